"""Tasks: methods of a program that run at their own cycle time.

    @task(every=0.1)
    def temperatures(self) -> None: ...

They run in PLC cycles, after the handlers of technology functions and before `cycle`, the shorter period first: nothing is
interrupted, so nothing has to be locked. A period that is no multiple of the PLC cycle is kept on the average. Cycles that were
missed are not made up for.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.plc_logic.errors import PlcError

F = TypeVar("F", bound=Callable[[Any], None])


def task(every: float) -> Callable[[F], F]:
    """The method is called every so many seconds. Raises PlcError unless they are more than 0."""
    if not every > 0.0:
        raise PlcError(catalogue.PLC_ARGUMENT, function="task", what=f"a period of {every} s is not possible")

    def mark(method: F) -> F:
        method.task_period_ns = round(every * 1e9)  # type: ignore[attr-defined]
        return method

    return mark


@dataclass(slots=True)
class _Task:
    name: str
    period_ns: int
    due_ns: int | None = None  # None: at once


class Tasks:
    """The tasks of a program class, and when each is due."""

    def __init__(self, program: type) -> None:
        found: dict[str, _Task] = {}
        for base in program.__mro__[::-1]:
            for name, member in vars(base).items():
                found.pop(name, None)  # overridden
                if (period := getattr(member, "task_period_ns", None)) is not None:
                    found[name] = _Task(name, period)
        self._tasks = sorted(found.values(), key=lambda task: task.period_ns)

    def run(self, program: object, time_ns: int) -> None:
        """Call what is due."""
        for task in self._tasks:
            due = task.due_ns
            if due is None or time_ns >= due:
                planned = (time_ns if due is None else due) + task.period_ns
                task.due_ns = planned if planned > time_ns else time_ns + task.period_ns
                getattr(program, task.name)()

    def keep_times_of(self, before: Tasks) -> None:
        """After an online change: tasks of the same name and period go on in their rhythm."""
        times = {(task.name, task.period_ns): task.due_ns for task in before._tasks}
        for task in self._tasks:
            task.due_ns = times.get((task.name, task.period_ns))
