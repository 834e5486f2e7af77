"""#SLOPE, #VECTOR LIMIT, #TRANSVELMIN, #DYNAMIC WEIGHT, #OVERRIDE, #FF.

Programming manual 13579–13668, 15726–15920, 17054–17082, 17909–17972.
"""

from __future__ import annotations

import math
from dataclasses import replace

from runtime.cnc.decoder.dynamics import change_dynamics, set_dynamics
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.modal import INCH
from runtime.cnc.dynamic_settings import Slope, VectorLimits
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

_SLOPE = "isg.add.slope"
_LIMIT_ON, _LIMIT_OFF = "isg.add.vector-limit-on", "isg.add.vector-limit-off"


# ---------------------------------------------------------------------------------------------------- slope


@statement(
    "SLOPE",
    _SLOPE,
    syntax=("#SLOPE [TYPE=STEP|TRAPEZ|SIN2|HSC [NO_OPT=0|1]]", "#SLOPE DEFAULT"),
    form=Form.KEYS,
    keys=(Key("TYPE", KeyKind.WORD, tuple(slope.name for slope in Slope), needed=True), Key("NO_OPT")),
    aliases=("SET SLOPE PROFIL",),
)
def slope(x: Execution, call: StatementCall) -> None:
    """NO_OPT is taken and changes nothing: jerk is always used as well as the limits allow."""
    if call.number("NO_OPT", 1.0) not in (0.0, 1.0):
        raise call.error(catalogue.FLAG_VALUE, "NO_OPT", value=call.needed("NO_OPT"))
    change_dynamics(x, slope=Slope[call.text("TYPE") or ""])


@statement("SLOPE DEFAULT", _SLOPE)
def default_slope(x: Execution, call: StatementCall) -> None:
    """That of P-CHAN-00071."""
    change_dynamics(x, slope=x.setup.dynamics.slope)


# ---------------------------------------------------------------------------------------------------- path limits

# key of the statement → field of VectorLimits; lengths per min² or s² by P-CHAN-00351, per min, per s³
_ACCELERATIONS = {
    "ACC": "acceleration",
    "DEC": "deceleration",
    "RADIAL_ACC": "radial_acceleration",
    "RADIAL_JERK": "radial_jerk",
    "TRANS_ACC": "transition_acceleration",
}
_FIELDS = {**_ACCELERATIONS, "JERK": "jerk", "VEL": "velocity"}


def _in_seconds(x: Execution, key: str, value: float) -> float:
    """A programmed limit in mm and s."""
    value = x.length(value)
    if key == "VEL":
        return value / 60.0
    if key in _ACCELERATIONS and not x.setup.vector_per_second:
        return value / (60.0**3 if key == "RADIAL_JERK" else 3600.0)
    return value


def _limit(x: Execution, call: StatementCall, key: str) -> float:
    if call.argument(key) is None:
        return float(getattr(x.setup.vector_limits, _FIELDS[key]))
    value = call.number(key)
    if value is None:
        return float(getattr(x.setup.vector_limits, _FIELDS[key]))
    if not 0.0 < value < math.inf:
        raise call.error(catalogue.LIMIT_INVALID, key, key=key, value=value)
    return _in_seconds(x, key, value)


def _set_limits(x: Execution, call: StatementCall, keys: tuple[str, ...]) -> None:
    chosen = {_FIELDS[key]: _limit(x, call, key) for key in keys}
    feed, rapid = call.given("FEED"), call.given("RAPID")
    settings = x.dynamics
    for moves in (False, True):
        if (rapid if moves else feed) or feed == rapid:
            held = settings.of(moves)
            settings = settings.with_moves(moves, replace(held, vector=replace(held.vector, **chosen)))
    set_dynamics(x, settings)


_LIMIT_KEYS = tuple(Key(name, KeyKind.SWITCH) for name in _FIELDS)


@statement(
    "VECTOR LIMIT ON",
    _LIMIT_ON,
    syntax="#VECTOR LIMIT ON [ACC[=..] DEC[=..] RADIAL_ACC[=..] RADIAL_JERK[=..] JERK[=..] TRANS_ACC[=..] VEL[=..] FEED RAPID]",
    form=Form.KEYS,
    keys=(*_LIMIT_KEYS, Key("FEED", KeyKind.FLAG), Key("RAPID", KeyKind.FLAG)),
    continued=True,
)
def limits_on(x: Execution, call: StatementCall) -> None:
    """A key without value takes that of the channel parameters, or none."""
    keys = tuple(name for name in _FIELDS if call.given(name))
    if not keys:
        raise call.error(catalogue.KEY_MISSING, key="ACC, DEC, VEL or another limit", statement="#VECTOR LIMIT ON",
                         syntax=call.syntax.syntax[0])  # fmt: skip
    _set_limits(x, call, keys)


@statement("VECTOR LIMIT ON ALL", _LIMIT_ON)
def all_limits_on(x: Execution, call: StatementCall) -> None:
    _set_limits(x, call, tuple(_FIELDS))


