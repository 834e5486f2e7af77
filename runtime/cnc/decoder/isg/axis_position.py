"""<axis>[SET_POSITION ..]: the machine counts an axis anew where it stands (programming manual 30693–30738)."""

from __future__ import annotations

from runtime.cnc.blocks import PositionSetting
from runtime.cnc.decoder.additions import expect_no_line
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.axis_commands import axis_command, chosen
from runtime.cnc.decoder.isg.registry import StatementCall
from runtime.cnc.decoder.motion import POSITION_LIMIT
from runtime.cnc.decoder.places import begin_where_axes_are
from runtime.cnc.language.isg.syntax import Key
from runtime.diagnostics.catalogue import language as catalogue


@axis_command(
    "SET_POSITION",
    "isg.axis.set-position",
    syntax=("SET_POSITION POS=..", "SET_POSITION OFFSET=.."),
    keys=(Key("POS"), Key("OFFSET")),
)
def set_position(x: Execution, call: StatementCall, axis: int) -> None:
    """To a position, or by an offset, in machine coordinates; the axis has its reference then. Offsets of the program stay."""
    key = chosen(call, "SET_POSITION", "POS", "OFFSET")
    value = x.axis_value(axis, call.needed(key))
    if not abs(value) <= POSITION_LIMIT:
        raise call.error(catalogue.POSITION_RANGE, key, value=value, axis=x.setup.axes[axis], limit=POSITION_LIMIT)
    expect_no_line(x)
    begin_where_axes_are(x, PositionSetting(x.source, axis, value, relative=key == "OFFSET"), "SET_POSITION")
