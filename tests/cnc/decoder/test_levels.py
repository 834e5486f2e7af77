"""Program levels: calls by name, variable, macro and function, returns, the programs at start and end, what survives."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import BlockEnd, Line, Polyline, Synch, TechnologyFunction
from runtime.cnc.decoder import ChannelMemory, Decoder, DecoderSetup, ProgramError, load_program
from runtime.cnc.path_preparation.element_lengths import element_ends
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import tools
from runtime.hli.layout import Mode
from tests.cnc.decoder.programs import SETUP, Run, decode


def xs(text: str, setup: DecoderSetup = SETUP, files: Mapping[str, str] | None = None) -> list[float]:
    """X of all motions of a program that has no error."""
    run = decode(text, setup, files)
    assert run.problem is None, run.problem
    return [end[0] for end in run.ends]


def problem_of(text: str, setup: DecoderSetup = SETUP, files: Mapping[str, str] | None = None) -> object:
    run = decode(text, setup, files)
    return run.problem and run.problem.entry


def warned(run: Run) -> list[object]:
    return [warning.entry for warning in run.decoder.warnings]


@dataclass(frozen=True)
class External:
    path: str
    offset: int = 0
    dims: tuple[int, ...] = ()
    strides: tuple[int, ...] = ()
    kind: str = "STRING"
    size: int = 84
    access: str = "rw"
    synchronous: bool = False


# -- names ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.sub.call-by-variable")
def test_an_external_variable_names_the_program() -> None:
    setup = replace(SETUP, external=(External("V.E.NAME"), External("V.E.LIST[]", 100, (3,), (84,))))
    text = (
        '%L POCKET\nG00 X1\nM17\n%M\nV.E.NAME = "POCKET"\nLL V.E.NAME\nV.E.LIST[2] = "sub.nc"\n'
        "L V.E.LIST[2]\nLV.E.LIST[1 + 1]\nM30"
    )
    assert xs(text, setup, {"sub.nc": "G00 X2\nM17"}) == [1, 2, 2]
    assert problem_of('V.E.NAME = "NOWHERE"\nLL V.E.NAME\nM30', setup) is C.LOCAL_MISSING
    run = decode('V.E.NAME = "nowhere.nc"\nL V.E.NAME\nM30', setup)
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (C.GLOBAL_MISSING, 2)


@pytest.mark.spec("isg.sub.call-by-macro")
def test_a_macro_names_the_program_and_an_unknown_one_is_the_name_itself() -> None:
    text = '%L POCKET_1\nG00 X1\nM17\n%M\n"P 1" = "POCKET_1"\n"G" = "sub.nc"\nLL "P 1"\nL "G"\nL"G"\nLL "POCKET_1"\nM30'
    assert xs(text, files={"sub.nc": "G00 X2\nM17"}) == [1, 2, 2, 1]
    assert problem_of('"A" = "NOWHERE"\nLL "A"\nM30') is C.LOCAL_MISSING


@pytest.mark.spec("isg.lex.character-set")
@pytest.mark.parametrize("name", ["a b.nc", "a;b.nc", "a#.nc", "a,b.nc", "a$.nc"])
def test_separators_are_not_allowed_in_names(name: str, tmp_path: Path) -> None:
    (tmp_path / name).write_text("M30")
    with pytest.raises(ProgramError) as caught:
        load_program(tmp_path / name, SETUP)
    assert caught.value.problem.entry is C.NAME_CHARACTER
    assert problem_of(f'#FILE NAME [M6="{name}"]\nM30') is C.NAME_CHARACTER
    with pytest.raises(ProgramError):
        decode("%MAIN X\nM30")


@pytest.mark.spec("isg.lex.character-set")
def test_separators_that_nobody_sees_are_blanks() -> None:
    assert [end[:2] for end in decode(b"G00\tX1\x03Y2\r\nX[2]\x1a\n\nM30\r\n").ends] == [[1, 2], [2, 2]]


def test_names_have_a_greatest_length() -> None:
    assert problem_of(f'#FILE NAME [M6="{"a" * 84}"]\nM30') is C.NAME_LENGTH


@pytest.mark.spec("isg.sub.global-call")
def test_search_paths_come_in_their_order_behind_the_folder_of_the_main_program() -> None:
    setup = replace(SETUP, program_paths=(Path("first"), Path("second")))
    files = {
        "second/a.nc": "G00 X9",
        "first/a.nc": "G00 X[V.G.PATH_NR]",
        "second/b.nc": "G00 X[V.G.PATH_NR]",
        "c.nc": "G00 X[V.G.PATH_NR]",
    }
    assert xs("L a.nc\nL b.nc\nL c.nc\nM30", setup, files) == [2, 3, 1]


# -- calls by functions --------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.mh.m06-tool-change-program", "chan.sub.m6")
def test_m6_calls_the_configured_program_as_last_action_and_is_no_function_then() -> None:
    setup = replace(SETUP, tool_change_program="change.nc")
    run = decode("M6 G00 X1\nX3\nM30", setup, {"change.nc": "G00 X2\nM17"})
    assert [end[0] for end in run.ends] == [1, 2, 3]
    assert not [block for block in run.blocks if isinstance(block, TechnologyFunction)]
    assert [row["number"] for row in decode("M6\nM30").rows if row["type"] == "m"] == [6]
    assert problem_of("M6\nM30", setup) is C.GLOBAL_MISSING


@pytest.mark.spec("isg.g.implicit-subroutines-g80", "chan.sub.g8xx", "chan.sub.m6")
def test_file_names_are_changed_at_any_time_and_hold_until_the_end() -> None:
    files = {f"{name}.nc": f"G00 X{value}\nM17" for value, name in enumerate(("a", "b", "c", "d"), 1)}
    setup = replace(SETUP, tool_change_program="a.nc", g_programs={80: "b.nc", 839: "c.nc"}, tool_data_program="d.nc")
    assert xs("M6\nG80\nG839\nD0\nM30", setup, files) == [1, 2, 3, 4]
    text = '#FILE NAME [M6="d.nc" G80 "c.nc", G839="a.nc" D=b.nc]\nM6\nG80\nG839\nD0\n#FILE NAME [G80="a.nc"]\nG80\nM30'
    assert xs(text, setup, files) == [4, 3, 1, 2, 1]
    assert xs("M6\nM30", setup, files) == [1]


def test_d0_calls_the_program_of_d_as_last_action_and_tool_data_that_are_not_there_are_refused() -> None:
    files = {"d.nc": "G00 X2\nM17", "e.nc": "G00 X3\nM17"}
    setup = replace(SETUP, tool_data_program="d.nc")
    assert xs('D0 G00 X1\n#FILE NAME [D="e.nc"]\nD=0\nX4\nM30', setup, files) == [1, 2, 3, 4]
    assert xs("D0 G00 X1\nM30", files=files) == [1]  # no program named
    run = decode("G00 X5\nD1\nM30", setup, files)
    assert [end[0] for end in run.ends] == [5]
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (tools.TOOL_MISSING, 2)
    assert problem_of("D0 M6\nM30", replace(setup, tool_change_program="e.nc"), files) is C.CALL_BESIDE


@pytest.mark.spec("isg.g.implicit-subroutines-g80")
def test_g_calls_give_values_as_transfer_parameters() -> None:
    cycle = "P1 = @P1 P2 = @P2 P4 = @P4 P10 = V.G.@P[3].VALID P11 = V.G.@P[4].VALID P12 = V.G.CYCLE_ACTIVE\nG91\nM17"
    setup = replace(SETUP, g_programs={85: "c.nc"})
    run = decode("G00 X1 G85[10, 2 * 3,, -4]\nX3\nG85[5, @P1, @P2, @P2 + 1]\nX5\nM30", setup, {"c.nc": cycle})
    assert [end[0] for end in run.ends] == [1, 3, 5]  # G91 of the cycle does not stay
    assert run.parameters == {1: 5, 2: 5, 4: 6, 10: 1, 11: 1, 12: 1}
    run = decode("G85[10, 2 * 3,, -4]\nM30", setup, {"c.nc": cycle})
    assert run.parameters == {1: 10, 2: 6, 4: -4, 10: 0, 11: 1, 12: 1}


@pytest.mark.spec("isg.g.implicit-subroutines-g80", "chan.sub.g8xx")
def test_g_calls_without_values_are_subprograms() -> None:
    setup = replace(SETUP, g_programs={80: "c.nc"})
    assert xs("G00 X1\nG80\nX1\nM30", setup, {"c.nc": "G91\nP1 = V.G.CYCLE_ACTIVE\nM17"}) == [1, 2]
    assert problem_of("G80\nM30", setup, {"c.nc": "P1 = @P1"}) is C.TRANSFER_OUTSIDE


@pytest.mark.spec("isg.g.implicit-subroutines-g80", "chan.sub.g8xx")
def test_g_calls_that_cannot_be() -> None:
    setup = replace(SETUP, g_programs={80: "c.nc"})
    run = decode("G81\nM30")
    assert run.problem is not None
    assert run.problem.entry.id == 20131
    assert problem_of(f"G80[{','.join('1' * 51)}]\nM30", setup, {"c.nc": ""}) is C.VALUES_MANY
    assert problem_of('G80["a"]\nM30', setup, {"c.nc": "M17"}) is C.STRING_NOT_ALLOWED
    assert problem_of("%L A\nM17\n%M\nLL A M30") is C.CALL_BESIDE
    assert problem_of("M6 G80\nM30", replace(setup, tool_change_program="c.nc"), {"c.nc": "M17"}) is C.CALL_BESIDE


# -- start and end -------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.sub.implicit-start", "chan.sub.start")
def test_every_start_begins_with_the_configured_program() -> None:
    setup = replace(SETUP, start_program="start.nc")
    files = {"start.nc": "%L A\nG00 X1\nM17\n%S\nLL A\nG91 P1 = V.G.PROG_LEVEL V.P.A = 7\nM17"}
    run = decode("X1\nX[V.P.A]\nM30", setup, files)
    assert [end[0] for end in run.ends] == [1, 2, 9]
    assert run.parameters == {1: 2}
    assert problem_of("M30", setup) is C.GLOBAL_MISSING


@pytest.mark.spec("isg.sub.implicit-end", "isg.mh.m02-m30-program-end", "chan.sub.end")
@pytest.mark.parametrize("end", ["M30", "M02", "LL B", ""])
def test_every_end_comes_behind_the_configured_program(end: str) -> None:
    setup = replace(SETUP, final_program="end.nc", m_synch={**SETUP.m_synch, 30: Synch.MOS, 2: Synch.MOS})
    run = decode(f"%L B\nX2 M30\n%M\nG00 X1\n{end}\nX9\nM30", setup, {"end.nc": "G00 X5\nM10\nM17\nX9"})
    xs_before = {"LL B": [1, 2], "": [1, 9]}.get(end, [1])
    assert [e[0] for e in run.ends] == [*xs_before, 5]
    kinds = [(row["type"], row.get("number")) for row in run.rows if row["type"] in ("m", "stop")]
    number = 2 if end == "M02" else 30
    assert kinds == [("m", 10), ("m", number), ("stop", None)]


@pytest.mark.spec("chan.sub.start", "chan.sub.end")
@pytest.mark.parametrize(
    ("words", "modes"),
    [
        ("AUTOMATIC", {Mode.AUTOMATIC}),
        ("MDI", {Mode.MDI, Mode.MANUAL}),
        ("AUTOMATIC | MDI", {Mode.AUTOMATIC, Mode.MDI, Mode.MANUAL}),
    ],
)
def test_the_programs_at_start_and_end_run_in_the_modes_that_are_chosen(words: str, modes: set[Mode]) -> None:
    both = replace(SETUP, start_program="start.nc", final_program="end.nc")
    files = {"start.nc": "G00 X1\nM17", "end.nc": "G00 X2\nM17"}
    chosen = frozenset(word.strip() for word in words.split("|"))
    for mode in (Mode.AUTOMATIC, Mode.MDI, Mode.MANUAL, Mode.HOMING):
        first = [1.0] if mode in modes else []
        last = [2.0] if mode in modes else []
        assert xs("G00 X5", replace(both, start_in=chosen).in_mode(mode), files)[: len(first) + 1] == [*first, 5.0]
        assert xs("G00 X5\nM30", replace(both, final_in=chosen).in_mode(mode), files)[-len(last) - 1 :] == [5.0, *last]


@pytest.mark.spec("chan.sub.m6", "chan.sub.g8xx")
def test_the_next_start_calls_the_configured_programs_again(tmp_path: Path) -> None:
    for name, x in (("a.nc", 1), ("b.nc", 2), ("c.nc", 3)):
        (tmp_path / name).write_text(f"G00 X{x}\nM17")
    setup = replace(SETUP, tool_change_program="a.nc", g_programs={81: "b.nc"}, program_paths=(tmp_path,))
    memory = ChannelMemory(setup)
    ends = []
    for text in ('#FILE NAME [M6="c.nc" G81="c.nc"]\nM6\nG81\nM30', "M6\nG81\nM30"):
        (tmp_path / "main.nc").write_text(text)
        decoder = Decoder(load_program(tmp_path / "main.nc", setup), setup, start=np.zeros(3), memory=memory)
        motions = [block for block in decoder.blocks() if isinstance(block, Line | Polyline)]
        ends.append([float(end[0]) for motion in motions for end in element_ends(motion)])
    assert ends == [[3.0, 3.0], [1.0, 2.0]]


def test_faulty_configured_programs_are_errors_of_the_program() -> None:
    for name, limit, entry in (("a b", 50, C.NAME_CHARACTER), ("a", 50, C.GLOBAL_MISSING), ("sub.nc", 1, C.CALL_DEPTH)):
        for where in ("start_program", "final_program"):
            setup = replace(SETUP, limits=replace(SETUP.limits, levels=limit), **{where: name})  # type: ignore[arg-type]
            for text in ("G00 X1\nM30", "G00 X1"):
                assert problem_of(text, setup, {"sub.nc": "M17"}) is entry


@pytest.mark.spec("isg.mh.m02-m30-program-end")
def test_what_survives_the_end_of_a_program(tmp_path: Path) -> None:
    text = (
        '"HALF" = "0.5"\nV.S.KEPT = EXIST[V.S.KEPT] + 1\nP20 = V.S.KEPT P21 = EXIST["HALF"] P22 = EXIST[P5]\n'
        'P23 = EXIST[V.P.A] P24 = EXIST[V.L.A] V.P.A = 1 V.L.A = 1 P5 = 1\nG91 G54 G00 X10\n#FILE NAME [G80="a.nc"]\nM30'
    )
    first = '"FIRST" = "1"\nM30'
    asks = 'P1 = EXIST["FIRST"]\nX[1]\nG80\nM30'
    for keep in (False, True):
        setup = replace(SETUP, keep_parameters=keep)
        memory = ChannelMemory(setup)
        runs = []
        for program in (first, text, text, asks):
            path = tmp_path / "a.nc"
            path.write_text(program.replace("X[1]", "G00 X[1]"))
            decoder = Decoder(load_program(path, setup), setup, start=np.zeros(3), memory=memory)
            try:
                list(decoder.blocks())
            except ProgramError as error:
                assert error.problem.entry is C.CALL_FILE  # noqa: PT017 - the file name is forgotten
            runs.append((decoder.parameters, list(decoder.position)))
        assert runs[1][0][20] == 1
        assert runs[2][0][20] == 2  # V.S stays
        assert runs[2][0][22] == float(keep)
        assert (runs[2][0][23], runs[2][0][24]) == (0, 0)
        assert runs[3][0][1] == 1  # macros stay
        assert runs[3][1] == [1, 0, 0]  # G53, G90 and G01 are there again


# -- returns -------------------------------------------------------------------------------------------------------

NESTED = "%L C\nX3\n{}\nX93\nM17\n%L B\nX2\nLL C\nX92\nN400 [IN_B] X22\nM17\n%L A\nX1\nLL B\nX91\nN300: X11\nM17\n%M\nG00\n{}"


@pytest.mark.spec("isg.mh.m17-parametrised-return", "isg.mh.m17-m29-subprogram-end")
@pytest.mark.parametrize(
    ("back", "expected"),
    [
        ("M17", [92, 22, 91, 11, 90, 30]),
        ("M29 []", [92, 22, 91, 11, 90, 30]),
        ("M17 [MAIN]", [90, 30]),
        ("M17[JUMPS=2]", [91, 11, 90, 30]),
        ("M17 [JUMPS 2 N300]", [11, 90, 30]),
        ("M17 [JUMPS = P9 + 1 N[100 * 3]]", [11, 90, 30]),
        ("M29 [N400]", [22, 91, 11, 90, 30]),
        ("M17 [[in_b]]", [22, 91, 11, 90, 30]),
        ("M17 [MAIN [END]]", [30]),
        ("M17 [MAIN N500]", [30]),
        ("M17 [JUMPS=3 [END] ]", [30]),
    ],
)
def test_returns(back: str, expected: list[float]) -> None:
    main = "P9 = 1\nLL A\nX90\nN500 [END] X30\nM30"
    assert xs(NESTED.format(back, main)) == [1, 2, 3, *expected]


@pytest.mark.spec("isg.mh.m17-parametrised-return")
def test_a_block_number_is_searched_forward_and_a_label_in_both_directions() -> None:
    loop = "%L A\nX2\n$IF P1 > 1\nM17\n$ENDIF\nM17 [{}]\n%M\nG00 P1 = 0\n{} X1 P1 = P1 + 1\nLL A\nX3\nM30"
    assert xs(loop.format("N10", "N10:")) == [1, 2, 1, 2, 3]
    assert xs(loop.format("[BACK]", "[BACK]")) == [1, 2, 1, 2, 3]
    assert problem_of(loop.format("N10", "N10")) is C.LABEL_MISSING
    assert xs("%L A\nM17 [N3]\n%M\nG00 F1\nLL A\nN1 X1\nN2 X2\nN3 X3\nX4\nM30") == [3, 4]


@pytest.mark.spec("isg.mh.m17-parametrised-return")
def test_returns_that_cannot_be() -> None:
    run = decode(NESTED.format("M17 [JUMPS=9]", "LL A\nX30\nM30"))
    assert [end[0] for end in run.ends] == [1, 2, 3, 30]
    assert warned(run) == [C.JUMPS_MANY]
    assert problem_of(NESTED.format("M17 [JUMPS=0]", "LL A\nM30")) is C.JUMPS_INVALID
    assert problem_of(NESTED.format("M17 [N999]", "LL A\nM30")) is C.LABEL_MISSING
    assert problem_of(NESTED.format("M17 [N300]", "LL A\nM30")) is C.LABEL_MISSING  # of another level
    assert problem_of("%L A\nM17 [[IN]]\n%M\nLL A\n$WHILE 1\n[IN] X[1]\n$ENDWHILE\nM30") is C.JUMP_INTO_LOOP
    with pytest.raises(ProgramError) as caught:
        decode("%L A\nM17 [BACK]\n%M\nM30")
    assert (caught.value.problem.entry, caught.value.problem.place.column) == (C.RETURN_TARGET, 6)


# -- variables -----------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.var.g-program-info")
def test_programs_know_their_names() -> None:
    sub = "P11 = V.G.PROG_NR P12 = V.G.MAIN_PROG_NR P13 = V.G.PROG_LEVEL\nV.P.F = V.G.FILE_NAME\nV.P.N = V.G.PROG_NAME"
    text = (
        f"%L 77\n{sub}\nV.P.M = V.G.MAIN_FILE_NAME\nM17\n%4711 \nP1 = V.G.PROG_LEVEL P2 = V.G.PROG_NR\nLL 77\n"
        'P3 = V.P.F == "test.nc" P4 = V.P.N == "77" P5 = V.P.M == "test.nc"\nL lib/sub.nc\n'
        'P6 = V.P.F == "sub.nc" P7 = V.P.N == "SUB" P8 = V.G.MAIN_PROG_NAME == "4711"\nP9 = V.G.FILE_OFFSET\nM30'
    )
    run = decode(text, files={"lib/sub.nc": f"%SUB\n{sub}\nM17"})
    assert run.problem is None, run.problem
    told = {2: 4711, 9: text.index("P9 ="), 11: 0, 12: 4711, 13: 2}
    assert run.parameters == told | dict.fromkeys((1, 3, 4, 5, 6, 7, 8), 1)


@pytest.mark.spec("isg.sub.cycle-display", "isg.mh.m06-tool-change-program")
def test_hidden_cycles_show_only_their_call_and_are_one_step() -> None:
    files = {"c.nc": "G00 X2\nX3\nM10\nLL_IN = 0\nM17".replace("LL_IN = 0", "L d.nc"), "d.nc": "G00 X[4] Y1\nM17"}
    text = "N1 G00 X1\nN2 M6\nN3 L CYCLE [NAME=d.nc]\nX5\nM30"
    shown = replace(SETUP, tool_change_program="c.nc")
    assert [row["line"] for row in decode(text, shown, files).rows if row["type"] != "stop"] == [1, 1, 2, 3, 1, 1, 4]
    run = decode(text, replace(shown, hide_cycles=True), files)
    assert [(row["line"], row["n"]) for row in run.rows if row["type"] != "stop"] == (
        [(1, 1), (2, 2), (2, 2), (2, 2), (2, 2), (3, 3), (4, None)]
    )
    assert [block.source.line for block in run.blocks if isinstance(block, BlockEnd)] == [2, 3]
