"""#MCS: for a while programmed coordinates are those of the machine axes (programming manual 27641–27698)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.systems import leave_systems, return_to_systems
from runtime.diagnostics.catalogue import coordinates as errors

_SPEC = "isg.cs.mcs"


def _leave(x: Execution, call: StatementCall, *, without_tool: bool) -> None:
    if x.systems.mcs is not None:
        raise call.error(errors.MACHINE_TWICE)
    leave_systems(x, without_tool=without_tool)


@statement("MCS ON", _SPEC, modal=True)
def machine_axes(x: Execution, call: StatementCall) -> None:
    """Coordinate systems and all offsets are set aside; offsets that are programmed now end with #MCS OFF."""
    _leave(x, call, without_tool=False)


@statement("MCS ON EX TOOL", _SPEC, modal=True)
def machine_axes_without_tool(x: Execution, call: StatementCall) -> None:
    """The same; a tool that is selected meanwhile does not count before #MCS OFF."""
    _leave(x, call, without_tool=True)


@statement("MCS OFF", _SPEC, modal=True)
def systems_again(x: Execution, call: StatementCall) -> None:
    """Everything holds that held before #MCS ON."""
    if x.systems.mcs is None:
        x.warn(errors.NOTHING_TO_END, call.column, statement="#MCS OFF")
        return
    if not return_to_systems(x):
        x.warn(errors.ROTATION_LOST, call.column)
