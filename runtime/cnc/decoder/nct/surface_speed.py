"""Constant surface speed: G96, G97, and the greatest speed G92 S (manual lines 2542–2624).

    G96 S100 P1     100 m/min (G20: ft/min) at the distance of the axis P from its zero; the cycle follows it on G01, G02, G03
    G00             the speed that belongs to the end of the motion is ordered in front of it
    G97             the speed stays; S is rev/min again. A bare G96 takes the surface speed of before
    G92 S3000       G96 orders no more than that

It acts while the spindle turns by M03 or M04. Surface speed, axis and greatest speed outlive programs.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from runtime.cnc.blocks import CuttingSpeed
from runtime.cnc.decoder.modal import INCH, Motion
from runtime.cnc.decoder.surface_settings import PER_METRE, SurfaceSettings
from runtime.cnc.language.errors import LineError
from runtime.cnc.turning_speed import turning_speed
from runtime.diagnostics.catalogue import nct as catalogue

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.execution import NctExecution

AXES = "XYZUVWABC"  # by P from 1 on
PER_FOOT = 12.0 * INCH  # mm
DEGREES_PER_SECOND = 6.0  # per rev/min
TURNING = (3, 4)


class SurfaceSpeed:
    """Of one program run."""

    def __init__(self, settings: SurfaceSettings) -> None:
        self.settings = settings
        self.on = False
        self._told: CuttingSpeed | None = None  # what the cycle follows

    def begin(self, x: NctExecution, column: int) -> None:
        """G96. LineError for a spindle that the control does not move, or an axis that is not there."""
        setup = x.setup.spindles[x.spindles.main] if x.setup.spindles else None
        if setup is None or setup.plc:
            raise LineError(catalogue.SURFACE_SPINDLE, column)
        x.expect_axis(self.settings.axis, column)
        self.on = True

    def end(self, x: NctExecution) -> None:
        """G97: the spindle keeps the speed that it has here."""
        if self.on and self._turning(x):
            x.spindles.main_programmed.speed = x.modal.speed = self.speed(x)
        self.on = False
        self._follow_no_longer(x)

    def take_velocity(self, x: NctExecution, value: float) -> None:
        """The S word under G96."""
        self.settings.velocity = value * (PER_FOOT if x.modal.inch else PER_METRE)

    def take_limit(self, value: float, column: int) -> None:
        """G92 S. LineError for a limit that no spindle could turn at."""
        if value < 1.0:
            raise LineError(catalogue.VALUE_EXCESS, column, address="S", value=value, least=1, most=99_999)
        self.settings.limit = value

    def speed(self, x: NctExecution) -> float:
        """rev/min where the axis stands behind the last motion."""
        axis = x.expect_axis(self.settings.axis, 1)
        fastest = x.setup.spindles[x.spindles.main].dynamics.velocity / DEGREES_PER_SECOND
        limit = min(self.settings.limit or fastest, fastest)
        return turning_speed(self.settings.velocity, x.coordinates.position[axis] - x.coordinates.shift[axis], limit)

    def acts(self, x: NctExecution) -> bool:
        """The speed of the spindle is a matter of G96 now."""
        return self.on and self.settings.velocity > 0.0 and self._turning(x)

    def _turning(self, x: NctExecution) -> bool:
        state = x.spindles.main_programmed
        return state.command in TURNING and not state.positioned

    def before_motion(self, x: NctExecution) -> None:
        """The functions of the block are out, its motion comes."""
        if not self.acts(x) or x.modal.motion is Motion.RAPID:
            self._follow_no_longer(x)
            return
        axis = x.expect_axis(self.settings.axis, 1)
        centre = x.coordinates.shift[axis]
        wanted = (x.spindles.main, self.settings.velocity, axis, centre, self.settings.limit)
        told = self._told
        if told is None or wanted != (told.spindle, told.velocity, told.axis, told.centre, told.limit):
            self._told = CuttingSpeed(x.source, *wanted)
            x.emit(self._told)

    def _follow_no_longer(self, x: NctExecution) -> None:
        if self._told is not None:
            x.emit(CuttingSpeed(x.source, self._told.spindle))
            self._told = None
