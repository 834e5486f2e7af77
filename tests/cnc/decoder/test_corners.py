"""Chamfers and roundings: two motions in, two shorter ones and what lies between them out."""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import replace
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Corner,
    CornerKind,
    Dwell,
    Floats,
    Flush,
    FlushKind,
    Hold,
    Line,
    Polyline,
    Source,
    SpatialArc,
    Stop,
    StopKind,
    Synch,
    Technology,
    TechnologyFunction,
)
from runtime.cnc.decoder.corners import CornerError, Corners, with_corner
from runtime.cnc.geometry.elements import arc_at, line_at
from runtime.diagnostics.catalogue import language as catalogue
from tests.cnc.interpolator.driving import check_path_laws, drive, limits

WIDTH, LENGTH, ROUNDING = CornerKind.CHAMFER_WIDTH, CornerKind.CHAMFER_LENGTH, CornerKind.ROUNDING


def at(*place: float) -> Floats:
    return np.array((*place, 0.0, 0.0, 0.0)[:3], dtype=np.float64)


def line(start: Floats, end: Floats, corner: Corner | None = None, number: int = 1, feed: float = 2000.0) -> Line:
    return Line(Source("p", number, 10 * number), start, end, feed, math.isinf(feed), end - at(1, 2, 3), corner=corner)


def arc(start: Floats, centre: Floats, angle: float, corner: Corner | None = None, number: int = 1) -> Arc:
    """An arc, or a helix with the third axis of `centre` as its height."""
    phi = math.radians(angle)
    x, y = start[0] - centre[0], start[1] - centre[1]
    end = centre + at(x * math.cos(phi) - y * math.sin(phi), x * math.sin(phi) + y * math.cos(phi))
    end[2] = start[2] + centre[2]
    return Arc(
        Source("p", number), start, end, 800.0, end.copy(), (0, 1), centre[:2], math.hypot(x, y), angle, corner=corner
    )


def place(motion: Line | Arc, share: float) -> tuple[Floats, Floats]:
    """Position and unit tangent in the plane, by the kernels of the interpolator."""
    q, dq = np.zeros(3), np.zeros(3)
    if isinstance(motion, Line):
        line_at(motion.start, motion.end, share, 1.0, 3, q, dq)
    else:
        first, second = motion.plane
        centre, angle = motion.centre, math.radians(motion.angle)
        arc_at(motion.start, motion.end, first, second, centre[0], centre[1], angle, share, 1.0, 3, q, dq)
        if share >= 1.0:
            q[:] = motion.end
    norm = float(np.linalg.norm(dq[:2]))
    return q, dq[:2] / norm if norm > 0.0 else dq[:2]


def worked(*blocks: Block) -> list[Block]:
    return list(Corners(("X", "Y", "Z"))(blocks))


def motions(blocks: Iterable[Block]) -> list[Line | Arc]:
    return [block for block in blocks if isinstance(block, Line | Arc)]


# -- numbers of the manual


def test_a_chamfer_at_a_right_angle() -> None:
    a = line(at(100, 0), at(100, 100), Corner(WIDTH, 20.0))
    first, insert, second = motions(worked(a, line(a.end, at(40, 100))))
    assert isinstance(insert, Line)
    np.testing.assert_allclose(first.end, at(100, 80), atol=1e-12)
    np.testing.assert_allclose(insert.start, first.end, atol=0)
    np.testing.assert_allclose(insert.end, at(80, 100), atol=1e-12)
    np.testing.assert_allclose(second.start, insert.end, atol=0)
    np.testing.assert_allclose(second.end, at(40, 100), atol=0)
    np.testing.assert_allclose(insert.end_pcs, at(79, 98, -3), atol=1e-12)
    np.testing.assert_allclose(first.end_pcs, at(99, 78, -3), atol=1e-12)


