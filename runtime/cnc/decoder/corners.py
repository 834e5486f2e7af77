"""Chamfers and roundings (G301, G302, #CHR, #CHF, #RND; programming manual 5291–5555): a stage behind the decoder.

A motion with a `corner` is held back until the next motion is known; then both are shortened and one line or arc
stands between them:

    Line(corner), M, BlockEnd, M, Line        →        Line', insert, M, BlockEnd, M, Line'

What stood between them comes behind the insert, so that single block, M00 and functions act once, on the new contour.
In the plane the insert is what `corner_geometry` says; every other axis keeps its place on the shortened element and
goes along linearly over the insert.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Corner,
    CornerKind,
    Floats,
    Flush,
    FlushKind,
    FrameChange,
    Hold,
    Homing,
    IndependentMotion,
    Line,
    ManualMotion,
    Polyline,
    PositionSetting,
    Source,
    SpatialArc,
    Stop,
    StopKind,
    TakeOver,
)
from runtime.cnc.decoder import corner_geometry as geometry
from runtime.cnc.language.errors import ProgramError
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue.coordinates import CORNER_SYSTEM
from runtime.diagnostics.errors import ErrorEntry, Place, Problem

Plane = tuple[int, int]

NO_LENGTH = 1e-9  # mm: below it an element has no direction in the plane

_NAMES = {
    CornerKind.CHAMFER_WIDTH: "chamfer",
    CornerKind.CHAMFER_LENGTH: "chamfer (length)",
    CornerKind.ROUNDING: "rounding",
}


class CornerError(ProgramError):
    """A chamfer or rounding is not possible; its place is the motion that it was programmed with."""


class Corners:
    """The stage; a new one for each program. `axes`: names of the channel's axes for messages.

    The insert lies in the plane of the second motion (line 5367) and is part of the first motion's block: its
    `source`, and `end_pcs` with the offset of the first motion. Its feed is that of the corner (#FRC), else the E feed
    of the first motion, else its feed; after a rapid motion the insert is rapid, an arc then has the feed inf. The
    first motion hands its corner over: `corner` of all blocks behind this stage is None.

    A Hold passes through at once. `Flush` STOP and CONTINUE wait behind the insert like everything else. `Flush` WAIT
    would wait for ever for a motion that is held back, and letting it go would give another contour: CornerError.
    Where the blocks end without `Stop` PROGRAM_END (the program was aborted), a motion that is held back is dropped.

    `warnings` collects tangential transitions, where nothing is inserted. Raises CornerError; the motion that was held
    back is not handed on then.
    """

    def __init__(self, axes: tuple[str, ...] = ()) -> None:
        self.warnings: list[Problem] = []
        self._axes = axes

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        held: _Held | None = None
        for block in blocks:
            if isinstance(block, Hold) or (held is None and not isinstance(block, Line | Arc)):
                yield block
                continue
            following: list[Block] = []
            if held is not None:
                if not _is_motion(block):
                    held.between.append(held.expect_no_end(block))
                    continue
                second, *following = _beginning(block, held.motion.plane)
                first, insert, second = self._insert(held, second)
                yield first
                if insert is not None:
                    yield insert
                yield from held.between
                block = second
            held = _Held.of(block)
            if held is None:
                yield block
                yield from following

    def _insert(self, held: _Held, second: Block) -> tuple[Block, Line | Arc | None, Line | Arc]:
        """First motion, insert, second motion; no insert at a tangential transition."""
        first, corner = held.motion, held.corner
        if not isinstance(second, Line | Arc):
            raise held.error(catalogue.CORNER_NEIGHBOUR, reason="the next motion is an arc in space")
        plane = second.plane
        for motion in (first, second):
            if isinstance(motion, Arc) and motion.plane != plane:
                raise held.error(
                    catalogue.CORNER_NEIGHBOUR, reason="this arc lies in another plane than the next motion"
                )
        one, two = _at_its_end(first, plane), _at_its_start(second, plane)
        for motion, element in ((first, one), (second, two)):
            if element.length <= NO_LENGTH:
                raise held.error(
                    catalogue.CORNER_DIRECTION, line=motion.source.line, plane=" ".join(map(self._axis, plane))
                )
        bare = replace(first, corner=None)
        turn = abs(geometry.turn(one, two))
        next_line = second.source.line
        if turn < geometry.TANGENTIAL:
            self.warnings.append(held.error(catalogue.CORNER_TANGENTIAL, next_line=next_line).problem)
            return bare, None, second
        if turn > math.pi - geometry.TANGENTIAL:
            raise held.error(catalogue.CORNER_REVERSAL, next_line=next_line)
        try:
            cut = _CUTS[corner.kind](one, two, corner.size)
        except geometry.TooLargeError as error:
            raise held.error(
                catalogue.CORNER_TOO_LARGE, size=corner.size, largest=error.largest, next_line=next_line
            ) from None
        bare = _until(bare, 1.0 - cut.first / one.length)
        second = _from(second, cut.second / two.length)
        return bare, _between(first, bare.end, second.start, plane, corner, cut), second

    def _axis(self, index: int) -> str:
        return self._axes[index] if index < len(self._axes) else str(index + 1)


_CUTS = {
    CornerKind.CHAMFER_WIDTH: geometry.chamfer,
    CornerKind.CHAMFER_LENGTH: geometry.chamfer_by_length,
    CornerKind.ROUNDING: geometry.rounding,
}


class _Held:
    """A motion that waits for the next one, and the blocks since then."""

    def __init__(self, motion: Line | Arc, corner: Corner) -> None:
        self.motion = motion
        self.corner = corner
        self.between: list[Block] = []

    @classmethod
    def of(cls, block: Block) -> _Held | None:
        """None for a motion without a corner. Raises CornerError for a size that is none."""
        if not isinstance(block, Line | Arc) or block.corner is None:
            return None
        held = cls(block, block.corner)
        if not 0.0 < block.corner.size < math.inf:
            raise held.error(catalogue.CORNER_SIZE, size=block.corner.size)
        return held

    def expect_no_end(self, block: Block) -> Block:
        """The block, if the next motion can still come behind it."""
        if isinstance(block, Stop) and block.kind is StopKind.PROGRAM_END:
            raise self.error(catalogue.CORNER_OPEN)
        if isinstance(block, FrameChange):
            raise self.error(CORNER_SYSTEM, wait_line=block.source.line)
        if isinstance(block, Homing | ManualMotion | TakeOver | PositionSetting | IndependentMotion) or (
            isinstance(block, Flush) and block.kind is FlushKind.WAIT
        ):
            raise self.error(catalogue.CORNER_WAIT, wait_line=block.source.line)
        return block

    def error(self, entry: ErrorEntry, **values: object) -> CornerError:
        source = self.motion.source
        return CornerError(entry, Place(source.program, source.line), what=_NAMES[self.corner.kind], **values)


def _is_motion(block: Block) -> bool:
    return isinstance(block, Line | Arc | SpatialArc) or (isinstance(block, Polyline) and len(block.feeds) > 0)


def _beginning(block: Block, plane: Plane) -> list[Block]:
    """The motion a block begins with, and what is left of the block; `plane` if the block knows none."""
    if not isinstance(block, Polyline):
        return [block]
    line, rest = _move(block, 0, plane), _moves(block, 1, len(block.feeds))
    end = [] if block.one_block else [BlockEnd(line.source)]
    return [line, *end, *rest]


def with_corner(block: Line | Arc | Polyline, corner: Corner, plane: Plane) -> list[Block]:
    """`block` with a corner at its end, for a chamfer or rounding that is programmed in a block of its own.

    Of a run the last move is split off, with its BlockEnd; `plane` is its plane if the run knows none.
    """
    if not isinstance(block, Polyline):
        return [replace(block, corner=corner)]
    last = len(block.feeds) - 1
    line = replace(_move(block, last, plane), corner=corner)
    end = [] if block.one_block else [BlockEnd(line.source)]
    return [*_moves(block, 0, last), line, *end]


def _move(run: Polyline, index: int, plane: Plane) -> Line:
    """A segment of a run as a block of its own."""
    number = int(run.numbers[index])
    feed = float(run.feeds[index])
    return Line(
        Source(run.program, int(run.lines[index]), number if number >= 0 else None),
        run.points[index],
        run.points[index + 1],
        feed,
        math.isinf(feed),
        (run.points[index + 1] - run.pcs_shift) / (1.0 if run.pcs_gain is None else run.pcs_gain),
        run.plane or plane,
        pcs_gain=run.pcs_gain,
    )


def _moves(run: Polyline, first: int, behind: int) -> list[Block]:
    """The segments from `first` to before `behind` as a run; nothing if there are none."""
    if first >= behind:
        return []
    return [
        replace(
            run,
            points=run.points[first : behind + 1],
            feeds=run.feeds[first:behind],
            lines=run.lines[first:behind],
            numbers=run.numbers[first:behind],
        )
    ]


# -- what the corner sees of a motion


def _at_its_end(motion: Line | Arc, plane: Plane) -> geometry.Element:
    if isinstance(motion, Line):
        return _straight(motion, plane)
    return _round(motion, motion.end)


def _at_its_start(motion: Line | Arc, plane: Plane) -> geometry.Element:
    if isinstance(motion, Line):
        return _straight(motion, plane)
    return _round(motion, motion.start)


def _straight(line: Line, plane: Plane) -> geometry.Element:
    x, y = (float(line.end[axis] - line.start[axis]) for axis in plane)
    length = math.hypot(x, y)
    heading = (x / length, y / length) if length > NO_LENGTH else (1.0, 0.0)
    return geometry.Element(heading, 0.0, length)


def _round(arc: Arc, place: Floats) -> geometry.Element:
    x, y = (float(place[axis] - centre) for axis, centre in zip(arc.plane, arc.centre, strict=True))
    radius = math.hypot(x, y)
    sense = math.copysign(1.0, arc.angle)
    return geometry.Element(
        (-sense * y / radius, sense * x / radius), sense / radius, radius * math.radians(abs(arc.angle))
    )


# -- shortening


def _place(motion: Line | Arc, share: float) -> Floats:
    """Where a motion is at a share of its length, (n_axes,): as the interpolator drives it."""
    place = motion.start + (motion.end - motion.start) * share
    if isinstance(motion, Arc):
        axes = list(motion.plane)
        radius = motion.start[axes] - motion.centre
        missing = motion.end[axes] - motion.centre - _turned(radius, motion.angle)
        place[axes] = motion.centre + _turned(radius, motion.angle * share) + missing * share
    return place


def _turned(vector: Floats, degrees: float) -> Floats:
    cosine, sine = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    return np.array([cosine * vector[0] - sine * vector[1], sine * vector[0] + cosine * vector[1]])


def _until(motion: Line | Arc, share: float) -> Line | Arc:
    """The motion up to a share of its length."""
    end = _place(motion, share)
    pcs = motion.programmed(end)
    if isinstance(motion, Line):
        return replace(motion, end=end, end_pcs=pcs)
    return replace(motion, end=end, end_pcs=pcs, angle=motion.angle * share)


def _from(motion: Line | Arc, share: float) -> Line | Arc:
    """The motion from a share of its length on."""
    start = _place(motion, share)
    if isinstance(motion, Line):
        return replace(motion, start=start)
    return replace(motion, start=start, angle=motion.angle * (1.0 - share))


def _between(
    first: Line | Arc, start: Floats, end: Floats, plane: Plane, corner: Corner, cut: geometry.Insert
) -> Line | Arc:
    """The inserted element; `first` is the whole motion, which ends at the corner."""
    rapid = isinstance(first, Line) and first.rapid and corner.feed is None
    feed = corner.feed
    if feed is None:
        feed = math.inf if rapid else first.feed if first.end_feed is None else first.end_feed
    pcs = first.programmed(end)
    if corner.kind is not CornerKind.ROUNDING:
        rapid = rapid or math.isinf(feed)
        return Line(first.source, start, end, feed, rapid, pcs, plane, pcs_gain=first.pcs_gain)
    centre = first.end[list(plane)] + np.array(cut.centre)
    angle = math.degrees(cut.angle)
    return Arc(first.source, start, end, feed, pcs, plane, centre, corner.size, angle, pcs_gain=first.pcs_gain)
