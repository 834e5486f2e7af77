"""What decides about part time and safety: time against the time-optimal bound, way of a feed hold, cost of the look-ahead.

The bound is TOPP-RA's: the same velocity and acceleration limits on the same curve, no jerk limit, at corners the speed that
the velocity steps of the axes allow. No planner can be faster, and a jerk limit must cost something on top.
"""

from __future__ import annotations

import time
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt
from toppra import SplineInterpolator, constraint
from toppra.algorithm import TOPPRA
from toppra.constraint import DiscretizationType

from bench.figure import Figure
from bench.stopwatch import as_in_the_cycle, distribution
from runtime.cnc.blocks import Block, ContourChange, Contouring, Line, Polyline, Polynomials, Source
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState, QueueWriter, smooth
from runtime.kernels import warm_up

Floats = npt.NDArray[np.float64]

PERIOD = 0.001
V, A, J, STEP = 250.0, 2000.0, 50_000.0, 5.0
UNLIMITED = 1000.0  # mm/s: never reached
SURFACE_LINES = 20_000
SMOOTH = 0.15  # a sharper change of direction is a corner
ZERO = np.zeros(3)


def measure() -> list[Figure]:
    """Ratios to the bound, the way of a feed hold against the shortest, cost per cycle, blocks per second."""
    warm_up()
    return [*_part_times(), _feed_hold(), *_cost(), _consumed()]


def axis_limits(n: int = 3, jerk: float = J) -> AxisLimits:
    return AxisLimits(np.full(n, V), np.full(n, A), np.full(n, jerk), np.full(n, STEP))


@dataclass
class Run:
    """`seconds` until standstill at the end; `times` (k,) ns of each cycle."""

    seconds: float
    times: npt.NDArray[np.int64]


def run(blocks: list[Block], start: Floats, axes: AxisLimits, most: int = 10**6) -> Run:
    """Drive the blocks; the preparation is never late."""
    queue = MotionQueue(axes.n)
    writer = QueueWriter(queue, axes, PERIOD)
    path = Interpolator(queue, axes, PERIOD, start)
    stream, state = iter(blocks), PumpState.MORE
    times = np.zeros(most, dtype=np.int64)
    clock = time.perf_counter_ns
    for cycle in range(most):
        if state is not PumpState.FINISHED:
            state = writer.pump(stream, 20_000)
        begin = clock()
        path.step(override=1.0, feed_hold=False, single_block=False)
        times[cycle] = clock() - begin
        if state is PumpState.FINISHED and path.standstill and path.starved:
            return Run(cycle * PERIOD, times[:cycle])
    raise RuntimeError("the path has not come to its end")


def polyline(points: Floats, feed: float) -> Polyline:
    """Straight moves between points (k + 1, n) at `feed` mm/s."""
    k = len(points) - 1
    return Polyline("bench", points, np.full(k, feed * 60.0), np.arange(k), np.full(k, -1), points[0] * 0.0)


def bound(points: Floats, feed: float, begin: float = 0.0, end: float = 0.0, *, between: bool = True) -> float:
    """Least time, s, over the curve through points (k + 1, n), its length as parameter, from speed `begin` to `end`.

    `between`: the limits are watched between the points, too; where points are close and curvature changes quickly that finds
    no solution.
    """
    scheme = DiscretizationType.Interpolation if between else DiscretizationType.Collocation
    s = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(points, axis=0), axis=1))])
    path = SplineInterpolator(s, np.column_stack([points, s]))  # the length as one more axis: its speed is the feed
    n = points.shape[1]
    most = np.array([V] * n + [feed])
    hardest = np.array([A] * n + [1e9])
    limits = [
        constraint.JointVelocityConstraint(np.stack([-most, most], axis=1)),
        constraint.JointAccelerationConstraint(np.stack([-hardest, hardest], axis=1), discretization_scheme=scheme),
    ]
    grid = np.sort(np.concatenate([s, 0.5 * (s[1:] + s[:-1])])) if between else s
    speeds = TOPPRA(limits, path, gridpoints=grid).compute_parameterization(begin, end)[1]
    if speeds is None:
        raise RuntimeError("no time-optimal parameterisation")
    return float((2.0 * np.diff(grid) / (speeds[:-1] + speeds[1:])).sum())


def bound_with_corners(points: Floats, feed: float) -> float:
    """The bounds between corners, which are passed as fast as the velocity steps of the axes allow."""
    way = np.diff(points, axis=0)
    turn = np.abs(np.diff(way / np.linalg.norm(way, axis=1)[:, None], axis=0)).max(axis=1)
    corners = np.flatnonzero(turn > SMOOTH) + 1
    ends = [0, *corners.tolist(), len(points) - 1]
    speeds = [0.0, *(STEP / turn[corners - 1]).tolist(), 0.0]
    total = 0.0
    for k in range(len(ends) - 1):
        part = points[ends[k] : ends[k + 1] + 1]
        if len(part) == 2:
            part = np.stack([part[0], part.mean(axis=0), part[1]])
        total += bound(part, feed, min(speeds[k], feed), min(speeds[k + 1], feed))
    return total


def trial_curve() -> Floats:
    """858 mm in 4000 moves, three turns."""
    t = np.linspace(0.0, 6.0 * np.pi, 4001)
    return np.stack([50.0 * np.cos(t), 40.0 * np.sin(t), 5.0 * np.sin(5.0 * t / 3.0)], axis=1)


