"""G61, G261, G260 and #CONTOUR MODE (programming manual 9569–10580)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import ContourAction, ContourChange, Contouring, ContourMethod
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, StatementHandler, g_function, statement, variable
from runtime.cnc.decoder.smoothing import select_contouring
from runtime.cnc.language.isg.syntax import Form, Group, Key, KeyKind
from runtime.diagnostics.catalogue import smoothing as catalogue
from runtime.diagnostics.catalogue.coordinates import ROTATED_POINT

_SPEC = ("isg.smooth.contour-mode-command", "isg.smooth.contour-dev", "isg.smooth.contour-dist")
_METHODS = {method.value: method for method in ContourMethod}
_REFUSED = ("DIST_MASTER",)  # methods that this version does not have
_ACTIONS = {action.value: action for action in ContourAction}
_COMMON = {"PRE_ACTION", "INTER_ACTION", "POST_ACTION", "CHECK_JERK", "CONST_VEL"}
_RELEVANT = {"RELEVANT_PATH", "RELEVANT_TRACK", "TRACK_DEV", "REMAIN_PART", "MAX_ANGLE"}
_ALLOWED = {
    ContourMethod.DEVIATION: {"PATH_DEV", *_RELEVANT, *_COMMON},
    ContourMethod.DISTANCE: {"PRE_DIST", "POST_DIST", *_RELEVANT, *_COMMON},
    ContourMethod.SOFT: {"PATH_DIST", "TRACK_DIST", "ACC_MAX", "ACC_MIN", "RAMP_TIME", "DIST_WEIGHT"},
    ContourMethod.WHOLE: {"PATH_DEV", "PATH_DIST", "MERGE", *(action.value for action in ContourAction)},
    ContourMethod.POINT: {"PRE_DIST", "POST_DIST", "X", "Y", "Z", *_COMMON},
}
_KEYS = (
    *(Key(name, KeyKind.FLAG) for name in (*_METHODS, *_REFUSED, *_ACTIONS)),
    *(Key(name) for name in sorted(set().union(*_ALLOWED.values()) - _ACTIONS.keys())),
    Key("SYM_DIST"),
)
_SYNTAX = (
    "[DEV [PATH_DEV=..] [RELEVANT_PATH=..] [TRACK_DEV=..] [RELEVANT_TRACK=..] [REMAIN_PART=..] [MAX_ANGLE=..] <further>]",
    "[DIST [PRE_DIST=..] [POST_DIST=..] [RELEVANT_PATH=..] [TRACK_DEV=..] [RELEVANT_TRACK=..] [REMAIN_PART=..] <further>]",
    "[DIST_SOFT [PATH_DIST=..] [TRACK_DIST=..] [ACC_MAX=..] [ACC_MIN=..] [RAMP_TIME=..]]",
    "[PTP [PATH_DEV=..] [PATH_DIST=..] [MERGE=0|1]]",
    "[POS [PRE_DIST=..] [POST_DIST=..] [X..] [Y..] [Z..] <further>]",
)


# ---------------------------------------------------------------------------------------------------- G functions


@g_function(61, Group.CONTOURING, "isg.smooth.contour-select", "isg.g.polynomial-contouring", modal=False)
def contour_here(x: Execution, call: GCall) -> None:
    x.emit(ContourChange(x.source, x.smoothing.contouring, once=True))


@g_function(261, Group.CONTOURING, "isg.smooth.contour-select", "isg.g.polynomial-contouring")
def contour_on(x: Execution, call: GCall) -> None:
    select_contouring(x, True)


@g_function(260, Group.CONTOURING, "isg.smooth.contour-select", "isg.g.polynomial-contouring")
def contour_off(x: Execution, call: GCall) -> None:
    """Beside a motion only its own end is concerned, alone also that of the motion before."""
    block = x.block
    motion = block is not None and bool(block.axes or block.interpolation or block.additions)
    select_contouring(x, False, keeps=motion)


_NUMBER = {
    ContourMethod.DISTANCE: 3,
    ContourMethod.DEVIATION: 4,
    ContourMethod.POINT: 5,
    ContourMethod.SOFT: 6,
    ContourMethod.WHOLE: 7,
}


@variable(
    "V.G.CONT_MODE_ACTIVE", "isg.var.g-active-flags", "with G261: 3 DIST, 4 DEV, 5 POS, 6 DIST_SOFT, 7 PTP; 0 with G260"
)
def contour_method(x: Execution) -> float:
    return float(_NUMBER[x.smoothing.contouring.method]) if x.modal.contouring else 0.0


# ---------------------------------------------------------------------------------------------------- #CONTOUR MODE


def _statement(name: str, on: bool | None) -> StatementHandler:
    @statement(
        name, *_SPEC, "isg.smooth.contour-dist-soft", "isg.smooth.contour-pos", "isg.smooth.contour-ptp",
        syntax=tuple(f"#{name} {syntax}" for syntax in _SYNTAX), form=Form.KEYS, keys=_KEYS, optional=on is not None,
    )  # fmt: skip
    def contour_mode(x: Execution, call: StatementCall) -> None:
        state = x.smoothing
        state.contouring = settings_of(x, call, state.contouring)
        if on is not None:
            select_contouring(x, on, keeps=on)
        elif x.modal.contouring:
            select_contouring(x, True)

    return contour_mode


_statement("CONTOUR MODE", None)
_statement("CONTOUR MODE ON", True)
_statement("CONTOUR MODE OFF", False)


def settings_of(x: Execution, call: StatementCall, now: Contouring) -> Contouring:
    """The settings after a #CONTOUR MODE: what it does not name stays. LineError for wrong ones."""
    methods = [name for name in (*_METHODS, *_REFUSED) if call.given(name)]
    actions = [name for name in _ACTIONS if call.given(name)]
    for words in (methods, actions):
        if len(words) > 1:
            raise call.error(catalogue.CHOOSE_ONE, words[1], first=words[0], second=words[1])
    for name in _REFUSED:
        if call.given(name):
            raise call.error(catalogue.METHOD_UNSUPPORTED, name, method=name)
    method = _METHODS[methods[0]] if methods else now.method
    for argument, _ in call:
        if argument.name not in _ALLOWED[method] and argument.name not in methods:
            raise call.error(
                catalogue.OF_OTHER_METHOD,
                argument.name,
                key=argument.name,
                method=method.value,
                known=", ".join(sorted(_ALLOWED[method])),
            )
    changes: dict[str, Any] = {"method": method}
    if actions:
        changes["action"] = _ACTIONS[actions[0]]
    soft = method is ContourMethod.SOFT
    for name, field, least, most, scale in _NUMBERS:
        value = call.number(name)
        if value is None or not call.given(name):
            continue
        if soft and value == -1 and name in ("PATH_DIST", "TRACK_DIST"):
            changes[field] = math.inf
            continue
        if not least <= value <= most:
            raise call.error(catalogue.VALUE_RANGE, name, key=name, value=value, least=least, most=most)
        changes[field] = value * (length_unit(x) if name in _LENGTHS else scale)
    if call.given("DIST_WEIGHT") and call.number("DIST_WEIGHT") != 0:
        raise call.error(catalogue.METHOD_UNSUPPORTED, "DIST_WEIGHT", method="DIST_WEIGHT")
    if soft and "before" in changes and "tracking_distance" not in changes and not x.smoothing.own_track_distance:
        changes["tracking_distance"] = changes["before"]
    x.smoothing.own_track_distance |= call.given("TRACK_DIST")
    if "check_jerk" in changes:
        changes["check_jerk"] = round(changes["check_jerk"])
    if call.given("CONST_VEL"):
        changes["constant_velocity"] = bool(call.number("CONST_VEL"))
    if method is ContourMethod.WHOLE:
        _whole_contour(call, changes)
    if method is ContourMethod.POINT:
        changes["point"] = _point(x, call, now)
    made = replace(now, **changes)
    if soft and made.least_acceleration > made.greatest_acceleration:
        raise call.error(catalogue.ACCELERATION_ORDER, "ACC_MIN")
    return made


