"""The records of a recording in their order, and what stands in later ones: pieces of a keyframe, records of the motion queue."""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator
from dataclasses import dataclass, field

import numpy as np
import numpy.typing as npt

from runtime.cnc.motion_queue import MotionQueue
from runtime.recorder.keyframes import RECORD_WORDS, put_records
from runtime.recorder.record import GAP, CycleRecord, Section

Words = npt.NDArray[np.int64]
Piece = tuple[int, int, Words]  # area or ring, first word or record, content


@dataclass(slots=True)
class Beginning:
    """What a keyframe tells; `state` of the objects, empty if they are as they were built."""

    areas: list[Piece] = field(default_factory=list)
    rings: list[Piece] = field(default_factory=list)
    state: bytes = b""
    whole: bool | None = None  # not yet told; FALSE: given up


class ReplaySource:
    """Brings the motion queue's records to their places when they were there in the recording.

    They were recorded some at a time, so some of them stand in records of later cycles.
    """

    def __init__(self, records: Iterator[CycleRecord]) -> None:
        self._records = records
        self._read_ahead: deque[CycleRecord] = deque()
        self._waiting: deque[tuple[int, Words]] = deque()
        self._beginning = Beginning(whole=False)
        self.filled = 0  # up to which record of the queue

    def attach(self, queue: MotionQueue) -> None:
        """The queue of a controller that begins anew."""
        self._slots: Words = queue.records.view(np.int64).reshape(queue.capacity, RECORD_WORDS)
        self._polynomials: Words = queue.polynomials.view(np.int64).reshape(queue.capacity, -1)

    def begin(self, keyframe: CycleRecord) -> Beginning | None:
        """Everything of before is forgotten; what the keyframe of this record tells, None if that is not whole."""
        self._waiting.clear()
        beginning = self._beginning = Beginning()
        for record in (keyframe, *self._read_ahead):
            self._note(record)
        while beginning.whole is None:
            if self._interrupted or not self._look():
                return None
        return beginning if beginning.whole else None

    def records(self) -> Iterator[CycleRecord]:
        """The records of the recording in their order."""
        while self._read_ahead or self._look():
            yield self._read_ahead.popleft()

    def fill_to(self, written: int) -> bool:
        """Everything in front of record `written` is in its place; FALSE if the recording ends before it stands there."""
        while self.filled < written:
            if not self._waiting:
                if self._interrupted or not self._look():
                    return False
                continue
            first, words = self._waiting.popleft()
            self.filled, at = put_records(words, first, self._slots, self._polynomials, written)
            if at < len(words):
                self._waiting.appendleft((self.filled, words[at:]))
        return True

    @property
    def _interrupted(self) -> bool:
        """What would have followed is missing."""
        return bool(self._read_ahead) and bool(self._read_ahead[-1].marks & GAP)

    def _look(self) -> bool:
        record = next(self._records, None)
        if record is None:
            return False
        self._note(record)
        self._read_ahead.append(record)
        return True

    def _note(self, record: CycleRecord) -> None:
        """What later records bring for earlier cycles."""
        beginning = self._beginning
        for kind, words in record.sections:
            if kind == Section.QUEUE_RECORDS:
                self._waiting.append((int(words[0]), words[1:]))
            elif kind > Section.KEYFRAME_END or beginning.whole is not None:
                continue
            elif kind == Section.KEYFRAME_AREA:
                beginning.areas.append((int(words[0]), int(words[1]), words[2:]))
            elif kind == Section.KEYFRAME_RING:
                beginning.rings.append((int(words[0]), int(words[1]), words[2:]))
            elif kind == Section.KEYFRAME_STATE:
                beginning.state += words.tobytes().rstrip() + b"\n"
            elif kind == Section.KEYFRAME_END:
                beginning.whole = bool(words[0])