def surface(moves: int) -> Floats:
    """The points of a finishing pass: rows of 400 moves of 0.1 mm over a wavy surface, to four decimals."""
    row, k = np.divmod(np.arange(moves), 400)
    x, y = np.where(row % 2 == 0, k, 400 - k) * 0.1, row * 0.25
    points: Floats = np.stack([x, y, 2.0 * np.sin(x / 5.0) * np.cos(y / 7.0)], axis=1).round(4)
    return points


def spiral(turns: int, pitch: float) -> Floats:
    """Corners of a square spiral whose sides grow by `pitch` mm twice in a turn."""
    sides = pitch * (1 + np.arange(4 * turns) // 2)
    way = sides[:, None] * np.array([[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [-1.0, 0.0, 0.0], [0.0, -1.0, 0.0]] * turns)
    corners: Floats = np.vstack([np.zeros(3), np.cumsum(way, axis=0)])
    return corners


def contoured(corners: Floats, feed: float, deviation: float) -> list[Block]:
    """Straight moves at `feed` mm/s with G261."""
    source = Source("bench", 1)
    moves = [Line(source, a, b, feed * 60.0, False, b) for a, b in pairwise(corners)]
    return list(smooth([ContourChange(source, Contouring(deviation=deviation)), *moves], axis_limits()))


def places(blocks: list[Block], longest: float) -> Floats:
    """Points (k, n) of smoothed moves, no further apart than `longest` mm on lines and 0.01 mm on curves."""
    found: list[Floats] = []
    for block in blocks:
        pieces: list[tuple[Floats, float]] = []
        match block:
            case Polynomials():
                pieces = [(c, 0.01) for c in block.coefficients]
            case Polyline():
                pieces = [(np.stack([a, b - a]), longest) for a, b in pairwise(block.points)]
            case Line():
                pieces = [(np.stack([block.start, block.end - block.start]), longest)]
        for c, step in pieces:
            u = np.linspace(0.0, 1.0, max(int(np.linalg.norm(c[1:].sum(axis=0)) / step), 1) + 1)[1:]
            found.append((u[:, None] ** np.arange(len(c))) @ c)
    return np.vstack([np.zeros((1, found[0].shape[1])), *found])


def _part_times() -> list[Figure]:
    curve, rows = trial_curve(), surface(SURFACE_LINES)
    blocks = contoured(spiral(5, 10.0), 100.0, 0.05)
    smoothed_bound = bound(places(blocks, 0.05)[:, :2], 100.0, between=False)
    cases: list[tuple[str, list[Block], Floats, float, float]] = [
        ("858 mm curve, 150 mm/s", [polyline(curve, 150.0)], curve[0], bound(curve, 150.0), 1.03),
        ("858 mm curve, unlimited", [polyline(curve, UNLIMITED)], curve[0], bound(curve, UNLIMITED), 1.03),
        ("finishing pass, 20 000 lines", [polyline(rows, 100.0)], rows[0], bound_with_corners(rows, 100.0), 1.05),
        ("square spiral, G261 0.05 mm, sides 10…100 mm", blocks, ZERO, smoothed_bound, 1.10),
    ]
    return [
        Figure(f"time against TOPP-RA, {name}", run(path, start, axis_limits()).seconds / least, "", limit)
        for name, path, start, least, limit in cases
    ]


def _feed_hold() -> Figure:
    """10 m/min, 2 m/s², 50 m/s³ on a straight line."""
    queue = MotionQueue(3)
    end = np.array([300.0, 0.0, 0.0])
    QueueWriter(queue, axis_limits(), PERIOD).write(Line(Source("bench", 1), ZERO, end, 10_000.0, False, end))
    path = Interpolator(queue, axis_limits(), PERIOD, ZERO)
    for _ in range(600):
        path.step(override=1.0, feed_hold=False, single_block=False)
    begin, v = path.path_position, path.path_velocity
    for _ in range(600):
        path.step(override=1.0, feed_hold=True, single_block=False)
    least = v * (v / A + A / J) / 2.0
    return Figure("way of a feed hold against the shortest", (path.path_position - begin) / least, "", 1.01)


def _cost() -> list[Figure]:
    """Eight axes, 10 000 short moves ahead."""
    t = np.linspace(0.0, 40.0, 14_001)
    points = np.stack([50.0 * np.cos(t + k) for k in range(8)], axis=1)
    with as_in_the_cycle():
        driven = run([polyline(points, 150.0)], points[0], axis_limits(8))
    windows = [driven.times[k : k + 1000] for k in range(500, len(driven.times) - 1000, 1000)]
    return distribution("cycle, 8 axes, 10 000 elements ahead", windows, 50.0)


def _consumed() -> Figure:
    """Moves of 0.005 mm at 60 mm/s: 12 000 in a second if nothing slows down."""
    x = np.arange(40_001) * 0.005
    driven = run([polyline(np.stack([x, 0.0 * x, 0.0 * x], axis=1), 60.0)], ZERO, axis_limits())
    return Figure("blocks consumed at a cycle of 1 ms", 40_000 / driven.seconds, "1/s", 10_000.0, "higher")
