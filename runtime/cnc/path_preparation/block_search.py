"""Block search: a program is entered in the middle. Everything up to there is computed, nothing of it is moved.

    BEGIN ─ left out: motion, stops, dwells, messages ─ END ─ RETURN ─ way back ─ GO_ON ─ the rest of the program
      │       └ kept: the last of each function, put out where the decoder waits, and at END
      └ the PLC agrees                                   │       └ preparation waits here: where the axes stand
                                                         └ the PLC has done what it got

The stage stands behind all others, so the place lies on the path that would have been driven: compensated, smoothed. It counts
the way, and tells it where the program goes on (`SearchPlace`), so that an interruption of the rest can be found again.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import (
    AT_BLOCK_END,
    Arc,
    AxisJob,
    AxisJobWait,
    Block,
    BlockEnd,
    CouplingChange,
    CuttingSpeed,
    Dwell,
    ExactStop,
    Floats,
    Flush,
    FlushKind,
    Hold,
    Homing,
    IndependentMotion,
    IndependentWait,
    Line,
    ManualKind,
    ManualMotion,
    Measurement,
    Message,
    PathRestart,
    Polyline,
    Polynomials,
    PositionSetting,
    SearchArea,
    SearchGate,
    SearchMark,
    SearchPlace,
    SearchStep,
    Source,
    SpindleRole,
    SpindleSection,
    SpindleSetting,
    StepEnd,
    Stop,
    StopKind,
    StopMark,
    Synch,
    TakeOver,
    Technology,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.path_preparation.element_lengths import (
    MOTIONS,
    Motion,
    begin_of,
    behind,
    element_ends,
    element_lengths,
)
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.motion_pieces import NO_LENGTH
from runtime.cnc.search_target import BlockSearch, SearchKind
from runtime.diagnostics.catalogue import block_search as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place

ON_BORDER = 1e-6  # mm: a place so near to the end of an element lies behind it
CHECKED_WAY = 5.0  # mm before the place in which the line of the interruption is looked for
_CHECKED_ELEMENTS = 64
_OF_THE_PROGRAM = frozenset({0, 1, 2, 17, 29, 30})  # M functions that only steer the program
_NO_WAIT = (Synch.NO_SYNCH, Synch.MOS, Synch.MOS_TS, Synch.MEP_MOS, Synch.MET_MOS)
_MAIN = 3


class CollectedFunctions:
    """The last of each function that was left out, in the order in which they came last."""

    def __init__(self) -> None:
        self._kept: dict[tuple[object, ...], TechnologyFunction | SpindleSetting | CuttingSpeed] = {}

    def take(self, block: TechnologyFunction | SpindleSetting | CuttingSpeed) -> None:
        """An older one of the same kind and number gives way; of a spindle there is one command, and one speed."""
        if isinstance(block, SpindleSetting):
            key: tuple[object, ...] = ("setting", block.spindle, block.what)
        elif isinstance(block, CuttingSpeed):
            key = ("cutting speed",)
        elif block.kind is Technology.M and block.number in _OF_THE_PROGRAM:
            return
        elif block.kind is Technology.S:
            key = ("S", block.spindle, block.plc_spindle, block.number != 0)
        else:
            key = (block.kind, block.area, 0 if block.kind is Technology.T else block.number)
        self._kept.pop(key, None)
        self._kept[key] = block

    def put_out(self) -> Iterator[Block]:
        """One after the other, each waited for if its type asks for it; nothing is left."""
        kept, self._kept = self._kept, {}
        for block in kept.values():
            if isinstance(block, SpindleSetting | CuttingSpeed):
                yield block
                continue
            kind = block.synch.kind
            waited = kind not in _NO_WAIT
            standing = Synch.MVS_SVS if waited else kind if kind in (Synch.NO_SYNCH, Synch.MOS) else Synch.MOS
            flags = block.synch.flags & ~int(Synch.FAW_SYNCH)
            yield replace(block, synch=Synch(int(standing) | int(flags)), lead=0.0)
            if waited:
                yield Wait(block.source, AT_BLOCK_END)


class BlockSearchStage:
    """The stage of one program start. `begin` (n_axes,): where the program begins; `standing()`: where the axes stand when
    the cycle has passed RETURN; `interrupted()`: an order waits, the blocks end early."""

    def __init__(
        self,
        target: BlockSearch,
        program: str,
        begin: Floats,
        standing: Callable[[], Floats],
        interrupted: Callable[[], bool],
    ) -> None:
        self._target = target
        self._program = program
        self._standing = standing
        self._interrupted = interrupted
        self._functions = CollectedFunctions()
        self._place: Floats = np.array(begin)
        self._way = 0.0
        self._blocks = 0
        self._feed = math.inf  # of the last motion that was no rapid one, mm/min
        self._plane = (0, 1)
        self._source = Source(program, 0)
        self._marked = self._locked = False
        self._with_spindle = False  # path and spindle move together
        self._lines: deque[tuple[float, int]] = deque(
            maxlen=_CHECKED_ELEMENTS
        )  # ends of the last elements, and their lines
        self.searching = True

    @property
    def place(self) -> Floats:
        """Where the program has come to without the axes, (n_axes,)."""
        return self._place

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        yield SearchGate(self._source, SearchStep.BEGIN)
        rest = iter(blocks)
        for block in rest:
            yield from self._left_out(block)
            if not self.searching:
                yield from rest
                return
        if self.searching and not self._interrupted():
            raise self._error(catalogue.SEARCH_NOT_FOUND, target=self._wanted)

    # ------------------------------------------------------------------ what is left out

    def _left_out(self, block: Block) -> Iterator[Block]:
        if isinstance(block, MOTIONS):
            yield from self._motion(block)
            return
        match block:
            case SearchMark():
                self._source, self._marked = block.source, True
                if self._target.covered <= 0.0 and not self._with_spindle:  # which the block may be about to end
                    yield from self._enter(self._place, self._feed)
            case SearchArea():
                self._locked = block.locked
            case TechnologyFunction() | SpindleSetting() | CuttingSpeed():
                self._functions.take(block)
            case SpindleSection():
                self._with_spindle = block.role is not SpindleRole.FREE
                if self._marked and not self._with_spindle and self._target.covered <= 0.0:
                    yield from self._enter(self._place, self._feed)
            case Flush():
                if block.kind is FlushKind.WAIT:
                    yield from self._functions.put_out()
                    yield block
            case Hold():
                yield from self._functions.put_out()
                yield block
            case Stop(kind=StopKind.PROGRAM_END):
                self._source = block.source
                if self._target.kind is not SearchKind.INTERRUPTION or self._way < self._target.way - ON_BORDER:
                    raise self._error(catalogue.SEARCH_NOT_FOUND, target=self._wanted)
                yield from self._enter(self._place, self._feed)  # only functions were left to be done
                yield block
            case BlockEnd():
                self._blocks += 1
            case (
                StepEnd()
                | StopMark()
                | Stop()
                | Dwell()
                | ExactStop()
                | Wait()
                | Message()
                | PathRestart()
                | SearchPlace()
                | SearchGate()
            ):
                return
            case AxisJob() | AxisJobWait():
                self._refuse(block.source, "a job of an axis")
            case Homing():
                self._refuse(block.source, "homing (G74)")
            case IndependentMotion() | IndependentWait():
                self._refuse(block.source, "an own motion of an axis (INDP_SYN, INDP_ASYN)")
            case CouplingChange():
                self._refuse(block.source, "an axis coupling (#AX LINK)")
            case Measurement():
                self._refuse(block.source, "a measuring run")
            case PositionSetting():
                self._refuse(block.source, "SET_POSITION")
            case TakeOver():
                self._refuse(block.source, "the taking over of offsets by hand")
            case ManualMotion(kind=ManualKind.EXCLUSIVE):
                self._refuse(block.source, "manual mode (G200)")
            case _:
                yield block

    def _refuse(self, source: Source, what: str) -> None:
        self._source = source
        raise self._error(catalogue.SEARCH_STOPS_HERE, what=what)

    def _motion(self, motion: Motion) -> Iterator[Block]:
        lengths = element_lengths(motion)
        found = self._entry(motion, lengths)
        count = len(lengths) if found is None else found[0]
        lines, feeds = _lines(motion), _feeds(motion)
        ends = self._way + np.cumsum(lengths[:count])
        first = max(0, count - _CHECKED_ELEMENTS)
        self._lines.extend(zip(ends[first:].tolist(), lines[first:count].tolist(), strict=True))
        if count:
            self._way = float(ends[-1])
            self._place = element_ends(motion)[count - 1]
            self._blocks += _block_ends(motion, count)
            fed = feeds[:count][np.isfinite(feeds[:count])]
            self._feed = float(fed[-1]) if len(fed) else self._feed
        self._plane = motion.plane or self._plane
        if found is None:
            return
        element, taken = found
        self._source = _source(motion, element)
        self._check_line(lines[element:], self._way + np.cumsum(lengths[element:]), taken)
        rest = list(behind(motion, element, taken, float(lengths[element])))
        self._way += taken
        self._place = begin_of(rest[0]) if rest else element_ends(motion)[-1]
        yield from self._enter(self._place, float(feeds[element]))
        yield from rest

    def _entry(self, motion: Motion, lengths: Floats) -> tuple[int, float] | None:
        """The element in which the program is entered, and how far in it; None if that comes later."""
        target = self._target
        there = lengths > NO_LENGTH
        if target.kind is SearchKind.INTERRUPTION:
            ends = self._way + np.cumsum(lengths)
            inside = np.flatnonzero(there & (ends > target.way + ON_BORDER))
            if not len(inside):
                return None
            element = int(inside[0])
            taken = target.way - (ends[element] - lengths[element])
            return element, float(taken) if taken > ON_BORDER else 0.0
        if target.kind is SearchKind.BLOCK_COUNTER:
            ended = self._blocks + _ends_before(motion)
            inside = np.flatnonzero(there & (ended >= target.value))
        else:
            inside = np.flatnonzero(there) if self._marked else np.zeros(0, dtype=np.int64)
        if not len(inside):
            return None
        element = int(inside[0])
        return element, float(lengths[element] * min(max(target.covered, 0.0), 1.0))

    def _check_line(self, lines: npt.NDArray[np.int64], ends: Floats, taken: float) -> None:
        """An interruption lies on the line that it was told with, or that line has just ended."""
        asked = self._target.line
        if self._target.kind is not SearchKind.INTERRUPTION or not asked:
            return
        place = self._way + taken
        near = {int(line) for line, end in zip(lines, ends, strict=True) if end <= place + CHECKED_WAY}
        near |= {line for end, line in self._lines if end >= place - CHECKED_WAY}
        if asked not in near | {int(lines[0])}:
            raise self._error(catalogue.SEARCH_CHANGED, line=asked, found=int(lines[0]))

    # ------------------------------------------------------------------ the way back

    def _enter(self, place: Floats, feed: float) -> Iterator[Block]:
        if self._locked:
            raise self._error(catalogue.SEARCH_LOCKED, target=self._wanted)
        if self._with_spindle:
            raise self._error(catalogue.SEARCH_WITH_SPINDLE, target=self._wanted)
        target, source = self._target, self._source
        yield from self._functions.put_out()
        yield SearchGate(source, SearchStep.END)
        self.searching = False
        yield SearchGate(source, SearchStep.RETURN, target.automatic)
        here = self._standing()
        yield PathRestart(source)
        chosen = target.feed or feed
        for end in way_back(here, place, target.ranks, self._tool_axis):
            rapid = math.isinf(chosen)
            yield Line(source, here, end, math.inf if rapid else chosen, rapid, end, self._plane)
            yield BlockEnd(source)
            here = end
        yield SearchPlace(source, self._way, self._blocks)
        yield SearchGate(source, SearchStep.GO_ON, target.without_stop)

    @property
    def _tool_axis(self) -> int | None:
        """The main axis across the plane."""
        others = [axis for axis in range(min(_MAIN, len(self._place))) if axis not in self._plane]
        return others[0] if len(others) == 1 else None

    # ------------------------------------------------------------------ errors

    @property
    def _wanted(self) -> str:
        """The place in words."""
        target = self._target
        words = {
            SearchKind.FILE_OFFSET: f"file offset {target.value}",
            SearchKind.BLOCK_COUNTER: f"block {target.value}",
            SearchKind.BLOCK_NUMBER: f"block N{target.value}",
            SearchKind.LINE: f"line {target.value}",
            SearchKind.INTERRUPTION: f"the place of the interruption ({target.way:.3f} mm of path)",
        }
        passes = f" for the {target.passes}. time" if target.passes > 1 else ""
        return words[target.kind] + passes + (f" in {target.program}" if target.program else "")

    def _error(self, entry: ErrorEntry, **values: object) -> PathError:
        source = self._source
        return PathError(entry, Place(source.program, source.line), **values)


def way_back(start: Floats, end: Floats, ranks: Sequence[int], tool_axis: int | None) -> Iterator[Floats]:
    """The corners of the way from `start` to `end`, (n_axes,) each: axes of one rank together, rank by rank.

    Without ranks the tool axis comes last, or first where it moves in its positive direction, away from the workpiece.
    """
    turns = np.zeros(len(start), dtype=np.int64)
    if any(ranks):
        turns[: len(ranks)] = ranks
    elif tool_axis is not None:
        turns[tool_axis] = -1 if end[tool_axis] > start[tool_axis] else 1
    here = start
    for turn in np.unique(turns):
        there = np.where(turns == turn, end, here)
        if np.abs(there - here).max() > NO_LENGTH:
            here = there
            yield there


def _lines(motion: Motion) -> npt.NDArray[np.int64]:
    return motion.lines if isinstance(motion, Polyline | Polynomials) else np.array([motion.source.line])


def _feeds(motion: Motion) -> Floats:
    if isinstance(motion, Polyline | Polynomials):
        return motion.feeds
    return np.array([math.inf if isinstance(motion, Line) and motion.rapid else motion.feed])


def _source(motion: Motion, element: int) -> Source:
    if isinstance(motion, Line | Arc):
        return motion.source
    number = int(motion.numbers[element])
    return Source(motion.program, int(motion.lines[element]), number if number >= 0 else None)


def _ends(motion: Motion) -> npt.NDArray[np.int64]:
    """1 where an NC block ends with an element, (k,)."""
    if isinstance(motion, Polyline):
        return np.full(len(motion.feeds), 0 if motion.one_block else 1)
    return motion.block_ends.astype(np.int64) if isinstance(motion, Polynomials) else np.zeros(1, dtype=np.int64)


def _ends_before(motion: Motion) -> npt.NDArray[np.int64]:
    ends = _ends(motion)
    return np.cumsum(ends) - ends


def _block_ends(motion: Motion, count: int) -> int:
    return int(_ends(motion)[:count].sum())
