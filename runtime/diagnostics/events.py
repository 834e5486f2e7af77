"""What happens in the cycle, told to whoever listens: a ring of fixed records, one writer and one reader.

The cycle may neither write files nor log. It puts an event into the ring; the service process (or the simulation) takes it
out and writes the journal, the trace and the counters. A full ring loses the newest event and counts the loss.
"""

from __future__ import annotations

import mmap
from dataclasses import dataclass
from enum import IntEnum, auto

import numpy as np

from runtime.diagnostics.memory import SharedMemory, open_shared

CAPACITY = 8192
TEXT_BYTES = 260


class EventKind(IntEnum):
    """Names of the events in traces and in the journal are these, in lower case."""

    BLOCK_START = auto()
    BLOCK_END = auto()
    M_OUT = auto()
    M_ACK = auto()
    H_OUT = auto()
    H_ACK = auto()
    S_OUT = auto()
    S_ACK = auto()
    T_OUT = auto()
    T_ACK = auto()
    MESSAGE = auto()  # of the NC program: number is the receiver (position in RECEIVERS), value 1 information
    ERROR = auto()
    MODE = auto()
    SPINDLE = auto()
    STOP = auto()  # the path stands and waits: number is the StopCondition mask
    GO = auto()
    DRIVE = auto()  # a drive changed its state: number is the axis index, value the state
    PLC = auto()  # the PLC process started (1) or was lost (0)
    RESET = auto()


RECEIVERS = ("ISG_DIAG_BED", "HMI", "PLC", "EVENT_LOGGER")  # of messages, as in runtime.cnc.blocks.Receiver


RECORD = np.dtype(
    [
        ("t", "f8"),
        ("path_pos", "f8"),
        ("value", "f8"),
        ("cycle", "i8"),
        ("kind", "i4"),
        ("line", "i4"),
        ("n", "i4"),  # -1: no block number
        ("number", "i4"),
        ("axis", "i4"),  # index, -1: none
        ("text", f"S{TEXT_BYTES}"),
    ],
    align=True,
)


@dataclass(frozen=True, slots=True)
class Event:
    """One event: `t` seconds and `cycle` since the start of the runtime, `path_pos` mm since program start."""

    t: float
    cycle: int
    kind: EventKind
    line: int = 0
    n: int | None = None
    number: int = 0
    value: float = 0.0
    path_pos: float = 0.0
    axis: int = -1
    text: str = ""


class EventRing:
    """The ring, in shared memory when `name` is given, else in this process only.

    `create` makes the memory (and removes a left-over of the same name); without it the ring of a running machine is opened.
    """

    def __init__(self, name: str | None = None, *, create: bool = True) -> None:
        self._memory: SharedMemory | None = None
        size = 64 + CAPACITY * RECORD.itemsize
        if name is None:
            buffer: mmap.mmap | bytearray = bytearray(size)
        else:
            self._memory = open_shared(name, size if create else None)
            buffer = self._memory.buf
        self._counters = np.frombuffer(buffer, dtype=np.uint64, count=8)  # written, read, lost
        self._records = np.frombuffer(buffer, dtype=RECORD, count=CAPACITY, offset=64)

    @property
    def lost(self) -> int:
        """Events that found the ring full."""
        return int(self._counters[2])

    def put(self, event: Event) -> None:
        """Called by the cycle only. Bounded; never waits."""
        written = int(self._counters[0])
        if written - int(self._counters[1]) >= CAPACITY:
            self._counters[2] += np.uint64(1)
            return
        self._records[written % CAPACITY] = (
            event.t,
            event.path_pos,
            event.value,
            event.cycle,
            event.kind,
            event.line,
            -1 if event.n is None else event.n,
            event.number,
            event.axis,
            event.text.encode("utf-8", "replace")[:TEXT_BYTES],
        )
        self._counters[0] = np.uint64(written + 1)

    def take(self) -> list[Event]:
        """All events that have come since the last call; called by the one reader."""
        events: list[Event] = []
        read, written = int(self._counters[1]), int(self._counters[0])
        if read == written:
            return events
        for index in range(read, written):
            r = self._records[index % CAPACITY]
            events.append(
                Event(
                    t=float(r["t"]),
                    cycle=int(r["cycle"]),
                    kind=EventKind(int(r["kind"])),
                    line=int(r["line"]),
                    n=None if r["n"] < 0 else int(r["n"]),
                    number=int(r["number"]),
                    value=float(r["value"]),
                    path_pos=float(r["path_pos"]),
                    axis=int(r["axis"]),
                    text=bytes(r["text"]).decode("utf-8", "replace"),
                )
            )
        self._counters[1] = np.uint64(written)
        return events

    def close(self, *, unlink: bool = False) -> None:
        """Let go of the memory; `unlink` also removes it (its creator does)."""
        if self._memory is None:
            return
        memory, self._memory = self._memory, None
        del self._counters, self._records
        if unlink:
            memory.remove()
        else:
            memory.close()
