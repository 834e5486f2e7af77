"""G functions that move axes beside the program: homing (G74), manual mode (G200, G201, G202)."""

from __future__ import annotations

from runtime.cnc.blocks import Homing, ManualKind, ManualMotion
from runtime.cnc.decoder.additions import expect_no_line
from runtime.cnc.decoder.couplings import expect_uncoupled
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.decoder.places import begin_where_axes_are
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Group
from runtime.diagnostics.catalogue import language as catalogue


@g_function(
    74,
    Group.ARGUMENTS,
    "isg.g.homing-g74",
    modal=False,
    syntax="G74 <axis><order> {<axis><order>}",
    axis_arguments=True,
    alone=True,
)
def homing(x: Execution, call: GCall) -> None:
    """Axes with the same number at the same time, lower numbers first; decoding goes on where they stand then."""
    order = x.raw_arguments(74, call.column)
    for axis, value in order.items():
        if value < 0.5 or value != round_half_up(value):
            raise LineError(catalogue.HOMING_ORDER, call.column, axis=x.setup.axes[axis], value=value)
    turns = sorted(set(order.values()))
    ranks = tuple(turns.index(order[axis]) + 1 if axis in order else 0 for axis in range(len(x.setup.axes)))
    expect_no_line(x)
    begin_where_axes_are(x, Homing(x.source, ranks), "G74")


@g_function(
    200,
    Group.MANUAL,
    "isg.g.manual-exclusive-g200",
    modal=False,
    syntax="G200 {<axis>..}",
    axis_arguments=True,
    alone=True,
)
def by_hand(x: Execution, call: GCall) -> None:
    """The path stands, all axes or those that are named are moved by hand, until continue."""
    expect_no_line(x)
    begin_where_axes_are(x, ManualMotion(x.source, ManualKind.EXCLUSIVE, _axes(x)), "G200")
    x.manual_axes.clear()  # continue takes the hand away from all axes


@g_function(
    201,
    Group.MANUAL,
    "isg.g.manual-parallel-g201-g202",
    syntax="G201 <axis>.. {<axis>..}",
    axis_arguments=True,
    alone=True,
)
def beside_the_path(x: Execution, call: GCall) -> None:
    """The named axes are moved by hand beside the path."""
    expect_uncoupled(x, "G201", call.column)
    chosen = tuple(x.raw_arguments(201, call.column))
    x.manual_axes.update(chosen)
    x.emit(ManualMotion(x.source, ManualKind.PARALLEL, chosen))


@g_function(
    202,
    Group.MANUAL,
    "isg.g.manual-parallel-g201-g202",
    syntax="G202 {<axis>..}",
    axis_arguments=True,
    alone=True,
)
def hand_away(x: Execution, call: GCall) -> None:
    """The initial state, of all axes or those that are named. What was moved by hand stays."""
    chosen = _axes(x)
    x.manual_axes.difference_update(chosen)
    x.emit(ManualMotion(x.source, ManualKind.END, chosen))


def _axes(x: Execution) -> tuple[int, ...]:
    """The axes of the block, all of them if none is named; their values have no meaning."""
    x.axes_taken = True
    return tuple(x.axis_words) or tuple(range(len(x.setup.axes)))
