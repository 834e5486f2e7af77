"""Runs of short lines with G26: where they turn hardly they stay runs, and the tool keeps its distance."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Polyline
from runtime.cnc.tool_radius_comp.corners import PEAK
from tests.cnc.tool_radius_comp.paths import Path, tool_path
from tests.cnc.tool_radius_comp.random_contours import Edge, distances, places_of

G26 = pytest.mark.spec("isg.trc.transitions-g25-g26")


def curve(turn: float, radius: float, lines: int = 40, side: str = "G42") -> tuple[Path, list[Edge]]:
    """Lines of 0.05 mm that turn left by `turn` degrees each, the tool on their right."""
    points, heading = [(0.0, 0.0)], 0.0
    for _ in range(lines):
        x, y = points[-1]
        points.append((x + 0.05 * math.cos(heading), y + 0.05 * math.sin(heading)))
        heading += math.radians(turn)
    contour = "".join(f"X{x:.12f} Y{y:.12f}\n" for x, y in points[1:])
    path = tool_path(f"G00 X0 Y0\nG26 G237 {side}\nG01\n{contour}G40\nM30", radius=radius)
    assert path.error is None
    return path, [Edge(a, b) for a, b in pairwise(points)]


@G26
def test_a_fine_curve_stays_a_run() -> None:
    path, _ = curve(0.03, 5.0, lines=500)
    assert not any(isinstance(block, Arc) for block in path.blocks)
    moves = [len(block.feeds) for block in path.blocks if isinstance(block, Polyline)]
    assert sum(moves) > 490
    assert len(moves) < 10


@G26
@pytest.mark.parametrize(
    ("share", "inserted", "arcs"),
    [(0.99, 0, 0), (1.01, 39, 0), (1.99, 39, 0), (2.01, 78, 0), (3.01, 117, 0), (3.99, 117, 0), (4.01, 39, 39)],
)
def test_only_what_is_hardly_a_corner_gets_no_arc(share: float, inserted: int, arcs: int) -> None:
    """A vertex bridges a turn up to where r · (1 / cos(turn / 2) − 1) = PEAK; up to four take the place of an arc."""
    limit = math.degrees(2 * math.acos(5.0 / (5.0 + PEAK)))
    path, _ = curve(share * limit, 5.0)
    assert sum(isinstance(block, Arc) for block in path.blocks) == arcs
    assert len([motion for motion in path.motions if 4 <= motion.source.line < 44]) == 40 + inserted


@G26
@given(st.floats(1e-5, 0.5), st.floats(0.1, 30.0))
def test_the_distance_is_kept_however_little_it_turns(turn: float, radius: float) -> None:
    path, edges = curve(turn, radius, lines=12)
    contour = [motion for motion in path.motions if 4 <= motion.source.line < 16]
    places = np.concatenate([places_of(motion) for motion in contour])
    apart = distances(edges, places)
    assert apart.min() > radius - 1e-9
    assert apart.max() < radius + 1e-6
    assert len(contour) >= len(edges)
