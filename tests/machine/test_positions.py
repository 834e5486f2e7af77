"""Programs that ask the machine where its axes are, and go on from there."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
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


@pytest.mark.spec("isg.g.channel-init-cmdpos-actpos")
def test_real_axes_go_on_from_where_they_are(demo: Machine, program: Write) -> None:
    """The path of the servos has no jump, and the axis without a word goes to where it was measured."""
    path = program(
        "%T\nG90 G01 X20 Y5 F6000\n#CHANNEL INIT [ACTPOS]\nP1=V.A.ABS.X P2=V.A.ABS.Y\nX40\n#GET CMDPOS [P3=X, P4=Y]\n"
        "#CHANNEL INIT [CMDPOS AX=Y]\nP5=V.A.ABS.Y\nX0 Y0\nM30\n"
    )
    simulation = Simulation(demo, samples=True)
    found = parameters(simulation, path)
    window = demo.axes[0].in_position
    assert 0 < abs(found[1] - 20) <= window
    assert (found[3], found[4]) == pytest.approx((40, found[2]), abs=1e-9)
    assert found[5] == found[4]
    assert simulation.samples is not None
    speeds = np.abs(np.diff(simulation.samples.arrays()["X"])) / simulation.period
    assert speeds.max() <= 100.0 * 1.001  # mm/s, F6000
