"""The technology functions of a channel in the cycle: put out, acknowledged, and the gates that wait for them.

    path passes a function ─▶ take ─▶ port of the channel or of an axis ─▶ PLC
                                │                                           │
                                └─▶ spindle ─▶ speed reached ──────┐        │ done
                                                                   ▼        ▼
    gate of the path ◀── passable ◀───────────────────────────── waiting list

A port takes one block's functions at a time and has only so many units. What finds no room waits here in its order, and the
channel keeps the path still until there is room: a slow PLC loses nothing.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.spindle import DEGREES_PER_SECOND, Spindle
from runtime.cnc.blocks import Synch, Technology
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.queue_record import QueueRecord, read_record
from runtime.diagnostics.events import EventKind
from runtime.hli.technology import Function, Sent, TechnologyPort
from runtime.hli.units import INT32

Floats = npt.NDArray[np.float64]

_OUT = {
    Technology.M: EventKind.M_OUT,
    Technology.H: EventKind.H_OUT,
    Technology.S: EventKind.S_OUT,
    Technology.T: EventKind.T_OUT,
}
_ACK = {
    Technology.M: EventKind.M_ACK,
    Technology.H: EventKind.H_ACK,
    Technology.S: EventKind.S_ACK,
    Technology.T: EventKind.T_ACK,
}
_WAITING = int(Synch.MVS_SVS | Synch.MVS_SNS | Synch.MNS_SNS)
_MVS_SVS = int(Synch.MVS_SVS)


class Tell(Protocol):
    """Puts an event into the ring of the channel."""

    def __call__(
        self, kind: EventKind, line: int, n: int | None, number: int = 0, value: float = 0.0, axis: int = -1
    ) -> None: ...


@dataclass(slots=True)
class _Waiting:
    """A function that was put out and not yet acknowledged."""

    kind: Technology
    number: int
    line: int
    n: int | None
    spindle: Spindle | None  # waits for its speed
    sent: Sent | None  # waits for the PLC
    synch: int


class TechnologyFunctions:
    """Bounded work in every cycle: the queue holds at most as many functions as records."""

    def __init__(
        self,
        queue: MotionQueue,
        port: TechnologyPort,
        spindles: Sequence[Spindle],
        spindle_ports: Sequence[TechnologyPort],
        tell: Tell,
    ) -> None:
        self._queue = queue
        self._port = port
        self._spindles = spindles
        self._spindle_ports = spindle_ports
        self._ports = (port, *spindle_ports)
        self._tell = tell
        self._waiting: list[_Waiting] = []
        self._overflow: deque[QueueRecord] = deque()  # functions for which the port had no room

    # ------------------------------------------------------------------ the cycle

    def acknowledge(self, speeds: Floats) -> None:
        """Take from the waiting list what the PLC has done and what the spindles have reached (`speeds`, degrees/s)."""
        for port in self._ports:
            port.poll()
        if not self._waiting:
            return
        left: list[_Waiting] = []
        for waiting in self._waiting:
            spindle = waiting.spindle
            told = waiting.sent is None or waiting.sent.done
            if told and (spindle is None or spindle.reached(speeds[spindle.index])):
                self._tell(_ACK[waiting.kind], waiting.line, waiting.n, waiting.number)
            else:
                left.append(waiting)
        self._waiting = left

    def take(self, index: int) -> None:
        """The path has come to a function, the record `index` of the queue."""
        record = read_record(self._queue, index)
        if self._overflow or not self._put_out(record):
            self._overflow.append(record)

    def put_out_late(self) -> None:
        """Put out what found no room before, in its order."""
        while self._overflow and self._put_out(self._overflow[0]):
            self._overflow.popleft()

    def drop(self) -> None:
        """Forget everything; the PLC is asked to do so too."""
        self._waiting.clear()
        self._overflow.clear()
        for port in self._ports:
            port.drop_all()

    # ------------------------------------------------------------------ what the path waits for

    @property
    def full(self) -> bool:
        """Functions found no room: nothing may pass them."""
        return bool(self._overflow)

    @property
    def waiting(self) -> int:
        """Functions that are out, or due, and not yet acknowledged."""
        return len(self._waiting) + len(self._overflow)

    @property
    def pending(self) -> bool:
        """Something is not acknowledged, or not even taken."""
        return bool(self._waiting or self._overflow) or any(port.pending for port in self._ports)

    def passable(self, gate: QueueRecord) -> bool:
        """Nothing that the gate waits for is missing, of the functions that the path has passed."""
        return not self._overflow and next(self._missing(gate), None) is None

    def plc_owes(self, gate: QueueRecord) -> bool:
        """The PLC has not done something that the gate waits for; else it is only a spindle that is not there yet."""
        return bool(self._overflow) or any(
            waiting.sent is not None and not waiting.sent.done for waiting in self._missing(gate)
        )

    def _missing(self, gate: QueueRecord) -> Iterator[_Waiting]:
        return (waiting for waiting in self._waiting if not gate.synch or waiting.synch & _MVS_SVS)

    # ------------------------------------------------------------------ putting out

    def _put_out(self, record: QueueRecord) -> bool:
        """Hand a function to the PLC and to the spindle it concerns; FALSE if there is no free unit."""
        kind, waits = record.technology, bool(int(record.synch) & _WAITING)
        spindle = self._spindles[record.spindle] if record.spindle >= 0 else None
        sent: Sent | None = None
        if spindle is None or record.synch & Synch.PLC_INFO:
            port = self._port if spindle is None else self._spindle_ports[record.spindle]
            sent = port.put(_to_interface(record, spindle))
            if sent is None:
                return False
        if spindle is not None:
            spindle.command(record.number, record.value)
            self._tell(EventKind.SPINDLE, record.line, record.n, record.number, record.value, axis=spindle.index)
        self._tell(_OUT[kind], record.line, record.n, record.number, record.value)
        if waits:
            self._waiting.append(_Waiting(kind, record.number, record.line, record.n, spindle, sent, int(record.synch)))
        return True


def _to_interface(record: QueueRecord, spindle: Spindle | None) -> Function:
    """A function in the interface's whole numbers; the value of S is a speed, that of M and H goes over as it is."""
    if spindle is None:
        value, revolutions = round(record.value), 0
    else:
        value, revolutions = 0, min(round(record.value * DEGREES_PER_SECOND * 1e3), INT32)
    return Function(
        kind=int(record.technology),
        number=record.number,
        value=max(-INT32, min(value, INT32)),
        synch=int(record.synch),
        line=record.line,
        block_number=-1 if record.n is None else record.n,
        revolutions=revolutions,
    )
