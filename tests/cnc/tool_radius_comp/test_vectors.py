"""Compensation by vectors: blocks in, motions of the tool out. Expected places are derived by hand; all contours lie in X Y."""

from __future__ import annotations

import math
from collections.abc import Iterable
from itertools import pairwise

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Dwell,
    Line,
    Polyline,
    Source,
    Stop,
    StopKind,
    VectorCompensation,
    VectorOrder,
    VectorSettings,
)
from runtime.cnc.tool_radius_comp import CompensationError, ToolRadiusCompensation
from runtime.diagnostics.catalogue import nct_offsets as catalogue
from tests.cnc.tool_radius_comp.paths import Path, compensate

R = 5.0
USUAL = VectorSettings()


class Contour:
    """Blocks of a program; every call is an NC block of its own unless `same`."""

    def __init__(self, x: float = -20.0, y: float = 0.0, z: float = 0.0, settings: VectorSettings = USUAL) -> None:
        self.blocks: list[Block] = []
        self._place = np.array([x, y, z])
        self._line = 0
        self._settings = settings

    def _source(self, same: bool = False) -> Source:
        self._line += not same
        return Source("test", self._line)

    def select(
        self, offset: float, direction: tuple[float, float] | None = None, active: bool = True, same: bool = False
    ) -> Contour:
        source = self._source(same)
        order = VectorOrder.SELECT
        self.blocks.append(VectorCompensation(source, order, (0, 1), active, offset, direction, self._settings))
        return self

    def cancel(self, direction: tuple[float, float] | None = None) -> Contour:
        return self.select(0.0, direction, active=False)

    def order(self, order: VectorOrder, direction: tuple[float, float] | None = None) -> Contour:
        self.blocks.append(VectorCompensation(self._source(), order, direction=direction))
        return self

    def to(self, x: float, y: float, z: float | None = None, same: bool = False) -> Contour:
        end = np.array([x, y, self._place[2] if z is None else z])
        self.blocks.append(Line(self._source(same), self._place, end, 1000.0, False, end.copy()))
        self._place = end
        return self

    def raw(self, x: float, y: float) -> Contour:
        return self.to(x, y)

    def arc(self, x: float, y: float, cx: float, cy: float, angle: float, same: bool = False) -> Contour:
        end = np.array([x, y, self._place[2]])
        centre = np.array([cx, cy])
        radius = float(np.linalg.norm(self._place[:2] - centre))
        self.blocks.append(Arc(self._source(same), self._place, end, 1000.0, end.copy(), (0, 1), centre, radius, angle))
        self._place = end
        return self

    @property
    def place(self) -> tuple[float, float]:
        return float(self._place[0]), float(self._place[1])

    def dwell(self) -> Contour:
        self.blocks.append(Dwell(self._source(), 1.0))
        return self

    def done(self) -> Path:
        self.blocks.append(Stop(self._source(), StopKind.PROGRAM_END))
        return compensate(self.blocks)


def places(path: Path) -> list[tuple[float, float]]:
    """Where each motion ends."""
    assert path.error is None, path.error
    return [(round(m.end[0], 6) + 0.0, round(m.end[1], 6) + 0.0) for m in path.motions]


def driven(contour: Contour) -> Path:
    """As `Contour.done`; arcs may change their radius."""
    return Path(list(ToolRadiusCompensation()(contour.blocks)))


def started(offset: float = R, settings: VectorSettings = USUAL) -> Contour:
    """G41 (positive) or G42 with a straight move to the zero point, from the left."""
    return Contour(settings=settings).select(offset).to(0, 0, same=True)


# ---------------------------------------------------------------------------------------------------- corners


@pytest.mark.parametrize(("offset", "y"), [(R, R), (-R, -R)])
def test_the_tool_runs_beside_the_contour(offset: float, y: float) -> None:
    path = started(offset).to(40, 0).cancel().to(60, 0, same=True).done()
    assert places(path) == [(0, y), (40, y), (60, 0)]


def test_an_inside_corner_has_one_vector_to_the_meeting_point() -> None:
    path = started().to(40, 0).to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(path) == [(0, R), (40 - R, R), (40 - R, 40), (40, 60)]


