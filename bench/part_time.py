"""How long a known curve takes: three turns of 858 mm, limits of 250 mm/s and 2000 mm/s² per axis, in 4000 straight moves.

With the same velocity and acceleration limits and no jerk limit the time-optimal parameterisation needs 5.79 s at 150 mm/s, and
3.29 s with unlimited feed: no planner can be faster, and jerk limits must cost something on top.
"""

from __future__ import annotations

import numpy as np

from bench.figure import Figure
from runtime.cnc.blocks import Polyline
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState, QueueWriter
from runtime.kernels import warm_up

PERIOD = 0.001
MOVES = 4000
BOUND = {150.0: 5.79, 1000.0: 3.29}  # feed mm/s (1000: never reached) -> s


def measure() -> list[Figure]:
    """Part times, s, and their ratio to the bound."""
    warm_up()
    figures = []
    for jerk in (200_000.0, 50_000.0, 20_000.0):
        axes = AxisLimits(np.full(3, 250.0), np.full(3, 2000.0), np.full(3, jerk), np.full(3, 5.0))
        for feed, bound in BOUND.items():
            seconds = _run(feed, axes)
            name = f"{'150 mm/s' if feed == 150.0 else 'unlimited'}, jerk {jerk / 1000:.0f} m/s³"
            figures.append(Figure(f"part time, {name}", seconds, "s"))
            figures.append(Figure(f"against the bound, {name}", seconds / bound, ""))
    return figures


def _run(feed: float, axes: AxisLimits) -> float:
    t = np.linspace(0.0, 6.0 * np.pi, MOVES + 1)
    points = np.stack([50.0 * np.cos(t), 40.0 * np.sin(t), 5.0 * np.sin(5.0 * t / 3.0)], axis=1)
    lines = np.arange(MOVES)
    curve = Polyline("bench", points, np.full(MOVES, feed * 60.0), lines, np.full(MOVES, -1), np.zeros(3))
    queue = MotionQueue(axes.n)
    writer = QueueWriter(queue, axes, PERIOD)
    path = Interpolator(queue, axes, PERIOD, points[0])
    blocks, state, cycles = iter([curve]), PumpState.MORE, 0
    while True:
        if state is not PumpState.FINISHED:
            state = writer.pump(blocks, 5000)
        path.step(override=1.0, feed_hold=False, single_block=False)
        if state is PumpState.FINISHED and path.standstill and path.starved:
            return cycles * PERIOD
        cycles += 1