def test_the_length_of_a_chamfer_is_that_of_the_line() -> None:
    a = line(at(0, 100), at(0, 0), Corner(LENGTH, 35.0))
    _, insert, _ = motions(worked(a, line(a.end, at(40, 0))))
    assert np.linalg.norm(insert.end - insert.start) == pytest.approx(35.0, abs=1e-9)
    assert insert.start[1] == pytest.approx(35.0 / math.sqrt(2.0), abs=1e-9)
    assert insert.end[0] == pytest.approx(35.0 / math.sqrt(2.0), abs=1e-9)


def test_a_pocket_with_rounded_corners() -> None:
    places = [at(0, 0), at(200, 0), at(200, 100), at(0, 100), at(0, 0), at(40, 0)]
    rounded = Corner(ROUNDING, 20.0)
    blocks = [line(a, b, rounded if number < 5 else None, number) for number, (a, b) in enumerate(pairwise(places), 1)]
    out = motions(worked(*blocks))
    arcs = [block for block in out if isinstance(block, Arc)]
    assert [isinstance(block, Arc) for block in out] == [False, True] * 4 + [False]
    centres = [(180, 20), (180, 80), (20, 80), (20, 20)]
    for block, centre in zip(arcs, centres, strict=True):
        np.testing.assert_allclose(block.centre, centre, atol=1e-9)
        assert block.angle == pytest.approx(90.0, abs=1e-9)
        assert block.radius == 20.0
    assert all(block.corner is None for block in out)
    for before, after in pairwise(out):
        np.testing.assert_allclose(before.end, after.start, atol=0)
    np.testing.assert_allclose(out[2].start, at(200, 20), atol=1e-9)
    np.testing.assert_allclose(out[2].end, at(200, 80), atol=1e-9)


def test_a_rounded_pocket_is_driven_without_slowing_down() -> None:
    places = [at(50, 0), at(200, 0), at(200, 100), at(0, 100), at(0, 0), at(50, 0)]
    blocks = [
        line(a, b, Corner(ROUNDING, 20.0) if number < 5 else None, number, 6000.0)
        for number, (a, b) in enumerate(pairwise(places), 1)
    ]
    run = drive(worked(*blocks), limits(400.0, 4000.0, 6e4, 5.0), places[0])
    check_path_laws(run)
    assert run.finished
    np.testing.assert_allclose(run.path[-1], places[-1], atol=1e-9)
    on_the_way = np.array(run.v)[200:-200]
    assert on_the_way.min() == pytest.approx(100.0)


def test_sizes_that_use_an_element_up_leave_one_without_length() -> None:
    places = [at(0, 0), at(100, 0), at(100, 100), at(0, 100)]
    corner = Corner(ROUNDING, 50.0)
    blocks = [line(a, b, corner) for a, b in pairwise(places)]
    out = motions(worked(*blocks[:2], line(blocks[1].end, blocks[2].end)))
    assert [type(block) for block in out] == [Line, Arc, Line, Arc, Line]
    np.testing.assert_allclose(out[2].start, out[2].end, atol=1e-6)


def test_a_rounding_between_arcs_outside_them() -> None:
    a = arc(at(0, 0), at(40, 0), -180.0, Corner(ROUNDING, 40.0))  # the corner is seen from above 180 degrees
    b = arc(at(80, 0), at(105, -15), -118.0)
    first, insert, second = motions(worked(a, b))
    assert isinstance(insert, Arc)
    assert isinstance(first, Arc)
    assert isinstance(second, Arc)
    # the centre is 40 mm away from both circles, above the corner
    assert math.dist(insert.centre, (40, 0)) == pytest.approx(80.0, abs=1e-9)
    assert math.dist(insert.centre, (105, -15)) == pytest.approx(math.hypot(25, 15) + 40.0, abs=1e-9)
    assert insert.centre[1] > 0
    assert insert.angle > 0
    np.testing.assert_allclose(first.end[:2], (insert.centre + at(40, 0)[:2]) / 2, atol=1e-9)
    assert -180.0 < first.angle < 0.0
    assert -118.0 < second.angle < 0.0
    np.testing.assert_array_equal(first.centre, a.centre)
    np.testing.assert_array_equal(second.centre, b.centre)


