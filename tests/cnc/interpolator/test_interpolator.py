"""What the interpolator does with single programs: times, gates, functions, feed hold, starvation, abort."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import numpy.typing as npt
import pytest

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Dwell,
    Line,
    Polyline,
    Source,
    Stop,
    StopKind,
    Synch,
    Technology,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.cnc.path_preparation import QueueWriter
from tests.cnc.interpolator.driving import PERIOD, Order, check_path_laws, drive, limits

Floats = npt.NDArray[np.float64]

ZERO = np.zeros(3)
DEMO = limits(400.0, 4000.0, 60_000.0, 5.0)


def line(start: Floats, end: Floats, feed: float = 6000.0, number: int = 1) -> Line:
    rapid = math.isinf(feed)
    return Line(Source("p", number, number), start, end, feed, rapid, end)


def at(x: float, y: float = 0.0, z: float = 0.0) -> Floats:
    return np.array([x, y, z])


def polyline(points: Floats, feed: float) -> Polyline:
    k = len(points) - 1
    return Polyline("p", points, np.full(k, feed), np.arange(1, k + 1), np.full(k, -1), ZERO)


def function(number: int, synch: Synch = Synch.MOS) -> TechnologyFunction:
    return TechnologyFunction(Source("p", 1), Technology.M, number, 0.0, synch)


def optimum(length: float, V: float, A: float, J: float) -> float:
    """Time of a jerk-limited move from stop to stop, analytically."""

    def ramp(v: float) -> float:
        return v / A + A / J if v >= A * A / J else 2.0 * math.sqrt(v / J)

    if V * ramp(V) <= length:
        return 2.0 * ramp(V) + (length - V * ramp(V)) / V
    low, high = 0.0, V
    for _ in range(100):
        v = (low + high) / 2
        low, high = (v, high) if v * ramp(v) <= length else (low, v)
    return 2.0 * ramp(low)


@pytest.mark.parametrize(
    ("length", "feed"), [(100.0, 6000.0), (5.0, 6000.0), (0.3, 6000.0), (0.004, 6000.0), (300.0, math.inf)]
)
def test_a_single_line_takes_the_optimal_time(length: float, feed: float) -> None:
    run = drive([line(ZERO, at(length), feed)], DEMO, ZERO)
    best = optimum(length, min(feed / 60.0, 400.0), 4000.0, 60_000.0)
    moved = np.flatnonzero(np.diff([0.0, *run.s]) > 0.0)
    assert (moved[-1] + 1) * PERIOD == pytest.approx(best, abs=2 * PERIOD)
    assert run.path[-1].tolist() == [length, 0.0, 0.0]


def test_finite_differences_of_a_line_keep_the_axis_limits() -> None:
    limited = AxisLimits(
        np.array([300.0, 200.0, 100.0]), np.array([4000.0, 3000.0, 1000.0]), np.array([60e3, 50e3, 9e3]), np.zeros(3)
    )
    run = drive([line(ZERO, at(80.0, 60.0, 30.0), math.inf)], limited, ZERO)
    q = np.vstack([ZERO, ZERO, ZERO, run.path])
    greatest = [np.abs(np.diff(q, k, axis=0)).max(axis=0) / PERIOD**k for k in (1, 2, 3)]
    assert (greatest[0] <= 1.005 * limited.velocity).all()
    assert (greatest[1] <= 1.005 * limited.acceleration).all()
    assert (greatest[2] <= 1.05 * limited.jerk).all()
    # one axis is driven at its limit: rapid uses what the axes have
    assert (greatest[0] / limited.velocity).max() == pytest.approx(1.0, rel=1e-3)


@pytest.mark.parametrize("radius", [1.0, 8.0, 40.0])
def test_finite_differences_of_tangential_arcs_keep_the_axis_limits(radius: float) -> None:
    limited = limits(400.0, 4000.0, 60_000.0, 0.0)
    source = Source("p", 1)
    a, b, c, e = at(0), at(20.0), at(20.0, 2 * radius), at(0.0, 2 * radius)
    arc = Arc(source, b, c, 12_000.0, c, (0, 1), np.array([20.0, radius]), radius, 180.0)
    run = drive([line(a, b, 12_000.0), arc, line(c, e, 12_000.0)], limited, ZERO)
    check_path_laws(run)
    q = np.vstack([ZERO, ZERO, ZERO, run.path])
    assert np.abs(np.diff(q, 2, axis=0)).max() / PERIOD**2 <= 1.005 * 4000.0
    third = np.abs(np.diff(q, 3, axis=0)) / PERIOD**3
    changes = np.flatnonzero(np.diff(run.record)) + 3  # the step of acceleration where the arc begins and ends
    away = np.ones(len(third), dtype=bool)
    for change in changes:
        away[max(change - 4, 0) : change + 4] = False
    assert third[away].max() <= 1.05 * 60_000.0
    assert third.max() <= 2.0 * 60_000.0
    assert run.path[-1].tolist() == e.tolist()
    # tangential: slower, never a stop
    middle = np.array(run.v)[(np.array(run.s) > 5.0) & (np.array(run.s) < run.s[-1] - 5.0)]
    assert middle.min() > 5.0


def test_the_arc_is_followed_exactly() -> None:
    source = Source("p", 1)
    start, end = at(10.0), at(0.0, 10.0, 4.0)
    helix = Arc(source, start, end, 6000.0, end, (0, 1), np.zeros(2), 10.0, 450.0)
    run = drive([helix], DEMO, start)
    q = run.path
    assert np.abs(np.hypot(q[:, 0], q[:, 1]) - 10.0).max() < 1e-9
    turned = np.unwrap(np.arctan2(q[:, 1], q[:, 0]))
    assert np.abs(q[:, 2] - 4.0 * turned / math.radians(450.0)).max() < 1e-9
    assert q[-1].tolist() == end.tolist()


def test_splitting_a_line_changes_nothing() -> None:
    whole = drive([line(ZERO, at(50.0, 20.0))], DEMO, ZERO)
    parts = [ZERO + (at(50.0, 20.0) - ZERO) * share for share in np.linspace(0.0, 1.0, 11)]
    split = drive([line(a, b) for a, b in pairwise(parts)], DEMO, ZERO)
    assert split.cycles == pytest.approx(whole.cycles, rel=0.01)
    assert np.abs(split.path[: whole.cycles - 2] - whole.path[: whole.cycles - 2]).max() < 1e-6


def test_many_tiny_segments_run_at_speed() -> None:
    x = np.arange(20_001) * 0.01
    run = drive([polyline(np.stack([x, 0 * x, 0 * x], axis=1), 6000.0)], DEMO, ZERO, keep_records=False)
    v = np.array(run.v)
    inside = (np.array(run.s) > 5.0) & (np.array(run.s) < 195.0)
    assert run.finished
    assert v[inside].min() == pytest.approx(100.0, abs=1e-3)
    assert [index for _, index in run.passed] == list(range(20_000))


def test_the_curve_of_the_trial() -> None:
    """858 mm at 150 mm/s with 2000 mm/s² and 50 000 mm/s³: 5.79 s is the bound without jerk limit."""
    t = np.linspace(0.0, 6.0 * np.pi, 4001)
    points = np.stack([50 * np.cos(t), 40 * np.sin(t), 5 * np.sin(5 * t / 3)], axis=1)
    run = drive([polyline(points, 9000.0)], limits(250.0, 2000.0, 50_000.0, 5.0), points[0], keep_records=False)
    assert run.cycles * PERIOD < 5.86
    q = run.path
    assert np.abs(np.diff(q, axis=0)).max() / PERIOD <= 250.0
    assert np.abs(np.diff(q, 2, axis=0)).max() / PERIOD**2 <= 2000.0 * 1.005


def test_feed_hold_stops_on_the_path_and_goes_on() -> None:
    blocks = [line(ZERO, at(20.0)), line(at(20.0), at(20.0, 10.0))]
    free = drive(blocks, DEMO, ZERO)
    held = drive(blocks, DEMO, ZERO, lambda cycle, _: Order(hold=60 <= cycle < 300))
    check_path_laws(held)
    assert held.v[250] == 0.0
    assert 0.0 < held.path[250][0] < 20.0
    assert held.path[-1].tolist() == free.path[-1].tolist()
    off = np.minimum(np.abs(held.path[:, 1]), np.abs(held.path[:, 0] - 20.0))
    assert off.max() < 1e-9
    assert held.cycles > free.cycles + 200


def test_override_scales_feed_but_rapid_only_down() -> None:
    blocks = [line(ZERO, at(200.0), 3000.0)]
    for override, fastest in ((0.5, 25.0), (1.0, 50.0), (2.0, 100.0), (9.0, 100.0)):
        run = drive(blocks, DEMO, ZERO, lambda *_, o=override: Order(override=o))
        assert max(run.v) == pytest.approx(fastest, rel=1e-6)
    for override, fastest in ((0.5, 200.0), (2.0, 400.0)):
        run = drive([line(ZERO, at(300.0), math.inf)], DEMO, ZERO, lambda *_, o=override: Order(override=o))
        assert max(run.v) == pytest.approx(fastest, rel=1e-6)


def test_override_zero_stops_and_goes_on() -> None:
    run = drive([line(ZERO, at(30.0))], DEMO, ZERO, lambda cycle, _: Order(override=0.0 if cycle < 500 else 1.0))
    assert run.v[499] == 0.0
    assert run.finished


def gate_program(gate: Block) -> list[Block]:
    return [line(ZERO, at(30.0)), function(8, Synch.MVS_SNS), gate, line(at(30.0), at(60.0))]


def test_a_closed_gate_is_stopped_at_exactly() -> None:
    def schedule(cycle: int, interpolator: Interpolator) -> Order:
        if interpolator.at_gate:
            assert interpolator.position.tolist() == [30.0, 0.0, 0.0]
            assert interpolator.gate == 2
        return Order(open_gates=cycle > 900)

    run = drive(gate_program(Wait(Source("p", 1))), DEMO, ZERO, schedule)
    check_path_laws(run)
    assert run.at_gate[890]
    put_out = {index: cycle for cycle, index in run.passed}
    assert put_out[0] == put_out[1] < 890
    assert run.path[put_out[1]].tolist() == [30.0, 0.0, 0.0]
    assert run.finished


def test_a_gate_opened_early_does_not_slow_down() -> None:
    free = drive([line(ZERO, at(30.0)), line(at(30.0), at(60.0))], DEMO, ZERO)
    run = drive(gate_program(Wait(Source("p", 1))), DEMO, ZERO)
    assert np.array_equal(run.path, free.path)
    assert not any(run.at_gate)


def test_a_gate_opened_while_braking_lets_the_path_go_on() -> None:
    closed = drive(gate_program(Wait(Source("p", 1))), DEMO, ZERO, lambda *_: Order(open_gates=False), most=600)
    braking = next(c for c in range(100, 600) if closed.a[c] < -1000.0)
    run = drive(
        gate_program(Wait(Source("p", 1))), DEMO, ZERO, lambda cycle, _: Order(open_gates=cycle > braking), most=3000
    )
    check_path_laws(run)
    crossing = int(np.searchsorted(np.array(run.s), 30.0))
    assert run.v[crossing] > 10.0
    assert run.finished


@pytest.mark.parametrize("gate", [Dwell(Source("p", 1), 0.5), Stop(Source("p", 1), StopKind.PROGRAM_END)])
def test_functions_in_front_of_a_gate_at_standstill_are_passed_at_once(gate: Block) -> None:
    run = drive([function(3), gate, line(ZERO, at(5.0))], DEMO, ZERO, lambda c, _: Order(open_gates=c > 10))
    assert run.passed[0] == (0, 0)
    assert run.at_gate[0]
    assert run.v[10] == 0.0
    assert run.finished


def test_a_function_before_motion_goes_out_and_the_path_moves_in_the_same_cycle() -> None:
    run = drive([function(3), line(ZERO, at(5.0))], DEMO, ZERO)
    assert run.passed[0] == (0, 0)
    assert run.v[0] > 0.0


def test_a_function_between_lines_is_passed_in_the_crossing_cycle() -> None:
    run = drive([line(ZERO, at(30.0)), function(9), line(at(30.0), at(60.0))], DEMO, ZERO)
    crossing = next(c for c, s in enumerate(run.s) if s >= 30.0)
    assert (crossing, 1) in run.passed
    assert min(run.v[crossing - 5 : crossing + 5]) > 99.0


def test_single_block_stops_at_every_block_end_and_polyline_segment() -> None:
    points = np.array([[10.0, 0, 0], [15.0, 0, 0], [20.0, 1, 0]])
    program: list[Block] = [line(ZERO, at(10.0)), BlockEnd(Source("p", 1)), polyline(points, 6000.0)]
    stops: list[list[float]] = []

    def schedule(cycle: int, interpolator: Interpolator) -> Order:
        if interpolator.at_gate:
            stops.append(interpolator.position.tolist())
            interpolator.open_gate()
        return Order(single_block=True, open_gates=False)

    run = drive(program, DEMO, ZERO, schedule)
    check_path_laws(run)
    assert stops == [[10.0, 0, 0], [15.0, 0, 0], [20.0, 1, 0]]
    assert [index for _, index in run.passed] == [0, 1, 2, 3]


def test_single_block_switched_on_late_stops_where_it_still_can() -> None:
    points = np.stack([np.arange(301) * 0.1, np.zeros(301), np.zeros(301)], axis=1)
    run = drive(
        [polyline(points, 6000.0)], DEMO, ZERO, lambda c, _: Order(single_block=c >= 200, open_gates=False), most=800
    )
    check_path_laws(run)
    assert run.at_gate[-1]
    assert run.path[-1][0] in points[:, 0]
    assert 15.0 < run.path[-1][0] < 29.0


def test_starvation_stops_smoothly_and_goes_on() -> None:
    parts = [at(float(x)) for x in range(0, 61, 5)]
    program = [line(a, b) for a, b in pairwise(parts)]
    run = drive(program, DEMO, ZERO, lambda c, _: Order(feed_queue=c == 0 or c > 600), budget=6)
    check_path_laws(run)
    assert run.starved[500]
    assert run.v[500] == 0.0
    assert run.path[500].tolist() == [15.0, 0.0, 0.0]
    assert run.finished
    assert run.path[-1].tolist() == [60.0, 0.0, 0.0]


def test_abort_brakes_on_the_path_and_a_new_path_can_begin() -> None:
    queue = MotionQueue(3)
    QueueWriter(queue, DEMO, PERIOD).write(line(ZERO, at(100.0, 50.0)))
    interpolator = Interpolator(queue, DEMO, PERIOD, ZERO)
    for cycle in range(400):
        if cycle == 150:
            assert interpolator.path_velocity > 50.0
            interpolator.abort()
        interpolator.step(override=1.0, feed_hold=False, single_block=False)
    assert interpolator.aborted
    place = interpolator.position.copy()
    assert place[1] == pytest.approx(place[0] / 2)
    queue.discard_all()
    interpolator.restart(place)
    assert not interpolator.aborted
    assert interpolator.path_position == 0.0
    QueueWriter(queue, DEMO, PERIOD).write(line(place, ZERO))
    for _ in range(3000):
        interpolator.step(override=1.0, feed_hold=False, single_block=False)
    assert interpolator.position.tolist() == [0.0, 0.0, 0.0]


def test_a_path_that_starts_elsewhere_does_not_move() -> None:
    queue = MotionQueue(3)
    QueueWriter(queue, DEMO, PERIOD).write(line(at(1.0), at(5.0)))
    interpolator = Interpolator(queue, DEMO, PERIOD, ZERO)
    for _ in range(20):
        interpolator.step(override=1.0, feed_hold=False, single_block=False)
    assert interpolator.apart
    assert interpolator.position.tolist() == [0.0, 0.0, 0.0]


def test_source_of_the_block_being_executed() -> None:
    queue = MotionQueue(3)
    writer = QueueWriter(queue, DEMO, PERIOD)
    writer.write(line(ZERO, at(10.0), number=7))
    interpolator = Interpolator(queue, DEMO, PERIOD, ZERO)
    assert (interpolator.index, interpolator.line, interpolator.n) == (-1, 0, -1)
    interpolator.step(override=1.0, feed_hold=False, single_block=False)
    assert (interpolator.index, interpolator.line, interpolator.n) == (0, 7, 7)
    assert queue.program_name(interpolator.program) == "p"
    assert interpolator.remaining == pytest.approx(10.0, abs=0.01)
    assert int(queue.record(0)["kind"]) == RecordKind.LINE


def test_rotary_axes_alone_are_measured_in_degrees() -> None:
    four = limits(400.0, 4000.0, 60_000.0, 5.0, n=4)
    a, b, c = np.zeros(4), np.array([0.0, 0, 0, 90.0]), np.array([10.0, 0, 0, 180.0])
    program = [line(a, b, 1200.0), line(b, c, 1200.0)]
    run = drive(program, four, a)
    check_path_laws(run)
    assert run.s[-1] == pytest.approx(100.0)
    assert max(np.array(run.velocities)[:, 3]) > 100.0  # the rotary axis goes along with the main axes
    assert run.path[-1].tolist() == c.tolist()
