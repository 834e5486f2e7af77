"""Feed hold with a ramp of its own (P-CHAN-00097): how far it goes, and that no axis has to do more than it can."""

from __future__ import annotations

import math
import os
import random
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import Block, DynamicsChange, Line, Source
from runtime.cnc.dynamic_settings import USUAL, DynamicSettings, MoveSettings, Slope, VectorLimits
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import RecordKind
from runtime.cnc.path_preparation.channel_dynamics import ChannelDynamics, HoldRamp
from tests.cnc.interpolator.driving import PERIOD, Order, drive, limits
from tests.cnc.interpolator.test_laws import distance_to_path, random_blocks, random_limits, restless

Floats = npt.NDArray[np.float64]

COMPILED = os.environ.get("NUMBA_DISABLE_JIT", "0") in ("", "0")
ZERO = np.zeros(3)
SOURCE = Source("p", 1)
AXES = limits(400.0, 4000.0, 60_000.0, 5.0)
HALF = replace(USUAL, feed=MoveSettings(acceleration=(0.25,) * 3))


def ramp(deceleration: float = math.inf, seconds: float = 0.0) -> ChannelDynamics:
    return ChannelDynamics(hold=HoldRamp(np.full(3, deceleration), np.full(3, seconds)))


def way_of_a_hold(v: float, A: float, J: float) -> float:
    """The shortest way to standstill with deceleration A, mm/s², built up with jerk J, mm/s³, from v mm/s."""
    return v * (v / A + A / J) / 2.0 if v > A * A / J else v * math.sqrt(v / J)


@pytest.mark.uncompiled
@pytest.mark.spec("chan.feedhold-ramp", "isg.g.acceleration-weight", "isg.g.ramp-time-weight")
@pytest.mark.parametrize(
    ("weights", "program", "A", "J"),
    [
        (ChannelDynamics(), HALF, 1000.0, 15_000.0),  # without the parameter: what holds
        (ramp(), USUAL, 4000.0, 60_000.0),
        (ramp(), HALF, 4000.0, 60_000.0),  # the axis as it is, whatever the weights of the program
        (ramp(2000.0), HALF, 2000.0, 60_000.0),
        (ramp(2000.0), USUAL, 2000.0, 60_000.0),  # gentler than the program
        (ramp(9000.0), HALF, 4000.0, 60_000.0),  # never more than the axis can
        (ramp(2000.0, 0.1), USUAL, 2000.0, 20_000.0),
        (ramp(2000.0), replace(HALF, hold_acceleration=(1.5,) * 3), 3000.0, 60_000.0),
        (ramp(2000.0), replace(HALF, hold_acceleration=(4.0,) * 3), 4000.0, 60_000.0),
        (ramp(2000.0), replace(HALF, hold_acceleration=(0.75,) * 3), 1500.0, 45_000.0),
        (ramp(2000.0), replace(HALF, hold_acceleration=(0.25,) * 3), 2000.0, 60_000.0),  # below the 1000 of the program
        (ramp(2000.0, 0.1), replace(HALF, hold_ramp_time=(2.0,) * 3), 2000.0, 10_000.0),
        (ramp(2000.0, 0.1), replace(HALF, hold_ramp_time=(0.1,) * 3), 2000.0, 60_000.0),
        (ramp(2000.0), replace(USUAL, slope=Slope.STEP), 2000.0, 2000.0 / PERIOD),
        (ramp(), replace(USUAL, feed=MoveSettings(vector=VectorLimits(deceleration=500.0))), 500.0, 60_000.0),
    ],
)
def test_a_feed_hold_takes_the_way_of_its_ramp(
    weights: ChannelDynamics, program: DynamicSettings, A: float, J: float
) -> None:
    end = np.array([600.0, 0.0, 0.0])
    move = Line(SOURCE, ZERO, end, 12_000.0, False, end)
    begin = 700

    def held(cycle: int, _path: Interpolator) -> Order:
        return Order(hold=cycle >= begin)

    run = drive([DynamicsChange(SOURCE, program), move], AXES, ZERO, held, weights=weights, most=begin + 900)
    v = np.array([0.0, *run.v])
    assert v[begin] == pytest.approx(200.0)
    assert run.v[-1] == 0.0
    way = run.s[-1] - run.s[begin - 1]
    assert way == pytest.approx(way_of_a_hold(200.0, A, J), rel=2e-3 if J < 1e6 else 1e-2)
    a = np.diff(v[begin:]) / PERIOD
    assert a.min() >= -A * 1.001


