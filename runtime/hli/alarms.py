"""The alarm history of the HLI, and the way of the PLC's alarms into it."""

from __future__ import annotations

from dataclasses import dataclass

from runtime.diagnostics.errors import Severity
from runtime.hli.layout import ALARMS, TEXT, Alarm, Hli, PlcReport
from runtime.hli.memory import get_text, put_text


@dataclass(frozen=True, slots=True)
class AlarmLine:
    """One line of the history. `time_ns` is the wall clock, `axis` the logical number (0 none), `line` the program
    line."""

    sequence: int
    time_ns: int
    cycle: int
    id: int
    severity: Severity
    text: str
    axis: int = 0
    line: int = 0
    active: bool = True


class AlarmHistory:
    """The writer: the CNC only. The history is a ring; the newest line overwrites the oldest."""

    def __init__(self, hli: Hli) -> None:
        self._hli = hli
        self._lines: list[Alarm] = list(hli.alarms)

    def add(self, alarm: AlarmLine) -> int:
        """Write a line (its `sequence` is given here); returns the sequence, by which it is closed later."""
        sequence = int(self._hli.alarm_count_r) + 1
        line = self._lines[(sequence - 1) % ALARMS]
        line.sequence_r = 0
        line.time_ns_r = alarm.time_ns
        line.cycle_r = alarm.cycle
        line.id_r = alarm.id
        line.severity_r = alarm.severity
        line.axis_r = alarm.axis
        line.line_r = alarm.line
        line.active_r = alarm.active
        put_text(line, "text_r", alarm.text)
        line.sequence_r = sequence
        self._hli.alarm_count_r = sequence
        return sequence

    def close(self, sequence: int) -> None:
        """The cause is gone; the line stays."""
        line = self._lines[(sequence - 1) % ALARMS]
        if line.sequence_r == sequence:
            line.active_r = False

    def close_all(self) -> None:
        """A reset clears whatever can be cleared."""
        for line in self._lines:
            line.active_r = False


def alarm_lines(hli: Hli, *, active_only: bool = False) -> list[AlarmLine]:
    """The history, newest first. A line that is being written while it is read is left out."""
    count = int(hli.alarm_count_r)
    lines = []
    for sequence in range(count, max(count - ALARMS, 0), -1):
        line = hli.alarms[(sequence - 1) % ALARMS]
        read = AlarmLine(
            sequence=sequence,
            time_ns=int(line.time_ns_r),
            cycle=int(line.cycle_r),
            id=int(line.id_r),
            severity=Severity(min(int(line.severity_r), Severity.FATAL)),
            text=get_text(line, "text_r"),
            axis=int(line.axis_r),
            line=int(line.line_r),
            active=bool(line.active_r),
        )
        if line.sequence_r == sequence and (read.active or not active_only):
            lines.append(read)
    return lines


@dataclass(frozen=True, slots=True)
class Report:
    """An alarm of the PLC that comes or goes; `number` is the same for both."""

    id: int
    number: int
    text: str
    active: bool = True
    line: int = 0


def send_report(slot: PlcReport, report: Report) -> bool:
    """PLC: hand over a report; False while the CNC has not taken the one before."""
    if slot.semaphor_rw:
        return False
    slot.id_w = report.id
    slot.number_w = report.number
    slot.line_w = report.line
    slot.active_w = report.active
    put_text(slot, "text_w", report.text)
    slot.semaphor_rw = True
    return True


def take_report(slot: PlcReport) -> Report | None:
    """CNC: take the waiting report, if there is one."""
    if not slot.semaphor_rw:
        return None
    report = Report(
        id=int(slot.id_w),
        number=int(slot.number_w),
        text=get_text(slot, "text_w")[:TEXT],
        active=bool(slot.active_w),
        line=int(slot.line_w),
    )
    slot.semaphor_rw = False
    return report
