"""Work and protection spaces of a program: their contours, and what the stage that watches them is told.

    #CONTROL AREA BEGIN [..] ─ blocks of the contour, which move nothing ─ #CONTROL AREA END ─▶ ChannelMemory.control_areas
    #CONTROL AREA ON ─▶ ChannelMemory.active_areas ─▶ ControlAreaChange, again whenever the tool changes

The contour counts in machine coordinates, whatever offsets and coordinate systems are active (manual line 16513).
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

import numpy as np

from runtime.cnc.blocks import ControlAreaChange, Floats
from runtime.cnc.decoder.modal import PLANE_AXES, Motion, Plane
from runtime.cnc.geometry.control_areas import ControlArea, Disc, Polygon
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import control_areas as errors

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution
    from runtime.cnc.language.isg.compiler import CompiledBlock

_SAME_POINT = 1e-6  # mm
_SIDES = 3  # of a polygon, at least
_ALLOWED = (WordKind.G, WordKind.AXIS, WordKind.INTERPOLATION, WordKind.FEED)
_LETTERS = {Plane.XY: (0, 1), Plane.ZX: (2, 0), Plane.YZ: (1, 2)}  # of the centre: I 0, J 1, K 2


@dataclass(slots=True)
class OpenArea:
    """A definition that is not closed yet; `line` where it began. `place` (2,) is the last point of its contour."""

    number: int
    work: bool
    circle: bool
    plane: Plane
    excursion: int
    low: float
    high: float
    line: int
    place: list[float | None] = field(default_factory=lambda: [None, None])
    points: list[tuple[float, float]] = field(default_factory=list)
    disc: Disc | None = None

    def closed(self, column: int) -> ControlArea:
        """The area. LineError for a contour that is none."""
        axes = (*PLANE_AXES[self.plane], self.excursion)
        if self.circle:
            if self.disc is None:
                raise LineError(errors.SPACE_OPEN, column, number=self.number, what="there is no full circle")
            return ControlArea(self.number, self.work, axes, self.disc, self.low, self.high)
        corners = np.array(self.points)
        if len(corners) <= _SIDES:
            raise LineError(errors.SPACE_OPEN, column, number=self.number, what="it has less than three sides")
        if np.abs(corners[0] - corners[-1]).max() > _SAME_POINT:
            raise LineError(errors.SPACE_OPEN, column, number=self.number, what="it does not end where it began")
        return ControlArea(self.number, self.work, axes, Polygon(corners[:-1]), self.low, self.high)


def contour_block(x: Execution, block: CompiledBlock) -> None:
    """A block between BEGIN and END: a point or a circle of the contour. Nothing moves. Raises LineError."""
    area = x.open_area
    assert area is not None

    def wrong(what: str, kind: WordKind = WordKind.AXIS) -> LineError:
        return LineError(errors.SPACE_BLOCK, block.column(kind), what=what)

    for word in block.words:
        if word.kind not in _ALLOWED:
            raise LineError(errors.SPACE_BLOCK, word.column, what="only motion is possible")
    if x.axes_taken or x.modal.plane is not area.plane:
        raise wrong("another plane, or a function with axis words, is not possible", WordKind.G)
    if not x.axis_words and not x.letters:
        return
    if x.modal.incremental or any(x.incremental_words.values()):
        raise wrong("incremental dimension is not possible")
    axes = PLANE_AXES[area.plane]
    for axis, value in x.axis_words.items():
        if axis not in axes:
            raise LineError(
                errors.SPACE_BLOCK, block.column(WordKind.AXIS, axis), what=f"{x.setup.axes[axis]} is not possible"
            )
        area.place[axes.index(axis)] = x.axis_value(axis, value)
    first, second = area.place
    if first is None or second is None:
        raise wrong("the first point needs both axes of the plane; one is missing")
    if x.modal.motion in (Motion.RAPID, Motion.LINEAR):
        if x.letters:
            raise wrong("a centre without a circle is not possible", WordKind.INTERPOLATION)
        if area.circle and area.points:
            raise wrong("a second line is not possible with CIRC")
        area.points.append((first, second))
        return
    if x.modal.motion is Motion.ARC_IN_SPACE or not area.circle or not area.points or area.disc is not None:
        raise wrong("this circle is not possible")
    _circle(x, area, wrong("it has to be a full circle by its centre", WordKind.INTERPOLATION))


def _circle(x: Execution, area: OpenArea, wrong: LineError) -> None:
    begin = np.array(area.points[0])
    given = [x.length(x.letters.get(letter, 0.0)) for letter in _LETTERS[area.plane]]
    if not x.letters or np.abs(begin - np.array(area.place, dtype=np.float64)).max() > _SAME_POINT:
        raise wrong
    centre = np.array(given) if x.modal.centre_absolute else begin + given
    radius = float(np.linalg.norm(begin - centre))
    if radius <= _SAME_POINT:
        raise wrong
    area.disc = Disc(centre, radius)


# ---------------------------------------------------------------------------------------------------- which are active


def tool_tip(x: Execution) -> Floats:
    """Where the tip of the tool is on the machine, (n_axes,)."""
    tip: Floats = x.coordinates.array() - x.tools.mounted()
    return tip


def activate(x: Execution, numbers: list[int], column: int) -> None:
    """These areas are watched, too. LineError where the tool is in a place that is not permitted."""
    place = tool_tip(x)
    for number in numbers:
        area = x.memory.control_areas[number]
        if not area.permits(place):
            kind, where = ("work", "outside of") if area.work else ("protection", "within")
            raise LineError(errors.SPACE_BEGIN, column, kind=kind, number=number, where=where)
        if any(axis in x.coupling.slaves for axis in area.axes):
            what = "an axis that follows another one"
            raise LineError(errors.SPACE_BESIDE, column, what=what, number=number)
    for number in numbers:
        if number not in x.memory.active_areas:
            x.memory.active_areas.append(number)
    tell(x)


def tell(x: Execution) -> None:
    """What is watched from here on."""
    areas = tuple(x.memory.control_areas[number] for number in x.memory.active_areas)
    x.emit(ControlAreaChange(x.source_in_work(), areas, x.tools.mounted()))
