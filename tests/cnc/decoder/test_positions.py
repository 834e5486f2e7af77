"""#GET and #CHANNEL INIT: the positions of the machine for variables and for the decoder."""

from __future__ import annotations

import itertools
from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import Floats, Flush, FlushKind
from runtime.cnc.decoder import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import SETUP, Run, decode
from tests.cnc.decoder.scripted_outside import Machine

_INIT = "isg.g.channel-init-cmdpos-actpos"
_GET = "isg.g.get-cmdpos-actpos"


class Standing(Machine):
    """A machine that stands where a test says."""

    def __init__(self, command: tuple[float, ...], actual: tuple[float, ...]) -> None:
        super().__init__()
        self.command, self.actual = np.array(command), np.array(actual)

    def command_position(self) -> Floats | None:
        return self.command

    def actual_position(self) -> Floats | None:
        return self.actual


NUMBERED = replace(SETUP, log_axes=(4, 5, 9))


def at(text: str, command: tuple[float, ...] = (10.0, 20.0, 30.0), start: tuple[float, ...] = (0.0, 0.0, 0.0)) -> Run:
    """The program on a machine whose axes lag by 0.01, 0.02 and 0.03 mm."""
    actual = tuple(c - 0.01 * (i + 1) for i, c in enumerate(command))
    run = decode(text, NUMBERED, start=start, outside=Standing(command, actual))
    assert run.problem is None, run.problem
    return run


def refused(text: str) -> ErrorEntry | None:
    try:
        run = decode(text, NUMBERED)
    except ProgramError as error:
        return error.problem.entry
    return run.problem.entry if run.problem else None


# -- #GET


@pytest.mark.spec(_GET)
@pytest.mark.parametrize("name", ["GET CMDPOS", "SET IPO SOLLPOS"])
def test_command_positions_go_into_parameters_and_variables(name: str) -> None:
    run = at(
        f"#VAR\nV.L.ARRAY[2] = [0, 0]\n#ENDVAR\nP9 = 1\n"
        f"#{name} [P1 = X, V.P.POS=Y, V.S.S=Z, V.L.ARRAY[P9]=X, P[P9+1]=Y]\nP3=V.L.ARRAY[1]"
    )
    assert run.parameters == {1: 10, 2: 20, 3: 10, 9: 1}
    assert run.value("POS") == 20
    assert run.decoder.execution.memory.static.read("S") == 30


@pytest.mark.spec(_GET)
def test_actual_positions_are_those_that_are_measured() -> None:
    assert at("#GET ACTPOS [P1=X, P2=Y, P3=Z]").parameters == pytest.approx({1: 9.99, 2: 19.98, 3: 29.97})


@pytest.mark.spec(_GET)
@pytest.mark.parametrize("name", ["CMDPOS", "ACTPOS"])
def test_the_answer_is_that_of_the_place_on_the_path_and_nothing_of_the_channel_changes(name: str) -> None:
    run = at(f"G01 X1 F100\nN20 #GET {name} [P1=X]\nP2=V.A.ABS.X\nG91 X1")
    flush = run.blocks[1]
    assert isinstance(flush, Flush)
    assert (flush.kind, flush.source.line) == (FlushKind.WAIT, 2)
    assert run.parameters[2] == 1
    assert [end[0] for end in run.ends] == [1, 2]


@pytest.mark.spec(_GET)
def test_positions_are_told_with_all_offsets_and_in_the_unit_that_is_selected() -> None:
    assert at("G54\nG70\n#GET CMDPOS [P1=X]", (25.4, 0.0, 0.0)).parameters == pytest.approx({1: 1})
    assert at("G54\nG70\n#GET ACTPOS [P1=X]", (25.41, 0.0, 0.0)).parameters == pytest.approx({1: 1})


@pytest.mark.spec(_GET)
@pytest.mark.parametrize("name", ["CMDPOS", "ACTPOS"])
def test_without_a_machine_the_decoded_position_is_meant(name: str) -> None:
    run = decode(f"G01 X5 Y6 F100\n#GET {name} [P1=X, P2=Y]", start=(0.0, 0.0, 0.0))
    assert run.parameters == {1: 5, 2: 6}


@pytest.mark.spec(_GET)
@pytest.mark.parametrize(
    ("arguments", "entry"),
    [
        ("[P1]", catalogue.STATEMENT_ARGUMENTS),
        ("[P1=Q]", catalogue.AXIS_UNKNOWN),
        ("[P1=S]", catalogue.AXIS_UNKNOWN),
        ("[V.G.NP_AKT.V.X=X]", catalogue.STATEMENT_ARGUMENTS),
        ("[V.A.ABS.X=X]", catalogue.VARIABLE_READ_ONLY),
    ],
)
def test_what_is_refused(arguments: str, entry: ErrorEntry) -> None:
    assert refused(f"#GET CMDPOS {arguments}") is entry


# -- #CHANNEL INIT

ABS = "\nP1=V.A.ABS.X P2=V.A.ABS.Y P3=V.A.ABS.Z"
STANDS = (10.0, 20.0, 30.0)