@statement(
    "VECTOR LIMIT OFF",
    _LIMIT_OFF,
    syntax="#VECTOR LIMIT OFF [ACC DEC RADIAL_ACC RADIAL_JERK JERK TRANS_ACC VEL]",
    form=Form.KEYS,
    keys=tuple(Key(name, KeyKind.FLAG) for name in _FIELDS),
    continued=True,
)
def limits_off(x: Execution, call: StatementCall) -> None:
    """For moves at feed and rapid ones."""
    keys = [name for name in _FIELDS if call.given(name)]
    if not keys:
        raise call.error(catalogue.KEY_MISSING, key="ACC, DEC, VEL or another limit", statement="#VECTOR LIMIT OFF",
                         syntax=call.syntax.syntax[0])  # fmt: skip
    settings = x.dynamics
    for rapid in (False, True):
        held = settings.of(rapid)
        vector = replace(held.vector, **{_FIELDS[key]: math.inf for key in keys})
        settings = settings.with_moves(rapid, replace(held, vector=vector))
    set_dynamics(x, settings)


@statement("VECTOR LIMIT OFF ALL", _LIMIT_OFF)
def all_limits_off(x: Execution, call: StatementCall) -> None:
    settings = x.dynamics
    for rapid in (False, True):
        settings = settings.with_moves(rapid, replace(settings.of(rapid), vector=VectorLimits()))
    set_dynamics(x, settings)


@statement(
    "TRANSVELMIN ON",
    "isg.add.transvelmin",
    syntax="#TRANSVELMIN ON [<velocity>]",
    form=Form.VALUE,
    optional=True,
)
def least_transition(x: Execution, call: StatementCall) -> None:
    """In mm/min; corners of lines and arcs are not passed more slowly."""
    value = call.number() or 0.0
    if not 0.0 <= value < math.inf:
        raise call.error(catalogue.FEED_INVALID, value=value)
    change_dynamics(x, least_transition=value * (INCH if x.modal.inch else 1.0) / 60.0)


@statement("TRANSVELMIN OFF", "isg.add.transvelmin")
def no_least_transition(x: Execution, call: StatementCall) -> None:
    change_dynamics(x, least_transition=0.0)


# ---------------------------------------------------------------------------------------------------- weights


def _weighting(state: str) -> None:
    @statement(
        f"DYNAMIC WEIGHT {state}",
        "isg.add.dynamic-weight",
        syntax=f"#DYNAMIC WEIGHT {state} [PATH CURVE]",
        form=Form.KEYS,
        keys=(Key("PATH", KeyKind.FLAG), Key("CURVE", KeyKind.FLAG)),
    )
    def switch(x: Execution, call: StatementCall) -> None:
        """The weights by path length and by radius that the channel parameters have."""
        on = state == "ON"
        if not (call.given("PATH") or call.given("CURVE")):
            raise call.error(catalogue.KEY_MISSING, key="PATH or CURVE", statement="#" + call.syntax.name,
                             syntax=call.syntax.syntax[0])  # fmt: skip
        if call.given("PATH"):
            change_dynamics(x, path_weights=(x.setup.dynamics.path_weights or 3) if on else 0)
        if call.given("CURVE"):
            change_dynamics(x, curve_weights=on)


_weighting("ON")
_weighting("OFF")


# ---------------------------------------------------------------------------------------------------- overrides

_LEAST_OVERRIDE, _GREATEST_OVERRIDE = 0.1, 200.0  # percent


@statement(
    "OVERRIDE",
    "isg.add.override",
    syntax="#OVERRIDE [FEED_FACT=.. RAPID_FACT=..]",
    form=Form.KEYS,
    keys=(Key("FEED_FACT"), Key("RAPID_FACT")),
    continued=True,
)
def override(x: Execution, call: StatementCall) -> None:
    """On top of that of operator and PLC; a factor that is not given stays."""
    settings = x.dynamics
    for key, rapid in (("FEED_FACT", False), ("RAPID_FACT", True)):
        value = call.number(key)
        if value is not None:
            settings = settings.with_moves(
                rapid, replace(settings.of(rapid), override=override_share(call, key, value))
            )
    set_dynamics(x, settings)


def override_share(call: StatementCall, key: str, value: float) -> float:
    """A programmed override as a factor; LineError outside 0.1…200 %."""
    if not _LEAST_OVERRIDE <= value <= _GREATEST_OVERRIDE:
        raise call.error(catalogue.OVERRIDE_RANGE, key, value=value, least=_LEAST_OVERRIDE, most=_GREATEST_OVERRIDE)
    return value / 100.0


_FF_LEAST, _FF_GREATEST = 0.1, 1_000_000.0  # percent


@statement("FF", "isg.add.ff", syntax="#FF = <percent>", form=Form.VALUE)
def external_feed(x: Execution, call: StatementCall) -> None:
    """Weights a feed that the PLC commands, and only that; a value out of range is taken as the nearest one."""
    value = call.needed()
    if not math.isfinite(value):
        raise call.error(catalogue.WEIGHT_INVALID, value=value)
    change_dynamics(x, external_feed=min(max(value, _FF_LEAST), _FF_GREATEST) / 100.0)
