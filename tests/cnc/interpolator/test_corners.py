"""Corners in which the axes jump: the path brakes up to them and speeds up from them on without standing still in between."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt
import pytest

from runtime.cnc.blocks import Block, Line, Polyline, Source
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.interpolator.prediction import stretch_time
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import QueueWriter
from tests.cnc.interpolator.driving import PERIOD, Drive, Order, Schedule, always, check_path_laws, drive, limits

Floats = npt.NDArray[np.float64]

V, A, J, STEP = 250.0, 2000.0, 50_000.0, 5.0
LIMITS = limits(V, A, J, STEP)
ALLOWED = (8.0 * J * STEP) ** 0.5  # mm/s²: an axis catches up with such a jump while it lags by no more than STEP
ZIGZAG = np.array([[0.0, 0, 0], [8, 0, 0], [8.1, 0.25, 0], [0, 0.25, 0], [0, 0.5, 0], [8, 0.5, 0], [2, 0.5, 0]])


def lines(points: Floats, feed: float = 6000.0) -> list[Block]:
    return [
        Line(Source("p", k + 1), points[k], points[k + 1], feed, False, points[k + 1]) for k in range(len(points) - 1)
    ]


def driven(points: Floats, schedule: Schedule = always) -> Drive:
    run = drive(lines(points), LIMITS, points[0], schedule)
    assert run.finished
    check_path_laws(run)
    assert run.path[-1].tolist() == points[-1].tolist()
    return run


def jumps(points: Floats, step: float = STEP) -> list[float]:
    queue = MotionQueue(3)
    writer = QueueWriter(queue, limits(V, A, J, step), PERIOD)
    for block in lines(points):
        assert writer.write(block)
    return [float(queue.record(k)["a_entry"]) for k in range(queue.written)]


def test_what_may_jump_in_a_corner() -> None:
    right_angle = np.array([[0.0, 0, 0], [5, 0, 0], [5, 5, 0]])
    assert jumps(right_angle) == pytest.approx([0.0, ALLOWED])
    reversal = np.array([[0.0, 0, 0], [5, 0, 0], [0, 0, 0]])
    assert jumps(reversal) == pytest.approx([0.0, ALLOWED])  # braking and speeding up pull in the same sense
    half = np.array([[0.0, 0, 0], [5, 0, 0], [7.5, 2.5 * 3**0.5, 0]])
    assert jumps(half) == pytest.approx([0.0, ALLOWED / 1.5])  # X goes on: 1 and 1/2
    assert jumps(right_angle, step=0.0) == [0.0, 0.0]
    assert jumps(np.array([[0.0, 0, 0], [5, 0, 0], [10, 0.5, 0]])) == [0.0, 0.0]  # it may stand for a curve


def test_a_corner_is_left_as_it_is_come_to() -> None:
    run = driven(ZIGZAG)
    assert run.refused <= 10
    first = run.record.index(1)
    assert run.a[first - 1] < -500.0
    assert run.a[first] > 200.0
    ways = np.linalg.norm(np.diff(ZIGZAG, axis=0), axis=1)
    corners = [0.0, *(float(run.elements[k]["v_entry"]) for k in range(1, len(ways))), 0.0]
    without = sum(
        stretch_time(way, v0, v1, 100.0, A, J) for way, v0, v1 in zip(ways, corners[:-1], corners[1:], strict=True)
    )
    assert run.cycles * PERIOD < without - 0.01 * (len(ways) - 1)


def test_the_axes_jump_by_what_they_may_and_no_more() -> None:
    run = driven(ZIGZAG)
    velocity = np.diff(np.vstack([ZIGZAG[0], run.path]), axis=0) / PERIOD
    assert np.abs(np.diff(velocity, axis=0)).max() <= STEP + A * PERIOD + 1e-6


def test_feed_hold_wherever_the_path_is_near_a_corner() -> None:
    at = driven(ZIGZAG).record.index(1)
    for begin in range(at - 24, at + 48, 6):

        def schedule(cycle: int, _: Interpolator, begin: int = begin) -> Order:
            return Order(hold=begin <= cycle < begin + 120)

        run = driven(ZIGZAG, schedule)
        assert 0.0 in run.v[begin : begin + 120]
        assert run.cycles > at + 120


def test_a_zigzag_of_short_lines() -> None:
    x = np.arange(0.0, 4.05, 0.1)
    rows = [np.stack([x if k % 2 == 0 else x[::-1], np.full(len(x), 0.2 * k), 0.0 * x], axis=1) for k in range(4)]
    points = np.vstack(rows)
    k = len(points) - 1
    block = Polyline("p", points, np.full(k, 6000.0), np.arange(k), np.full(k, -1), np.zeros(3))
    run = drive([block], LIMITS, points[0], lambda cycle, _: Order(override=(1.0, 0.3, 2.0)[cycle // 40 % 3]))
    assert run.finished
    check_path_laws(run)
    assert run.path[-1].tolist() == points[-1].tolist()
