"""The alarms of a PLC program: cyclic calls become lines that come and go, handed to the CNC one by one."""

from __future__ import annotations

from collections import deque

from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.alarms import Report, send_report
from runtime.hli.layout import PlcReport

WAITING = 64  # reports that wait for the CNC; a program that invents texts in every cycle loses the newest


class Reports:
    """An alarm comes with the first cycle that reports it and goes with the first one that doesn't."""

    def __init__(self, slot: PlcReport) -> None:
        self._slot = slot
        self._standing: dict[tuple[int, str], Report] = {}
        self._reported: set[tuple[int, str]] = set()  # in this cycle
        self._waiting: deque[Report] = deque()
        self._number = 0
        self.line = 0  # program line of the function whose handler runs, 0 none

    @property
    def standing(self) -> list[str]:
        """Texts of the alarms that stand."""
        return [report.text for report in self._standing.values()]

    def report(self, entry: ErrorEntry, text: str, line: int | None = None) -> None:
        """Called in every cycle in which the cause is there; `line` is that of the running handler if it is not
        given."""
        key = (entry.id, text)
        self._reported.add(key)
        if key not in self._standing:
            self._number += 1
            self._standing[key] = Report(entry.id, self._number, text, line=self.line if line is None else line)
            self._queue(self._standing[key])

    def update(self) -> None:
        """End of a PLC cycle: what was not reported again goes; hand over one report if the CNC is ready for it."""
        if len(self._standing) != len(self._reported):
            for key in [key for key in self._standing if key not in self._reported]:
                came = self._standing.pop(key)
                self._queue(Report(came.id, came.number, came.text, active=False, line=came.line))
        self._reported.clear()
        if self._waiting and send_report(self._slot, self._waiting[0]):
            self._waiting.popleft()

    def _queue(self, report: Report) -> None:
        if len(self._waiting) < WAITING:
            self._waiting.append(report)