@pytest.mark.spec("chan.feedhold-ramp")
def test_each_axis_has_its_own_ramp() -> None:
    """A diagonal: the axis that may brake least decides."""
    weights = ChannelDynamics(hold=HoldRamp(np.array([3000.0, 1200.0, 4000.0]), np.zeros(3)))
    end = np.array([300.0, 400.0, 0.0])
    move = Line(SOURCE, ZERO, end, 12_000.0, False, end)
    run = drive([move], AXES, ZERO, lambda cycle, _: Order(hold=cycle >= 500), weights=weights, most=1200)
    A, J = 1200.0 / 0.8, 60_000.0 / 0.8
    assert run.s[-1] - run.s[499] == pytest.approx(way_of_a_hold(200.0, A, J), rel=2e-3)


def check_axes(run: npt.NDArray[np.float64], axes: AxisLimits, steps: Floats) -> None:
    """Acceleration and jerk of every axis between samples; `steps` (cycles,): corners passed in or beside a cycle."""
    v = np.diff(run, axis=0) / PERIOD
    a = np.diff(v, axis=0) / PERIOD
    smooth = steps[2:] == 0.0
    worst = (np.abs(a) / axes.acceleration).max(axis=1)
    assert worst[smooth].max(initial=0.0) <= 1.005


@settings(max_examples=25 if COMPILED else 2, deadline=None, derandomize=True)
@given(seed=st.integers(0, 10**9), level=st.integers(1, 3), count=st.integers(1, 8))
def test_no_axis_does_more_than_it_can_and_the_end_is_met(seed: int, level: int, count: int) -> None:
    rng = random.Random(seed)
    blocks, end = random_blocks(rng, count, ZERO)
    axes = random_limits(rng)
    program = replace(
        USUAL,
        feed=MoveSettings(acceleration=tuple(rng.choice([0.2, 0.5, 1.0]) for _ in range(3))),
        rapid=MoveSettings(ramp_time=tuple(rng.choice([1.0, 2.0]) for _ in range(3))),
        hold_acceleration=tuple(rng.choice([0.5, 1.0, 3.0]) for _ in range(3)),
        hold_ramp_time=tuple(rng.choice([0.3, 1.0, 2.0]) for _ in range(3)),
    )
    share = np.array([rng.choice([0.3, 1.0]) for _ in range(3)])
    weights = ChannelDynamics(hold=HoldRamp(axes.acceleration * share, np.full(3, rng.choice([0.0, 0.05]))))
    stream: list[Block] = [DynamicsChange(SOURCE, program), *blocks]
    run = drive(stream, axes, ZERO, restless(rng, level), budget=rng.choice([1, 3, 4000]), most=60_000, weights=weights)
    assert run.finished
    assert distance_to_path(run) < 1e-6
    assert np.abs(run.path[-1] - end).max() < 2e-9
    assert (np.diff(run.s) >= 0.0).all()
    moving = {k: r for k, r in run.elements.items() if r["kind"] <= RecordKind.POLYNOMIAL}
    a, before = np.array([0.0, *run.a]), -1
    for cycle in range(run.cycles):
        now = run.record[cycle]
        touched = [moving[k] for k in range(max(before, 0), now + 1) if k in moving]
        if touched:
            A = max(max(float(r["a_limit"]), float(r["a_hold"])) for r in touched)
            J = max(max(float(r["j_limit"]), float(r["j_hold"])) for r in touched)
            jump = sum(2.0 * float(r["a_entry"]) for r in touched[1:])
            assert abs(a[cycle + 1]) <= A * (1 + 1e-4) + 1e-3
            assert max(abs(a[cycle + 1] - a[cycle]) - jump, 0.0) / PERIOD <= J * 1.05 + 10.0
            assert a[cycle + 1] <= max(float(r["a_limit"]) for r in touched) * (1 + 1e-4) + 1e-3  # speeding up as ever
        before = max(before, now)
    corner = np.zeros(run.cycles)
    for cycle in range(run.cycles):
        if cycle and run.record[cycle] != run.record[cycle - 1]:
            corner[max(cycle - 2, 0) : cycle + 3] = 1.0
    check_axes(run.path, axes, corner)