def test_an_obtuse_outside_corner_has_one_vector() -> None:
    """A right angle in the workpiece is still obtuse: the tangents meet one radius beyond both ends."""
    path = started(-R).to(40, 0).to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(path) == [(0, -R), (40 + R, -R), (40 + R, 40), (40, 60)]


def test_an_acute_outside_corner_has_two_vectors() -> None:
    """Back at 45 degrees: both motions are prolonged by one radius, a line leads from one to the other."""
    path = started(-R).to(40, 0).to(0, 40).cancel().to(-20, 60, same=True).done()
    s = math.sqrt(0.5)
    first = (40 + R, -R)
    second = (40 + R * s + R * s, 0 + R * s - R * s)  # square to the start of the next, one radius back along it
    expected = [(0, -R), first, second, (0 + R * s, 40 + R * s), (-20, 60)]
    assert np.allclose(places(path), expected, atol=1e-6)


def test_arcs_are_not_extended_but_their_tangents_are_inserted() -> None:
    """A half circle between lines that come and go square to its ends."""
    path = started().to(40, 0).arc(60, 0, 50, 0, -180).to(80, 0).cancel().to(100, 0, same=True).done()
    # left of the line and outside of the clockwise arc: inside corners, circle of radius 15 cut by y = 5
    x = math.sqrt(15**2 - R**2)
    assert np.allclose(places(path)[:4], [(0, R), (50 - x, R), (50 + x, R), (80, R)], atol=1e-6)
    outside = started(-R).to(40, 0).arc(60, 0, 50, 0, -180).to(80, 0).cancel().to(100, 0, same=True).done()
    # right of the line, inside of the arc: the line is prolonged to x = 45, where the tangent of the arc comes down to it
    assert np.allclose(places(outside)[:4], [(0, -R), (45, -R), (45, 0), (55, 0)], atol=1e-6)


def test_an_inside_corner_without_intersection_stops_in_front_of_the_block() -> None:
    """Straight to (40, 0), and back along an arc of radius 6, inside of which the tool has a radius of 1 mm left."""
    centre = (40 - 6 * math.cos(0.3), 6 * math.sin(0.3))
    contour = started().to(20, 0).to(40, 0)
    end = (2 * centre[0] - 40, 2 * centre[1])
    path = contour.arc(*end, *centre, 180).to(end[0], 60).done()
    # the path beside the line is y = 5; that of the arc a circle of radius 1 about y = 1.77, which does not come up to it
    assert path.error is not None
    assert path.error.problem.entry is catalogue.NO_INTERSECTION
    assert path.error.problem.place.line == 3
    assert [m.source.line for m in path.motions] == [1]


# ---------------------------------------------------------------------------------------------------- start and end


def test_start_and_end_at_an_inside_corner_are_square() -> None:
    path = Contour(0, -20).select(-R).to(0, 0, same=True).to(40, 0).cancel().to(40, -20, same=True).done()
    # right of the contour, which turns right at both corners: inside
    assert places(path) == [(0, -R), (40, -R), (40, -20)]


def test_start_and_end_at_an_outside_corner_go_around_it() -> None:
    path = Contour(0, -20).select(R).to(0, 0, same=True).to(40, 0).cancel().to(40, -20, same=True).done()
    assert places(path) == [(-R, R), (40 + R, R), (40, -20)]


def test_selected_without_motion_the_next_motion_ends_with_a_vector_of_the_contour() -> None:
    path = Contour(0, 0).select(-R).to(80, 0).to(110, 60).cancel().to(140, 120, same=True).done()
    # G42, turning left: the outside corner of both full offsets, not the square point of a start
    angle = math.atan2(60, 30)
    on = R * math.tan(angle / 2)
    assert np.allclose(places(path)[0], (80 + on, -R), atol=1e-6)


def test_an_auxiliary_line_at_the_start_and_at_the_end() -> None:
    """A wall that rises to the corner from the left: the tool comes to where both offsets meet, inside and outside alike."""
    contour = Contour(-30, 30).select(R, (0, -10)).to(0, 0, same=True).to(40, 0)
    path = contour.cancel((0, 10)).to(70, 30, same=True).done()
    assert places(path) == [(R, R), (40 - R, R), (70, 30)]


def test_without_intersection_with_the_auxiliary_line_it_is_square() -> None:
    path = Contour(-30, 30).select(R, (10, 0)).to(0, 0, same=True).to(40, 0).cancel((3, 0)).to(70, 30, same=True).done()
    assert places(path) == [(0, R), (40, R), (70, 30)]


