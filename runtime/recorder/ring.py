"""The ring between the cycle, which records, and the process that brings the records to the disk.

Whole records of words (8 bytes), each with its length in its first word. One writer, one reader, in shared memory. The cycle
never waits: a record that finds no room is dropped and counted, and the next one that fits carries the mark of a gap.

    | written | read | records | dropped | … |  record  record  record ···
"""

from __future__ import annotations

import mmap

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.memory import SharedMemory, open_shared

Words = npt.NDArray[np.int64]
RING_BYTES = 16 << 20  # some 20 s of a machine in motion
_HEAD = 64  # bytes
_WRITTEN, _READ, _RECORDS, _DROPPED, _KEYFRAME, _REFUSED = 0, 1, 2, 3, 4, 5


class RecorderRing:
    """The ring, in shared memory when `name` is given, else in this process only; `create` makes it, of `size` bytes."""

    def __init__(self, name: str | None = None, *, create: bool = True, size: int = RING_BYTES) -> None:
        self._memory: SharedMemory | None = None
        if name is None:
            buffer: mmap.mmap | bytearray = bytearray(_HEAD + size)
        else:
            self._memory = open_shared(name, _HEAD + size if create else None)
            buffer = self._memory.buf
        self._counters: Words = np.frombuffer(buffer, dtype=np.int64, count=8)
        self._words: Words = np.frombuffer(buffer, dtype=np.int64, offset=_HEAD)
        self.capacity = len(self._words)
        if create:
            self._words[:] = 0  # every page is there before the first cycle

    # ------------------------------------------------------------------ the cycle's side

    def put(self, record: Words) -> bool:
        """Append a record; FALSE if it was dropped. Bounded, never waits."""
        counters, words = self._counters, self._words
        written = int(counters[_WRITTEN])
        count = len(record)
        if self.capacity - (written - int(counters[_READ])) < count:
            counters[_DROPPED] += 1
            return False
        slot = written % self.capacity
        first = min(count, self.capacity - slot)
        words[slot : slot + first] = record[:first]
        if first < count:
            words[: count - first] = record[first:]
        counters[_RECORDS] += 1
        counters[_WRITTEN] = written + count
        return True

    def take_wish(self) -> bool:
        """Whether the reader has asked for a keyframe since the last call."""
        if not self._counters[_KEYFRAME]:
            return False
        self._counters[_KEYFRAME] = 0
        return True

    def refuse_keyframes(self) -> None:
        """The state has something that cannot be recorded: there will be no keyframe but the first."""
        self._counters[_REFUSED] = 1

    # ------------------------------------------------------------------ the reader's side

    @property
    def keyframes_refused(self) -> bool:
        """There will be no keyframe but the first."""
        return bool(self._counters[_REFUSED])

    def want_keyframe(self) -> None:
        """Ask the cycle for a keyframe."""
        self._counters[_KEYFRAME] = 1

    def take(self, most: int = 1 << 17) -> Words:
        """Whole records that have come, oldest first, at least one if there is one and hardly more than `most` words; a copy."""
        read, written = int(self._counters[_READ]), int(self._counters[_WRITTEN])
        end = read
        while end < written and end - read < most:
            end += int(self._words[end % self.capacity])
        slot, count = read % self.capacity, end - read
        first = min(count, self.capacity - slot)
        taken = np.concatenate([self._words[slot : slot + first], self._words[: count - first]])
        self._counters[_READ] = end
        return taken

    @property
    def waiting(self) -> int:
        """Bytes that nobody has taken yet."""
        return 8 * int(self._counters[_WRITTEN] - self._counters[_READ])

    @property
    def records(self) -> int:
        """Records ever put."""
        return int(self._counters[_RECORDS])

    @property
    def dropped(self) -> int:
        """Records that found the ring full."""
        return int(self._counters[_DROPPED])

    def close(self, *, unlink: bool = False) -> None:
        """Let go of the memory; `unlink` also removes it (its creator does)."""
        if self._memory is None:
            return
        memory, self._memory = self._memory, None
        del self._counters, self._words
        if unlink:
            memory.remove()
        else:
            memory.close()
