"""Keyframes: what a replay needs to begin in the middle of a recording.

    the cycle of the keyframe   record with the mark: counters of the queue; everything else is noted in memory
    the cycles behind it        pieces of what was noted, in the records of these cycles: areas, way that is kept, state; the end

What is noted is that of one moment, in front of the cycle; telling it takes its time. Before, some objects in each cycle, it is
looked at which objects there are (`noting`). In front of the first cycle everything is as it was built, so that keyframe has
areas only, and all of it in one record.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.path_storage import FIRST, NEXT, OPEN, PathStorage
from runtime.cnc.motion_queue import RECORD, MotionQueue, RecordKind
from runtime.kernels import kernel, warms
from runtime.recorder.areas import Area
from runtime.recorder.noting import Noted, StateNotes
from runtime.recorder.record import Section
from runtime.recorder.state import Outside, StateError

Words = npt.NDArray[np.int64]
Told = tuple[Section, Words]  # a section of a record

RECORD_WORDS = RECORD.itemsize // 8
AREA_WORDS = 8192  # told in one cycle
KEPT_RECORDS = 64  # of the way that is kept, told in one cycle
RETRY = 8  # cycles between two attempts, when too much was new
ATTEMPTS = 5  # until it is looked again which objects there are
_POLYNOMIAL = int(RecordKind.POLYNOMIAL)
_OPEN_SIZE = RECORD.fields["size"][1] // 8  # type: ignore[index]


@kernel
def stage_records(
    records: Words, polynomials: Words, kinds: npt.NDArray[np.int64], first: int, count: int, out: Words, at: int
) -> int:
    """Queue records from absolute index `first` on, as a section's content; (capacity, words) each."""
    capacity = records.shape[0]
    for index in range(first, first + count):
        slot = index % capacity
        for k in range(records.shape[1]):
            out[at + k] = records[slot, k]
        at += records.shape[1]
        if kinds[slot] == _POLYNOMIAL:
            for k in range(polynomials.shape[1]):
                out[at + k] = polynomials[slot, k]
            at += polynomials.shape[1]
    return at


@warms("keyframes of the recorder")
def _warm() -> None:
    words = np.zeros((1, 2), dtype=np.int64)
    kinds = np.zeros((2, 2), dtype=np.int64)[:, 0]  # not contiguous, as those of the queue
    stage_records(words, words, kinds, 0, 1, np.zeros(8, dtype=np.int64), 0)


