"""How fast contours are compensated: blocks in, blocks of the tool path out."""

from __future__ import annotations

import math
from collections.abc import Iterable
from functools import partial

import numpy as np

from bench.figure import Figure
from bench.stopwatch import seconds
from runtime.cnc.blocks import (
    Approach,
    Arc,
    Block,
    BlockEnd,
    CompensationSettings,
    Line,
    Polyline,
    RadiusCompensation,
    Source,
    Stop,
    StopKind,
    ToolRadius,
)
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.kernels import warm_up

CORNERS = 10_000  # rounded corners: a line and an arc each
MOVES = 400_000  # of the run
RUN = 4096  # moves of one polyline
CONTOUR_LIMIT = 100_000.0  # blocks/s
RUN_LIMIT = 500_000.0


def measure() -> list[Figure]:
    """Blocks per second, inserted ones not counted."""
    warm_up()
    rows = []
    for settings, name in ((CompensationSettings(), "G25"), (CompensationSettings(circular=True), "G26")):
        contour = list(_compensated(_contour(), settings))
        sharp = list(_compensated(_sharp(), settings))
        runs = list(_compensated(_runs(), settings))
        few = list(_compensated(_contour(CORNERS // 10), settings))
        whole, part = seconds(partial(_drain, contour)), seconds(partial(_drain, few))
        rows += [
            Figure(f"lines and tangential arcs, {name}", 2 * CORNERS / whole, "blocks/s", CONTOUR_LIMIT, "higher"),
            Figure(f"ten times as many blocks take as many times longer, {name}", whole / part / 10, "times"),
            Figure(
                f"lines and arcs, every corner inside or outside, {name}",
                2 * CORNERS / seconds(partial(_drain, sharp)),
                "blocks/s",
                CONTOUR_LIMIT,
                "higher",
            ),
            Figure(
                f"runs of short lines, {name}",
                MOVES / seconds(partial(_drain, runs)),
                "blocks/s",
                RUN_LIMIT,
                "higher",
            ),
        ]
    return rows


def _drain(blocks: list[Block]) -> None:
    for _ in ToolRadiusCompensation()(blocks):
        pass


def _compensated(motions: Iterable[Block], settings: CompensationSettings) -> Iterable[Block]:
    begin = Source("bench.nc", 1)
    yield ToolRadius(begin, 2.0)
    yield RadiusCompensation(begin, 1, Approach.PERPENDICULAR, (0, 1), settings)
    yield from motions
    yield RadiusCompensation(begin, 0, Approach.PERPENDICULAR, (0, 1), settings)
    yield Stop(begin, StopKind.PROGRAM_END)


def _contour(corners: int = CORNERS) -> Iterable[Block]:
    """A staircase whose steps are rounded alternately to both sides."""
    x = y = 0.0
    for corner in range(corners):
        source = Source("bench.nc", corner + 2)
        up = corner % 2 == 0
        dx, dy = (10.0, 0.0) if up else (0.0, 10.0)
        yield from _line(source, x, y, x + dx, y + dy)
        x, y = x + dx, y + dy
        centre = (x, y + 4.0) if up else (x + 4.0, y)
        yield from _arc(source, x, y, x + 4.0, y + 4.0, centre, 90.0 if up else -90.0)
        x, y = x + 4.0, y + 4.0


def _sharp(corners: int = CORNERS) -> Iterable[Block]:
    """Lines with half circles on them: every other corner is an inside one."""
    x = 0.0
    for corner in range(corners):
        source = Source("bench.nc", corner + 2)
        yield from _line(source, x, 0.0, x + 10.0, 0.0)
        side = 1.0 if corner % 2 else -1.0
        angle = -120.0 * side
        half = 10.0 * math.sin(math.radians(60.0))
        centre = (x + 10.0 + half, -5.0 * side)
        yield from _arc(source, x + 10.0, 0.0, x + 10.0 + 2 * half, 0.0, centre, angle)
        x += 10.0 + 2 * half


def _runs() -> Iterable[Block]:
    angle = np.linspace(0.0, 200.0 * math.pi, MOVES + 1)
    radius = 50.0 + 5.0 * np.sin(7.3 * angle) + 0.05 * angle
    points = np.stack([radius * np.cos(angle), radius * np.sin(angle), np.zeros(MOVES + 1)], axis=1)
    for first in range(0, MOVES, RUN):
        behind = min(first + RUN, MOVES)
        count = behind - first
        yield Polyline(
            "bench.nc", points[first : behind + 1], np.full(count, 2000.0), np.arange(first, behind), np.full(count, -1),
            np.zeros(3), None, (0, 1),
        )  # fmt: skip


def _line(source: Source, x: float, y: float, u: float, v: float) -> Iterable[Block]:
    end = np.array([u, v, 0.0])
    yield Line(source, np.array([x, y, 0.0]), end, 2000.0, False, end)
    yield BlockEnd(source)


def _arc(
    source: Source, x: float, y: float, u: float, v: float, centre: tuple[float, float], angle: float
) -> Iterable[Block]:
    end = np.array([u, v, 0.0])
    radius = math.dist((x, y), centre)
    yield Arc(source, np.array([x, y, 0.0]), end, 2000.0, end, (0, 1), np.array(centre), radius, angle)
    yield BlockEnd(source)
