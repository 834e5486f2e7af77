"""#TRC: the options of tool radius compensation (programming manual 20033–20878)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import ApproachSplit
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import radius as catalogue

_SWITCHES: dict[str, str] = {
    "REVERSE": "reverse",
    "IGNORE_CONT_DAMAGE": "ignore_damage",
    "EXT_ANGLE_BLOCK_INTERSECTION": "extended_limit",
    "PERPENDICULAR_RADIUS_CHANGE": "perpendicular_change",
    "G236_LIN": "line_on_path",
    "SUPPRESS_TRC": "suppress",
}
_UNSUPPORTED = (
    "ONLINE",
    "ONLINE_BY_VECTOR",
    "INVERSE",
    "DYNAMIC_VARIATION_MAX_OFFSET",
    "TAPERLINK",
    "GEN_CIR_BLOCK_IN_CORNER",
    "CONV_CIR_TO_LIN",
    "KERF_MASKING",
    "REMOVE_MASKED_BLOCKS",
)
_SPLITS = ("SPLIT", "SPLIT_PATH", "SPLIT_OFF")
_ENDS = ("PRE", "POST", "COMBINED")
_PARTS = ("DIST_SEG1", "FEED_SEG1", "DIST_SEG2", "FEED_SEG2")


@statement(
    "TRC",
    "isg.trc.options-command",
    "isg.trc.opt-reverse",
    "isg.trc.opt-ignore-cont-damage",
    "isg.trc.opt-ext-angle",
    "isg.trc.opt-stretch-factor",
    "isg.trc.opt-perpendicular-radius-change",
    "isg.trc.opt-split",
    "isg.trc.opt-g236-lin",
    "isg.trc.opt-tangential-limit",
    "isg.trc.opt-suppress-trc",
    syntax="#TRC [<option>=.. {<option>=..}]",
    form=Form.KEYS,
    keys=(
        *(Key(name) for name in (*_SWITCHES, "STRETCH_FACTOR", "TANGENTIAL_LIMIT", *_UNSUPPORTED)),
        Key("MULTI_PATH_RADIUS", KeyKind.WORD, ("INDIVIDUAL", "DEFAULT", "REFERENCE", "SECONDARY")),
        *(Key(name, KeyKind.FLAG) for name in (*_SPLITS, *_ENDS)),
        Key("AX", KeyKind.AXIS),
        Key("AXNR"),
        *(Key(name) for name in _PARTS),
    ),
    modal=True,
    continued=True,
)
def options(x: Execution, call: StatementCall) -> None:
    """What is not named stays as it is; a new program begins with the defaults."""
    settings = x.modal.compensation
    for argument, value in call:
        name = argument.name
        if name == "ONLINE" and value and not call.number("INVERSE"):
            raise call.error(catalogue.ONLINE_WITHOUT_INVERSE, name, value=value)
        if _absent(call, name, value):
            raise call.error(catalogue.OPTION_UNSUPPORTED, name, option=name)
        if name in _SWITCHES:
            change: dict[str, Any] = {_SWITCHES[name]: _switch(call, name, value)}
            settings = replace(settings, **change)
        elif name == "STRETCH_FACTOR":
            settings = replace(settings, stretch=_stretch(x, call, value))
        elif name == "TANGENTIAL_LIMIT" and not 0.1 <= value <= 3.0:
            raise call.error(catalogue.OPTION_VALUE, name, option=name, value=value, allowed="0.1 to 3 degrees")
    x.modal.compensation = replace(settings, split=_split(x, call, settings.split))
    x.compensation.follow(x)


def _absent(call: StatementCall, name: str, value: float | None) -> bool:
    """Whether an option asks for what this control does not have."""
    if name == "MULTI_PATH_RADIUS":
        return call.text(name) not in ("INDIVIDUAL", "DEFAULT")
    return name in _UNSUPPORTED and value != 0.0


def _split(x: Execution, call: StatementCall, before: ApproachSplit | None) -> ApproachSplit | None:
    """SPLIT, SPLIT_PATH, SPLIT_OFF with what belongs to them."""
    kinds = [name for name in _SPLITS if call.given(name)]
    ends = [name for name in _ENDS if call.given(name)]
    others = [name for name in (*_ENDS, *_PARTS, "AX", "AXNR") if call.given(name)]
    if len(kinds) > 1 or len(ends) > 1:
        raise call.error(catalogue.SPLIT_WRITTEN, (kinds + ends)[-1], why=f"only one of {', '.join(kinds + ends)}")
    if not kinds or kinds[0] == "SPLIT_OFF":
        if others:
            raise call.error(catalogue.SPLIT_WRITTEN, others[0], why=f"{others[0]} without SPLIT or SPLIT_PATH")
        return None if kinds else before
    parts = [call.number(name) for name in _PARTS]
    for name, value in zip(_PARTS, parts, strict=True):
        if value is not None and not 0.0 < value < math.inf:
            raise call.error(catalogue.OPTION_VALUE, name, option=name, value=value, allowed="a number above 0")
    given = [value for value in parts if value is not None]
    if parts[:2].count(None) or len(given) % 2:
        missing = next(name for name, value in zip(_PARTS, parts, strict=True) if value is None)
        raise call.error(catalogue.SPLIT_WRITTEN, kinds[0], why=f"{missing} is missing")
    axis = _split_axis(x, call, kinds[0] == "SPLIT")
    end = ends[0] if ends else "PRE"
    return ApproachSplit(tuple(given[::2]), tuple(given[1::2]), axis, end != "POST", end != "PRE")


def _split_axis(x: Execution, call: StatementCall, needed: bool) -> int | None:
    """The axis of the plane along which the segments are measured, by its name or its logical number."""
    named, number = call.argument("AX"), call.number("AXNR")
    if (named is not None) + (number is not None) != needed:
        why = "it needs AX or AXNR" if needed else "SPLIT_PATH takes no axis"
        raise call.error(catalogue.SPLIT_WRITTEN, "SPLIT" if needed else "SPLIT_PATH", why=why)
    if not needed:
        return None
    if named is not None:
        axis = named.index
    elif number in x.setup.log_axes:
        axis = x.setup.log_axes.index(int(number))
    else:
        raise call.error(catalogue.SPLIT_WRITTEN, "AXNR", why="no axis of the channel has this number")
    if axis not in PLANE_AXES[x.modal.plane]:
        key = "AX" if named is not None else "AXNR"
        raise call.error(catalogue.SPLIT_WRITTEN, key, why="the axis does not lie in the plane")
    return axis


def _switch(call: StatementCall, name: str, value: float) -> bool:
    if value not in (0.0, 1.0):
        raise call.error(catalogue.OPTION_VALUE, name, option=name, value=value, allowed="0 or 1")
    return value == 1.0


def _stretch(x: Execution, call: StatementCall, value: float) -> float:
    if 1.0 <= value <= 9.0:
        return value
    x.warn(catalogue.STRETCH_RANGE, call.columns("STRETCH_FACTOR"), value=value)
    return 1.0
