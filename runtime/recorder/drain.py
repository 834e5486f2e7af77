"""The thread of the service process that brings the ring to the disk, and saves what was recorded around an alarm.

Whatever the disk does, the ring is emptied: a full disk costs the recording, never the machine. It is told, and tried again.
"""

from __future__ import annotations

import threading
import time
from collections.abc import Callable
from dataclasses import dataclass
from datetime import UTC, datetime

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.catalogue import recorder as errors
from runtime.diagnostics.errors import ErrorEntry, Place, Problem
from runtime.recorder.file import RecordingError
from runtime.recorder.ring import RecorderRing
from runtime.recorder.store import Segments, save

Words = npt.NDArray[np.int64]
_EVERY = 0.25  # s
_AGAIN = 5.0  # s between two attempts on a disk that does not take it
_BEHIND = 2.0  # s that are recorded after an alarm before it is saved
_BETWEEN = 10.0  # s between two alarms that are saved; a storm of them is one recording
_SEGMENTS_AT_ALARM = 3  # keyframes and what follows them


@dataclass(slots=True)
class RecorderFigures:
    """For the metrics."""

    bytes: int = 0
    records: int = 0
    dropped: int = 0
    lost: int = 0  # records that the disk did not take
    saved: int = 0
    writing: bool = False


class Drain:
    """`start` begins, `close` writes what is left and ends. `tell` gets what the journal has to know."""

    def __init__(
        self,
        ring: RecorderRing,
        segments: Segments,
        tell: Callable[[Problem], None],
        *,
        period: float,
        keyframe_every: float,
        kept: int,
        now: Callable[[], float] = time.monotonic,
    ) -> None:
        self._ring, self._segments, self._tell = ring, segments, tell
        self._period, self._keyframe_every, self._kept, self._now = period, keyframe_every, kept, now
        self._thread = threading.Thread(target=self._run, name="recorder", daemon=True)
        self._end = threading.Event()
        self._keyframe_at = now() + keyframe_every
        self._broken_since = 0.0
        self._again_at = 0.0
        self._save_at: float | None = None
        self._save_as = ""
        self._saved_at = -_BETWEEN
        self._told: list[ErrorEntry] = []
        self.figures = RecorderFigures()

    def start(self) -> None:
        self._thread.start()

    def alarm(self, number: int) -> None:
        """An alarm has come: what was before it and what comes behind it is saved. Never blocks."""
        if self._save_at is None and self._now() - self._saved_at >= _BETWEEN:
            self._save_as = f"alarm-{number}-{datetime.now(UTC):%Y%m%dT%H%M%S}.tandem"
            self._save_at = self._now() + _BEHIND

    def close(self) -> None:
        """Write what is left; the cycle has ended."""
        self._end.set()
        if self._thread.is_alive():
            self._thread.join(5.0)
        self.step()
        if self._save_at is not None:
            self._save()
        self._segments.close()

    def _run(self) -> None:
        while not self._end.wait(_EVERY):
            self.step()

    def step(self) -> None:
        """Once: what the thread does again and again."""
        now = self._now()
        while self._ring.waiting:
            words = self._ring.take()
            if self._broken_since and now < self._again_at:
                self.figures.lost += _count(words)
                continue
            try:
                self._segments.add(words)
            except OSError as error:
                self._failed(error, words, now)
            else:
                self._worked(now)
        if now >= self._keyframe_at or (self._segments.full and now >= self._again_at):
            self._keyframe_at, self._again_at = now + self._keyframe_every, now + _AGAIN
            self._ring.want_keyframe()
        if self._save_at is not None and now >= self._save_at:
            self._save()
        self._tell_limits()
        figures = self.figures
        figures.bytes, figures.records, figures.dropped = self._segments.bytes, self._ring.records, self._ring.dropped
        figures.writing = not self._broken_since

    def _tell_limits(self) -> None:
        """Once each: why a recording does not go on although the disk would take it."""
        for holds, entry in (
            (self._ring.keyframes_refused, errors.NO_KEYFRAMES),
            (self._segments.full, errors.ROOM_USED_UP),
        ):
            if holds and entry not in self._told:
                self._tell(Problem(entry, {"folder": self._segments.folder}))
                self._told.append(entry)
            elif not holds and entry in self._told:
                self._told.remove(entry)

    def _failed(self, error: OSError, words: Words, now: float) -> None:
        self._segments.fail()
        self.figures.lost += _count(words)
        self._again_at = now + _AGAIN
        if not self._broken_since:
            self._broken_since = now
            values = {"folder": self._segments.folder, "reason": error.strerror or str(error)}
            self._tell(Problem(errors.NOT_WRITTEN, values, Place(str(self._segments.folder))))

    def _worked(self, now: float) -> None:
        """The disk takes it; a segment goes on with the next keyframe only."""
        if not self._broken_since:
            return
        if self._segments.open:
            values = {"folder": self._segments.folder, "lost": round(now - self._broken_since)}
            self._broken_since = 0.0
            self._tell(Problem(errors.WRITES_AGAIN, values))
        else:
            self._ring.want_keyframe()

    def _save(self) -> None:
        self._save_at, self._saved_at = None, self._now()
        target = self._segments.folder / self._save_as
        segments = self._segments.current[-_SEGMENTS_AT_ALARM:]
        try:
            first, last = save(segments, target)
            self._segments.forget_saved(self._kept)
        except RecordingError:
            return  # nothing is recorded: that was told
        except OSError as error:
            values = {"folder": self._segments.folder, "reason": error.strerror or str(error)}
            self._tell(Problem(errors.NOT_WRITTEN, values, Place(str(target))))
            return
        self.figures.saved += 1
        self._tell(Problem(errors.SAVED, {"seconds": round((last - first) * self._period, 1), "file": target}))


def _count(words: Words) -> int:
    count = at = 0
    while at < len(words):
        at += int(words[at])
        count += 1
    return count
