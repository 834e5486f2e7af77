"""A PLC that acknowledges each function after a given time: for tests of the synchronisation types."""

from __future__ import annotations

from collections.abc import Mapping

from runtime.hli.memory import HliMemory
from runtime.hli.technology import Taken, TechnologyTaker

Key = tuple[int, int]  # kind, number


class ScriptedPlc:
    """`delays`: seconds from taking to acknowledging, by (kind, number); None never. Everything else is done at once."""

    def __init__(self, memory: HliMemory, delays: Mapping[Key, float | None]) -> None:
        self.hli = memory.hli
        self.delays = delays
        self.taken: list[Key] = []
        self._open: list[tuple[Taken, float | None]] = []
        self._takers: list[TechnologyTaker] = []

    def wake(self, time: float) -> None:
        hli = self.hli
        if not self._takers:
            areas = [hli.channels[0], *(hli.axes[i] for i in range(hli.head.axes_r))]
            self._takers = [TechnologyTaker(area) for area in areas]
            for area in areas:
                area.plc_present_w = True
            watchdog = hli.channels[0].watchdog
            watchdog.cycle_time_w, watchdog.enable_w = 50_000, True
        hli.channels[0].watchdog.alive_rw = True
        hli.platform.plc_cycle_done_w = hli.platform.plc_cycle_request_r
        for taker in self._takers:
            for taken in taker.take():
                key = (taken.function.kind, taken.function.number)
                self.taken.append(key)
                delay = self.delays.get(key, 0.0)
                self._open.append((taken, None if delay is None else time + delay))
        still_open = []
        for taken, due in self._open:
            if due is not None and time >= due - 1e-9:
                taken.done()
            else:
                still_open.append((taken, due))
        self._open = still_open

    def restart(self) -> None:
        """It never fails."""
