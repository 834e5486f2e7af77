"""The alarms of a PLC program: cyclic calls become lines that come and go, handed to the CNC one by one."""

from __future__ import annotations

from collections import deque
from dataclasses import dataclass
from enum import Enum

from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.alarms import Report, send_report
from runtime.hli.layout import PlcReport
from runtime.plc_logic.cycle_time import now_ns

WAITING = 64  # reports that wait for the CNC; a program that invents texts in every cycle loses the newest
HISTORY = 256  # changes that the program may look back at; the CNC's history and the journal have more

Key = tuple[int, str]  # id of the entry, text


class Change(Enum):
    """What happened to an alarm."""

    CAME = "came"
    GONE = "gone"  # its cause; one that needs acknowledgement still stands
    ACKNOWLEDGED = "acknowledged"


@dataclass(frozen=True, slots=True)
class AlarmChange:
    """A line of the program's alarm history; `time` as `Program.time`."""

    time: float
    change: Change
    text: str


class Reports:
    """An alarm comes with the first cycle that reports it and goes with the first one that doesn't.

    One that needs acknowledgement stands until its cause is gone and it was acknowledged, in either order.
    """

    def __init__(self, slot: PlcReport) -> None:
        self._slot = slot
        self._standing: dict[Key, Report] = {}
        self._reported: set[Key] = set()  # in this cycle
        self._causes: set[Key] = set()  # reported in the cycle before
        self._unacknowledged: dict[Key, None] = {}  # in the order they came
        self._waiting: deque[Report] = deque()
        self._number = 0
        self.history: deque[AlarmChange] = deque(maxlen=HISTORY)  # oldest first
        self.line = 0  # program line of the function whose handler runs, 0 none

    @property
    def standing(self) -> list[str]:
        """Texts of the alarms that stand."""
        return [report.text for report in self._standing.values()]

    @property
    def unacknowledged(self) -> list[str]:
        """Texts of those that wait for an acknowledgement."""
        return [text for _, text in self._unacknowledged]

    def report(self, entry: ErrorEntry, text: str, line: int | None = None, *, acknowledge: bool = False) -> None:
        """Called in every cycle in which the cause is there; `line` is that of the running handler if it is not
        given."""
        key = (entry.id, text)
        if key in self._reported:
            return
        self._reported.add(key)
        if key in self._causes:
            return
        self._note(Change.CAME, text)
        if acknowledge:
            self._unacknowledged[key] = None
        if key not in self._standing:
            self._number += 1
            self._standing[key] = Report(entry.id, self._number, text, line=self.line if line is None else line)
            self._queue(self._standing[key])

    def acknowledge(self) -> None:
        """All alarms that need it: those whose cause is gone go, the others go with their cause."""
        for _, text in self._unacknowledged:
            self._note(Change.ACKNOWLEDGED, text)
        self._unacknowledged.clear()

    def update(self) -> None:
        """End of a PLC cycle: what was not reported again goes; hand over one report if the CNC is ready for it."""
        reported = self._reported
        if self._standing.keys() != reported:
            for key in [key for key in self._standing if key not in reported]:
                if key in self._causes:
                    self._note(Change.GONE, key[1])
                if key not in self._unacknowledged:
                    came = self._standing.pop(key)
                    self._queue(Report(came.id, came.number, came.text, active=False, line=came.line))
        self._causes, self._reported = reported, self._causes
        self._reported.clear()
        if self._waiting and send_report(self._slot, self._waiting[0]):
            self._waiting.popleft()

    def _note(self, change: Change, text: str) -> None:
        self.history.append(AlarmChange(now_ns() * 1e-9, change, text))

    def _queue(self, report: Report) -> None:
        if len(self._waiting) < WAITING:
            self._waiting.append(report)
