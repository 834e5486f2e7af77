"""How jobs move an axis: one motion, one on top of it, and the gear.

    set-point = offset + base + extra

    base: a single axis, or the gear;  extra: the superimposed way, joins the offset at its end

Base and extra share what the axis can: their velocities, accelerations and jerks may add up to its limits.

Units: mm or degrees, and seconds.
"""

from __future__ import annotations

import math
from dataclasses import replace

from runtime.cnc.axes.axis_plan import Dynamics, Plan, State, plan_speed, proven
from runtime.cnc.axes.gear import Gear, MasterPlaces, surely_stops
from runtime.cnc.axes.job_values import ENDLESS, MOVES, dynamics_of
from runtime.cnc.axes.modulo import TURN, chosen_turn
from runtime.cnc.axes.single_axis import SingleAxis
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, BufferMode, Direction

_ROUNDING = 1e-6
_SEEN = 2  # cycles until velocity and acceleration of a master are known


class JobMotion:
    """Set-points of one axis. `limits` is what it can, `least` and `greatest` are its software limits."""

    def __init__(
        self, limits: Dynamics, period: float, least: float, greatest: float, masters: MasterPlaces, *, modulo: bool
    ) -> None:
        self.limits = limits
        self.least, self.greatest = least, greatest
        self.masters = masters
        self.modulo = modulo
        self.base = SingleAxis(limits, period, least, greatest)
        self.extra = SingleAxis(limits, period)
        self.catch = SingleAxis(limits, period)  # of a gear
        self.offset = 0.0
        self.gear: Gear | None = None
        self.stopping_plan = Plan()  # scratch
        self._period = period

    # ------------------------------------------------------------------ where it is

    @property
    def below(self) -> State:
        """Of what is below the added motion, without the offset."""
        gear, base = self.gear, self.base
        return State(base.position, base.velocity, base.acceleration) if gear is None else gear.state

    @property
    def position(self) -> float:
        """The set-point."""
        base = self.base.position if self.gear is None else self.gear.state.p
        return self.offset + base + self.extra.position

    @property
    def standing(self) -> bool:
        """The set-point rests."""
        still = self.base.standstill if self.gear is None else self.gear.state.v == 0.0
        return still and self.extra.standstill

    def begin(self, place: float) -> None:
        """At rest at `place`; nothing is left of what was before."""
        self.offset = 0.0
        self.base.restart(place)
        self.extra.restart(0.0)
        self.gear = None
        self.set_base_limits()

    # ------------------------------------------------------------------ where a job leads

    def target(self, job: Job) -> float:
        """Of an absolute move; of a modulo axis in the turn that its direction leads to."""
        if not self.modulo:
            return job.position
        below, extra, plan = self.below, self.extra, self.stopping_plan
        v, a = below.v + extra.velocity, below.a + extra.acceleration
        plan_speed(plan, State(self.position, v, a), 0.0, dynamics_of(job, self.limits))
        return chosen_turn(job.position, self.position, plan.end.p, v, job.direction)

    def endless_velocity(self, job: Job) -> float:
        """Of a motion without a target, signed."""
        if job.direction is Direction.NEGATIVE:
            return -job.velocity
        if job.direction is Direction.CURRENT and self.base.velocity < 0.0:
            return -job.velocity
        return job.velocity

    def blend(self, first: Job, following: Job) -> None:
        """The present move passes its target with the velocity of the buffer mode, if the next one goes on in its direction."""
        base = self.base
        if first.function not in MOVES or following.function not in (*MOVES, AxisFunction.MOVE_VELOCITY):
            return
        present, then = dynamics_of(first, self.limits), dynamics_of(following, self.limits)
        speed = {
            BufferMode.BLENDING_LOW: min(present.velocity, then.velocity),
            BufferMode.BLENDING_PREVIOUS: present.velocity,
            BufferMode.BLENDING_NEXT: then.velocity,
            BufferMode.BLENDING_HIGH: max(present.velocity, then.velocity),
        }.get(following.buffer_mode)
        if speed is None:
            return
        if following.function is AxisFunction.MOVE_VELOCITY:
            onwards = self.endless_velocity(following)
        elif following.function is AxisFunction.MOVE_ABSOLUTE:
            onwards = self.target(following) - self.offset - base.target
        else:
            onwards = following.position
        way = base.target - base.position
        if way * onwards <= 0.0:
            return  # it has to turn there, so it stands there
        faster = replace(present, velocity=max(present.velocity, speed))
        base.move_to(base.target, faster, math.copysign(speed, way))

    # ------------------------------------------------------------------ the added motion

    def room(self, job: Job, present: Job | None) -> Dynamics | None:
        """What an added motion may use beside the `present` one, which gets the rest; None if that is too little."""
        limits, base, gear = self.limits, self.base, self.gear
        acceleration = job.acceleration or limits.acceleration / 2.0
        slower = max(acceleration, job.deceleration or 0.0)
        jerk = job.jerk or limits.jerk / 2.0
        left = Dynamics(
            limits.velocity - abs(job.velocity),
            limits.acceleration - slower,
            limits.jerk - jerk,
            limits.acceleration - slower,
        )
        locked = gear is not None and gear.begin is not None
        busy = 0.0 if locked else abs(base.acceleration)  # a locked slave is judged in every cycle
        if not left.usable or abs(self.below.v) > left.velocity * (1.0 + _ROUNDING) or busy > left.acceleration:
            return None
        if gear is not None:
            if gear.phase is not None and not gear.caught:
                return None
            gear.dynamics = gear.dynamics.within(left)
            gear.wanted = math.nan
        elif present is not None and present.function in MOVES:
            base.move_to(base.target, dynamics_of(present, limits).within(left))
        elif present is not None and present.function in ENDLESS:
            speed = math.copysign(min(abs(base.speed), left.velocity), base.speed)
            base.move_at(speed, dynamics_of(present, limits).within(left))
        else:
            base.stop(left if present is None else dynamics_of(present, limits).within(left))
        return Dynamics(abs(job.velocity), acceleration, jerk, job.deceleration or acceleration).within(limits)

    def set_base_limits(self, added: float = 0.0) -> None:
        """Software limits of the base, in its own coordinates, with room for an added way."""
        self.base.set_limits(self.least - self.offset - min(added, 0.0), self.greatest - self.offset - max(added, 0.0))

    def add(self, way: float, dynamics: Dynamics) -> None:
        """A way on top of what goes on."""
        self.set_base_limits(way)
        self.extra.restart(0.0)
        self.extra.move_to(way, dynamics)

    def added(self) -> None:
        """The way on top is done: it belongs to the place from now on."""
        self.offset += self.extra.position
        self.extra.restart(0.0)
        self.set_base_limits()

    def join(self) -> None:
        """Base and extra become one motion, without a jump of velocity or acceleration."""
        base, extra = self.base, self.extra
        if extra.position != 0.0 or not extra.standstill:
            state = State(
                base.position + extra.position, base.velocity + extra.velocity, base.acceleration + extra.acceleration
            )
            base.continue_from(state)
            extra.restart(0.0)

    # ------------------------------------------------------------------ gear

    def couple(self, gear: Gear) -> None:
        """From now on the axis follows a master."""
        gear.state = self.below
        self.gear = gear

    def uncouple(self) -> None:
        """The axis goes on from where the gear has brought it."""
        gear, self.gear = self.gear, None
        if gear is not None and gear.begin is not None:
            self.base.continue_from(gear.state)

    def follow(self, gear: Gear, hold: bool) -> str:
        """One cycle of a slave: on its way to the master's velocity, or locked. Why it cannot follow any more, "" if it can."""
        place = self.masters.of(gear.master, gear.actual)
        gear.master_motion = gear.master_motion.moved(place, self._period)
        if gear.begin is None:
            return self._approach(gear, place, hold)
        motion = gear.line.moved(gear.begin[0] + gear.ratio * (place - gear.begin[1]), self._period)
        acceleration = 0.0 if gear.actual else motion.a  # actual values are too rough for it
        catch = gear.catch
        if not catch.arrived:
            gear.share(motion.v, self.limits)
            catch.step()
        state = State(motion.p + catch.position, motion.v + catch.velocity, acceleration + catch.acceleration)
        reason = "feed hold" if hold else self._beyond(state)
        if not reason:
            gear.line, gear.state = motion, state
        return reason

    def _approach(self, gear: Gear, place: float, hold: bool) -> str:
        """To the velocity of the master; as soon as it is nearly that, the slave is locked."""
        base, limits = self.base, self.limits
        gear.seen += 1
        velocity, acceleration = gear.ratio * gear.master_motion.v, gear.ratio * gear.master_motion.a
        if not abs(velocity - gear.wanted) <= _ROUNDING * limits.velocity:
            gear.wanted = velocity
            most = gear.dynamics.velocity
            base.move_at(max(-most, min(velocity, most)), gear.dynamics)
        p = base.step(1.0, hold)
        gear.state = State(p, base.velocity, base.acceleration)
        near = limits.jerk * self._period / 4.0
        slow = abs(base.velocity - velocity) <= near * self._period
        if gear.seen > _SEEN and slow and abs(base.acceleration - acceleration) <= near:
            gear.lock(place, State(p, velocity, acceleration), self._period)
            if gear.phase is None:
                return ""
            way = gear.ratio * place + gear.phase - self.offset - p
            if self.modulo:
                way = (way + TURN / 2.0) % TURN - TURN / 2.0
            gear.catch_up(way, velocity, limits)
            return ""
        return "it has come to its software limit" if base.at_limit else ""

    def _beyond(self, state: State) -> str:
        """Why the slave cannot follow to a state, "" if it can; the added motion counts as well.

        From every state that it takes it can be brought to rest within its limits.
        """
        limits, extra, plan = self.limits, self.extra, self.stopping_plan
        least, greatest = self.least - self.offset, self.greatest - self.offset
        total = State(state.p + extra.position, state.v + extra.velocity, state.a + extra.acceleration)
        if surely_stops(total, limits, least, greatest):
            return ""
        plan_speed(plan, total, 0.0, limits)
        if proven(plan, limits, least, greatest):
            return ""
        low, high, speed, acceleration = plan.extrema()
        if speed > limits.velocity * (1.0 + _ROUNDING):
            return f"a velocity of {speed:.3f} is more than it can"
        if acceleration > limits.acceleration * (1.0 + _ROUNDING):
            return f"an acceleration of {acceleration:.1f} is more than it can"
        return f"it could not stop any more before its software limit ({low + self.offset:.3f} ... {high + self.offset:.3f})"
