"""Exact stop on the machine with its servos: the path goes on when the axes are where it stands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import numpy.typing as npt
import pytest

from runtime.config.machine import Machine
from runtime.hli.layout import StopCondition
from runtime.scheduler.simulation import Simulation

pytestmark = pytest.mark.spec("isg.g.exact-stop")
Write = Callable[[str], Path]
Floats = npt.NDArray[np.float64]


@pytest.fixture(scope="module")
def exacting(demo: Machine) -> Machine:
    """The demo machine with windows so small that its servos need some cycles to get there."""
    return demo.model_copy(update={"axes": tuple(a.model_copy(update={"in_position": 0.002}) for a in demo.axes)})


class Watched:
    """A program on real axes, recorded in every cycle: X and Y of the path and as measured, path velocity, stop condition."""

    def __init__(self, machine: Machine, path: Path) -> None:
        self.window = machine.axes[0].in_position
        simulation = Simulation(machine)
        channel, interpolator = simulation.controller.channel, simulation.controller.interpolator
        assert simulation.run_until(simulation.ready, 20.0)
        simulation.start(path)
        rows: list[list[float]] = []
        for _ in range(20_000):
            simulation.cycle()
            if rows and not channel.active:
                break
            if channel.active:
                actual = simulation.drives.image.actual_position
                rows.append(
                    [*interpolator.position[:2], *actual[:2], interpolator.path_velocity, channel.stop_condition]
                )
        assert not channel.active
        assert simulation.problems == []
        self.rows = np.array(rows)

    def standing_at(self, x: float, y: float) -> Floats:
        """The rows in which the path is at this place."""
        there = (np.abs(self.rows[:, 0] - x) < 1e-9) & (np.abs(self.rows[:, 1] - y) < 1e-9)
        return self.rows[there]

    def lag_when_leaving(self, x: float, y: float) -> float:
        """The greatest following error of X and Y in the last cycle in which the path is at a place, mm."""
        last = self.standing_at(x, y)[-1]
        return float(np.abs(last[:2] - last[2:4]).max())


CORNER = "%T\nG90 G01 F6000 X50 {}\nY50\nX0 Y0\nM30\n"


def test_the_corner_is_left_when_the_axes_are_in_their_window(exacting: Machine, program: Write) -> None:
    exact = Watched(exacting, program(CORNER.format("G60")))
    stands = exact.standing_at(50, 0)
    assert stands[-1, 4] == 0.0
    assert exact.lag_when_leaving(50, 0) <= exact.window
    assert (stands[1:-1, 5].astype(int) == StopCondition.EXACT_STOP).all()
    assert len(stands) > 5, "there was something to wait for"
    assert len(exact.standing_at(50, 50)) <= 2, "G60 holds for its block only"


def test_without_exact_stop_the_corner_is_left_while_the_axes_lag(exacting: Machine, program: Write) -> None:
    plain = Watched(exacting, program(CORNER.format("")))
    before = plain.rows[int(np.argmax(plain.rows[:, 1] > 0.0)) - 1]  # the last cycle in which Y has not yet moved
    assert np.abs(before[:2] - before[2:4]).max() > plain.window


def test_g360_stops_at_every_block_even_on_a_straight_way(exacting: Machine, program: Write) -> None:
    text = "%T\nG90 G360 G01 F6000 X20\nX40\nX60\nG359\nX80\nX100\nM30\n"
    watched = Watched(exacting, program(text))
    for x in (20.0, 40.0, 60.0):
        assert watched.standing_at(x, 0)[-1, 4] == 0.0
        assert watched.lag_when_leaving(x, 0) <= watched.window
    beside = (watched.rows[:, 0] > 79.0) & (watched.rows[:, 0] < 81.0)
    assert watched.rows[beside, 4].min() == pytest.approx(100.0)  # mm/s: it runs through