def test_a_rounding_between_arcs_inside_them() -> None:
    a = arc(at(0, 0), at(40, 0), -180.0, Corner(ROUNDING, 5.0))
    b = arc(at(80, 0), at(100, 35), -150.0)
    _, insert, _ = motions(worked(a, b))
    assert isinstance(insert, Arc)
    assert math.dist(insert.centre, (40, 0)) == pytest.approx(35.0, abs=1e-9)
    assert math.dist(insert.centre, (100, 35)) == pytest.approx(math.hypot(20, 35) - 5.0, abs=1e-9)
    assert insert.angle < 0
    assert insert.centre[1] < 17.5  # below the line of the centres: at this crossing of the circles, not at the other


def test_a_chamfer_between_arcs_is_measured_as_a_chord() -> None:
    a = arc(at(0, 0), at(50, 0), 160.0, Corner(WIDTH, 30.0))
    b = arc(a.end, a.end + at(40, 15), 110.0)
    first, insert, second = motions(worked(a, b))
    assert isinstance(insert, Line)
    assert math.dist(insert.start, a.end) == pytest.approx(30.0, abs=1e-9)
    assert math.dist(insert.end, a.end) == pytest.approx(30.0, abs=1e-9)
    assert isinstance(first, Arc)
    assert isinstance(second, Arc)
    assert first.angle == pytest.approx(160.0 - 2 * math.degrees(math.asin(0.3)), abs=1e-9)


# -- laws


@st.composite
def neighbours(draw: st.DrawFn) -> tuple[Line | Arc, Line | Arc]:
    """Two elements that meet in a corner somewhere; lines, arcs of either sense, helices."""
    corner = at(draw(st.floats(-100, 100)), draw(st.floats(-100, 100)), draw(st.floats(-10, 10)))
    heading = draw(st.floats(0, 2 * math.pi))
    turn = draw(st.floats(0.01, math.pi - 0.01)) * draw(st.sampled_from((-1.0, 1.0)))
    first = _element(draw, corner, heading + math.pi)
    second = _element(draw, corner, heading + turn)
    return _reversed(first), second


def _element(draw: st.DrawFn, start: Floats, heading: float) -> Line | Arc:
    height = draw(st.sampled_from((0.0, 0.0, 7.0, -3.0)))
    if draw(st.booleans()):
        length = draw(st.floats(1.0, 200.0))
        return line(start, start + at(length * math.cos(heading), length * math.sin(heading), height))
    radius, sense = draw(st.floats(1.0, 300.0)), draw(st.sampled_from((-1.0, 1.0)))
    centre = start + radius * sense * at(-math.sin(heading), math.cos(heading))
    centre[2] = height
    return arc(start, centre, sense * draw(st.floats(5.0, 500.0)))


def _reversed(motion: Line | Arc) -> Line | Arc:
    if isinstance(motion, Line):
        return line(motion.end, motion.start)
    return arc(motion.end, np.array([*motion.centre, motion.start[2] - motion.end[2]]), -motion.angle)


def _with(motion: Line | Arc, corner: Corner) -> Line | Arc:
    return replace(motion, corner=corner)


def _on(part: Line | Arc, whole: Line | Arc, from_share: float, to_share: float) -> None:
    """`part` is the piece of `whole` between two shares of its length, all axes."""
    for share in np.linspace(0.0, 1.0, 7):
        expected, _ = place(whole, from_share + (to_share - from_share) * float(share))
        np.testing.assert_allclose(place(part, float(share))[0], expected, atol=1e-6)


def _share_left(part: Line | Arc, whole: Line | Arc) -> float:
    if isinstance(part, Arc) and isinstance(whole, Arc):
        return part.angle / whole.angle
    return float(np.linalg.norm((part.end - part.start)[:2]) / np.linalg.norm((whole.end - whole.start)[:2]))


