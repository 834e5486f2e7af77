"""Laws of compensated contours: the distance is kept, the offset goes back, radius 0 changes nothing, mirrors mirror.

TANDEM_CONTOURS sets how many random contours are driven; 10 000 take some minutes.
"""

from __future__ import annotations

import math
import os
from collections.abc import Sequence
from random import Random

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import (
    Approach,
    Arc,
    Block,
    CompensationSettings,
    Line,
    RadiusCompensation,
    Source,
    Stop,
    StopKind,
    ToolRadius,
)
from tests.cnc.tool_radius_comp.paths import Motion, Path, compensate
from tests.cnc.tool_radius_comp.random_contours import Edge, distances, places_of, polygon, random_contour

CONTOURS = int(os.environ.get("TANDEM_CONTOURS", "150"))
SAMPLES = 60  # places on each edge where the judge looks whether the tool can touch it


def motions(edges: Sequence[Edge]) -> list[Block]:
    """The contour as programmed: the line of an edge is its number from 1."""
    made: list[Block] = []
    for number, edge in enumerate(edges, 1):
        source, start, end = Source("p", number), np.array([*edge.start, 0.0]), np.array([*edge.end, 0.0])
        if edge.angle == 0.0:
            made.append(Line(source, start, end, 1000.0, False, end))
        else:
            centre = np.array(edge.centre)
            made.append(Arc(source, start, end, 1000.0, end, (0, 1), centre, edge.radius, edge.angle))
    return made


def compensated(contour: Sequence[Block], side: int, radius: float, settings: CompensationSettings) -> Path:
    """Between G237 G41 or G42, and G40."""
    begin, end = Source("p", 0), Source("p", 9999)
    return compensate(
        [
            ToolRadius(begin, radius),
            RadiusCompensation(begin, side, Approach.PERPENDICULAR, (0, 1), settings),
            *contour,
            RadiusCompensation(end, 0, Approach.PERPENDICULAR, (0, 1), settings),
            Stop(end, StopKind.PROGRAM_END),
        ]
    )


def on_contour(path: Path) -> list[Motion]:
    """Without the lines to and from the contour."""
    return [motion for motion in path.motions if motion.source.line not in (0, 9999)]


def fits(edges: Sequence[Edge], side: int, radius: float) -> bool:
    """Whether the tool can touch every edge, and each without a gap: the judge of shapes, with some reserve."""
    shape = polygon(edges)
    room = shape.buffer(-1.001 * radius, quad_segs=64) if side > 0 else shape.buffer(1.001 * radius, quad_segs=64)
    if room.geom_type != "Polygon" or room.is_empty or (side < 0 and len(room.interiors) > 0):
        return False
    for edge in edges:
        shares = (np.arange(SAMPLES) + 0.5) / SAMPLES
        points = np.array([edge.at(float(share)) for share in shares])
        ahead = np.array([edge.at(float(share) + 1e-6) for share in shares]) - points
        normals = np.stack([-ahead[:, 1], ahead[:, 0]], axis=1) / np.hypot(*ahead.T)[:, None]
        free = distances(edges, points + side * radius * normals) > radius - 1e-5
        there = np.flatnonzero(free)
        if not len(there) or there[-1] - there[0] + 1 != len(there):
            return False
    return True


@pytest.mark.spec("isg.trc.g40-g41-g42", "isg.trc.transitions-g25-g26", "isg.trc.violation-detection")
@pytest.mark.parametrize("part", range(5))
def test_the_tool_keeps_its_distance_wherever_it_fits(part: int) -> None:
    driven = 0
    for number in range(part, CONTOURS, 5):
        random = Random(number)
        edges = random_contour(random)
        radius, side = random.choice((0.3, 1.0, 2.0, 4.0)), random.choice((1, -1))
        settings = CompensationSettings(circular=random.random() < 0.5, stretch=random.choice((1.0, 3.0)))
        widest = radius if settings.circular else radius * math.hypot(1.0, settings.stretch)  # around outside corners
        if not fits(edges, side, radius) or not fits(edges, side, widest):
            continue
        driven += 1
        path = compensated(motions(edges), side, radius, settings)
        assert path.error is None, (number, path.error)
        touched = set()
        for motion in on_contour(path):
            places = places_of(motion)
            apart = distances(edges, places)
            assert apart.min() > radius - 1e-6, (number, motion)
            own = edges[motion.source.line - 1].distance(places)
            assert own.max() < radius + 1e-6 or not settings.circular, (number, motion)
            if own.min() < radius + 1e-6:
                touched.add(motion.source.line)
        assert touched == set(range(1, len(edges) + 1)), number
    assert driven > CONTOURS / 5 * 0.3


