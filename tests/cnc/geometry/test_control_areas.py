"""Work and protection spaces against places on the path, one by one."""

from __future__ import annotations

import math

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.geometry.control_areas import (
    CHORD_ERROR,
    EDGE,
    ControlArea,
    Disc,
    Floats,
    Polygon,
    circle_points,
    polynomial_points,
)

# an L: the square from 0 to 10 without the one from 5 to 10
L_SHAPE = Polygon(np.array([(0, 0), (10, 0), (10, 5), (5, 5), (5, 10), (0, 10)], dtype=float))
DISC = Disc(np.array([5.0, 5.0]), 4.0)
places = st.tuples(*[st.integers(-4, 14).map(float)] * 3)
AXES = (0, 1, 2)


def in_l(x: float, y: float) -> bool:
    return (0 < x < 10 and 0 < y < 5) or (0 < x < 5 and 0 < y < 10)


@given(st.floats(-5, 15), st.floats(-5, 15))
def test_the_depth_of_a_polygon_tells_inside_from_outside(x: float, y: float) -> None:
    (depth,) = L_SHAPE.depth(np.array([[x, y]]))
    if abs(depth) > 1e-9:
        assert (depth > 0) == in_l(x, y)


def test_depths() -> None:
    points = np.array([(2, 2), (5, 5), (12, 2), (6, 6), (-3, -4), (2.5, 9)], dtype=float)
    np.testing.assert_allclose(L_SHAPE.depth(points), [2, 0, -2, -1, -5, 1])
    np.testing.assert_allclose(DISC.depth(np.array([(5.0, 5.0), (5.0, 10.0)])), [4, -1])


@given(places, places, st.booleans(), st.sampled_from([L_SHAPE, DISC]))
def test_a_line_is_permitted_if_all_its_places_are(
    start: tuple[float, ...], end: tuple[float, ...], work: bool, contour: Polygon | Disc
) -> None:
    """Looked at in 4000 places: whoever finds one that is clearly wrong was told, and who finds none was not."""
    area = ControlArea(1, work, AXES, contour, 0.0, 3.0)
    points = np.array([start, end])
    told = area.first_violation(points) == 0
    way = points[0] + np.linspace(0, 1, 4001)[:, None] * (points[1] - points[0])
    inside = np.minimum(contour.depth(way[:, :2]), np.minimum(way[:, 2], 3.0 - way[:, 2]))
    wrong = float((-inside if work else inside).max())
    if wrong > 3 * EDGE:
        assert told
    elif wrong < 0.5 * EDGE:
        assert not told


def test_a_line_through_a_corner_of_a_wide_space_is_found() -> None:
    """Both ends are permitted, and the way between them leads over what the L leaves out."""
    work = ControlArea(1, True, AXES, L_SHAPE, -1.0, 1.0)
    assert work.first_violation(np.array([(2, 9, 0), (9, 2, 0)], dtype=float)) == 0
    assert work.first_violation(np.array([(2, 9, 0), (2, 2, 0), (9, 2, 0)], dtype=float)) == -1
    protected = ControlArea(1, False, AXES, L_SHAPE, -1.0, 1.0)
    assert protected.first_violation(np.array([(20, 2, 0), (-20, 2, 0)], dtype=float)) == 0
    assert protected.first_violation(np.array([(20, 2, 2), (-20, 2, 2), (0, 0, 1)], dtype=float)) == -1
    assert protected.first_violation(np.array([(20, 2, 2), (5, 2, 2), (5, 2, 0.5)], dtype=float)) == 1


def test_the_border_itself_is_permitted() -> None:
    along = np.array([(0, 0, 0), (10, 0, 0), (10, 5, 0), (5, 5, 0), (5, 10, 0), (0, 10, 0), (0, 0, 0)], dtype=float)
    for work in (True, False):
        assert ControlArea(1, work, AXES, L_SHAPE, -1.0, 1.0).first_violation(along) == -1
        top = ControlArea(1, work, AXES, L_SHAPE, -1.0, 0.0)
        assert top.first_violation(np.array([(2, 2, 0), (4, 4, 0)], dtype=float)) == -1
        assert top.permits((5, 5, 0))


def test_other_axes_can_be_those_of_the_space() -> None:
    low = Polygon(np.array([(0, 0), (10, 0), (10, 2), (0, 2)], dtype=float))
    area = ControlArea(1, True, (2, 0, 3), low, 0.0, 5.0)
    assert area.permits((1.0, 99.0, 8.0, 4.0))
    assert not area.permits((8.0, 99.0, 1.0, 4.0))
    assert not area.permits((1.0, 99.0, 8.0, 6.0))


@pytest.mark.parametrize("angle", [-400.0, -90.0, 30.0, 360.0, 725.0])
def test_points_of_a_helix_lie_on_it_and_close_together(angle: float) -> None:
    start, radius = np.array([13.0, 2.0, 5.0]), 10.0
    turn = math.radians(angle)
    end = np.array([3 + 10 * math.cos(turn), 2 + 10 * math.sin(turn), 9.0])
    points = circle_points(start, end, (0, 1), np.array([3.0, 2.0]), radius, angle)
    np.testing.assert_allclose(np.hypot(points[:, 0] - 3, points[:, 1] - 2), radius, atol=1e-9)
    np.testing.assert_allclose((points[0], points[-1]), (start, end), atol=1e-9)
    middle = 0.5 * (points[1:] + points[:-1])
    assert (radius - np.hypot(middle[:, 0] - 3, middle[:, 1] - 2)).max() <= CHORD_ERROR * 1.001


def test_points_of_a_polynomial() -> None:
    coefficients = np.zeros((6, 3))
    coefficients[1, 0], coefficients[2, 1], coefficients[5, 2] = 10.0, 3.0, -2.0
    points = polynomial_points(coefficients)

    def at(u: Floats) -> Floats:
        return np.stack([10 * u, 3 * u**2, -2 * u**5], axis=1)

    share = np.linspace(0, 1, len(points))
    np.testing.assert_allclose(points, at(share), atol=1e-12)
    middle = at(0.5 * (share[1:] + share[:-1])) - 0.5 * (points[1:] + points[:-1])
    assert np.linalg.norm(middle, axis=1).max() <= CHORD_ERROR
