"""Contour lines: angles and a few coordinates in, points out."""

from __future__ import annotations

import math

import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from runtime.cnc.decoder.contour_lines import ContourLineError, ContourLines, Coordinates, Point, one_line, two_lines
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place, Problem


def refused(entry: ErrorEntry, error: ContourLineError) -> None:
    assert error.entry is entry
    assert Problem(error.entry, error.values, Place("p", 1, 1, "N10 #ANG=1")).explained()


@pytest.mark.parametrize(
    ("angle", "coordinates", "target"),
    [
        (60.0, (20.0, None), (20.0, 27.3205)),
        (35.0, (None, 20.0), (24.2815, 20.0)),
        (25.0, (30.0, None), (30.0, 19.3262)),
        (-45.0, (20.0, None), (20.0, 0.0)),
        (405.0, (20.0, None), (20.0, 20.0)),
        (60.0, (20.0, 27.32051), (20.0, 27.32051)),  # both, and they agree
        (60.0, (10.0, None), (10.0, 10.0)),  # no way at all
    ],
)
def test_one_line_by_its_angle_and_a_coordinate(angle: float, coordinates: Coordinates, target: Point) -> None:
    assert one_line((10.0, 10.0), angle, coordinates) == pytest.approx(target, abs=1e-4)


@pytest.mark.parametrize(("angle", "target"), [(0.0, (20.0, 10.0)), (180.0, (-5.0, 10.0)), (-180.0, (-5.0, 10.0))])
def test_lines_along_an_axis_are_exact(angle: float, target: Point) -> None:
    assert one_line((10.0, 10.0), angle, (target[0], None)) == target
    assert one_line((10.0, 10.0), angle + 90.0, (None, target[0])) == (10.0, target[0])


@pytest.mark.parametrize(
    ("angle", "coordinates", "entry"),
    [
        (60.0, (9.0, None), catalogue.CONTOUR_LINE_UNREACHABLE),
        (-60.0, (None, 11.0), catalogue.CONTOUR_LINE_UNREACHABLE),
        (0.0, (None, 11.0), catalogue.CONTOUR_LINE_UNREACHABLE),
        (90.0, (11.0, None), catalogue.CONTOUR_LINE_UNREACHABLE),
        (180.0, (None, 10.0), catalogue.CONTOUR_LINE_UNDETERMINED),
        (90.0, (None, None), catalogue.CONTOUR_LINE_UNDETERMINED),
        (45.0, (20.0, 21.0), catalogue.CONTOUR_LINE_OVERDETERMINED),
        (225.0, (20.0, 20.0), catalogue.CONTOUR_LINE_UNREACHABLE),
    ],
)
def test_what_one_line_cannot_reach(angle: float, coordinates: Coordinates, entry: ErrorEntry) -> None:
    with pytest.raises(ContourLineError) as caught:
        one_line((10.0, 10.0), angle, coordinates)
    refused(entry, caught.value)


def test_the_corner_is_where_both_lines_meet() -> None:
    start = (10.0, 10.0)
    corner, end = two_lines(start, 15.0, 100.0, (40.0, 60.0))
    assert end == (40.0, 60.0)
    assert math.degrees(math.atan2(corner[1] - 10.0, corner[0] - 10.0)) == pytest.approx(15.0)
    assert math.degrees(math.atan2(60.0 - corner[1], 40.0 - corner[0])) == pytest.approx(100.0)


def test_a_missing_coordinate_of_the_end_is_that_of_the_start() -> None:
    corner, end = two_lines((10.0, 10.0), 75.0, 100.0, (None, 60.0))
    assert end == (10.0, 60.0)
    assert math.degrees(math.atan2(corner[1] - 10.0, corner[0] - 10.0)) == pytest.approx(75.0)
    assert math.degrees(math.atan2(60.0 - corner[1], 10.0 - corner[0])) == pytest.approx(100.0)
    _, end = two_lines((10.0, 10.0), -75.0, 60.0, (50.0, None))
    assert end == (50.0, 10.0)


def test_two_angles_alone_stay_at_the_start() -> None:
    assert two_lines((10.0, 10.0), 75.0, 75.0, (None, None)) == ((10.0, 10.0), (10.0, 10.0))


@pytest.mark.parametrize(
    ("first", "second", "end", "entry"),
    [
        (30.0, 30.0, (40.0, 60.0), catalogue.CONTOUR_LINE_PARALLEL),
        (30.0, 210.0, (40.0, 60.0), catalogue.CONTOUR_LINE_PARALLEL),
        (195.0, 100.0, (40.0, 60.0), catalogue.CONTOUR_LINE_UNREACHABLE),  # the corner lies behind
        (15.0, -80.0, (40.0, 60.0), catalogue.CONTOUR_LINE_UNREACHABLE),  # the end lies behind
    ],
)
def test_what_two_lines_cannot_reach(first: float, second: float, end: Coordinates, entry: ErrorEntry) -> None:
    with pytest.raises(ContourLineError) as caught:
        two_lines((10.0, 10.0), first, second, end)
    refused(entry, caught.value)


