"""Offsets: zero offsets, reference point offset, position preset, software limits, offsets left out in a block."""

from __future__ import annotations

import math

from runtime.cnc.blocks import SoftwareLimitChange
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, g_function, statement
from runtime.cnc.decoder.memory import ZERO_OFFSET_SETS
from runtime.cnc.decoder.selection import select_zero_offset
from runtime.cnc.decoder.turning import offset_of
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Group, Key, KeyKind, Values
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import spindle


def _zero_offset(number: int) -> None:
    @g_function(number, Group.ZERO_OFFSET, "isg.g.zero-offset-g53-g59")
    def select(x: Execution, call: GCall) -> None:
        select_zero_offset(x, number - 53)


for _number in range(53, 60):
    _zero_offset(_number)


def _data_set(value: float | None, column: int) -> int:
    """The index of a data set from a computed value."""
    if value is None or not -0.5 <= value < ZERO_OFFSET_SETS - 0.5:
        raise LineError(catalogue.ZERO_OFFSET_INDEX, column, value=value or 0.0, last=ZERO_OFFSET_SETS - 1)
    return round_half_up(value)


@g_function(159, Group.ZERO_OFFSET, "isg.g.zero-offset-g159", syntax="G159=<index>", values=Values.EQUALS)
def extended_zero_offset(x: Execution, call: GCall) -> None:
    select_zero_offset(x, _data_set(call.value, call.column))


@g_function(
    160,
    Group.ARGUMENTS,
    "isg.g.zero-offset-g160",
    modal=False,
    syntax="G160=<index> <axis><0|1> {<axis><0|1>}",
    values=Values.EQUALS,
    axis_arguments=True,
)
def enable_zero_offsets(x: Execution, call: GCall) -> None:
    """0: the offset of the axis is used, 1: it is not. It acts when the data set is selected."""
    index = _data_set(call.value, call.column)
    for axis, flag in x.raw_arguments(160, call.column).items():
        if flag not in (0.0, 1.0):
            assert x.block is not None
            raise LineError(catalogue.FLAG_VALUE, x.block.column(WordKind.AXIS, axis), value=flag)
        x.memory.zero_enabled[index, axis] = 1.0 - flag


@g_function(
    92,
    Group.ARGUMENTS,
    "isg.g.reference-offset-g92",
    modal=False,
    syntax="G92 <axis>.. {<axis>..}",
    axis_arguments=True,
)
def reference_offset(x: Execution, call: GCall) -> None:
    """Absolute with G90, added to what is there with G91."""
    reference = x.coordinates.offsets.reference
    for axis, value in x.arguments(92, call.column).items():
        value = offset_of(x, axis, value)
        reference[axis] = reference[axis] + value if x.modal.incremental else value
    x.coordinates.update()


# ---------------------------------------------------------------------------------------------------- software limits


def _limits(number: int, side: int) -> None:
    @g_function(
        number,
        Group.ARGUMENTS,
        "isg.g.soft-limits-g98-g99",
        "isg.g.soft-limits-extension",
        modal=False,
        syntax=f"G{number} <axis>.. {{<axis>..}}",
        axis_arguments=True,
    )
    def set_limit(x: Execution, call: GCall) -> None:
        """Absolute with G90, added to what is there with G91; back to the configured ones at program start."""
        assert x.block is not None
        for axis, value in x.arguments(number, call.column).items():
            column = x.block.column(WordKind.AXIS, axis)
            limits = x.soft_limits[axis]
            if x.modal.incremental:
                if not math.isfinite(limits[side]):
                    raise LineError(catalogue.LIMIT_OPEN, column, axis=x.setup.axes[axis])
                value += limits[side]
            configured = x.configured_limits[axis][side]
            wider = value < configured if side == 0 else value > configured
            if wider and x.setup.clamp_limits:
                entry = catalogue.LIMIT_CLAMPED_NEGATIVE if side == 0 else catalogue.LIMIT_CLAMPED_POSITIVE
                x.warn(entry, column, axis=x.setup.axes[axis], limit=configured)
                value = configured
            changed = (value, limits[1]) if side == 0 else (limits[0], value)
            if not changed[0] < changed[1]:
                raise LineError(catalogue.LIMITS_REVERSED, column, axis=x.setup.axes[axis])
            x.soft_limits[axis] = changed
        x.emit(SoftwareLimitChange(x.source, tuple(x.soft_limits), tuple(x.limit_behaviour)))


_limits(98, 0)
_limits(99, 1)


# ---------------------------------------------------------------------------------------------------- position preset


def _preset_allowed(x: Execution, call: StatementCall) -> None:
    if x.modal.diameter:
        raise call.error(spindle.PSET_DIAMETER, name=call.syntax.name)
    if any(sign < 0 for sign in (*x.coordinates.mirror_plane, *x.coordinates.mirror_axis)):
        raise call.error(catalogue.PRESET_MIRRORED)


@statement("PSET", "isg.add.pset", syntax="#PSET <axis><value> {<axis><value>}", form=Form.AXES)
def preset(x: Execution, call: StatementCall) -> None:
    """The present position of an axis is the given one from now on; nothing moves.

    Under a rotation a coordinate of the contour lies across both axes of the plane: both get a part of the offset.
    """
    _preset_allowed(x, call)
    c = x.coordinates
    words = {axis: x.axis_value(axis, value) for axis, value in call.axes().items() if value is not None}
    there = c.target(words, False)
    c.offsets.preset = [old + now - end for old, now, end in zip(c.offsets.preset, c.position, there, strict=True)]
    c.update()


@statement("PRESET", "isg.add.preset", syntax="#PRESET {<axis><value>}", form=Form.AXIS_LIST, optional=True)
def preset_no_more(x: Execution, call: StatementCall) -> None:
    """Of the named axes, of all if none is named."""
    _preset_allowed(x, call)
    for axis in call.axes() or range(len(x.setup.axes)):
        x.coordinates.offsets.preset[axis] = 0.0
    x.coordinates.update()


# ---------------------------------------------------------------------------------------------------- left out in a block

_KINDS = ("ZERO", "ADD_ZERO", "PSET", "CLAMP", "TOOL", "MEASURE", "MANUAL")


@statement(
    "SUPPRESS OFFSETS",
    "isg.add.suppress-offsets",
    syntax="#SUPPRESS OFFSETS [ZERO ADD_ZERO PSET CLAMP TOOL MEASURE MANUAL] <axis>.. {<axis>..}",
    form=Form.KEYS,
    keys=tuple(Key(name, KeyKind.FLAG) for name in _KINDS),
    optional=True,
)
def suppress_offsets(x: Execution, call: StatementCall) -> None:
    """The axis words of this block are taken without the named kinds of offsets, without all if none is named."""
    if not x.axis_words:
        raise call.error(catalogue.SUPPRESS_AXES)
    kinds = [argument.name for argument, _ in call if argument.name in _KINDS] or list(_KINDS)
    x.coordinates.suppress(kinds)