class Keyframes:
    """Of one border. `prepare`, `take` and `tell` in each cycle, as far as there is something to do."""

    def __init__(self, areas: tuple[Area, ...], root: object, outside: Outside, storage: PathStorage | None) -> None:
        self._areas = areas
        self._copies = [area.agreed.copy() for area in areas]
        self._notes = StateNotes(root, outside)
        self._storage = storage
        self._survey: Iterator[None] | None = None
        self._ready = False
        self._attempts = 0
        self._pause = 0
        self._pieces: Iterator[Told] | None = None

    @property
    def telling(self) -> bool:
        """Pieces of a keyframe follow."""
        return self._pieces is not None

    def first(self) -> Iterator[Told]:
        """That in front of the first cycle."""
        for number, area in enumerate(self._areas):
            yield _area_piece(number, 0, area.agreed)
        yield Section.KEYFRAME_END, np.array([1], dtype=np.int64)

    def prepare(self) -> bool:
        """One is wanted: a step of looking which objects there are; whether it can be taken. Raises StateError."""
        if self._pause:
            self._pause -= 1
            return False
        if self._ready:
            return True
        if self._survey is None:
            self._survey = self._notes.survey()
        if next(self._survey, self) is self:
            self._survey, self._ready, self._attempts = None, True, 0
        return False

    def take(self) -> bool:
        """Note everything as it is now; FALSE if too much was new: it is tried again some cycles later. Raises StateError."""
        noted = self._notes.note()
        if noted is None:
            self._pause = RETRY
            self._attempts += 1
            self._ready = self._attempts < ATTEMPTS
            return False
        for copy, area in zip(self._copies, self._areas, strict=True):
            np.copyto(copy, area.agreed)
        self._ready = False
        self._pieces = self._tell(noted, [] if self._storage is None else _rings_of(self._storage))
        return True

    def tell(self) -> Told:
        """The next piece, while `telling`."""
        assert self._pieces is not None
        try:
            piece = next(self._pieces)
        except StateError:  # it cannot be replayed from here, but from the next one
            piece = (Section.KEYFRAME_END, np.array([0], dtype=np.int64))
        if piece[0] == Section.KEYFRAME_END:
            self._pieces = None
        return piece

    def _tell(self, noted: Noted, rings: list[_Ring]) -> Iterator[Told]:
        for ring in rings:  # first, since the path writes over them
            yield from ring.pieces()
        for number, copy in enumerate(self._copies):
            for begin in range(0, len(copy), AREA_WORDS):
                yield _area_piece(number, begin, copy[begin : begin + AREA_WORDS])
        for text in self._notes.tell(noted):
            yield Section.KEYFRAME_STATE, np.frombuffer(text.ljust(-(-len(text) // 8) * 8, b" "), dtype=np.int64)
        yield Section.KEYFRAME_END, np.array([1], dtype=np.int64)


def _area_piece(number: int, begin: int, words: Words) -> Told:
    return Section.KEYFRAME_AREA, np.concatenate([np.array([number, begin], dtype=np.int64), words])


class _Ring:
    """Records first … end - 1 of a ring of the cycle, noted by their numbers only: the path writes over them later than they are
    told. `written` tells how many there ever were; should they be written over all the same the keyframe is given up."""

    def __init__(
        self,
        which: int,
        records: npt.NDArray[np.void],
        polynomials: npt.NDArray[np.float64],
        first: int,
        end: int,
        written: Callable[[], int],
        still_open: int = -1,
    ) -> None:
        self._which, self._written = which, written
        self._capacity = len(records)
        self._records: Words = records.view(np.int64).reshape(len(records), RECORD_WORDS)
        self._polynomials: Words = polynomials.view(np.int64).reshape(len(records), -1)
        self._kinds = records["kind"]
        self._first, self._end = first, end
        self._open = still_open  # a section that ends behind the keyframe: what its end adds to it is taken back

    def pieces(self) -> Iterator[Told]:
        """Raises StateError."""
        out = np.zeros(2 + KEPT_RECORDS * (RECORD_WORDS + self._polynomials.shape[1]), dtype=np.int64)
        at = self._first
        while at < self._end:
            if not self._end <= self._written() <= at + self._capacity:
                raise StateError("the path was faster than the recorder")
            count = min(KEPT_RECORDS, self._end - at)
            if at < self._open:
                count = min(count, self._open - at)
            out[0], out[1] = self._which, at
            end = stage_records(self._records, self._polynomials, self._kinds, at, count, out, 2)
            if at == self._open:
                out[2 + _OPEN_SIZE] = -1
            yield Section.KEYFRAME_RING, out[:end]
            at += count


def _rings_of(storage: PathStorage) -> list[_Ring]:
    state, counters = storage.state, storage.queue.counters
    kept = _Ring(
        0, storage.kept, storage.tables, int(state[FIRST]), int(state[NEXT]), lambda: int(state[NEXT]), int(state[OPEN])
    )
    queue = storage.queue
    again = _Ring(1, queue.records, queue.polynomials, int(counters[1]), int(counters[0]), lambda: int(counters[0]))
    return [kept, again]


def ring_slots(storage: PathStorage, which: int) -> tuple[Words, Words]:
    """Records and polynomials of a ring as words, to put back what was told of it."""
    queue: MotionQueue = storage.queue
    records, polynomials = (storage.kept, storage.tables) if which == 0 else (queue.records, queue.polynomials)
    return (
        records.view(np.int64).reshape(len(records), RECORD_WORDS),
        polynomials.view(np.int64).reshape(len(records), -1),
    )


def put_records(
    words: Words, first: int, records: Words, polynomials: Words, until: int | None = None
) -> tuple[int, int]:
    """Staged records back into their slots, up to before index `until`; the index and the word behind the last one."""
    at, index = 0, first
    while at < len(words) and (until is None or index < until):
        slot = index % len(records)
        records[slot] = words[at : at + RECORD_WORDS]
        at += RECORD_WORDS
        if records[slot, 0] == _POLYNOMIAL:
            polynomials[slot] = words[at : at + polynomials.shape[1]]
            at += polynomials.shape[1]
        index += 1
    return index, at
