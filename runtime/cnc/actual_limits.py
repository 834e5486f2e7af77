"""Software limits of actual positions: those that POS_LIMIT leaves to the cycle (programming manual line 31008).

Nothing is looked at while no program has asked for it. An axis that has left its range is told once, until it is back in it.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from runtime.cnc.queue_record import QueueRecord
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.errors import Problem

Floats = npt.NDArray[np.float64]


class ActualLimits:
    """Of one channel; `names` of its axes."""

    def __init__(self, names: Sequence[str]) -> None:
        self._names = list(names)
        self._limits: dict[int, tuple[float, float, bool]] = {}  # axis -> low, high, whether the path stops
        self._beyond: set[int] = set()

    def begin(self) -> None:
        """A program starts: nothing is watched."""
        self._limits.clear()
        self._beyond.clear()

    def act(self, record: QueueRecord) -> None:
        """The path has come to a change of limits."""
        self._limits.pop(record.number, None)
        self._beyond.discard(record.number)
        if np.isfinite(record.value) or np.isfinite(record.seconds):
            self._limits[record.number] = (record.value, record.seconds, bool(record.offset))

    def step(self, actual: Floats, axes: npt.NDArray[np.int64]) -> Problem | None:
        """One cycle; `actual` of all axes of the machine, `axes` (n_axes,) which of them are those of the channel."""
        for axis, (low, high, stops) in self._limits.items():
            place = float(actual[axes[axis]])
            if low <= place <= high:
                self._beyond.discard(axis)
            elif axis not in self._beyond:
                self._beyond.add(axis)
                limit = low if place < low else high
                entry = errors.LIMIT_REACHED if stops else errors.LIMIT_PASSED
                return Problem(entry, {"axis": self._names[axis], "position": place, "limit": limit})
        return None
