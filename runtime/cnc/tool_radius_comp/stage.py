"""Tool radius compensation: contour blocks become the blocks of the tool path (programming manual 18666–20947).

    off ── G41, G42 ──▶ entering ── approach and first element known ──▶ on ── G40 ──▶ leaving ── exit block ──▶ off
                            ▲                                             │
                            └──────────── the other side ─────────────────┘

A corner needs the element behind it, and an element is only handed on when the corner at its end shows that it does not
run backwards: so the stage looks ahead over two elements with motion in the plane. Everything that moves nothing in the
plane keeps its place, behind the corner of the element in front of it.
"""

from __future__ import annotations

import math
from collections.abc import Generator, Iterable, Iterator
from dataclasses import replace
from enum import Enum, auto

import numpy as np

from runtime.cnc.blocks import (
    Approach,
    Arc,
    Block,
    BlockEnd,
    CompensationSettings,
    Floats,
    Hold,
    Line,
    Polyline,
    Polynomials,
    RadiusCompensation,
    Source,
    SpatialArc,
    Stop,
    StopKind,
    TechnologyFunction,
    ToolRadius,
    VectorCompensation,
    Wait,
)
from runtime.cnc.tool_radius_comp.approach import (
    ApproachError,
    Way,
    corner_limit,
    enter,
    reversed_element,
    reversed_way,
)
from runtime.cnc.tool_radius_comp.closed_contour import MOST_KEPT, ClosedContour
from runtime.cnc.tool_radius_comp.corners import BACK, connect, join
from runtime.cnc.tool_radius_comp.elements import (
    APART,
    ARC,
    GOOD,
    NO_INSERT,
    NO_LENGTH,
    NONE,
    REVERSED,
    TOO_SMALL,
    TWISTED,
    Elements,
    offset,
    place,
)
from runtime.cnc.tool_radius_comp.errors import CompensationError
from runtime.cnc.tool_radius_comp.meeting import NEAR
from runtime.cnc.tool_radius_comp.pieces import Piece, Point, in_pieces, straight
from runtime.cnc.tool_radius_comp.segments import can_be_split, in_segments
from runtime.cnc.tool_radius_comp.vectors import VectorRun
from runtime.cnc.tool_radius_comp.window import Window, move_of, part
from runtime.diagnostics.catalogue import radius as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place

BATCH = 256  # blocks that are joined together
MOST_BETWEEN = 4096  # blocks without motion in the plane that wait for the next one that has it

_DAMAGE = {
    TOO_SMALL: catalogue.ARC_TOO_SMALL,
    REVERSED: catalogue.CONTOUR_DAMAGED,
    APART: catalogue.OFFSETS_APART,
    TWISTED: catalogue.CHANGE_OVER_ARC,
}


_PLAIN = frozenset({Line, Arc, BlockEnd, TechnologyFunction, Wait})


class _State(Enum):
    OFF = auto()
    ENTERING = auto()
    ON = auto()
    LEAVING = auto()


class ToolRadiusCompensation:
    """The stage. Raises CompensationError; what was handed on before is right and may be driven."""

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        run = _Run()
        vectors = VectorRun()
        for block in blocks:
            if run.add(block):
                continue
            if run.full:
                yield from run.join_what_is_there()
                run.raise_what_failed()
                if run.add(block):
                    continue
            if isinstance(block, ToolRadius):
                yield from run.change_tool(block)
            elif isinstance(block, RadiusCompensation):
                yield from run.change(block)
            elif isinstance(block, VectorCompensation):
                yield from vectors.order(block)
            elif vectors.active:
                yield from vectors.take(block)
            elif run.off:
                yield block
            else:
                yield from run.take(block)