def _whole_contour(call: StatementCall, changes: dict[str, Any]) -> None:
    """PTP has limits of its own: what is programmed last holds, deviation, distance or both."""
    if call.given("MERGE"):  # the path is driven through tangential borders anyway
        value = call.needed("MERGE")
        if value not in (0.0, 1.0):
            raise call.error(catalogue.VALUE_RANGE, "MERGE", key="MERGE", value=value, least=0.0, most=1.0)
    limits = {"whole_deviation": changes.pop("deviation", math.inf), "whole_distance": changes.pop("before", math.inf)}
    if call.given("PATH_DEV") or call.given("PATH_DIST"):
        changes |= limits


# key, field, range, and what a unit of it is inside
_NUMBERS = (
    ("PATH_DEV", "deviation", 0.0, 1e6, 1.0),
    ("PRE_DIST", "before", 0.0, 1e6, 1.0),
    ("POST_DIST", "behind", 0.0, 1e6, 1.0),
    ("PATH_DIST", "before", 0.0, 1e6, 1.0),
    ("TRACK_DIST", "tracking_distance", 0.0, 1e6, 1.0),
    ("TRACK_DEV", "tracking_deviation", 0.0, 1e6, 1.0),
    ("RELEVANT_PATH", "relevant", 0.0, 1e6, 1.0),
    ("RELEVANT_TRACK", "relevant_tracking", 0.0, 1e6, 1.0),
    ("REMAIN_PART", "remain", 0.0, 100.0, 0.01),
    ("MAX_ANGLE", "greatest_angle", 0.0, 180.0, 1.0),
    ("ACC_MAX", "greatest_acceleration", 0.1, 100.0, 0.01),
    ("ACC_MIN", "least_acceleration", 0.1, 100.0, 0.01),
    ("RAMP_TIME", "ramp_time", 0.0, 10_000.0, 0.01),
    ("CHECK_JERK", "check_jerk", 0.0, 2.0, 1.0),
)
_LENGTHS = frozenset({"PATH_DEV", "PRE_DIST", "POST_DIST", "PATH_DIST", "RELEVANT_PATH"})


def length_unit(x: Execution) -> float:
    """mm per programmed unit: inch under G70 with P-CHAN-00439 only."""
    return x.length(1.0) if x.setup.contouring_inch else 1.0


def _point(x: Execution, call: StatementCall, now: Contouring) -> tuple[float | None, float | None, float | None]:
    """The interim point in machine coordinates; main axes that are not named keep theirs, or take that of the corner."""
    point = list(now.point)
    frame = x.coordinates.frame
    if frame is not None and any(call.given(name) for name in "XYZ"):
        given = [call.number(name) if call.given(name) else None for name in "XYZ"]
        words = {axis: x.axis_value(axis, value) for axis, value in enumerate(given) if value is not None}
        if len(words) < len(given):
            raise call.error(ROTATED_POINT)
        first, second, third = x.coordinates.machine(x.coordinates.target(words, False))[:3]
        return first, second, third
    for axis, name in enumerate("XYZ"):
        value = call.number(name) if call.given(name) else None
        if value is not None and axis < len(x.setup.axes):
            point[axis] = x.coordinates.target({axis: x.axis_value(axis, value)}, False)[axis]
    return point[0], point[1], point[2]
