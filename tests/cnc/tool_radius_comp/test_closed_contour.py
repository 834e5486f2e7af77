"""G238: a closed contour is entered and left at the corner where it closes."""

from __future__ import annotations

import math
from itertools import pairwise
from random import Random

import numpy as np
import pytest
from shapely.geometry import Polygon

from runtime.cnc.blocks import Approach, TechnologyFunction
from runtime.diagnostics.catalogue import radius as catalogue
from tests.cnc.decoder.programs import decode
from tests.cnc.tool_radius_comp.paths import Path, motions_of, tool_path
from tests.cnc.tool_radius_comp.random_contours import Edge, distances, places_of

G238 = pytest.mark.spec("isg.trc.inside-corner-g238", "isg.trc.selection-modes")
STAR = [(0, 100), (-20, 20), (-100, 0), (-20, -20), (0, -100), (20, -20), (100, 0), (20, 20), (0, 100)]
SQUARE = "X40\nY40\nX0\nY0\n"


def star(radius: float, setup: str = "G238") -> Path:
    lines = "\n".join(f"X{x} Y{y}" for x, y in STAR[1:])
    return tool_path(f"G00 X0 Y0\n{setup} G41\nG01 X0 Y100\n{lines}\nG40\nG00 X0 Y0\nM30", radius=radius)


def square(begin: str = "X20 Y20", contour: str = SQUARE, end: str = "X20 Y20", side: str = "G41") -> Path:
    return tool_path(f"G00 {begin} G162\nG238 {side}\nG01 X0 Y0\n{contour}G40\n{end}\nM30")


@G238
@pytest.mark.parametrize("radius", [1.0, 5.0, 10.0])
def test_the_star_is_entered_in_its_tip(radius: float) -> None:
    """The corner lies on the axis of the tip, where both its edges are one radius away."""
    path = star(radius)
    assert path.error is None
    tip = 100.0 - radius / math.sin(math.atan2(20, 80))
    assert path.of(3) == [pytest.approx((0.0, tip), abs=1e-6)]
    assert path.of(11) == [pytest.approx((0.0, tip), abs=1e-6)]
    assert path.shape[-1] == (13, 0, 0)
    edges = [Edge(a, b) for a, b in pairwise(STAR)]
    for motion in path.motions[2:-1]:
        assert distances(edges, places_of(motion)).min() > radius - 1e-6
    inner = Polygon([motion.end[:2] for motion in path.motions[1:-1]])
    assert inner.symmetric_difference(Polygon(STAR).buffer(-radius, join_style="mitre")).area < 1.0 + radius**2


@G238
def test_lines_and_arcs_close_in_an_inside_corner() -> None:
    path = square(contour="X40\nG03 X0 Y40 I-40\nG01 Y0\n")
    assert path.error is None
    assert path.of(3) == [(5, 5)]
    assert path.of(6) == [(5, 5)]


@G238
def test_two_arcs_close_where_their_offsets_meet() -> None:
    """A lens of two arcs of radius 30 about (-10, 30) and (30, 30): its tips are where they meet."""
    low = 30 - math.sqrt(30**2 - 20**2)
    path = tool_path(
        f"G161 G00 X10 Y30\nG238 G41\nG01 X10 Y{low:.12f}\nG03 X10 Y{60 - low:.12f} I-10 J30\n"
        f"G03 X10 Y{low:.12f} I30 J30\nG40\nG01 X10 Y30\nM30",
        radius=4.0,
    )
    assert path.error is None
    tip = 30 - math.sqrt(26**2 - 20**2)
    assert path.of(3) == [pytest.approx((10.0, tip), abs=1e-6)]
    assert path.of(5)[0][:2] == pytest.approx((10.0, tip), abs=1e-6)


@G238
def test_it_goes_right_of_the_contour_too() -> None:
    path = square(contour="Y40\nX40\nY0\nX0\n", side="G42")
    assert path.error is None
    assert path.of(3) == path.of(7) == [(5, 5)]


@G238
def test_an_outside_corner_is_entered_and_left_directly() -> None:
    """The contour of a post, from outside: last and first element turn away from the tool."""
    path = square("X-20 Y20", "X40\nY-40\nX0\nY0\n", "X-20 Y-20")
    assert path.error is None
    assert path.of(3) == [(0, 5)]
    assert path.of(7)[-1] == (-5, 0)
    assert path.shape[-1] == (9, -20, -20)


@G238
def test_functions_and_other_axes_keep_their_place() -> None:
    path = tool_path("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nM10\nX40\nZ-3\nY40\nM11\nX0\nY0\nG40\nM12\nZ5\nX20 Y20\nM30")
    assert path.error is None
    order: list[str | int] = []
    for block in path.blocks:
        order += [f"M{block.number}"] if isinstance(block, TechnologyFunction) else []
        order += [motion.source.line for motion in motions_of([block])]
    assert order == [1, 3, "M10", 5, 6, 7, "M11", 9, 10, "M12", 13, 14]
    assert path.of(13) == [(5, 5)]  # Z moves in the corner
    assert path.motions[-1].end[2] == 5


@G238
def test_without_a_contour_the_approach_is_driven_as_programmed() -> None:
    path = tool_path("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nM10\nZ4\nG40\nX40\nM30")
    assert path.shape == [(1, 20, 20), (3, 0, 0), (5, 0, 0), (7, 40, 0)]
    assert [block.number for block in path.blocks if isinstance(block, TechnologyFunction)] == [10]


