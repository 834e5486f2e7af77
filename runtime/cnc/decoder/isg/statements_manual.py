"""# statements of manual mode: stages of handwheel and keys, limits, and the offsets that came of it (manual 5711–6066).

Resolutions are programmed per turn of the handwheel and handed over per pulse.
"""

from __future__ import annotations

from runtime.cnc.blocks import ManualParameter, ManualValue
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

PULSES_PER_TURN = 100  # of a handwheel

_PARAMETERS = "isg.g.manual-parameters"
_LIMITS = "isg.g.manual-limits"
_OFFSETS = "isg.g.request-manual-offsets"
_STAGES = (1, 2, 3)
_AXIS = (Key("AX", KeyKind.AXIS), Key("AXNR"))


def _axis(x: Execution, call: StatementCall) -> int:
    """The axis by its name or its logical number."""
    if call.given("AX") == call.given("AXNR"):
        raise call.error(catalogue.MANUAL_AXIS, statement="#" + call.syntax.name)
    named = call.argument("AX")
    if named is not None:
        return named.index
    number = call.needed("AXNR")
    if number not in x.setup.log_axes:
        known = ", ".join(f"{name} {n}" for name, n in zip(x.setup.axes, x.setup.log_axes, strict=False))
        raise call.error(catalogue.LOGICAL_AXIS, "AXNR", value=number, known=f"axes of the channel: {known or 'none'}")
    return x.setup.log_axes.index(int(number))


def _closed_axis(x: Execution, call: StatementCall) -> int:
    """An axis that is not in manual mode."""
    axis = _axis(x, call)
    if axis in x.manual_axes:
        name = "#" + call.syntax.name
        raise call.error(catalogue.MANUAL_ACTIVE, statement=name, axis=x.setup.axes[axis])
    return axis


def _above_zero(call: StatementCall, key: str) -> float | None:
    value = call.number(key)
    if value is not None and not 0.0 < value < float("inf"):
        raise call.error(catalogue.MANUAL_STAGE, key, statement="#" + call.syntax.name, key=key, value=value)
    return value


def _feed(x: Execution, axis: int, value: float) -> float:
    """A programmed feed in mm/s or degrees/s."""
    return x.axis_value(axis, value) * (x.setup.feed_factor if x.setup.linear[axis] else 1.0) / 60.0


@statement(
    "HANDWHEEL",
    _PARAMETERS,
    syntax="#HANDWHEEL [AX=<axis> | AXNR=.. RES1=.. {RES2=.. RES3=..}]",
    form=Form.KEYS,
    keys=(*_AXIS, *(Key(f"RES{i}", needed=i == 1) for i in _STAGES)),
    aliases=("SET HR",),
)
def handwheel(x: Execution, call: StatementCall) -> None:
    axis = _closed_axis(x, call)
    for stage in _STAGES:
        way = _above_zero(call, f"RES{stage}")
        if way is not None:
            per_pulse = x.axis_value(axis, way) / PULSES_PER_TURN
            x.emit(ManualParameter(x.source, axis, ManualValue.HANDWHEEL, stage, per_pulse))


@statement(
    "JOG CONT",
    _PARAMETERS,
    syntax="#JOG CONT [AX=<axis> | AXNR=.. FEED1=.. {FEED2=.. FEED3=..}]",
    form=Form.KEYS,
    keys=(*_AXIS, *(Key(f"FEED{i}", needed=i == 1) for i in _STAGES)),
    aliases=("SET TIP",),
)
def continuous(x: Execution, call: StatementCall) -> None:
    axis = _closed_axis(x, call)
    for stage in _STAGES:
        feed = _above_zero(call, f"FEED{stage}")
        if feed is not None:
            x.emit(ManualParameter(x.source, axis, ManualValue.CONTINUOUS, stage, _feed(x, axis, feed)))


@statement(
    "JOG INCR",
    _PARAMETERS,
    syntax="#JOG INCR [AX=<axis> | AXNR=.. DIST1=.. FEED1=.. {DIST2=.. FEED2=.. DIST3=.. FEED3=..}]",
    form=Form.KEYS,
    keys=(*_AXIS, *(Key(f"{name}{i}", needed=i == 1) for i in _STAGES for name in ("DIST", "FEED"))),
    aliases=("SET JOG",),
)
def incremental(x: Execution, call: StatementCall) -> None:
    axis = _closed_axis(x, call)
    for stage in _STAGES:
        first, second = f"DIST{stage}", f"FEED{stage}"
        way, feed = _above_zero(call, first), _above_zero(call, second)
        if (way is None) != (feed is None):
            raise call.error(catalogue.MANUAL_PAIR, statement="#JOG INCR", first=first, second=second)
        if way is not None and feed is not None:
            values = x.axis_value(axis, way), _feed(x, axis, feed)
            x.emit(ManualParameter(x.source, axis, ManualValue.INCREMENTAL, stage, *values))


@statement(
    "MANUAL LIMITS",
    _LIMITS,
    syntax="#MANUAL LIMITS [AX=<axis> | AXNR=.. NEGATIVE=.. POSITIVE=..]",
    form=Form.KEYS,
    keys=(*_AXIS, Key("NEGATIVE", needed=True), Key("POSITIVE", needed=True)),
    aliases=("SET OFFSET",),
)
def limits(x: Execution, call: StatementCall) -> None:
    """Counted from where manual mode is selected; they hold at once. Axes that turn without end have none."""
    axis = _axis(x, call)
    negative, positive = call.needed("NEGATIVE"), call.needed("POSITIVE")
    if not negative < 0.0 < positive:
        raise call.error(catalogue.MANUAL_SIGN, negative=negative, positive=positive)
    if axis not in x.modulo.configured:
        values = x.axis_value(axis, negative), x.axis_value(axis, positive)
        x.emit(ManualParameter(x.source, axis, ManualValue.LIMITS, 0, *values))


@statement("GET MANUAL OFFSETS", _OFFSETS, flush=True, aliases=("GET IPO OFFSET",))
def get_offsets(x: Execution, call: StatementCall) -> None:
    """Into V.A.MANUAL_OFFSETS; the offsets stay, and positions of the program too."""
    offsets = x.outside.manual_offsets()
    if offsets is not None:
        x.manual_offsets = [0.0 if k in x.modulo.configured else float(offset) for k, offset in enumerate(offsets)]


def _offset(name: str) -> None:
    @variable(
        f"V.A.{name}.<axis>", _OFFSETS, "way by hand, as #GET MANUAL OFFSETS or G200 has found it", unit="mm, inch"
    )
    def read(x: Execution, axis: int) -> float:
        return x.shown(axis, x.manual_offsets[axis])


_offset("MANUAL_OFFSETS")
_offset("SOFFS")
