"""Additions of a motion block: #ANG, #CANG, #CHR, #CHF, #RND, #FRC, G301, G302 (programming manual 2420–2952, 5291–5555).

A contour line whose target is not known yet holds everything back that the program puts out: the next one puts the motion of
the first in front of it (`WaitingLine.place`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace

from runtime.cnc.blocks import Arc, Corner, CornerKind, Line, Polyline, Source, SpatialArc
from runtime.cnc.decoder.circles import by_opening_angle
from runtime.cnc.decoder.contour_lines import ContourLineError, Point
from runtime.cnc.decoder.corners import with_corner
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import require_feed
from runtime.cnc.decoder.feed_word import FeedChange
from runtime.cnc.decoder.modal import PLANE_AXES, FeedMode, ModalState, Motion
from runtime.cnc.decoder.motion import (
    centre_point,
    clockwise,
    emit_arc,
    expect_in_range,
    note_circle,
    plane_of,
    size_scale,
    straight,
    target,
)
from runtime.cnc.decoder.turning import halved
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
_NAMES = {CornerKind.CHAMFER_WIDTH: "chamfer", CornerKind.ROUNDING: "rounding"}


# ---------------------------------------------------------------------------------------------------- corners


def corner_of(x: Execution, block: CompiledBlock) -> Corner | None:
    """The chamfer or rounding that the block asks for at its end. LineError for two of them, or a feed without any."""
    asked = [(kind, x.additions[name]) for name, kind in _SIZES.items() if name in x.additions]
    asked += [
        (_BY_NUMBER[slots.word.index], x.values[slots.value])
        for slots in block.g
        if slots.word.index in _BY_NUMBER and slots.value >= 0
    ]
    if not asked and "FRC" not in x.additions:
        return None
    column = block.column(WordKind.ADDITION if x.additions else WordKind.G)
    if len(asked) > 1:
        raise LineError(catalogue.CORNER_TWICE, column)
    if not asked:
        raise LineError(catalogue.CORNER_FEED_ALONE, column)
    kind, size = asked[0]
    return Corner(kind, _scaled(x, block, _size(x.length(size), column)), _own_feed(x, column))


def _scaled(x: Execution, block: CompiledBlock, size: float) -> float:
    """A size on the machine: the contour around it is scaled too."""
    plane, _, _ = plane_of(x, block)
    return size * size_scale(x, plane)


def _own_feed(x: Execution, column: int) -> float | None:
    """The feed of #FRC in mm/min, None without."""
    if "FRC" not in x.additions:
        return None
    value = x.length(x.additions["FRC"])
    return insert_feed(x, value * (x.setup.feed_factor if x.modal.feed_mode is FeedMode.PER_MINUTE else 1.0), column)


def insert_feed(x: Execution, feed: float, column: int) -> float:
    """A feed in mm/min or mm/rev as that of an inserted element, in mm/min."""
    mode = x.modal.feed_mode
    if mode not in (FeedMode.PER_MINUTE, FeedMode.PER_REVOLUTION):
        raise LineError(catalogue.CORNER_FEED_MODE, column, number=int(mode))
    if mode is FeedMode.PER_REVOLUTION:
        if not x.modal.speed > 0:
            raise LineError(catalogue.FEED_SPINDLE, column)
        feed *= x.modal.speed
    if not 0 < feed < math.inf:
        raise LineError(catalogue.FEED_INVALID, column, value=feed)
    return feed


def _size(size: float, column: int) -> float:
    if not 0 < size < math.inf:
        raise LineError(catalogue.CORNER_SIZE, column, size=size, what="chamfer or rounding")
    return size


