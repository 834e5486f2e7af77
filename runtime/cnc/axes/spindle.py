"""A spindle: brings the speed to what M3, M4, M5 and S ask for, within its own acceleration and jerk.

Speeds are degrees/s, positive for M3 (clockwise seen along the tool).

The ramp is stepped, not planned: in each cycle the acceleration moves with the greatest jerk towards the greatest one from which
it can still be taken back to zero in time,

    v + a²/2J ≤ target        a ▲   ╭──────╮        jerk +J up to A, hold, jerk -J so that a = 0 where v = target
                                │  ╱        ╲
                                └─╱──────────╲──▶ t

so any new target, in the middle of a ramp too, needs no case of its own, and nothing can fail. (A general trajectory generator
was tried first: at the edges of its limits it raised an error once in some hundred thousand cycles.)
"""

from __future__ import annotations

import math
from enum import IntEnum

from runtime.config.machine import Axis

DEGREES_PER_SECOND = 6.0  # per rev/min
SPEED_REACHED = 0.02  # share of the commanded speed
ZERO_SPEED = 60.0  # degrees/s, 10 rev/min


class SpindleMode(IntEnum):
    """`mode_r` of the spindle status."""

    M5 = 1
    M3 = 2
    M4 = 4


class Spindle:
    """State in, state out: `command` sets the wish, `step` moves the set-point one cycle on."""

    def __init__(self, axis: Axis, index: int, period: float) -> None:
        self.axis = axis
        self.index = index  # in the machine's axes
        self.mode = SpindleMode.M5
        self.programmed_speed = 0.0  # degrees/s, without sign
        self.set_point = 0.0  # degrees/s, signed
        self._acceleration = 0.0  # degrees/s²
        self._period = period
        self._target = 0.0

    def command(self, number: int, speed_rpm: float) -> None:
        """M3, M4 or M5 (`number`), or 0 for a new speed in the same direction; `speed_rpm` in rev/min, not negative."""
        self.programmed_speed = speed_rpm * DEGREES_PER_SECOND
        if number == 3:
            self.mode = SpindleMode.M3
        elif number == 4:
            self.mode = SpindleMode.M4
        elif number == 5:
            self.mode = SpindleMode.M5

    def stop(self) -> None:
        """As M5: used by every reaction that stops the machine."""
        self.mode = SpindleMode.M5

    def step(self, override: float, running: bool) -> None:
        """One cycle. `running`: the drive takes set-points; if not, the set-point is zero at once, without a ramp."""
        if not running:
            self.set_point = self._acceleration = self._target = 0.0
            return
        target = 0.0
        if self.mode is not SpindleMode.M5:
            target = min(self.programmed_speed * override, self.axis.velocity)
            if self.mode is SpindleMode.M4:
                target = -target
        self._target = target
        if self.set_point != target or self._acceleration != 0.0:
            self._ramp(target)

    def _ramp(self, target: float) -> None:
        """One cycle towards `target` (degrees/s)."""
        T, A, J = self._period, self.axis.acceleration, self.axis.jerk
        way = target - self.set_point
        sign = math.copysign(1.0, way)
        a = self._acceleration * sign  # positive: towards the target
        # The acceleration b of this cycle, of which b·T is gained at once, must fall to zero with -J in whole cycles before
        # the target: b·T + b·(b/J)/2 ≤ way  ⇒  b ≤ J·(-T + √(T² + 2·way/J))
        b = min(A, J * (math.sqrt(T * T + 2.0 * abs(way) / J) - T))
        b = max(min(b, a + J * T), a - J * T)
        gain = b * T
        if b >= 0.0 and gain >= abs(way) - 1e-9 and b <= J * T * 1.5:
            self.set_point, self._acceleration = target, 0.0  # the rest is less than one cycle of jerk
            return
        self.set_point += gain * sign
        self._acceleration = b * sign

    def reached(self, actual: float) -> bool:
        """The set-point is where it should be, and the actual speed (degrees/s) within its window of it."""
        window = max(SPEED_REACHED * abs(self._target), ZERO_SPEED)
        wanted = self._target if self.mode is not SpindleMode.M5 else 0.0
        return self.set_point == wanted and abs(actual - wanted) <= window

    def standing(self, actual: float) -> bool:
        """Below zero speed."""
        return abs(actual) <= ZERO_SPEED
