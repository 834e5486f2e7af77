"""Alarms: from a problem to the HLI's history and to an event for the journal."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from runtime.diagnostics.errors import Problem, Severity
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.hli.alarms import AlarmHistory, AlarmLine, alarm_lines
from runtime.hli.layout import Hli


class AlarmList:
    """Writes the alarm history of the HLI and tells the event ring.

    `wall_clock` gives nanoseconds since 1970 and is only stored, never computed with.
    """

    def __init__(self, hli: Hli, events: EventRing, wall_clock: Callable[[], int]) -> None:
        self._hli = hli
        self._history = AlarmHistory(hli)
        self._events = events
        self._wall_clock = wall_clock

    def add(self, problem: Problem, *, time: float = 0.0, cycle: int = 0, axis: int = -1) -> int:
        """Put a problem into history and event ring; returns its number in the history, by which it is closed.

        `axis` is the index in the machine description, -1 for none.
        """
        text = problem.text
        if problem.place.file or problem.place.line:
            text = f"{problem.place}: {text}"
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
        return self._history.add(
            AlarmLine(
                sequence=0,
                time_ns=self._wall_clock(),
                cycle=cycle,
                id=problem.entry.id,
                severity=problem.entry.severity,
                text=text,
                axis=self._hli.axes[axis].log_ax_n_r if axis >= 0 else 0,
                line=problem.place.line,
                active=problem.entry.severity >= Severity.ERROR,
            )
        )

    def close(self, number: int) -> None:
        """The cause of one alarm is gone."""
        self._history.close(number)

    def acknowledge(self) -> None:
        """After a reset no alarm is active any more; the history stays."""
        self._history.close_all()

    def restore(self, rows: Iterable[Mapping[str, object]]) -> None:
        """Put what an earlier run left, as `history` returned it, in front of the history."""
        for row in rows:
            self._history.add(
                AlarmLine(
                    sequence=0,
                    time_ns=int(str(row["time_ns"])),
                    cycle=int(str(row["cycle"])),
                    id=int(str(row["id"])),
                    severity=Severity(int(str(row["severity"]))),
                    text=str(row["text"]),
                    axis=int(str(row["axis"])),
                    line=int(str(row["line"])),
                    active=False,
                )
            )


def history(hli: Hli) -> list[dict[str, object]]:
    """The alarm history as plain data, oldest first, for keeping it over a restart."""
    return [
        {
            "time_ns": line.time_ns,
            "cycle": line.cycle,
            "id": line.id,
            "severity": int(line.severity),
            "axis": line.axis,
            "line": line.line,
            "text": line.text,
        }
        for line in reversed(alarm_lines(hli))
    ]