def test_cancelled_alone_the_vector_goes_with_the_next_motion() -> None:
    path = started().to(40, 0).cancel().to(60, 20).done()
    assert places(path) == [(0, R), (40, R), (60, 20)]


def test_cancelled_with_a_move_of_no_length_the_vector_goes_at_once() -> None:
    path = started().to(40, 0).cancel().to(40, 0, same=True).to(60, 20).done()
    assert places(path) == [(0, R), (40, R), (40, 0), (60, 20)]


@pytest.mark.parametrize("start", [True, False])
def test_arcs_start_and_end_no_compensation(start: bool) -> None:
    if start:
        path = Contour().select(R).arc(0, 0, -10, 0, 180, same=True).to(40, 0).done()
    else:
        path = started().to(40, 0).cancel().arc(60, 0, 50, 0, 180, same=True).done()
    assert path.error is not None
    assert path.error.problem.entry is (catalogue.START_IN_ARC if start else catalogue.CANCEL_IN_ARC)


def test_the_end_of_the_program_lets_the_last_motion_end_square() -> None:
    assert places(started().to(40, 0).to(40, 40).done()) == [(0, R), (40 - R, R), (40 - R, 40)]


# ---------------------------------------------------------------------------------------------------- blocks between


def test_one_block_without_motion_leaves_the_path_as_it_is() -> None:
    path = started().to(40, 0).dwell().to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(path) == [(0, R), (40 - R, R), (40 - R, 40), (40, 60)]
    kinds = [type(block).__name__ for block in path.blocks]
    assert kinds.index("Dwell") == 2  # behind the corner


def test_two_blocks_without_motion_distort_it() -> None:
    path = started().to(40, 0).dwell().dwell().to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(path) == [(0, R), (40, R), (40 - R, 40), (40, 60)]


def test_any_number_of_blocks_without_motion_waits_for_nothing() -> None:
    contour = started().to(40, 0)
    for _ in range(10_000):
        contour.dwell()
    path = contour.to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(path) == [(0, R), (40, R), (40 - R, 40), (40, 60)]


def test_a_move_of_no_length_sets_the_vector_square() -> None:
    path = started(-R).to(40, 0).to(40, 0).to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(path) == [(0, -R), (40, -R), (40 + R, 40), (40, 60)]


def test_a_motion_beside_the_plane_happens_where_the_path_is() -> None:
    path = started().to(40, 0).to(40, 0, -10).to(40, 40).cancel().to(40, 60, same=True).done()
    assert [tuple(m.end) for m in path.motions][1:3] == [(40 - R, R, 0), (40 - R, R, -10)]
    two = started().to(40, 0).to(40, 0, -5).to(40, 0, -10).to(40, 40).cancel().to(40, 60, same=True).done()
    assert [tuple(m.end) for m in two.motions][1:4] == [(40, R, 0), (40, R, -5), (40, R, -10)]


def test_every_move_of_a_run_is_a_step() -> None:
    points = np.array([[0.0, 0, 0], [40, 0, 0], [40, 40, 0]])
    lines, numbers = np.array([3, 4]), np.array([-1, -1])
    run = Polyline("test", points, np.array([1000.0, 1000.0]), lines, numbers, np.zeros(3))
    contour = started()
    contour.blocks.append(run)
    path = compensate([*contour.blocks, Stop(Source("test", 5), StopKind.PROGRAM_END)])
    assert places(path) == [(0, R), (40 - R, R), (40 - R, 40)]
    steps = [(type(block).__name__, block.source.line) for block in path.blocks if isinstance(block, Line | BlockEnd)]
    assert steps[1:5] == [("Line", 3), ("BlockEnd", 3), ("Line", 4), ("BlockEnd", 4)]


# ---------------------------------------------------------------------------------------------------- changes


def test_a_new_radius_holds_at_the_end_of_its_block() -> None:
    path = started().to(40, 0).select(2 * R).to(80, 0, same=True).to(80, 60).cancel().to(80, 80, same=True).done()
    assert places(path) == [(0, R), (40, R), (80 - 2 * R, 2 * R), (80 - 2 * R, 60), (80, 80)]


