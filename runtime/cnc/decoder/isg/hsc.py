"""#HSC (programming manual 9013–9467, 10925–11055)."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import ContourChange, Contouring, Spline, SplineChange, SplineKind
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.contouring import length_unit
from runtime.cnc.decoder.isg.registry import StatementCall, StatementHandler, statement, variable
from runtime.cnc.decoder.smoothing import HscMethod
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import smoothing as catalogue

_BSPLINE = ("PATH_DEV", "TRACK_DEV", "MERGE", "AUTO_OFF_PATH", "AUTO_OFF_TRACK", "AUTO_OFF_G00", "AUTO_OFF_G60",
            "MAX_PATH_LENGTH", "MAX_ANGLE")  # fmt: skip
_SURFACE = ("PATH_DEV", "PATH_DEV_G00", "TRACK_DEV", "TRACK_DEV_G00", "MAX_ANGLE", "CHECK_JERK", "AUTO_OFF_G00", "CIR_MODE",
            "CIR_MIN_ANGLE", "CIR_MIN_RADIUS", "MERGE", "LENGTH_LONG_CIR")  # fmt: skip
_TRANSITIONS = ("OPMODE", "CONTERROR", "COS_PHI_MIN", "FACT_BLOCK_LEN")
_KEYS = (
    Key("BSPLINE", KeyKind.FLAG),
    Key("SURFACE", KeyKind.FLAG),
    *(Key(name) for name in dict.fromkeys((*_BSPLINE, *_SURFACE, *_TRANSITIONS))),
)
_FLAGS = {
    "MERGE": "merge",
    "AUTO_OFF_PATH": "sharp",
    "AUTO_OFF_TRACK": "sharp_tracking",
    "AUTO_OFF_G00": "without_rapid",
}
_SIZES = {
    "PATH_DEV": ("deviation", 1e6),
    "PATH_DEV_G00": ("rapid_deviation", 1e6),
    "TRACK_DEV": ("tracking_deviation", 1e6),
    "TRACK_DEV_G00": ("rapid_tracking", 1e6),
    "MAX_PATH_LENGTH": ("longest", 1e6),
    "MAX_ANGLE": ("greatest_angle", 180.0),
    "CIR_MIN_ANGLE": ("least_angle", 360.0),
    "CIR_MIN_RADIUS": ("least_radius", 1e6),
}
_LENGTHS = frozenset({"PATH_DEV", "PATH_DEV_G00", "MAX_PATH_LENGTH", "CIR_MIN_RADIUS", "LENGTH_LONG_CIR"})
_ABOVE_ZERO = frozenset({"PATH_DEV", "PATH_DEV_G00", "LENGTH_LONG_CIR"})  # of SURFACE


def _set_hsc(x: Execution, call: StatementCall) -> None:
    """The settings of the statement; which method is meant is told by its first key."""
    state = x.smoothing
    named = [argument.name for argument, _ in call]
    if not named:
        return
    method = _method(state.hsc_method, named)
    allowed = {HscMethod.BSPLINE: ("BSPLINE", *_BSPLINE), HscMethod.SURFACE: ("SURFACE", *_SURFACE)}.get(
        method, _TRANSITIONS
    )
    for name in named:
        if name not in allowed:
            title = "OPMODE" if method is HscMethod.TRANSITIONS else method.value
            raise call.error(catalogue.OF_OTHER_METHOD, name, key=name, method=title, known=", ".join(allowed))
    only_error = named == ["CONTERROR"] and method is HscMethod.TRANSITIONS
    if state.hsc_on and not only_error:
        raise call.error(catalogue.WHILE_ACTIVE, statement="#HSC [..]", off="#HSC OFF")
    state.hsc_method = method
    if method is HscMethod.BSPLINE:
        state.hsc = _curve_settings(x, call, state.hsc)
    elif method is HscMethod.SURFACE:
        state.surface = _surface_settings(x, call, state.surface)
    else:
        _transition_settings(x, call)


def _method(now: HscMethod, named: list[str]) -> HscMethod:
    """What the keys of a statement belong to."""
    for method in (HscMethod.BSPLINE, HscMethod.SURFACE):
        if method.value in named:
            return method
    if any(name in named for name in _TRANSITIONS):
        return HscMethod.TRANSITIONS
    return now


def _transition_settings(x: Execution, call: StatementCall) -> None:
    """OPMODE 1 and 2."""
    state = x.smoothing
    if call.given("OPMODE"):
        mode = call.needed("OPMODE")
        if mode not in (1.0, 2.0):
            raise call.error(catalogue.VALUE_RANGE, "OPMODE", key="OPMODE", value=mode, least=1.0, most=2.0)
        state.hsc_interpolating = mode == 2.0
    if call.given("CONTERROR"):
        state.contour_error = _size(call, "CONTERROR", 1e6) * x.length(1.0)
    if call.given("COS_PHI_MIN"):
        state.least_cosine = _size(call, "COS_PHI_MIN", 1.0, -1.0)
    if call.given("FACT_BLOCK_LEN"):
        state.longest_factor = _size(call, "FACT_BLOCK_LEN", 1e6, above=True)
    if state.hsc_on:
        _transitions(x)


def _curve_settings(x: Execution, call: StatementCall, now: Spline) -> Spline:
    changes: dict[str, Any] = {}
    above = _ABOVE_ZERO if now.kind is SplineKind.SURFACE else frozenset()
    for name, field in _FLAGS.items():
        if call.given(name):
            changes[field] = bool(_size(call, name, 1.0))
    for name, (field, most) in _SIZES.items():
        if call.given(name):
            unit = length_unit(x) if name in _LENGTHS else 1.0
            changes[field] = _size(call, name, most, above=name in above) * unit
    return replace(now, **changes)


def _surface_settings(x: Execution, call: StatementCall, now: Spline) -> Spline:
    made = _curve_settings(x, call, now)
    if call.given("CIR_MODE"):
        made = replace(made, arcs=_choice(call, "CIR_MODE") > 0)
    if call.given("CHECK_JERK"):
        made = replace(made, check_jerk=_choice(call, "CHECK_JERK"))
    if call.given("LENGTH_LONG_CIR"):  # an arc of any length is planned as a whole: nothing to divide
        _size(call, "LENGTH_LONG_CIR", 1e6, above=True)
    return made


def _choice(call: StatementCall, name: str) -> int:
    """0, 1 or 2."""
    value = _size(call, name, 2.0)
    if value != round(value):
        raise call.error(catalogue.VALUE_RANGE, name, key=name, value=value, least=0.0, most=2.0)
    return round(value)


def _size(call: StatementCall, name: str, most: float, least: float = 0.0, above: bool = False) -> float:
    """A value within limits; with `above` it is greater than the lower one."""
    value = call.needed(name)
    if not least <= value <= most or (above and value == least):
        entry = catalogue.NOT_ABOVE if above and value <= least else catalogue.VALUE_RANGE
        raise call.error(entry, name, key=name, value=value, least=least, most=most)
    return value


def switch_hsc(x: Execution, on: bool, column: int) -> None:
    """#HSC ON, #HSC OFF."""
    state = x.smoothing
    if on and state.spline_on:
        raise LineError(catalogue.CHOOSE_ONE, column, first="#SPLINE ON", second="#HSC ON")
    if state.hsc_on == on:
        return
    if on and x.setup.no_hsc_at_zero and state.hsc_method is HscMethod.BSPLINE:
        watched = state.hsc.deviation > 0.0, state.hsc.tracking_deviation > 0.0
        if not any(watched):
            return
        if not all(watched):
            key, other = ("PATH_DEV", "TRACK_DEV") if watched[1] else ("TRACK_DEV", "PATH_DEV")
            raise LineError(catalogue.ONE_DEVIATION_ZERO, column, key=key, other=other)
    state.hsc_on = on
    if state.hsc_method is HscMethod.BSPLINE:
        x.emit(SplineChange(x.source, state.hsc if on else None))
    elif state.hsc_method is HscMethod.SURFACE:
        x.emit(SplineChange(x.source, state.surface if on else None))
    elif on:
        _transitions(x)
        if state.hsc_interpolating:
            interpolating = Spline(
                SplineKind.INTERPOLATING,
                deviation=state.contour_error,
                least_cosine=state.least_cosine,
                longest_factor=state.longest_factor,
            )
            x.emit(SplineChange(x.source, interpolating))
    else:
        if state.hsc_interpolating:
            x.emit(SplineChange(x.source, None))
        x.emit(ContourChange(x.source, state.contouring if x.modal.contouring else None))


