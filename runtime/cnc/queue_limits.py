"""The axis limits that hold on the elements of the motion queue: a small ring of sets beside it, since they change rarely.

    sets (SETS, ROWS, MAX_AXES)                       record["limits"] = number of a set, slot = number % SETS

    row VELOCITY       mm or degrees per s            row JERK           per s³, while speeding up
    row ACCELERATION   per s², while speeding up      row BRAKING_JERK   per s³, while slowing down
    row DECELERATION   per s², while slowing down     row VELOCITY_STEP  per s, the jump at a corner

Whatever changes the dynamics (weights, groups, ramp times, slope types) makes a new set; the cycle knows nothing else
of them. A slope with ramp times is a jerk of acceleration / ramp time, one without any ramp a jerk of acceleration /
period of the cycle; both are finite.

A set is kept until the last record that was written while it was valid is free again. When all are in use the producer
waits, as with a full queue. Limits that come again (rapid moves and moves at feed take turns) are the set that they were,
if it is not too old: an old one is put anew, so that its place can become free.
"""

from __future__ import annotations

import mmap

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.axis_limits import AxisLimits

SETS = 128
AGAIN = 64  # sets that may become valid again
VELOCITY, ACCELERATION, DECELERATION, JERK, BRAKING_JERK, VELOCITY_STEP = 0, 1, 2, 3, 4, 5
ROWS = 6
_HEAD = 64  # bytes: number of sets ever put

Counters = npt.NDArray[np.int64]


def limits_bytes(max_axes: int) -> int:
    """The memory that the sets need."""
    return _HEAD + SETS * ROWS * max_axes * 8


class QueueLimits:
    """The ring in `buffer` from byte `offset` on, zero at first. `queue_counters`: written and read of the queue."""

    def __init__(
        self, buffer: mmap.mmap | bytearray, offset: int, max_axes: int, n_axes: int, queue_counters: Counters
    ) -> None:
        self.counters: Counters = np.frombuffer(buffer, dtype=np.int64, count=1, offset=offset)  # sets ever put
        self.sets: npt.NDArray[np.float64] = np.frombuffer(
            buffer, dtype=np.float64, count=SETS * ROWS * max_axes, offset=offset + _HEAD
        ).reshape(SETS, ROWS, max_axes)
        self._n = n_axes
        self._current: AxisLimits | None = None  # put last
        self._number = int(self.counters[0]) - 1
        self._queue = queue_counters
        self._until = np.full(
            SETS, self._queue[0]
        )  # written when a set was replaced: it is free when read has come there

    @property
    def room(self) -> bool:
        """Whether `put` will take another set now."""
        put = int(self.counters[0])
        return put < SETS or int(self._queue[1]) >= int(self._until[put % SETS])

    def room_for(self, count: int) -> bool:
        """Whether `put` will take so many other sets now."""
        if count == 1:
            return self.room
        put = int(self.counters[0])
        slots = np.arange(max(put, SETS), max(put + count, SETS)) % SETS
        return bool((self._until[slots] <= self._queue[1]).all())

    def put(self, limits: AxisLimits, records: int = 0) -> int:
        """The number of the set with these limits; it is valid from the next record on. Producer only, while `room`.

        `records`: how many are not written yet and may belong to the set before.
        """
        if limits is self._current:
            return self._number
        self._current = limits
        put = int(self.counters[0])
        rows = np.full((ROWS, self.sets.shape[2]), np.inf)
        rows[:, : self._n] = (
            limits.velocity, limits.acceleration, limits.deceleration,
            limits.jerk, limits.braking_jerk, limits.velocity_step,
        )  # fmt: skip
        if put > 0:
            self._until[self._number % SETS] = self._queue[0] + records
        number = next((k for k in range(put - 1, max(put - AGAIN, 0) - 1, -1) if self._is(k, rows)), put)
        if number == put:
            self.sets[put % SETS] = rows
            self.counters[0] = put + 1
        self._until[number % SETS] = np.iinfo(np.int64).max  # in use until it is replaced
        self._number = number
        return number

    def _is(self, number: int, rows: npt.NDArray[np.float64]) -> bool:
        return np.array_equal(self.sets[number % SETS], rows)