def test_the_vector_goes_and_comes_with_d0() -> None:
    path = started().to(40, 0).select(0.0).to(80, 0, same=True).select(R).to(120, 0, same=True).to(160, 0).done()
    assert places(path) == [(0, R), (40, R), (80, 0), (120, R), (160, R)]


def test_a_new_radius_over_an_arc_changes_its_radius_on_the_way() -> None:
    contour = started().to(40, 0).select(R + 1).arc(40, 40, 40, 20, 180, same=True).to(0, 40)
    path = driven(contour.cancel().to(-20, 40, same=True))
    arcs = [m for m in path.motions if isinstance(m, Arc)]
    distances = [math.dist(arc.end[:2], (40, 20)) for arc in arcs]
    assert distances[0] < 15
    assert distances[-1] == pytest.approx(14)
    assert all(a > b for a, b in pairwise(distances))
    assert sum(arc.angle for arc in arcs) == pytest.approx(180)


def test_the_side_changes_where_both_paths_meet() -> None:
    """Right of y = 0 and left of x = 40 downwards: both meet at (45, -5), one radius beyond the end."""
    path = started(-R).to(40, 0).select(R).to(40, -40, same=True).to(80, -40).done()
    assert places(path)[:3] == [(0, -R), (40 + R, -R), (40 + R, -40 + R)]


def test_straight_on_the_side_changes_square_to_the_motion() -> None:
    path = started(-R).to(40, 0).select(R).to(80, 0, same=True).to(120, 0).done()
    assert places(path) == [(0, -R), (40, -R), (40, R), (80, R), (120, R)]


def test_the_side_changes_where_an_arc_meets_a_line() -> None:
    """Outside of a half circle of radius 20, then down on its other side: the circle of radius 25 comes to x = 55 at y = -20."""
    path = started(R).to(20, 0).arc(60, 0, 40, 0, -180).select(-R).to(60, -60, same=True).to(60, -90).done()
    assert places(path)[2:] == [(55, -20), (55, -60), (55, -90)]


def test_a_full_circle_may_be_passed_by_more_than_a_turn() -> None:
    """The example with two changes of the side: both paths along the lines meet the circle beyond its top, on either side."""
    contour = Contour(0, 0).select(-R).to(30, -40, same=True).select(R).arc(30, -40, 30, -80, -360, same=True)
    path = contour.select(-R).to(60, 0, same=True).to(90, 40).done()
    (arc,) = (m for m in path.motions if isinstance(m, Arc))
    along = 32 - math.sqrt(45**2 - 19**2)  # on the path beside the first line, from (26, -43)
    meeting = (26 + 0.6 * along, -43 - 0.8 * along)
    assert np.allclose(arc.start[:2], meeting)
    assert np.allclose(arc.end[:2], (60 - meeting[0], meeting[1]))
    beyond = math.degrees(math.asin((30 - meeting[0]) / 45))
    assert arc.angle == pytest.approx(-360 - 2 * beyond)


def test_a_side_change_over_an_arc_moves_its_centre() -> None:
    """Inside of a half circle, then straight on at its other side: the offsets do not meet. An arc of the programmed radius leads
    from the start of the path along the arc to the point square to the start of the line."""
    path = started(R).to(40, 0).arc(40, 40, 40, 20, 180).select(-R).to(0, 40, same=True).to(-40, 40).done()
    arc = next(m for m in path.motions if isinstance(m, Arc))
    assert arc.radius == pytest.approx(20)
    assert tuple(arc.centre) == pytest.approx((40, 25))
    assert arc.angle == pytest.approx(180)
    assert places(path)[2:] == [(40, 45), (0, 45), (-40, 45)]


def test_a_side_change_over_an_arc_that_does_not_reach_is_an_error() -> None:
    """As before, but 10 mm on the other side: 45 mm are more than the arc has across."""
    path = started(R).to(40, 0).arc(40, 40, 40, 20, 180).select(-2 * R).to(0, 40, same=True).to(-40, 40).done()
    assert path.error is not None
    assert path.error.problem.entry is catalogue.CHANGE_IMPOSSIBLE
    assert path.error.problem.place.line == 3


