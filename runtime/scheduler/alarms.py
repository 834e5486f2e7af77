"""Alarms: from a problem to the HLI's history, to an event, and to the reaction the catalogue asks for."""

from __future__ import annotations

from collections.abc import Callable

from runtime.diagnostics.errors import Problem, Severity
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.hli.layout import ALARMS, TEXT, Hli


class AlarmList:
    """Writes the alarm history of the HLI; the oldest line is overwritten.

    `wall_clock` gives nanoseconds since 1970 and is only stored, never computed with.
    """

    def __init__(self, hli: Hli, events: EventRing, wall_clock: Callable[[], int]) -> None:
        self._hli = hli
        self._events = events
        self._wall_clock = wall_clock

    def add(self, problem: Problem, *, time: float = 0.0, cycle: int = 0, axis: int = -1) -> None:
        """Put a problem into history and event ring. `axis` is the index in the machine description, -1 for none."""
        text = problem.text
        if problem.place.file or problem.place.line:
            text = f"{problem.place}: {text}"
        hli = self._hli
        count = hli.alarm_count_r
        line = hli.alarms[count % ALARMS]
        line.sequence_r = 0
        line.time_ns_r = self._wall_clock()
        line.cycle_r = cycle
        line.id_r = problem.entry.id
        line.severity_r = problem.entry.severity
        line.axis_r = hli.axes[axis].log_ax_n_r if axis >= 0 else 0
        line.line_r = problem.place.line
        line.active_r = problem.entry.severity >= Severity.ERROR
        line.text_r = text.encode("utf-8", "replace")[: TEXT - 1]
        hli.alarm_count_r = count + 1
        line.sequence_r = count + 1
        self._events.put(
            Event(
                t=time,
                cycle=cycle,
                kind=EventKind.ERROR,
                line=problem.place.line,
                number=problem.entry.id,
                value=float(problem.entry.severity),
                axis=axis,
                text=text,
            )
        )

    def acknowledge(self) -> None:
        """After a reset no alarm is active any more; the history stays."""
        for line in self._hli.alarms:
            line.active_r = False

    def restore(self, rows: list[dict[str, object]]) -> None:
        """Fill the history with what an earlier run left (oldest first), as `history` returned it."""
        hli = self._hli
        for row in rows[-ALARMS:]:
            count = hli.alarm_count_r
            line = hli.alarms[count % ALARMS]
            line.time_ns_r = int(str(row["time_ns"]))
            line.id_r = int(str(row["id"]))
            line.severity_r = int(str(row["severity"]))
            line.axis_r = int(str(row["axis"]))
            line.line_r = int(str(row["line"]))
            line.active_r = False
            line.text_r = str(row["text"]).encode("utf-8", "replace")[: TEXT - 1]
            hli.alarm_count_r = count + 1
            line.sequence_r = count + 1


def history(hli: Hli) -> list[dict[str, object]]:
    """The alarm history as plain data, oldest first, for retaining it over a restart."""
    lines = sorted((line for line in hli.alarms if line.sequence_r), key=lambda line: line.sequence_r)
    return [
        {
            "time_ns": line.time_ns_r,
            "id": line.id_r,
            "severity": line.severity_r,
            "axis": line.axis_r,
            "line": line.line_r,
            "active": line.active_r,
            "text": line.text_r.decode("utf-8", "replace"),
        }
        for line in lines
    ]
