"""#SPLINE, #AKIMA, G150 and G151 (programming manual 10582–10922)."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

from runtime.cnc.blocks import Spline, SplineChange, SplineKind, Tangent
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, StatementCall, StatementHandler, g_function, statement
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
        if x.coordinates.frame is not None:
            made[:main] = (x.coordinates.frame.rotation @ made[:main]).tolist()
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
