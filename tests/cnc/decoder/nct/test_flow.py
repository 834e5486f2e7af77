"""GOTO, IF, WHILE … DO … END in programs (manual lines 7435–7608)."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.decoder.dialects import load_program
from runtime.cnc.decoder.nct.decoder import NctDecoder
from runtime.cnc.decoder.nct.program import NctProgram
from runtime.cnc.language.errors import ProgramErrors
from runtime.cnc.language.nct.program_file import BlockText, Unit
from runtime.diagnostics.catalogue import language, nct
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.nct.macro_programs import SETUP, decode, values

spec = pytest.mark.spec


def trail(text: str) -> str:
    """The letters of the comments `(a)` … that a program has passed: each `mark` block notes its number in #100 as a digit."""
    value = values(text, 100)[0]
    return f"{value or 0:.0f}"


def mark(digit: int) -> str:
    return f"#100=#100*10+{digit}"


@spec("nct.flow.goto")
@pytest.mark.parametrize("jump", ["GOTO30", "GOTO 30", "GOTO#1", "GOTO[#1/3*3]", "GOTO[#1+0.4]"])
def test_forward_jumps(jump: str) -> None:
    assert trail(f"#1=30\n{mark(1)}\n{jump}\n{mark(2)}\nN30\n{mark(3)}") == "13"


@spec("nct.flow.goto")
def test_a_jump_backward_and_the_number_nearest_behind() -> None:
    text = f"N10 #1=#1+1\n{mark(1)}\nIF[#1 LT 3]GOTO10\nGOTO20\nN20\n{mark(2)}\nGOTO99\nN20\n{mark(3)}\nN99"
    assert trail(text) == "1112"


@spec("nct.flow.goto")
def test_only_a_number_at_the_beginning_of_a_block_counts() -> None:
    assert trail(f"GOTO5\n{mark(1)}\n(N5)\n/N5 {mark(2)}\n{mark(3)}") == "23"


@spec("nct.flow.goto")
def test_a_jump_stays_in_its_program() -> None:
    run = decode("O0001\nN1 M98 P2\nM30\nO0002\nGOTO1\nM99")
    assert run.place == (nct.NO_BLOCK, 5, 1)
    assert decode("O0001\nM98 P2\nN1 M30\nO0002\nGOTO1\nN1 M99").problem is None


@spec("nct.flow.goto", "nct.flow.if-then")
def test_a_condition_that_is_not_fulfilled_goes_on_with_the_next_block() -> None:
    assert trail(f"IF[1 EQ 2]GOTO9\n{mark(1)}\nIF[1 EQ 1]GOTO9\n{mark(2)}\nN9 {mark(3)}") == "13"


@spec("nct.flow.if-then")
@pytest.mark.parametrize("then", ["THEN", "THEN ", ""])
def test_if_then(then: str) -> None:
    assert trail(f"IF[2 GT 1]{then}{mark(1)}\nIF[2 LT 1]{then}{mark(2)}") == "1"
    run = decode(f"G90 G0\nIF[2 GT 1]{then}X1\nIF[2 LT 1]{then}X2\nM30")
    assert run.axis("X") == [1.0]


@spec("nct.flow.while-do")
def test_while_tests_before_each_pass() -> None:
    assert trail(f"#1=1\nWHILE[#1 LE 3]DO1\n{mark(1)}\n#1=#1+1\nEND1\n{mark(2)}") == "1112"
    assert trail(f"WHILE[1 EQ 2]DO2\n{mark(1)}\nEND2\n{mark(2)}") == "2"


@spec("nct.flow.while-do")
def test_three_loops_in_each_other_and_numbers_used_again() -> None:
    loop = "#{n}=0\nWHILE[#{n} LT 2]DO{n}\n#{n}=#{n}+1\n{body}\nEND{n}"
    inner = loop.format(n=3, body=mark(3))
    middle = loop.format(n=2, body=f"{mark(2)}\n{inner}")
    outer = loop.format(n=1, body=f"{mark(1)}\n{middle}")
    assert trail(outer) == "1233233" * 2
    assert trail(f"{inner}\n{inner}") == "3333"


@spec("nct.flow.while-do")
def test_a_loop_that_is_not_entered_passes_over_those_in_it() -> None:
    text = f"WHILE[1 EQ 2]DO1\nWHILE[1 EQ 2]DO2\n{mark(1)}\nEND2 (END1)\n{mark(2)}\nEND1\n{mark(3)}"
    assert trail(text) == "3"


@spec("nct.flow.while-do")
def test_a_jump_out_ends_the_loops_that_it_leaves() -> None:
    text = f"DO1\nDO2\n{mark(1)}\nGOTO5\nEND2\nN5 {mark(2)}\n#1=#1+1\nIF[#1 EQ 2]GOTO7\nEND1\nN7\nDO1\nGOTO8\nEND1\nN8"
    assert trail(text) == "1212"


