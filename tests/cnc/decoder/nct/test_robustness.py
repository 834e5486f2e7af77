"""Whatever stands in a program, the decoder gives blocks or an error with a place, and comes to an end."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.language.errors import ProgramError, ProgramErrors
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import Problem
from tests.cnc.decoder.nct.macro_programs import decode, with_parameters

CODES = (
    "G0 G1 G2 G65 G66 G66.1 G67 G73 G74 G76 G80 G81 G83 G84 G87 G88 G90 G91 G98 G99 G17 G18 G120 G10 G43 G54 G52 G68"
)
FUNCTIONS = "M3 M4 M5 M8 M30 M50 M98 M99 S500 T7 H1 D1"
PLAIN = "X1 Y-2 Z5 ZI-5 R3 R-1 Q1 Q0 E2 P1 P2 P9 L0 L2 L3 F100 I1 J-1 K2 N5 N9 A5 ,C1 (A) / [ ] = -"
VARIABLES = "#1=#1+1 #2=#1*#1 #[#1]=3 #100=1/#2 #500=#500+1 X#1 X[#1+1] G#1 M#2 P#1 SQRT[#1]"
SYSTEM = "#3000=1 #3006=(A) #3004=3 #5221=1 #10001=5 #1=#5041 #1=#4001"
FLOW = "GOTO5 GOTO9 IF[#1LT3]GOTO5 IF[#1EQ#0]#1=1 IF[#1GT2]THEN WHILE[#1LT3]DO1 DO2 END1 END2"
WORDS = " ".join((CODES, FUNCTIONS, PLAIN, VARIABLES, SYSTEM, FLOW)).split()
block = st.lists(st.sampled_from(WORDS), min_size=1, max_size=5).map(" ".join)
program = st.lists(block, min_size=1, max_size=12).map("\n".join)
SETUP = with_parameters(g={9010: 120}, m={9000: 50}, orient1=True)


def problem_of(text: str) -> Problem | None:
    try:
        return decode(text, SETUP, idle_limit=2000, most=5000).problem
    except ProgramError as error:
        return error.problem


@settings(max_examples=150, deadline=None)
@given(program, program)
def test_only_errors_with_a_place(main: str, called: str) -> None:
    problem = problem_of(f"O0001\n{main}\nM30\nO0002\n{called}\nM99\nO9010\n{called}\nM99\nO9000\nM99")
    assert problem is None or (problem.place.line > 0 and problem.text)


@pytest.mark.parametrize("formula", ["{n}", "FIX[{n}]", "-{n}+1", "[{n} AND 1]", "BIN{n}", "1.{n}"])
def test_numbers_of_hundreds_of_digits(formula: str) -> None:
    with pytest.raises(ProgramErrors) as raised:
        decode(f"#100={formula.format(n='9' * 400)}\nM30")
    assert raised.value.problem.entry is catalogue.NUMBER_LONG
