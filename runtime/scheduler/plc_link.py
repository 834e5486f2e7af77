"""How the cycle wakes the PLC and how it sees that the PLC is no longer well."""

from __future__ import annotations

import contextlib
import os
from collections.abc import Callable
from typing import Protocol

from runtime.diagnostics.catalogue import CATALOGUE, plc
from runtime.diagnostics.errors import ErrorEntry, Place, Problem, Reaction
from runtime.hli.alarms import take_report
from runtime.hli.layout import ALARMS, Hli
from runtime.hli.memory import get_text
from runtime.hli.watchdog import PlcWatchdog


class PlcPartner(Protocol):
    """Whoever runs the PLC program: another process, or the simulation in the same one."""

    def wake(self, time: float) -> None:
        """A PLC cycle is due. Never blocks in the real machine; in the simulation it runs the cycle."""

    def restart(self) -> None:
        """Start the program again after it was lost."""


class PlcProcess:
    """The PLC in its own process, woken through an eventfd; the service process starts it again when asked."""

    def __init__(self, wake_descriptor: int, hli: Hli) -> None:
        self._descriptor = wake_descriptor
        self._platform = hli.platform

    def wake(self, time: float) -> None:
        with contextlib.suppress(BlockingIOError):  # the counter is full: nobody has read it for ages
            os.eventfd_write(self._descriptor, 1)

    def restart(self) -> None:
        self._platform.plc_restart_request_r += 1


class PlcSupervision:
    """Wakes the PLC when it is due, and tells once when it is lost.

    Lost: no sign of life within the watchdog time, its program has reported a failure, or it has logged off. Its log-on flags
    stay as they are: what it has claimed is not given away, and what it has not acknowledged is not taken as done.
    """

    def __init__(self, hli: Hli, partner: PlcPartner, every: int) -> None:
        self._hli = hli
        self._platform = hli.platform
        self._partner = partner
        self._every = every
        self._countdown = 1
        self._watchdog = PlcWatchdog(hli.channels[0])
        self._errors_seen = int(hli.platform.plc_error_count_w)
        self._alarms: dict[int, int] = {}  # the PLC's number of an alarm -> ours
        self.running = False

    def wake(self, time: float) -> None:
        """Once per cycle: wakes the PLC when it is due."""
        platform = self._platform
        self._countdown -= 1
        if self._countdown > 0:
            return
        self._countdown = self._every
        if self.running and platform.plc_cycle_done_w != platform.plc_cycle_request_r:
            platform.plc_overruns_r += 1
        platform.plc_cycle_request_r += 1
        self._partner.wake(time)

    def judge(self, time_ns: int) -> Problem | None:
        """Once per cycle: the problem by which the PLC was lost in this cycle."""
        problem = self._watchdog.check(time_ns)
        platform = self._platform
        if platform.plc_error_count_w != self._errors_seen:
            self._errors_seen = int(platform.plc_error_count_w)
            entry = CATALOGUE.get(platform.plc_error_id_w, plc.PLC_RAISED)
            told = ErrorEntry(entry.id, "{text}", entry.severity, Reaction.STOP_ON_PATH, entry.remedy)
            problem = Problem(told, {"text": get_text(platform, "plc_error_text_w")})
        alive = bool(self._hli.channels[0].watchdog.alive_state_r)
        if problem is None and self.running and not alive:
            problem = Problem(plc.PLC_LOGGED_OFF)
        if problem is not None:
            self._lose()
        elif alive != self.running:
            self.running = alive
            platform.plc_running_r = alive
        return problem

    def reports(self, add: Callable[[Problem], int], close: Callable[[int], None]) -> None:
        """Alarms of the PLC program that came or went in this cycle: at most one, the semaphore guards it."""
        report = take_report(self._platform.lc_error)
        if report is None:
            return
        if not report.active:
            number = self._alarms.pop(report.number, None)
            if number is not None:
                close(number)
            return
        entry = CATALOGUE.get(report.id, plc.PLC_ALARM)
        told = ErrorEntry(entry.id, "{text}", entry.severity, entry.reaction, entry.remedy)
        if len(self._alarms) < ALARMS:
            self._alarms[report.number] = add(Problem(told, {"text": report.text}, Place("", report.line)))

    def _lose(self) -> None:
        self.running = False
        self._platform.plc_running_r = False

    def restart(self) -> None:
        """Ask for a new start, if the program does not run."""
        if not self.running:
            self._partner.restart()