def test_a_vector_that_is_held_is_used_again() -> None:
    path = started().to(60, 60).order(VectorOrder.HOLD).to(150, 20).to(170, 90).to(230, 90).done()
    u, v = np.array([1, 1]) / math.sqrt(2), np.array([90, -40]) / math.hypot(90, 40)
    square = np.array([[-u[1], u[0]], [-v[1], v[0]]])
    vector = R * (square[0] + square[1]) / (1 + square[0] @ square[1])  # to the meeting point of both tangents
    assert np.allclose(places(path)[1:3], [np.array([60, 60]) + vector, np.array([150, 20]) + vector], atol=1e-6)


def test_a_vector_is_held_over_several_blocks_to_recede() -> None:
    """The last vector is square to a straight contour: away from it and back, without end of the compensation."""
    contour = started(-R).to(40, 0)
    for place in ((90, 0), (90, -70), (90, 0)):
        contour.order(VectorOrder.HOLD).to(*place)
    path = contour.to(150, 0).to(190, 0).done()
    assert places(path) == [(0, -R), (40, -R), (90, -R), (90, -70 - R), (90, -R), (150, -R), (190, -R)]


def test_a_corner_arc_goes_around_the_corner() -> None:
    path = started(R).to(100, 0).order(VectorOrder.CORNER_ARC).to(100, -80).cancel().to(100, -100, same=True).done()
    arc = next(m for m in path.motions if isinstance(m, Arc))
    assert tuple(arc.centre) == (100, 0)
    assert arc.angle == pytest.approx(-90)  # G02 in G41
    assert places(path)[1:3] == [(100, R), (100 + R, 0)]


def test_a_corner_arc_can_end_square_to_a_direction() -> None:
    contour = started(R).to(100, 0).order(VectorOrder.CORNER_ARC, (50, -60))
    path = contour.cancel().to(210, 30, same=True).done()
    u = np.array([50, -60]) / math.hypot(50, 60)
    assert np.allclose(places(path)[2], np.array([100, 0]) + R * np.array([-u[1], u[0]]), atol=1e-6)
    assert places(path)[3] == (210, 30)


def test_at_an_inside_corner_no_arc_is_inserted() -> None:
    with_it = started().to(40, 0).order(VectorOrder.CORNER_ARC).to(40, 40).cancel().to(40, 60, same=True).done()
    assert places(with_it) == [(0, R), (40 - R, R), (40 - R, 40), (40, 60)]


def test_a_change_of_the_system_takes_the_vector_away_for_a_moment() -> None:
    contour = started().to(80, 0).order(VectorOrder.SUSPEND).order(VectorOrder.RESUME).to(120, 0).to(160, 0)
    assert places(contour.done()) == [(0, R), (80, 0), (120, R), (160, R)]


def test_motions_of_a_suspension_are_driven_as_they_are() -> None:
    contour = started().to(80, 0).order(VectorOrder.SUSPEND).raw(80, 50).raw(90, 0).order(VectorOrder.RESUME)
    path = contour.to(120, 0).to(160, 0).done()
    assert places(path) == [(0, R), (80, 0), (80, 50), (90, 0), (120, R), (160, R)]


def test_a_suspension_behind_blocks_without_motion_drives_the_vector_away() -> None:
    contour = started().to(80, 0).dwell().dwell().dwell().order(VectorOrder.SUSPEND).order(VectorOrder.RESUME)
    path = contour.to(120, 0).to(160, 0).done()
    assert places(path) == [(0, R), (80, R), (80, 0), (120, R), (160, R)]


@pytest.mark.parametrize("before", [True, False])
def test_a_suspension_beside_an_arc_is_an_error(before: bool) -> None:
    contour = started()
    if before:
        contour.arc(40, 0, 20, 0, 180)
    else:
        contour.to(40, 0)
    contour.order(VectorOrder.SUSPEND).order(VectorOrder.RESUME)
    if before:
        contour.to(80, 0)
    else:
        contour.arc(80, 0, 60, 0, 180)
    error = contour.done().error
    assert error is not None
    assert error.problem.entry is catalogue.AFTER_ARC


# ---------------------------------------------------------------------------------------------------- interference


def groove(settings: VectorSettings) -> Path:
    """A groove of 8 mm, in which the tool of radius 5 does not fit."""
    contour = started(settings=settings).to(40, 0).to(40, -20).to(48, -20).to(48, 0).to(80, 0)
    return contour.cancel().to(100, 0, same=True).done()


