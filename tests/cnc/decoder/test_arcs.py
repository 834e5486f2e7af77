"""Circles by opening angle, with a kept centre, through three points in space."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import numpy.typing as npt
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from runtime.cnc.block_json import rows
from runtime.cnc.blocks import Arc, Corner, CornerKind, Floats, Source, SpatialArc
from runtime.cnc.decoder.arcs import radius_transition, through_three_points
from runtime.cnc.decoder.circles import Circle, CircleError, by_kept_centre, by_opening_angle
from runtime.cnc.geometry.elements import arc_at
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.interpolator.driving import check_path_laws, drive, limits


def refused(entry: ErrorEntry, error: CircleError) -> None:
    assert error.entry is entry
    assert error.entry.text.format(**error.values)


# -- #CANG


@pytest.mark.parametrize("clockwise", [True, False])
@pytest.mark.parametrize("opening", [0.5, 135.0, 180.0, 359.0])
def test_the_end_of_a_circle_by_its_opening_angle(opening: float, clockwise: bool) -> None:
    start, centre = (10.0, 10.0), (40.0, 20.0)
    circle, end = by_opening_angle(start, centre, opening, clockwise)
    assert circle == Circle(centre, math.hypot(30, 10), -opening if clockwise else opening)
    assert math.dist(end, centre) == pytest.approx(circle.radius)
    first = math.atan2(start[1] - centre[1], start[0] - centre[0])
    last = math.atan2(end[1] - centre[1], end[0] - centre[0])
    assert math.degrees(last - first) % 360.0 == pytest.approx(circle.angle % 360.0)


def test_a_full_circle_by_its_opening_angle_ends_where_it_began() -> None:
    circle, end = by_opening_angle((1.1, 2.2), (3.3, 4.4), 360.0, True)
    assert end == (1.1, 2.2)
    assert circle.angle == -360.0


@pytest.mark.parametrize("opening", [0.0, -10.0, 360.1, math.nan])
def test_opening_angles_that_are_none(opening: float) -> None:
    with pytest.raises(CircleError) as caught:
        by_opening_angle((1.0, 2.0), (3.0, 4.0), opening, True)
    refused(catalogue.OPENING_ANGLE, caught.value)
    with pytest.raises(CircleError) as caught:
        by_opening_angle((1.0, 2.0), (1.0, 2.0), 90.0, True)
    refused(catalogue.RADIUS_ZERO, caught.value)


# -- G164


def test_a_kept_centre_allows_two_radii_within_both_limits() -> None:
    start, centre, end = (0.0, 10.0), (0.0, 0.0), (10.04, 0.0)
    circle = by_kept_centre(start, end, centre, True, 0.05, 0.01)
    assert (circle.centre, circle.radius) == (centre, 10.0)
    assert circle.angle == pytest.approx(-90.0)
    assert by_kept_centre(start, end, centre, False, 0.05, 0.0).angle == pytest.approx(270.0)
    for difference, share in ((0.03, 0.01), (0.05, 0.003), (0.0, 0.01)):
        with pytest.raises(CircleError) as caught:
            by_kept_centre(start, end, centre, True, difference, share)
        refused(catalogue.RADIUS_DIFFERENCE, caught.value)
    assert by_kept_centre(start, (10.00005, 0.0), centre, True, 0.0, 0.0).radius == 10.0


def test_a_full_circle_keeps_its_place_only_if_start_and_end_are_the_same() -> None:
    centre = (0.0, 200.0)
    assert by_kept_centre((0.0, 0.0), (0.0, 0.0), centre, True, 0.1, 0.0).angle == -360.0
    assert abs(by_kept_centre((0.0, 0.0), (0.1, 0.0), centre, True, 0.1, 0.0).angle) > 359.0
    assert abs(by_kept_centre((0.0, 0.0), (0.1, 0.0), centre, False, 0.1, 0.0).angle) < 1.0


def spiral(first: float, last: float, angle: float, begin: float = 0.3) -> Arc:
    centre = np.array([5.0, -7.0])
    phi = begin + math.radians(angle)
    start = np.array([centre[0] + first * math.cos(begin), centre[1] + first * math.sin(begin), 1.0])
    end = np.array([centre[0] + last * math.cos(phi), centre[1] + last * math.sin(phi), 3.0])
    corner = Corner(CornerKind.ROUNDING, 1.0)
    return Arc(
        Source("p", 1), start, end, 500.0, end - 1.0, (0, 1), centre, first, angle, corner=corner, end_feed=100.0
    )


@pytest.mark.parametrize(
    ("first", "last", "angle"), [(10.0, 10.05, 90.0), (10.0, 9.5, -300.0), (100.0, 100.0004, 359.0), (3.0, 3.9, 20.0)]
)
def test_the_radius_changes_linearly_with_the_angle(first: float, last: float, angle: float) -> None:
    whole = spiral(first, last, angle)
    pieces = radius_transition(whole)
    np.testing.assert_array_equal(pieces[0].start, whole.start)
    np.testing.assert_array_equal(pieces[-1].end, whole.end)
    np.testing.assert_allclose(pieces[-1].end_pcs, whole.end_pcs, atol=1e-12)
    assert sum(piece.angle for piece in pieces) == pytest.approx(angle)
    assert [piece.corner for piece in pieces] == [None] * (len(pieces) - 1) + [whole.corner]
    assert [piece.end_feed for piece in pieces] == [None] * (len(pieces) - 1) + [100.0]
    q, dq = np.zeros(3), np.zeros(3)
    for number, piece in enumerate(pieces):
        if number:
            np.testing.assert_array_equal(piece.start, pieces[number - 1].end)
        for share in (0.25, 0.5, 0.75):
            x, y = piece.centre
            arc_at(piece.start, piece.end, 0, 1, x, y, math.radians(piece.angle), share, 1.0, 3, q, dq)
            part = (number + share) / len(pieces)
            radius, phi = first + part * (last - first), 0.3 + math.radians(angle) * part
            expected = np.array([x + radius * math.cos(phi), y + radius * math.sin(phi), 1.0 + 2.0 * part])
            assert np.linalg.norm(q - expected) < 1e-4


def test_the_pieces_are_driven_like_one_arc() -> None:
    axes = limits(400.0, 4000.0, 6e4, 5.0)
    whole = replace(spiral(50.0, 50.5, 300.0), corner=None, end_feed=None, feed=6000.0)
    run = drive(radius_transition(whole), axes, whole.start)
    check_path_laws(run)
    assert run.finished
    assert min(run.v[200:-200]) == pytest.approx(100.0)


def test_a_true_arc_stays_in_one_piece() -> None:
    arc = spiral(10.0, 10.0, 200.0)
    assert radius_transition(arc) == [arc]


# -- G303


def turned(vector: Floats, normal: Floats, angle: float) -> Floats:
    """Rodrigues' formula."""
    cosine, sine = math.cos(angle), math.sin(angle)
    result: Floats = (
        vector * cosine + np.cross(normal, vector) * sine + normal * float(normal @ vector) * (1.0 - cosine)
    )
    return result


