"""<axis>[MODULO ..] and <axis>[POS_LIMIT ..]: how an axis counts, and where it may go (programming manual 30971–31150).

Both hold until the end of the program. Nothing moves: the machine goes on counting as it did, the difference is kept in
`Coordinates.turns`. Software limits are those of the machine's count.
"""

from __future__ import annotations

import math

from runtime.cnc.blocks import LimitBehaviour, SoftwareLimitChange, TakeOver
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.axis_commands import axis_command, chosen
from runtime.cnc.decoder.isg.registry import StatementCall
from runtime.cnc.decoder.modulo import TURN, wrapped
from runtime.cnc.decoder.places import begin_where_axes_are
from runtime.cnc.decoder.systems import expect_unrotated
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Key, KeyKind
from runtime.diagnostics.catalogue import axes as errors
from runtime.diagnostics.catalogue import language as catalogue

_MODES = ("ON", "OFF_POS_INIT", "OFF", "DEFAULT", "SHIFT")
_RANGE = (Key("MIN"), Key("MAX"))


@axis_command(
    "MODULO",
    "isg.axis.modulo-command",
    syntax=("MODULO ON|SHIFT [MIN=..] [MAX=..]", "MODULO OFF|OFF_POS_INIT|DEFAULT"),
    keys=(*(Key(mode, KeyKind.FLAG) for mode in _MODES), *_RANGE),
)
def modulo(x: Execution, call: StatementCall, axis: int) -> None:
    """Counts within a range, or on and on; SHIFT brings the position into the range once and leaves everything as it is."""
    mode = chosen(call, "MODULO", *_MODES)
    expect_unrotated(x, axis, "MODULO", call.column)
    state, c = x.modulo, x.coordinates
    limits = state.last_limits(axis)
    if mode in ("ON", "SHIFT"):
        low, high = (call.number(key, x.shown(axis, old)) for key, old in zip(("MIN", "MAX"), limits, strict=True))
        assert low is not None
        assert high is not None
        limits = x.axis_value(axis, low), x.axis_value(axis, high)
        if not -math.inf < limits[0] < limits[1] < math.inf:
            raise call.error(errors.MODULO_RANGE, axis=x.setup.axes[axis], low=low, high=high)
    elif call.given("MIN") or call.given("MAX"):
        raise LineError(
            catalogue.STATEMENT_ARGUMENTS,
            call.columns("MIN" if call.given("MIN") else "MAX"),
            found="MIN, MAX",
            statement="<axis>[MODULO]",
            syntax=call.syntax.syntax[0],
        )
    if mode == "OFF_POS_INIT":
        begin_where_axes_are(x, TakeOver(x.source), "MODULO OFF_POS_INIT")
        if x.again is not None:
            return  # the place is not known yet
    counted = x.counted(axis, c.position[axis])
    if mode == "OFF_POS_INIT":  # the position of the axis itself, which counts as it is described
        counted = wrapped(c.position[axis], 0.0, TURN) if axis in state.configured else c.position[axis]
    if mode == "ON":
        state.ranges[axis] = state.limits[axis] = limits
    elif mode == "DEFAULT" and axis in state.configured:
        state.ranges[axis] = state.limits[axis] = (0.0, TURN)
    elif mode != "SHIFT":
        state.ranges.pop(axis, None)
    counted = wrapped(counted, *limits) if mode == "SHIFT" else state.shown(axis, counted)
    c.turns[axis] = c.position[axis] - counted
    c.update()


_BEHAVIOURS = tuple(behaviour.name for behaviour in LimitBehaviour)


@axis_command(
    "POS_LIMIT",
    "isg.axis.pos-limit",
    syntax=(f"POS_LIMIT ON [MIN=..] [MAX=..] [BEHAVIOUR={'|'.join(_BEHAVIOURS)}]", "POS_LIMIT OFF|DEFAULT"),
    keys=(
        *(Key(mode, KeyKind.FLAG) for mode in ("ON", "OFF", "DEFAULT")),
        *_RANGE,
        Key("BEHAVIOUR", KeyKind.WORD, words=_BEHAVIOURS),
    ),
)
def position_limit(x: Execution, call: StatementCall, axis: int) -> None:
    """Software limits in machine coordinates, and what happens beyond them: ERROR before the motion, ERROR_LR when the axis
    is there, WARNING nothing but a warning."""
    mode = chosen(call, "POS_LIMIT", "ON", "OFF", "DEFAULT")
    limits, behaviour = x.configured_limits[axis], LimitBehaviour.ERROR
    if mode == "OFF":
        limits = (-math.inf, math.inf)
    elif mode == "ON":
        kept = x.last_limits.get(axis, limits)
        low, high = call.number("MIN"), call.number("MAX")
        limits = (
            kept[0] if low is None else x.axis_value(axis, low),
            kept[1] if high is None else x.axis_value(axis, high),
        )
        if not limits[0] < limits[1]:
            raise call.error(catalogue.LIMITS_REVERSED, axis=x.setup.axes[axis])
        behaviour = LimitBehaviour[call.text("BEHAVIOUR", "ERROR") or "ERROR"]
        x.last_limits[axis] = limits
    x.soft_limits[axis] = limits
    x.limit_behaviour[axis] = behaviour
    x.emit(SoftwareLimitChange(x.source, tuple(x.soft_limits), tuple(x.limit_behaviour)))
