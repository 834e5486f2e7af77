from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.axes.spindle import Spindle, SpindleMode
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
    spindle.command(3, 6000.0)
    run(spindle, 1.0)
    assert spindle.set_point == pytest.approx(36000.0)
    assert spindle.reached(36000.0)
    assert not spindle.reached(35000.0)  # more than 2 % too slow
    spindle.command(5, 0.0)
    run(spindle, 1.0)
    assert spindle.set_point == 0.0
    assert spindle.standing(0.0)


def test_m4_turns_the_other_way_and_a_lone_s_keeps_the_direction() -> None:
    spindle = make_spindle()
    spindle.command(4, 1000.0)
    run(spindle, 0.5)
    spindle.command(0, 2000.0)
    run(spindle, 0.5)
    assert spindle.mode is SpindleMode.M4
    assert spindle.set_point == pytest.approx(-12000.0)


def test_speed_is_limited_to_what_the_spindle_can() -> None:
    spindle = make_spindle()
    spindle.command(3, 20000.0)
    run(spindle, 3.0, override=2.0)
    assert spindle.set_point == pytest.approx(24000 * 6.0)


def test_a_drive_that_takes_no_set_points_has_none() -> None:
    spindle = make_spindle()
    spindle.command(3, 6000.0)
    run(spindle, 1.0)
    spindle.step(1.0, running=False)
    assert spindle.set_point == 0.0


@settings(max_examples=25, deadline=None)
@given(
    st.lists(
        st.tuples(st.sampled_from([3, 4, 5, 0]), st.floats(0, 30000), st.floats(0, 2), st.floats(0.01, 0.4)), max_size=6
    )
)
def test_acceleration_stays_within_its_limit(orders: list[tuple[int, float, float, float]]) -> None:
    spindle = make_spindle()
    before = 0.0
    for number, speed, override, seconds in orders:
        spindle.command(number, speed)
        for value in run(spindle, seconds, override):
            assert abs(value - before) <= spindle.axis.acceleration * PERIOD * 1.001
            before = value
