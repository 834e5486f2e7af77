"""System variables of positions (manual lines 7144–7259): #5001 …, the last digits are the axis, counted as in the channel.

    #5001  end of the block before: programmed point, without compensations
    #5021  where the axis stands: machine coordinates
    #5041  where the axis stands: work coordinates, compensations are in it
    #5061  where the skip signal came (G31)
    #5081  length compensation
    #5101  how far the axis is behind its set-point

Values are in inch where inch is selected. Reading where an axis stands waits for the path.
"""

from __future__ import annotations

from collections.abc import Callable

from runtime.cnc.decoder.nct.cycle_data import tool_length
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import system_variable
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.nct.functions import Value
from runtime.diagnostics.catalogue import nct_macros as catalogue

AXES = 8
_SPEC = "nct.sysvar.positions"


def block_end(x: NctExecution, axis: int) -> float:
    """The programmed point that the last motion has led to, transformations taken off."""
    c = x.coordinates
    return c.transformations.image(c.numbers)[axis]


def machine_position(x: NctExecution, axis: int) -> float:
    place = x.outside.command_position()
    return x.coordinates.position[axis] if place is None else float(place[axis])


def work_position(x: NctExecution, axis: int) -> float:
    """Counted from the work zero; compensations are in it."""
    return machine_position(x, axis) - work_zero(x, axis)


def work_zero(x: NctExecution, axis: int) -> float:
    """Where the zero of the work coordinates lies in the machine."""
    c = x.coordinates
    return c.offsets.zero[axis] + c.common[axis] + c.shifted[axis] + c.local[axis]


def servo_lag(x: NctExecution, axis: int) -> float:
    command, actual = x.outside.command_position(), x.outside.actual_position()
    return 0.0 if command is None or actual is None else float(command[axis] - actual[axis])


def _register(first: int, read: Callable[[NctExecution, int], float], meaning: str, in_step: bool) -> None:
    @system_variable(first + 1, first + AXES, _SPEC, meaning=meaning, in_step=in_step)
    def position(x: NctExecution, variable: int) -> Value:
        axis = variable - first - 1
        if axis >= len(x.setup.axes):
            raise CalculationError(catalogue.VARIABLE_UNKNOWN, f"#{variable}", number=variable)
        return x.shown(axis, read(x, axis))


_register(5000, block_end, "end of the block before, axis 1 to 8", False)
_register(5020, machine_position, "present position in machine coordinates, axis 1 to 8", True)
_register(5040, work_position, "present position in work coordinates, axis 1 to 8", True)
_register(5080, tool_length, "length compensation, axis 1 to 8", False)
_register(5100, servo_lag, "servo lag, axis 1 to 8", True)


@system_variable(5061, 5060 + AXES, _SPEC, "nct.meas.skip-g31", meaning="where the skip signal came (G31), axis 1 to 8")
def skip_position(x: NctExecution, variable: int) -> Value:
    """Counted from the work zero, compensations are in it. Vacant before the first G31; the end of one without a signal."""
    axis = variable - 5061
    if axis >= len(x.setup.axes):
        raise CalculationError(catalogue.VARIABLE_UNKNOWN, f"#{variable}", number=variable)
    places = x.memory.skip
    return None if places is None else x.shown(axis, places[axis] - work_zero(x, axis))