class _Run:
    """The compensation of one program."""

    def __init__(self) -> None:
        self._state = _State.OFF
        self._approach = Approach.INDIRECT
        self._settings = CompensationSettings()
        self._plane = (0, 1)
        self._radius = 0.0  # of the active tool, mm
        self._told: RadiusCompensation | None = None  # what G functions and #TRC have said last
        self._offset = 0.0  # mm to the left, of the elements that come
        self._before: float | None = None  # offset in front of the next element, where the radius changes
        self._window = Window(0, self._plane)
        self._joined = 0  # the element in the window whose begin is known and whose end is not
        self._source = Source("", 0)  # of G41 or G42
        self._block: Line | Arc | None = None  # the approach, as it is programmed
        self._between: list[Block] = []  # what stands behind it
        self._last: Elements | None = None  # (1,), the last element before the change of the side
        self._closed: ClosedContour | None = None  # behind an approach with G238, up to G40
        self._way: Way | None = None  # the approach, if it is known before the first element
        self._failed: CompensationError | None = None
        self._place: Floats | None = None  # (n,): where the tool path stands, if not where the program does

    @property
    def full(self) -> bool:
        """So much was added that it should be joined."""
        return self._window.waiting >= BATCH

    @property
    def off(self) -> bool:
        """Blocks pass as they are."""
        return self._state is _State.OFF

    # ------------------------------------------------------------------ changes

    def change_tool(self, tool: ToolRadius) -> Iterator[Block]:
        """A tool of another radius."""
        if self._closed is not None and tool.radius != self._radius:
            raise self._error(catalogue.INSIDE_CORNER, tool.source, why="the radius changes along it")
        self._radius = tool.radius
        if self._told is not None and not self.off:
            yield from self.change(self._told)

    def change(self, now: RadiusCompensation) -> Iterator[Block]:
        """G40, G41, G42, a new radius, or other settings."""
        self._told = now
        wanted = 0.0 if now.settings.suppress else now.side * self._radius
        if self._closed is not None and now.side != 0:
            if wanted != self._offset:
                raise self._error(catalogue.INSIDE_CORNER, now.source, why="the side or the radius changes along it")
            self._closed.add(now)
            return
        if self._state in (_State.ON, _State.LEAVING):
            yield from self._put_out_joined()
        if now.side == 0:
            yield from self._deselect(now)
        elif self._state is _State.ON and wanted * self._offset >= 0.0:
            if wanted != self._offset and self._before is None:
                self._before = self._offset
        elif self._state in (_State.ON, _State.LEAVING):
            yield from self._change_side(now)
        elif self._state is _State.OFF:
            self._enter(now)
        elif self._place is None:
            self._approach = now.approach
        self._settings = now.settings
        self._offset = wanted if now.side else self._offset

    def _enter(self, now: RadiusCompensation) -> None:
        self._state, self._approach, self._plane, self._source = _State.ENTERING, now.approach, now.plane, now.source
        self._block, self._between, self._before = None, [], None
        self._last = self._place = self._way = self._closed = None

    def _change_side(self, now: RadiusCompensation) -> Iterator[Block]:
        """The old side ends on its normal, the next block leads to the normal of the new one."""
        if now.approach is Approach.INSIDE_CORNER:
            raise self._error(catalogue.INSIDE_CORNER, now.source, why="the tool is not free in front of it")
        last = None
        if self._window.count:
            last = self._window.elements[self._joined : self._joined + 1].copy()
            yield from self._close()
        there = self._place
        self._enter(now)
        self._approach, self._last, self._place = Approach.DIRECT, last, there

    def _deselect(self, now: RadiusCompensation) -> Iterator[Block]:
        end = None
        if self._closed is not None and self._closed.moves:
            end = yield from self._drive_closed(now)
        elif self._closed is not None:
            self._between += [block for block in self._closed.blocks if not isinstance(block, RadiusCompensation)]
            self._closed = None
        if self._state is _State.ENTERING:  # there is no contour
            yield from self._plain_approach()
            self._state = _State.OFF if self._place is None else _State.LEAVING
            self._window.count, self._approach = 0, Approach.DIRECT
        elif self._state is _State.ON:
            self._state, self._approach = _State.LEAVING, now.approach
            if now.approach is Approach.WITHOUT_BLOCK:
                yield from self._close()
                self._state = _State.OFF
            elif now.approach is Approach.PERPENDICULAR:
                motion = self._window.motion_at(self._joined)
                last = self._window.elements[self._joined]
                corner = float(last["x1"]), float(last["y1"])
                yield from self._close()
                assert self._place is not None
                home = replace(motion, source=now.source)
                yield from in_pieces(home, self._place, [Piece(corner)], self._plane, motion.feed)
                self._state = _State.OFF
            elif now.approach is Approach.INSIDE_CORNER:
                yield from self._close(end)

    def _drive_closed(self, now: RadiusCompensation) -> Generator[Block, None, float]:
        """The contour that was kept since G238 is complete; how much of its last element is left of it, mm."""
        closed, self._closed = self._closed, None
        assert closed is not None
        try:
            self._way, end = closed.corner(self._offset, self._settings)
        except ApproachError as error:
            raise CompensationError(error.entry, _place(closed.approach.source), **error.values) from None
        for block in closed.blocks:
            yield from self.change(block) if isinstance(block, RadiusCompensation) else self.take(block)
        self._told = now
        return end

    # ------------------------------------------------------------------ blocks

    def add(self, block: Block) -> bool:
        """The short way of a block that only has to be kept for now; False if it has to be looked at."""
        kind = type(block)
        if self._state is not _State.ON or self._before is not None or kind not in _PLAIN:
            return False
        if (kind is Arc and block.plane != self._plane) or self.full or self._window.held > MOST_BETWEEN:  # type: ignore[union-attr]
            return False
        self._window.add(block)
        return True

    def take(self, block: Block) -> Iterator[Block]:
        """A block behind G41 or G42, up to the exit block."""
        if isinstance(block, Hold):
            if self._state is _State.ON:
                yield from self._put_out_joined()
            yield block
        elif self._closed is not None and not isinstance(block, SpatialArc | Polynomials):
            self._keep(block)
        elif isinstance(block, Stop) and block.kind is StopKind.PROGRAM_END:
            yield from self._end()
            yield block
        elif isinstance(block, Polyline) and not self._takes_runs:
            yield from self._one_by_one(block)
        elif isinstance(block, Line | Arc | Polyline):
            self._expect_in_plane(block)
            yield from self._motion(block)
        elif isinstance(block, SpatialArc):
            raise self._error(catalogue.CANNOT_BE_OFFSET, block.source, what="an arc in space")
        elif isinstance(block, Polynomials):
            source = Source(block.program, int(block.lines[0]))
            raise self._error(catalogue.CANNOT_BE_OFFSET, source, what="a curve of polynomials (spline, contouring)")
        else:
            yield from self._other(block)

    def _keep(self, block: Block) -> None:
        """A block of the contour that G238 enters."""
        assert self._closed is not None
        if isinstance(block, Stop) and block.kind is StopKind.PROGRAM_END:
            raise self._error(catalogue.INSIDE_CORNER, block.source, why="the program ends without G40")
        if isinstance(block, Line | Arc | Polyline):
            self._expect_in_plane(block)
        self._closed.add(block)
        if self._closed.full:
            source = self._closed.approach.source
            raise self._error(catalogue.INSIDE_CORNER, source, why=f"it has more than {MOST_KEPT} blocks")

    @property
    def _takes_runs(self) -> bool:
        return self._state is _State.ON and self._before is None

    def _one_by_one(self, run: Polyline) -> Iterator[Block]:
        """The first move of the run that counts, as a block of its own, then the rest."""
        way = np.diff(run.points[:, self._plane], axis=0)
        there = np.hypot(way[:, 0], way[:, 1]) > NO_LENGTH
        first = int(np.argmax(there)) if there.any() else len(there)
        for move in range(min(first + 1, len(there))):
            yield from self._motion(move_of(run, move))
        if first + 1 < len(there):
            rest = part(run, first + 1, len(there))
            if self.off:
                yield rest
            else:
                yield from self.take(rest)

    def _motion(self, block: Line | Arc | Polyline) -> Iterator[Block]:
        if self._state is _State.ON:
            yield from self._element(block)
            return
        assert not isinstance(block, Polyline)
        if not self._counts(block):
            yield from self._other(block)
        elif self._state is _State.LEAVING:
            yield from self._exit(block)
        elif self._block is None and self._approach is not Approach.PERPENDICULAR and not self._turns_back(block):
            if isinstance(block, Arc) and self._place is not None:
                raise self._error(catalogue.SIDE_CHANGE_ARC, block.source)
            self._block = block
            if self._approach is Approach.INSIDE_CORNER:
                if isinstance(block, Arc):
                    raise self._error(catalogue.INSIDE_CORNER, block.source, why="the approach is an arc")
                self._closed = ClosedContour(block, self._plane)
        else:
            yield from self._first(block)

    def _other(self, block: Block) -> Iterator[Block]:
        """A block that moves nothing in the plane."""
        if self._state is _State.LEAVING and self._window.count == 0:
            yield from self._where_the_path_is(block)
        elif self._state is not _State.ENTERING:
            self._window.add(block)
            yield from self._bounded()
        elif self._block is None and (self._approach is not Approach.PERPENDICULAR or _of(block) == self._source):
            yield from self._where_the_path_is(block)
        else:
            self._between.append(block)
            if len(self._between) > MOST_BETWEEN:
                raise self._error(catalogue.TOO_MANY_BETWEEN, _of(block) or self._source, limit=MOST_BETWEEN)

    def _element(self, block: Line | Arc | Polyline) -> Iterator[Block]:
        """A motion of the contour."""
        if self._before is not None and not isinstance(block, Polyline) and self._counts(block):
            yield from self._change_radius(block)
            return
        self._window.add(block)
        if isinstance(block, Polyline):
            yield from self._put_out_joined()
        else:
            yield from self._bounded()

    def _bounded(self) -> Iterator[Block]:
        if self._window.waiting >= BATCH and self._state is _State.ON:
            yield from self._put_out_joined()
        if self._window.held > MOST_BETWEEN:
            motion = self._window.motion_at(self._joined)
            raise self._error(catalogue.TOO_MANY_BETWEEN, motion.source, limit=MOST_BETWEEN)

    # ------------------------------------------------------------------ approach

    def _first(self, block: Line | Arc) -> Iterator[Block]:
        """The first element of the contour: the approach is known now."""
        self._window = Window(len(block.start), self._plane)
        self._window.add(block)
        self._window.load(self._offset)
        elements = self._window.elements
        offset(elements, 0, 1)
        first = elements[0]
        self._check(0)
        turns_back, self._last = self._block is None and self._last is not None, None
        motion = self._block or replace(block, source=self._source)
        begin = block.start if self._block is None else self._block.start
        start = begin if self._place is None else self._place
        selects = self._block is not None and self._way is None and self._place is None
        split = self._settings.split if selects else None
        if self._way is not None:
            way, self._way = self._way, None
        elif turns_back:
            way = Way((Piece((float(first["px"]), float(first["py"]))),))
        else:
            try:
                way = enter(self._approach, self._in_plane(start), self._record(motion), first, self._settings)
            except ApproachError as error:
                values = {"what": "approach", **error.values}
                raise CompensationError(error.entry, _place(motion.source), **values) from None
        end = None if self._block is None else motion.end
        pieces = list(way.pieces)
        if split is not None and split.entering and can_be_split(self._approach, self._record(motion), first):
            pieces = in_segments(self._in_plane(start), pieces, split, self._plane, False)
        yield from in_pieces(motion, start, pieces, self._plane, motion.feed, end)
        self._place = (start if end is None else end).copy()
        self._place[list(self._plane)] = pieces[-1].end
        for other in self._between:
            yield from self._where_the_path_is(other)
        self._state, self._block, self._between, self._place = _State.ON, None, [], None
        first["begin"] = way.begin
        first["bx"], first["by"] = pieces[-1].end
        self._joined = 0

    def _turns_back(self, block: Line | Arc) -> bool:
        """Whether the side changes where the path reverses, so that the tool need not move (#TRC REVERSE)."""
        if self._last is None or not self._settings.reverse:
            return False
        record = self._record(block)
        record["o0"] = record["o1"] = self._offset
        offset(record, 0, 1)
        last, first = self._last[0], record[0]
        turned = last["t1x"] * first["t0x"] + last["t1y"] * first["t0y"]
        beside = abs(last["t1x"] * first["t0y"] - last["t1y"] * first["t0x"])
        apart = math.hypot(last["qx"] - first["px"], last["qy"] - first["py"])
        return bool(turned < 0.0 and beside <= BACK * 10 and apart <= NEAR * 10)

    def _plain_approach(self) -> Iterator[Block]:
        """There is no contour behind the approach: it is driven as programmed."""
        block = self._block
        if block is not None and self._place is not None:
            yield from in_pieces(
                block, self._place, [Piece(self._in_plane(block.end))], self._plane, block.feed, block.end
            )
        elif block is not None:
            yield block
        if block is not None:
            self._place = None
        for other in self._between:
            yield from self._where_the_path_is(other)
        self._block, self._between = None, []

    # ------------------------------------------------------------------ exit

    def _exit(self, block: Line | Arc) -> Iterator[Block]:
        if self._window.count == 0:
            assert self._place is not None
            if self._approach is Approach.INSIDE_CORNER and isinstance(block, Arc):
                raise self._error(catalogue.INSIDE_CORNER, block.source, why="the exit is an arc")
            yield from in_pieces(
                block, self._place, [Piece(self._in_plane(block.end))], self._plane, block.feed, block.end
            )
            self._state = _State.OFF
            return
        yield from self._put_out_joined()
        last = self._window.elements[self._joined]
        turned = reversed_element(last)[0]
        end = self._in_plane(block.end)
        back = reversed_element(self._record(block)[0])
        try:
            way = enter(self._approach, end, back, turned, self._settings)
        except ApproachError as error:
            values = {"what": "exit", **error.values}
            raise CompensationError(error.entry, _place(block.source), **values) from None
        yield from self._close(float(last["length"]) - way.begin)
        assert self._place is not None
        pieces, split = list(reversed_way(way, end)), self._settings.split
        if split is not None and split.leaving and can_be_split(self._approach, back, turned):
            pieces = in_segments(self._in_plane(self._place), pieces, split, self._plane, True)
        yield from in_pieces(block, self._place, pieces, self._plane, block.feed, block.end)
        self._state, self._place = _State.OFF, None

    def _end(self) -> Iterator[Block]:
        """The program ends."""
        if self._state is _State.ENTERING:
            yield from self._plain_approach()
        elif self._window.count:
            yield from self._close()
        self._state = _State.OFF

    # ------------------------------------------------------------------ contour

    def _put_out_joined(self, loaded: int | None = None) -> Iterator[Block]:
        """Join what was added, and put out what cannot change any more. As `join_what_is_there`."""
        yield from self.join_what_is_there(loaded)
        self.raise_what_failed()

    def join_what_is_there(self, loaded: int | None = None) -> list[Block]:
        """Join what was added; what cannot change any more: all but the last two elements. Damage is raised afterwards.

        The elements from `loaded` on are in the arrays already.
        """
        window = self._window
        if window.count + window.waiting == 0:
            return []
        new = window.load(self._offset) if loaded is None else loaded
        elements = window.elements
        offset(elements, new, window.count)
        s = self._settings
        last = int(connect(elements, self._joined, window.count, s.circular, s.stretch, corner_limit(s)))
        self._joined = last
        ready = self._in_front_of(last)
        bad = np.flatnonzero(elements["status"][:last] != GOOD)
        if len(bad) and not s.ignore_damage:
            self._failed = self._damage_of(int(bad[0]))
            ready = self._in_front_of(int(bad[0]))
        self._joined -= ready
        return window.put_out(ready, s) if ready else []

    def raise_what_failed(self) -> None:
        """Raise the damage that was found."""
        if self._failed is not None:
            raise self._failed

    def _in_front_of(self, element: int) -> int:
        """The element with motion in the plane in front of another one; the first one if there is none."""
        kinds = self._window.elements["kind"][:element]
        there = np.flatnonzero(kinds != NONE)
        return int(there[-1]) if len(there) else 0

    def _close(self, end: float | None = None) -> Iterator[Block]:
        """Put out everything; the last element ends `end` mm from where its offset starts, None: with its offset."""
        yield from self._put_out_joined()
        last = self._window.elements[self._joined]
        if end is None:
            last["end"], last["ex"], last["ey"] = last["length"], last["qx"], last["qy"]
        else:
            last["end"] = end
            last["ex"], last["ey"] = place(last, end)
        last["insert"] = NO_INSERT
        if last["status"] == GOOD and last["end"] < last["begin"] - NEAR:
            last["status"] = REVERSED
        yield from self._all_out(float(last["ex"]), float(last["ey"]))

    def _all_out(self, x: float, y: float) -> Iterator[Block]:
        """Put out everything; the last element is joined, and the path stands at x, y then."""
        window, elements = self._window, self._window.elements
        if elements["status"][self._joined] != GOOD and not self._settings.ignore_damage:
            error = self._damage_of(self._joined)
            yield from window.put_out(self._in_front_of(self._joined), self._settings)
            raise error
        rest = elements[self._joined + 1 : window.count]
        rest["bx"], rest["by"], rest["ex"], rest["ey"] = x, y, x, y
        self._place = window.placed(window.count)[1][-1].copy()
        self._place[list(self._plane)] = x, y
        yield from window.put_out(window.count, self._settings)
        self._joined = 0

    def _change_radius(self, block: Line | Arc) -> Iterator[Block]:
        """The element over which, or in front of which, the radius changes."""
        assert self._before is not None
        before, self._before = self._before, None
        yield from self._put_out_joined()
        window = self._window
        if self._settings.perpendicular_change:
            yield from self._step(block, before)
            return
        for half in _halves(block):
            window.add(half)
        at = window.load(self._offset)
        window.elements[at]["o0"] = before
        yield from self._put_out_joined(at)

    def _step(self, block: Line | Arc, before: float) -> Iterator[Block]:
        """The radius changes at once, along the normal of the next element (#TRC PERPENDICULAR_RADIUS_CHANGE)."""
        s, window = self._settings, self._window
        old = self._record(block)
        old["o0"] = old["o1"] = before
        offset(old, 0, 1)
        last = window.elements[self._joined]
        join(last, old[0], s.circular, s.stretch, corner_limit(s))
        motion = window.motion_at(self._joined)
        yield from self._all_out(float(old["bx"][0]), float(old["by"][0]))
        window.add(block)
        window.load(self._offset)
        first = window.elements[0]
        offset(window.elements, 0, 1)
        self._check(0)
        scale = float(first["length"] / old["length"][0]) if first["kind"] == ARC else 1.0
        first["begin"] = float(old["begin"][0]) * scale
        first["bx"], first["by"] = place(first, first["begin"])
        assert self._place is not None
        step = [Piece((float(first["bx"]), float(first["by"])))]
        yield from in_pieces(motion, self._place, step, self._plane, motion.feed)
        self._place = None

    def _check(self, element: int) -> None:
        e = self._window.elements[element]
        if e["status"] != GOOD and not self._settings.ignore_damage:
            raise self._damage_of(element)

    def _damage_of(self, element: int) -> CompensationError:
        e = self._window.elements[element]
        values = {
            "radius": abs(float(e["o1"])),
            "before": abs(float(e["o0"])),
            "after": abs(float(e["o1"])),
            "arc": math.hypot(e["x0"] - e["cx"], e["y0"] - e["cy"]),
        }
        source = self._window.motion_at(element).source
        return CompensationError(_DAMAGE[int(e["status"])], _place(source), **values)

    # ------------------------------------------------------------------ parts

    def _in_plane(self, position: Floats) -> Point:
        return float(position[self._plane[0]]), float(position[self._plane[1]])

    def _record(self, motion: Line | Arc) -> Elements:
        """A motion as an element (1,) as it is programmed."""
        window = Window(len(motion.start), self._plane)
        window.add(motion)
        window.load(0.0)
        return window.elements[:1]

    def _counts(self, motion: Line | Arc) -> bool:
        """Whether a motion moves anything in the plane."""
        return bool(self._record(motion)["kind"][0] != NONE)

    def _expect_in_plane(self, block: Line | Arc | Polyline) -> None:
        if isinstance(block, Arc) and block.plane != self._plane:
            raise self._error(catalogue.OTHER_PLANE, block.source)

    def _where_the_path_is(self, block: Block) -> Iterator[Block]:
        """A block that moves nothing in the plane, where the tool path stands."""
        if self._place is None or not isinstance(block, Line | Arc):
            yield block
            return
        end = block.end.copy()
        end[list(self._plane)] = self._place[list(self._plane)]
        yield straight(block, self._place, end, block.feed)
        self._place = end

    def _error(self, entry: ErrorEntry, source: Source, **values: object) -> CompensationError:
        return CompensationError(entry, _place(source), **values)


def _place(source: Source) -> Place:
    return Place(source.program, source.line)


def _of(block: Block) -> Source | None:
    """Where a block stands in the program."""
    return None if isinstance(block, Polyline | Polynomials) else block.source


def _halves(block: Line | Arc) -> tuple[Line | Arc, ...]:
    """An arc of more than 180 degrees in two, so that a new radius is reached in the first (manual line 19930)."""
    if isinstance(block, Line) or abs(block.angle) <= 180.0 + 1e-9:
        return (block,)
    share = 180.0 / abs(block.angle)
    middle = block.start + share * (block.end - block.start)
    for index, axis in enumerate(block.plane):
        middle[axis] = 2.0 * block.centre[index] - block.start[axis]
    half = math.copysign(180.0, block.angle)
    return (
        replace(block, end=middle, angle=half, end_pcs=block.programmed(middle), end_feed=None),
        replace(block, start=middle, angle=block.angle - half),
    )
