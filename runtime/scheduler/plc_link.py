"""How the cycle wakes the PLC and how it sees that the PLC is no longer well."""

from __future__ import annotations

import contextlib
import os
from typing import Protocol

from runtime.diagnostics.catalogue import CATALOGUE, plc
from runtime.diagnostics.errors import ErrorEntry, Problem, Reaction
from runtime.hli.layout import Hli


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
    """Counts PLC cycles out and in. Lost: no cycle finished for the watchdog time, or the program has reported its failure."""

    def __init__(self, hli: Hli, partner: PlcPartner, every: int, watchdog: float) -> None:
        self._hli = hli
        self._platform = hli.platform
        self._partner = partner
        self._every = every
        self._watchdog = watchdog
        self._countdown = 1
        self._finished_at = 0.0
        self._errors_seen = int(hli.platform.plc_error_count_w)
        self.running = False

    def wake(self, time: float) -> Problem | None:
        """Once per cycle, `time` in s: wakes the PLC when it is due; tells once when it is lost."""
        platform = self._platform
        self._countdown -= 1
        if self._countdown <= 0:
            self._countdown = self._every
            if platform.plc_cycle_done_w != platform.plc_cycle_request_r and self.running:
                platform.plc_overruns_r += 1
            platform.plc_cycle_request_r += 1
            self._partner.wake(time)
        return self._judge(time)

    def _judge(self, time: float) -> Problem | None:
        platform = self._platform
        if platform.plc_error_count_w != self._errors_seen:
            self._errors_seen = int(platform.plc_error_count_w)
            self._lose()
            entry = CATALOGUE.get(platform.plc_error_id_w, plc.PLC_RAISED)
            text = platform.plc_error_text_w.decode("utf-8", "replace")
            return Problem(
                ErrorEntry(entry.id, "{text}", entry.severity, Reaction.STOP_ON_PATH, entry.remedy), {"text": text}
            )
        if not platform.plc_present_w:
            if self.running:
                self._lose()
                return Problem(plc.PLC_WATCHDOG, self._gap(time))
            self._finished_at = time
            return None
        if platform.plc_cycle_done_w == platform.plc_cycle_request_r:
            self._finished_at = time
            if not self.running:
                self.running = True
                platform.plc_running_r = True
        elif self.running and time - self._finished_at > self._watchdog:
            problem = Problem(plc.PLC_WATCHDOG, self._gap(time))
            self._lose()
            return problem
        return None

    def _gap(self, time: float) -> dict[str, object]:
        return {
            "milliseconds": round((time - self._finished_at) * 1e3),
            "allowed": round(self._watchdog * 1e3),
        }

    def _lose(self) -> None:
        self.running = False
        self._platform.plc_running_r = False
        self._platform.plc_present_w = False  # a dead PLC cannot log off
        for area in (*self._hli.channels, *self._hli.axes):
            area.plc_present_w = False

    def restart(self) -> None:
        """Ask for a new start, if the program does not run."""
        if not self.running:
            self._partner.restart()