def way(run: Run) -> list[tuple[list[float], list[float]]]:
    """Start and end of every motion."""
    found = []
    for row in run.rows:
        begin, end = row.get("from"), row.get("to")
        if isinstance(begin, dict) and isinstance(end, dict):
            found.append((list(begin.values()), list(end.values())))
    return found


@pytest.mark.spec(_INIT)
@pytest.mark.parametrize(
    ("statement", "expected"),
    [
        ("#CHANNEL INIT [CMDPOS]", (10, 20, 30)),
        ("#SET DEC LR SOLL", (10, 20, 30)),
        ("#CHANNEL INIT [CMDPOS AX=Y]", (0, 20, 0)),
        ("#CHANNEL INIT [CMDPOS AX=X AXNR=9]", (10, 0, 30)),
        ("#CHANNEL INIT [ACTPOS]", (9.99, 19.98, 29.97)),
        ("#CHANNEL INIT [ACTPOS AX=Y]", (10, 19.98, 30)),
        ("#CHANNEL INIT [ACTPOS, AXNR=4, AX=Z]", (9.99, 20, 29.97)),
    ],
)
def test_positions_are_taken_over_by_the_decoder(statement: str, expected: tuple[float, ...]) -> None:
    run = at(statement + ABS)
    assert isinstance(run.blocks[0], Flush)
    assert tuple(run.parameters.values()) == pytest.approx(expected)


@pytest.mark.spec(_INIT)
def test_the_position_is_that_without_offsets_and_offsets_stay_selected() -> None:
    run = at("G54\n#CHANNEL INIT [CMDPOS]\nP1=V.A.ABS.X P2=V.A.PROG.X\nG00 X1")
    assert run.parameters == {1: 10, 2: -90}
    assert way(run) == [([10, 20, 30], [101, 20, 30])]


@pytest.mark.spec(_INIT)
@pytest.mark.parametrize(
    ("motion", "end"),
    [
        ("G01 X50 F100", [50, 19.98, 29.97]),  # an axis without a word goes to where it was measured
        ("G00 X50 Y20 Z30", [50, 20, 30]),
        ("G91 G01 X1 Y1 Z1 F100", [10.99, 20.98, 30.97]),
        ("G01 #ANG=0 X50 F100", [50, 19.98, 29.97]),
        ("G193 G01 X50 F100", [50, 19.98, 29.97]),
        ("G01 X50 G166 E50 F100", [50, 19.98, 29.97]),
    ],
)
def test_behind_actpos_the_path_goes_on_from_where_it_stands(motion: str, end: list[float]) -> None:
    run = at(f"F100\n#CHANNEL INIT [ACTPOS]\n{motion}\nG90 G01 X60 Y0 Z0 F100\nX61", start=STANDS)
    moves = way(run)
    assert moves[0][0] == list(STANDS)
    assert any(found[1] == pytest.approx(end) for found in moves)
    for before, behind in itertools.pairwise(moves):
        assert behind[0] == pytest.approx(before[1]), "no gap"
    assert moves[-1][1] == [61, 0, 0]


@pytest.mark.spec(_INIT)
def test_feeds_of_a_whole_block_count_over_the_way_that_is_driven() -> None:
    run = at("#CHANNEL INIT [ACTPOS AX=X]\nG93 F2\nG01 X20", start=STANDS)
    (row,) = [row for row in run.rows if "to" in row]
    assert row["feed"] == pytest.approx(10.0 / 2 * 60)


@pytest.mark.spec(_INIT)
@pytest.mark.parametrize("arc", ["G02 X2 I1", "G03 X2 R5", "G02 I1 #CANG=90", "G303 I1 J1 K0 X2 Y0 Z0"])
def test_behind_actpos_an_arc_is_refused_until_a_straight_move_has_come(arc: str) -> None:
    assert refused(f"#CHANNEL INIT [ACTPOS]\nF100\n{arc}") is catalogue.ACTUAL_FIRST
    assert refused("#CHANNEL INIT [ACTPOS]\nG01 X10 F100\nG02 X12 I1") is None
    assert refused("#CHANNEL INIT [ACTPOS]\n#CHANNEL INIT [CMDPOS]\nF100\nG02 X12 I6") is None


@pytest.mark.spec(_INIT)
@pytest.mark.parametrize(
    ("arguments", "entry"),
    [
        ("[]", catalogue.POSITIONS_KIND),
        ("[AX=X]", catalogue.POSITIONS_KIND),
        ("[CMDPOS ACTPOS]", catalogue.POSITIONS_KIND),
        ("[CMDPOS AX=Q]", catalogue.AXIS_UNKNOWN),
        ("[CMDPOS AXNR=1]", catalogue.LOGICAL_AXIS),
        ("[CMDPOS AXNR=4.4]", catalogue.LOGICAL_AXIS),
    ],
)
def test_what_an_initialisation_refuses(arguments: str, entry: ErrorEntry) -> None:
    assert refused(f"#CHANNEL INIT {arguments}") is entry
