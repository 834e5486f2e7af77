"""Functions that are put out ahead of their place: a way (MEP) or a time (MET) before the path comes there.

            put out                                place of the function
               ▼            lead                        ▼
    ━━━━┿━━━━━━●━━━━━┿━━━━━━━━━━━━━━┿━━━━━━━━━┿━━━━━━━━━●━━━━━━━
     path here       borders of blocks

The records of the queue are looked through once, in order, some of them in each cycle. The way from here to a function is the
difference of two sums of the same lengths, so it is exact however long the path has become.

Overlap (channel parameters, lines 2031–2138): functions of different blocks keep the order of the program; one that is due
before one programmed earlier waits for it. Functions of one block are independent of each other.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import BY_PATH
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import RECORD, MotionQueue, RecordKind, Records
from runtime.cnc.queue_record import QueueRecord, read_record
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

SEARCH = 512  # records looked through in one cycle
MOST = 64  # functions that are known ahead at the same time; further ones are found when some of them are passed

_FUNCTION, _AHEAD = int(RecordKind.FUNCTION), int(RecordKind.FUNCTION_AHEAD)
_BLOCK_END = int(RecordKind.BLOCK_END)
_BY_PATH = int(BY_PATH)
# state of the search
HERE, SEEN, BLOCKS_HERE, BLOCKS_SEEN = 0, 1, 2, 3  # indices, and ends of blocks before them
WAY_HERE, WAY_SEEN = 0, 1  # mm


@kernel
def look_through(
    records: Records, written: int, cur: int, blocks: int, room: int, i: Ints, f: Floats, found: Ints, ways: Floats
) -> int:
    """Look through records that are new, at most `blocks` NC blocks ahead of `cur`; returns how many functions were found.

    `i`, `f`: state. `found` and `ways`: indices of the functions, and the way to them in the measure of `f[WAY_HERE]`.
    """
    size = records.shape[0]
    while i[HERE] < cur:
        r = records[i[HERE] % size]
        f[WAY_HERE] += r["length"]
        if r["kind"] == _BLOCK_END or r["block_end"] == 1:
            i[BLOCKS_HERE] += 1
        i[HERE] += 1
    if i[SEEN] < cur:
        i[SEEN], f[WAY_SEEN], i[BLOCKS_SEEN] = cur, f[WAY_HERE], i[BLOCKS_HERE]
    count = 0
    end = min(written, i[SEEN] + SEARCH)
    while i[SEEN] < end and count < room and i[BLOCKS_SEEN] - i[BLOCKS_HERE] < blocks:
        r = records[i[SEEN] % size]
        if r["kind"] == _AHEAD:
            found[count], ways[count] = i[SEEN], f[WAY_SEEN]
            count += 1
        f[WAY_SEEN] += r["length"]
        if r["kind"] == _BLOCK_END or r["block_end"] == 1:
            i[BLOCKS_SEEN] += 1
        i[SEEN] += 1
    return count


@kernel
def last_function(records: Records, start: int, end: int, kinds: int) -> int:
    """Index of the last function of one of these types with start ≤ index < end, -1 if there is none."""
    size = records.shape[0]
    index = end - 1
    while index >= start:
        r = records[index % size]
        if (r["kind"] == _FUNCTION or r["kind"] == _AHEAD) and r["synch"] & kinds != 0:
            return index
        index -= 1
    return -1


@warms("functions ahead")
def _warm_up() -> None:
    records = np.zeros(1, dtype=RECORD)
    ints, floats = np.zeros(4, dtype=np.int64), np.zeros(2)
    found, ways = np.zeros(MOST, dtype=np.int64), np.zeros(MOST)
    look_through(records, 0, 0, 1, 1, ints, floats, found, ways)
    last_function(records, 0, 0, 1)


@dataclass(slots=True)
class Planned:
    """A function that is known ahead."""

    index: int
    record: QueueRecord
    way: float  # to its place, in the measure of the search
    block: int  # functions of one NC block have the same number
    out: bool = False


class FunctionsAhead:
    """Of one channel. `due` tells in every cycle what has to be put out now."""

    def __init__(self, queue: MotionQueue, path: Interpolator, blocks: int) -> None:
        self._queue = queue
        self._path = path
        self._blocks = blocks
        self._planned: list[Planned] = []
        self._i: Ints = np.zeros(4, dtype=np.int64)
        self._f: Floats = np.zeros(2)
        self._found: Ints = np.zeros(MOST, dtype=np.int64)
        self._ways: Floats = np.zeros(MOST)
        self._count = 0
        self._block = 0
        self._known = queue.functions_ahead  # that were found, or written before the program started
        self._looking = False

    def restart(self) -> None:
        """The queue has been emptied."""
        self._planned.clear()
        self._looking = False
        self._known = self._queue.functions_ahead

    def look(self) -> None:
        """Once per cycle, behind the step of the path."""
        if self._known == self._queue.functions_ahead and not self._planned:
            self._looking = False
            return
        cur = self._path.next_index
        if not self._looking:  # from here on sums are kept
            self._looking = True
            self._i[:] = cur, cur, 0, 0
            self._f[:] = 0.0
        room = MOST - len(self._planned)
        written = self._queue.written
        count = look_through(
            self._queue.records, written, cur, self._blocks, room, self._i, self._f, self._found, self._ways
        )
        for k in range(count):
            self._add(int(self._found[k]), float(self._ways[k]))

    def _add(self, index: int, way: float) -> None:
        record = read_record(self._queue, index)
        before = self._planned[-1] if self._planned else None
        same = (
            before is not None
            and before.way == way
            and (before.record.line, before.record.program) == (record.line, record.program)
        )
        if not same:
            self._block += 1
        self._known += 1
        self._planned.append(Planned(index, record, way, self._block))

    @property
    def any(self) -> bool:
        """Functions are known ahead."""
        return bool(self._planned)

    def to_go(self, planned: Planned) -> float:
        """Way of the axes from here to the place of a function, mm."""
        path = self._path
        cur = path.next_index
        here = float(self._f[WAY_HERE])
        if cur < self._queue.written:
            here += float(self._queue.record(cur)["length"]) - path.remaining
        return planned.way - here + path.trail

    def due(self, *, moving: bool, one_block: bool, release: Callable[[Planned, float], None]) -> None:
        """Calls `release` with each function to be put out now and the way to its place, in the right order.

        `moving`: the path is not held, so that times can be foreseen. `one_block`: while functions of a block are out, those
        of the blocks behind it wait until the path has come to its place.
        """
        open_block, out_block = -1, -1
        for planned in self._planned:
            if one_block and out_block >= 0 and planned.block != out_block:
                return
            if planned.out:
                out_block = planned.block
                continue
            if open_block >= 0 and planned.block != open_block:
                return
            way = self.to_go(planned)
            if self._is_due(planned, way, moving):
                planned.out = True
                out_block = planned.block
                release(planned, way)
            elif open_block < 0:
                open_block = planned.block

    def _is_due(self, planned: Planned, way: float, moving: bool) -> bool:
        lead = planned.record.lead
        if int(planned.record.synch) & _BY_PATH:
            return way <= lead
        if way <= 0.0:
            return True
        return moving and self._path.time_until(way - self._path.trail, planned.index, lead) <= lead

    def passed(self, index: int) -> Planned | None:
        """The path has come to a function; None if it was not known."""
        for k, planned in enumerate(self._planned):
            if planned.index == index:
                del self._planned[k]
                return planned
        self._known += 1  # passed before it was found
        return None

    def owed(self, gate: int) -> bool:
        """A function before the gate is not out, or is perhaps not even known."""
        if self._looking and self._i[SEEN] < gate:
            return True
        return any(planned.index < gate and not planned.out for planned in self._planned)

    def point(self) -> Planned | None:
        """The first function ahead that is out and whose place is still to come."""
        return next((planned for planned in self._planned if planned.out), None)

    def foreseen(self, planned: Planned) -> float:
        """Seconds to the place of a function; infinite if they cannot be foreseen."""
        return self._path.time_until(self.to_go(planned) - self._path.trail, planned.index, math.inf)
