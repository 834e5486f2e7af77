"""Additions of a motion block: #ANG, #CANG, #CHR, #CHF, #RND, #FRC, G301, G302 (programming manual 2420–2952, 5291–5555)."""

from __future__ import annotations

import math

from runtime.cnc.blocks import Arc, Corner, CornerKind, Line, Polyline
from runtime.cnc.decoder.circles import by_opening_angle
from runtime.cnc.decoder.contour_lines import ContourLines
from runtime.cnc.decoder.corners import with_corner
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import require_feed
from runtime.cnc.decoder.modal import PLANE_AXES, Motion
from runtime.cnc.decoder.motion import centre_point, clockwise, emit_arc, plane_of, straight, target
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue

_SIZES = {
    "CHR": CornerKind.CHAMFER_WIDTH,
    "CHF": CornerKind.CHAMFER_LENGTH,
    "RND": CornerKind.ROUNDING,
}
_BY_NUMBER = {301: CornerKind.CHAMFER_WIDTH, 302: CornerKind.ROUNDING}


def corner_of(x: Execution, block: CompiledBlock) -> Corner | None:
    """The chamfer or rounding that the block asks for at its end. LineError for two of them, or a feed without any."""
    asked = [(kind, x.additions[name]) for name, kind in _SIZES.items() if name in x.additions]
    asked += [
        (_BY_NUMBER[slots.word.index], x.values[slots.value])
        for slots in block.g
        if slots.word.index in _BY_NUMBER and slots.value >= 0
    ]
    column = block.column(WordKind.ADDITION)
    if len(asked) > 1:
        raise LineError(catalogue.CORNER_TWICE, column)
    feed = _corner_feed(x, column)
    if not asked:
        if feed is not None:
            raise LineError(catalogue.CORNER_FEED_ALONE, column)
        return None
    kind, size = asked[0]
    return Corner(kind, _size(x.length(size), column), feed)


def _corner_feed(x: Execution, column: int) -> float | None:
    if "FRC" not in x.additions:
        return None
    feed = x.length(x.additions["FRC"]) * x.setup.feed_factor
    if not 0 < feed < math.inf:
        raise LineError(catalogue.FEED_INVALID, column, value=x.additions["FRC"])
    return feed


def _size(size: float, column: int) -> float:
    if not 0 < size < math.inf:
        raise LineError(catalogue.CORNER_SIZE, column, size=size, what="chamfer or rounding")
    return size


def corner_block(x: Execution, kind: CornerKind, column: int) -> None:
    """G301 or G302 as a block of its own: the motion before it gets the corner. The size is kept for the next ones."""
    assert x.block is not None
    x.axes_taken = True
    if x.axis_words:
        raise LineError(catalogue.CORNER_BLOCK, column)
    if 0 in x.letters:
        x.modal.corner_size = _size(x.length(x.letters[0]), column)
    if x.modal.corner_size is None:
        raise LineError(catalogue.CORNER_SIZE, column, size=0.0, what="chamfer or rounding")
    feed = _corner_feed(x, column)
    if x.block.feed >= 0 and feed is None:
        x.take_feed()
        feed = x.modal.feed
    corner = Corner(kind, x.modal.corner_size, feed)
    x.flush_run()
    for place in range(len(x.out) - 1, -1, -1):
        block = x.out[place]
        if isinstance(block, Line | Arc | Polyline):
            x.out[place : place + 1] = with_corner(block, corner, PLANE_AXES[x.modal.plane])
            return
    raise LineError(catalogue.CORNER_WITHOUT_MOTION, column)


def arc_by_angle(x: Execution, block: CompiledBlock, corner: Corner | None) -> bool:
    """A circle by centre and opening angle (#CANG); whether the block was one."""
    if "CANG" not in x.additions:
        return False
    column = block.column(WordKind.ADDITION)
    if x.modal.motion not in (Motion.CIRCLE_CW, Motion.CIRCLE_CCW):
        raise LineError(catalogue.ANGLE_WITHOUT_CIRCLE, column)
    require_feed(x, block)
    plane, letters, _ = plane_of(x, block)
    if any(axis in plane for axis in x.axis_words):
        raise LineError(catalogue.ANGLE_AND_TARGET, column)
    start = x.coordinates.position
    begin = (start[plane[0]], start[plane[1]])
    centre = centre_point(x, plane, letters)
    circle, goal = by_opening_angle(begin, centre, x.additions["CANG"], clockwise(x))
    end = target(x, block)
    end[plane[0]], end[plane[1]] = goal
    emit_arc(x, block, end, plane, circle, corner)
    x.modal.radius = None
    x.coordinates.moved(end)
    return True


# ---------------------------------------------------------------------------------------------------- contour lines


def contour_line(x: Execution, block: CompiledBlock, corner: Corner | None) -> bool:
    """A line by its angle (#ANG); whether the block was one."""
    lines: ContourLines = x.state.setdefault("contour lines", ContourLines())
    if "ANG" not in x.additions:
        lines.expect_none()
        return False
    column = block.column(WordKind.ADDITION)
    if x.modal.motion in (Motion.CIRCLE_CW, Motion.CIRCLE_CCW):
        raise LineError(catalogue.ANGLE_WITH_CIRCLE, column)
    plane, _, _ = plane_of(x, block)
    end = target(x, block)
    start = x.coordinates.position
    given = tuple(end[axis] if axis in x.axis_words else None for axis in plane)
    angle = _machine_angle(x, plane, x.additions["ANG"])
    waited = lines.waiting
    points = lines.add((start[plane[0]], start[plane[1]]), angle, (given[0], given[1]), not x.modal.incremental)
    if points is None:
        x.state["contour block"] = (block, x.source, x.modal.copy(), corner, dict(x.axis_words))
        return True
    if waited:
        _first_of_two(x, plane, points[0])
        points = points[1:]
        end = [
            p if axis not in x.axis_words or axis in plane else end[axis]
            for axis, p in enumerate(x.coordinates.position)
        ]
    for place, axis in enumerate(plane):
        end[axis] = points[0][place]
    straight(x, block, end, corner)
    x.coordinates.moved(end)
    return True


def _first_of_two(x: Execution, plane: tuple[int, int], corner_point: tuple[float, float]) -> None:
    """The motion of the block that waited for this one, as it was programmed."""
    block, source, modal, corner, words = x.state.pop("contour block")
    own = (x.source, x.modal, x.axis_words)
    x.source, x.modal, x.axis_words = source, modal, words
    try:
        end = target(x, block)
        for place, axis in enumerate(plane):
            end[axis] = corner_point[place]
        straight(x, block, end, corner)
        x.coordinates.moved(end)
    finally:
        x.source, x.modal, x.axis_words = own


def _machine_angle(x: Execution, plane: tuple[int, int], angle: float) -> float:
    """The direction on the machine of a programmed angle: rotated and mirrored like coordinates."""
    c = x.coordinates
    if c.rotation is not None and c.rotation.plane == plane:
        angle += c.rotation.angle
    signs = [c.mirror_plane[axis] * c.mirror_axis[axis] for axis in plane]
    if signs == [1.0, 1.0]:
        return angle
    direction = math.radians(angle)
    return math.degrees(math.atan2(math.sin(direction) * signs[1], math.cos(direction) * signs[0]))
