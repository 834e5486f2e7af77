"""Radius compensation by vectors: the end of every motion in the plane is moved by the vectors of the corner behind it.

    off ── G41, G42 ──▶ active ── G40 ──▶ off          (NCT manual 3478-4234)

    programmed      ── A ──┐ corner ┌── B ──┐ corner ┌── C ──
    tool path    here ─────▶ ends of A ─────▶ ends of B ─────▶

The vectors of a corner are known with the motion behind it; whether B runs against its direction is known with the vectors at its
end. So A goes out when C has come. Everything else keeps its place behind the last vector of the motion in front of it. Where two
NC blocks without motion in the plane stand between two motions, or one of no length, the vector is square to the motion in front
and nothing is waited for.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass, field, replace

import numpy as np

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    Floats,
    Flush,
    Hold,
    Line,
    Polyline,
    Polynomials,
    Source,
    SpatialArc,
    Stop,
    StopKind,
    VectorCompensation,
    VectorOrder,
    VectorSettings,
)
from runtime.cnc.tool_radius_comp.elements import NO_LENGTH, NO_RADIUS, TOO_SMALL, Elements
from runtime.cnc.tool_radius_comp.errors import CompensationError
from runtime.cnc.tool_radius_comp.pieces import Piece, Point, in_pieces, straight
from runtime.cnc.tool_radius_comp.vector_corners import (
    NoMeetingError,
    arc_around,
    change_of_side,
    corner,
    is_inside,
    moved_arc,
    record,
    square_end,
    to_wall,
    wall,
    without_small_gaps,
)
from runtime.cnc.tool_radius_comp.window import move_of
from runtime.diagnostics.catalogue import nct_offsets as catalogue
from runtime.diagnostics.catalogue import radius
from runtime.diagnostics.errors import ErrorEntry, Place

AGAINST = 1e-6  # mm or rad: a motion that is shorter than this runs against no direction
RADIUS_STEP = 1e-3  # mm: change of radius within a piece of an arc whose radius changes
ANGLE_STEP = math.radians(22.5)


@dataclass(slots=True)
class _Motion:
    """A motion in the plane, and what is known of its tool path."""

    block: Line | Arc
    before: float  # offset at its start, mm to the left
    after: float  # and at its end
    begin: Point = (0.0, 0.0)  # where its tool path begins
    starts: bool = False  # G41 or G42 stands in its block
    leaves: bool = False  # G40 stands in its block
    fades: bool = False  # the vector goes over it
    holds: bool = False  # G38
    turned: bool = False  # the side changes in front of it
    direction: tuple[float, float] | None = None  # of the auxiliary line with which it starts or leaves
    ends: list[Piece] = field(default_factory=list)  # known when the next one has come
    arc: VectorCompensation | None = None  # G39 behind it
    flat: bool = False  # vectors were left out: driven straight
    own: Piece | None = None  # an arc of its own, where the side changes
    between: list[Block] = field(default_factory=list)
    foreign: list[Source] = field(default_factory=list)  # NC blocks without motion in the plane behind it

    @property
    def bare(self) -> bool:
        """No vector at one of its ends, or one that is none of its own: it may have any direction."""
        return self.starts or self.leaves or self.fades or self.holds or self.turned or self.before != self.after


class VectorRun:
    """The compensation of one program. What `select` and `take` raise is CompensationError; what came before is right."""

    def __init__(self) -> None:
        self.active = False  # blocks are to be given to `take`
        self._plane = (0, 1)
        self._settings = VectorSettings()
        self._offset = 0.0  # at the end of the motions that come
        self._last = 0.0  # at the end of the last motion
        self._start: VectorCompensation | None = None  # G41 or G42, as long as no motion has come
        self._cancel: VectorCompensation | None = None  # G40, as long as no motion has come
        self._holds = False
        self._suspended = False
        self._resumed = False  # the next motion begins without vector because it was suspended
        self._front: _Motion | None = None  # its ends are known
        self._motion: _Motion | None = None  # the last one
        self._here: Floats | None = None  # (n,): where the tool path stands behind what was put out
        self._aside: Floats | None = None  # (n,): where it stands, if not where the program does and nothing is in hand
        self._passed: Line | Arc | None = None  # the last motion, as it is programmed

    # ------------------------------------------------------------------ orders

    def order(self, now: VectorCompensation) -> Iterator[Block]:
        """What a block of the compensation says."""
        if now.order is VectorOrder.SELECT:
            self._select(now)
        elif not self.active:
            return
        elif now.order is VectorOrder.HOLD:
            self._holds = True
        elif now.order is VectorOrder.CORNER_ARC:
            if self._motion is not None:
                self._motion.arc = now
        elif now.order is VectorOrder.SUSPEND:
            yield from self._suspend(now)
        elif self._suspended:
            self._suspended, self._resumed = False, True

    def _select(self, now: VectorCompensation) -> None:
        if not now.active:
            self._cancel = now
            if not self.active or self._start is not None or (self._motion is None and self._aside is None):
                self._end()  # there is no vector
            return
        self._settings, self._cancel = now.settings, None
        if not self.active:
            self._end()
            self.active, self._start, self._plane = True, now, now.plane
        elif self._start is not None:
            self._start = now
        self._offset = now.offset

    def _end(self) -> None:
        """No compensation any more, nothing in hand."""
        self.active = self._holds = self._suspended = self._resumed = False
        self._start = self._cancel = self._front = self._motion = self._passed = None
        self._here = self._aside = None
        self._offset = self._last = 0.0

    def _suspend(self, now: VectorCompensation) -> Iterator[Block]:
        """The vector goes with the motion in front."""
        if self._motion is not None:
            motion = self._motion
            if isinstance(motion.block, Arc) and motion.after != 0.0:
                raise self._error(catalogue.AFTER_ARC, now.source, what="a change of the coordinate system")
            motion.ends, motion.fades = [Piece(self._end_of(motion.block))], True
            yield from self._all_out()
            self._aside = None
        elif self._aside is not None and self._passed is not None:  # that motion is over: a way of its own
            block, start, end = replace(self._passed, source=now.source), self._aside, self._aside.copy()
            end[list(self._plane)] = self._end_of(block)
            if np.abs(end - start).max() > NO_LENGTH:
                yield straight(block, start, end, block.feed)
            self._aside = None
        self._suspended = True

    # ------------------------------------------------------------------ blocks

    def take(self, block: Block) -> Iterator[Block]:
        """A block behind G41 or G42, up to the motion over which G40 takes the vector away."""
        if isinstance(block, Hold):
            yield block
        elif isinstance(block, Stop) and block.kind is StopKind.PROGRAM_END:
            yield from self._settle()
            self._end()
            yield block
        elif self._suspended:
            yield block
        elif isinstance(block, Flush):
            yield from self._settle()
            yield block
        elif isinstance(block, Polyline):
            for move in range(len(block.feeds)):
                line = move_of(block, move)
                for part in (line, BlockEnd(line.source)):  # in a run every move is a step
                    yield from self.take(part) if self.active else (part,)
        elif isinstance(block, Line | Arc) and self._moves(block):
            yield from self._add(block)
        elif isinstance(block, SpatialArc):
            raise self._error(radius.CANNOT_BE_OFFSET, block.source, what="an arc in space")
        elif isinstance(block, Polynomials):
            source = Source(block.program, int(block.lines[0]))
            raise self._error(radius.CANNOT_BE_OFFSET, source, what="a curve of polynomials (spline, contouring)")
        else:
            yield from self._other(block)

    def _moves(self, block: Line | Arc) -> bool:
        """Whether a block moves anything in the plane."""
        if isinstance(block, Arc):
            if block.plane != self._plane:
                raise self._error(radius.OTHER_PLANE, block.source)
            return block.radius * abs(math.radians(block.angle)) > NO_LENGTH
        first, second = self._plane
        return math.hypot(block.end[first] - block.start[first], block.end[second] - block.start[second]) > NO_LENGTH

    def _other(self, block: Block) -> Iterator[Block]:
        """A block that moves nothing in the plane."""
        motion = self._motion
        if motion is None:
            yield from self._in_place(block)
            return
        assert not isinstance(block, Polyline | Polynomials)
        source = block.source
        nothing = isinstance(block, Line) and np.abs(block.end - block.start).max() <= NO_LENGTH
        if not nothing:
            motion.between.append(block)
        if not _same(source, motion.block.source) and not any(_same(source, other) for other in motion.foreign):
            motion.foreign.append(source)
        if nothing and motion.after != 0.0:
            cancel = self._cancel
            if cancel is not None and _same(cancel.source, source):
                yield from self._settle(leaving=True)
                self._end()
            else:
                yield from self._settle()
        elif len(motion.foreign) > 2 and motion.after != 0.0:  # the last of them may belong to the next motion
            yield from self._settle()

    def _in_place(self, block: Block) -> Iterator[Block]:
        """A block that moves nothing in the plane, where the tool path stands."""
        if not isinstance(block, Line | Arc) or self._aside is None:
            yield block
            return
        start, end = self._aside, block.end.copy()
        end[list(self._plane)] = start[list(self._plane)]
        if np.abs(end - start).max() > NO_LENGTH:
            yield straight(block, start, end, block.feed)
        self._aside = end

    def _add(self, block: Line | Arc) -> Iterator[Block]:
        """A motion in the plane: the vectors at the end of the one before are known now."""
        new = _Motion(block, self._last, self._offset)
        new.begin = self._start_of(block) if self._aside is None else self._in_plane(self._aside)
        new.holds, self._holds = self._holds, False
        if self._start is not None:
            new.starts = _same(self._start.source, block.source)
            new.direction = self._start.direction if new.starts else None
            if new.starts and isinstance(block, Arc) and self._offset != 0.0:
                raise self._error(catalogue.START_IN_ARC, block.source)
            self._start = None
        if self._resumed:
            if isinstance(block, Arc) and self._offset != 0.0:
                raise self._error(catalogue.AFTER_ARC, block.source, what="a change of the coordinate system")
            new.before, self._resumed = 0.0, False
        if new.before * new.after < 0.0:
            new.before, new.turned = new.after, True
        cancel, self._cancel = self._cancel, None
        if cancel is not None:
            new.leaves = _same(cancel.source, block.source)
            new.fades, new.after = not new.leaves, 0.0
            new.direction = cancel.direction if new.leaves else None
            if isinstance(block, Arc) and self._last != 0.0:
                raise self._error(catalogue.CANCEL_IN_ARC, block.source)
        if self._motion is not None:
            yield from self._join(self._motion, new)
        self._aside = None
        self._motion, self._passed, self._last = new, block, new.after
        if self._here is None:
            self._here = block.start.copy()
            self._here[list(self._plane)] = new.begin
        if cancel is not None:
            new.ends = [Piece(self._end_of(block))]
            yield from self._all_out()
            self._end()

    # ------------------------------------------------------------------ corners

    def _join(self, motion: _Motion, new: _Motion) -> Iterator[Block]:
        """The vectors between two motions; what is in front of them goes out."""
        motion.ends = without_small_gaps(self._vectors(motion, new), self._settings.least_gap)
        new.begin = motion.ends[-1].end
        yield from self._front_out()
        self._front, self._motion = motion, None

    def _vectors(self, motion: _Motion, new: _Motion) -> list[Piece]:
        end, left = self._end_of(motion.block), motion.after
        if motion.holds:
            start = self._start_of(motion.block)
            return [Piece((end[0] + motion.begin[0] - start[0], end[1] + motion.begin[1] - start[1]))]
        if left == 0.0 and not new.turned:
            return [Piece(end)]
        e, f = (
            record(motion.block, self._plane, left),
            record(new.block, self._plane, new.before if new.turned else left),
        )
        self._expect_room(motion, e)
        foreign = [source for source in motion.foreign if not _same(source, new.block.source)]
        if len(foreign) > 1 or new.fades:
            return [Piece(square_end(e[0]))]
        if new.turned:
            return self._turn(motion, e, f)
        if not new.leaves:
            self._expect_room(new, f)
        if new.direction is not None:
            return to_wall(e, wall(end, new.direction, left, before=False), leaving=True)
        if motion.direction is not None:
            return to_wall(wall(end, motion.direction, left, before=True), f, leaving=False)
        inside = is_inside(e[0], f[0])
        if motion.arc is not None and (not inside or motion.arc.direction is not None):
            return arc_around(e[0], f[0], motion.arc.direction)
        if inside and motion.starts:
            return [Piece((float(f[0]["px"]), float(f[0]["py"])))]
        if inside and new.leaves:
            return [Piece(square_end(e[0]))]
        try:
            return corner(e, f)
        except NoMeetingError:
            raise self._error(catalogue.NO_INTERSECTION, motion.block.source, radius=abs(left)) from None

    def _turn(self, motion: _Motion, e: Elements, f: Elements) -> list[Piece]:
        """The side changes between two motions."""
        pieces = change_of_side(e, f)
        if pieces is not None:
            return pieces
        goal = float(f[0]["px"]), float(f[0]["py"])
        motion.own = moved_arc(e[0], motion.begin, goal)
        if motion.own is None:
            raise self._error(catalogue.CHANGE_IMPOSSIBLE, motion.block.source)
        return [Piece(goal)]

    def _expect_room(self, motion: _Motion, e: Elements) -> None:
        """An arc in which the tool has no room is one that would be driven backwards."""
        if e[0]["status"] == TOO_SMALL:
            raise self._error(catalogue.INTERFERENCE, motion.block.source, radius=abs(float(e[0]["o1"])))

    def _check(self, front: _Motion | None, motion: _Motion) -> None:
        """No motion runs against its programmed direction; vectors at both of its ends are left out until it does not."""
        if not self._settings.checked or motion.bare or motion.own is not None:
            return
        while self._runs_back(motion):
            left_out = False
            if self._settings.repaired:
                motion.flat = True
                if front is not None and len(front.ends) > 1:
                    front.ends.pop()
                    motion.begin = front.ends[-1].end
                    left_out = True
                if len(motion.ends) > 1:
                    motion.ends.pop(0)
                    left_out = True
            if not left_out:
                raise self._error(catalogue.INTERFERENCE, motion.block.source, radius=abs(motion.after))

    def _runs_back(self, motion: _Motion) -> bool:
        begin, end, block = motion.begin, motion.ends[0].end, motion.block
        if isinstance(block, Arc) and not motion.flat:
            return self._sweep(motion) < -AGAINST
        start, goal = self._start_of(block), self._end_of(block)
        if math.dist(start, goal) <= NO_LENGTH:  # a full circle is no straight line
            return True
        way = (end[0] - begin[0]) * (goal[0] - start[0]) + (end[1] - begin[1]) * (goal[1] - start[1])
        return way < -AGAINST * math.dist(start, goal)

    def _sweep(self, motion: _Motion) -> float:
        """By how much the tool path of an arc turns, rad in the sense of the arc: less than nothing where it would run back."""
        block = motion.block
        assert isinstance(block, Arc)
        centre = float(block.centre[0]), float(block.centre[1])
        sense = math.copysign(1.0, block.angle)
        ahead = _angle(self._start_of(block), motion.begin, centre) * sense
        behind = _angle(self._end_of(block), motion.ends[0].end, centre) * sense
        return abs(math.radians(block.angle)) - ahead + behind

    # ------------------------------------------------------------------ out

    def _settle(self, leaving: bool = False) -> Iterator[Block]:
        """Nothing is waited for: the vector stands square to the last motion, or, `leaving`, goes away on the spot."""
        motion = self._motion
        if motion is None:
            return
        end = self._end_of(motion.block)
        if motion.holds:
            start = self._start_of(motion.block)
            motion.ends = [Piece((end[0] + motion.begin[0] - start[0], end[1] + motion.begin[1] - start[1]))]
        elif motion.after == 0.0:
            motion.ends = [Piece(end)]
        else:
            e = record(motion.block, self._plane, motion.after)
            self._expect_room(motion, e)
            motion.ends = [Piece(square_end(e[0]))]
        if leaving:
            motion.ends.append(Piece(end))
        yield from self._all_out()

    def _all_out(self) -> Iterator[Block]:
        """The last motion has its ends: everything goes out."""
        motion = self._motion
        assert motion is not None
        yield from self._front_out()
        self._front, self._motion = motion, None
        yield from self._front_out()
        self._aside, self._here = self._here, None

    def _front_out(self) -> Iterator[Block]:
        """The motion whose ends cannot change any more goes out; the one behind it, whose ends are known, is checked first."""
        behind = self._motion
        if behind is not None and behind.ends:
            self._check(self._front, behind)
        front, self._front = self._front, None
        if front is None:
            return
        assert self._here is not None
        block = front.block
        here = self._in_plane(self._here)
        way = self._at_contour(block, here, self._way(front, here))
        yield from in_pieces(block, self._here, way, self._plane, block.feed, block.end)
        place = block.end.copy()
        place[list(self._plane)] = front.ends[0].end
        yield from in_pieces(block, place, front.ends[1:], self._plane, block.feed)
        self._here = place.copy()
        self._here[list(self._plane)] = front.ends[-1].end
        for other in front.between:
            if isinstance(other, Line | Arc):
                end = other.end.copy()
                end[list(self._plane)] = self._here[list(self._plane)]
                yield straight(other, self._here, end, other.feed)
                self._here = end
            else:
                yield other

    def _at_contour(self, block: Line | Arc, begin: Point, way: list[Piece]) -> list[Piece]:
        """Inside an arc the tool goes slower than F, so that F holds at the contour (VectorSettings.inside_feed)."""
        least = self._settings.inside_feed
        if not isinstance(block, Arc) or least >= 1.0:
            return way
        slowed = []
        for piece in way:
            share = 1.0 if piece.centre is None else math.dist(begin, piece.centre) / block.radius
            slowed.append(piece if share >= 1.0 else replace(piece, feed=block.feed * max(share, least)))
            begin = piece.end
        return slowed

    def _way(self, motion: _Motion, begin: Point) -> list[Piece]:
        """The tool path of a motion itself."""
        end, block = motion.ends[0].end, motion.block
        if motion.own is not None:
            return [motion.own]
        if isinstance(block, Line) or motion.flat:
            return [Piece(end)]
        centre = float(block.centre[0]), float(block.centre[1])
        first, last = math.dist(begin, centre), math.dist(end, centre)
        sweep = self._sweep(motion)
        if max(first, last) <= NO_RADIUS or sweep <= 0.0:
            return [Piece(end)]
        if min(first, last) <= NO_RADIUS:
            raise self._error(
                catalogue.RADIUS_OVER_ARC,
                block.source,
                arc=block.radius,
                radius=max(abs(motion.before), abs(motion.after)),
            )
        turn = math.copysign(sweep, block.angle)
        if abs(last - first) <= NO_RADIUS:
            return [Piece(end, centre, turn)]
        count = math.ceil(max(abs(last - first) / RADIUS_STEP, sweep / ANGLE_STEP))
        start = math.atan2(begin[1] - centre[1], begin[0] - centre[0])
        pieces = []
        for number in range(1, count):
            share = number / count
            size, angle = first + share * (last - first), start + share * turn
            point = centre[0] + size * math.cos(angle), centre[1] + size * math.sin(angle)
            pieces.append(Piece(point, centre, turn / count))
        return [*pieces, Piece(end, centre, turn / count)]

    # ------------------------------------------------------------------ parts

    def _in_plane(self, position: Floats) -> Point:
        return float(position[self._plane[0]]), float(position[self._plane[1]])

    def _start_of(self, block: Line | Arc) -> Point:
        return self._in_plane(block.start)

    def _end_of(self, block: Line | Arc) -> Point:
        return self._in_plane(block.end)

    def _error(self, entry: ErrorEntry, source: Source, **values: object) -> CompensationError:
        return CompensationError(entry, Place(source.program, source.line), **values)


def _angle(one: Point, other: Point, centre: Point) -> float:
    """From one point to another about a centre, rad, counter-clockwise, -π … π; 0 where one of them is the centre."""
    ux, uy = one[0] - centre[0], one[1] - centre[1]
    vx, vy = other[0] - centre[0], other[1] - centre[1]
    return math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)


def _same(one: Source, other: Source) -> bool:
    """Whether two blocks are of one NC block."""
    return one.line == other.line and one.program == other.program