def _largest(error: CornerError, corner: Corner) -> float:
    assert error.problem.entry is catalogue.CORNER_TOO_LARGE
    largest = error.problem.values["largest"]
    assert isinstance(largest, float)
    assert largest < corner.size
    return largest


def _cut(pair: tuple[Line | Arc, Line | Arc], corner: Corner) -> tuple[Line | Arc, Line | Arc, Line | Arc] | float:
    """First, insert, second; or the size that would just fit."""
    a, b = pair
    try:
        first, insert, second = motions(worked(_with(a, corner), b))
    except CornerError as error:
        return _largest(error, corner)
    assert 0.0 <= _share_left(first, a) < 1.0
    assert 0.0 <= _share_left(second, b) < 1.0
    _on(first, a, 0.0, _share_left(first, a))
    _on(second, b, 1.0 - _share_left(second, b), 1.0)
    np.testing.assert_array_equal(first.start, a.start)
    np.testing.assert_array_equal(second.end, b.end)
    np.testing.assert_allclose(insert.start, first.end, atol=0)
    np.testing.assert_allclose(insert.end, second.start, atol=0)
    return first, insert, second


def _fitting(pair: tuple[Line | Arc, Line | Arc], corner: Corner) -> tuple[Line | Arc, Line | Arc, Line | Arc]:
    """As `_cut`, with the size that just fits if `corner` is too large; that size is a sharp limit."""
    result = _cut(pair, corner)
    if isinstance(result, float):
        assume(result > 1e-3)
        assert isinstance(_cut(pair, Corner(corner.kind, result * 1.001 + 1e-6)), float)
        result = _cut(pair, Corner(corner.kind, result * 0.999))
        assert not isinstance(result, float)
    return result


@given(neighbours(), st.floats(0.01, 400.0))
def test_a_rounding_touches_both_elements(pair: tuple[Line | Arc, Line | Arc], radius: float) -> None:
    first, insert, second = _fitting(pair, Corner(ROUNDING, radius))
    assert isinstance(insert, Arc)
    for end in (insert.start, insert.end):
        assert math.dist(end[:2], insert.centre) == pytest.approx(insert.radius, abs=1e-6)
    tolerance = 1e-5 + 1e-6 / insert.radius
    if _share_left(first, pair[0]) > 1e-6:
        np.testing.assert_allclose(place(first, 1.0)[1], place(insert, 0.0)[1], atol=tolerance)
    if _share_left(second, pair[1]) > 1e-6:
        np.testing.assert_allclose(place(insert, 1.0)[1], place(second, 0.0)[1], atol=tolerance)
    turned, _ = place(insert, 1.0 - 1e-12)
    np.testing.assert_allclose(turned, insert.end, atol=1e-6)
    # What is cut off lies outside the circle: the insert is inside the corner, and it is the nearest one.
    left = _share_left(first, pair[0]), _share_left(second, pair[1])
    for share in np.linspace(0.0, 1.0, 9):
        for motion, s in ((pair[0], 1.0 - (1.0 - left[0]) * share), (pair[1], (1.0 - left[1]) * share)):
            distance = math.dist(place(motion, float(s))[0][:2], insert.centre)
            assert distance >= insert.radius - 1e-6
    for motion, s in zip(pair, left, strict=True):
        if isinstance(motion, Arc):
            assert (1.0 - s) * abs(motion.angle) < 180.0


@given(neighbours(), st.floats(0.01, 400.0))
def test_a_chamfer_is_equally_wide_on_both_sides(pair: tuple[Line | Arc, Line | Arc], width: float) -> None:
    _, insert, _ = _fitting(pair, Corner(WIDTH, width))
    assert isinstance(insert, Line)
    corner = pair[0].end[:2]
    wide = math.dist(insert.start[:2], corner)
    assert math.dist(insert.end[:2], corner) == pytest.approx(wide, abs=2e-6)
    assert wide == pytest.approx(width, abs=2e-6) or wide < width  # where the largest one was taken instead


