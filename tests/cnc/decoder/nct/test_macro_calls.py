"""Macro calls in programs: G65, G66, G66.1, G67 and the codes that call programs (manual lines 6059–6480)."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import Flush, Synch, Technology, TechnologyFunction
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.nct.macro_programs import Run, decode, values, with_parameters

spec = pytest.mark.spec


def functions(run: Run) -> list[str]:
    """The functions that were put out: M8, T5, S500."""
    return [
        f"{f.kind.name}{f.number or f.value:g}"
        for f in run.blocks
        if isinstance(f, TechnologyFunction) and f.kind in (Technology.M, Technology.T, Technology.S)
    ]


# ---------------------------------------------------------------------------------------------------- G65


@spec("nct.macro.simple-call-g65")
def test_arguments_arrive_in_local_variables() -> None:
    macro = "O1234\n#100=#1\n#101=#2\n#102=#24\n#103=#7\n#105=#26\nM99"
    text = f"O0001\n#1=77\nG65 P1234 A1.5 B-2 X3 I4 I7 Z#5\n#104=#1\nM30\n{macro}"
    assert values(text, 100, 101, 102, 103, 104, 105) == [1.5, -2.0, 3.0, 7.0, 77.0, None]


@spec("nct.macro.simple-call-g65")
def test_l_repeats_and_each_pass_begins_with_the_arguments() -> None:
    assert values("O0001\nG65 P2 A5 L3\nM30\nO0002\n#1=#1+1\n#100=#100+#1\nM99", 100) == [18.0]


@spec("nct.macro.simple-call-g65")
def test_in_the_block_of_a_call_addresses_only_pass_values() -> None:
    run = decode("O0001\nG90 G0 X1\nG65 P2 X50 M8 S9 F7 T3\nM30\nO0002\nG0 X[#24/10+#13+#19+#9+#20]\nM99")
    assert run.axis("X") == [1.0, 5 + 8 + 9 + 7 + 3]
    assert functions(run) == []


ERRORS: list[tuple[str, ErrorEntry, int]] = [
    ("G65 A2.12 B3.213 J36.9 J-12 E129.73 P2", catalogue.ARGUMENT_TWICE, 29),  # line 6156
    ("G65 P2 G1", catalogue.ARGUMENT_ADDRESS, 8),
    ("G65 P2 X1 X2", catalogue.ARGUMENT_TWICE, 11),
    ("G65 P2" + " K1" * 11, catalogue.TOO_MANY_ARGUMENTS, 38),
    ("G65 X1", nct.FAULTY_P, 1),
    ("G65 P0", nct.FAULTY_P, 5),
    ("G65 P1.5", nct.FAULTY_P, 5),
    ("G65 P2 L0", nct.FAULTY_L, 8),
    ("G65 P3", nct.NO_PROGRAM, 5),
    ("G66 P3", nct.NO_PROGRAM, 5),
    ("G66", nct.FAULTY_P, 1),
    ("G66.1 P2 X1 X2", catalogue.ARGUMENT_TWICE, 13),
]


@spec("nct.macro.simple-call-g65")
@pytest.mark.parametrize(("block", "entry", "column"), ERRORS, ids=[block for block, *_ in ERRORS])
def test_faulty_calls(block: str, entry: ErrorEntry, column: int) -> None:
    assert decode(f"O0001\n{block}\nM30\nO0002\nM99").place == (entry, 2, column)


# ---------------------------------------------------------------------------------------------------- levels


@spec("nct.macro.levels-and-differences")
def test_each_macro_level_has_its_variables_and_a_subprogram_those_of_its_caller() -> None:
    text = (
        "O0001\n#1=1\nG65 P2 A2\n#110=#1\nM30\n"
        "O0002\n#101=#1\nM98 P3\nG65 P4 A4\n#109=#1\nM99\n"
        "O0003\n#102=#1\n#1=3\nM99\n"
        "O0004\n#103=#1\n#1=9\nM99"
    )
    assert values(text, 101, 102, 103, 109, 110) == [2.0, 2.0, 4.0, 3.0, 1.0]


@spec("nct.macro.levels-and-differences")
def test_four_macros_in_each_other_and_no_fifth() -> None:
    programs = "\n".join(f"O{n:04d}\n#100={n}\nG65 P{n + 1}\nM99" for n in range(2, 7))
    run = decode(f"O0001\nG65 P2\nM30\n{programs}")
    assert run.problem is not None
    assert run.problem.entry is nct.LEVEL_EXCESS
    assert run.value(100) == 5.0  # the fourth macro
    assert decode(f"O0001\nG65 P3\nM30\n{programs.replace('G65 P7', '')}").problem is None


@spec("nct.macro.levels-and-differences")
def test_four_macros_and_four_subprograms() -> None:
    programs = "\n".join(f"O{n:04d}\n#100={n}\n{'M98' if n % 2 else 'G65'} P{n + 1}\nM99" for n in range(2, 11))
    run = decode(f"O0001\nM98 P2\nM30\n{programs}")
    assert run.problem is not None
    assert run.problem.entry is nct.LEVEL_EXCESS
    assert run.value(100) == 9.0  # four subprograms and four macros


@spec("nct.macro.levels-and-differences")
def test_a_subprogram_is_called_when_the_rest_of_the_block_is_done() -> None:
    assert decode("O0001\nG90 G0 X5 M98 P2\nM30\nO0002\nX7\nM99").axis("X") == [5.0, 7.0]


# ---------------------------------------------------------------------------------------------------- G66

NESTED = (  # lines 6453–6510, in the order of the levels
    "O0001\nN10 G66 P2\nN11 G1 G91 Z10 F100\nN12 G66 P3\nN13 Z20\nN14 G67\nN15 G67\nN16 Z-5\nM30\n"
    "O0002\nN20 X4\nN21 M99\n"
    "O0003\nN30 Z2\nN31 Z3\nN32 M99"
)


@spec("nct.macro.modal-call-g66")
def test_stacked_modal_calls() -> None:
    run = decode(NESTED)
    assert run.numbers == [11, 20, 13, 30, 20, 31, 20, 16]


@spec("nct.macro.modal-call-g66")
def test_the_drilling_of_the_manual() -> None:
    """Lines 6222–6250: X 100, then Y 30, drilled behind each motion; nothing behind blocks without motion."""
    text = (
        "O0001\nG90 G0 Z0\nG66 P1250 Z-100 R-1 X2 F130\nG91 G0 X100\nM8\nG4 P1\nY30\nG67\nX150\nM30\n"
        "O1250\nG0 Z#18\nG1 Z#26 F#9\nG4 P#24\nG0 Z-[#18+#26]\nM99"
    )
    hole = [(-1.0), (-101.0), 0.0]
    run = decode(text)
    assert run.problem is None
    assert run.axis("Z") == [0.0, 0.0, *hole, 0.0, *hole, 0.0]
    assert run.axis("X")[-1] == 250.0


@spec("nct.macro.modal-call-g66")
def test_l_of_a_modal_call_and_its_arguments_each_time() -> None:
    run = decode("O0001\nG66 P2 L2 A3\nG91 G0 X1\nX1\nG67\nX1\nM30\nO0002\n#1=#1+1\n#100=#100+#1\nM99")
    assert run.value(100) == 16.0


@spec("nct.macro.modal-call-g66")
def test_a_modal_call_holds_in_subprograms_and_beyond_them() -> None:
    text = "O0001\nM98 P3\nG91 G0 X1\nG67\nX1\nM30\nO0002\n#100=#100+1\nM99\nO0003\nG66 P2\nG91 G0 X1 M99"
    assert values(text, 100) == [2.0]


@spec("nct.macro.modal-call-g66")
def test_the_last_motion_of_the_macro_calls_nothing_again() -> None:
    assert decode("O0001\nG66 P2\nG91 G0 X1\nG67\nM30\nO0002\nG91 G0 Y1 M99").axis("Y") == [0.0, 1.0]


def test_g67_without_a_call_does_nothing() -> None:
    assert decode("G67\nM30").problem is None


# ---------------------------------------------------------------------------------------------------- G66.1


@spec("nct.macro.block-call-g66-1")
def test_every_block_is_a_list_of_arguments() -> None:
    text = (
        "O0001\nG66.1 P2 X1\n/N130 X12.3 Y32.6 N250\nX34.236 N320\nG3 M8 L4 P5\nN1240\n#1=4\nG67\nG0 G90 X9\nM30\n"
        "O0002\n#100=#100+1\n#[110+#100]=#24\n#[120+#100]=#14\n#[130+#100]=#10\n#[140+#100]=#13\n#[150+#100]=#12\n#[160+#100]=#16\nM99"
    )
    run = decode(text)
    assert run.problem is None
    assert run.value(100) == 4.0
    assert [run.value(n) for n in (111, 112, 113)] == [1.0, 12.3, 34.236]  # lines 6283–6292
    assert [run.value(n) for n in (122, 123)] == [250.0, 320.0]
    assert [run.value(n) for n in (134, 144, 154, 164)] == [3.0, 8.0, 4.0, 5.0]
    assert run.axis("X") == [9.0]
    assert functions(run) == []


@spec("nct.macro.block-call-g66-1")
def test_the_blocks_of_the_last_macro_feed_the_one_before() -> None:
    text = "O0001\nG66.1 P2\nG66.1 P3 A1\nX7\nG67\nG67\nM30\nO0002\n#100=#100*100+#24\nM99\nO0003\nX[10+#24]\nM99"
    # the block of the first call feeds nothing; that of the second feeds O0003, whose block feeds O0002
    assert values(text, 100) == [10.0 * 100 + 17.0]


@spec("nct.macro.block-call-g66-1")
@pytest.mark.parametrize(
    ("block", "entry", "column"),
    [("G1 G2", nct.ILLEGAL_G, 4), ("X1 N5 N6", catalogue.ARGUMENT_TWICE, 7)],
)
def test_faulty_blocks_of_arguments(block: str, entry: ErrorEntry, column: int) -> None:
    assert decode(f"O0001\nG66.1 P2\n{block}\nM30\nO0002\nM99").place == (entry, 3, column)


# ---------------------------------------------------------------------------------------------------- user codes


@spec("nct.macro.call-by-g-code")
def test_a_g_code_calls_a_macro() -> None:
    setup = with_parameters(g={9010: 120, 9011: 101.1})
    run = decode(
        "O0001\nG120 X5 P3 L2\nG101.1 X6\nM30\nO9010\n#100=#24\n#101=#16\n#102=#12\nM99\nO9011\n#103=#24\nM99", setup
    )
    assert [run.value(n) for n in (100, 101, 102, 103)] == [5.0, 3.0, 2.0, 6.0]


@spec("nct.macro.call-by-g-code")
def test_a_modal_g_code() -> None:
    text = "O0001\nG120 A2\nG91 G0 X1\nX1\nG67\nX1\nM30\nO9010\n#100=#100+#1\nM99"
    assert decode(text, with_parameters(g={9010: -120})).value(100) == 4.0
    text = "O0001\nG120 A2\nX3\nG67\nM30\nO9010\n#100=#100*10+#1+#24\nM99"
    assert decode(text, with_parameters(g={9010: -120}, modgequ=True)).value(100) == 23.0


@spec("nct.macro.call-by-g-code")
def test_a_standard_code_acts_as_ever_in_its_own_macro_and_another_is_an_error() -> None:
    run = decode("O0001\nG90\nG1 X5 F100\nM30\nO9010\nG1 X[#24*2] F#9\nM99", with_parameters(g={9010: 1}))
    assert run.axis("X") == [10.0]
    run = decode("O0001\nG120\nM30\nO9010\nG120\nM99", with_parameters(g={9010: 120}))
    assert run.place == (nct.ILLEGAL_G, 5, 1)


@spec("nct.macro.call-by-g-code", "nct.macro.call-by-m-code")
@pytest.mark.parametrize(("nested", "put_out"), [(False, ["M50"]), (True, [])])
def test_other_codes_within_a_called_macro(nested: bool, put_out: list[str]) -> None:
    setup = with_parameters(g={9010: 120}, m={9020: 50}, fgmac=nested)
    run = decode("O0001\nG120\nM30\nO9010\nM50\nM99\nO9020\n#100=#100+1\nM99", setup)
    assert functions(run) == put_out
    assert run.value(100) == (1.0 if nested else None)


@spec("nct.macro.call-by-m-code")
def test_an_m_code_calls_a_macro() -> None:
    setup = with_parameters(m={9020: 50})
    run = decode("O0001\n/N7 M50 X5 G3 L2 P6\nM30\nO9020\n#100=#24\n#101=#10\n#102=#12\n#103=#16\nM50\nM99", setup)
    assert run.problem is None
    assert [run.value(n) for n in (100, 101, 102, 103)] == [5.0, 3.0, 2.0, 6.0]
    assert functions(run) == ["M50"]  # the one in the macro


@spec("nct.macro.call-by-m-code")
@pytest.mark.parametrize(
    ("block", "entry", "column"),
    [("X1 M50", catalogue.CODE_NOT_FIRST, 4), ("M50 M8", catalogue.ARGUMENT_ADDRESS, 5)],
)
def test_an_m_code_that_calls_stands_first_and_alone(block: str, entry: ErrorEntry, column: int) -> None:
    assert decode(f"O0001\n{block}\nM30\nO9020\nM99", with_parameters(m={9020: 50})).place == (entry, 2, column)


@spec("nct.macro.subprogram-by-m-code")
def test_an_m_code_calls_a_subprogram_behind_the_rest_of_its_block() -> None:
    setup = with_parameters(m={9000: 50})
    run = decode("O0001\n#1=4\nG90 G0 X5 M8 M50\nM30\nO9000\nX[#1+2]\nM50\nM99", setup)
    assert run.axis("X") == [5.0, 6.0]
    assert functions(run) == ["M8", "M50"]


@spec("nct.macro.subprogram-by-t-s")
def test_t_and_s_call_subprograms() -> None:
    setup = with_parameters(t9034=True, s9033=True)
    run = decode(
        "O0001\nG90 G0 X5 T7\nS300\nM30\nO9034\nX#199 T[#199+1]\nM99\nO9033\n#100=#198\nS[#198*2] M3\nM99", setup
    )
    assert run.problem is None
    assert run.axis("X") == [5.0, 7.0]
    assert functions(run) == ["T8", "S3"]
    assert run.value(100) == 300.0
    assert run.decoder.modal.speed == 600.0


@spec("nct.macro.subprogram-by-a-b-c")
def test_auxiliary_addresses_call_subprograms() -> None:
    base = {"miscel": {"A": 20, "B": 21, "C": 22}}
    setup = replace(with_parameters(**base, a9030=True, c9032=True), h_synch={21: Synch.MOS, 22: Synch.MOS})
    run = decode("O0001\nG90 G0 X5 A7 B3 C8\nM30\nO9030\nX[#195+#197]\nM99\nO9032\nX#197 C9\nM99", setup)
    assert run.problem is None
    assert run.axis("X") == [5.0, 15.0, 8.0]  # A runs before C
    put_out = [(f.number, f.value) for f in run.blocks if isinstance(f, TechnologyFunction)]
    assert put_out == [(21, 3.0), (22, 9.0)]  # B calls nothing, C within its own subprogram neither
    axis = replace(with_parameters(b9031=True), axes=("X", "Y", "Z", "B"), linear=(True, True, True, False))
    assert decode("G90 G0 B30\nM30", axis, start=(0.0,) * 4).ends == [(0.0, 0.0, 0.0, 30.0)]


@spec("nct.macro.subprogram-by-t-s", "nct.macro.subprogram-by-m-code")
@pytest.mark.parametrize("nested", [False, True])
def test_other_codes_within_a_called_subprogram(nested: bool) -> None:
    setup = with_parameters(t9034=True, m={9000: 50}, fgmac=nested)
    run = decode("O0001\nT7\nM30\nO9034\nM50\nM99\nO9000\n#100=1\nM99", setup)
    assert functions(run) == ([] if nested else ["M50"])
    assert run.value(100) == (1.0 if nested else None)


# ---------------------------------------------------------------------------------------------------- order in time

IN_TIME = (
    "N10 #100=50\nN20 #101=100\nN30 G1 X#100 Y#101 F100\nN40 #100=60\nN50 #101=120\nN60 G1 X#100 Y#101"  # line 7803
)


@spec("nct.macro.nc-and-macro-blocks")
@pytest.mark.parametrize(("sbstm", "waits"), [(True, []), (False, [4])])
def test_macro_blocks_wait_for_the_motion_before_them_or_do_not(sbstm: bool, waits: list[int]) -> None:
    run = decode(f"{IN_TIME}\nM30", with_parameters(sbstm=sbstm))
    assert run.problem is None
    assert run.ends == [(50.0, 100.0, 0.0), (60.0, 120.0, 0.0)]
    assert [block.source.line for block in run.blocks if isinstance(block, Flush)] == waits


@spec("nct.macro.nc-and-macro-blocks")
@pytest.mark.parametrize(
    ("block", "macro"),
    [
        ("#1=2", True), ("IF[1 EQ 2]GOTO9", True), ("GOTO9", True), ("WHILE[1 EQ 2]DO1\nEND1", True), ("G65 P2", True),
        ("G66 P2", True), ("G67", True), ("G120 X5", True), ("M50", True),
        ("X[#1+2]", False), ("M8", False), ("M98 P2", False), ("G4 P1", False),
    ],
)  # fmt: skip
def test_which_blocks_are_macro_blocks(block: str, macro: bool) -> None:
    setup = with_parameters(sbstm=False, g={9010: 120}, m={9020: 50})
    run = decode(f"O0001\nG0 X1\n{block}\nN9 M30\nO0002\nM99\nO9010\nM99\nO9020\nM99", setup)
    assert run.problem is None
    assert [out.source.line for out in run.blocks if isinstance(out, Flush)] == ([3] if macro else [])
