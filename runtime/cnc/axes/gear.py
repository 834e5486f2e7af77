"""A gear between two axes: what is known of the master, where the slave is, and whether it could still be stopped.

    locked:  slave = slave at the begin + ratio · (master - master at the begin) + catch

Where the slave is locked it has not exactly the master's velocity and acceleration, and with automatic phase compensation not
its phase; `catch` is an axis of its own that takes up what is left, with a share of what the slave can. So nothing jumps.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics, State
from runtime.cnc.axes.single_axis import SingleAxis

Floats = npt.NDArray[np.float64]
_SHARE = 0.5  # of acceleration and jerk that the catch uses; the rest is for following the master
_USED, _LEAST = 0.9, 1e-3  # of the velocity that is left
_CHANGE = 0.05  # of the greatest velocity: a smaller change of what is left is not worth a new plan


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


class Gear:
    """`begin`: places of slave and master where the gear was locked; None while the slave is still getting there.

    `phase`: where the slave shall be beside ratio · master, None where it is locked.
    """

    def __init__(
        self,
        master: int,
        ratio: float,
        dynamics: Dynamics,
        place: float,
        catch: SingleAxis,
        *,
        actual: bool,
        phase: float | None = None,
    ) -> None:
        self.master = master  # index of the axis
        self.ratio = ratio
        self.actual = actual
        self.dynamics = dynamics
        self.phase = phase
        self.master_motion = Motion(place)
        self.begin: tuple[float, float] | None = None
        self.line = Motion(0.0)  # of the slave while it is locked, without the catch
        self.state = State(0.0, 0.0, 0.0)  # of the slave
        self.catch = catch
        self.wanted = math.nan  # velocity that was commanded last
        self.seen = 0  # cycles
        self._room = 0.0  # velocity that the catch may use

    @property
    def caught(self) -> bool:
        """The slave follows its master, and nothing is left to take up."""
        return self.begin is not None and self.catch.arrived

    def lock(self, place: float, line: State, period: float) -> None:
        """From here on the slave, in `state`, follows the master at `place`; `line` is the state of one that does so exactly."""
        state, can = self.state, self.dynamics
        self.begin = (line.p, place)
        self.line = Motion(line.p, line.v, line.a, line.v - line.a * period / 2.0)
        self.catch.continue_from(State(0.0, state.v - line.v, state.a - line.a))
        self.catch.stop(self._share_of(can.velocity))

    def catch_up(self, way: float, velocity: float, limits: Dynamics) -> None:
        """The slave also has to go `way` against its master; its velocity without that is `velocity`."""
        self._room = self._left(velocity, limits)
        self.catch.move_to(way, self._share_of(self._room))

    def share(self, velocity: float, limits: Dynamics) -> None:
        """The velocity of the master has changed what is left for the way."""
        left = self._left(velocity, limits)
        if self.catch.moves_to_target and abs(left - self._room) > _CHANGE * limits.velocity:
            self._room = left
            self.catch.move_to(self.catch.target, self._share_of(left))

    def _left(self, velocity: float, limits: Dynamics) -> float:
        """Never nothing: a slave that has no velocity left is lost as soon as it wants some, and says so."""
        return max(_USED * (limits.velocity - abs(velocity)), _LEAST * limits.velocity)

    def _share_of(self, velocity: float) -> Dynamics:
        can = self.dynamics
        return Dynamics(velocity, can.acceleration * _SHARE, can.jerk * _SHARE)


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