@spec("nct.flow.while-do")
def test_a_loop_around_calls_whose_programs_have_loops() -> None:
    body = (
        "\n".join(f"#{n}0=0\nWHILE[#{n}0 LT 1]DO{n}\n#{n}0=1" for n in (1, 2, 3))
        + f"\n{mark(5)}\nEND3\nEND2\nEND1\nM99"
    )
    text = f"O0001\n#1=0\nWHILE[#1 LT 2]DO1\n#1=#1+1\nM98 P2\nG65 P2\nEND1\nM30\nO0002\n{body}"
    assert trail(text) == "5555"


ERRORS: list[tuple[str, ErrorEntry, int, int]] = [
    ("GOTO7", nct.NO_BLOCK, 1, 1),
    ("IF[1 EQ 1]GOTO7", nct.NO_BLOCK, 1, 1),
    ("GOTO#1", nct.NO_BLOCK, 1, 1),  # vacant
    ("DO4\nEND4", catalogue.LOOP_NUMBER, 1, 1),
    ("WHILE[1 EQ 1]DO0\nEND0", catalogue.LOOP_NUMBER, 1, 1),
    ("#1=1\nDO#1\nEND1", catalogue.LOOP_NUMBER, 2, 1),
    ("X1\nEND1\nDO1", catalogue.LOOP_MISSING, 2, 1),
    ("DO1\nDO1\nEND1", catalogue.LOOP_TWICE, 2, 1),
    ("WHILE[1 EQ 2]DO1\nX1", catalogue.LOOP_OPEN, 1, 1),
    ("WHILE[1 EQ 2]DO1\nX1\nEND2", catalogue.LOOP_OPEN, 1, 1),
    ("DO1\nDO2\nEND1\nEND2", catalogue.LOOP_OVERLAPS, 3, 1),
    ("GOTO5\nDO1\nN5 X1\nEND1", catalogue.JUMP_INTO_LOOP, 1, 1),
    ("#1=0\nWHILE[#1 LT 1]DO1\n#1=1\nN5 X1\nEND1\nGOTO5", catalogue.JUMP_INTO_LOOP, 6, 1),
    ("DO1\nGOTO5\nDO2\nN5 X1\nEND2\nEND1", catalogue.JUMP_INTO_LOOP, 2, 1),
]


@spec("nct.flow.goto", "nct.flow.while-do", "nct.flow.if-then")
@pytest.mark.parametrize(("text", "entry", "line", "column"), ERRORS, ids=[text for text, *_ in ERRORS])
def test_what_is_wrong(text: str, entry: ErrorEntry, line: int, column: int) -> None:
    assert decode(f"{text}\nM30").place == (entry, line, column)


@spec("nct.flow.goto", "nct.flow.while-do", "nct.flow.if-then")
@pytest.mark.parametrize(
    ("block", "entry"),
    [
        ("IF GOTO5", nct.OPERATION),
        ("WHILE DO1", nct.OPERATION),
        ("IF[#1 = 2]GOTO5", nct.MACRO_STATEMENT),
        ("IF[#1 EQ]GOTO5", nct.MACRO_STATEMENT),
        ("WHILE[#1]DO1", nct.MACRO_STATEMENT),
    ],
)
def test_conditions_that_are_none(block: str, entry: ErrorEntry) -> None:
    with pytest.raises(ProgramErrors) as raised:
        decode(f"{block}\nM30")
    assert raised.value.problem.entry is entry


def test_an_endless_loop_holds_nobody() -> None:
    assert decode("DO1\n#1=#1+1\nEND1\nM30").place[0] is language.ENDLESS_LOOP


def test_a_search_through_a_long_program_can_be_interrupted(tmp_path: Path) -> None:
    path = tmp_path / "long.nc"
    path.write_text("GOTO99999\n" + "X1\n" * 100_000 + "N99999 M30\n")
    program = load_program(path, SETUP, "nct")
    asked: list[int] = []

    def interrupted() -> bool:
        asked.append(1)
        return len(asked) == 3

    assert isinstance(program, NctProgram)
    decoder = NctDecoder(program, SETUP, start=np.zeros(3), interrupted=interrupted)
    assert list(decoder.blocks()) == []
    assert len(asked) == 3
    program.close()


def test_a_jump_that_is_executed_again_reads_nothing(monkeypatch: pytest.MonkeyPatch) -> None:
    read: list[int] = []
    blocks = Unit.blocks

    def counted(unit: Unit, offset: int, line: int) -> Iterator[BlockText]:
        for block in blocks(unit, offset, line):
            read.append(block.line)
            yield block

    text = "\n".join(["N10 #1=#1+1", *["(nothing)"] * 100, "IF[#1 LT 50]GOTO10", "M30"])
    monkeypatch.setattr(Unit, "blocks", counted)
    assert decode(text).problem is None
    assert read.count(1) <= 2  # looked through before the start, and by the first jump
