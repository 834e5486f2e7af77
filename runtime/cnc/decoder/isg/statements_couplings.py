"""#AX LINK: axes that follow others (programming manual 12926–13301)."""

from __future__ import annotations

from runtime.cnc.decoder import couplings
from runtime.cnc.decoder.additions import expect_no_line
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.independent import wait_for
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import language as catalogue

_DEFINE, _SWITCH, _STATE = "isg.add.ax-link-define", "isg.add.ax-link-enable", "isg.add.ax-link-variables"


@statement(
    "SET AX LINK",
    _DEFINE,
    syntax="#SET AX LINK [<group>, <slave>=<master> {, <slave>=<master>}]",
    form=Form.PAIRS,
    words=("NBR",),
    aliases=("AX LINK",),
)
def define(x: Execution, call: StatementCall) -> None:
    """With NBR the axes are logical numbers; whether the channel has them is seen when the group is switched on."""
    by_number = bool(call.words())
    group, axes = 0, []
    for argument, value in call:
        if argument.name == "GROUP":
            group = round_half_up(value)
        elif argument.name:
            axes.append(_number(x, call, argument.text, value, by_number=by_number))
    couplings.define(x, group, list(zip(axes[::2], axes[1::2], strict=True)), call.column)


def _number(x: Execution, call: StatementCall, text: str, value: float | None, *, by_number: bool) -> int:
    """The logical number of an axis of a pair, by its name or, with NBR, as it is."""
    if by_number:
        if value is None:
            raise call.error(errors.COUPLING_NUMBER, text=text)
        return round_half_up(value)
    axis = x.setup.addresses.axis(text)
    if axis < 0:
        raise call.error(catalogue.AXIS_UNKNOWN, axis=text, axes=", ".join(x.setup.axes))
    if axis >= len(x.setup.log_axes):
        raise call.error(catalogue.LOGICAL_AXIS, value=text, known="without a machine description axes have no number")
    return x.setup.log_axes[axis]


def _before(x: Execution, call: StatementCall) -> None:
    """What may not be when a coupling is switched."""
    name = "#" + call.syntax.name
    expect_none(x, name, call.column)
    expect_no_line(x)
    if x.modal.contouring or x.smoothing.spline_on or x.smoothing.hsc_on:
        raise call.error(errors.COUPLING_SMOOTHED, statement=name)
    wait_for(x, tuple(x.independent.running))


@statement(
    "AX LINK ON", _SWITCH, syntax="#AX LINK ON [<group>]", form=Form.PLACES, optional=True, aliases=("ENABLE AX LINK",)
)
def enable(x: Execution, call: StatementCall) -> None:
    """Without a number group 0, that of the channel parameters."""
    _before(x, call)
    couplings.enable(x, round_half_up(call.number("", 0.0) or 0.0), call.column)


@statement(
    "AX LINK OFF",
    _SWITCH,
    syntax="#AX LINK OFF [<group>]",
    form=Form.PLACES,
    optional=True,
    aliases=("DISABLE AX LINK",),
)
def disable(x: Execution, call: StatementCall) -> None:
    """Without a number the group that was switched on last."""
    _before(x, call)
    group = call.number("")
    couplings.disable(x, list(x.coupling.active)[-1:] if group is None else [round_half_up(group)])


@statement("AX LINK OFF ALL", _SWITCH, aliases=("DISABLE AX LINK ALL",))
def disable_all(x: Execution, call: StatementCall) -> None:
    _before(x, call)
    couplings.disable(x, tuple(x.coupling.active))


@variable("V.G.AX_LINK.NR", _STATE, "coupling group that is active, or was last")
def last_group(x: Execution) -> float:
    return float(next(reversed(x.coupling.active), x.coupling.last))


@variable("V.G.AX_LINK.ACTIVE", _STATE, "1 while a coupling is active")
def any_active(x: Execution) -> float:
    return float(bool(x.coupling.active))
