"""System variables of offsets: compensation registers and work offsets (manual lines 6824–6931).

    #10001 … #10999  H geometry     #5201 …  common offset, axis 1 to 8
    #11001 … #11999  H wear         #5221 …  G54, #5241 … G55, to #5321 … G59
    #12001 … #12999  D geometry
    #13001 … #13999  D wear

They are those of G10 and of the operator, and are kept. A work offset that is active acts at once; a register with the next H or
D.
Values are in inch where inch is selected.
"""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.g_offsets import WORK_SYSTEMS, offset_changed
from runtime.cnc.decoder.nct.registers import write_register
from runtime.cnc.decoder.nct.registry import system_variable, writes
from runtime.cnc.language.errors import CalculationError, LineError
from runtime.cnc.language.nct.functions import Value, number
from runtime.cnc.tools.offset_table import COMMON, GREATEST_REGISTER, OffsetTableError
from runtime.diagnostics.catalogue import nct_macros as catalogue

AXES = 8
COMMON_FIRST, STEP = 5200, 20  # #5201; the next system is 20 further
REGISTERS = {10_000: ("H", False), 11_000: ("H", True), 12_000: ("D", False), 13_000: ("D", True)}


def _failed(error: OffsetTableError, variable: int) -> CalculationError:
    return CalculationError(error.problem.entry, f"#{variable}", **error.problem.values)


# ---------------------------------------------------------------------------------------------------- registers


def _register(first: int, kind: str, wear: bool) -> None:
    meaning = f"{kind} {'wear' if wear else 'geometry'} of register 1 to {GREATEST_REGISTER}"

    @system_variable(first + 1, first + GREATEST_REGISTER, "nct.sysvar.tool-compensation", meaning=meaning)
    def read(x: NctExecution, variable: int) -> Value:
        try:
            register = x.memory.offsets.register(kind, variable - first)
        except OffsetTableError as error:
            raise _failed(error, variable) from None
        return x.shown_length(register.wear if wear else register.geometry)

    @writes(first + 1)
    def write(x: NctExecution, variable: int, value: Value) -> None:
        length = x.length(number(value))
        try:
            write_register(x, kind, variable - first, length, wear=wear, added=False, column=1)
        except LineError as error:
            raise CalculationError(error.entry, f"#{variable}", **error.values) from None


for _first, (_kind, _wear) in REGISTERS.items():
    _register(_first, _kind, _wear)


# ---------------------------------------------------------------------------------------------------- work offsets


def _axis(x: NctExecution, variable: int, first: int) -> int:
    axis = variable - first - 1
    if axis >= len(x.setup.axes):
        raise CalculationError(catalogue.VARIABLE_UNKNOWN, f"#{variable}", number=variable)
    return axis


def _work_offset(system: int) -> None:
    first = COMMON_FIRST + STEP * system
    meaning = f"offset of {f'G{53 + system}' if system else 'all work systems'}, axis 1 to {AXES}"

    @system_variable(first + 1, first + AXES, "nct.sysvar.work-offsets", meaning=meaning)
    def read(x: NctExecution, variable: int) -> Value:
        axis = _axis(x, variable, first)
        offsets = x.memory.zero_offsets[system] if system else x.memory.common_offset
        return x.shown(axis, float(offsets[axis]))

    @writes(first + 1)
    def write(x: NctExecution, variable: int, value: Value) -> None:
        axis = _axis(x, variable, first)
        try:
            x.memory.set_work_offset(system or COMMON, axis, x.axis_value(axis, number(value)))
        except OffsetTableError as error:
            raise _failed(error, variable) from None
        offset_changed(x, system)


for _system in range(WORK_SYSTEMS + 1):
    _work_offset(_system)
