"""The motor and its controller in a simulated drive: a second-order servo with velocity feed-forward.

    a = w² (command - x) + 2 D w (command velocity - v)        w = 2 pi bandwidth, D damping

In increments. A constant velocity is followed without lag, a jump with the response of a second-order system. The torque is the
acceleration as a share of that at rated torque; where it is limited, the motor lags behind.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from runtime.config.machine import SimulatedServo

COAST_TIME = 0.2  # s, in which the velocity falls to 1/e without torque
STEP_ANGLE = 0.25  # greatest w·dt of one integration step: semi-implicit Euler is stable below 2, accurate well below


class Motor(NamedTuple):
    """What a servo turns."""

    increments_per_unit: float
    rated: float  # acceleration at rated torque, increments/s²


class Servo:
    """Position (increments) and velocity (increments/s), and what they follow."""

    def __init__(self, config: SimulatedServo, position: float, rated: float) -> None:
        self._w = 2.0 * math.pi * config.bandwidth_hz
        self._damping = 2.0 * config.damping * self._w
        self.rated = rated  # acceleration at rated torque
        self.position = position
        self.velocity = 0.0
        self.command = position  # where it should be at the end of this step
        self.strongest, self.weakest = math.inf, -math.inf  # limits of the acceleration, increments/s²
        self.torque = 0.0  # share of the rated one, mean of the last step
        self._acceleration = 0.0  # of the velocity loop

    def take_over(self) -> None:
        """Begin to follow from where it stands."""
        self.command = self.position
        self._acceleration = 0.0

    def _steps(self, dt: float) -> tuple[int, float]:
        count = max(1, math.ceil(self._w * dt / STEP_ANGLE))
        return count, dt / count

    def _pushed(self, before: float, dt: float) -> None:
        self.torque = (self.velocity - before) / (dt * self.rated)

    def follow_position(self, target: float, dt: float) -> None:
        """Move for `dt` s while the command goes from where it was to `target`, linearly."""
        count, h = self._steps(dt)
        velocity, before = (target - self.command) / dt, self.velocity
        for _ in range(count):
            pull = self._w * self._w * (self.command - self.position) + self._damping * (velocity - self.velocity)
            self.velocity += min(max(pull, self.weakest), self.strongest) * h
            self.position += self.velocity * h
            self.command += velocity * h
        self.command = target
        self._pushed(before, dt)

    def follow_velocity(self, target: float, dt: float) -> None:
        """Move for `dt` s towards the velocity `target`."""
        count, h = self._steps(dt)
        before = self.velocity
        for _ in range(count):
            jerk = self._w * self._w * (target - self.velocity) - self._damping * self._acceleration
            self._acceleration = min(max(self._acceleration + jerk * h, self.weakest), self.strongest)
            self.velocity += self._acceleration * h
            self.position += self.velocity * h
        self.command = self.position
        self._pushed(before, dt)

    def push(self, torque: float, dt: float) -> None:
        """Move for `dt` s by a torque (share of the rated one) against a friction that grows with the velocity."""
        before = self.velocity
        acceleration = min(max(torque * self.rated, self.weakest), self.strongest)
        decay = math.exp(-dt / COAST_TIME)
        end = acceleration * COAST_TIME  # velocity that this torque leads to
        self.position += end * dt + (before - end) * COAST_TIME * (1.0 - decay)
        self.velocity = end + (before - end) * decay
        self.take_over()
        self.torque = acceleration / self.rated

    def brake(self, deceleration: float, dt: float) -> bool:
        """Move for `dt` s on a ramp to standstill (increments/s²); True when it stands."""
        before = self.velocity
        time = min(dt, abs(self.velocity) / deceleration)
        change = math.copysign(deceleration * time, self.velocity)
        self.position += (self.velocity - 0.5 * change) * time
        self.velocity = 0.0 if time < dt else self.velocity - change
        self.take_over()
        self._pushed(before, dt)
        return self.velocity == 0.0

    def coast(self, dt: float) -> None:
        """Move for `dt` s without torque."""
        decay = math.exp(-dt / COAST_TIME)
        self.position += self.velocity * COAST_TIME * (1.0 - decay)
        self.velocity *= decay
        if abs(self.velocity) < 1.0:
            self.velocity = 0.0
        self.take_over()
        self.torque = 0.0