@given(neighbours(), st.floats(0.01, 100.0))
def test_a_chamfer_can_be_given_by_its_length(pair: tuple[Line | Arc, Line | Arc], length: float) -> None:
    result = _cut(pair, Corner(LENGTH, length))
    assume(not isinstance(result, float))
    assert not isinstance(result, float)
    _, insert, _ = result
    corner = pair[0].end[:2]
    assert math.dist(insert.start[:2], insert.end[:2]) == pytest.approx(length, abs=2e-6)
    assert math.dist(insert.start[:2], corner) == pytest.approx(math.dist(insert.end[:2], corner), abs=2e-6)


# -- the stage


def square(corner: Corner, second_plane: tuple[int, int] = (0, 1), feed: float = 2000.0) -> tuple[Line, Line]:
    a = line(at(0, 0), at(10, 0), corner, 3, feed)
    b = line(a.end, at(10, 10, 10) if second_plane != (0, 1) else at(10, 10), None, 5)
    return a, Line(b.source, b.start, b.end, b.feed, b.rapid, b.end_pcs, second_plane)


def test_what_stands_between_comes_behind_the_insert_in_its_order() -> None:
    a, b = square(Corner(WIDTH, 1.0))
    function = TechnologyFunction(a.source, Technology.M, 10, 0.0, Synch.MOS)
    end, dwell, stop = BlockEnd(a.source), Dwell(Source("p", 4), 1.0), Stop(Source("p", 4), StopKind.PROGRAMMED)
    flush, last = Flush(Source("p", 4), FlushKind.STOP), BlockEnd(b.source)
    before = Dwell(Source("p", 2), 1.0)
    out = worked(before, a, function, end, dwell, stop, flush, b, last)
    assert [type(block) for block in out[:3]] == [Dwell, Line, Line]
    assert out[3:8] == [function, end, dwell, stop, flush]
    assert isinstance(out[8], Line)
    assert out[9:] == [last]
    insert = out[2]
    assert isinstance(insert, Line)
    assert insert.source == a.source


def test_a_hold_passes_at_once_and_the_motion_stays_back() -> None:
    a, b = square(Corner(WIDTH, 1.0))
    hold = Hold(a.source, "waits for a variable")
    out = Corners()([a, hold, hold, b])
    assert next(out) is hold
    assert next(out) is hold
    assert [type(block) for block in out] == [Line, Line, Line]


@pytest.mark.parametrize(
    ("between", "entry"),
    [
        (Flush(Source("p", 4), FlushKind.WAIT), catalogue.CORNER_WAIT),
        (Stop(Source("p", 4), StopKind.PROGRAM_END), catalogue.CORNER_OPEN),
        (
            SpatialArc(Source("p", 4), at(10, 0), at(20, 0), 1.0, at(20, 0), at(15, 0), at(0, 0, 1), 180.0),
            catalogue.CORNER_NEIGHBOUR,
        ),
    ],
)
def test_what_makes_a_corner_impossible_is_an_error_of_its_block(between: Block, entry: object) -> None:
    a, b = square(Corner(ROUNDING, 1.0))
    out = Corners()([Dwell(a.source, 1.0), a, BlockEnd(a.source), between, b])
    assert isinstance(next(out), Dwell)
    with pytest.raises(CornerError) as caught:
        next(out)  # the motion with the corner is not handed on
    problem = caught.value.problem
    assert problem.entry is entry
    assert (problem.place.file, problem.place.line) == ("p", 3)
    assert problem.explained()


@pytest.mark.parametrize("size", [0.0, -1.0, math.inf, math.nan])
def test_a_size_must_be_above_zero(size: float) -> None:
    with pytest.raises(CornerError) as caught:
        worked(*square(Corner(WIDTH, size)))
    assert caught.value.problem.entry is catalogue.CORNER_SIZE


