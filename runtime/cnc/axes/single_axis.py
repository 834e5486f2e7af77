"""One axis moved alone: jog, handwheel, homing, PLC jobs, spindle positioning. Jerk-limited, one set-point per cycle.

    axis.move_to(120.0)          or  axis.move_at(-10.0)          or  axis.stop()
    image.target_position[i] = axis.step(override=1.0)            every cycle

A goal may be changed at any time, in the middle of a ramp too. What is driven is always a plan that was proven: it keeps the
limits of the axis, and where the axis has software limits it comes to rest inside them. A new plan that cannot be proven is not
driven; the axis goes on with the one it has, tries again in the next cycle, and after some of them brakes. So a speed towards a
software limit is a motion to the limit, and the axis stands there exactly.

Units: mm or degrees, and seconds.
"""

from __future__ import annotations

import math
from enum import Enum, auto

from runtime.cnc.axes.axis_plan import Dynamics, Plan, PositionPlanner, State, plan_speed, proven

PATIENCE = 3  # cycles without a plan for the goal until the axis brakes
GREATEST_OVERRIDE = 2.0
_ROUNDING = 1e-9


class Goal(Enum):
    """What the axis is asked for."""

    REST = auto()
    POSITION = auto()
    SPEED = auto()


class SingleAxis:
    """`limits` is what the axis can; `least`, `greatest` are its software limits, ±inf where there is none."""

    def __init__(
        self,
        limits: Dynamics,
        period: float,
        least: float = -math.inf,
        greatest: float = math.inf,
        position: float = 0.0,
    ) -> None:
        self._limits = Dynamics(limits.velocity, limits.acceleration, limits.jerk, limits.acceleration)
        self._period = period
        self._least, self._greatest = least, greatest
        self._planner = PositionPlanner()
        self._plan, self._spare = Plan(), Plan()
        self._time = 0.0  # in the plan
        self.restart(position)

    # ------------------------------------------------------------------ goals

    def restart(self, position: float) -> None:
        """At rest at `position`, without a goal: the axis was somewhere else, or somebody else has moved it."""
        self._state = State(position, 0.0, 0.0)
        self._plan.begin(self._state)
        self._time = 0.0
        self.goal = Goal.REST
        self.target = position  # of Goal.POSITION, as it can be reached
        self.speed = 0.0  # of Goal.SPEED, signed
        self.limited = False  # the goal lies behind a software limit
        self._end_velocity = 0.0
        self._dynamics = self._limits
        self._planned_with = -1.0  # override of the present plan; negative: the goal is not planned yet
        self._misses = 0

    def continue_from(self, state: State) -> None:
        """In motion at `state`, which somebody else has brought it to: it brakes unless a goal follows."""
        self.restart(state.p)
        self._state = state
        self._plan.begin(state)

    def move_to(self, position: float, dynamics: Dynamics | None = None, end_velocity: float = 0.0) -> bool:
        """Go to `position`, at most to the software limit, and pass it with `end_velocity` (signed) if that is not 0.

        FALSE if a value is no number that can be used: then the goal stays what it was.
        """
        if not (math.isfinite(position) and math.isfinite(end_velocity) and (dynamics is None or dynamics.usable)):
            return False
        self.goal = Goal.POSITION
        self.target = self._inside(position)
        self.limited = self.target != position
        self._take(dynamics)
        self._end_velocity = 0.0 if self.limited else self._bounded_end(end_velocity)
        return True

    def move_at(self, velocity: float, dynamics: Dynamics | None = None) -> bool:
        """Run with `velocity` (signed), until the software limit if there is one in that direction. FALSE as `move_to`."""
        if not math.isfinite(velocity) or not (dynamics is None or dynamics.usable):
            return False
        self.goal = Goal.SPEED
        self.speed = velocity
        self.limited = False
        self._take(dynamics)
        return True

    def stop(self, dynamics: Dynamics | None = None) -> None:
        """Come to rest as soon as possible, with `dynamics` or all the axis can."""
        if dynamics is not None and not dynamics.usable:
            dynamics = None
        self.goal = Goal.REST
        self.limited = False
        self._take(dynamics)

    def set_limits(self, least: float, greatest: float) -> None:
        """Other software limits from now on. Outside of them the axis may only go back in.

        An axis in motion that cannot come to rest inside of them gets them where it can.
        """
        if not self.standstill:
            plan_speed(self._spare, self._state, 0.0, self._limits)
            low, high, *_ = self._spare.extrema()
            least, greatest = min(least, low), max(greatest, high)
        self._least, self._greatest = least, greatest
        if self.goal is Goal.POSITION and self._inside(self.target) != self.target:
            self.target, self.limited, self._end_velocity = self._inside(self.target), True, 0.0
        self._planned_with = -1.0

    def _take(self, dynamics: Dynamics | None) -> None:
        self._dynamics = self._limits if dynamics is None else dynamics.within(self._limits)
        self._planned_with = -1.0
        self._misses = 0

    # ------------------------------------------------------------------ the cycle

    def step(self, override: float = 1.0, hold: bool = False) -> float:
        """One cycle: the new set-point. `override` 1.0 is 100 %, 0…200 %; `hold` brakes and keeps the goal."""
        wanted = 0.0 if hold else max(0.0, min(override, GREATEST_OVERRIDE))
        if wanted != self._planned_with:
            self._replan(wanted)
        self._time += self._period
        p, v, a = self._plan.at(self._time)
        least, greatest = self._bounds()
        self._state = State(min(max(p, least), greatest), v, a)  # cuts off rounding, which the proof allows
        if self._state.v != 0.0 and self._time >= self._plan.duration:
            self._passed()
        return self._state.p

    def _passed(self) -> None:
        """Behind the end of a plan that ends with a velocity: on with it, towards the software limit."""
        if self.goal is Goal.POSITION and self._end_velocity != 0.0:
            self.goal, self.speed = Goal.SPEED, self._end_velocity
            self._planned_with = -1.0

    def _replan(self, override: float) -> None:
        """A plan for the goal if one is proven, otherwise the present one goes on."""
        if self._candidate(override):
            self._drive()
            self._planned_with = override
            self._misses = 0
            return
        self._misses += 1
        if self._misses <= PATIENCE:
            return
        for dynamics in (self._dynamics, self._limits):
            plan_speed(self._spare, self._state, 0.0, dynamics)
            if self._proven():
                self._drive()
                self._misses = 0
                return

    def _drive(self) -> None:
        self._plan, self._spare = self._spare, self._plan
        self._time = 0.0

    def _candidate(self, override: float) -> bool:
        """Makes a plan for the goal; FALSE if there is none that is proven."""
        state, spare, allowed = self._state, self._spare, self._dynamics
        least, greatest = self._least, self._greatest
        velocity = min(allowed.velocity * override, self._limits.velocity)
        if override == 0.0 or self.goal is Goal.REST or (self.goal is Goal.SPEED and self.speed == 0.0):
            plan_speed(spare, state, 0.0, allowed)
            # outside of limits that were moved meanwhile: resting soon is the best that can be done
            return self._proven() or not least <= state.p <= greatest
        dynamics = Dynamics(velocity, allowed.acceleration, allowed.jerk, allowed.deceleration)
        if self.goal is Goal.POSITION:
            end = self._end_velocity * override
            return self._planner.plan(spare, state, self.target, end, dynamics) and self._proven()
        speed = math.copysign(min(abs(self.speed) * override, self._limits.velocity), self.speed)
        limit = greatest if speed > 0.0 else least
        if math.isinf(limit):
            plan_speed(spare, state, speed, allowed)
            return self._proven()
        if (limit - state.p) * speed <= 0.0:  # there, or beyond: no way back by itself
            plan_speed(spare, state, 0.0, allowed)
            return True
        dynamics = Dynamics(abs(speed), allowed.acceleration, allowed.jerk, allowed.deceleration)
        return self._planner.plan(spare, state, limit, 0.0, dynamics) and self._proven()

    def _proven(self) -> bool:
        return proven(self._spare, self._limits, *self._bounds())

    def _bounds(self) -> tuple[float, float]:
        """The software limits, or where the axis is if it is outside of them: it may only come back."""
        return min(self._least, self._state.p), max(self._greatest, self._state.p)

    def _inside(self, position: float) -> float:
        """The nearest position that may be gone to."""
        return min(max(position, self._least), self._greatest)

    def _bounded_end(self, end_velocity: float) -> float:
        """0 if the axis could not stop behind the target before its software limit."""
        if end_velocity == 0.0:
            return 0.0
        stopping = Plan()
        plan_speed(stopping, State(self.target, end_velocity, 0.0), 0.0, self._dynamics)
        return end_velocity if self._least <= stopping.end.p <= self._greatest else 0.0

    # ------------------------------------------------------------------ state

    @property
    def position(self) -> float:
        """The set-point."""
        return self._state.p

    @property
    def velocity(self) -> float:
        return self._state.v

    @property
    def acceleration(self) -> float:
        return self._state.a

    @property
    def standstill(self) -> bool:
        """The set-point rests."""
        return self._state.v == 0.0 and self._state.a == 0.0

    @property
    def bounds(self) -> tuple[float, float]:
        """The software limits."""
        return self._least, self._greatest

    @property
    def moves_to_target(self) -> bool:
        """On the way to `target`, or there."""
        return self.goal is Goal.POSITION

    @property
    def at_limit(self) -> bool:
        """The axis rests at a software limit behind which its goal lies."""
        if not self.standstill:
            return False
        if self.goal is Goal.SPEED:
            return self._state.p >= self._greatest if self.speed > 0.0 else self._state.p <= self._least
        return self.goal is Goal.POSITION and self.limited and self._state.p == self.target

    @property
    def arrived(self) -> bool:
        """The goal is reached: it stands at its target, has its speed (with the override), or rests."""
        if self.goal is Goal.POSITION:
            return self.standstill and self._state.p == self.target
        if self.goal is Goal.SPEED and self.speed != 0.0:
            wanted = min(abs(self.speed) * max(self._planned_with, 0.0), self._limits.velocity)
            even = (
                abs(self._state.a) <= _ROUNDING * self._limits.acceleration
            )  # a plan from a higher speed leaves a trace
            return wanted > 0.0 and even and abs(abs(self._state.v) - wanted) <= 1e-6 * wanted
        return self.standstill