def test_the_arc_of_the_manual() -> None:
    start, interim, target = np.array([0.0, 0.0, 30.0]), np.array([30.0, 75.0, 15.0]), np.array([60.0, 0.0, 0.0])
    circle = through_three_points(start, interim, target)
    for point in (start, interim, target):
        assert np.linalg.norm(point - circle.centre) == pytest.approx(circle.radius)
        assert float((point - start) @ circle.normal) == pytest.approx(0.0, abs=1e-9)
    np.testing.assert_allclose(
        circle.centre + turned(start - circle.centre, circle.normal, math.radians(circle.angle)), target, atol=1e-9
    )
    assert circle.angle > 180.0  # the interim point is beyond the centre


part = st.floats(-1.0, 1.0)


@given(part, part, part, part, st.floats(1.0, 500.0), st.floats(5.0, 350.0), st.floats(0.1, 0.9))
def test_any_arc_in_space_is_found_again(
    a: float, b: float, c: float, d: float, radius: float, angle: float, where: float
) -> None:
    normal: npt.NDArray[np.float64] = np.array([a, b, c])
    assume(np.linalg.norm(normal) > 0.1)
    normal /= np.linalg.norm(normal)
    aside = np.cross(normal, np.array([d, 1.0, -a]))
    assume(np.linalg.norm(aside) > 0.1)
    radial = radius * aside / np.linalg.norm(aside)
    centre = np.array([10.0 * d, -20.0, 30.0 * a])
    points = [centre + turned(radial, normal, math.radians(angle * share)) for share in (0.0, where, 1.0)]
    found = through_three_points(points[0], points[1], points[2])
    np.testing.assert_allclose(found.centre, centre, atol=1e-6)
    np.testing.assert_allclose(found.normal, normal, atol=1e-6)
    assert found.radius == pytest.approx(radius)
    assert found.angle == pytest.approx(angle, abs=1e-6)


def test_three_points_that_are_no_arc() -> None:
    a, b, c = np.array([1.0, 2.0, 3.0]), np.array([2.0, 4.0, 6.0]), np.array([4.0, 8.0, 12.0])
    for points in ((a, b, c), (a, c, b), (b, a, c)):
        with pytest.raises(CircleError) as caught:
            through_three_points(*points)
        refused(catalogue.ARC_POINTS_IN_LINE, caught.value)
    aside = np.array([0.0, 0.0, 9.0])
    for points, text in (
        ((a, a, aside), "start point and interim point"),
        ((a, aside, a), "start point and target point"),
        ((aside, a, a), "interim point and target point"),
    ):
        with pytest.raises(CircleError) as caught:
            through_three_points(*points)
        refused(catalogue.ARC_POINTS_EQUAL, caught.value)
        assert text in caught.value.entry.text.format(**caught.value.values)


def test_the_row_of_an_arc_in_space() -> None:
    start, end = np.array([1.0, 0.0, 0.0, 5.0]), np.array([0.0, 1.0, 0.0, 6.0])
    block = SpatialArc(
        Source("p", 7, 70), start, end, 900.0, end - 1.0, np.zeros(3), np.array([0.0, 0.0, 1.0]), 90.0
    )  # fmt: skip
    (row,) = rows(block, ("X", "Y", "Z", "C"))
    assert row == {
        "line": 7, "n": 70, "program": "p", "type": "arc",
        "from": {"X": 1.0, "Y": 0.0, "Z": 0.0, "C": 5.0}, "to": {"X": 0.0, "Y": 1.0, "Z": 0.0, "C": 6.0},
        "to_pcs": {"X": -1.0, "Y": 0.0, "Z": -1.0, "C": 5.0}, "centre": {"X": 0.0, "Y": 0.0, "Z": 0.0},
        "radius": 1.0, "angle": 90.0, "normal": [0.0, 0.0, 1.0], "feed": 900.0, "rapid": False,
    }  # fmt: skip
