"""Messages of the NC program on their way to the PLC: one at a time, the next one when the PLC has taken the last.

    CNC                                    unit                       PLC
    put: text, typ, sequence, flag := 1    ─────▶  message waits
                                                   taken        ◀──── reads, flag := 0
    poll: taken; the next one goes out     ◀─────

What was not taken at a reset is withdrawn. The PLC's own messages, for whoever operates the channel, go back the same way: it
fills `command_w` and raises the flag, the CNC tells them and lowers it.
"""

from __future__ import annotations

from collections import deque
from typing import NamedTuple

from runtime.hli.layout import Channel
from runtime.hli.memory import get_text, put_text

MESSAGE, INFORMATION = 1, 2  # typ
LIMIT = 10  # messages that may wait for the PLC before the path stops (programming manual line 13365)


class Waiting(NamedTuple):
    """A message that the PLC has not taken yet; `number` above 0 counts those of decoding time, 0 is one of the path."""

    text: str
    information: bool
    number: int


class MessagePort:
    """The CNC's side for one channel. Whoever puts messages keeps to `LIMIT`, so that no more than some ten wait."""

    def __init__(self, channel: Channel) -> None:
        self._channel = channel
        self._unit = channel.msg_mc_control
        self._request = channel.msg_mc_control.request_r
        self._waiting: deque[Waiting] = deque()  # the first one is out
        self._out = False
        self._sequence = 0

    @property
    def waiting(self) -> int:
        """Messages that are not taken."""
        return len(self._waiting)

    @property
    def waiting_of_path(self) -> int:
        """Those of them that were put out on the path."""
        return sum(message.number == 0 for message in self._waiting)

    def put(self, message: Waiting) -> None:
        """Hand a message over; it goes out in the next `poll`, when those before it have been taken."""
        self._waiting.append(message)

    def poll(self) -> int:
        """Once per cycle; the number of the last message of decoding time that was taken, 0 if there was none.

        Where no PLC is logged on, every message is taken at once.
        """
        if not self._waiting:
            return 0
        last = 0
        present, unit = bool(self._channel.plc_present_w), self._unit
        while self._waiting:
            if self._out:
                if present and unit.request_semaphor_rw:
                    return last
                last = self._waiting.popleft().number or last
                self._out = False
                unit.request_semaphor_rw = False
            elif present:
                self._send(self._waiting[0])
            else:
                self._out = True  # nobody is there to take it: as if it had been
        return last

    def received(self) -> tuple[str, bool] | None:
        """Once per cycle: a message of the PLC, and whether it is information for programs."""
        unit = self._unit
        if not unit.command_semaphor_rw:
            return None
        message = get_text(unit.command_w, "contents"), unit.command_w.typ == INFORMATION
        unit.command_semaphor_rw = False
        return message

    def _send(self, message: Waiting) -> None:
        self._sequence = (self._sequence + 1) & 0xFFFFFFFF
        self._unit.sequence_r = self._sequence
        put_text(self._request, "contents", message.text)
        self._request.typ = INFORMATION if message.information else MESSAGE
        self._unit.request_semaphor_rw = True
        self._out = True

    def drop_all(self) -> None:
        """Reset: withdraw what was not taken."""
        self._waiting.clear()
        self._out = False
        self._unit.request_semaphor_rw = False


class Offered(NamedTuple):
    """A message as the PLC finds it."""

    text: str
    information: bool
    sequence: int


class MessageTaker:
    """The PLC's side of one channel."""

    def __init__(self, channel: Channel) -> None:
        self._unit = channel.msg_mc_control

    def offered(self) -> Offered | None:
        """The message that waits."""
        unit = self._unit
        if not unit.request_semaphor_rw:
            return None
        sequence = int(unit.sequence_r)
        message = Offered(get_text(unit.request_r, "contents"), unit.request_r.typ == INFORMATION, sequence)
        return message if unit.request_semaphor_rw and unit.sequence_r == sequence else None

    def send(self, text: str, *, information: bool) -> bool:
        """Tell the operator something; FALSE while the CNC has not taken the message before."""
        unit = self._unit
        if unit.command_semaphor_rw:
            return False
        put_text(unit.command_w, "contents", text)
        unit.command_w.typ = INFORMATION if information else MESSAGE
        unit.command_semaphor_rw = True
        return True

    def take(self, message: Offered) -> None:
        """Acknowledge; without effect on another message than the one that was read."""
        if self._unit.sequence_r == message.sequence:
            self._unit.request_semaphor_rw = False
