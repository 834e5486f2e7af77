"""Programs that ask the machine where its axes are, and go on from there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.scheduler.simulation import Simulation

Write = Callable[[str], Path]


def parameters(simulation: Simulation, path: Path) -> dict[int, float]:
    """The P parameters of a program that has come to its end."""
    result = simulation.run_program(path)
    assert result.good, result.problems
    return result.parameters


@pytest.mark.spec("isg.g.get-cmdpos-actpos")
def test_command_and_actual_positions_of_real_axes(demo: Machine, program: Write) -> None:
    path = program("%T\nG90 G01 X20 Y5 F6000\n#GET CMDPOS [P1=X, P2=Y]\n#GET ACTPOS [P3=X, P4=Y]\nX0 Y0\nM30\n")
    found = parameters(Simulation(demo), path)
    assert (found[1], found[2]) == (20, 5)
    window = demo.axes[0].in_position
    assert 0 < abs(found[3] - 20) <= window  # measured: a servo is not yet exactly there
    assert abs(found[4] - 5) <= window
