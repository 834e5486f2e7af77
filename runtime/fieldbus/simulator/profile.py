"""The profile generator of a simulated drive: where the command is on a trapezoid, step by step. In increments."""

from __future__ import annotations

import math


class Profile:
    """`position` and `velocity` of the command."""

    def __init__(self) -> None:
        self.position = self.velocity = 0.0

    def take_over(self, position: float, velocity: float) -> None:
        self.position, self.velocity = position, velocity

    def towards(self, target: float, speed: float, acceleration: float, deceleration: float, dt: float) -> bool:
        """One step to a position; True when it is reached."""
        way = target - self.position
        # the speed from which the ramp just ends there, seen from the end of this step
        ahead = abs(way) - 0.5 * abs(self.velocity) * dt
        allowed = min(speed, math.sqrt(2.0 * deceleration * max(ahead, 0.0)))
        self._change(math.copysign(allowed, way), acceleration, deceleration, dt)
        step = self.velocity * dt
        if abs(way) <= max(abs(step), 0.5) and abs(self.velocity) <= 2.0 * deceleration * dt:
            self.position, self.velocity = target, 0.0
            return True
        self.position += step
        return False

    def at(self, velocity: float, acceleration: float, deceleration: float, dt: float) -> bool:
        """One step to a velocity; True when it is reached."""
        self._change(velocity, acceleration, deceleration, dt)
        self.position += self.velocity * dt
        return self.velocity == velocity

    def _change(self, velocity: float, acceleration: float, deceleration: float, dt: float) -> None:
        faster = abs(velocity) > abs(self.velocity) and velocity * self.velocity >= 0.0
        greatest = (acceleration if faster else deceleration) * dt
        change = velocity - self.velocity
        self.velocity = velocity if abs(change) <= greatest else self.velocity + math.copysign(greatest, change)