def test_interference_is_told_before_the_block_in_front_of_it() -> None:
    path = groove(VectorSettings())
    assert path.error is not None
    assert path.error.problem.entry is catalogue.INTERFERENCE
    assert path.error.problem.place.line == 4
    assert [m.source.line for m in path.motions] == [1, 2]  # the block in front of the faulty one does not begin


def test_without_the_check_it_is_driven_backwards() -> None:
    path = groove(VectorSettings(checked=False))
    assert path.error is None
    xs = [m.end[0] for m in path.motions if m.source.line == 4]
    assert xs[0] == pytest.approx(48 - R)  # from 45 back to 43


def test_vectors_are_left_out_until_nothing_interferes() -> None:
    """An acute outside corner, 2 mm, an inside corner that takes 8 mm away: it would run back by 1 mm from the second of the two
    vectors, but not from the first."""
    u = np.array([-1, 1]) / math.sqrt(2)
    corner = np.array([40, 0]) + 2 * u
    direction = math.radians(135) - 2 * math.atan(1.6)
    far = corner + 100 * np.array([math.cos(direction), math.sin(direction)])

    def path(settings: VectorSettings) -> Path:
        return started(-R, settings).to(40, 0).to(*corner).to(*far).done()

    plain = path(USUAL)
    assert plain.error is not None
    assert plain.error.problem.entry is catalogue.INTERFERENCE
    there = places(path(VectorSettings(repaired=True)))
    end = np.array([40, 0]) + R * np.array([1, 1]) / math.sqrt(2) + (2 - R * 1.6) * u
    assert np.allclose(there[:3], [(0, -R), (40 + R, -R), (end[0], end[1])], atol=1e-6)
    assert len(there) == 4


def test_what_cannot_be_repaired_is_an_error() -> None:
    path = groove(VectorSettings(repaired=True))
    assert path.error is not None
    assert path.error.problem.entry is catalogue.INTERFERENCE


def test_an_arc_smaller_than_the_tool_is_interference() -> None:
    path = started().to(40, 0).arc(40, 6, 40, 3, 180).to(0, 6).done()
    assert path.error is not None
    assert path.error.problem.entry is catalogue.INTERFERENCE


def test_vectors_that_are_near_to_each_other_become_one() -> None:
    """Just beyond a right angle two vectors lie 0.2 mm apart; with DELTV above that only the first is kept."""

    def path(gap: float) -> list[tuple[float, float]]:
        contour = started(-R, VectorSettings(least_gap=gap)).to(40, 0).to(38, 40)
        return places(contour.cancel().to(36, 80, same=True).done())

    apart = path(0.0)
    assert len(apart) == 5
    gap = max(abs(apart[2][0] - apart[1][0]), abs(apart[2][1] - apart[1][1]))
    assert 0 < gap < 1
    assert path(gap * 1.01) == [apart[0], apart[1], *apart[3:]]
    assert path(gap * 0.99) == apart


# ---------------------------------------------------------------------------------------------------- laws


@st.composite
def contours(draw: st.DrawFn) -> tuple[Contour, tuple[float, float]]:
    """Anything that a program can say between G41 and G40, and where it ends."""
    repaired = draw(st.booleans())
    settings = VectorSettings(draw(st.sampled_from([0.0, 0.5])), draw(st.booleans()), repaired)
    contour = Contour(settings=settings)
    place = st.tuples(st.integers(-40, 40), st.integers(-40, 40))
    offsets = st.sampled_from([R, -R, 0.0, 2 * R, -1.0])
    contour.select(draw(offsets)).to(*draw(place), same=draw(st.booleans()))
    for _ in range(draw(st.integers(0, 10))):
        x, y = contour.place
        match draw(st.integers(0, 9)):
            case 0 | 1 | 2:
                contour.to(*draw(place))
            case 3:
                radius, turn = (
                    draw(st.sampled_from([3.0, 8.0, 30.0])),
                    draw(st.sampled_from([90.0, -90.0, 180.0, -360.0])),
                )
                begin = math.radians(draw(st.integers(0, 359)))
                cx, cy = x - radius * math.cos(begin), y - radius * math.sin(begin)
                end = begin + math.radians(turn)
                contour.arc(cx + radius * math.cos(end), cy + radius * math.sin(end), cx, cy, turn)
            case 4:
                contour.dwell()
            case 5:
                contour.to(x, y, draw(st.integers(-5, 5)))
            case 6:
                contour.select(draw(offsets))
            case 7:
                contour.order(VectorOrder.HOLD).to(*draw(place))
            case 8:
                contour.order(VectorOrder.CORNER_ARC, draw(st.sampled_from([None, (3.0, -4.0)])))
            case 9:
                contour.order(VectorOrder.SUSPEND)
                if draw(st.booleans()):
                    contour.to(*draw(place))
                contour.order(VectorOrder.RESUME)
    contour.cancel().to(*draw(place), same=draw(st.booleans()))
    if contour.blocks[-1].start is contour.blocks[-1].end:  # type: ignore[union-attr]
        contour.to(100, 100)
    contour.to(90, -90)
    return contour, (90.0, -90.0)


