"""Errors of the CNC on their way to the PLC: one at a time, the next one when the PLC has taken the last.

    CNC                                unit `mc_error`                PLC
    tell: record, sequence, flag := 1   ─────▶  error waits
                                                taken           ◀──── copies, flag := 0

What nobody takes costs nothing: a PLC that is not logged on gets none, and of those that wait the first ones are kept, as the
cause comes before what follows from it; how many were left out is counted. The alarm history has them all.
"""

from __future__ import annotations

from collections import deque
from enum import IntEnum
from typing import Final, NamedTuple

from runtime.hli.layout import Channel
from runtime.hli.memory import get_text, put_text

WAITING: Final = 32  # errors that may wait for the PLC


class Body(IntEnum):
    """Where an error comes from (`body_type_r`)."""

    NC_PROGRAM = 1  # program and line say where
    NONE = 9


class ErrorMessage(NamedTuple):
    """One error. `axis`: logical number, 0 none; `program` and `line`: where it stands in the NC program, "" and 0 nowhere.

    `reaction` and `severity` are those of the error catalogue; `time_ns` since 1970.
    """

    id: int
    text: str
    severity: int
    reaction: int
    axis: int = 0
    program: str = ""
    line: int = 0
    time_ns: int = 0
    cycle: int = 0


class ErrorPort:
    """The CNC's side for one channel."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._unit = channel.mc_error
        self._waiting: deque[ErrorMessage] = deque()
        self._sequence = 0

    def put(self, message: ErrorMessage) -> None:
        """Hand an error over; it goes out in the next `poll`, when those before it have been taken."""
        if len(self._waiting) < WAITING:
            self._waiting.append(message)
        else:
            self._unit.left_out_r += 1

    def poll(self) -> None:
        """Once per cycle."""
        if not self._waiting:
            return
        if not self._channel.plc_present_w:
            self._waiting.clear()
            return
        if not self._unit.semaphor_rw:
            self._send(self._waiting.popleft())

    def _send(self, message: ErrorMessage) -> None:
        record = self._unit.message_r
        record.time_ns_r, record.cycle_r = message.time_ns, message.cycle
        record.error_id_r, record.severity_r, record.reaction_r = message.id, message.severity, message.reaction
        record.axis_r, record.line_r = message.axis, message.line
        record.body_type_r = Body.NC_PROGRAM if message.program or message.line else Body.NONE
        record.channel_r = self._channel.number_r
        put_text(record, "program_r", message.program)
        put_text(record, "text_r", message.text)
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF
        self._unit.sequence_r = self._sequence
        self._unit.semaphor_rw = True


class ErrorTaker:
    """The PLC's side of one channel."""

    def __init__(self, channel: Channel) -> None:
        self._unit = channel.mc_error

    def take(self) -> ErrorMessage | None:
        """The error that waits, and the next one may come; None if there is none."""
        unit = self._unit
        if not unit.semaphor_rw:
            return None
        record = unit.message_r
        message = ErrorMessage(
            int(record.error_id_r),
            get_text(record, "text_r"),
            int(record.severity_r),
            int(record.reaction_r),
            int(record.axis_r),
            get_text(record, "program_r"),
            int(record.line_r),
            int(record.time_ns_r),
            int(record.cycle_r),
        )
        unit.semaphor_rw = False
        return message
