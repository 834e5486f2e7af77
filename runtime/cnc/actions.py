"""What the cycle does at a place of the path besides moving: messages, timers, external variables, tool life, warnings.

Everything here is bounded: of the messages for the PLC no more wait than the gates of the path let pass, and of those told at
decoding time no more are taken over than may wait.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import NamedTuple

from runtime.cnc.blocks import Receiver, TimerCommand
from runtime.cnc.decoder_reports import ReportKind
from runtime.cnc.motion_queue import ActionKind, MotionQueue
from runtime.cnc.preparation_link import PreparationLink
from runtime.cnc.queue_record import QueueRecord
from runtime.cnc.tools.life import ToolLifeRecorder
from runtime.hli.external import KINDS, external_area, write_external
from runtime.hli.layout import Channel, Hli
from runtime.hli.messages import LIMIT, MessagePort, Waiting
from runtime.hli.timers import Timers

_RECEIVERS = tuple(Receiver)
_COMMANDS = tuple(TimerCommand)
_PLC = _RECEIVERS.index(Receiver.PLC)
_OPERATOR = _RECEIVERS.index(Receiver.HMI)


class Told(NamedTuple):
    """A message that was put out: for the trace and the journal."""

    text: str
    line: int
    n: int | None
    receiver: int  # position in `Receiver`
    information: bool


class Warned(NamedTuple):
    """A warning of the program, or (with the number of its entry in the catalogue) one about it."""

    text: str
    program: str
    line: int
    number: int = 0


class Actions:
    """Of one channel. `on_message` and `on_warning` are called in the cycle for each of them."""

    def __init__(
        self,
        queue: MotionQueue,
        link: PreparationLink,
        hli: Hli,
        channel: Channel,
        on_message: Callable[[Told], None],
        on_warning: Callable[[Warned], None],
    ) -> None:
        self._queue = queue
        self._told = link.told
        self._port = MessagePort(channel)
        self._timers = Timers(hli)
        self._external = external_area(hli)
        self._on_message = on_message
        self._on_warning = on_warning
        self.life = ToolLifeRecorder(channel)
        self._put_out = 0  # messages for the PLC on the path since the start of the program

    # ------------------------------------------------------------------ the cycle

    def step(self) -> None:
        """Once per cycle: take over what decoder and PLC tell, hand messages to the PLC and look what it has taken."""
        while self._told.waiting and self._port.waiting < LIMIT:
            number, report = self._told.take()
            if report.kind is not ReportKind.MESSAGE:
                number = report.receiver if report.kind is ReportKind.NOTICED else 0
                self._on_warning(Warned(report.text, report.program, report.line, number))
                continue
            if report.receiver == _PLC:
                self._port.put(Waiting(report.text, report.information, number))
            self._on_message(Told(report.text, report.line, report.n, report.receiver, report.information))
        received = self._port.received()
        if received is not None:
            self._on_message(Told(received[0], 0, None, _OPERATOR, received[1]))
        self.life.step()
        taken = self._port.poll()
        if taken:
            self._told.confirm(taken)

    def carry_out(self, record: QueueRecord, place: float) -> None:
        """The path has come to an action, at `place` (mm)."""
        text = self._queue.texts.take(record.text)
        if record.action is ActionKind.MESSAGE:
            if record.number:
                self._put_out += 1
                self._port.put(Waiting(text, record.value != 0.0, 0))
            self._on_message(Told(text, record.line, record.n, record.size, record.value != 0.0))
        elif record.action is ActionKind.TIMER:
            command = _COMMANDS[int(record.value)]
            if command is TimerCommand.READ:
                self._timers.latch(record.number)
            else:
                self._timers.act(command.value, record.number)
        elif record.action is ActionKind.TOOL_LIFE:
            self.life.carry_out(record, place)
        elif record.action is ActionKind.EXTERNAL:
            value = record.value if record.text < 0 else text
            write_external(self._external, record.offset, KINDS[record.number], record.size, value)
        else:
            self._on_warning(Warned(text, self._queue.program_name(record.program), record.line))

    # ------------------------------------------------------------------ gates

    @property
    def full(self) -> bool:
        """As many messages wait for the PLC as may: the path stops."""
        return self._port.waiting >= LIMIT

    @property
    def all_taken(self) -> bool:
        """Every message so far, of the path and of decoding time, has been taken."""
        return not self._port.waiting and not self._told.waiting

    def passable(self, record: QueueRecord, *, here: bool) -> bool:
        """The gate of a message opens; `here`: the path stands at it, and everything before it has been carried out."""
        if record.value:  # SYN_ACK
            return here and not self._port.waiting_of_path
        return self._port.waiting + record.number - self._put_out < LIMIT

    # ------------------------------------------------------------------ programs

    def begin(self) -> None:
        """A program starts: its messages count anew; what waits of the one before still waits."""
        self._put_out = 0
        self.life.begin()

    def drop(self) -> None:
        """Reset: withdraw the messages that nobody took."""
        self._port.drop_all()
