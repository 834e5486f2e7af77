"""Work and protection spaces (#CONTROL AREA): no block is handed on in which the tip of the tool leaves one or enters one.

The stage stands behind all others that change the path. It sees machine axes, so zero offsets and coordinate systems count by
themselves; of the tool its offsets are taken back. Curves are looked at as chords (`geometry/control_areas.py`).
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator

import numpy as np

from runtime.cnc.blocks import (
    Arc,
    Block,
    ControlAreaChange,
    CouplingChange,
    Floats,
    Homing,
    IndependentMotion,
    Line,
    ManualMotion,
    Polyline,
    Polynomials,
)
from runtime.cnc.geometry.control_areas import ControlArea, circle_points, polynomial_points
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.motion_pieces import moves
from runtime.diagnostics.catalogue import control_areas as catalogue
from runtime.diagnostics.errors import Place

_BESIDE = {
    IndependentMotion: "an own motion of an axis",
    Homing: "homing",
    ManualMotion: "moving an axis by hand",
    CouplingChange: "an axis that follows another one",
}


class ControlAreas:
    """The stage. Raises PathError before it yields the block that is not permitted; the moves of a run before it are yielded."""

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        watch: _Watch | None = None
        for block in blocks:
            if isinstance(block, ControlAreaChange):
                watch = _Watch(block) if block.areas else None
                continue
            if watch is not None:
                if isinstance(block, Polyline):
                    count = watch.permitted(block)
                    if count:
                        yield block if count == len(block.feeds) else moves(block, 0, count)
                    if count < len(block.feeds):
                        watch.refuse_move(block, count)
                    continue
                watch.check(block)
            yield block


class _Watch:
    def __init__(self, change: ControlAreaChange) -> None:
        self._areas, self._tool = change.areas, change.tool
        self._left, self._entered = change.told or (catalogue.SPACE_LEFT, catalogue.SPACE_ENTERED)

    def permitted(self, run: Polyline) -> int:
        """How many moves of a run come before one that is not permitted."""
        places = run.points - self._tool
        found = [area.first_violation(places) for area in self._areas]
        return min((line for line in found if line >= 0), default=len(run.feeds))

    def refuse_move(self, run: Polyline, move: int) -> None:
        self._expect(run.points[move : move + 2], run.program, int(run.lines[move]))

    def check(self, block: Block) -> None:
        """PathError for a motion that is not permitted, or one that nobody watches."""
        match block:
            case Line():
                self._expect(np.array([block.start, block.end]), block.source.program, block.source.line)
            case Arc():
                points = circle_points(block.start, block.end, block.plane, block.centre, block.radius, block.angle)
                self._expect(points, block.source.program, block.source.line)
            case Polynomials():
                for element, coefficients in enumerate(block.coefficients):
                    self._expect(polynomial_points(coefficients), block.program, int(block.lines[element]))
            case IndependentMotion() | Homing() | ManualMotion() | CouplingChange():
                self._expect_elsewhere(block)

    def _expect(self, points: Floats, program: str, line: int) -> None:
        for area in self._areas:
            if area.first_violation(points - self._tool) >= 0:
                entry = self._left if area.work else self._entered
                raise PathError(entry, Place(program, line), number=area.number)

    def _expect_elsewhere(self, block: IndependentMotion | Homing | ManualMotion | CouplingChange) -> None:
        """What moves without the path is not watched: it must not be an axis of a space."""
        if isinstance(block, IndependentMotion):
            axes = {block.axis}
        elif isinstance(block, CouplingChange):
            axes = {pair.slave for pair in block.coupled}
        elif isinstance(block, Homing):
            axes = {axis for axis, rank in enumerate(block.ranks) if rank}
        else:
            axes = set(block.axes) if block.kind.value != "G202" else set()
        area = next((area for area in self._areas if axes & set(area.axes)), None)
        if area is not None:
            what = _BESIDE[type(block)]
            raise PathError(
                catalogue.SPACE_BESIDE, Place(block.source.program, block.source.line), what=what, number=area.number
            )


__all__ = ["ControlArea", "ControlAreas"]
