"""Constant cutting speed (G96): the spindle turns the faster, the nearer the tool is to the turning centre.

    n = v / (2 π r)     r: distance of the facing axis, as it is commanded, from the centre

bounded by G196 and by what the spindle can do. A velocity of 0 leaves the speed as it is now: rapid moves of the facing axis,
G97.
"""

from __future__ import annotations

from collections.abc import Sequence

from runtime.cnc.axes.spindle import DEGREES_PER_SECOND, Spindle
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.queue_record import QueueRecord
from runtime.cnc.turning_speed import turning_speed

CHANGE = 1e-4  # share by which the speed has to change to be ordered anew


class CuttingSpeeds:
    """Of the spindles of one channel; one of them at a time."""

    def __init__(self, path: Interpolator, spindles: Sequence[Spindle]) -> None:
        self._path = path
        self._spindles = spindles
        self._spindle = 0
        self._axis = 0
        self._velocity = 0.0  # mm/min
        self._centre = 0.0  # mm, machine coordinate
        self._limit = 0.0  # rev/min

    @property
    def active(self) -> bool:
        """The speed follows the radius."""
        return self._velocity > 0.0

    def end(self) -> None:
        """The program is over: the spindle keeps the speed that it has."""
        self._velocity = 0.0

    def order(self, record: QueueRecord) -> None:
        """The path has come to a change."""
        self._spindle, self._velocity, self._axis = record.spindle, record.value, record.number
        self._centre, self._limit = record.lead, record.seconds

    def step(self) -> None:
        """Once per cycle, behind the interpolator."""
        spindle = self._spindles[self._spindle]
        radius = float(self._path.set_point[self._axis]) - self._centre
        fastest = spindle.greatest_speed / DEGREES_PER_SECOND
        limit = min(self._limit, fastest) if self._limit > 0.0 else fastest
        spindle.change_speed(turning_speed(self._velocity, radius, limit) * DEGREES_PER_SECOND, CHANGE)
