"""A gear between two axes: what is known of the master, where the slave is, and whether it could still be stopped."""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics, State

Floats = npt.NDArray[np.float64]


class Motion(NamedTuple):
    """A place that is told once per cycle, and what it says about velocity and acceleration at the end of the cycle."""

    p: float
    v: float = 0.0
    a: float = 0.0
    mean: float = 0.0  # velocity in the middle of the cycle

    def moved(self, place: float, period: float) -> Motion:
        """A cycle later, at `place`."""
        mean = (place - self.p) / period
        a = (mean - self.mean) / period
        return Motion(place, mean + a * period / 2.0, a, mean)


@dataclass(slots=True)
class Gear:
    """`begin`: places of slave and master where the gear was locked; None while the slave is still getting there."""

    master: int  # index of the axis
    ratio: float
    actual: bool
    dynamics: Dynamics
    master_motion: Motion
    motion: Motion  # of the slave while it is locked
    begin: tuple[float, float] | None = None
    wanted: float = math.nan  # velocity that was commanded last
    seen: int = 0  # cycles


class MasterPlaces:
    """Where the axes are that others follow: arrays of the drive image."""

    def __init__(self, numbers: dict[int, int], target: Floats, actual: Floats) -> None:
        """`numbers`: logical axis number -> index."""
        self.numbers = numbers
        self._target, self._actual = target, actual

    def of(self, index: int, actual: bool) -> float:
        """Commanded or actual place of an axis."""
        return float((self._actual if actual else self._target)[index])


def surely_stops(state: State, limits: Dynamics, least: float, greatest: float) -> bool:
    """A bound that is quick to compute: from here the axis can be stopped within its limits.

    While the acceleration is brought to zero the speed becomes at most w = |v| + a²/2J, within the time |a|/J. To stop from w
    takes the time w/A + A/J with a mean speed of w/2, or, if A is not reached, 2√(w/J), which is not more. So the way is at most
    w·(|a|/J + (w/A + A/J)/2), in either direction.
    """
    A, J = limits.acceleration, limits.jerk
    w = abs(state.v) + state.a * state.a / (2.0 * J)
    way = w * (abs(state.a) / J + (w / A + A / J) / 2.0)
    inside = least <= state.p - way and state.p + way <= greatest
    return inside and w <= limits.velocity and abs(state.a) <= A
