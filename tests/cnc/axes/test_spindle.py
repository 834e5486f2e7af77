from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from ruckig import ControlInterface, InputParameter, Ruckig, Trajectory

from runtime.cnc.axes.spindle import Spindle, SpindleMode, SpindleOrder
from runtime.config import load_machine

PERIOD = 0.001


def make_spindle() -> Spindle:
    return Spindle(load_machine(None).axes[3], 3, PERIOD)


def run(spindle: Spindle, seconds: float, override: float = 1.0) -> list[float]:
    speeds = []
    for _ in range(round(seconds / PERIOD)):
        spindle.step(override, running=True)
        speeds.append(spindle.set_point)
    return speeds


def test_m3_reaches_the_speed_and_m5_brings_it_to_rest() -> None:
    spindle = make_spindle()
    spindle.command(SpindleOrder(3, 6000.0))
    run(spindle, 1.0)
    assert spindle.set_point == pytest.approx(36000.0)
    assert spindle.reached(36000.0)
    assert not spindle.reached(35000.0)  # more than 2 % too slow
    spindle.command(SpindleOrder(5, 0.0))
    run(spindle, 1.0)
    assert spindle.set_point == 0.0
    assert spindle.standing(0.0)


def test_m4_turns_the_other_way_and_a_lone_s_keeps_the_direction() -> None:
    spindle = make_spindle()
    spindle.command(SpindleOrder(4, 1000.0))
    run(spindle, 0.5)
    spindle.command(SpindleOrder(0, 2000.0))
    run(spindle, 0.5)
    assert spindle.mode is SpindleMode.M4
    assert spindle.set_point == pytest.approx(-12000.0)


def test_speed_is_limited_to_what_the_spindle_can() -> None:
    spindle = make_spindle()
    spindle.command(SpindleOrder(3, 20000.0))
    run(spindle, 3.0, override=2.0)
    assert spindle.set_point == pytest.approx(24000 * 6.0)


def test_a_drive_that_takes_no_set_points_has_none() -> None:
    spindle = make_spindle()
    spindle.command(SpindleOrder(3, 6000.0))
    run(spindle, 1.0)
    spindle.step(1.0, running=False)
    assert spindle.set_point == 0.0


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from([3, 4, 5, 0]), st.floats(0, 30000), st.floats(0, 2), st.floats(0.01, 0.4)), max_size=6
    )
)
def test_acceleration_and_jerk_stay_within_their_limits_and_it_always_comes_to_rest(
    orders: list[tuple[int, float, float, float]],
) -> None:
    spindle = make_spindle()
    before = acceleration = 0.0
    for number, speed, override, seconds in orders:
        spindle.command(SpindleOrder(number, speed))
        for value in run(spindle, seconds, override):
            now = (value - before) / PERIOD
            assert abs(now) <= spindle.axis.acceleration * 1.0001
            assert abs(now - acceleration) <= spindle.axis.jerk * PERIOD * 1.001
            before, acceleration = value, now
    spindle.command(SpindleOrder(5, 0.0))
    assert run(spindle, 3.0)[-1] == 0.0


@pytest.mark.parametrize("speed", [10.0, 300.0, 6000.0, 24000.0])
def test_the_ramp_takes_no_longer_than_the_time_optimal_one_and_some_cycles(speed: float) -> None:
    spindle = make_spindle()
    optimal = InputParameter(1)
    optimal.control_interface = ControlInterface.Velocity
    optimal.max_acceleration, optimal.max_jerk = [spindle.axis.acceleration], [spindle.axis.jerk]
    optimal.target_velocity = [speed * 6.0]
    trajectory = Trajectory(1)
    Ruckig(1).calculate(optimal, trajectory)
    spindle.command(SpindleOrder(3, speed))
    cycles = 0
    while spindle.set_point != speed * 6.0:
        spindle.step(1.0, running=True)
        cycles += 1
    assert trajectory.duration <= cycles * PERIOD <= trajectory.duration + 8 * PERIOD
