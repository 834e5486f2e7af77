"""Axis jobs: the motion blocks of PLCopen, executed in the cycle beside the path.

    Disabled ── enabled ──▶ Standstill ◀──────────── done ─────────────┐
                               │ move                                  │
                               ├──▶ DiscreteMotion ────────────────────┤
                               ├──▶ ContinuousMotion   (MoveVelocity, GearOut)
                               ├──▶ SynchronizedMotion (GearIn)        │
                               ├──▶ Homing ────────────────────────────┤
    from each of them:         ├──▶ Stopping  (MC_Stop, until Execute falls)
                               └──▶ ErrorStop (the machine had to stop the axis, until MC_Reset)

An axis has one job that moves it, one that waits (buffer modes), one that is superimposed, and a probe. The set-point is

    offset + base + extra        base: a single axis, or the gear;  extra: the superimposed way, joins the offset at its end

Base and extra share what the axis can: their velocities, accelerations and jerks may add up to its limits. No job leads beyond
a software limit: a target there is refused, an endless motion comes to rest at it.

Units: mm or degrees, and seconds.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

from runtime.cnc.axes.axis_plan import Dynamics, Plan, State, plan_speed, proven
from runtime.cnc.axes.gear import Gear, MasterPlaces, Motion, surely_stops
from runtime.cnc.axes.homing import AxisHoming, HomingPhase
from runtime.cnc.axes.modulo import chosen_turn
from runtime.cnc.axes.single_axis import Goal, SingleAxis
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.errors import ErrorEntry, Problem
from runtime.hli.axis_jobs import Answer, Job
from runtime.hli.layout import AxisFunction, BufferMode, Direction, JobState, MotionState

_MOVES = (AxisFunction.MOVE_ABSOLUTE, AxisFunction.MOVE_RELATIVE, AxisFunction.MOVE_ADDITIVE)
_ENDLESS = (AxisFunction.MOVE_VELOCITY, AxisFunction.GEAR_IN, AxisFunction.GEAR_OUT)
_SUPERIMPOSED = (AxisFunction.MOVE_SUPERIMPOSED, AxisFunction.PHASING)
_OPEN = (JobState.BUSY, JobState.ACTIVE, JobState.REACHED)
_ACTUAL_VALUES, _PHASE_COMPENSATION = 128, 256  # bits of the mode of a gear
_FALLING = 1  # edge of a probe
DRIVE_PROBES = 513  # number of the first touch probe of the axis's own drive: behind the inputs of the image
_STATES = {
    **dict.fromkeys((*_MOVES, AxisFunction.HALT), MotionState.DISCRETE_MOTION),
    AxisFunction.MOVE_VELOCITY: MotionState.CONTINUOUS_MOTION,
    AxisFunction.GEAR_OUT: MotionState.CONTINUOUS_MOTION,
    AxisFunction.GEAR_IN: MotionState.SYNCHRONIZED_MOTION,
    AxisFunction.STOP: MotionState.STOPPING,
    AxisFunction.HOME: MotionState.HOMING,
}
_ROUNDING = 1e-6
_SEEN = 2  # cycles until velocity and acceleration of a master are known
_UNTOLD = Answer(JobState.NONE)


def spelt(job: Job) -> str:
    """MC_MoveAbsolute."""
    return f"MC_{job.function.name.title().replace('_', '')}"


def wrong_values(job: Job, way: float) -> str:
    """What is wrong with the inputs of a job, "" nothing; `way`: from where the axis is to the position of the job."""
    function = job.function
    values = (job.position, job.velocity, job.acceleration or 1.0, job.deceleration or 1.0, job.jerk or 1.0)
    if not all(map(math.isfinite, (*values, job.numerator, job.denominator))):
        return "a value is no finite number"
    if function in (*_MOVES, *_SUPERIMPOSED, AxisFunction.MOVE_VELOCITY) and not job.velocity > 0.0:
        return "the velocity has to be above 0"
    if function is AxisFunction.GEAR_IN:
        if job.denominator == 0.0:
            return "the denominator of the ratio is 0"
        if job.mode & _PHASE_COMPENSATION:
            return "automatic phase compensation (mode 256) is not available in this version"
    against = {Direction.POSITIVE: way < 0.0, Direction.NEGATIVE: way > 0.0}.get(job.direction, False)
    if function is AxisFunction.MOVE_ABSOLUTE and against:
        return "the axis is not modulo, so the position lies only in the other direction"
    return ""


@dataclass(slots=True)
class AxisCycle:
    """What an axis finds in a cycle."""

    enabled: bool
    fault: bool
    in_path: bool  # a program or a mode of the channel uses it
    set_point: float  # of the cycle before
    actual: float
    in_position: bool
    override: float = 1.0
    hold: bool = False
    stop_hold: bool = False
    cam: bool | None = None  # the axis stands on its reference cam; None: nobody tells


@dataclass(slots=True)
class Followed:
    """A job and what was told of it last."""

    job: Job
    answer: Answer = field(default=_UNTOLD)

    @property
    def open(self) -> bool:
        return self.answer.state in _OPEN


class AxisJobs:
    """The jobs of one axis. `give` hands a job over, `step` is called once per cycle."""

    def __init__(
        self,
        name: str,
        index: int,
        limits: Dynamics,
        period: float,
        least: float,
        greatest: float,
        masters: MasterPlaces,
        *,
        absolute: bool = True,
        modulo: bool = False,
        probes: frozenset[tuple[int, int]] = frozenset(),
    ) -> None:
        """`absolute`: the encoder has its reference always, so homing has nothing to do. `modulo`: it turns without end.

        `probes`: number (from `DRIVE_PROBES` on) and edge of the touch probes that the drive latches itself.
        """
        self.name = name
        self._index = index
        self._limits = limits
        self._period = period
        self._least, self._greatest = least, greatest
        self._masters = masters
        self._absolute = absolute
        self._modulo = modulo
        self._probes = probes
        self.base = self._base = SingleAxis(limits, period, least, greatest)
        self.homing: AxisHoming | None = None  # of `base`; of an axis that has to look for its reference
        self._extra = SingleAxis(limits, period)
        self._stopping_plan = Plan()
        self._on_cam = False  # where homing begins
        self._offset = 0.0
        self._gear: Gear | None = None
        self._gear_state = State(0.0, 0.0, 0.0)  # of the slave while it follows
        self._current: Followed | None = None
        self._next: Followed | None = None
        self._added: Followed | None = None  # superimposed
        self._probe: Followed | None = None
        self._probe_before: bool | None = None
        self.referenced = False  # homing has found the reference; taken by the caller
        self.shift = 0.0  # by which the coordinates of the axis shift in this cycle; taken by the caller
        self.owned = False  # jobs say where the axis goes
        self.state = MotionState.DISABLED
        self.error = 0  # why it is in ErrorStop
        self.changed: list[Followed] = []  # jobs of which there is something to tell; taken by the caller
        self.problems: list[Problem] = []

    # ------------------------------------------------------------------ orders

    def give(self, job: Job, cycle: AxisCycle) -> Followed:
        """A job: it begins now, waits, or is refused, which its answer tells."""
        followed = Followed(job)
        self.take(followed, cycle)
        return followed

    def take(self, followed: Followed, cycle: AxisCycle) -> None:
        """The same, of a job that its giver follows already."""
        job = followed.job
        if not self.owned:
            self._offset = 0.0
            self._base.restart(cycle.set_point)
            self._extra.restart(0.0)
            self._set_base_limits()
        refusal = self._refusal(job, cycle)
        if refusal is not None:
            self._fail(followed, refusal)
            return
        function = job.function
        if function is AxisFunction.RESET:
            self.reset()
            self._tell(followed, JobState.DONE)
        elif function is AxisFunction.HOME and self._absolute:
            self._tell(followed, JobState.DONE)
        elif function is AxisFunction.TOUCH_PROBE:
            if self._probe is not None:
                self._tell(self._probe, JobState.ABORTED)
            self._probe, self._probe_before = followed, None
            self._tell(followed, JobState.ACTIVE)
        elif function is AxisFunction.ABORT_TRIGGER:
            if self._probe is not None:
                self._tell(self._probe, JobState.ABORTED)
            self._probe = None
            self._tell(followed, JobState.DONE)
        elif function in _SUPERIMPOSED:
            self.owned = True
            self._superimpose(followed)
        elif self._waits(job):
            self._next = followed
            self._tell(followed, JobState.BUSY)
            self._blend()
        else:
            self.owned = True
            self._start(followed)

    def stop(self, reason: str) -> None:
        """The machine stops the axis: jobs end with an error, the axis comes to rest, its state is ErrorStop."""
        busy = [
            followed for followed in (self._current, self._next, self._added) if followed is not None and followed.open
        ]
        if not busy:
            return
        for followed in busy:
            self._fail(followed, self._problem(errors.JOB_STOPPED, followed.job, reason=reason))
        self._leave_gear()
        self._join()
        self._current = self._next = self._added = None
        if self.homes and self.homing is not None:
            self.homing.cancel()
        else:
            self._base.stop()
        self.error = errors.JOB_STOPPED.id
        self.state = MotionState.ERROR_STOP

    def let_go(self) -> None:
        """Somebody else says where the axis goes, or nobody: no motion is left, a probe still waits."""
        for followed in (self._current, self._next, self._added):
            if followed is not None and followed.open:
                self._tell(followed, JobState.ABORTED)
        self._current = self._next = self._added = self._gear = None
        if self.homes and self.homing is not None:
            self.homing.forget()
        self.owned = False

    def reset(self) -> None:
        """MC_Reset: leaves ErrorStop, as soon as the axis rests."""
        self.error = 0
        if self.state is MotionState.ERROR_STOP and not self.owned:
            self.state = MotionState.STANDSTILL

    # ------------------------------------------------------------------ the cycle

    def step(self, cycle: AxisCycle) -> float | None:
        """The new set-point, or None if jobs do not say where the axis goes."""
        if not cycle.enabled or cycle.in_path:
            self._absent(cycle)
            return None
        if self.state is MotionState.DISABLED:
            self.state = MotionState.ERROR_STOP if self.error else MotionState.STANDSTILL
        if not self.owned:
            return None
        if self.homes and self.homing is not None:
            self._home(self.homing, cycle)
            return self.position
        stopping = self._current is None or self._current.job.function in (AxisFunction.STOP, AxisFunction.HALT)
        if self._gear is not None:
            self._follow(self._gear, cycle.hold)
        else:
            self._base.step(1.0 if stopping else cycle.override, cycle.hold and not stopping)
        if self._added is not None:
            self._extra.step(cycle.override, cycle.hold)
        self._judge(cycle)
        if self._added is not None and self._extra.arrived:
            self._offset += self._extra.position
            self._extra.restart(0.0)
            self._tell(self._added, JobState.DONE)
            self._added = None
            self._set_base_limits()
        return self.position

    @property
    def homes(self) -> bool:
        """The axis looks for its reference, or comes to rest from that."""
        return self.homing is not None and not self.homing.over

    def _home(self, homing: AxisHoming, cycle: AxisCycle) -> None:
        """One cycle of homing; where the coordinates shift, `shift` has that for the caller."""
        current = self._current
        self.shift = homing.step(bool(cycle.cam), cycle.actual, 0.0, cycle.override, cycle.hold)
        if homing.phase is HomingPhase.LATE:
            homing.phase = HomingPhase.STOPPING
        elif homing.phase is not HomingPhase.DONE and homing.phase is not HomingPhase.FAILED:
            return
        self._set_base_limits()
        if current is None or current.job.function is not AxisFunction.HOME:
            return
        if homing.phase is HomingPhase.DONE:
            self.referenced = True
            self._end(current)
            return
        self._fail(current, self._problem(errors.JOB_HOME_FAILED, current.job))
        self._current = None
        self.error = errors.JOB_HOME_FAILED.id
        self.state = MotionState.ERROR_STOP

    @property
    def position(self) -> float:
        """The set-point."""
        base = self._gear_state.p if self._gear is not None else self._base.position
        return self._offset + base + self._extra.position

    @property
    def standing(self) -> bool:
        """The set-point rests."""
        still = self._gear_state.v == 0.0 if self._gear is not None else self._base.standstill
        return not self.owned or (still and self._extra.standstill and not self.homes)

    @property
    def moving(self) -> bool:
        """A job has the axis, or it does not yet rest."""
        return self.owned and (self._current is not None or self._added is not None or not self.standing)

    def trigger(self, level: bool, actual: float) -> None:
        """The probe's input in this cycle; `actual` is the position of the axis."""
        before, self._probe_before = self._probe_before, level
        probe = self._probe
        if probe is None or before is None or before is level:
            return
        if level is not (probe.job.mode == _FALLING):
            self.latch(actual)

    def latch(self, position: float) -> None:
        """The probe that is waited for has seen its edge where the axis was at `position`."""
        probe, self._probe = self._probe, None
        if probe is not None:
            probe.answer = Answer(JobState.DONE, 0, position)
            self.changed.append(probe)

    @property
    def probe_rises(self) -> bool:
        """The edge that a probe waits for is a rising one."""
        return self._probe is not None and self._probe.job.mode != _FALLING

    @property
    def probe_input(self) -> int:
        """Number of the input that a probe waits for, 0 none."""
        return 0 if self._probe is None else self._probe.job.master

    def _absent(self, cycle: AxisCycle) -> None:
        """The axis is off, or belongs to the path."""
        if self.owned:
            if cycle.fault and self._current is not None:
                self._fail(
                    self._current, self._problem(errors.JOB_STOPPED, self._current.job, reason="its drive has failed")
                )
                self.error = errors.JOB_STOPPED.id
            self.let_go()
        if cycle.enabled:
            self.state = MotionState.ERROR_STOP if self.error else MotionState.STANDSTILL
        else:
            self.state = MotionState.ERROR_STOP if cycle.fault else MotionState.DISABLED

    def _judge(self, cycle: AxisCycle) -> None:
        """What the present job has reached, and what follows it."""
        current = self._current
        if current is None:
            if self.standing and self._added is None:
                self.owned = False
                self.state = MotionState.ERROR_STOP if self.error else MotionState.STANDSTILL
            return
        function = current.job.function
        base = self._base
        if function in _MOVES:
            passed = base.goal is Goal.SPEED
            if passed or (base.arrived and (cycle.in_position or self._next is not None)):
                self._end(current)
        elif function is AxisFunction.HALT:
            if base.standstill and cycle.in_position:
                self._end(current)
        elif function is AxisFunction.STOP:
            if current.open and base.standstill and cycle.in_position:
                self._tell(current, JobState.DONE)
            if not current.open and not cycle.stop_hold:
                self._current = None
        elif self._gear is None:
            if base.at_limit:
                self._fail(current, self._problem(errors.JOB_AT_LIMIT, current.job))
                self._current = None
                base.stop()
            else:
                self._tell(current, JobState.REACHED if base.arrived else JobState.ACTIVE)
                if base.arrived and self._next is not None:
                    self._end(current)

    def _end(self, current: Followed) -> None:
        """A job is done; the one that waits begins."""
        self._tell(current, JobState.DONE)
        self._current, following = None, self._next
        self._next = None
        if following is not None:
            refusal = self._aims_beyond(following.job)
            if refusal is None:
                self._start(following)
                return
            self._fail(following, refusal)
            self._base.stop()

    # ------------------------------------------------------------------ beginning

    def _start(self, followed: Followed) -> None:
        """The job takes the axis over, from whatever is in motion."""
        job, before = followed.job, self._current
        dynamics = self._dynamics(job)
        target = self._target(job)
        for other in (before, self._next, self._added):
            if other is not None and other.open:
                self._tell(other, JobState.ABORTED)
        self._leave_gear()
        self._join()
        self._added = self._next = None
        self._current = followed
        self._set_base_limits()
        function = job.function
        if self.homes and self.homing is not None:
            self.homing.cancel()
        elif function is AxisFunction.HOME and self.homing is not None:
            self._base.restart(self.position)
            self._offset = 0.0
            self.homing.begin(self._on_cam)
        elif function in _MOVES:
            self._base.move_to(target - self._offset, dynamics)
        elif function is AxisFunction.MOVE_VELOCITY:
            self._base.move_at(self._endless_velocity(job), dynamics)
        elif function is AxisFunction.GEAR_IN:
            master = self._masters.numbers[job.master]
            actual = bool(job.mode & _ACTUAL_VALUES)
            ratio = job.numerator / job.denominator
            place = Motion(self._masters.of(master, actual))
            self._gear = Gear(master, ratio, actual, dynamics, place, place)
            self._gear_state = State(self._base.position, self._base.velocity, self._base.acceleration)
        elif function is AxisFunction.GEAR_OUT:
            self._base.move_at(self._base.velocity, dynamics)
        else:
            self._base.stop(dynamics)
        self.state = _STATES[function]
        self._tell(followed, JobState.DONE if function is AxisFunction.GEAR_OUT else JobState.ACTIVE)
        if function is AxisFunction.GEAR_OUT:
            onwards = replace(job, function=AxisFunction.MOVE_VELOCITY, number=0)  # nobody waits for it
            self._current = None if self._base.standstill else Followed(onwards, Answer(JobState.ACTIVE))

    def _target(self, job: Job) -> float:
        """Where a motion leads, in coordinates of the axis."""
        function = job.function
        if function is AxisFunction.MOVE_ABSOLUTE:
            return self._of_turn(job) if self._modulo else job.position
        discrete = self._current is not None and self._current.job.function in _MOVES
        if function is AxisFunction.MOVE_ADDITIVE and discrete:
            return self._base.target + self._offset + job.position
        return self.position + job.position

    def _of_turn(self, job: Job) -> float:
        """An absolute position of a modulo axis, in the turn that its direction leads to."""
        base, extra = self._base, self._extra
        motion = self._gear_state if self._gear is not None else State(base.position, base.velocity, base.acceleration)
        v = motion.v + extra.velocity
        plan_speed(
            self._stopping_plan, State(self.position, v, motion.a + extra.acceleration), 0.0, self._dynamics(job)
        )
        return chosen_turn(job.position, self.position, self._stopping_plan.end.p, v, job.direction)

    def _endless_velocity(self, job: Job) -> float:
        if job.direction is Direction.NEGATIVE:
            return -job.velocity
        if job.direction is Direction.CURRENT and self._base.velocity < 0.0:
            return -job.velocity
        return job.velocity

    def _dynamics(self, job: Job) -> Dynamics:
        limits = self._limits
        return Dynamics(
            abs(job.velocity) or limits.velocity,
            job.acceleration or limits.acceleration,
            job.jerk or limits.jerk,
            job.deceleration or job.acceleration or limits.acceleration,
        ).within(limits)

    def _waits(self, job: Job) -> bool:
        return (
            job.buffer_mode is not BufferMode.ABORTING
            and job.function is not AxisFunction.STOP
            and self._current is not None
            and self._current.open
        )

    def _blend(self) -> None:
        """The present move passes its target with the velocity of the buffer mode, if the next one goes on in its direction."""
        current, following = self._current, self._next
        if current is None or following is None or current.job.function not in _MOVES:
            return
        first, second = self._dynamics(current.job), self._dynamics(following.job)
        speed = {
            BufferMode.BLENDING_LOW: min(first.velocity, second.velocity),
            BufferMode.BLENDING_PREVIOUS: first.velocity,
            BufferMode.BLENDING_NEXT: second.velocity,
            BufferMode.BLENDING_HIGH: max(first.velocity, second.velocity),
        }.get(following.job.buffer_mode)
        if speed is None or following.job.function not in (*_MOVES, AxisFunction.MOVE_VELOCITY):
            return
        target = self._base.target
        if following.job.function is AxisFunction.MOVE_VELOCITY:
            onwards = self._endless_velocity(following.job)
        elif following.job.function is AxisFunction.MOVE_ABSOLUTE:
            onwards = self._target(following.job) - self._offset - target
        else:
            onwards = following.job.position
        way = target - self._base.position
        if way * onwards <= 0.0:
            return  # it has to turn there, so it stands there
        faster = replace(first, velocity=max(first.velocity, speed))
        self._base.move_to(target, faster, math.copysign(speed, way))

    # ------------------------------------------------------------------ superimposed motion

    def _superimpose(self, followed: Followed) -> None:
        job = followed.job
        if self._added is not None:
            self._tell(self._added, JobState.ABORTED)
            self._added = None
            self._join()
        shared = self._current is not None
        room = self._room(job) if shared else self._dynamics(job)
        if room is None:
            what = "velocity and acceleration of both are more than it can"
            self._fail(followed, self._problem(errors.JOB_NO_ROOM, job, what=what))
            return
        self._added = followed
        self._set_base_limits(job.position)
        self._extra.restart(0.0)
        self._extra.move_to(job.position, room)
        if not shared:
            self.state = MotionState.DISCRETE_MOTION
        self._tell(followed, JobState.ACTIVE)

    def _room(self, job: Job) -> Dynamics | None:
        """What the added motion may use beside the present one; the present one is planned anew with the rest."""
        limits, current = self._limits, self._current
        assert current is not None
        base = self._dynamics(current.job)
        busy = abs(self._base.acceleration) if self._gear is None else 0.0
        acceleration = job.acceleration or limits.acceleration / 2.0
        slower = max(acceleration, job.deceleration or 0.0)
        jerk = job.jerk or limits.jerk / 2.0
        left = Dynamics(
            limits.velocity - abs(job.velocity),
            limits.acceleration - slower,
            limits.jerk - jerk,
            limits.acceleration - slower,
        )
        speed = abs(self._base.velocity) if self._gear is None else abs(self._gear_state.v)
        if not left.usable or speed > left.velocity * (1.0 + _ROUNDING) or busy > left.acceleration:
            return None
        if self._gear is None and current.open:
            shared = base.within(left)
            if current.job.function in _MOVES:
                self._base.move_to(self._base.target, shared)
            elif current.job.function in _ENDLESS:
                self._base.move_at(math.copysign(min(abs(self._base.speed), left.velocity), self._base.speed), shared)
        return Dynamics(abs(job.velocity), acceleration, jerk, job.deceleration or acceleration).within(limits)

    def _set_base_limits(self, added: float = 0.0) -> None:
        """Software limits of the base, in its own coordinates, with room for an added way."""
        self._base.set_limits(
            self._least - self._offset - min(added, 0.0), self._greatest - self._offset - max(added, 0.0)
        )

    def _join(self) -> None:
        """Base and extra become one motion, without a jump of velocity or acceleration."""
        base, extra = self._base, self._extra
        if extra.position != 0.0 or not extra.standstill:
            state = State(
                base.position + extra.position, base.velocity + extra.velocity, base.acceleration + extra.acceleration
            )
            base.continue_from(state)
            extra.restart(0.0)

    # ------------------------------------------------------------------ gear

    def _follow(self, gear: Gear, hold: bool) -> None:
        """One cycle of a slave: on its way to the master's velocity, or locked."""
        place = self._masters.of(gear.master, gear.actual)
        gear.master_motion = gear.master_motion.moved(place, self._period)
        current = self._current
        assert current is not None
        if gear.begin is None:
            gear.seen += 1
            velocity, acceleration = gear.ratio * gear.master_motion.v, gear.ratio * gear.master_motion.a
            if not abs(velocity - gear.wanted) <= _ROUNDING * self._limits.velocity:
                gear.wanted = velocity
                self._base.move_at(velocity, gear.dynamics)
            p = self._base.step(1.0, hold)
            self._gear_state = State(p, self._base.velocity, self._base.acceleration)
            # locking changes velocity and acceleration by what is left, beside the jerk of the ramp: 1.5 times it together
            near = 0.25 * self._limits.jerk * self._period
            slow = abs(self._base.velocity - velocity) <= near * self._period
            if gear.seen > _SEEN and slow and abs(self._base.acceleration - acceleration) <= near:
                gear.begin = (p, place)
                gear.motion = Motion(p, velocity, acceleration, velocity - acceleration * self._period / 2.0)
                self._tell(current, JobState.REACHED)
            elif self._base.at_limit:
                self._lose_gear("it has come to its software limit")
            return
        slave, master = gear.begin
        motion = gear.motion.moved(slave + gear.ratio * (place - master), self._period)
        state = State(motion.p, motion.v, 0.0 if gear.actual else motion.a)  # actual values are too rough for it
        reason = "feed hold" if hold else self._beyond(state)
        if reason:
            self._lose_gear(reason)
            self._base.step()
        else:
            gear.motion, self._gear_state = motion, state

    def _beyond(self, state: State) -> str:
        """Why the slave cannot follow to a state, "" if it can; the added motion counts as well.

        From every state that it takes it can be brought to rest within its limits.
        """
        limits, extra, plan = self._limits, self._extra, self._stopping_plan
        least, greatest = self._least - self._offset, self._greatest - self._offset
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
        return f"it could not stop any more before its software limit ({low + self._offset:.3f} ... {high + self._offset:.3f})"

    def _lose_gear(self, reason: str) -> None:
        current = self._current
        assert current is not None
        self._fail(current, self._problem(errors.JOB_GEAR_LOST, current.job, what=reason))
        self._leave_gear()
        self._join()
        if self._added is not None:
            self._tell(self._added, JobState.ABORTED)
        self._current = self._added = None
        self._base.stop()
        self.error = errors.JOB_GEAR_LOST.id
        self.state = MotionState.ERROR_STOP

    def _leave_gear(self) -> None:
        """The slave goes on from where the gear has brought it."""
        if self._gear is not None:
            if self._gear.begin is not None:
                self._base.continue_from(self._gear_state)
            self._gear = None

    # ------------------------------------------------------------------ what is refused

    def _refusal(self, job: Job, cycle: AxisCycle) -> Problem | None:
        """Why a job cannot begin; nothing changes then."""
        function = job.function
        if function is AxisFunction.RESET:
            return None
        if not cycle.enabled:
            return self._problem(errors.JOB_DISABLED, job)
        if function in (AxisFunction.TOUCH_PROBE, AxisFunction.ABORT_TRIGGER):
            return None if function is AxisFunction.ABORT_TRIGGER else self._wrong_probe(job)
        if cycle.in_path:
            return self._problem(errors.JOB_IN_PATH, job)
        if self.state is MotionState.ERROR_STOP:
            return self._problem(errors.JOB_ERROR_STOP, job)
        if self.state is MotionState.STOPPING and function is not AxisFunction.STOP:
            return self._problem(errors.JOB_STOPPING, job)
        if self.homes and function not in (AxisFunction.STOP, AxisFunction.HALT):
            return self._problem(errors.JOB_HOMES, job)
        if function is AxisFunction.HOME and not self._absolute:
            if self.homing is None or (cycle.cam is None and not self.homing.by_drive):
                return self._problem(errors.JOB_HOME, job)
            if self.moving:
                return self._problem(errors.JOB_HOME_MOVES, job)
            self._on_cam = bool(cycle.cam)
        wrong = wrong_values(job, 0.0 if self._modulo else job.position - self.position)
        if wrong:
            return self._problem(errors.JOB_VALUE, job, what=wrong)
        if self._waits(job):
            return self._problem(errors.JOB_BUFFER_FULL, job) if self._next is not None else None
        if function in (AxisFunction.GEAR_OUT, AxisFunction.PHASING) and self._gear is None:
            return self._problem(errors.JOB_NO_GEAR, job)
        if function is AxisFunction.PHASING and job.master and not self._follows(job.master):
            return self._problem(errors.JOB_OTHER_MASTER, job, master=job.master)
        if function in _SUPERIMPOSED or function in _MOVES:
            return self._aims_beyond(job)
        if function is AxisFunction.GEAR_IN and self._masters.numbers.get(job.master, self._index) == self._index:
            return self._problem(errors.JOB_MASTER, job, master=job.master)
        return None

    def _follows(self, master: int) -> bool:
        return self._gear is not None and self._masters.numbers.get(master) == self._gear.master

    def _wrong_probe(self, job: Job) -> Problem | None:
        if job.mode not in (1, 2) or job.master < 1:
            return self._problem(
                errors.JOB_VALUE, job, what="a probe has an input from 1 and mode 1 (falling) or 2 (rising)"
            )
        if job.master >= DRIVE_PROBES and (job.master, job.mode) not in self._probes:
            return self._problem(errors.JOB_NO_PROBE, job, number=job.master - DRIVE_PROBES + 1)
        return None

    def _aims_beyond(self, job: Job) -> Problem | None:
        """A target outside of the software limits."""
        function = job.function
        if function in _SUPERIMPOSED:
            moving = self._current is not None and self._current.job.function in _MOVES and self._current.open
            target = (self._base.target + self._offset if moving else self.position) + job.position
        elif function in _MOVES:
            target = self._target(job)
        else:
            return None
        if self._least <= target <= self._greatest:
            return None
        return self._problem(errors.JOB_LIMIT, job, position=target, least=self._least, greatest=self._greatest)

    # ------------------------------------------------------------------ telling

    def _problem(self, entry: ErrorEntry, job: Job, **values: object) -> Problem:
        return Problem(entry, {"axis": self.name, "function": spelt(job), **values})

    def _fail(self, followed: Followed, problem: Problem) -> None:
        self.problems.append(problem)
        followed.answer = Answer(JobState.ERROR, problem.entry.id)
        self.changed.append(followed)

    def _tell(self, followed: Followed, state: JobState) -> None:
        if followed.answer.state is not state:
            followed.answer = Answer(state)
            self.changed.append(followed)
