"""G100, G106: measuring runs. G101, G102: measuring offsets in and out of the coordinates (programming manual 3234–3675)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group
from runtime.diagnostics.catalogue import measuring as catalogue

_TYPES = (
    "isg.g.measuring-framework",
    "isg.g.measure-type1",
    "isg.g.measure-type2",
    "isg.g.measure-type3-g106",
    "isg.g.measure-type4",
)
_OFFSET = "isg.g.measuring-offset-g101-g102"


@g_function(
    100, Group.MEASURING, *_TYPES, modal=False, syntax="G100 <axis>.. {<axis>..} [G106] [F..]", axis_arguments=False
)
def measuring_run(x: Execution, call: GCall) -> None:
    """The motion of the block is a measuring run: see decoder.measuring."""
    x.measuring.column = call.column


@g_function(
    310,
    Group.MEASURING,
    "isg.g.measure-interrupt-g310",
    modal=False,
    syntax="G310 [G00 | G01 F..] <axis>.. {<axis>..} [$GOTO[<label>]]",
)
def interruptible(x: Execution, call: GCall) -> None:
    """A signal ends the motion of the block, and the program goes on at the label."""
    x.measuring.column = x.measuring.interrupts_column = call.column


@g_function(106, Group.MEASURING_THROUGH, "isg.g.measure-type3-g106", modal=False, syntax="G100 G106 <axis>..")
def through(x: Execution, call: GCall) -> None:
    """It goes on to its target behind the signal."""
    x.measuring.through_column = call.column


@g_function(
    101, Group.ARGUMENTS, _OFFSET, modal=False, syntax="G101 <axis><factor> {<axis><factor>}", axis_arguments=True
)
def include(x: Execution, call: GCall) -> None:
    """The difference between measured point and target, times a factor, is an offset of its own, in place of the one before."""
    state, offsets = x.measuring, x.coordinates.offsets
    factors = x.raw_arguments(101, call.column)
    for axis in factors:
        if axis not in state.values:
            raise LineError(catalogue.NOT_MEASURED, call.column, axis=x.setup.axes[axis])
        if axis in state.turned:
            raise LineError(catalogue.TURNED, call.column, axis=x.setup.axes[axis])
    measuring = offsets.measuring.copy()
    for axis, factor in factors.items():
        state.included[axis] = measuring[axis] = factor * state.values[axis].offset
    offsets.measuring = measuring
    x.coordinates.update()


@g_function(102, Group.ARGUMENTS, _OFFSET, modal=False, syntax="G102 {<axis>..}", axis_arguments=True)
def exclude(x: Execution, call: GCall) -> None:
    """What G101 has put in is taken out, of all axes or of those that are named; their values have no meaning."""
    state, offsets = x.measuring, x.coordinates.offsets
    chosen = tuple(x.axis_words)
    x.axes_taken = True
    for axis in chosen:
        if axis not in state.included:
            raise LineError(catalogue.NO_OFFSET, call.column, axis=x.setup.axes[axis])
    measuring = offsets.measuring.copy()
    for axis in chosen or tuple(state.included):
        del state.included[axis]
        measuring[axis] = 0.0
    offsets.measuring = measuring
    x.coordinates.update()
