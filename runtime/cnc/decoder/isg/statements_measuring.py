"""#MEAS MODE, #MEAS, #MEAS DEFAULT, #MEAS PREPARE (programming manual 12600–12853), and V.A. of measuring (21671–21684)."""

from __future__ import annotations

from dataclasses import replace

from runtime.cnc.blocks import ProbeSignal
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import measuring as catalogue

_MODE, _PARAMETERS, _RESET = "isg.add.meas-mode", "isg.add.meas-parameters", "isg.add.meas-default-prepare"
_VALUES = "isg.var.a-measuring"
_LENGTH = "mm, inch, deg"
_SIGNALS = {
    "PLC": ProbeSignal.PLC,
    "DRIVE": ProbeSignal.DRIVE,
    "PLC_FIRST_EVENT": ProbeSignal.PLC_FIRST_EVENT,
}
_OTHER_SIGNALS = ("FIXED_STOP", "PLC_EXT_LATCH_CONTROL", "EXT_PROBE_WITH_DRIVE")
_EDGES = {"POS": True, "NEG": False}
_AXES = (Key("AX", KeyKind.AXIS, many=True), Key("AXNR", many=True))


# ---------------------------------------------------------------------------------------------------- statements


def _choose(x: Execution, value: float, column: int) -> None:
    if value != round_half_up(value) or not 1 <= value <= 8:
        raise LineError(catalogue.TYPE_UNKNOWN, column, value=value)
    if value > 5:
        raise LineError(catalogue.TYPE_UNSUPPORTED, column, value=round_half_up(value))
    x.measuring.type = round_half_up(value)


@statement("MEAS MODE", _MODE, syntax="#MEAS MODE [[<type>]]", form=Form.PLACES, optional=True)
def mode(x: Execution, call: StatementCall) -> None:
    """The type of the measuring blocks behind it; without one that of P-CHAN-00057."""
    given = [(argument, value) for argument, value in call if value is not None]
    if not given:
        x.measuring.type = x.setup.measuring.type
        return
    _choose(x, given[0][1], given[0][0].column)


@statement(
    "MEAS",
    _PARAMETERS,
    syntax=(
        "#MEAS [TYPE=.. ERR_NO_SIGNAL=..]",
        "#MEAS [AX=<axis> | AXNR=<number> .. SIGNAL=PLC|DRIVE|PLC_FIRST_EVENT EDGE=POS|NEG INPUT=..]",
    ),
    form=Form.KEYS,
    keys=(
        Key("TYPE"),
        Key("ERR_NO_SIGNAL"),
        *_AXES,
        Key("SIGNAL", KeyKind.WORD, (*_SIGNALS, *_OTHER_SIGNALS)),
        Key("EDGE", KeyKind.WORD, tuple(_EDGES)),
        Key("INPUT"),
        Key("SIMU_OFFSET"),
        Key("TRIGGER", KeyKind.FLAG),
        Key("G107", KeyKind.FLAG),
        Key("G108", KeyKind.FLAG),
    ),
)
def parameters(x: Execution, call: StatementCall) -> None:
    """They hold until the program ends."""
    for key in ("SIMU_OFFSET", "TRIGGER", "G107", "G108"):
        if call.given(key):
            raise call.error(catalogue.SOURCE_UNSUPPORTED, key, what=f"#MEAS [{key}]")
    state = x.measuring
    if call.given("TYPE"):
        _choose(x, call.needed("TYPE"), call.columns("TYPE"))
    if call.given("ERR_NO_SIGNAL"):
        value = call.needed("ERR_NO_SIGNAL")
        if value not in (0.0, 1.0):
            raise call.error(language.FLAG_VALUE, "ERR_NO_SIGNAL", value=value)
        state.signal_needed = bool(value)
    axes = _axes(x, call)
    changed = [key for key in ("SIGNAL", "EDGE", "INPUT") if call.given(key)]
    if changed and not axes:
        raise call.error(catalogue.KEYS_TOGETHER, changed[0], key=changed[0])
    signal, edge = call.text("SIGNAL"), call.text("EDGE")
    if signal in _OTHER_SIGNALS:
        raise call.error(catalogue.SOURCE_UNSUPPORTED, "SIGNAL", what=f"the probe signal {signal}")
    number = call.number("INPUT")
    if number is not None and number not in (1.0, 2.0):
        raise call.error(catalogue.SOURCE_UNSUPPORTED, "INPUT", what=f"measuring input {number:g}")
    for axis in axes:
        probe = state.probes[axis]
        assert probe is not None
        if signal is not None:
            probe = replace(probe, signal=_SIGNALS[signal])
        if edge is not None:
            probe = replace(probe, rising=_EDGES[edge])
        if number is not None:
            probe = replace(probe, number=round_half_up(number))
        state.probes[axis] = probe


