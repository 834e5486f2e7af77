"""Compensation registers as programs use them: read when H or D is programmed, written by G10 (manual lines 3173–3307)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.language.errors import LineError
from runtime.cnc.tools.offset_table import GREATEST_GEOMETRY, GREATEST_WEAR, OffsetTableError, Register
from runtime.diagnostics.catalogue import nct


def register_value(x: NctExecution, kind: str, number: int, column: int) -> float:
    """Geometry and wear of a register together, mm; number 0 is zero. LineError if the table cannot be read."""
    if number == 0:
        return 0.0
    try:
        return x.memory.offsets.register(kind, number).value
    except OffsetTableError as error:
        raise LineError(error.problem.entry, column, **error.problem.values) from None


def write_register(
    x: NctExecution, kind: str, number: int, value: float, *, wear: bool, added: bool, column: int
) -> None:
    """Set, or add to, geometry or wear of a register, mm. LineError 3001 beyond the limits."""
    try:
        before = x.memory.offsets.register(kind, number)
        old = before.wear if wear else before.geometry
        new = old + value if added else value
        register = Register(before.geometry, new) if wear else Register(new, before.wear)
        if not register.within_limits:
            limit = GREATEST_WEAR if wear else GREATEST_GEOMETRY
            raise LineError(nct.VALUE_EXCESS, column, address="R", value=new, least=-limit, most=limit)
        x.memory.offsets.set_register(kind, number, register)
    except OffsetTableError as error:
        raise LineError(error.problem.entry, column, **error.problem.values) from None
