"""Absolute motions of an axis that turns without end."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.gear import MasterPlaces
from runtime.cnc.axes.job_values import AxisCycle, Followed
from runtime.cnc.axes.jobs import AxisJobs
from runtime.cnc.axes.modulo import TURN, chosen_turn
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, Direction, JobState

LIMITS = Dynamics(velocity=100.0, acceleration=1000.0, jerk=20_000.0)
PERIOD = 0.001
PLACES = st.floats(-1e5, 1e5)


@given(PLACES, PLACES, st.floats(-200.0, 200.0), st.floats(-500.0, 500.0), st.sampled_from(Direction))
def test_the_end_is_the_position_in_some_turn_and_in_the_direction(
    position: float, place: float, braking: float, velocity: float, direction: Direction
) -> None:
    rest = place + math.copysign(braking, velocity)
    end = chosen_turn(position, place, rest, velocity, direction)
    turns = (end - position) / TURN
    assert turns == pytest.approx(round(turns), abs=1e-9)
    if direction is Direction.SHORTEST:
        assert abs(end - place) <= TURN / 2 + 1e-6
    elif direction is Direction.NEGATIVE or (direction is Direction.CURRENT and velocity < 0.0):
        assert -TURN - 1e-6 <= end - rest <= 1e-6
    else:
        assert -1e-6 <= end - rest <= TURN + 1e-6


class Table:
    """An ideal axis without software limits."""

    def __init__(self, place: float = 0.0) -> None:
        places = np.zeros(1)
        masters = MasterPlaces({1: 0}, places, places)
        self.jobs = AxisJobs("C", 0, LIMITS, PERIOD, -math.inf, math.inf, masters, modulo=True)
        self.cycle = AxisCycle(True, False, False, place, place, True)
        self.path = [place]
        self.step()

    def give(self, function: AxisFunction, **values: object) -> Followed:
        return self.jobs.give(Job(function, **values), self.cycle)  # type: ignore[arg-type]

    def step(self, cycles: int = 1) -> None:
        for _ in range(cycles):
            place = self.jobs.step(self.cycle)
            if place is not None:
                self.cycle.set_point = self.cycle.actual = place
            self.path.append(self.cycle.set_point)

    def finish(self, job: Followed) -> float:
        while job.open:
            self.step()
        assert job.answer.state is JobState.DONE
        return self.path[-1]


@pytest.mark.parametrize(
    ("begin", "direction", "end"),
    [
        (10.0, Direction.SHORTEST, -10.0),
        (10.0, Direction.POSITIVE, 350.0),
        (10.0, Direction.NEGATIVE, -10.0),
        (10.0, Direction.CURRENT, 350.0),
        (700.0, Direction.SHORTEST, 710.0),
        (710.0, Direction.POSITIVE, 710.0),
        (710.0, Direction.NEGATIVE, 710.0),
        (711.0, Direction.POSITIVE, 1070.0),
        (-371.0, Direction.NEGATIVE, -730.0),
    ],
)
def test_the_turn_that_a_direction_leads_to(begin: float, direction: Direction, end: float) -> None:
    table = Table(begin)
    job = table.give(AxisFunction.MOVE_ABSOLUTE, position=350.0, velocity=90.0, direction=direction)
    assert table.finish(job) == pytest.approx(end)


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize("position", [0.5, 5.0, 100.0])
def test_out_of_a_motion_it_never_turns_back(sign: int, position: float) -> None:
    table = Table()
    table.give(
        AxisFunction.MOVE_VELOCITY, velocity=90.0, direction=Direction.POSITIVE if sign > 0 else Direction.NEGATIVE
    )
    while abs(table.path[-1]) < 360.0:
        table.step()
    job = table.give(AxisFunction.MOVE_ABSOLUTE, position=sign * position, velocity=60.0, direction=Direction.CURRENT)
    end = table.finish(job)
    assert end % 360.0 == pytest.approx(sign * position % 360.0)
    assert (np.diff(table.path) * sign >= -1e-12).all()
    v = np.diff(table.path) / PERIOD
    a = np.diff(v) / PERIOD
    assert np.abs(a).max() <= LIMITS.acceleration * (1.0 + 1e-6)
    assert np.abs(np.diff(a)).max() / PERIOD <= LIMITS.jerk * (1.0 + 1e-3)
