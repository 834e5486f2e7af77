"""#GET CMDPOS, #GET ACTPOS: the positions of the machine in parameters and variables."""

from __future__ import annotations

import numpy as np
import pytest

from runtime.cnc.blocks import Floats, Flush, FlushKind
from runtime.cnc.decoder import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import Run, decode
from tests.cnc.decoder.scripted_outside import Machine

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


def at(text: str, command: tuple[float, ...] = (10.0, 20.0, 30.0)) -> Run:
    """The program on a machine whose axes lag by 0.01, 0.02 and 0.03 mm."""
    run = decode(text, outside=Standing(command, tuple(c - 0.01 * (i + 1) for i, c in enumerate(command))))
    assert run.problem is None, run.problem
    return run


def refused(text: str) -> ErrorEntry | None:
    try:
        run = decode(text)
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
