"""How long the cycles take and how late they start: histograms in memory that another process may read.

The cycle counts, the service process exports. The buckets are fixed, nothing is allocated while counting. A reader sees
each number whole, and takes the number of cycles from the buckets, so that what it exports is consistent in itself.

    per histogram, u64   | magic, last, greatest, sum | bucket 0 | bucket 1 | … | bucket n (above the last bound) |
"""

from __future__ import annotations

import mmap
from bisect import bisect_left
from collections.abc import Sequence

from runtime.diagnostics.memory import SharedMemory, open_shared

BOUNDS_NS: tuple[int, ...] = tuple(
    round(microseconds * 1000)
    for microseconds in (
        *(1, 2, 3, 5, 7, 10, 15, 20, 30, 50, 70, 100, 150, 200, 250, 300, 400, 500, 700),
        *(1000, 1500, 2000, 3000, 5000, 10_000, 20_000, 50_000, 100_000),
    )
)
"""Upper bounds of the buckets, inclusive, ns; a bucket for everything above follows."""

_HEAD = 4
_WORDS = _HEAD + len(BOUNDS_NS) + 1
_MAGIC = 0x54534948_00000001 + len(BOUNDS_NS)


class Histogram:
    """Durations in ns, counted into the buckets of BOUNDS_NS."""

    __slots__ = ("_words",)

    def __init__(self, words: memoryview[int]) -> None:
        """`words`: `_WORDS` unsigned 64-bit numbers, zero at first."""
        self._words = words

    def add(self, duration_ns: int) -> None:
        """Count one duration. Called in the cycle."""
        words = self._words
        words[1] = duration_ns
        if duration_ns > words[2]:
            words[2] = duration_ns
        words[3] += duration_ns
        words[_HEAD + bisect_left(BOUNDS_NS, duration_ns)] += 1

    @property
    def bounds(self) -> tuple[float, ...]:
        """Upper bounds of all buckets but the last, s."""
        return tuple(bound / 1e9 for bound in BOUNDS_NS)

    @property
    def counts(self) -> tuple[int, ...]:
        """Durations per bucket, one more than there are bounds."""
        return tuple(self._words[_HEAD:])

    @property
    def count(self) -> int:
        """How many durations were counted."""
        return sum(self._words[_HEAD:])

    @property
    def sum(self) -> float:
        """All durations together, s."""
        return self._words[3] / 1e9

    @property
    def last(self) -> float:
        """The last duration, s."""
        return self._words[1] / 1e9

    @property
    def greatest(self) -> float:
        """The greatest duration so far, s."""
        return self._words[2] / 1e9

    def quantile(self, share: float) -> float:
        """The duration that `share` (0…1) of all stay within, s: interpolated in its bucket, 0 without any."""
        counts, greatest = self.counts, self.greatest
        wanted = share * sum(counts)
        below, reached = 0.0, 0
        for bound, count in zip((*self.bounds, greatest), counts, strict=True):
            if count and reached + count >= wanted:
                above = min(bound, greatest)
                return below + max(0.0, above - below) * (wanted - reached) / count
            below, reached = bound, reached + count
        return greatest


class CycleStatistics:
    """The two histograms of a cycle: `work` (start to end of the work) and `lateness` (due to start).

    In shared memory when `name` is given, else in this process only. `create` makes the memory; without it that of a
    running machine is opened: FileNotFoundError if there is none, ValueError if it is of another version.
    """

    def __init__(self, name: str | None = None, *, create: bool = True) -> None:
        self._memory: SharedMemory | None = None
        size = 2 * _WORDS * 8
        buffer: mmap.mmap | bytearray
        if name is None:
            buffer = bytearray(size)
        else:
            self._memory = open_shared(name, size if create else None)
            buffer = self._memory.buf
        words = memoryview(buffer)[:size].cast("Q")
        self._views: Sequence[memoryview[int]] = (words[:_WORDS], words[_WORDS:], words)
        self.work = Histogram(self._views[0])
        self.lateness = Histogram(self._views[1])
        if name is None or create:
            words[0] = _MAGIC
        elif words[0] != _MAGIC:
            self.close()
            raise ValueError(f"{name} holds no cycle statistics of this version")

    def close(self, *, unlink: bool = False) -> None:
        """Let go of the memory; `unlink` also removes it (its creator does)."""
        for view in self._views:
            view.release()
        if self._memory is None:
            return
        memory, self._memory = self._memory, None
        if unlink:
            memory.remove()
        else:
            memory.close()
