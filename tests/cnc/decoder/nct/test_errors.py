"""Every error of the NCT dialect: the right id at the right place."""

from __future__ import annotations

import re
from pathlib import Path

import pytest
from pydantic import ValidationError

from runtime.cnc.decoder.nct.registry import G_CODES, GCall
from runtime.cnc.language.errors import LineError
from runtime.config import load_machine
from runtime.config.consistency import inconsistencies
from runtime.config.contradictions import ContradictionError
from runtime.config.loader import DEMO_MACHINE
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct as C  # noqa: N812
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.nct.programs import decode, found

# text, entry, line, column
CASES: list[tuple[str, ErrorEntry, int, int]] = [
    ("G12.1\n", C.NOT_SUPPORTED, 1, 1),
    ("X1\nPOPEN1\n", C.NOT_SUPPORTED, 2, 1),
    ("G90 G27\n", C.ILLEGAL_G, 1, 5),
    ("G1.5\n", C.ILLEGAL_G, 1, 1),
    ("G0 G1 X1\n", C.G_GROUP_TWICE, 1, 4),
    ("G17 G17\n", C.G_GROUP_TWICE, 1, 5),
    ("X100000\n", C.VALUE_EXCESS, 1, 1),
    ("M1000\n", C.VALUE_EXCESS, 1, 1),
    ("S100000\n", C.VALUE_EXCESS, 1, 1),
    ("G1 X0 F250001\n", C.VALUE_EXCESS, 1, 7),
    ("Y1 O12\n", C.ADDRESS_UNKNOWN, 1, 4),
    ("M-3\n", C.ADDRESS_RIGHT, 1, 1),
    ("M3.5\n", C.ADDRESS_RIGHT, 1, 1),
    ("JI5\n", C.ADDRESS_RIGHT, 1, 1),
    ("G0 U5\n", C.AXIS_MISSING, 1, 4),
    ("G0 X1 Y2 X3\n", C.WORD_TWICE, 1, 10),
    ("G0 X1 Q5\n", C.WORD_WITHOUT_MEANING, 1, 7),
    ("G1 X1 ? Y2\n", C.SYNTAX, 1, 7),
    ("G1 X Y2\n", C.VALUE_MISSING, 1, 6),
    ("G1 X1 (open\n", C.COMMENT_OPEN, 1, 7),
    ("G1 X1 )\n", C.COMMENT_CLOSE, 1, 7),
    ("G1 X1 \xe4\n", C.CHARACTER, 1, 7),
    ("/0 X1\n", C.SKIP_NUMBER, 1, 2),
    ("N100000 X1\n", C.BLOCK_NUMBER, 1, 2),
    ("G0 X[[[[[[1]]]]]]\n", C.MACRO_STATEMENT, 1, 1),
    ("G0 X[1+]\n", C.MACRO_STATEMENT, 1, 8),
    ("IF GOTO 1\n", C.OPERATION, 1, 4),
    ("X#1.5\n", C.VARIABLE_NUMBER_TEXT, 1, 3),
    ("%O12(A)\nX1\n", C.PROGRAM_NUMBER, 1, 2),
    ("O0000\nX1\n", C.PROGRAM_NUMBER, 1, 1),
    ("O0001 (MORE THAN SIXTEEN)\nX1\n", C.PROGRAM_NAME, 1, 7),
    ("O0001 X1\nX1\n", C.PROGRAM_NAME, 1, 7),
    ("O0001\nM98 P2\nM30\nO0003\nX1\nO0003\nX1\n", C.PROGRAM_TWICE, 6, 0),
    ("%\n\n", C.PROGRAM_MISSING, 0, 0),
    ("G2 X10 Y0 F100\n", C.CIRCLE, 1, 1),
    ("G18 G2 X10 Z0 J5 F100\n", C.CIRCLE, 1, 15),
    ("G2 X10 Y0 I5 R5 F100\n", C.CIRCLE, 1, 14),
    ("G2 X10 Y0 I6 F100\n", C.RADIUS_DIFFERENCE, 1, 4),
    ("G2 R6 F100\n", C.CIRCLE_RADIUS, 1, 4),
    ("M7 M8\n", C.CONFLICTING_M, 1, 4),
    ("G94 F100\nG31\n", C.G31_FORMAT, 2, 1),
    ("G94 F100\nG31 X1 P4\n", C.G31_FORMAT, 2, 8),
    ("G94 F100\nG31 X1\n", C.G31_FORMAT, 2, 5),  # the axis has no probe
    ("F100\nG16 G31 X1\n", C.G31_STATE, 2, 5),
    ("M6 M11 M3 M8 M20 M0\n", C.TOO_MANY_M, 1, 18),
    ("M98 P1000\n", C.LEVEL_EXCESS, 1, 5),
    ("G0 X1\nM99 P7\n", C.NO_BLOCK, 2, 5),
    ("G0 X1\nGOTO 3\n", C.NO_BLOCK, 2, 1),
    ("M98\n", C.FAULTY_P, 1, 1),
    ("M98 P10000\n", C.FAULTY_P, 1, 5),
    ("G4 P-1\n", C.FAULTY_P, 1, 4),
    ("M98 P7 L0\n", C.FAULTY_L, 1, 8),
    ("M98 P7\n", C.NO_PROGRAM, 1, 5),
]


@pytest.mark.parametrize(("text", "entry", "line", "column"), CASES)
def test_errors(text: str, entry: ErrorEntry, line: int, column: int) -> None:
    assert found(text) == (entry, line, column)


def test_codes_of_the_start_that_exclude_each_other() -> None:
    with pytest.raises(ValidationError) as caught:
        NctParameters(codes=("G90", "G00", "G91"))
    (error,) = caught.value.errors()
    cause = error["ctx"]["error"]
    assert isinstance(cause, ContradictionError)
    assert [found.entry for found in cause.contradictions] == [C.START_CODES]


def test_a_skip_signal_that_is_no_input() -> None:
    demo = load_machine(DEMO_MACHINE)
    channel = demo.channels[0].model_copy(update={"nct": NctParameters(skip=("no such",))})
    machine = demo.model_copy(update={"channels": (channel,)})
    (wrong,) = inconsistencies(machine)
    assert wrong.entry is C.SKIP_INPUT
    assert wrong.location == ("channels", 0, "nct", "skip", 0)


def test_nothing_moves_before_a_faulty_program_is_told() -> None:
    run = decode("G0 X1\nX2\nX3?\n")
    assert run.problem is not None
    assert run.problem.place.line == 3
    assert run.blocks == []


def test_what_is_jumped_over_is_only_looked_at_when_it_is_reached() -> None:
    run = decode("G0 X1\nM99 P9\nX3?\nN9 X2\nM30\n")
    assert run.problem is None
    assert [end[0] for end in run.ends] == [1.0, 2.0]


def test_no_other_plane_while_the_radius_is_compensated() -> None:
    x = decode("M30\n").decoder.execution
    x.modal.compensation_side = 1
    with pytest.raises(LineError) as caught:
        G_CODES[180].handler(x, GCall(180, 3))
    assert (caught.value.entry, caught.value.column) == (C.PLANE_COMPENSATED, 3)


def test_every_entry_of_the_catalogue_has_a_test() -> None:
    tested = {entry for _, entry, _, _ in CASES}
    source = "".join(path.read_text() for path in Path(__file__).parents[2].rglob("test_*.py"))
    names = {name for name, value in vars(C).items() if isinstance(value, ErrorEntry)}
    missing = {name for name in names if getattr(C, name) not in tested and not re.search(rf"\bC\.{name}\b", source)}
    assert not missing
