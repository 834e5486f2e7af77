"""#DIST TO GO: what every axis has still to go to the end of the section in which the path is (programming manual line 18435)."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import ActionKind, RecordKind
from runtime.hli.layout import ChannelStatus
from runtime.hli.units import LENGTH

Floats = npt.NDArray[np.float64]

SEARCH = 1024  # records looked at in one cycle
_ACTION, _END = int(RecordKind.ACTION), int(ActionKind.DISTANCE_END)


class DistanceDisplay:
    """Of one channel. The way of the section comes with its end, so nothing is shown until that stands in the queue."""

    def __init__(self, path: Interpolator, status: ChannelStatus) -> None:
        self._path = path
        self._shown = status.dist_to_geom_end_r
        self._active = False
        self._whole: Floats | None = None  # what the axes travel in the section
        self._travelled = np.zeros(path.queue.n_axes)
        self._before = np.zeros(path.queue.n_axes)
        self._scanned = 0
        self.late = False  # the end was not known when the queue was full; told once per section

    def begin(self, index: int) -> None:
        """The path has passed the begin of a section, the record `index`."""
        self._active, self._whole, self.late = True, None, False
        self._travelled[:] = 0.0
        self._before[:] = self._path.position
        self._scanned = index + 1

    def end(self) -> None:
        """The section is over, or the program is."""
        if self._active:
            self._active = False
            self._shown[:] = [0] * len(self._shown)

    @property
    def active(self) -> bool:
        return self._active

    def step(self, *, backward: bool, replaying: bool) -> bool:
        """Once per cycle behind the interpolator; TRUE once if the queue is too short for the section."""
        if not self._active:
            return False
        path = self._path
        way = np.abs(path.position - self._before)
        self._before[:] = path.position
        self._travelled += -way if backward else way
        if self._whole is None and not replaying and not self._look():
            late = path.queue.free == 0 and not self.late
            self.late |= late
            return late
        if self._whole is not None:
            for k, left in enumerate((self._whole - self._travelled).tolist()):
                self._shown[k] = round(max(left, 0.0) / LENGTH)
        return False

    def _look(self) -> bool:
        """Whether the end of the section is known now."""
        queue = self._path.queue
        last = min(queue.written, self._scanned + SEARCH)
        if last <= self._scanned:
            return False
        records = queue.records[np.arange(self._scanned, last) % queue.capacity]
        found = np.flatnonzero((records["kind"] == _ACTION) & (records["action"] == _END))
        self._scanned = last
        if not len(found):
            return False
        self._whole = records["end"][int(found[0]), : queue.n_axes].copy()
        return True
