"""The running machine as the decoder sees it at decoding time: HLI, clock, and the cycle at the other end of the link.

Messages and warnings go through the link, because the cycle alone writes events and the HLI. What finds no room there waits
here; meanwhile the preparation asks the decoder for nothing more.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Sequence
from datetime import datetime
from typing import Protocol

import numpy as np

from runtime.cnc.blocks import Floats, Message, Receiver, TimerCommand, UserError
from runtime.cnc.decoder_reports import Report, ReportKind
from runtime.cnc.preparation_link import PreparationLink
from runtime.config.error_texts import ErrorTexts
from runtime.config.machine import Machine
from runtime.diagnostics.errors import Problem
from runtime.hli.external import external_area
from runtime.hli.layout import Hli
from runtime.hli.timers import Timers
from runtime.hli.tools import Identity, RequestKind, ToolAnswered, ToolRequests
from runtime.hli.units import LENGTH

_RECEIVERS = tuple(Receiver)


class Search(Protocol):
    """A block search, as far as the decoder has to know of it."""

    @property
    def searching(self) -> bool:
        """What the program does is left out now."""

    @property
    def place(self) -> Floats:
        """Where the program has come to without the axes, (n_axes,)."""


class RunningMachine:
    """`Outside` of one channel. `now` is the wall clock; a simulation gives its own."""

    def __init__(self, machine: Machine, hli: Hli, link: PreparationLink, now: Callable[[], datetime]) -> None:
        self.error_texts = ErrorTexts.of(machine)
        self.now = now
        self._link = link
        self._head = hli.head
        self._skip_unit = hli.channels[0].control.program_block_ignore
        self._axes = [hli.axes[machine.axis_index(name)] for name in machine.channels[0].axes]
        self._jobs = [hli.axes[i].job for i in range(len(machine.axes))]
        self._timers = Timers(hli)
        self._tools = ToolRequests(hli.channels[0])
        self._external = external_area(hli)
        self._backlog: deque[Report] = deque()
        self._number = link.told.last  # of the report told last; goes on when the preparation starts anew
        self.search: Search | None = None  # of the program that runs
        self._for_plc: deque[int] = deque(maxlen=1024)  # numbers of messages that the PLC takes, oldest first

    @property
    def external(self) -> memoryview:
        return self._external

    def command_position(self) -> Floats | None:
        return self._left_out if self.searching() else self._link.command_position

    def actual_position(self) -> Floats | None:
        return self._left_out if self.searching() else self._link.actual_position

    def manual_offsets(self) -> Floats | None:
        return np.zeros(len(self._axes)) if self.searching() else self._link.manual_offsets

    def searching(self) -> bool:
        return self.search is not None and self.search.searching

    @property
    def _left_out(self) -> Floats:
        """Where the axes would be if they had driven what a block search leaves out."""
        assert self.search is not None
        return self.search.place.copy()

    def referenced(self, axis: int) -> bool:
        return bool(self._axes[axis].status.referenced_r)

    def parked(self, axis: int) -> bool:
        return bool(self._axes[axis].control.parked.state_r)

    def skip_levels(self, at_start: int) -> int:
        """Switched-on levels as bits: the plain slash as at the start of the program, the others as they are now."""
        return at_start & 1 | int(self._skip_unit.state_r) & ~1

    def cycle(self) -> int:
        return int(self._head.cycle_r)

    def operating_mode(self) -> int:
        return self._link.read_start().mode

    def changes_files(self) -> bool:
        return True

    def waits_in_vain(self) -> bool:
        return False

    # ------------------------------------------------------------------ messages and warnings

    def tell(self, message: Message) -> int:
        if self.searching():
            return self._number
        number = self._put(
            Report(
                ReportKind.MESSAGE,
                message.text,
                message.source.program,
                message.source.line,
                message.source.n,
                _RECEIVERS.index(message.receiver),
                message.information,
            )
        )
        if message.receiver is Receiver.PLC:
            self._for_plc.append(number)
        return number

    def error(self, error: UserError) -> None:
        source = error.source
        text = self.error_texts.describe(error)
        self._put(Report(ReportKind.WARNING, text, source.program, source.line, source.n))

    def warn(self, problem: Problem) -> None:
        """Tell a warning of the decoder, or of a stage behind it, where the errors of the machine are told."""
        place = problem.place
        self._put(Report(ReportKind.NOTICED, problem.text, place.file, place.line, None, problem.entry.id))

    def _put(self, report: Report) -> int:
        self._number += 1
        self._backlog.append(report)
        self.hand_over()
        return self._number

    def hand_over(self) -> bool:
        """Pass on what waits here, as far as there is room; TRUE if some of it still waits."""
        self._tools.hand_over()
        told = self._link.told
        while self._backlog and told.free:
            told.put(self._backlog.popleft())
        return bool(self._backlog)

    def room(self) -> bool:
        return not self._backlog and self._link.told.free > 0

    def taken(self, number: int) -> bool:
        if number in self._for_plc:
            return self._link.told.was_taken(number)
        return self._link.told.was_told(number)

    def forget(self) -> None:
        """A program starts or is aborted: what was not handed over is not told any more."""
        self._number -= len(self._backlog)
        self._backlog.clear()
        self._tools.forget()
        self.search = None

    # ------------------------------------------------------------------ external tool management

    def has_tool_management(self) -> bool:
        return self._tools.present

    def ask_tool(self, kind: RequestKind, tool: Identity, parameters: Sequence[float] = ()) -> int:
        return self._tools.ask(kind, tool, parameters)

    def tool_answered(self, request: int) -> ToolAnswered | None:
        return self._tools.answered(request)

    # ------------------------------------------------------------------ timers

    def timer(self, command: TimerCommand, timer: int) -> int:
        return self._timers.act(command.value, timer)

    def probed(self, axis: int) -> float | None:
        unit = self._jobs[axis]
        return unit.probe_position_r * LENGTH if unit.probe_recorded_r else None

    def measured(self) -> dict[int, float] | None:
        return self._link.measured

    def latched(self, timer: int) -> int:
        return self._timers.latched(timer)