coordinate = st.floats(-1000.0, 1000.0)


@given(coordinate, coordinate, st.floats(-360.0, 360.0), st.floats(0.1, 1000.0), st.booleans())
def test_a_point_on_a_ray_is_found_again(x: float, y: float, angle: float, way: float, by_first: bool) -> None:
    target = x + way * math.cos(math.radians(angle)), y + way * math.sin(math.radians(angle))
    along = abs(target[0] - x if by_first else target[1] - y) / way
    assume(along > 1e-3)
    found = one_line((x, y), angle, (target[0], None) if by_first else (None, target[1]))
    assert found == pytest.approx(target, abs=1e-6)
    behind = (2 * x - target[0], None) if by_first else (None, 2 * y - target[1])
    with pytest.raises(ContourLineError):
        one_line((x, y), angle, behind)


@given(coordinate, coordinate, st.floats(-360.0, 360.0), st.floats(-360, 360.0), st.floats(1, 1000), st.floats(1, 1000))
def test_the_corner_of_two_lines_is_found_again(
    x: float, y: float, first: float, second: float, there: float, on: float
) -> None:
    assume(abs(math.sin(math.radians(second - first))) > 1e-3)
    corner = x + there * math.cos(math.radians(first)), y + there * math.sin(math.radians(first))
    end = corner[0] + on * math.cos(math.radians(second)), corner[1] + on * math.sin(math.radians(second))
    assert two_lines((x, y), first, second, end)[0] == pytest.approx(corner, abs=1e-6)
    for turned in ((first + 180.0, second), (first, second + 180.0)):
        with pytest.raises(ContourLineError, match=str(catalogue.CONTOUR_LINE_UNREACHABLE.id)):
            two_lines((x, y), *turned, end)


# -- block by block, as the decoder calls


def test_a_chain_of_single_lines_returns() -> None:
    lines, position = ContourLines(), (10.0, 10.0)
    chain: list[tuple[float, Coordinates]] = [
        (0, (20, None)), (90, (None, 20)), (45, (30, None)), (135, (20, None)), (90, (None, 50)), (180, (15, None)),
        (135, (None, 55)), (225, (None, 50)), (180, (0, None)), (270, (None, 40)), (225, (None, 30)), (315, (None, 20)),
        (270, (None, 10)), (0, (10, None)),
    ]  # fmt: skip
    corners = []
    for angle, coordinates in chain:
        (position,) = lines.add(position, angle, coordinates) or []
        corners.append(position)
    assert corners[3] == pytest.approx((20.0, 40.0))
    assert corners[10] == pytest.approx((-10.0, 30.0))
    assert position == pytest.approx((10.0, 10.0))
    lines.expect_none()


def test_a_turned_part_with_a_line_that_waits() -> None:
    """Z, X in G18, with the angle from Z."""
    lines = ContourLines()
    assert lines.add((150.0, 5.0), 100.0, (None, None)) is None
    assert lines.waiting
    points = lines.add((150.0, 5.0), 130.0, (140.0, 25.0))
    assert not lines.waiting
    assert points is not None
    assert points[0] == pytest.approx((148.1958, 15.2323), abs=1e-3)
    assert points[1] == (140.0, 25.0)
    assert lines.add(points[1], 90.0, (None, 40.0)) == [(140.0, 40.0)]
    lines.expect_none()
    (target,) = lines.add((120.0, 40.0), 140.0, (None, 50.0)) or []
    assert target == pytest.approx((120.0 - 10.0 / math.tan(math.radians(40.0)), 50.0))


def test_a_line_that_waits_needs_a_second_one() -> None:
    lines = ContourLines()
    lines.add((0.0, 0.0), 30.0, (None, None))
    with pytest.raises(ContourLineError) as caught:
        lines.expect_none()
    refused(catalogue.CONTOUR_LINE_UNDETERMINED, caught.value)
    lines.expect_none()  # nothing waits any more


def test_the_second_target_must_be_absolute() -> None:
    lines = ContourLines()
    lines.add((0.0, 0.0), 30.0, (None, None), absolute=False)
    with pytest.raises(ContourLineError) as caught:
        lines.add((0.0, 0.0), 60.0, (10.0, None), absolute=False)
    refused(catalogue.CONTOUR_LINE_INCREMENTAL, caught.value)
    (target,) = lines.add((0.0, 0.0), 30.0, (10.0, None), absolute=False) or []
    assert target == pytest.approx((10.0, 5.7735), abs=1e-4)
    assert lines.add((0.0, 0.0), 30.0, (None, None), absolute=False) is None
    assert lines.add((0.0, 0.0), 60.0, (None, None), absolute=False) == [(0.0, 0.0), (0.0, 0.0)]
