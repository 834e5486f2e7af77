"""Cutter compensation: G40, G41, G42 with D and I, J, K, vector hold G38, corner arc G39 (manual lines 3478–4303)."""

from __future__ import annotations

from runtime.cnc.blocks import VectorOrder
from runtime.cnc.decoder.modal import PLANE_AXES, Motion
from runtime.cnc.decoder.motion import PLANES
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.g_offsets import expect_alone
from runtime.cnc.decoder.nct.registers import register_value
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code, word
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_offsets as catalogue

_STRAIGHT = (Motion.RAPID, Motion.LINEAR)
_ENTRIES = (
    "nct.trc.mode-g40-g41-g42",
    "nct.trc.corner-strategy",
    "nct.trc.start-up",
    "nct.trc.start-up-without-motion",
    "nct.trc.start-up-ijk",
    "nct.trc.offset-mode",
    "nct.trc.change-side",
    "nct.trc.intervening-blocks",
    "nct.trc.small-vector-gap",
    "nct.trc.interference-check",
)


@word(
    "D",
    "nct.tool.compensation-memory-h-d",
    "nct.trc.new-d-value",
    meaning="number of the radius compensation, D0: none",
)
def radius(x: NctExecution, value: float, column: int) -> None:
    """The register is read here; what is written into it later counts with the next D."""
    x.used.d_number = round(value)
    x.vectors.radius = register_value(x, "D", round(value), column)


def _direction(x: NctExecution, call: GCall) -> tuple[float, float] | None:
    """I, J, K of the plane as a direction on the machine: mirrored and turned as the contour is, scaling does not matter."""
    letters = PLANES[x.modal.plane][1]
    if not x.letters:
        return None
    other = next((letter for letter in "IJK" if letter in x.words and letter not in letters), None)
    if other is not None:
        if len(x.letters) == 3 and call.tenths in (410, 420):
            raise LineError(
                nct.NOT_SUPPORTED, x.words.place(other), what="the offset in space (G41, G42 with I, J and K)"
            )
        raise LineError(nct.WORD_WITHOUT_MEANING, x.words.place(other), address=other)
    first, second = (x.length(x.words.number(letter) or 0.0) for letter in letters)
    rotation = x.coordinates.rotation
    plane = PLANE_AXES[x.modal.plane]
    if rotation is not None and rotation.plane == plane:
        first, second = rotation.turned(first, second)
    turned = first * x.coordinates.mirror(plane[0]), second * x.coordinates.mirror(plane[1])
    if turned == (0.0, 0.0):
        raise LineError(catalogue.DIRECTION_ZERO, x.words.place(letters[0] if letters[0] in x.words else letters[1]))
    return turned


@g_code("40", Group.COMPENSATION, "nct.trc.cancel-g40", meaning="no cutter compensation", stage=Stage.SET, takes="IJK")
def cancel(x: NctExecution, call: GCall) -> None:
    if call.modal:
        x.modal.compensation_side = 0
        return
    if x.vectors.active and x.modal.motion not in _STRAIGHT:
        raise LineError(catalogue.CANCEL_IN_ARC, call.column)
    x.vectors.direction = _direction(x, call) if x.modal.motion in _STRAIGHT else None
    x.modal.compensation_side = 0


def _select(x: NctExecution, call: GCall, side: int) -> None:
    if x.modal.motion not in _STRAIGHT:
        if not x.vectors.active:
            raise LineError(catalogue.START_IN_ARC, call.column)
    else:
        direction = _direction(x, call)
        x.vectors.direction = direction if not x.vectors.active else None
    plane = PLANE_AXES[x.modal.plane]
    if max(plane) >= len(x.setup.axes):
        raise LineError(nct.AXIS_MISSING, call.column, address="XYZ"[max(plane)], axes=", ".join(x.setup.axes))
    x.modal.compensation_side = side


@g_code("41", Group.COMPENSATION, *_ENTRIES, meaning="cutter compensation, tool left", stage=Stage.SET, takes="IJK")
def left(x: NctExecution, call: GCall) -> None:
    _select(x, call, 1)


@g_code("42", Group.COMPENSATION, *_ENTRIES, meaning="cutter compensation, tool right", stage=Stage.SET, takes="IJK")
def right(x: NctExecution, call: GCall) -> None:
    _select(x, call, -1)


@g_code(
    "38", Group.ONE_SHOT, "nct.trc.vector-hold-g38", meaning="keep the vector of cutter compensation", stage=Stage.SET
)
def hold(x: NctExecution, call: GCall) -> None:
    if not x.modal.compensation_side:
        raise LineError(catalogue.HOLD_OUTSIDE, call.column)
    if x.modal.motion not in _STRAIGHT:
        raise LineError(catalogue.HOLD_IN_ARC, call.column)
    x.vectors.order(VectorOrder.HOLD)


@g_code(
    "39",
    Group.ONE_SHOT,
    "nct.trc.corner-arc-g39",
    meaning="arc around a corner",
    stage=Stage.SET,
    takes="IJK",
)
def corner_arc(x: NctExecution, call: GCall) -> None:
    if not x.modal.compensation_side:
        raise LineError(catalogue.ARC_OUTSIDE, call.column)
    expect_alone(x, "GNIJK")
    direction = _direction(x, call)
    x.words.take("IJK")
    x.letters = {}
    x.vectors.order(VectorOrder.CORNER_ARC, direction=direction)