@pytest.mark.spec("isg.trc.violation-detection")
def test_the_tool_is_only_refused_where_it_does_not_fit() -> None:
    refused = 0
    for number in range(CONTOURS):
        random = Random(10_000 + number)
        edges, side = random_contour(random), random.choice((1, -1))
        path = compensated(motions(edges), side, 8.0, CompensationSettings())
        if path.error is not None:
            refused += 1
            assert not fits(edges, side, 8.0), number
            assert 1 <= path.error.problem.place.line <= len(edges)
    assert refused > CONTOURS / 20


def zigzag(turns: Sequence[float], lengths: Sequence[float]) -> list[Edge]:
    """An open contour of lines by turns (degrees) and lengths."""
    x = y = heading = 0.0
    edges = []
    for turn, length in zip((0.0, *turns), lengths, strict=True):
        heading += math.radians(turn)
        end = x + length * math.cos(heading), y + length * math.sin(heading)
        edges.append(Edge((x, y), end))
        x, y = end
    return edges


SHAPES = st.integers(2, 12).flatmap(
    lambda count: st.tuples(
        st.lists(st.floats(-100.0, 100.0), min_size=count - 1, max_size=count - 1),
        st.lists(st.floats(20.0, 60.0), min_size=count, max_size=count),
    )
).map(lambda drawn: zigzag(*drawn))  # fmt: skip


@pytest.mark.spec("isg.trc.g40-g41-g42")
@given(SHAPES, st.sampled_from((1, -1)), st.floats(0.1, 6.0))
def test_left_and_then_right_by_the_same_radius_returns(edges: list[Edge], side: int, radius: float) -> None:
    settings = CompensationSettings(stretch=9.0)
    forth = compensated(motions(edges), side, radius, settings)
    assert forth.error is None
    back = compensated(list(on_contour(forth)), -side, radius, settings)
    assert back.error is None
    points = [motion.end[:2] for motion in on_contour(back)]
    assert len(points) == len(edges)
    for point, edge in zip(points, edges, strict=True):
        assert point == pytest.approx(edge.end, abs=1e-6)


@pytest.mark.spec("isg.trc.g40-g41-g42")
@given(st.integers(0, 100_000), st.sampled_from((1, -1)), st.booleans())
def test_radius_0_is_the_programmed_path(seed: int, side: int, circular: bool) -> None:
    edges = random_contour(Random(seed))
    path = compensated(motions(edges), side, 0.0, CompensationSettings(circular=circular))
    assert path.error is None
    assert len(path.motions) == len(edges)
    for motion, programmed in zip(path.motions, motions(edges), strict=True):
        assert isinstance(programmed, Line | Arc)
        assert motion.end == pytest.approx(programmed.end, abs=1e-9)
        if isinstance(programmed, Arc):
            assert isinstance(motion, Arc)
            assert motion.angle == pytest.approx(programmed.angle)


@pytest.mark.spec("isg.trc.g40-g41-g42")
@given(st.integers(0, 100_000), st.sampled_from((1, -1)), st.booleans(), st.floats(0.1, 8.0))
def test_the_mirrored_contour_gives_the_mirrored_path(seed: int, side: int, circular: bool, radius: float) -> None:
    edges = random_contour(Random(seed))
    mirrored = [Edge((-e.start[0], e.start[1]), (-e.end[0], e.end[1]), -e.angle) for e in edges]
    settings = CompensationSettings(circular=circular)
    one = compensated(motions(edges), side, radius, settings)
    other = compensated(motions(mirrored), -side, radius, settings)
    assert (one.error is None) == (other.error is None)
    assert len(one.motions) == len(other.motions)
    for motion, image in zip(one.motions, other.motions, strict=True):
        assert motion.end[:2] == pytest.approx(image.end[:2] * [-1, 1], abs=1e-7)
