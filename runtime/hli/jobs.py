"""Control units with usage check whose jobs are plain structures: activations, parameters, key presses.

    operator ─ data_w, semaphor_rw ─┬─ unclaimed ───────────────────────────────▶ taken
                                    └─ claimed by the PLC ─▶ request_r, request_semaphor_rw ─▶ PLC copies, or lowers the flag
    PLC ─ command_w, command_semaphor_rw (with enable_w and plc_present_w) ─────▶ taken

One table of units serves all of them. A flag is lowered when the job has been copied, so each job is taken once, and the
next one of the same giver only after it.
"""

from __future__ import annotations

import ctypes
from collections.abc import Sequence
from typing import Generic, Protocol, TypeVar

Data = TypeVar("Data", bound=ctypes.Structure)


class Unit(Protocol[Data]):
    """A unit of the HLI with usage check."""

    request_r: Data
    command_w: Data
    enable_w: bool
    request_semaphor_rw: bool
    command_semaphor_rw: bool


class OperatorSide(Protocol[Data]):
    """The operator's half."""

    data_w: Data
    semaphor_rw: bool


class Jobs(Generic[Data]):
    """Several equal units, or one, with one operator. `take` is called once per cycle."""

    def __init__(self, units: Sequence[Unit[Data]], operator: OperatorSide[Data]) -> None:
        self._units = list(units)
        self._operator = operator

    def take(self, present: bool) -> list[Data]:
        """Copies of the jobs of this cycle, at most one per unit and one of the operator.

        Without a PLC its requests are dropped: nobody can release them any more. A unit that the PLC gives back with a request
        in it has released it.
        """
        taken: list[Data] = []
        claimed = [unit for unit in self._units if present and unit.enable_w]
        for unit in self._units:
            if not present:
                unit.request_semaphor_rw = False
            elif unit.request_semaphor_rw and not unit.enable_w:
                taken.append(_copy(unit.request_r))
                unit.request_semaphor_rw = False
        for unit in claimed:
            if unit.command_semaphor_rw:
                taken.append(_copy(unit.command_w))
                unit.command_semaphor_rw = False
        operator = self._operator
        if operator.semaphor_rw and not claimed:
            taken.append(_copy(operator.data_w))
            operator.semaphor_rw = False
        elif operator.semaphor_rw:
            free = next((unit for unit in claimed if not unit.request_semaphor_rw), None)
            if free is not None:
                free.request_r = operator.data_w
                free.request_semaphor_rw = True
                operator.semaphor_rw = False
        return taken


def _copy(data: Data) -> Data:
    return type(data).from_buffer_copy(data)
