"""One axis moved alone: its limits are never exceeded, its target is exact, and it may be asked for anything at any time."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruckig import InputParameter, Ruckig, Trajectory

from runtime.cnc.axes.axis_plan import Dynamics, PositionPlanner
from runtime.cnc.axes.single_axis import Goal, SingleAxis

PERIOD = 0.001
LIMITS = Dynamics(velocity=200.0, acceleration=2000.0, jerk=40000.0)


def make_axis(least: float = -math.inf, greatest: float = math.inf, position: float = 0.0) -> SingleAxis:
    return SingleAxis(LIMITS, PERIOD, least, greatest, position)


def run(axis: SingleAxis, cycles: int, override: float = 1.0, hold: bool = False) -> list[float]:
    return [axis.step(override, hold) for _ in range(cycles)]


def until_rest(axis: SingleAxis, most: int = 20000) -> list[float]:
    places = [axis.step()]
    while not axis.standstill:
        places.append(axis.step())
        assert len(places) < most, "never at rest"
    return places


def shortest_time(distance: float) -> float:
    """What Ruckig says by itself, s."""
    given_, trajectory = InputParameter(1), Trajectory(1)
    given_.target_position = [distance]
    given_.max_velocity, given_.max_acceleration = [LIMITS.velocity], [LIMITS.acceleration]
    given_.max_jerk = [LIMITS.jerk]
    Ruckig(1).calculate(given_, trajectory)
    return float(trajectory.duration)


# ------------------------------------------------------------------ goals


@pytest.mark.parametrize("distance", [1e-6, 0.001, 0.1, -3.0, 120.0, -2500.0])
def test_a_target_is_reached_exactly_and_in_the_shortest_time(distance: float) -> None:
    axis = make_axis()
    axis.move_to(distance)
    places = until_rest(axis)
    assert axis.position == distance
    assert axis.arrived
    assert len(places) == pytest.approx(shortest_time(distance) / PERIOD, abs=1.5)


def test_a_speed_is_reached_kept_and_given_up() -> None:
    axis = make_axis()
    axis.move_at(-50.0)
    run(axis, 500)
    assert axis.velocity == -50.0
    assert axis.arrived
    axis.stop()
    until_rest(axis)
    assert axis.arrived


def test_the_override_scales_speeds_and_zero_keeps_the_goal() -> None:
    axis = make_axis()
    axis.move_at(100.0)
    run(axis, 500, override=0.4)
    assert axis.velocity == pytest.approx(40.0)
    run(axis, 500, override=0.0)
    assert axis.standstill
    assert not axis.arrived
    run(axis, 500, override=1.5)
    assert axis.velocity == pytest.approx(150.0)


def test_no_override_lifts_a_motion_above_what_the_axis_can() -> None:
    axis = make_axis()
    axis.move_to(1000.0)
    speeds = []
    while not axis.standstill or axis.position == 0.0:
        axis.step(override=2.0)
        speeds.append(axis.velocity)
    assert max(speeds) <= LIMITS.velocity


def test_hold_brakes_and_the_goal_is_reached_afterwards() -> None:
    axis = make_axis()
    axis.move_to(50.0)
    run(axis, 150)
    run(axis, 500, hold=True)
    assert axis.standstill
    assert 0.0 < axis.position < 50.0
    until_rest(axis)
    assert axis.position == 50.0


def test_dynamics_of_a_motion_count_below_those_of_the_axis() -> None:
    axis = make_axis()
    axis.move_to(30.0, Dynamics(velocity=20.0, acceleration=100.0, jerk=1000.0, deceleration=50.0))
    speeds, gains = [0.0], []
    while not axis.arrived:
        axis.step()
        speeds.append(axis.velocity)
        gains.append(axis.acceleration)
    assert max(speeds) == pytest.approx(20.0)
    assert max(gains) == pytest.approx(100.0)
    assert min(gains) == pytest.approx(-50.0)


def test_a_target_may_be_passed_with_a_velocity() -> None:
    axis = make_axis(greatest=100.0)
    axis.move_to(20.0, end_velocity=30.0)
    while axis.position < 20.0:
        axis.step()
    assert axis.velocity == pytest.approx(30.0, rel=1e-3)
    until_rest(axis)
    assert axis.position == 100.0  # on towards the software limit


def test_a_target_too_near_to_the_limit_is_not_passed() -> None:
    axis = make_axis(greatest=20.001)
    axis.move_to(20.0, end_velocity=100.0)
    until_rest(axis)
    assert axis.position == 20.0


# ------------------------------------------------------------------ software limits


def test_a_speed_towards_a_limit_ends_exactly_at_it() -> None:
    axis = make_axis(least=-10.0, greatest=40.0)
    axis.move_at(80.0)
    places = until_rest(axis)
    assert axis.position == 40.0
    assert axis.at_limit
    assert max(places) <= 40.0
    axis.move_at(-80.0)
    until_rest(axis)
    assert axis.position == -10.0
    assert axis.at_limit


def test_a_target_behind_a_limit_is_cut_to_it_and_told() -> None:
    axis = make_axis(greatest=40.0)
    axis.move_to(41.0)
    until_rest(axis)
    assert axis.position == 40.0
    assert axis.limited
    assert axis.at_limit


def test_outside_of_the_limits_only_the_way_back_is_open() -> None:
    axis = make_axis(least=0.0, greatest=10.0, position=12.0)
    axis.move_at(5.0)
    run(axis, 100)
    assert axis.position == 12.0
    axis.move_at(-5.0)
    run(axis, 100)
    assert axis.position < 12.0


def test_limits_that_move_in_brake_the_axis() -> None:
    axis = make_axis(least=0.0, greatest=1000.0)
    axis.move_at(200.0)
    run(axis, 1000)
    axis.set_limits(0.0, 300.0)
    until_rest(axis)
    assert axis.position == 300.0


# ------------------------------------------------------------------ wrong values


@pytest.mark.parametrize("least", [-5.0, 10.0, 30.0])
def test_limits_that_are_moved_too_near_are_where_the_axis_can_stop(least: float) -> None:
    """Going down at 200 mm/s it needs some 15 mm; it neither jumps nor freezes, and does not come back by itself."""
    axis = make_axis(-500.0, 500.0, 100.0)
    axis.move_at(-200.0)
    places = run(axis, 500)
    assert places[-1] == pytest.approx(10.0, abs=6.0)
    axis.set_limits(least, 500.0)
    places += until_rest(axis)
    acceleration = np.diff(places, 2) / PERIOD**2
    assert np.abs(acceleration).max() <= LIMITS.acceleration * 1.001
    assert axis.position == min(places)


@pytest.mark.parametrize("value", [math.nan, math.inf])
def test_what_is_no_number_moves_nothing(value: float) -> None:
    axis = make_axis()
    assert not axis.move_to(value)
    assert not axis.move_at(value)
    assert not axis.move_to(1.0, Dynamics(value, 1.0, 1.0))
    assert not axis.move_to(1.0, Dynamics(1.0, 0.0, 1.0))
    run(axis, 10)
    assert axis.position == 0.0
    assert axis.goal is Goal.REST


# ------------------------------------------------------------------ laws

ORDERS = st.lists(
    st.tuples(
        st.one_of(
            st.tuples(st.just("to"), st.floats(-60, 60)),
            st.tuples(st.just("at"), st.floats(-300, 300)),
            st.tuples(st.just("stop"), st.just(0.0)),
            st.tuples(st.just("through"), st.floats(-60, 60)),
        ),
        st.sampled_from([1.0, 0.3, 2.0, 0.0, 1e-3]),
        st.booleans(),
        st.integers(1, 200),
        st.sampled_from([None, Dynamics(30.0, 300.0, 3000.0), Dynamics(400.0, 500.0, 90000.0, 50.0)]),
    ),
    min_size=1,
    max_size=12,
)


def give(axis: SingleAxis, kind: str, value: float, dynamics: Dynamics | None) -> None:
    if kind == "to":
        axis.move_to(value, dynamics)
    elif kind == "at":
        axis.move_at(value, dynamics)
    elif kind == "through":
        axis.move_to(value, dynamics, end_velocity=math.copysign(40.0, value))
    else:
        axis.stop(dynamics)


@settings(max_examples=150, deadline=None)
@given(ORDERS)
def test_limits_hold_whatever_is_ordered_and_the_last_target_is_reached(
    orders: list[tuple[tuple[str, float], float, bool, int, Dynamics | None]],
) -> None:
    axis = make_axis(least=-50.0, greatest=50.0)
    before = (0.0, 0.0, 0.0)
    for (kind, value), override, hold, cycles, dynamics in orders:
        give(axis, kind, value, dynamics)
        for _ in range(cycles):
            p = axis.step(override, hold)
            v, a = axis.velocity, axis.acceleration
            assert -50.0 <= p <= 50.0
            assert abs(v) <= LIMITS.velocity * (1 + 1e-6)
            assert abs(a) <= LIMITS.acceleration * (1 + 1e-6)
            assert abs(a - before[2]) <= LIMITS.jerk * PERIOD * (1 + 1e-6)
            assert abs(v - before[1]) <= LIMITS.acceleration * PERIOD * (1 + 1e-6)
            assert abs(p - before[0]) <= LIMITS.velocity * PERIOD * (1 + 1e-6)
            before = (p, v, a)
    axis.move_to(12.5)
    run(axis, 2000)
    assert axis.position == 12.5
    assert axis.arrived


@settings(max_examples=60, deadline=None)
@given(ORDERS, st.integers(0, 40))
def test_a_planner_that_fails_never_takes_the_axis_out_of_its_limits(
    orders: list[tuple[tuple[str, float], float, bool, int, Dynamics | None]], fails_every: int
) -> None:
    axis = make_axis(least=-50.0, greatest=50.0)
    axis._planner = Failing(fails_every)
    for (kind, value), override, hold, cycles, dynamics in orders:
        give(axis, kind, value, dynamics)
        for place in run(axis, cycles, override, hold):
            assert -50.0 <= place <= 50.0
    axis.stop()
    until_rest(axis)


class Failing(PositionPlanner):
    """Finds a plan only now and then; 0: never."""

    def __init__(self, every: int) -> None:
        super().__init__()
        self._every, self._count = every, 0

    def plan(self, *values: Any) -> bool:
        self._count += 1
        if not self._every or self._count % self._every:
            return False
        return super().plan(*values)
