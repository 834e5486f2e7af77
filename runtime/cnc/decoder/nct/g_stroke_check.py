"""Programmable stroke check: G22 and G23 (manual lines 5946–6004).

The box lies in machine coordinates. With a length compensation in force its tip-side numbers are those of the tip, so the box is
moved by it as the axes are. It is kept over programs and over a restart, and watched before anything moves: no block is driven
that would come into a forbidden inside, or leave an allowed one.
"""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import ControlAreaChange
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.g_offsets import expect_alone, suspended
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code
from runtime.cnc.geometry.control_areas import ControlArea, Polygon
from runtime.cnc.language.errors import LineError, ProgramError
from runtime.cnc.tools.offset_table import OffsetTableError, StrokeBox
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_offsets as catalogue

_UPPER, _LOWER = "XYZ", "IJK"
MAIN = 3


def area_of(box: StrokeBox) -> ControlArea | None:
    """What is watched: None where nothing is forbidden."""
    if not box.active or (not box.outside and any(low >= high for low, high in zip(box.low, box.high, strict=True))):
        return None
    (x0, y0, z0), (x1, y1, z1) = box.low, box.high
    corners = np.array([[x0, y0], [x1, y0], [x1, y1], [x0, y1]])
    return ControlArea(0, box.outside, (0, 1, 2), Polygon(corners), z0, z1)


def _expect_permitted(x: NctExecution, box: StrokeBox, column: int) -> None:
    """LineError 1400, or FORBIDDEN AREA, where the axes stand in what is forbidden."""
    area = area_of(box)
    if area is None or area.permits(x.coordinates.position):
        return
    if not box.outside:
        raise LineError(catalogue.STROKE_INSIDE, column)
    axis, sign = _beyond(x, box)
    raise LineError(catalogue.STROKE_OUTSIDE, column, axis=x.setup.axes[axis], sign=sign)


def tell(x: NctExecution, box: StrokeBox) -> None:
    """The box is watched from here on."""
    area = area_of(box)
    told = (catalogue.STROKE_LEFT, catalogue.STROKE_ENTERED)
    x.emit(ControlAreaChange(x.source, () if area is None else (area,), np.zeros(len(x.setup.axes)), told))


def _beyond(x: NctExecution, box: StrokeBox) -> tuple[int, str]:
    """The first axis that stands beyond the box, and at which end."""
    for axis, (low, high) in enumerate(zip(box.low, box.high, strict=True)):
        place = x.coordinates.position[axis]
        if not low <= place <= high:
            return axis, "-" if place < low else "+"
    return 0, "+"


def begin_watch(x: NctExecution) -> None:
    """At program start: what G22 has left holds on. Where the axes stand in what is forbidden no motion is permitted, but G23 is.
    Raises ProgramError if the box cannot be read."""
    try:
        box = x.memory.offsets.stroke_box(x.setup.channel_number)
    except OffsetTableError as error:
        raise ProgramError(error.problem.entry, x.level.unit.place(0), **error.problem.values) from None
    if box is not None and area_of(box) is not None:
        tell(x, box)


@g_code(
    "22", Group.STROKE_CHECK, "nct.mon.stroke-check-g22-g23", "nct.trc.suspension", meaning="stroke check: a box is forbidden",
    stage=Stage.SET, takes="IJKP", axes=True,
)  # fmt: skip
def forbid(x: NctExecution, call: GCall) -> None:
    """X, Y, Z are the upper limits, I, J, K the lower ones; P0 forbids the inside, P1 the outside."""
    expect_alone(x, "GNXYZIJKP")
    words = {letter: x.words.number(letter) for letter in (*_UPPER, *_LOWER)}
    missing = next((letter for letter, value in words.items() if value is None), None)
    which = x.words.number("P")
    if missing is not None or which not in (0.0, 1.0):
        reason = "P0 or P1 is wanted" if missing is None else f"{missing} is wanted"
        raise LineError(
            catalogue.REFERENCE_FORMAT,
            x.words.place("P") if missing is None else call.column,
            name="G22",
            reason=reason,
        )
    if any(letter not in x.axis_of or x.axis_of[letter] != axis for axis, letter in enumerate(_UPPER)):
        raise LineError(nct.AXIS_MISSING, call.column, address="X, Y, Z", axes=", ".join(x.setup.axes))
    if x.coordinates.rotation is not None:
        raise LineError(nct.NOT_SUPPORTED, call.column, what="G22 with G68")
    x.axes()
    x.letters = {}
    c = x.coordinates
    ends = []
    for letters in (_UPPER, _LOWER):
        numbers = c.numbers.copy()
        for axis, letter in enumerate(letters):
            numbers[axis] = x.axis_value(axis, words[letter] or 0.0)
        ends.append(c.machine_of(numbers)[:MAIN])
    for axis, letter in enumerate(_UPPER):
        if (words[letter] or 0.0) < (words[_LOWER[axis]] or 0.0):
            reason = f"{letter} is less than {_LOWER[axis]}"
            raise LineError(catalogue.REFERENCE_FORMAT, x.words.place(letter), name="G22", reason=reason)
    low = tuple(min(pair) for pair in zip(*ends, strict=True))
    high = tuple(max(pair) for pair in zip(*ends, strict=True))
    suspended(x)
    _keep(x, StrokeBox(True, which == 1.0, low, high), call.column)


@g_code(
    "23", Group.STROKE_CHECK, "nct.mon.stroke-check-g22-g23", "nct.trc.suspension", meaning="no stroke check",
    stage=Stage.SET,
)  # fmt: skip
def permit(x: NctExecution, call: GCall) -> None:
    expect_alone(x, "GN")
    suspended(x)
    try:
        before = x.memory.offsets.stroke_box(x.setup.channel_number)
    except OffsetTableError as error:
        raise LineError(error.problem.entry, call.column, **error.problem.values) from None
    if before is not None and before.active:
        _keep(x, before._replace(active=False), call.column)


def _keep(x: NctExecution, box: StrokeBox, column: int) -> None:
    _expect_permitted(x, box, column)
    try:
        x.memory.offsets.set_stroke_box(x.setup.channel_number, box)
    except OffsetTableError as error:
        raise LineError(error.problem.entry, column, **error.problem.values) from None
    tell(x, box)
