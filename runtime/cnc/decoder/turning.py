"""Turning in a program: diameters of the facing axis (G51, G52) and constant cutting speed (G96, G97, G196).

    G96 S63         n = v / (2 π r), r from where the facing axis stands to the turning centre; the cycle follows it
    G196 S6000      at most so fast
    G00 X..         the speed stays as it is, until the next G01, G02, G03
    G97             the speed stays; S is rev/min again

The turning centre is where the facing axis counts 0 without its reference point offset (G92).
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.cnc.blocks import CuttingSpeed
from runtime.cnc.decoder.modal import INCH, PLANE_AXES, Motion
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.turning_speed import turning_speed
from runtime.diagnostics.catalogue import spindle as errors

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

PER_METRE, PER_FOOT = 1000.0, 12.0 * INCH  # mm
DEGREES_PER_SECOND = 6.0  # per rev/min
LIMIT_G = 196


@dataclass(slots=True)
class Turning:
    """Of one program run. `velocity` in mm/min, 0 as long as no S stands behind G96; `limit` in rev/min, 0: none."""

    cutting: bool = False  # G96
    velocity: float = 0.0
    limit: float = 0.0
    frozen: bool = False  # a rapid move of the facing axis: the speed stays
    told: tuple[int, float, int, float, float] | None = None

    @property
    def watches(self) -> bool:
        """No block may take the fast road."""
        return self.cutting or self.told is not None

    def begin(self, x: Execution, column: int) -> None:
        """G96."""
        _facing_axis(x, "G96", column)
        setup = x.setup.spindles[x.spindles.main] if x.setup.spindles else None
        if setup is None or setup.plc:
            reason = "the channel has none" if setup is None else f"the PLC moves {setup.name}"
            raise LineError(errors.SPINDLE_NEEDED, column, what="G96", reason=reason)
        if not self.cutting:
            self.cutting, self.velocity, self.frozen = True, 0.0, False
            x.modal_changed()

    def end(self, x: Execution) -> None:
        """G97, another main spindle: the speed stays, S is in rev/min again, and the cutting speed is forgotten."""
        if self.cutting and self.velocity > 0.0:
            x.spindles.main_programmed.speed = x.modal.speed = self._speed(x, 1)
        self.cutting, self.velocity, self.frozen = False, 0.0, False
        x.modal_changed()

    def take_velocity(self, x: Execution, value: float, column: int) -> float:
        """The S word under G96; returns the speed with which the spindle begins, rev/min."""
        if not 0.0 < value < math.inf:
            raise LineError(errors.CUTTING_SPEED, column, number=96, value=value)
        self.velocity = value * self.unit(x)
        return self._speed(x, column)

    def take_limit(self, x: Execution, value: float, column: int) -> None:
        """G196: at most so many rev/min while G96 holds."""
        if not 0.0 < value < math.inf:
            raise LineError(errors.CUTTING_SPEED, column, number=LIMIT_G, value=value)
        self.limit = value

    def unit(self, x: Execution) -> float:
        """What S under G96 is in mm/min: m/min, or ft/min with G70 where P-CHAN-00360 says so."""
        return PER_FOOT if x.modal.inch and x.setup.cutting_feet else PER_METRE

    def _speed(self, x: Execution, column: int) -> float:
        axis = _facing_axis(x, "G96", column)
        fastest = x.setup.spindles[x.spindles.main].dynamics.velocity / DEGREES_PER_SECOND
        limit = min(self.limit or math.inf, fastest)
        return turning_speed(self.velocity, x.coordinates.position[axis] - _centre(x, axis), limit)

    def tell(self, x: Execution, block: CompiledBlock) -> None:
        """Words and offsets of the block are known, its motion comes: what the cycle has to know of the cutting speed."""
        if not self.watches:
            return
        wanted = None
        if self.cutting and self.velocity > 0.0:
            axis = _facing_axis(x, "G96", 1)
            if block.axes and not x.axes_taken:
                if x.modal.motion is not Motion.RAPID:
                    self.frozen = False
                elif axis in x.axis_words:
                    self.frozen = True
            if not self.frozen:
                wanted = (x.spindles.main, self.velocity, axis, _centre(x, axis), self.limit)
        if wanted == self.told:
            return
        if wanted is None:
            assert self.told is not None
            x.emit(CuttingSpeed(x.source, self.told[0]))
        else:
            x.emit(CuttingSpeed(x.source, *wanted))
        self.told = wanted
        x.modal_changed()


def halved(x: Execution, words: dict[int, float]) -> None:
    """G51: values of the facing axis in the words of a motion (axis → mm) are diameters."""
    if not x.modal.diameter:
        return
    for axis in words:
        described = x.setup.turning[axis] if axis < len(x.setup.turning) else None
        if described is None or not described.facing:
            continue
        _facing_axis(x, "G51", 1)
        relative = x.incremental_words.get(axis, x.modal.incremental)
        if described.diameter_incremental if relative else described.diameter_absolute:
            words[axis] /= 2.0


def select_diameter(x: Execution, on: bool, column: int) -> None:
    """G51 and G52."""
    if on:
        _facing_axis(x, "G51", column)
    x.modal.diameter = on
    x.modal_changed()


def offset_of(x: Execution, axis: int, value: float) -> float:
    """An offset of an axis (G92, zero offsets): of the facing axis a diameter where P-CHAN-00091 says so."""
    described = x.setup.turning[axis] if axis < len(x.setup.turning) else None
    return value / 2.0 if x.setup.offset_diameters and described is not None and described.facing else value


def _facing_axis(x: Execution, what: str, column: int) -> int:
    """The one facing axis of the active plane; LineError if there is none, or two."""
    plane = PLANE_AXES[x.modal.plane]
    found = [a for a in plane if a < len(x.setup.turning) and (d := x.setup.turning[a]) is not None and d.facing]
    if len(found) != 1:
        raise LineError(errors.FACE_AXIS, column, what=what, plane=int(x.modal.plane), count=len(found))
    return found[0]


def _centre(x: Execution, axis: int) -> float:
    """Machine coordinate of the turning centre."""
    coordinates = x.coordinates
    return coordinates.shift[axis] - coordinates.offsets.reference[axis] * coordinates.mirror_axis[axis]
