"""Variables and formulas in programs (manual lines 6567–6720, 7260–7434)."""

from __future__ import annotations

import pytest

from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.decoder.nct import execution
from runtime.cnc.decoder.nct.registry import SystemVariable
from runtime.cnc.language.errors import ProgramErrors
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.nct.macro_programs import SETUP, decode, values, with_parameters

spec = pytest.mark.spec


@spec("nct.expr.arithmetic")
@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("7+2*3", 13.0),
        ("[7+2]*3", 27.0),
        ("-2+5", 3.0),
        ("7-2-1", 4.0),
        ("12/3/2", 2.0),
        ("27 MOD 4", 3.0),  # line 7322
        ("2*-3", -6.0),
        ("#1*#2", 20.0),  # with #1=4, #2=5
        ("#[#1-3]", 4.0),  # #1
        ("-#1", -4.0),
    ],
)
def test_arithmetic(formula: str, value: float) -> None:
    assert values(f"#1=4\n#2=5\n#100={formula}", 100) == [value]


@spec("nct.expr.precedence-brackets")
@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("10+2*COS60", 11.0),  # function, then *, then + (line 7397)
        ("SIN30+SIN[20+10]", 1.0),
        ("COS[[[#1-4]*5+10]*6]", 0.5),  # 60 degrees
        ("8 OR 4 AND 6", 12.0),  # AND before OR
        ("1 XOR 3*2", 7.0),
        ("FIX-6.7", -6.0),
        ("FUP-7.3", -8.0),
        ("[[[[[1]]]]]", 1.0),
    ],
)
def test_precedence(formula: str, value: float) -> None:
    assert values(f"#1=4\n#100={formula}", 100) == [pytest.approx(value)]


@spec("nct.expr.precedence-brackets")
def test_five_levels_of_brackets_are_all_there_are() -> None:
    with pytest.raises(ProgramErrors) as raised:
        decode("#100=[[[[[[1]]]]]]\nM30")
    assert raised.value.problem.entry is nct.MACRO_STATEMENT
    assert raised.value.problem.place.line == 1


@spec("nct.expr.functions", "nct.expr.bitwise")
@pytest.mark.parametrize(
    ("formula", "value"),
    [
        ("SQRT[3*3+4*4]", 5.0),
        ("TAN45", 1.0),
        ("ASIN1", 90.0),
        ("ACOS-1", 180.0),
        ("ATAN-1", -45.0),
        ("EXP0", 1.0),
        ("LN[EXP2]", 2.0),
        ("ABS-3", 3.0),
        ("BCD19", 25.0),
        ("BIN25", 19.0),
        ("FIX4.8", 4.0),
        ("FUP12.1", 13.0),
        ("NOT0", -1.0),
        ("12 AND 10", 8.0),
        ("12 OR 10", 14.0),
        ("12 XOR 10", 6.0),
    ],
)
def test_functions(formula: str, value: float) -> None:
    assert values(f"#100={formula}", 100) == [pytest.approx(value)]


ERRORS: list[tuple[str, ErrorEntry, int]] = [
    ("#100=1/#1", catalogue.DIVISION_BY_ZERO, 7),
    ("#100=5 MOD 0", catalogue.DIVISION_BY_ZERO, 8),
    ("#100=1 AND 4294967296", catalogue.BITS, 8),
    ("#100=NOT4294967296", catalogue.BITS, 6),
    ("#100=SQRT-1", catalogue.DOMAIN, 6),
    ("#100=LN0", catalogue.DOMAIN, 6),
    ("#100=TAN90", catalogue.DOMAIN, 6),
    ("#100=ASIN2", catalogue.DOMAIN, 6),
    ("#100=EXP1000", catalogue.RESULT_RANGE, 6),
    ("#100=BCD-5", catalogue.DECIMAL_CODE, 6),
    ("#100=#40", catalogue.VARIABLE_UNKNOWN, 6),
    ("#40=1", catalogue.VARIABLE_UNKNOWN, 1),
    ("#100=#[1.5]", catalogue.VARIABLE_NUMBER, 1),
    ("#0=1", catalogue.VARIABLE_READ_ONLY, 1),
    ("#535=1", catalogue.VARIABLE_PROTECTED, 1),
]


