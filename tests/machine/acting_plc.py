"""A PLC that does what the test wants at the moment: acknowledges, waits, refuses, claims units, hangs and comes back."""

from __future__ import annotations

import ctypes
from enum import Enum

from runtime.diagnostics.catalogue import plc
from runtime.hli.layout import BoolUnit, ModeState, Uns32Unit
from runtime.hli.memory import HliMemory, put_text
from runtime.hli.technology import Taken, TechnologyTaker

LATE = 10  # PLC cycles


class Manner(Enum):
    """What becomes of a function that was taken."""

    AT_ONCE = 0
    LATE = 1
    NEVER = 2
    REFUSED = 3  # an alarm of the PLC, and no acknowledgement


class ActingPlc:
    """Takes everything in its cycle; `manner` tells how it answers what it takes from then on."""

    def __init__(self, memory: HliMemory) -> None:
        self.hli = memory.hli
        self.channel = self.hli.channels[0]
        self.manner = Manner.AT_ONCE
        self.frozen = False
        self.forwards = True  # what the operator asks of a mode unit that the PLC has claimed
        self.taken: list[tuple[int, int]] = []  # kind and number of all that came
        self.owed: list[Taken] = []  # what has come and is not acknowledged
        self._takers: list[TechnologyTaker] = []
        self._due: list[tuple[Taken, int]] = []
        self._cycle = 0
        self._alarms = 0
        self._refused = 0

    # ------------------------------------------------------------------ the cycle

    def wake(self, time: float) -> None:
        if self.frozen:
            return
        if not self._takers:
            self._log_on()
        hli = self.hli
        self._cycle += 1
        self.channel.watchdog.alive_rw = True
        hli.platform.plc_cycle_done_w = hli.platform.plc_cycle_request_r
        self._take()
        self._answer()
        self._forward()

    def restart(self) -> None:
        """The program is started anew: what the one before had claimed is given back, and the rest is not known to it."""
        self.frozen = False
        self._takers = []

    def _log_on(self) -> None:
        areas = [self.channel, *(self.hli.axes[i] for i in range(self.hli.head.axes_r))]
        self.give_back()
        unit = self.channel.control.mode_and_state
        unit.request_semaphor_rw = unit.command_semaphor_rw = False
        self._due, self.owed = [], []
        self._takers = [TechnologyTaker(area, self._due.clear) for area in areas]
        for area in areas:
            area.plc_present_w = True
        watchdog = self.channel.watchdog
        watchdog.cycle_time_w, watchdog.enable_w = 50_000, True

    def _take(self) -> None:
        for taker in self._takers:
            for taken in taker.take():
                self.taken.append((taken.function.kind, taken.function.number))
                self.owed.append(taken)
                if self.manner is Manner.REFUSED:
                    self._refused += 1
                elif self.manner is not Manner.NEVER:
                    self._due.append((taken, self._cycle + (LATE if self.manner is Manner.LATE else 0)))

    def _answer(self) -> None:
        for taken, _ in [entry for entry in self._due if entry[1] <= self._cycle]:
            taken.done()
        self._due = [entry for entry in self._due if entry[1] > self._cycle]
        self.owed = [taken for taken in self.owed if not taken.is_done]
        report = self.hli.platform.lc_error
        if self._refused and not report.semaphor_rw:
            self._refused -= 1
            self._alarms += 1
            report.id_w, report.number_w, report.active_w = plc.PLC_HANDLER_RESULT.id, self._alarms, True
            put_text(report, "text_w", "the function is refused")
            report.semaphor_rw = True

    def _forward(self) -> None:
        unit = self.channel.control.mode_and_state
        if unit.enable_w and unit.request_semaphor_rw and not unit.command_semaphor_rw and self.forwards:
            ctypes.memmove(ctypes.addressof(unit.command_w), ctypes.addressof(unit.request_r), ctypes.sizeof(ModeState))
            unit.request_semaphor_rw = False
            unit.command_semaphor_rw = True

    # ------------------------------------------------------------------ units

    def claim(self, name: str, value: int) -> None:
        """Command a unit of the channel."""
        unit: BoolUnit | Uns32Unit = getattr(self.channel.control, name)
        unit.command_w = value
        unit.enable_w = True

    def give_back(self) -> None:
        """The operator has every unit again."""
        control = self.channel.control
        for name, of, *_ in control._fields_:
            if hasattr(of, "enable_w"):
                unit = getattr(control, name)
                unit.enable_w = False
                if isinstance(unit.command_w, (bool, int)):
                    unit.command_w = 0
