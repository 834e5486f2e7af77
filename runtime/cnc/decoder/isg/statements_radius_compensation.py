"""#TRC: the options of tool radius compensation (programming manual 20033–20878)."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import CompensationSettings, Segments
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import radius as catalogue

_SWITCHES: dict[str, str] = {
    "CONV_CIR_TO_LIN": "convert_arcs",
    "KERF_MASKING": "kerf_masking",
    "REVERSE": "reverse",
    "IGNORE_CONT_DAMAGE": "ignore_damage",
    "REMOVE_MASKED_BLOCKS": "remove_masked",
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
)
_LATER = ("CONV_CIR_TO_LIN", "KERF_MASKING", "REMOVE_MASKED_BLOCKS", "SPLIT", "SPLIT_PATH")
_FLAGS = ("SPLIT", "SPLIT_PATH", "SPLIT_OFF", "PRE", "POST", "COMBINED")
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
    syntax=(
        "#TRC [<option>=.. {<option>=..}]",
        "#TRC [SPLIT PRE|POST|COMBINED AX=<axis>|AXNR=.. DIST_SEG1=.. FEED_SEG1=.. {DIST_SEG2=.. FEED_SEG2=..}]",
        "#TRC [SPLIT_PATH PRE|POST|COMBINED DIST_SEG1=.. FEED_SEG1=.. {DIST_SEG2=.. FEED_SEG2=..}]",
        "#TRC [SPLIT_OFF]",
    ),
    form=Form.KEYS,
    keys=(
        *(Key(name) for name in (*_SWITCHES, "STRETCH_FACTOR", "TANGENTIAL_LIMIT", *_UNSUPPORTED)),
        Key("MULTI_PATH_RADIUS", KeyKind.WORD, ("INDIVIDUAL", "DEFAULT", "REFERENCE", "SECONDARY")),
        *(Key(name, KeyKind.FLAG) for name in _FLAGS),
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
    x.modal.compensation = _segments(x, call, settings)
    x.compensation.follow(x)


def _absent(call: StatementCall, name: str, value: float) -> bool:
    """Whether an option asks for what this control does not have."""
    if name == "MULTI_PATH_RADIUS":
        return call.text(name) not in ("INDIVIDUAL", "DEFAULT")
    return name in (*_UNSUPPORTED, *_LATER) and value != 0.0


def _switch(call: StatementCall, name: str, value: float) -> bool:
    if value not in (0.0, 1.0):
        raise call.error(catalogue.OPTION_VALUE, name, option=name, value=value, allowed="0 or 1")
    return value == 1.0


def _stretch(x: Execution, call: StatementCall, value: float) -> float:
    if 1.0 <= value <= 9.0:
        return value
    x.warn(catalogue.STRETCH_RANGE, call.columns("STRETCH_FACTOR"), value=value)
    return 1.0


def _segments(x: Execution, call: StatementCall, settings: CompensationSettings) -> CompensationSettings:
    """SPLIT, SPLIT_PATH and SPLIT_OFF."""
    if call.given("SPLIT_OFF"):
        return replace(settings, segments=None)
    if not (call.given("SPLIT") or call.given("SPLIT_PATH")):
        return settings
    needed: Callable[[str], float] = call.needed
    first = x.length(needed("DIST_SEG1")), x.length(needed("FEED_SEG1"))
    second = None
    if call.given("DIST_SEG2") or call.given("FEED_SEG2"):
        second = x.length(needed("DIST_SEG2")), x.length(needed("FEED_SEG2"))
    for name in _PARTS:
        value = call.number(name)
        if value is not None and not value > 0.0:
            raise call.error(catalogue.OPTION_VALUE, name, option=name, value=value, allowed="a value above 0")
    post, both = call.given("POST"), call.given("COMBINED")
    axis = _axis(x, call) if call.given("SPLIT") else None
    return replace(settings, segments=Segments(both or not post, both or post, axis, first, second))


def _axis(x: Execution, call: StatementCall) -> int:
    """The axis along which the lengths are measured: one of the main axes."""
    argument = call.argument("AX")
    if argument is not None:
        return argument.index
    number = call.needed("AXNR")
    if number not in x.setup.log_axes:
        known = ", ".join(f"{name} {n}" for name, n in zip(x.setup.axes, x.setup.log_axes, strict=False))
        raise call.error(language.LOGICAL_AXIS, "AXNR", value=number, known=f"axes of the channel: {known}")
    return x.setup.log_axes.index(int(number))