@spec("nct.expr.arithmetic", "nct.expr.functions", "nct.expr.bitwise", "nct.var.local-and-common")
@pytest.mark.parametrize(("block", "entry", "column"), ERRORS, ids=[block for block, _, _ in ERRORS])
def test_what_has_no_value(block: str, entry: ErrorEntry, column: int) -> None:
    run = decode(f"G0 X1\n{block}\nX2\nM30", with_parameters(wrprot1=530, wrprot2=540))
    assert run.place == (entry, 2, column)
    assert run.axis("X") == [1.0]  # what came before stays


@spec("nct.expr.comparison", "nct.var.vacant")
@pytest.mark.parametrize(
    ("condition", "holds"),
    [
        ("1 EQ 1", True), ("1 EQ 2", False), ("1 NE 2", True), ("2 GT 1", True), ("1 GT 1", False), ("1 LT 2", True),
        ("1 GE 1", True), ("1 LE 0", False), ("1+1 EQ 4/2", True),
        # a vacant left side, then 0 (lines 6664–6688)
        ("#1 EQ #0", True), ("#1 NE 0", True), ("#1 GE #0", True), ("#1 GT 0", True),
        ("#2 EQ #0", False), ("#2 NE 0", False), ("#2 GE #0", False), ("#2 GT 0", False),
    ],
)  # fmt: skip
def test_comparisons(condition: str, holds: bool) -> None:
    assert values(f"#2=0\nIF[{condition}]#100=1", 100) == [1.0 if holds else None]


@spec("nct.var.vacant")
def test_a_vacant_variable_is_copied_and_counts_as_zero() -> None:
    assert values("#100=7\n#100=#1\n#101=#1*3\n#102=#1+#1", 100, 101, 102) == [None, 0.0, 0.0]


@spec("nct.var.vacant")
def test_a_word_with_a_vacant_value_is_not_there() -> None:
    run = decode("G90 G0 X20 Y#1\n#1=0\nG0 X30 Y#1\nG0 X#0 Z4\nM30", start=(1.0, 5.0, 0.0))
    assert run.ends == [(20.0, 5.0, 0.0), (30.0, 0.0, 0.0), (30.0, 0.0, 4.0)]


@spec("nct.var.reference")
def test_variables_behind_addresses() -> None:
    run = decode("#102=1.0\n#24=3\n#1=4\nG#102 G90 X5 Y[#1+5] F100\nXI-#24\nX-#24\nX[2*#24]\nM30")
    assert run.ends == [(5.0, 9.0, 0.0), (2.0, 9.0, 0.0), (-3.0, 9.0, 0.0), (6.0, 9.0, 0.0)]


@spec("nct.var.reference")
def test_a_value_is_rounded_to_what_the_address_holds() -> None:
    run = decode("#1=19.6\nM#1\n#1=20.23\nM#1\nM30")  # M20 twice: lines 6610–6615
    assert [row.number for row in run.blocks if hasattr(row, "number")] == [20, 20]


@spec("nct.var.reference")
def test_a_value_beyond_its_address_is_an_error() -> None:
    assert decode("#112=5630\nM#112\nM30").place == (nct.VALUE_EXCESS, 2, 1)  # line 6604


@spec("nct.var.reference")
@pytest.mark.parametrize("block", ["##120=1", "X##1", "N#1 X5", "/#1 X5"])
def test_where_no_variable_may_stand(block: str) -> None:
    try:
        problem = decode(f"{block}\nM30").problem
    except ProgramErrors as error:  # told before the start
        problem = error.problem
    assert problem is not None
    assert problem.place.line == 1
    if block[0] == "N":
        assert problem.entry is catalogue.NUMBER_FIRST


def test_a_system_variable_has_to_be_known_and_readable(monkeypatch: pytest.MonkeyPatch) -> None:
    assert decode("#100=#2999\nM30").place == (catalogue.VARIABLE_UNKNOWN, 1, 6)
    written: list[float | None] = []
    only_written = SystemVariable(2999, 2999, (), "", None, lambda x, number, value: written.append(value))
    monkeypatch.setattr(execution, "find_variable", {2999: only_written}.get)
    assert decode("#2999=5\nX#2999\nM30").place == (catalogue.VARIABLE_WRITE_ONLY, 2, 2)
    assert written == [5.0]


@spec("nct.var.local-and-common")
def test_common_variables_outlive_a_program_and_local_ones_do_not() -> None:
    memory = ChannelMemory(SETUP)
    decode("#1=1\n#100=2\n#500=3\nM30", memory=memory)
    run = decode("#110=#1\n#111=#100\n#112=#500\nM30", memory=memory)
    assert [run.value(n) for n in (110, 111, 112)] == [None, 2.0, 3.0]
    assert memory.common.retained() == {500: 3.0}
