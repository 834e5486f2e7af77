"""#SPLINE, #AKIMA, G150, G151 and #HSC (programming manual 8953–9199, 10582–11055)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import ContourChange, Contouring, Spline, SplineChange, SplineKind, Tangent
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.contouring import length_unit
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, StatementHandler, g_function, statement, variable
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Group, Key, KeyKind
from runtime.diagnostics.catalogue import smoothing as catalogue

_MAIN_AXES = 3

# ---------------------------------------------------------------------------------------------------- #SPLINE, G151


def _spline_on(x: Execution, column: int) -> None:
    state = x.smoothing
    if state.hsc_on:
        raise LineError(catalogue.CHOOSE_ONE, column, first="#HSC ON", second="#SPLINE ON")
    akima = state.spline_kind is SplineKind.AKIMA
    state.spline_on = True
    x.emit(SplineChange(x.source, state.akima if akima else Spline(state.spline_kind)))


def _spline_off(x: Execution) -> None:
    if x.smoothing.spline_on:
        x.smoothing.spline_on = False
        x.emit(SplineChange(x.source, None))


@g_function(151, Group.SPLINE, "isg.smooth.akima-select", "isg.smooth.bspline")
def spline_on_g(x: Execution, call: GCall) -> None:
    _spline_on(x, call.column)


@g_function(150, Group.SPLINE, "isg.smooth.akima-select", "isg.smooth.bspline")
def spline_off_g(x: Execution, call: GCall) -> None:
    _spline_off(x)


@statement("SPLINE ON", "isg.smooth.akima-select", "isg.smooth.bspline", aliases=("SET SPLINE ON",))
def spline_on(x: Execution, call: StatementCall) -> None:
    _spline_on(x, call.column)


@statement("SPLINE OFF", "isg.smooth.akima-select", "isg.smooth.bspline", aliases=("SET SPLINE OFF",))
def spline_off(x: Execution, call: StatementCall) -> None:
    _spline_off(x)


def _type(kind: SplineKind, entry: str) -> None:
    @statement(f"SPLINE TYPE {kind.value}", entry, aliases=(f"SET SPLINETYPE {kind.value}",))
    def choose(x: Execution, call: StatementCall) -> None:
        _not_while_on(x, call)
        x.smoothing.spline_kind = kind


_type(SplineKind.AKIMA, "isg.smooth.akima-select")
_type(SplineKind.BSPLINE, "isg.smooth.bspline")

_TANGENTS = tuple(tangent.value for tangent in Tangent)


@statement(
    "AKIMA TRANS", "isg.smooth.akima-transition", syntax="#AKIMA TRANS [[START=AUTO|TANGENTIAL|USER] [END=..]]",
    form=Form.KEYS, keys=(Key("START", KeyKind.WORD, _TANGENTS), Key("END", KeyKind.WORD, _TANGENTS)), optional=True,
    aliases=("SET ASPLINE MODE",),
)  # fmt: skip
def akima_transition(x: Execution, call: StatementCall) -> None:
    """What is not named is AUTO."""
    _not_while_on(x, call)
    chosen = {name: Tangent(call.text(name) or "AUTO") for name in ("START", "END")}
    x.smoothing.akima = replace(x.smoothing.akima, start=chosen["START"], end=chosen["END"])


def _vector(name: str, old: str, field: str) -> StatementHandler:
    @statement(
        f"AKIMA {name}", "isg.smooth.akima-tangents", syntax=f"#AKIMA {name} X.. Y.. Z.. {{<axis>..}}", form=Form.AXES,
        aliases=(f"SET ASPLINE {old}",),
    )  # fmt: skip
    def vector(x: Execution, call: StatementCall) -> None:
        """A direction in programmed coordinates; of the main axes only the direction counts."""
        _not_while_on(x, call)
        given = {axis: value for axis, value in call.axes().items() if value is not None}
        main = min(_MAIN_AXES, len(x.setup.axes))
        for axis in range(main):
            if axis not in given:
                raise call.error(catalogue.TANGENT_AXIS, axis=x.setup.axes[axis])
        if not any(given[axis] for axis in range(main)):
            raise call.error(catalogue.TANGENT_ZERO)
        tip, tail = x.coordinates.target(given, False), x.coordinates.target(dict.fromkeys(given, 0.0), False)
        made = [tip[axis] - tail[axis] if axis in given else math.nan for axis in range(len(x.setup.axes))]
        length = math.hypot(*made[:main])
        whole = tuple(value / length if axis < main else value for axis, value in enumerate(made))
        changes: dict[str, Any] = {field: whole}
        x.smoothing.akima = replace(x.smoothing.akima, **changes)

    return vector


_vector("STARTVECTOR", "STARTTANG", "start_vector")
_vector("ENDVECTOR", "ZIELTANG", "end_vector")


def _not_while_on(x: Execution, call: StatementCall) -> None:
    if x.smoothing.spline_on:
        raise call.error(catalogue.WHILE_ACTIVE, statement="#" + call.syntax.name, off="#SPLINE OFF")


# ---------------------------------------------------------------------------------------------------- #HSC

_BSPLINE = ("PATH_DEV", "TRACK_DEV", "MERGE", "AUTO_OFF_PATH", "AUTO_OFF_TRACK", "AUTO_OFF_G00", "AUTO_OFF_G60",
            "MAX_PATH_LENGTH", "MAX_ANGLE")  # fmt: skip
_SURFACE = ("PATH_DEV_G00", "TRACK_DEV_G00", "CHECK_JERK", "CIR_MODE", "CIR_MIN_ANGLE", "CIR_MIN_RADIUS",
            "LENGTH_LONG_CIR")  # fmt: skip
_TRANSITIONS = ("OPMODE", "CONTERROR", "COS_PHI_MIN", "FACT_BLOCK_LEN")
_KEYS = (
    Key("BSPLINE", KeyKind.FLAG),
    Key("SURFACE", KeyKind.FLAG),
    *(Key(name) for name in (*_BSPLINE, *_SURFACE, *_TRANSITIONS)),
)
_FLAGS = {
    "MERGE": "merge",
    "AUTO_OFF_PATH": "sharp",
    "AUTO_OFF_TRACK": "sharp_tracking",
    "AUTO_OFF_G00": "without_rapid",
}
_SIZES = {
    "PATH_DEV": ("deviation", 1e6),
    "TRACK_DEV": ("tracking_deviation", 1e6),
    "MAX_PATH_LENGTH": ("longest", 1e6),
    "MAX_ANGLE": ("greatest_angle", 180.0),
}


def _hsc(name: str, on: bool | None) -> StatementHandler:
    @statement(
        name, "isg.smooth.hsc-bspline", "isg.smooth.hsc-bspline-auto-off", "isg.smooth.psc-opmode1",
        syntax=(
            f"#{name} [BSPLINE [PATH_DEV=..] [TRACK_DEV=..] [MERGE=0|1] [MAX_PATH_LENGTH=..] [MAX_ANGLE=..] "
            "[AUTO_OFF_PATH=0|1] [AUTO_OFF_TRACK=0|1] [AUTO_OFF_G00=0|1] [AUTO_OFF_G60=0|1]]",
            f"#{name} [OPMODE=1 [CONTERROR=..]]",
        ),
        form=Form.KEYS, keys=_KEYS, optional=on is not None,
    )  # fmt: skip
    def hsc(x: Execution, call: StatementCall) -> None:
        _set_hsc(x, call)
        if on is not None:
            switch_hsc(x, on, call.column)

    return hsc


_hsc("HSC", None)
_hsc("HSC ON", True)


@statement("HSC OFF", "isg.smooth.hsc-bspline", "isg.smooth.psc-opmode1")
def hsc_off(x: Execution, call: StatementCall) -> None:
    switch_hsc(x, False, call.column)


def _set_hsc(x: Execution, call: StatementCall) -> None:
    """The settings of the statement; which method is meant is told by its first key."""
    state = x.smoothing
    named = [argument.name for argument, _ in call]
    if not named:
        return
    if "SURFACE" in named or any(name in named for name in _SURFACE):
        raise call.error(catalogue.METHOD_UNSUPPORTED, "SURFACE", method="#HSC [SURFACE]")
    bspline = "BSPLINE" in named or (state.hsc_bspline and not any(name in named for name in _TRANSITIONS))
    allowed = ("BSPLINE", *_BSPLINE) if bspline else _TRANSITIONS
    for name in named:
        if name not in allowed:
            method = "BSPLINE" if bspline else "OPMODE"
            raise call.error(catalogue.OF_OTHER_METHOD, name, key=name, method=method, known=", ".join(allowed))
    only_error = named == ["CONTERROR"] and not state.hsc_bspline
    if state.hsc_on and not only_error:
        raise call.error(catalogue.WHILE_ACTIVE, statement="#HSC [..]", off="#HSC OFF")
    state.hsc_bspline = bspline
    if bspline:
        state.hsc = _bspline_settings(x, call, state.hsc)
        return
    mode = call.number("OPMODE", 1.0)
    if mode != 1.0:
        raise call.error(catalogue.METHOD_UNSUPPORTED, "OPMODE", method=f"#HSC [OPMODE={mode:g}]")
    for name in ("COS_PHI_MIN", "FACT_BLOCK_LEN"):
        if name in named:
            raise call.error(catalogue.METHOD_UNSUPPORTED, name, method=f"{name} (of OPMODE 2)")
    if "CONTERROR" in named:
        state.contour_error = _size(call, "CONTERROR", 1e6) * x.length(1.0)
    if state.hsc_on:
        _transitions(x)


def _bspline_settings(x: Execution, call: StatementCall, now: Spline) -> Spline:
    changes: dict[str, Any] = {}
    for name, field in _FLAGS.items():
        if call.given(name):
            changes[field] = bool(_size(call, name, 1.0))
    for name, (field, most) in _SIZES.items():
        if call.given(name):
            unit = length_unit(x) if name in ("PATH_DEV", "MAX_PATH_LENGTH") else 1.0
            changes[field] = _size(call, name, most) * unit
    return replace(now, **changes)


def _size(call: StatementCall, name: str, most: float) -> float:
    value = call.needed(name)
    if not 0.0 <= value <= most:
        raise call.error(catalogue.VALUE_RANGE, name, key=name, value=value, least=0.0, most=most)
    return value


def switch_hsc(x: Execution, on: bool, column: int) -> None:
    """#HSC ON, #HSC OFF."""
    state = x.smoothing
    if on and state.spline_on:
        raise LineError(catalogue.CHOOSE_ONE, column, first="#SPLINE ON", second="#HSC ON")
    if state.hsc_on == on:
        return
    state.hsc_on = on
    if state.hsc_bspline:
        x.emit(SplineChange(x.source, state.hsc if on else None))
    elif on:
        _transitions(x)
    else:
        x.emit(ContourChange(x.source, state.contouring if x.modal.contouring else None))


def _transitions(x: Execution) -> None:
    """OPMODE 1: a curve at every corner, within the contour error."""
    deviation = x.smoothing.contour_error
    x.emit(ContourChange(x.source, Contouring(deviation=deviation, check_jerk=x.setup.poly_jerk), keeps=True))


@variable("V.G.HSC_ACTIVE", "isg.var.g-active-flags", "1 while #HSC or a spline (#SPLINE, G151) is on")
def hsc_active(x: Execution) -> float:
    return float(x.smoothing.hsc_on or x.smoothing.spline_on)


@variable("V.G.HSC_SURFACE_ACTIVE", "isg.var.g-active-flags", "0: this control does not have #HSC [SURFACE]")
def surface_active(x: Execution) -> float:
    return 0.0