@settings(deadline=None, derandomize=True, max_examples=200)
@given(contours())
def test_whatever_is_programmed_the_path_is_continuous_and_comes_to_its_end(
    drawn: tuple[Contour, tuple[float, float]],
) -> None:
    """Or an error of the catalogue tells why not, and what came before is continuous, too."""
    contour, end = drawn
    out: list[Block] = []
    error = None
    try:
        for block in ToolRadiusCompensation()([*contour.blocks, Stop(Source("test", 99), StopKind.PROGRAM_END)]):
            out.append(block)  # noqa: PERF402 - what came before an error counts
    except CompensationError as told:
        error = told.problem.entry
    motions = [block for block in out if isinstance(block, Line | Arc)]
    for one, other in pairwise(motions):
        assert np.abs(other.start - one.end).max() < 1e-9
    for arc in (motion for motion in motions if isinstance(motion, Arc)):
        begin, goal = math.dist(arc.start[:2], arc.centre), math.dist(arc.end[:2], arc.centre)
        assert abs(begin - goal) < 1.1e-3
        phi, u = math.radians(arc.angle), arc.start[:2] - arc.centre
        turned = np.array([u[0] * math.cos(phi) - u[1] * math.sin(phi), u[0] * math.sin(phi) + u[1] * math.cos(phi)])
        assert np.linalg.norm(arc.centre + turned - arc.end[:2]) < 1.2e-3
    if error is None:
        assert tuple(motions[-1].end[:2]) == end
        dwells = sum(isinstance(block, Dwell) for block in contour.blocks)
        assert sum(isinstance(block, Dwell) for block in out) == dwells  # nothing is lost
    else:
        assert error in vars(catalogue).values()


@st.composite
def outlines(draw: st.DrawFn) -> list[tuple[float, float]]:
    """Corners of a polygon around zero, seen from there in order, far from each other: star-shaped, counter-clockwise."""
    count = draw(st.integers(3, 9))
    radii = draw(st.lists(st.floats(60.0, 90.0), min_size=count, max_size=count))
    return [(r * math.cos(2 * math.pi * i / count), r * math.sin(2 * math.pi * i / count)) for i, r in enumerate(radii)]


def _distance(point: Iterable[float], outline: list[tuple[float, float]]) -> float:
    p = np.array(list(point))
    least = math.inf
    for i, end in enumerate(outline):
        a, b = np.array(outline[i - 1]), np.array(end)
        t = min(1.0, max(0.0, float((p - a) @ (b - a) / ((b - a) @ (b - a)))))
        least = min(least, float(np.linalg.norm(a + t * (b - a) - p)))
    return least


@settings(deadline=None, derandomize=True)
@given(outlines(), st.floats(0.5, 8.0))
def test_the_tool_never_comes_nearer_than_its_radius(outline: list[tuple[float, float]], radius: float) -> None:
    """Around the outside of a polygon, as long as nothing interferes."""
    middle = (np.array(outline[-1]) + outline[0]) / 2
    away = middle * 2
    contour = Contour(away[0], away[1]).select(-radius).to(middle[0], middle[1], same=True)
    for x, y in [*outline, (middle[0], middle[1])]:
        contour.to(x, y)
    path = contour.cancel().to(away[0], away[1], same=True).done()
    if path.error is not None:
        assert path.error.problem.entry is catalogue.INTERFERENCE
        return
    for motion in path.motions[1:-1]:
        for share in np.linspace(0, 1, 7):
            place = motion.start + share * (motion.end - motion.start)
            assert _distance(place[:2], outline) > radius - 1e-6
