"""A section of #OPTIONAL EXECUTION that is left out: its records lose their effect while the path stands before it."""

from __future__ import annotations

import numpy as np

from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import ActionKind, GateReason, RecordKind
from runtime.cnc.queue_record import QueueRecord
from runtime.diagnostics.catalogue import machine
from runtime.diagnostics.errors import Place, Problem

_ACTION, _GATE = int(RecordKind.ACTION), int(RecordKind.GATE)
_OFF, _NOTHING = int(ActionKind.OPTIONAL_OFF), int(ActionKind.NOTHING)
_FLUSH_WAIT, _MANUAL = int(GateReason.FLUSH_WAIT), int(GateReason.MANUAL)


class SkippedSection:
    """Of one channel. `leave_out` in every cycle at the gate in front of the section, until it is `gone`."""

    def __init__(self, path: Interpolator) -> None:
        self._path = path
        self.gone = False

    def leave_out(self, gate: QueueRecord, place: Place, running: bool) -> Problem | None:
        """Make the section one without effect, when its end is known; a problem where it never will be.

        `running`: the preparation goes on writing.
        """
        queue, begin = self._path.queue, self._path.gate + 1
        self.gone = False
        slots = np.arange(begin, queue.written) % queue.capacity
        records = queue.records[slots]
        ends = np.flatnonzero((records["kind"] == _ACTION) & (records["action"] == _OFF))
        inside = records[: int(ends[0])] if len(ends) else records
        waits = (inside["kind"] == _GATE) & ((inside["reason"] == _FLUSH_WAIT) | (inside["reason"] >= _MANUAL))
        if waits.any():
            line = int(inside["line"][np.argmax(waits)])
            return Problem(machine.SECTION_WAITS, {"why": f"line {line} waits for the machine"}, place)
        if not len(ends):
            if queue.free == 0 or not running:
                return Problem(machine.SECTION_WAITS, {"why": "its end is not known"}, place)
            return None
        slots = slots[: int(ends[0])]
        texts = queue.records["text"][slots]
        queue.records["kind"][slots] = _ACTION
        queue.records["action"][slots] = _NOTHING
        queue.records["block_end"][slots] = 0
        if len(texts) and int(texts.max()) >= 0:
            queue.texts.take(int(texts.max()))
        self.gone = True
        return None
