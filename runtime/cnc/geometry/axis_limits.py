"""What each axis of a channel is able to do, as arrays: the common currency of preparation and interpolator."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, field
from typing import Protocol

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]


class LimitedAxis(Protocol):
    """An axis of the machine description, as far as its dynamics go."""

    @property
    def velocity(self) -> float: ...
    @property
    def acceleration(self) -> float: ...
    @property
    def jerk(self) -> float: ...
    @property
    def velocity_step(self) -> float: ...


@dataclass(frozen=True, slots=True)
class AxisLimits:
    """Limits of the n axes of a channel, each shape (n,), in mm or degrees per s, s², s³.

    `velocity_step` is the jump of velocity an axis may make at a corner without tangent continuity; 0 allows none.
    `deceleration` and `braking_jerk` hold while the path slows down; left out they are those of speeding up.
    """

    velocity: Floats
    acceleration: Floats
    jerk: Floats
    velocity_step: Floats
    deceleration: Floats = field(default_factory=lambda: np.zeros(0))
    braking_jerk: Floats = field(default_factory=lambda: np.zeros(0))

    def __post_init__(self) -> None:
        if len(self.deceleration) == 0:
            object.__setattr__(self, "deceleration", self.acceleration)
        if len(self.braking_jerk) == 0:
            object.__setattr__(self, "braking_jerk", self.jerk)

    @property
    def least_acceleration(self) -> Floats:
        """Of speeding up and slowing down, (n,)."""
        least: Floats = np.minimum(self.acceleration, self.deceleration)
        return least

    @property
    def least_jerk(self) -> Floats:
        """Of speeding up and slowing down, (n,)."""
        least: Floats = np.minimum(self.jerk, self.braking_jerk)
        return least

    @property
    def n(self) -> int:
        return len(self.velocity)

    @classmethod
    def of(cls, axes: Iterable[LimitedAxis]) -> AxisLimits:
        """The limits of axes of the machine description, in their order."""
        chosen = list(axes)
        return cls(
            velocity=np.array([axis.velocity for axis in chosen], dtype=np.float64),
            acceleration=np.array([axis.acceleration for axis in chosen], dtype=np.float64),
            jerk=np.array([axis.jerk for axis in chosen], dtype=np.float64),
            velocity_step=np.array([axis.velocity_step for axis in chosen], dtype=np.float64),
        )
