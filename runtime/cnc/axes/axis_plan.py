"""The plan of one axis moved alone: pieces of constant jerk, made for a goal, proven before they are driven.

    jerk  ▔▔▁▁     ▁▁▔▔        a plan has at most 9 pieces, each with where it begins: p, v, a, and its jerk j
    speed  ╱▔▔▔▔▔▔▔╲           evaluation is exact at any time, and nothing has to be integrated from cycle to cycle

Two makers: `plan_speed` (closed form, cannot fail) and `plan_position` (Ruckig, may fail at the edges of its numbers). Whatever
they give is driven only if `proven` finds velocity, acceleration and position inside the axis' limits on the whole way.
Units: mm or degrees, and seconds.
"""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass
from typing import NamedTuple

from ruckig import InputParameter, Result, Ruckig, RuckigError, Trajectory

PIECES = 12
_HAIR = 1e-9  # share by which a plan stays inside its limits
_SLACK = 1e-6  # share of rounding that the proof allows
_PLACE = 1e-7  # mm, degrees: rounding of a position that the proof allows


class State(NamedTuple):
    """Where an axis is: position, velocity, acceleration."""

    p: float
    v: float
    a: float


@dataclass(frozen=True, slots=True)
class Dynamics:
    """What a motion may use, without sign; `deceleration` None: as `acceleration`."""

    velocity: float
    acceleration: float
    jerk: float
    deceleration: float | None = None

    @property
    def usable(self) -> bool:
        """Every value is a number above zero."""
        values = (self.velocity, self.acceleration, self.jerk, self.deceleration or self.acceleration)
        return all(math.isfinite(value) and value > 0.0 for value in values)

    def within(self, axis: Dynamics) -> Dynamics:
        """Cut to what the axis can."""
        slower = self.acceleration if self.deceleration is None else self.deceleration
        return Dynamics(
            min(self.velocity, axis.velocity),
            min(self.acceleration, axis.acceleration),
            min(self.jerk, axis.jerk),
            min(slower, axis.acceleration),
        )


class Plan:
    """Pieces in order. After the last one the axis keeps its velocity; `duration` s until then."""

    def __init__(self) -> None:
        self._until = [0.0] * PIECES
        self._p = [0.0] * PIECES
        self._v = [0.0] * PIECES
        self._a = [0.0] * PIECES
        self._j = [0.0] * PIECES
        self._count = 0
        self.duration = 0.0
        self.end = State(0.0, 0.0, 0.0)

    def begin(self, state: State) -> None:
        """Forget the pieces; the next one begins at `state`."""
        self._count = 0
        self.duration = 0.0
        self.end = state

    def add(self, seconds: float, jerk: float) -> None:
        """Append a piece; those without duration are left out."""
        if seconds <= 0.0 or self._count == PIECES:
            return
        k = self._count
        p, v, a = self.end
        self._p[k], self._v[k], self._a[k], self._j[k] = p, v, a, jerk
        self.duration += seconds
        self._until[k] = self.duration
        self.end = _after(p, v, a, jerk, seconds)
        self._count += 1

    def finish(self, end: State) -> None:
        """The exact end, known better than the sum of the pieces tells."""
        self.end = end

    def at(self, t: float) -> State:
        """State `t` seconds after the begin; behind the end the velocity stays, without acceleration."""
        if t >= self.duration:
            return State(self.end.p + self.end.v * (t - self.duration), self.end.v, 0.0)
        begin = 0.0
        for k in range(self._count):
            if t < self._until[k]:
                return _after(self._p[k], self._v[k], self._a[k], self._j[k], t - begin)
            begin = self._until[k]
        return self.end

    def extrema(self) -> tuple[float, float, float, float]:
        """Least and greatest position, greatest amounts of velocity and acceleration, of all pieces."""
        least = greatest = self._p[0] if self._count else self.end.p
        v_most, a_most = abs(self.end.v), 0.0
        begin = 0.0
        for k in range(self._count):
            p, v, a, j = self._p[k], self._v[k], self._a[k], self._j[k]
            T = self._until[k] - begin
            begin = self._until[k]
            a_most = max(a_most, abs(a), abs(a + j * T))
            for t in _turning(v, a, j, T):
                place, speed, _ = _after(p, v, a, j, t)
                least, greatest, v_most = min(least, place), max(greatest, place), max(v_most, abs(speed))
        return min(least, self.end.p), max(greatest, self.end.p), v_most, a_most


def _after(p: float, v: float, a: float, j: float, t: float) -> State:
    return State(p + t * (v + t * (a / 2.0 + t * j / 6.0)), v + t * (a + t * j / 2.0), a + j * t)