@statement(
    "MEAS DEFAULT", _RESET, syntax="#MEAS DEFAULT [[AX=<axis> | AXNR=<number> ..]]", form=Form.KEYS, keys=_AXES,
    optional=True,
)  # fmt: skip
def defaults(x: Execution, call: StatementCall) -> None:
    """The probes of the axes are again what the machine description says."""
    configured = x.setup.measuring.probes
    for axis in _axes(x, call) or range(len(x.measuring.probes)):
        x.measuring.probes[axis] = configured[axis] if configured else None


@statement(
    "MEAS PREPARE", _RESET, syntax="#MEAS PREPARE [[AX=<axis> | AXNR=<number> ..]]", form=Form.KEYS, keys=_AXES,
    optional=True,
)  # fmt: skip
def prepare(x: Execution, call: StatementCall) -> None:
    """The sources that this version has are got ready within some cycles: there is nothing to begin earlier."""
    _axes(x, call)


def _axes(x: Execution, call: StatementCall) -> list[int]:
    """Channel indices of the axes that are named; LineError for one that does not measure."""
    axes = []
    for argument, value in call:
        if argument.name == "AX":
            axis = argument.index
        elif argument.name == "AXNR":
            numbers = x.setup.log_axes
            if value not in numbers:
                known = ", ".join(f"{name} {n}" for name, n in zip(x.setup.axes, numbers, strict=False))
                raise LineError(
                    language.LOGICAL_AXIS, argument.column, value=value, known=f"axes of the channel: {known}"
                )
            axis = numbers.index(value)
        else:
            continue
        if x.measuring.probes[axis] is None:
            raise LineError(catalogue.NOT_MEASURING, argument.column, axis=x.setup.axes[axis])
        axes.append(axis)
    return axes


# ---------------------------------------------------------------------------------------------------- variables


@variable("V.G.MEAS_TYPE", "isg.var.g-active-flags", "active measuring type")
def measuring_type(x: Execution) -> float:
    return float(x.measuring.type)


@variable("V.A.MERF.<axis>", _VALUES, "1: the last measuring run of the axis has a value")
def is_measured(x: Execution, axis: int) -> float:
    return float(axis in x.measuring.done)


@variable(
    "V.A.MESS.<axis>",
    _VALUES,
    "measured value with all offsets, in the active coordinate system; 0 without",
    unit=_LENGTH,
)
def measured_value(x: Execution, axis: int) -> float:
    value = x.measuring.values.get(axis)
    return 0.0 if value is None else x.shown(axis, x.counted(axis, value.in_system))


@variable("V.A.MEAS.ACS.VALUE.<axis>", _VALUES, "measured value of the axis with all offsets, 0 without", unit=_LENGTH)
def measured_of_axis(x: Execution, axis: int) -> float:
    place = x.measuring.places.get(axis)
    return 0.0 if place is None else x.shown(axis, x.counted(axis, place))


@variable(
    "V.A.MEAS.PCS.VALUE.<axis>",
    _VALUES,
    "measured value as it would be programmed, with the ball of the probe, 0 without",
    unit=_LENGTH,
)
def measured_as_programmed(x: Execution, axis: int) -> float:
    value = x.measuring.programmed.get(axis)
    return 0.0 if value is None else x.shown(axis, x.modulo.shown(axis, value))


@variable("V.A.MOFFS.<axis>", _VALUES, "measured value minus target, 0 without", unit=_LENGTH)
def measured_offset(x: Execution, axis: int) -> float:
    value = x.measuring.values.get(axis)
    return 0.0 if value is None else x.shown(axis, value.offset)


@variable("V.A.MEIN.<axis>", _VALUES, "what G101 has taken into the coordinates", unit=_LENGTH)
def included_offset(x: Execution, axis: int) -> float:
    return x.shown(axis, x.measuring.included.get(axis, 0.0))
