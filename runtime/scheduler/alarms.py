"""Alarms: from a problem to the HLI's history, to the PLC, and to an event for the journal."""

from __future__ import annotations

from collections.abc import Callable, Iterable

from runtime.diagnostics.errors import Problem, Severity
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.hli.alarms import AlarmHistory, AlarmLine, alarm_lines
from runtime.hli.error_messages import ErrorMessage, ErrorPort
from runtime.hli.layout import Hli
from runtime.hli.memory import get_text
from runtime.scheduler.retained import RetainedAlarm


class AlarmList:
    """Writes the alarm history of the HLI, tells the event ring, and the PLC by `to_plc`, which is polled in each cycle.

    `wall_clock` gives nanoseconds since 1970 and is only stored, never computed with.
    """

    def __init__(self, hli: Hli, events: EventRing, wall_clock: Callable[[], int]) -> None:
        self._hli = hli
        self._history = AlarmHistory(hli)
        self.to_plc = ErrorPort(hli.channels[0])
        self._events = events
        self._wall_clock = wall_clock
        self.on_problem: Callable[[Problem], None] | None = None  # simulation: the problems themselves

    def add(self, problem: Problem, *, time: float = 0.0, cycle: int = 0, axis: int = -1) -> int:
        """Put a problem into history and event ring; returns its number in the history, by which it is closed.

        `axis` is the index in the machine description, -1 for none.
        """
        if self.on_problem is not None:
            self.on_problem(problem)
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
        time_ns = self._wall_clock()
        number = self._hli.axes[axis].log_ax_n_r if axis >= 0 else 0
        entry, place = problem.entry, problem.place
        self.to_plc.put(
            ErrorMessage(
                entry.id, problem.text, entry.severity, entry.reaction, number, place.file, place.line, time_ns, cycle
            )
        )
        return self._history.add(
            AlarmLine(
                sequence=0,
                time_ns=time_ns,
                cycle=cycle,
                id=problem.entry.id,
                severity=problem.entry.severity,
                text=text,
                axis=number,
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

    def restore(self, alarms: Iterable[RetainedAlarm]) -> None:
        """Put what an earlier run left, oldest first, in front of the history."""
        numbers = {get_text(axis, "name_r"): axis.log_ax_n_r for axis in self._hli.axes}
        for alarm in alarms:
            self._history.add(
                AlarmLine(
                    sequence=0,
                    time_ns=alarm.time_ns,
                    cycle=0,
                    id=alarm.id,
                    severity=Severity(alarm.severity),
                    text=alarm.text,
                    axis=numbers.get(alarm.axis, 0) if alarm.axis else 0,
                    line=alarm.line,
                    active=False,
                )
            )


def history(hli: Hli) -> tuple[RetainedAlarm, ...]:
    """The alarm history for keeping it over a restart, oldest first."""
    names = {axis.log_ax_n_r: get_text(axis, "name_r") for axis in hli.axes if axis.log_ax_n_r}
    return tuple(
        RetainedAlarm(line.time_ns, line.id, int(line.severity), line.text, names.get(line.axis, ""), line.line)
        for line in reversed(alarm_lines(hli))
    )