def test_a_size_that_turns_an_element_round_is_refused_and_the_largest_is_told() -> None:
    a = line(at(0, 0), at(20, 0), Corner(WIDTH, 30.0), 2)
    with pytest.raises(CornerError, match=r"chamfer of 30 mm does not fit .* in line 4: at most 20 mm"):
        worked(a, line(a.end, at(60, 50), None, 4))
    a = line(at(0, 0), at(20, 0), Corner(ROUNDING, 30.0), 2)
    with pytest.raises(CornerError, match="at most 20 mm"):
        worked(a, line(a.end, at(20, 50), None, 4))


def test_an_element_used_up_by_the_corner_before_has_no_room_for_another() -> None:
    corner = Corner(WIDTH, 6.0)
    a = line(at(0, 0), at(10, 0), corner, 1)
    b = line(a.end, at(10, 10), corner, 2)
    with pytest.raises(CornerError, match="at most 4 mm"):
        worked(a, b, line(b.end, at(0, 10), None, 3))


def test_an_aborted_program_drops_the_motion_that_is_held_back() -> None:
    assert worked(square(Corner(WIDTH, 1.0))[0]) == []


def test_feeds_of_the_insert() -> None:
    for kind in (WIDTH, ROUNDING):
        a, b = square(Corner(kind, 1.0))
        assert motions(worked(a, b))[1].feed == 2000.0
        assert motions(worked(replace(a, end_feed=300.0), b))[1].feed == 300.0
        a, b = square(Corner(kind, 1.0, 150.0))
        out = motions(worked(replace(a, end_feed=300.0), b))
        assert [block.feed for block in out] == [2000.0, 150.0, 2000.0]
        assert out[0].end_feed == 300.0
        assert out[1].end_feed is None


def test_after_a_rapid_motion_the_insert_is_rapid() -> None:
    a, b = square(Corner(WIDTH, 1.0), feed=math.inf)
    chamfer = motions(worked(a, b))[1]
    assert isinstance(chamfer, Line)
    assert chamfer.rapid
    a, b = square(Corner(ROUNDING, 1.0), feed=math.inf)
    assert math.isinf(motions(worked(a, b))[1].feed)
    a, b = square(Corner(WIDTH, 1.0, 150.0), feed=math.inf)
    chamfer = motions(worked(a, b))[1]
    assert isinstance(chamfer, Line)
    assert not chamfer.rapid
    assert chamfer.feed == 150.0


def test_the_insert_lies_in_the_plane_of_the_second_motion() -> None:
    a = line(at(0, -10, 0), at(0, 0, 0), Corner(ROUNDING, 2.0))
    b = line(a.end, at(5, 0, 10))
    b = Line(b.source, b.start, b.end, b.feed, b.rapid, b.end_pcs, (1, 2))
    first, insert, second = motions(worked(a, b))
    assert isinstance(insert, Arc)
    assert insert.plane == (1, 2)
    np.testing.assert_allclose(insert.centre, (-2, 2), atol=1e-12)
    np.testing.assert_allclose(first.end, at(0, -2, 0), atol=1e-12)
    np.testing.assert_allclose(second.start, at(1, 0, 2), atol=1e-12)  # X keeps its place on the element
    np.testing.assert_allclose(insert.end, second.start, atol=0)
    b = line(at(0, 0), at(0, 0, 8))
    with pytest.raises(CornerError, match="no way in the plane of axes X Y") as caught:
        worked(a, b)
    assert caught.value.problem.entry is catalogue.CORNER_DIRECTION


def test_an_arc_of_another_plane_is_refused() -> None:
    a = arc(at(0, 0), at(5, 0), 180.0, Corner(ROUNDING, 1.0))
    b = line(a.end, at(10, 10, 10))
    with pytest.raises(CornerError, match="another plane"):
        worked(a, Line(b.source, b.start, b.end, b.feed, b.rapid, b.end_pcs, (1, 2)))


