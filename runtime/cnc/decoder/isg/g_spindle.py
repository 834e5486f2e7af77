"""G functions of the main spindle: their argument is the S word of the block."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group
from runtime.diagnostics.catalogue import technology as errors


def _argument(x: Execution, call: GCall) -> None:
    """S is the argument of the function."""
    if x.block is None or x.block.speed < 0:
        raise LineError(errors.SPINDLE_WORD_NEEDED, call.column, number=call.number)
    x.speed_argument = call.number


@g_function(167, Group.NONE, "isg.spdl.override-g167", modal=False, syntax="G167 <spindle>..")
def override_off(x: Execution, call: GCall) -> None:
    """The external override of the spindle counts as 100 percent until its next order."""
    _argument(x, call)


@g_function(112, Group.NONE, "isg.spdl.gear-data-g112", modal=False, syntax="G112 <spindle>..")
def gear_data(x: Execution, call: GCall) -> None:
    """Dynamic data of a gear stage; the gear itself is changed by M functions."""
    _argument(x, call)
