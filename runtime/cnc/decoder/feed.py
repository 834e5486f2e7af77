"""What F means: mm/min, s per block, mm per revolution, or a share of the greatest axis velocity (lines 5260–5287)."""

from __future__ import annotations

import math

from runtime.cnc.decoder.circles import Circle
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed_group import MAIN_AXES, queue_length
from runtime.cnc.decoder.modal import FeedMode
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.motion_words import MotionBlock, WordKind
from runtime.diagnostics.catalogue import language as catalogue


def require_feed(x: Execution, block: MotionBlock) -> None:
    """LineError if no F of the active mode is programmed, or one that moves nothing."""
    feed = x.modal.feed
    if feed is None:
        column = block.column(WordKind.AXIS if block.axes else WordKind.INTERPOLATION)
        raise LineError(catalogue.FEED_MISSING, column, motion=int(x.modal.motion))
    if feed <= 0:
        raise LineError(catalogue.FEED_INVALID, block.column(WordKind.FEED), value=feed)


def feed_of(
    x: Execution,
    block: MotionBlock,
    start: list[float],
    end: list[float],
    arc: tuple[tuple[int, ...], Circle] | None,
) -> float:
    """The path feed of a move in mm/min (degrees/min if only rotary axes move); of an arc with its axes and its circle."""
    modal = x.modal
    feed = modal.feed
    assert feed is not None
    if modal.feed_mode is FeedMode.PER_MINUTE:
        return feed * group_ratio(x, block, start, end, arc)
    if modal.feed_mode is FeedMode.PER_REVOLUTION:
        if not modal.speed > 0:
            raise LineError(catalogue.FEED_SPINDLE, block.column(WordKind.FEED))
        ratio = 1.0 if x.feed_group.reference is not None else group_ratio(x, block, start, end, arc)
        return feed * modal.speed * ratio
    way = [e - s for s, e in zip(start, end, strict=True)]
    length = path_length(way, arc)
    if length <= 0:
        return 1.0  # nothing moves
    if modal.feed_mode is FeedMode.TIME:
        return length / feed * 60.0
    # G194: one axis of the block runs at this share of its greatest velocity
    share = feed / 100.0
    if arc is not None:
        plane, circle = arc
        along = abs(math.radians(circle.angle)) * circle.radius
        for axis in plane if x.coordinates.frame is None else range(MAIN_AXES):
            way[axis] = along  # somewhere on an arc both axes may have to run at path velocity
    elif x.coordinates.frame is not None:
        way[:MAIN_AXES] = (x.coordinates.frame.rotation @ way[:MAIN_AXES]).tolist()
    times = [
        abs(way[axis]) / velocity for axis, velocity in enumerate(x.setup.axis_velocity) if velocity > 0 and way[axis]
    ]
    return length / max(times) * share * 60.0 if times else feed


def group_ratio(
    x: Execution,
    block: MotionBlock,
    start: list[float],
    end: list[float],
    arc: tuple[tuple[int, ...], Circle] | None,
) -> float:
    """Speed along the path, as the queue measures it, per speed of the feed axes (#FGROUP)."""
    group = x.feed_group
    if group.plain:
        return 1.0
    way = [e - s for s, e in zip(start, end, strict=True)]
    length = path_length(way, arc)
    if arc is None:
        driven = group.line_length(way)
    else:
        driven = group.arc_length(way, length, block.column(WordKind.AXIS))
    return length / driven if driven > 0 and length > 0 else 1.0


def path_length(way: list[float], arc: tuple[tuple[int, ...], Circle] | None) -> float:
    """The length that the queue measures: along the main axes, or the other axes if no main axis moves."""
    if arc is not None:
        plane, circle = arc
        rest = [w for axis, w in enumerate(way[:MAIN_AXES]) if axis not in plane]
        return math.hypot(abs(math.radians(circle.angle)) * circle.radius, *rest)
    return queue_length(way)
