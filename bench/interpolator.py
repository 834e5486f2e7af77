"""What the interpolator costs per cycle, and how long it takes for known curves.

Run `python -m bench.interpolator`, or call `measure()`: numbers by name, µs and s.
"""

from __future__ import annotations

import json
import math
import time
from collections.abc import Iterable

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Arc, Block, BlockEnd, Line, Polyline, Source
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState, QueueWriter
from runtime.kernels import warm_up

Floats = npt.NDArray[np.float64]

PERIOD = 0.001
DEMO = AxisLimits(np.array([400.0, 400.0, 250.0]), np.array([4000.0, 4000.0, 3000.0]), np.full(3, 6e4), np.full(3, 5.0))


def polyline(points: Floats, feed: float, most: int = 1000) -> list[Block]:
    """Points (k + 1, n) as the decoder hands them on: in runs."""
    runs: list[Block] = []
    for first in range(0, len(points) - 1, most):
        part = points[first : first + most + 1]
        k = len(part) - 1
        lines = np.arange(first, first + k)
        runs.append(Polyline("bench", part, np.full(k, feed), lines, np.full(k, -1), np.zeros(part.shape[1])))
    return runs


def surface(rows: int = 12, step: float = 0.1) -> Floats:
    """Back and forth over a wavy surface, coordinates rounded to 1 µm as CAM systems write them."""
    parts = []
    for row in range(rows):
        x = np.arange(0.0, 60.0 + step / 2, step)[:: 1 if row % 2 == 0 else -1]
        y = np.full_like(x, 0.5 * row)
        parts.append(np.stack([x, y, 3.0 * np.sin(x / 7.0) * np.cos(y / 5.0) + 0.5 * np.sin(x)], axis=1))
    points: Floats = np.round(np.vstack(parts), 3)
    return points


def plate() -> list[Block]:
    """Rapids, lines, a pocket with rounded corners and full circles: what a plate consists of."""
    blocks: list[Block] = []
    place = np.zeros(3)
    number = 0

    def go(x: float, y: float, z: float, feed: float) -> None:
        nonlocal place, number
        number += 1
        end = np.array([x, y, z])
        blocks.append(Line(Source("plate", number), place, end, feed, math.isinf(feed), end))
        blocks.append(BlockEnd(Source("plate", number)))
        place = end

    def turn(centre: tuple[float, float], angle: float, feed: float) -> None:
        nonlocal place, number
        number += 1
        offset = place[:2] - np.array(centre)
        phi = math.radians(angle)
        end = place.copy()
        end[0] = centre[0] + offset[0] * math.cos(phi) - offset[1] * math.sin(phi)
        end[1] = centre[1] + offset[0] * math.sin(phi) + offset[1] * math.cos(phi)
        radius = float(np.hypot(*offset))
        source = Source("plate", number)
        blocks.append(Arc(source, place, end, feed, end, (0, 1), np.array(centre), radius, angle))
        blocks.append(BlockEnd(source))
        place = end

    for repeat in range(6):
        x0 = 40.0 * repeat
        go(x0 + 5, 0, 5, math.inf)
        go(x0 + 5, 0, -2, 500.0)
        for depth in (-2.0, -4.0):
            go(x0 + 5, 0, depth, 500.0)
            go(x0 + 25, 0, depth, 3000.0)
            turn((x0 + 25, 5), 90.0, 3000.0)
            go(x0 + 30, 25, depth, 3000.0)
            turn((x0 + 25, 25), 90.0, 3000.0)
            go(x0 + 5, 30, depth, 3000.0)
            turn((x0 + 5, 25), 90.0, 3000.0)
            go(x0, 5, depth, 3000.0)
            turn((x0 + 5, 5), 90.0, 3000.0)
        go(x0 + 5, 0, 5, math.inf)
        go(x0 + 20, 15, 5, math.inf)
        go(x0 + 20, 15, -3, 500.0)
        turn((x0 + 15, 15), 360.0, 2000.0)
        go(x0 + 20, 15, 5, math.inf)
    return blocks


def ellipse(count: int = 4000) -> Floats:
    """The curve of three turns, 858 mm, for which other planners' times are known."""
    t = np.linspace(0.0, 6.0 * np.pi, count + 1)
    return np.stack([50.0 * np.cos(t), 40.0 * np.sin(t), 5.0 * np.sin(5.0 * t / 3.0)], axis=1)


def run(blocks: Iterable[Block], axes: AxisLimits, start: Floats) -> tuple[float, float, Floats]:
    """Part time s, path length mm, and the cost of every step in µs."""
    queue = MotionQueue(axes.n)
    writer = QueueWriter(queue, axes, PERIOD)
    interpolator = Interpolator(queue, axes, PERIOD, start)
    stream = iter(blocks)
    state = PumpState.MORE
    cost: list[float] = []
    while True:
        if state is not PumpState.FINISHED:
            state = writer.pump(stream, 5000)
        before = time.perf_counter_ns()
        interpolator.step(override=1.0, feed_hold=False, single_block=False)
        cost.append((time.perf_counter_ns() - before) / 1000.0)
        if state is PumpState.FINISHED and interpolator.standstill and interpolator.starved:
            break
    return (len(cost) - 1) * PERIOD, interpolator.path_position, np.array(cost)


def measure() -> dict[str, float]:
    """Costs of `Interpolator.step` in µs and part times in s."""
    warm_up()
    result: dict[str, float] = {}
    for name, blocks, start in (
        ("surface", polyline(surface(), 6000.0), surface()[0]),
        ("plate", plate(), np.zeros(3)),
    ):
        run(blocks, DEMO, start)
        seconds, length, cost = run(blocks, DEMO, start)
        result[f"{name}_time_s"] = seconds
        result[f"{name}_length_mm"] = round(length, 3)
        for share, label in ((50.0, "median"), (99.0, "p99"), (99.9, "p99_9"), (100.0, "max")):
            result[f"{name}_step_{label}_us"] = round(float(np.percentile(cost, share)), 2)
    for jerk in (200_000.0, 50_000.0, 20_000.0):
        axes = AxisLimits(np.full(3, 250.0), np.full(3, 2000.0), np.full(3, jerk), np.full(3, 5.0))
        for feed, label in ((9000.0, "150mm_s"), (1e6, "unlimited")):
            seconds, _, _ = run(polyline(ellipse(), feed), axes, ellipse()[0])
            result[f"ellipse_{label}_jerk_{jerk:.0f}_s"] = round(seconds, 3)
    return result


if __name__ == "__main__":
    print(json.dumps(measure(), indent=1))