@pytest.mark.parametrize("kind", list(CornerKind))
def test_nothing_is_inserted_where_the_path_goes_straight_on(kind: CornerKind) -> None:
    stage = Corners()
    a = line(at(0, 0), at(10, 0), Corner(kind, 2.0))
    b = arc(a.end, at(10, 5), 90.0, number=7)
    out = motions(stage([a, b]))
    assert [type(block) for block in out] == [Line, Arc]
    np.testing.assert_array_equal(out[0].end, a.end)
    assert out[0].corner is None
    assert [warning.entry for warning in stage.warnings] == [catalogue.CORNER_TANGENTIAL]
    assert "line 7" in stage.warnings[0].text


@pytest.mark.parametrize("kind", list(CornerKind))
def test_a_motion_straight_back_has_no_corner(kind: CornerKind) -> None:
    a = line(at(0, 0), at(10, 0), Corner(kind, 2.0))
    with pytest.raises(CornerError, match="line 9 goes back the way") as caught:
        worked(a, line(a.end, at(5, 0), None, 9))
    assert caught.value.problem.entry is catalogue.CORNER_REVERSAL
    assert caught.value.problem.explained()


def test_only_the_first_move_of_a_run_is_split_off() -> None:
    a = line(at(0, 0), at(10, 0), Corner(ROUNDING, 1.0))
    points = np.array([at(10, 0), at(10, 10), at(20, 10), at(20, 20)])
    run = Polyline("p", points, np.full(3, 500.0), np.array([4, 5, 6]), np.array([40, -1, 60]), at(1, 1, 1))
    out = worked(a, BlockEnd(a.source), run)
    assert [type(block) for block in out] == [Line, Arc, BlockEnd, Line, BlockEnd, Polyline]
    move, end, rest = out[3:]
    assert isinstance(move, Line)
    assert isinstance(rest, Polyline)
    assert move.source == Source("p", 4, 40)
    assert end == BlockEnd(move.source)
    np.testing.assert_allclose(move.start, at(10, 1), atol=1e-12)
    np.testing.assert_allclose(move.end_pcs, at(9, 9, -1), atol=0)
    np.testing.assert_array_equal(rest.points, points[1:])
    assert rest.lines.tolist() == [5, 6]
    assert rest.numbers.tolist() == [-1, 60]
    assert len(rest.feeds) == 2


def test_a_run_of_one_move_and_the_plane_of_a_run() -> None:
    a = line(at(0, -10, 0), at(0, 0, 0), Corner(ROUNDING, 2.0))
    points = np.array([at(0, 0, 0), at(5, 0, 10)])
    run = Polyline("p", points, np.array([math.inf]), np.array([4]), np.array([-1]), at(), plane=(1, 2))
    out = worked(a, run)
    assert [type(block) for block in out] == [Line, Arc, Line, BlockEnd]
    insert, move = out[1:3]
    assert isinstance(insert, Arc)
    assert insert.plane == (1, 2)
    assert isinstance(move, Line)
    assert move.rapid


def test_a_corner_behind_a_run_takes_its_last_move() -> None:
    points = np.array([at(0, 0), at(5, 5), at(10, 0), at(10, 10)])
    run = Polyline("p", points, np.full(3, 500.0), np.array([4, 5, 6]), np.array([40, -1, 60]), at(1, 1, 1))
    corner = Corner(ROUNDING, 1.0)
    rest, move, end = with_corner(run, corner, (0, 1))
    assert isinstance(rest, Polyline)
    np.testing.assert_array_equal(rest.points, points[:3])
    assert rest.lines.tolist() == [4, 5]
    assert isinstance(move, Line)
    assert move.corner == corner
    assert end == BlockEnd(Source("p", 6, 60))
    out = worked(rest, move, end, line(at(10, 10), at(20, 10)))
    assert [type(block) for block in out] == [Polyline, Line, Arc, BlockEnd, Line]
    (alone, _) = with_corner(
        replace(rest, points=points[:2], feeds=run.feeds[:1], lines=run.lines[:1], numbers=run.numbers[:1]),
        corner,
        (1, 2),
    )
    assert isinstance(alone, Line)
    assert alone.plane == (1, 2)
    single = line(at(0, 0), at(1, 0))
    assert with_corner(single, corner, (0, 1)) == [replace(single, corner=corner)]
