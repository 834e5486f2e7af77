"""Signals, limits, ramps and controllers in virtual PLC cycles."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from datetime import datetime, timedelta

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.plc_logic import cycle_at
from runtime.plc_logic.control_blocks import (
    AVERAGE,
    BLINK,
    DEBOUNCE,
    DERIVATIVE,
    HYSTERESIS,
    INTEGRAL,
    LAG,
    LIMITALARM,
    OPERATING_HOURS,
    PID,
    RAMP,
    RTC,
    TONR,
)
from runtime.plc_logic.cycle_time import cycle_at_ns


def over(values: Iterable[object], call: Callable[[object], object], cycle: float = 0.1) -> list[object]:
    """What a call gives for each value, a cycle apart."""
    found = []
    for i, value in enumerate(values):
        with cycle_at(10.0 + i * cycle):
            found.append(call(value))
    return found


def line(pins: str, call: Callable[[bool], bool]) -> str:
    return "".join("#" if on else "_" for on in over(pins, lambda pin: call(pin == "#")))


def test_blink_begins_with_on_and_keeps_its_times() -> None:
    blink = BLINK(TIMELOW=0.2, TIMEHIGH=0.3)
    assert line("_##########_##", lambda pin: blink(ENABLE=pin).OUT) == "_###__###__" + "_##"


def test_retentive_delay_counts_on_after_a_pause_until_reset() -> None:
    timer = TONR(PT=0.3)
    assert line("##__##____", lambda pin: timer(IN=pin).Q) == "_____#####"
    assert pytest.approx(0.3) == timer.ET
    with cycle_at(20.0):
        assert not timer(IN=False, R=True).Q


def test_debounce_needs_a_value_that_stays() -> None:
    block = DEBOUNCE(TIME=0.2)
    assert line("_#_#_####_#_____", lambda pin: block(IN=pin).OUT) == "_______######___"


def test_operating_hours_count_only_while_it_runs() -> None:
    hours = OPERATING_HOURS(HOURS=5.0)
    line("_###__##__", lambda pin: bool(hours(IN=pin).HOURS))
    assert pytest.approx(5.0 + 0.5 / 3600) == hours.HOURS


def test_clock_follows_the_computers_and_can_be_set() -> None:
    clock, noon = RTC(), datetime(2026, 6, 1, 12, 0, 0)
    wall = round(noon.timestamp() * 1e9)
    with cycle_at_ns(0, wall):
        assert noon == clock(EN=False).CDT
    set_to = datetime(2030, 1, 1)
    with cycle_at_ns(1, wall):
        assert set_to == clock(EN=True, PDT=set_to).CDT
    with cycle_at_ns(2, wall + 60 * 10**9):
        assert set_to + timedelta(minutes=1) == clock(EN=True, PDT=set_to).CDT
        assert clock.Q


def test_hysteresis_and_limit_alarm() -> None:
    heat, watch = HYSTERESIS(), LIMITALARM()
    assert over((15, 18, 22, 25, 22, 19, 17), lambda t: heat(IN=float(str(t)), HIGH=24, LOW=18).OUT) == [
        *(True, True, True, False, False, False, True)
    ]
    states = over((5, 11, 9.5, 8, -1, 0.5, 2), lambda v: _states(watch, float(str(v))))
    assert states == ["IL", "O", "O", "IL", "U", "U", "IL"]


def _states(watch: LIMITALARM, value: float) -> str:
    watch(IN=value, HIGH=10, LOW=0, EPS=1)
    return "O" if watch.O else "U" if watch.U else "IL" if watch.IL else "?"


@given(st.lists(st.floats(-100, 100), min_size=2, max_size=30), st.floats(0.1, 50), st.floats(0.1, 50))
def test_a_ramp_is_never_steeper_than_its_slopes_and_never_beyond_its_target(
    targets: list[float], up: float, down: float
) -> None:
    ramp = RAMP(START=0.0)
    places = [0.0, *(float(str(v)) for v in over(targets, lambda t: ramp(float(str(t)), up, down).OUT))]
    for before, now, target in zip(places[1:], places[2:], targets[1:], strict=False):
        assert -down * 0.1 - 1e-9 <= now - before <= up * 0.1 + 1e-9
        assert min(before, target) <= now <= max(before, target)


def test_the_first_call_of_a_ramp_takes_its_input_over() -> None:
    ramp = RAMP()
    assert over((5.0, 5.0), lambda v: ramp(float(str(v)), 1, 1).OUT) == [5.0, 5.0]


def test_integral_and_derivative_of_a_straight_line() -> None:
    integral, derivative = INTEGRAL(), DERIVATIVE()
    values = [0.1 * i * 3 for i in range(11)]  # 3 per second for one second
    assert over(values, lambda v: integral(IN=float(str(v))).OUT)[-1] == pytest.approx(1.5)
    slopes = over(values, lambda v: derivative(IN=float(str(v))).OUT)
    assert slopes == [0.0, *[pytest.approx(3.0)] * 10]
    with cycle_at(11.1):
        assert integral(IN=100.0, HIGH=2.0).OUT == 2.0
        assert integral.LIMITED


@given(st.floats(0.01, 10), st.floats(-50, 50))
def test_a_lag_reaches_63_percent_after_its_time_constant(constant: float, step: float) -> None:
    lag = LAG()
    with cycle_at(0.0):
        lag(IN=0.0, T=constant)
    for i in range(1, 11):
        with cycle_at_ns(round(i * constant * 1e8)):
            lag(IN=step, T=constant)
    assert pytest.approx(step * (1 - math.exp(-1)), abs=1e-4) == lag.OUT


def test_average_of_the_last_values() -> None:
    mean = AVERAGE(3)
    assert over((3.0, 6.0, 9.0, 12.0), lambda v: mean(float(str(v))).OUT) == [3.0, 4.5, 6.0, 9.0]


@given(st.floats(0.5, 4.0), st.floats(-20, 20))
def test_a_pi_controller_brings_a_first_order_plant_to_its_set_point(gain: float, set_point: float) -> None:
    """Without the integral a difference of 1/(1 + gain) would stay."""
    controller, plant, value = PID(), LAG(), 0.0
    for i in range(600):
        with cycle_at(i * 0.05):
            drive = controller(ACTUAL=value, SET_POINT=set_point, KP=gain, TN=1.0, Y_MIN=-100, Y_MAX=100).Y
            value = plant(IN=drive, T=1.0).OUT
    assert value == pytest.approx(set_point, abs=0.01 * abs(set_point) + 1e-6)


def test_the_integral_does_not_run_away_at_the_limit() -> None:
    controller = PID()
    for i in range(100):  # far away for a long time
        with cycle_at(i * 0.1):
            assert controller(ACTUAL=0, SET_POINT=100, KP=1, TN=1, Y_MAX=10).Y <= 10
    assert controller.LIMITS_ACTIVE
    with cycle_at(10.1):
        assert controller(ACTUAL=110, SET_POINT=100, KP=1, TN=1, Y_MAX=10).Y < 10, "leaves the limit at once"


def test_manual_and_back_without_a_jump() -> None:
    controller = PID()
    for i in range(5):
        with cycle_at(i * 0.1):
            assert controller(ACTUAL=3, SET_POINT=5, KP=2, TN=4, MANUAL=True, Y_MANUAL=7).Y == 7
    with cycle_at(0.5):
        assert pytest.approx(7, abs=0.2) == controller(ACTUAL=3, SET_POINT=5, KP=2, TN=4).Y


def test_a_broken_sensor_leaves_the_output_where_it_is() -> None:
    controller = PID()
    with cycle_at(0.0):
        before = controller(ACTUAL=1, SET_POINT=2, KP=3).Y
    with cycle_at(0.1):
        assert before == controller(ACTUAL=math.nan, SET_POINT=2, KP=3).Y