def _transitions(x: Execution) -> None:
    """A curve at every corner, within the contour error."""
    deviation = x.smoothing.contour_error
    x.emit(ContourChange(x.source, Contouring(deviation=deviation, check_jerk=x.setup.poly_jerk), keeps=True))


@variable("V.G.HSC_ACTIVE", "isg.var.g-active-flags", "1 while #HSC or a spline (#SPLINE, G151) is on")
def hsc_active(x: Execution) -> float:
    return float(x.smoothing.hsc_on or x.smoothing.spline_on)


@variable("V.G.HSC_SURFACE_ACTIVE", "isg.var.g-active-flags", "1 while #HSC [SURFACE] is on")
def surface_active(x: Execution) -> float:
    return float(x.smoothing.hsc_on and x.smoothing.hsc_method is HscMethod.SURFACE)


def _hsc(name: str, on: bool | None) -> StatementHandler:
    @statement(
        name, "isg.smooth.hsc-bspline", "isg.smooth.hsc-bspline-auto-off", "isg.smooth.hsc-surface",
        "isg.smooth.hsc-surface-circles", "isg.smooth.psc-opmode1", "isg.smooth.psc-opmode2", "isg.smooth.psc-thresholds",
        syntax=(
            f"#{name} [BSPLINE [PATH_DEV=..] [TRACK_DEV=..] [MERGE=0|1] [MAX_PATH_LENGTH=..] [MAX_ANGLE=..] "
            "[AUTO_OFF_PATH=0|1] [AUTO_OFF_TRACK=0|1] [AUTO_OFF_G00=0|1] [AUTO_OFF_G60=0|1]]",
            f"#{name} [SURFACE [PATH_DEV=..] [PATH_DEV_G00=..] [TRACK_DEV=..] [TRACK_DEV_G00=..] [MAX_ANGLE=..] "
            "[CHECK_JERK=0|1|2] [AUTO_OFF_G00=0|1] [CIR_MODE=0|1|2] [CIR_MIN_ANGLE=..] [CIR_MIN_RADIUS=..] [MERGE=0|1] "
            "[LENGTH_LONG_CIR=..]]",
            f"#{name} [OPMODE=1|2 [CONTERROR=..] [COS_PHI_MIN=..] [FACT_BLOCK_LEN=..]]",
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


@statement("HSC OFF", "isg.smooth.hsc-bspline", "isg.smooth.hsc-surface", "isg.smooth.psc-opmode1")
def hsc_off(x: Execution, call: StatementCall) -> None:
    switch_hsc(x, False, call.column)