def corner_block(x: Execution, kind: CornerKind, column: int) -> None:
    """G301 or G302 as a block of its own: the motion before it gets the corner. The size is kept for the next ones."""
    block = x.block
    assert block is not None
    x.axes_taken = True
    if x.axis_words:
        raise LineError(catalogue.CORNER_BLOCK, column)
    if x.additions.keys() - {"FRC"}:
        raise LineError(catalogue.CORNER_TWICE, block.column(WordKind.ADDITION))
    if 0 in x.letters:
        x.modal.corner_size = _size(x.length(x.letters[0]), column)
    if x.modal.corner_size is None:
        raise LineError(catalogue.CORNER_SIZE, column, size=0.0, what=_NAMES[kind])
    x.take_feed()
    feed = _own_feed(x, block.column(WordKind.ADDITION))
    if block.feed >= 0 and feed is None and x.modal.feed is not None:
        feed = insert_feed(x, x.modal.feed, block.column(WordKind.FEED))
    x.additions = {}
    corner = Corner(kind, _scaled(x, block, x.modal.corner_size), feed)
    if x.waiting_line is not None:
        if x.waiting_line.corner is not None:
            raise LineError(catalogue.CORNER_TWICE, column)
        x.waiting_line = replace(x.waiting_line, corner=corner)
        return
    x.flush_run()
    for place in range(len(x.out) - 1, -1, -1):
        motion = x.out[place]
        if isinstance(motion, SpatialArc):
            reason = "the motion before it is an arc in space"
            raise LineError(catalogue.CORNER_NEIGHBOUR, column, what=_NAMES[kind], reason=reason)
        if isinstance(motion, Line | Arc | Polyline):
            if isinstance(motion, Polyline):
                if motion.one_block:
                    raise LineError(catalogue.FEED_CHANGE_BESIDE, column, word="chamfer or rounding")
            elif motion.corner is not None:
                raise LineError(catalogue.CORNER_TWICE, column)
            x.out[place : place + 1] = with_corner(motion, corner, PLANE_AXES[x.modal.plane])
            return
    raise LineError(catalogue.CORNER_WITHOUT_MOTION, column)


def expect_motion(x: Execution, block: CompiledBlock, corner: Corner | None) -> None:
    """LineError for additions in a block that has no motion, or whose axis words are arguments."""
    if corner is not None or x.additions:
        column = block.column(WordKind.ADDITION if x.additions else WordKind.G)
        raise LineError(catalogue.ADDITION_WITHOUT_MOTION, column)


# ---------------------------------------------------------------------------------------------------- circles


def arc_by_angle(x: Execution, block: CompiledBlock, corner: Corner | None) -> bool:
    """A circle by centre and opening angle (#CANG); whether the block was one."""
    if "CANG" not in x.additions:
        return False
    column = block.column(WordKind.ADDITION)
    if x.modal.motion not in (Motion.CIRCLE_CW, Motion.CIRCLE_CCW):
        raise LineError(catalogue.ANGLE_WITHOUT_CIRCLE, column)
    require_feed(x, block)
    plane, letters, pitch = plane_of(x, block)
    if block.radius >= 0:
        raise LineError(catalogue.CENTRE_AND_RADIUS, block.column(WordKind.RADIUS))
    third = "IJK".index(pitch)
    if third in x.letters:
        raise LineError(catalogue.ANGLE_AND_PITCH, block.column(WordKind.INTERPOLATION, third), letter=pitch)
    if any(axis in plane for axis in x.axis_words):
        raise LineError(catalogue.ANGLE_AND_TARGET, column)
    start = x.coordinates.position
    begin = (start[plane[0]], start[plane[1]])
    centre = centre_point(x, plane, letters)
    circle, goal = by_opening_angle(begin, centre, x.additions["CANG"], clockwise(x))
    end = target(x, block)
    end[plane[0]], end[plane[1]] = goal
    expect_in_range(x, block, end)
    note_circle(x, plane, circle, centre)
    emit_arc(x, block, end, plane, circle, corner)
    x.modal.radius = None
    x.coordinates.moved(end)
    return True


# ---------------------------------------------------------------------------------------------------- contour lines


@dataclass(frozen=True, slots=True)
class WaitingLine:
    """A block with a contour line whose target the next one gives: what of the block its motion needs.

    `place`: where its motion belongs in `Execution.out`. `system`: what was selected in the coordinates.
    """

    block: CompiledBlock
    source: Source
    modal: ModalState
    corner: Corner | None
    words: dict[int, float]
    incremental_words: dict[int, bool]
    end_feed: float | None
    feed_change: tuple[FeedChange, float] | None
    override_off: bool
    place: int
    system: tuple[object, ...]