def _turning(v: float, a: float, j: float, T: float) -> Iterator[float]:
    """Times within a piece at which position or velocity may be extreme: its ends, a = 0, v = 0."""
    yield 0.0
    yield T
    if j != 0.0 and 0.0 < -a / j < T:
        yield -a / j
    root = a * a - 2.0 * j * v
    if j == 0.0:
        if a != 0.0 and 0.0 < -v / a < T:
            yield -v / a
    elif root >= 0.0:
        for t in ((-a + math.sqrt(root)) / j, (-a - math.sqrt(root)) / j):
            if 0.0 < t < T:
                yield t


def proven(plan: Plan, axis: Dynamics, least: float, greatest: float) -> bool:
    """The plan keeps the limits of the axis and its positions, from its begin to its end."""
    low, high, v_most, a_most = plan.extrema()
    more = 1.0 + _SLACK
    return (
        v_most <= axis.velocity * more
        and a_most <= axis.acceleration * more
        and low >= least - _PLACE
        and high <= greatest + _PLACE
    )


def plan_speed(plan: Plan, state: State, velocity: float, dynamics: Dynamics) -> None:
    """To `velocity` in the shortest time, then on with it.

    With v* = v + a·|a|/2J, the speed at which the acceleration would be zero if it were taken back at once, the speed is too low
    if v* < velocity. Then the acceleration goes to its peak A', stays there, and goes to zero: from

        (A'² - a²)/2J + A'²/2J = velocity - v   ⇒   A' = √(J·(velocity - v) + a²/2)

    and what A' exceeds the greatest acceleration is a time at the greatest one. Too high is the same, mirrored.
    """
    J = dynamics.jerk * (1.0 - _HAIR)
    v, a = state.v, state.a
    sign = 1.0 if v + a * abs(a) / (2.0 * J) <= velocity else -1.0
    gain, b = (velocity - v) * sign, a * sign  # now upwards
    faster = (velocity - v) * velocity > 0.0
    A = (dynamics.acceleration if faster else dynamics.deceleration or dynamics.acceleration) * (1.0 - _HAIR)
    peak = min(math.sqrt(max(J * gain + b * b / 2.0, 0.0)), A)
    first = (peak - b) / J if b <= peak else (b - peak) / J
    jerk = J if b <= peak else -J
    gained = (peak + b) / 2.0 * first + peak * peak / (2.0 * J)
    plan.begin(state)
    plan.add(first, jerk * sign)
    if peak > 0.0:
        plan.add((gain - gained) / peak, 0.0)
    plan.add(peak / J, -J * sign)
    plan.finish(State(plan.end.p, velocity, 0.0))


class PositionPlanner:
    """Ruckig for one axis: input and output are kept, so that planning builds nothing anew."""

    def __init__(self) -> None:
        self._ruckig = Ruckig(1)
        self._input = InputParameter(1)
        self._trajectory = Trajectory(1)

    def plan(self, plan: Plan, state: State, position: float, end_velocity: float, dynamics: Dynamics) -> bool:
        """To `position` in the shortest time, there with `end_velocity`; FALSE if no plan was found."""
        given = self._input
        less = 1.0 - _HAIR
        up = dynamics.acceleration * less
        down = (dynamics.deceleration or dynamics.acceleration) * less
        if position < state.p:
            up, down = down, up
        V = dynamics.velocity * less
        given.current_position, given.current_velocity = [0.0], [state.v]  # relative: the numbers stay small
        given.current_acceleration = [state.a]
        given.target_position = [position - state.p]
        given.target_velocity = [max(-V, min(end_velocity, V))]
        given.max_velocity, given.max_acceleration, given.min_acceleration = [V], [up], [-down]
        given.max_jerk = [dynamics.jerk * less]
        try:
            result = self._ruckig.calculate(given, self._trajectory)
        except RuckigError:
            return False
        if result not in (Result.Working, Result.Finished):
            return False
        profile = self._trajectory.profiles[0][0]
        plan.begin(state)
        for seconds, jerk in zip(profile.brake.t, profile.brake.j, strict=True):
            plan.add(seconds, jerk)
        for seconds, jerk in zip(profile.t, profile.j, strict=True):
            plan.add(seconds, jerk)
        end = plan.end
        # the pieces must really lead there: a plan that does not would jump at its end
        scale = max(abs(position - state.p), 1.0)
        if abs(end.p - position) > 1e-6 * scale or abs(end.v - given.target_velocity[0]) > 1e-6 * max(V, 1.0):
            return False
        plan.finish(State(position, given.target_velocity[0], 0.0))
        return True
