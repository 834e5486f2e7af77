"""Program structure, control statements, calls, skipping and parameters."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Stop, StopKind
from runtime.cnc.decoder import Decoder, ProgramError, load_program
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from tests.cnc.decoder.programs import SETUP, decode


def xs(text: str, **options: object) -> list[float]:
    """X of all motions."""
    run = decode(text, **options)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return [end[0] for end in run.ends]


# -- structure -----------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.program-structure", "isg.sub.file-structure")
def test_execution_starts_at_the_main_program() -> None:
    assert xs("(head)\n%L A\nG00 X1\nM17\n%MAIN (name)\nG00 X2\nLL A\nX3\nM30\nX4\n") == [2, 1, 3]


@pytest.mark.spec("isg.lex.program-structure", "isg.mh.m02-m30-program-end")
@pytest.mark.parametrize("end", ["M30", "M02", "M2", "N99 M030", ""])
def test_the_end_of_the_program_is_one_stop(end: str) -> None:
    run = decode(f"G00 X1\n{end}")
    stops = [block for block in run.blocks if isinstance(block, Stop)]
    assert [stop.kind for stop in stops] == [StopKind.PROGRAM_END]
    assert run.blocks[-1] is stops[0]


def test_a_program_may_lack_its_name() -> None:
    assert xs("% \nG00 X1\nM30") == [1]


@pytest.mark.spec("isg.sub.local-call", "isg.mh.m17-m29-subprogram-end")
@pytest.mark.parametrize("end", ["M17\n", "M29\n", "M17\nX9\n", ""])
def test_a_local_subprogram_ends_with_m17_m29_or_the_next_program(end: str) -> None:
    assert xs(f"%L A\nG00 X1\n{end}%L B\nG00 X2\nM17\n%M\nLL A\nLL B\nG00 X3\nM30") == [1, 2, 3]


@pytest.mark.spec("isg.sub.global-call")
def test_global_subprograms_have_their_own_local_ones() -> None:
    files = {
        "sub.nc": "%L A\nG00 X20\nM17\n%SUB\nG00 X10\nLL A\nM17\nX99\n",
        "P4712": "G00 X30\n",
        "lib/deep.nc": "G00 X40\nM29\n",
    }
    text = "%L A\nG00 X1\nM17\n%M\nLL A\nL sub.nc\nL4712\nL P4712\nL lib/deep.nc\nLL A\nM30"
    files["4712"] = files["P4712"]
    assert xs(text, files=files) == [1, 10, 20, 30, 30, 40, 1]


@pytest.mark.spec("isg.mh.m02-m30-program-end", "isg.sub.local-call")
def test_m30_in_a_subprogram_ends_the_program_with_a_warning() -> None:
    run = decode("%L A\nG00 X1\nM30\nM17\n%M\nLL A\nX2\nM30")
    assert [end[0] for end in run.ends] == [1]
    assert [warning.entry for warning in run.decoder.warnings] == [C.END_IN_SUBPROGRAM]


def test_the_call_is_the_last_action_of_its_block() -> None:
    assert xs("%L A\nX2\nM17\n%M\nLL A G00 X1\nX3\nM30") == [1, 2, 3]


def test_levels_are_counted_and_given_back() -> None:
    deep = "".join(f"%L S{i}\nLL S{i + 1}\nM17\n" for i in range(47)) + "%L S47\nG00 X1\nM17\n"
    text = f"{deep}%M\n$FOR P1 = 1, 3, 1\nLL S0\n$ENDFOR\nM30"
    assert xs(text) == [1, 1, 1]


# -- comments, numbers, skipping -----------------------------------------------------------------------------------


@pytest.mark.spec("isg.lex.comments")
def test_comments() -> None:
    text = "G00 (a) X1 (b (nested) c) Y2\nX2 (open end\nX3 ; X4 ( \n;X5\n(X6) ; x\n X7 (X8 (X9))\nM30"
    assert [end[:2] for end in decode(text).ends] == [[1, 2], [2, 2], [3, 2], [7, 2]]


@pytest.mark.spec("isg.flow.block-number", "isg.lex.block-structure")
def test_block_numbers_are_rounded_expressions() -> None:
    text = "N10 G00 X1\nP1 = 3\nN[P1 * 10 + 0.5] X[2]\nNP1 X[3]\nX[4]\nM30"
    assert [(row["line"], row["n"]) for row in decode(text).rows if row["type"] == "line"] == [
        (1, 10),
        (3, 31),
        (4, 3),
        (5, None),
    ]


@pytest.mark.spec("isg.lex.block-skip", "isg.lex.block-skip-levels")
def test_skip_levels() -> None:
    text = "G00 X1\n/ X2\n/1 X3\n/2 N40 X4\n/10 X5\nX6\nM30"
    assert xs(text) == [1, 2, 3, 4, 5, 6]
    assert xs(text, skip=1) == [1, 4, 5, 6]
    assert xs(text, skip=2) == [1, 2, 3, 5, 6]
    assert xs(text, skip=1 << 9) == [1, 2, 3, 4, 6]
    assert xs(text, skip=0b1000000011) == [1, 6]


@pytest.mark.spec("isg.lex.block-skip-levels")
def test_skip_levels_act_while_the_program_runs() -> None:
    mask = iter([0, 1, 1, 0])
    assert xs("G00 X1\n/ X[2]\n/ X[3]\n/ X[4]\n/ X[5]\nM30", skip=lambda: next(mask)) == [1, 2, 5]


def test_a_skipped_loop_head_does_not_hang() -> None:
    assert xs("G00 X0\n/ $WHILE 1\nX[1]\n$ENDWHILE\n/ $FOR P1 = 1, 2, 1\nX[2]\n$ENDFOR\nM30", skip=1) == [0, 1, 2]


@pytest.mark.parametrize("end", ["\n", "\r\n", "\n\n", " \t\r\n"])
def test_line_ends(end: str) -> None:
    run = decode(end.join(["G00 X1", "X[2]", "M10", "X3", "M30"]))
    assert [end[0] for end in run.ends] == [1, 2, 3]


def test_a_byte_order_mark_is_no_text() -> None:
    assert [end[0] for end in decode(b"\xef\xbb\xbf%M\nG00 X1\nM30").ends] == [1]


# -- control statements --------------------------------------------------------------------------------------------

BRANCHES = "$IF P1 == 1\nX[1]\n$ELSEIF P1 == 2\nX[2]\n$ELSEIF P1 == 3\nX[3]\n$ELSE\nX[4]\n$ENDIF\nX[5]\nM30"


@pytest.mark.spec("isg.flow.if")
@pytest.mark.parametrize(("value", "expected"), [(1, 1), (2, 2), (3, 3), (7, 4)])
def test_the_first_true_branch_is_executed(value: int, expected: int) -> None:
    assert xs(f"G00 P1 = {value}\n{BRANCHES}") == [expected, 5]


@pytest.mark.spec("isg.flow.if", "isg.lex.comparison-truth")
@pytest.mark.parametrize(
    ("condition", "true"),
    [("0.5", True), ("0.49", False), ("-0.5", True), ("-0.49", False), ("TRUE", True), ("FALSE", False), ("7", True)],
)
def test_conditions_are_true_from_one_half_on(condition: str, true: bool) -> None:
    assert xs(f"G00\n$IF {condition}\nX1\n$ENDIF\nM30") == ([1] if true else [])
    assert xs(f"G00 P1 = 0\n$WHILE [{condition}] * [P1 < 2]\nP1 = P1 + 1\nX[P1]\n$ENDWHILE\nM30") == (
        [1, 2] if true else []
    )


@pytest.mark.spec("isg.flow.for")
@pytest.mark.parametrize(
    ("head", "passes", "last"),
    [
        ("1, 3, 1", [1, 2, 3], 4),
        ("1, 4, 2", [1, 3], 5),
        ("3, 1, -1", [3, 2, 1], 0),
        ("3, 1, 1", [], 3),
        ("1, 3, -1", [], 1),
        ("2, 2, 1", [2], 3),
    ],
)
def test_counting_loops(head: str, passes: list[float], last: float) -> None:
    run = decode(f"G00\nN1 $FOR P1 = {head}\nX[P1]\n$ENDFOR\nM30")
    assert [end[0] for end in run.ends] == passes
    assert run.parameters[1] == last


@pytest.mark.spec("isg.flow.for")
def test_the_bounds_of_a_loop_are_computed_once() -> None:
    assert xs("G00 P2 = 2\n$FOR P1 = 1, P2, 1\nX[P1] P2 = 9\n$ENDFOR\nM30") == [1, 2]


@pytest.mark.spec("isg.flow.for")
def test_step_zero_is_endless_with_one_warning() -> None:
    run = decode("$FOR P1 = 1, 2, 0\n$ENDFOR\nM30", idle_limit=1000)
    assert run.problem is not None
    assert run.problem.entry is C.ENDLESS_LOOP
    assert [warning.entry for warning in run.decoder.warnings] == [C.STEP_ZERO]


def test_the_counter_may_be_computed() -> None:
    run = decode("G00 P1 = 5\n$FOR P[P1 + 1] = 1, 2, 1\nX[P6]\n$ENDFOR\nM30")
    assert [end[0] for end in run.ends] == [1, 2]


@pytest.mark.spec("isg.flow.while")
def test_a_loop_without_motion_can_be_interrupted(tmp_path: Path) -> None:
    asked = []

    def interrupted() -> bool:
        asked.append(1)
        return len(asked) >= 3

    path = tmp_path / "a.nc"
    path.write_text("$WHILE 1\nP1 = 1\n$ENDWHILE\nM30")
    decoder = Decoder(load_program(path, SETUP), SETUP, start=np.zeros(3), interrupted=interrupted)
    assert list(decoder.blocks()) == []
    assert len(asked) == 3


def test_recursion_ends_with_an_error_and_no_python_recursion() -> None:
    run = decode("%L A\nG00 X[1]\nLL A\nM17\n%M\nLL A\nM30")
    assert run.problem is not None
    assert run.problem.entry is C.CALL_DEPTH
    assert len(run.ends) == 49  # the main program is level 1 of 50


# A program as nested statements, its text, and what a small interpreter makes of it.
Statement = tuple[object, ...]


def statements(depth: int) -> st.SearchStrategy[list[Statement]]:
    plain = st.tuples(st.just("x"), st.integers(0, 9))
    count = st.tuples(st.just("add"), st.integers(1, 3), st.integers(1, 4))
    if depth == 0:
        return st.lists(st.one_of(plain, count), max_size=3)
    inner = statements(depth - 1)
    condition = st.tuples(st.integers(1, 3), st.sampled_from(["<", ">=", "==", "!="]), st.integers(0, 6))
    branch = st.tuples(st.just("if"), st.lists(st.tuples(condition, inner), min_size=1, max_size=3), st.none() | inner)
    loop = st.tuples(st.just("for"), st.integers(0, 3), st.integers(-1, 3), st.sampled_from([1, 2, -1]), inner)
    until = st.tuples(st.just("while"), st.integers(0, 3), inner)
    return st.lists(st.one_of(plain, count, branch, loop, until), max_size=4)


def write(program: list[Statement], level: int = 0) -> list[str]:
    lines: list[str] = []
    for statement in program:
        match statement:
            case ("x", value):
                lines.append(f"X{value}" if value % 2 else f"X[{value}]")  # type: ignore[operator]
            case ("add", parameter, value):
                lines.append(f"P{parameter} = P{parameter} + {value}")
            case ("if", branches, otherwise):
                for i, ((parameter, operator, value), inner) in enumerate(branches):  # type: ignore[var-annotated, arg-type]
                    lines.append(f"{'$ELSEIF' if i else '$IF'} P{parameter} {operator} {value}")
                    lines += write(inner, level + 1)
                if otherwise is not None:
                    lines += ["$ELSE", *write(otherwise, level + 1)]  # type: ignore[arg-type]
                lines.append("$ENDIF")
            case ("for", start, end, step, inner):
                lines += [f"$FOR P{10 + level} = {start}, {end}, {step}", *write(inner, level + 1), "$ENDFOR"]  # type: ignore[arg-type]
            case ("while", count, inner):
                counter = f"P{20 + level}"
                lines += [f"{counter} = 0", f"$WHILE {counter} < {count}", f"{counter} = {counter} + 1"]
                lines += [*write(inner, level + 1), "$ENDWHILE"]  # type: ignore[arg-type]
    return lines


def interpret(program: list[Statement], p: dict[int, int], out: list[int]) -> None:
    compare = {"<": int.__lt__, ">=": int.__ge__, "==": int.__eq__, "!=": int.__ne__}
    for statement in program:
        match statement:
            case ("x", int(value)):
                out.append(value)
            case ("add", int(parameter), int(value)):
                p[parameter] += value
            case ("if", list(branches), otherwise):
                for (parameter, operator, value), inner in branches:
                    if compare[operator](p[parameter], value):
                        interpret(inner, p, out)
                        break
                else:
                    if isinstance(otherwise, list):
                        interpret(otherwise, p, out)
            case ("for", int(start), int(end), int(step), list(inner)):
                while start <= end if step > 0 else start >= end:
                    interpret(inner, p, out)
                    start += step
            case ("while", int(count), list(inner)):
                for _ in range(count):
                    interpret(inner, p, out)


@pytest.mark.spec("isg.flow.if", "isg.flow.for", "isg.flow.while", "isg.flow.control-block-rules")
@given(statements(2))
def test_nested_flow_equals_a_small_interpreter(program: list[Statement]) -> None:
    expected: list[int] = []
    parameters = {1: 0, 2: 0, 3: 0}
    interpret(program, parameters, expected)
    run = decode("\n".join(["G00 P1 = 0 P2 = 0 P3 = 0", *write(program), "M30"]), idle_limit=None)
    assert run.problem is None
    assert [end[0] for end in run.ends] == expected
    assert {number: run.parameters[number] for number in parameters} == parameters


# -- parameters ----------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.param.scalar", "isg.param.coordinates")
def test_parameters_stand_for_numbers() -> None:
    text = "P1 = 2 P2 = 3\nG00 XP1 Y P2 Z[P1 + P2]\nXP1*SIN[P2*30] Y=-P1 Z P1 ** P2\nM30"
    run = decode(text)
    assert run.ends == [[2, 3, 5], [2, -2, 8]]
    assert run.parameters == {1: 2, 2: 3}


@pytest.mark.spec("isg.param.indirect", "isg.param.scalar")
def test_indirect_parameters() -> None:
    run = decode("P1 = 20 P2 = 40\nPP1 = 50\nPP2 = PP1 + 1\nP3 = 1\nPPP3 = 7\nP[P1 + 5] = 8\nP[30.4] = 9\nM30")
    assert run.parameters == {1: 20, 2: 40, 20: 7, 40: 51, 3: 1, 25: 8, 30: 9}


def test_exist_asks_without_creating() -> None:
    text = "P1 = EXIST[P5] P2 = EXIST[M10] P3 = EXIST[M77] P4 = EXIST[H20] P6 = EXIST[P1]\nM30"
    assert decode(text).parameters == {1: 0, 2: 1, 3: 0, 4: 1, 6: 1}


def test_parameters_begin_anew_with_each_program() -> None:
    assert decode("P1 = 1\nM30").parameters == {1: 1}
    assert decode("M30").parameters == {}


def test_an_error_in_a_branch_that_is_not_taken_is_found_too() -> None:
    """Stricter than the manual (line 8264), which ignores other words there: nothing may move in a faulty program."""
    with pytest.raises(ProgramError):
        decode("$IF 0\nX Y\n$ENDIF\nM30")