def contour_line(x: Execution, block: CompiledBlock, corner: Corner | None) -> bool:
    """A line by its angle (#ANG); whether the block was one. The geometry is that of the programmed contour."""
    if "ANG" not in x.additions:
        expect_no_line(x)
        return False
    column = block.column(WordKind.ADDITION)
    if x.modal.motion not in (Motion.RAPID, Motion.LINEAR):
        raise LineError(catalogue.ANGLE_WITH_CIRCLE, column)
    if "CANG" in x.additions:
        raise LineError(catalogue.ANGLE_WITHOUT_CIRCLE, column)
    if x.letters:
        letter = "IJK"[next(iter(x.letters))]
        column = block.column(WordKind.INTERPOLATION)
        raise LineError(catalogue.CENTRE_WITHOUT_CIRCLE, column, letter=letter, motion=int(x.modal.motion))
    plane, _, _ = plane_of(x, block)
    target(x, block)  # the words must lie in their range
    waiting, x.waiting_line = x.waiting_line, None
    if waiting is not None and not all(a is b for a, b in zip(waiting.system, _system(x), strict=True)):
        _drop(x, waiting)
        raise LineError(catalogue.CONTOUR_LINE_SYSTEM, column, line=waiting.source.line)
    start = x.coordinates.in_plane(plane)
    incremental = any(x.incremental_words.get(axis, x.modal.incremental) for axis in plane if axis in x.axis_words)
    first, second = (_coordinate(x, axis, start[place]) for place, axis in enumerate(plane))
    try:
        points = x.contour_lines.add(start, x.additions["ANG"], (first, second), not incremental)
    except ContourLineError:
        if waiting is not None:
            _drop(x, waiting)
        raise
    if points is None:
        _wait(x, block, corner)
        return True
    if waiting is not None:
        _release(x, waiting, plane, points[0])
    _line_to(x, block, plane, points[-1], corner)
    return True


def expect_no_line(x: Execution) -> None:
    """ContourLineError if a contour line waits for the next one: something comes that gives it no target."""
    if x.waiting_line is not None:
        waiting, x.waiting_line = x.waiting_line, None
        _drop(x, waiting)
        x.contour_lines.expect_none()


def _coordinate(x: Execution, axis: int, start: float) -> float | None:
    """A programmed coordinate of the target, absolute in mm; None if it is not programmed."""
    if axis not in x.axis_words:
        return None
    words = {axis: x.axis_value(axis, x.axis_words[axis])}
    halved(x, words)
    value = words[axis]
    return start + value if x.incremental_words.get(axis, x.modal.incremental) else value


def _system(x: Execution) -> tuple[object, ...]:
    c = x.coordinates
    return (c.gain, c.shift, c.rotation, x.modal.plane)


def _wait(x: Execution, block: CompiledBlock, corner: Corner | None) -> None:
    if x.modal.motion is Motion.LINEAR:
        require_feed(x, block)
    x.flush_run()
    x.waiting_line = WaitingLine(
        block,
        x.source,
        x.modal.copy(),
        corner,
        dict(x.axis_words),
        dict(x.incremental_words),
        x.end_feed,
        x.feed_change,
        x.override_off,
        len(x.out),
        _system(x),
    )
    x.line_waits = True
    x.modal_changed()


def _drop(x: Execution, waiting: WaitingLine) -> None:
    """The motion will not come: nothing behind it is put out."""
    x.flush_run()
    del x.out[waiting.place :]
    x.line_waits = False


def _release(x: Execution, waiting: WaitingLine, plane: tuple[int, int], corner_point: Point) -> None:
    """Put the motion of the block that waited in front of what was held back."""
    behind = x.out[waiting.place :]
    del x.out[waiting.place :]
    own = (x.source, x.modal, x.axis_words, x.incremental_words, x.end_feed, x.feed_change, x.override_off)
    x.source, x.modal, x.axis_words, x.incremental_words = (
        waiting.source,
        waiting.modal,
        waiting.words,
        waiting.incremental_words,
    )
    x.end_feed, x.feed_change, x.override_off = waiting.end_feed, waiting.feed_change, waiting.override_off
    try:
        _line_to(x, waiting.block, plane, corner_point, waiting.corner)
    finally:
        x.source, x.modal, x.axis_words, x.incremental_words, x.end_feed, x.feed_change, x.override_off = own
    x.out.extend(behind)
    x.line_waits = False
    x.modal_changed()


def _line_to(x: Execution, block: CompiledBlock, plane: tuple[int, int], point: Point, corner: Corner | None) -> None:
    """The motion to a programmed point of the plane, and to the words of the other axes."""
    end = target(x, block)
    end[plane[0]], end[plane[1]] = x.coordinates.machine_in_plane(plane, point)
    expect_in_range(x, block, end)
    straight(x, block, end, corner)
    x.coordinates.moved(end)
