"""Programs through decoder and smoothing, and a judge that knows nothing of how they are smoothed: dense sampling."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Arc, Block, Line, Polyline, Polynomials
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation import SpatialArcs, smooth
from runtime.diagnostics.errors import Problem
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.interpolator.driving import limits

Floats = npt.NDArray[np.float64]
MAIN = 3
ARC_STEPS = 400


@dataclass(frozen=True)
class Smoothed:
    """The blocks of a program before and after smoothing."""

    programmed: list[Block]
    blocks: list[Block]
    warnings: list[Problem]

    @property
    def motions(self) -> list[Block]:
        return [block for block in self.blocks if isinstance(block, Line | Arc | Polyline | Polynomials)]

    @property
    def curves(self) -> list[Floats]:
        """Coefficients (6, n) of all polynomials that are no lines."""
        runs = [block.coefficients for block in self.blocks if isinstance(block, Polynomials)]
        return [c for run in runs for c in run if np.abs(c[2:]).max() > 0.0]


def smoothed(
    text: str, setup: DecoderSetup = SETUP, axes: AxisLimits | None = None, start: Sequence[float] = ()
) -> Smoothed:
    """Decode and smooth a program; an error of the decoder is raised."""
    n = len(setup.axes)
    run = decode(text, setup, start=tuple(start) or (0.0,) * n)
    assert run.problem is None, run.problem
    warnings: list[Problem] = []
    chosen = axes or limits(250.0, 2000.0, 50_000.0, 0.0, n)
    blocks = list(smooth(SpatialArcs()(iter(run.blocks)), chosen, warnings))
    return Smoothed(list(SpatialArcs()(iter(run.blocks))), blocks, warnings)


def places(block: Block, steps: int = 40) -> Floats:
    """Places of a motion, its start included, (m, n)."""
    if isinstance(block, Line):
        return np.linspace(block.start, block.end, steps + 1)
    if isinstance(block, Polyline):
        parts = [np.linspace(a, b, steps + 1) for a, b in pairwise(block.points)]
        return np.vstack(parts)
    if isinstance(block, Polynomials):
        powers = np.linspace(0.0, 1.0, steps + 1)[:, None] ** np.arange(6)
        return np.vstack([powers @ c for c in block.coefficients])
    assert isinstance(block, Arc)
    return _arc(block, steps)


def _arc(arc: Arc, steps: int) -> Floats:
    share = np.linspace(0.0, 1.0, steps + 1)
    made: Floats = np.linspace(arc.start, arc.end, steps + 1)
    first, second = arc.plane
    x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
    turn = np.radians(arc.angle) * share
    made[:, first] = arc.centre[0] + x * np.cos(turn) - y * np.sin(turn)
    made[:, second] = arc.centre[1] + x * np.sin(turn) + y * np.cos(turn)
    return made


def corners_of(blocks: Sequence[Block]) -> Floats:
    """The path as a polygon: ends of lines, ARC_STEPS chords of every arc and polynomial; (m, n)."""
    parts = []
    for block in blocks:
        if isinstance(block, Line):
            parts.append(np.vstack([block.start, block.end]))
        elif isinstance(block, Polyline):
            parts.append(block.points)
        elif isinstance(block, Arc | Polynomials):
            parts.append(places(block, ARC_STEPS))
    return np.vstack(parts)


def distances(points: Floats, polygon: Floats) -> Floats:
    """Distance of each point from a polygon, in the main axes."""
    parts = max(1, len(points) * len(polygon) // 4_000_000)
    return np.concatenate([_distances(part, polygon) for part in np.array_split(points, min(parts, len(points)))])


def _distances(points: Floats, polygon: Floats) -> Floats:
    p, a, b = points[:, None, :MAIN], polygon[None, :-1, :MAIN], polygon[None, 1:, :MAIN]
    way = b - a
    square = (way**2).sum(axis=2)
    with np.errstate(divide="ignore", invalid="ignore"):
        share = np.where(square > 0.0, ((p - a) * way).sum(axis=2) / square, 0.0)
    near = a + np.clip(share, 0.0, 1.0)[..., None] * way
    found: Floats = np.sqrt(((p - near) ** 2).sum(axis=2)).min(axis=1)
    return found


def deviation(program: Smoothed) -> float:
    """Greatest distance between programmed and smoothed path, in both directions."""
    before = [block for block in program.programmed if isinstance(block, Line | Arc | Polyline)]
    path = np.vstack([places(block) for block in program.motions])
    there = float(distances(path, corners_of(before)).max())
    ends = np.vstack([places(block, 1) for block in before])
    back = float(distances(ends, np.vstack([places(block, 100) for block in program.motions])).max())
    return max(there, back)


def ends_meet(blocks: Sequence[Block]) -> float:
    """Greatest gap between the end of a motion and the start of the next, any axis."""
    gap = 0.0
    before: Floats | None = None
    for block in blocks:
        if isinstance(block, Polynomials):
            inside = np.abs(block.coefficients[1:, 0] - block.ends[:-1])
            gap = max(gap, float(inside.max()) if inside.size else 0.0)
        if isinstance(block, Line | Arc | Polyline | Polynomials):
            here = places(block, 1)
            if before is not None:
                gap = max(gap, float(np.abs(here[0] - before).max()))
            before = here[-1]
    return gap


@dataclass(frozen=True)
class Joint:
    """Where two elements meet: the place, change of direction and of curvature in the main axes."""

    place: Floats
    turn: float
    bend: float


def joints(blocks: Sequence[Block]) -> list[Joint]:
    """All joints between elements with length."""
    ends = [pair for block in blocks for pair in _borders(block)]
    made = []
    for (_, last), (first, _) in pairwise(ends):
        turn = float(np.linalg.norm(first[1] - last[1]))
        made.append(Joint(first[0], turn, float(np.linalg.norm(first[2] - last[2]))))
    return made


Border = tuple[Floats, Floats, Floats]


def _borders(block: Block) -> list[tuple[Border, Border]]:
    """Place, direction and curvature at both ends of each element."""
    if isinstance(block, Polynomials):
        return [(_state(c, 0.0), _state(c, 1.0)) for c in block.coefficients if np.abs(c[1:]).max() > 1e-9]
    if isinstance(block, Line | Polyline):
        points = block.points if isinstance(block, Polyline) else np.vstack([block.start, block.end])
        lines = []
        for a, b in pairwise(points):
            if np.linalg.norm((b - a)[:MAIN]) > 1e-9:
                direction = (b - a)[:MAIN] / np.linalg.norm((b - a)[:MAIN])
                lines.append(((a, direction, np.zeros(MAIN)), (b, direction, np.zeros(MAIN))))
        return lines
    if isinstance(block, Arc):
        return [(_arc_state(block, 0.0), _arc_state(block, 1.0))]
    return []


def _arc_state(arc: Arc, share: float) -> Border:
    """From the formula of the circle: differences of places would drown in rounding where little is left of an arc."""
    place = arc.start + share * (arc.end - arc.start)
    first, second = arc.plane
    angle = math.radians(arc.angle)
    x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
    x, y = (
        x * math.cos(angle * share) - y * math.sin(angle * share),
        x * math.sin(angle * share) + y * math.cos(angle * share),
    )
    place[first], place[second] = arc.centre[0] + x, arc.centre[1] + y
    velocity, acceleration = arc.end - arc.start, np.zeros(len(place))
    velocity[first], velocity[second] = -angle * y, angle * x
    acceleration[first], acceleration[second] = -(angle**2) * x, -(angle**2) * y
    speed = float(np.linalg.norm(velocity[:MAIN]))
    return place, velocity[:MAIN] / speed, acceleration[:MAIN] / speed**2


def _state(c: Floats, u: float) -> Border:
    derivatives = []
    for order in range(3):
        factors = np.array([math.perm(p, order) * (u ** (p - order) if p >= order else 0.0) for p in range(6)])
        derivatives.append((factors @ c)[:MAIN])
    speed = float(np.linalg.norm(derivatives[1]))
    direction = derivatives[1] / speed
    along = derivatives[2] @ direction
    return derivatives[0], direction, (derivatives[2] - along * direction) / speed**2
