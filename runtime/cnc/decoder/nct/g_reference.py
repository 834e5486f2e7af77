"""Reference points: G28, G30 and the way back G29 (manual lines 2157–2259).

Programs begin when every axis has its reference, so both ways of G28 are positionings in rapid traverse.
"""

from __future__ import annotations

from runtime.cnc.blocks import VectorOrder
from runtime.cnc.decoder.motion import target
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.g_offsets import rapid_to, shortest
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct_offsets as catalogue


def _go(x: NctExecution, call: GCall, places: tuple[float, ...]) -> None:
    """Over the point of the axis words to machine positions, (n,), in the axes of the block."""
    c = x.coordinates
    words = x.axes()
    if not words:
        raise LineError(catalogue.REFERENCE_FORMAT, call.column, name=call.name, reason="an axis is wanted")
    rapid_to(x, target(x, x.words))
    for axis in words:
        x.memory.intermediate[axis] = c.numbers[axis]
    x.vectors.tell(x, VectorOrder.SUSPEND)
    rapid_to(x, shortest(x, [places[axis] if axis in words else place for axis, place in enumerate(c.position)]))
    x.vectors.tell(x, VectorOrder.RESUME)
    x.modal_changed()


@g_code(
    "28", Group.ONE_SHOT, "nct.ref.return-g28", "nct.trc.suspension", meaning="over a point to the reference point",
    stage=Stage.MOVE, axes=True,
)  # fmt: skip
def to_reference(x: NctExecution, call: GCall) -> None:
    _go(x, call, x.setup.reference_points or (0.0,) * len(x.setup.axes))


@g_code(
    "30", Group.ONE_SHOT, "nct.ref.return-g30", "nct.trc.suspension", meaning="over a point to the reference point P, 1 to 4",
    stage=Stage.MOVE, takes="P", axes=True,
)  # fmt: skip
def to_fixed_point(x: NctExecution, call: GCall) -> None:
    number = x.words.number("P")
    if number is None or number not in (1, 2, 3, 4):
        column = x.words.place("P") if number is not None else call.column
        raise LineError(catalogue.REFERENCE_FORMAT, column, name=call.name, reason="P from 1 to 4 is wanted")
    if number == 1:
        to_reference(x, call)
        return
    places = []
    for axis, points in enumerate(x.setup.fixed_points or ((),) * len(x.setup.axes)):
        if len(points) < number - 1 and axis in x.axis_words:
            name = x.setup.axes[axis]
            raise LineError(catalogue.FIXED_POINT_MISSING, x.words.place(name), number=round(number), axis=name)
        places.append(points[round(number) - 2] if len(points) >= number - 1 else 0.0)
    _go(x, call, tuple(places))


@g_code(
    "29", Group.ONE_SHOT, "nct.ref.return-from-g29", "nct.trc.suspension", meaning="back over the point of G28 or G30",
    stage=Stage.MOVE, axes=True,
)  # fmt: skip
def back(x: NctExecution, call: GCall) -> None:
    """The point is taken in the system that holds now; incremental words go on from it."""
    c = x.coordinates
    words = x.axes()
    if not words:
        raise LineError(catalogue.REFERENCE_FORMAT, call.column, name=call.name, reason="an axis is wanted")
    x.vectors.tell(x, VectorOrder.SUSPEND)
    rapid_to(x, shortest(x, c.target({axis: float(x.memory.intermediate[axis]) for axis in words}, False)))
    x.vectors.tell(x, VectorOrder.RESUME)
    rapid_to(x, target(x, x.words))
    x.modal_changed()