@G238
def test_settings_change_where_they_are_programmed() -> None:
    tooth = "X40\nY20\n{g26}X30\nX40 Y24\nY40\nX0\nY0\n"
    path, around = square(contour=tooth.format(g26="")), square(contour=tooth.format(g26="G26 "))
    assert path.error is None
    assert around.error is None
    assert [shape[0] for shape in around.shape if len(shape) == 7] == [6]
    assert all(len(shape) == 3 for shape in path.shape)


@G238
def test_another_strategy_may_be_chosen_for_the_end() -> None:
    path = square(contour=SQUARE + "G138 ", end="X-20 Y20")
    assert path.error is None
    assert path.of(3) == [(5, 5)]
    assert path.of(7) == [(5, 0)]


@G238
@pytest.mark.parametrize(
    ("program", "why", "line"),
    [
        ("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nX40\nY40\nX0\nY1\nG40\nX20 Y20\nM30", "does not end where", 3),
        ("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nX40\nY40\nX0 Y0\nG03 J40\nG40\nG01 X20 Y20\nM30", "full circle", 3),
        ("G00 X20 Y20\nG238 G41\nG02 X0 Y0 J-20\nG01 X40\nY40\nX0\nY0\nG40\nX20 Y20\nM30", "approach is an arc", 3),
        ("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nX40\nY40\nX0\nY0\nG40\nG02 X20 Y20 I20\nM30", "exit is an arc", 9),
        ("G00 X20 Y4\nG238 G41\nG01 X0 Y0\nX40\nY40\nX0\nY0\nG40\nX20 Y20\nM30", "nearer to it than the radius", 3),
        ("G00 X60 Y20\nG238 G41\nG01 X0 Y0\nX40\nY40\nX0\nY0\nG40\nX20 Y20\nM30", "crosses it", 3),
        ("G00 X80 Y20\nG238 G41\nG01 X0 Y0\nX40\nG03 Y40 J20\nG01 X0\nY0\nG40\nX20 Y20\nM30", "crosses it", 3),
        ("G00 X20 Y20\nG238 G42\nG01 X0 Y0\nX40\nY40\nX0\nY0\nG40\nX20 Y20\nM30", "turns away", 3),
        ("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nX40\nG42 Y40\nX0\nY0\nG40\nX20 Y20\nM30", "side or the radius", 5),
        ("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nX40\nV.G.WZ_AKT.R=3\nY40\nX0\nY0\nG40\nX20 Y20\nM30", "radius changes", 5),
        ("G00 X20 Y20\nG238 G41\nG01 X0 Y0\nX40\nY40\nX0\nY0\nM30", "without G40", 8),
    ],
)
def test_restrictions(program: str, why: str, line: int) -> None:
    path = tool_path(program.replace("G00", "G162 G00", 1))
    assert path.error is not None
    problem = path.error.problem
    assert problem.entry is catalogue.INSIDE_CORNER
    assert why in problem.text
    assert problem.place.line == line
    if line != 9:  # nothing of the contour is driven
        assert [shape[0] for shape in path.shape] == [1]


@G238
def test_the_contour_is_bounded() -> None:
    lines = "\n".join(f"X{40 + n % 2}" for n in range(20_100))
    path = tool_path(f"G00 X20 Y20\nG238 G41\nG01 X0 Y0\n{lines}\nG40\nX20 Y20\nM30")
    assert path.error is not None
    assert "20000 blocks" in path.error.problem.text


@G238
def test_g238_is_not_chosen_while_compensation_is_active() -> None:
    for text in ("G41\nG238\nG01 X10\n", "G41 G01 X10\nX20\nG238\n", "G41 G01 X10\nX20\nG238 G40\n"):
        run = decode(f"F1000 G00 X-10\n{text}M30")
        assert run.problem is not None, text
        assert run.problem.entry is catalogue.INSIDE_CORNER_LATE
    assert decode("F1000 G238 G41 G01 X10\nM30").decoder.modal.approach is Approach.INSIDE_CORNER


@G238
def test_entered_anew_behind_an_unfinished_exit() -> None:
    path = square(contour=SQUARE + "G40\nG41\n")
    assert path.error is not None
    assert "not free" in path.error.problem.text


@G238
@pytest.mark.parametrize("seed", range(20))
def test_polygons_keep_the_distance(seed: int) -> None:
    """Convex polygons, entered from their middle: the path is the smaller polygon, whatever the corner."""
    random = Random(seed)
    angles = sorted(random.sample(range(0, 360, 30), 5))
    if max(b - a for a, b in pairwise([*angles, angles[0] + 360])) > 150:
        angles = [0, 90, 150, 210, 300]
    points = [(50 * math.cos(math.radians(a)), 50 * math.sin(math.radians(a))) for a in angles]
    contour = "".join(f"X{x:.9f} Y{y:.9f}\n" for x, y in [*points[1:], points[0]])
    approach = f"G01 X{points[0][0]:.9f} Y{points[0][1]:.9f}"
    path = tool_path(f"G00 X0 Y0\nG238 G41\n{approach}\n{contour}G40\nX0 Y0\nM30", radius=2.0)
    assert path.error is None
    driven = Polygon([motion.end[:2] for motion in path.motions[1:-1]])
    assert driven.symmetric_difference(Polygon(points).buffer(-2.0, join_style="mitre")).area < 1e-5
    assert np.allclose(path.motions[1].end[:2], path.motions[-1].start[:2])
