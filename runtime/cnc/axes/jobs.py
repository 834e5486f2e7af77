"""Axis jobs: the motion blocks of PLCopen, executed in the cycle beside the path.

    Disabled ── enabled ──▶ Standstill ◀──────────── done ─────────────┐
                               │ move                                  │
                               ├──▶ DiscreteMotion ────────────────────┤
                               ├──▶ ContinuousMotion   (MoveVelocity, GearOut)
                               ├──▶ SynchronizedMotion (GearIn)        │
                               ├──▶ Homing ────────────────────────────┤
    from each of them:         ├──▶ Stopping  (MC_Stop, until Execute falls)
                               └──▶ ErrorStop (the machine had to stop the axis, until MC_Reset)

An axis has one job that moves it, one that waits (buffer modes), one that is superimposed, and a probe. How they move it is
`job_motion`. No job leads beyond a software limit: a target there is refused, an endless motion comes to rest at it.

Units: mm or degrees, and seconds.
"""

from __future__ import annotations

from dataclasses import replace

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.drive_order import DriveOrder
from runtime.cnc.axes.gear import Gear, MasterPlaces
from runtime.cnc.axes.homing import AxisHoming, HomingPhase
from runtime.cnc.axes.job_motion import JobMotion
from runtime.cnc.axes.job_probe import JobProbe
from runtime.cnc.axes.job_refusals import aims_beyond, refusal
from runtime.cnc.axes.job_values import (
    ACTUAL_VALUES,
    BY_DRIVE,
    MOVES,
    PHASE_COMPENSATION,
    STATES,
    SUPERIMPOSED,
    AxisCycle,
    Followed,
    dynamics_of,
    spelt,
)
from runtime.cnc.axes.single_axis import Goal
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.errors import ErrorEntry, Problem
from runtime.hli.axis_jobs import Answer, Job
from runtime.hli.layout import AxisFunction, BufferMode, JobState, MotionState


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
        self.index = index
        self._limits = limits
        self.absolute = absolute
        self.motion = JobMotion(limits, period, least, greatest, masters, modulo=modulo)
        self.base = self.motion.base
        self.homing: AxisHoming | None = None  # of `base`; of an axis that has to look for its reference
        self._on_cam = False  # where homing begins
        self.drive: DriveOrder | None = None  # of an axis whose drive may move it by itself
        self.current: Followed | None = None
        self.following: Followed | None = None
        self._added: Followed | None = None  # superimposed
        self.probe = JobProbe(probes)
        self.recorded: float | None = None  # by the last probe
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
            self.motion.begin(cycle.set_point)
        refused = refusal(self, job, cycle)
        if refused is not None:
            self._fail(followed, refused)
            return
        function = job.function
        if function is AxisFunction.RESET:
            self.reset()
            self._tell(followed, JobState.DONE)
        elif function is AxisFunction.HOME and self.absolute:
            self._tell(followed, JobState.DONE)
        elif function is AxisFunction.TOUCH_PROBE:
            self.wait_for_edge(followed)
            self._tell(followed, JobState.ACTIVE)
        elif function is AxisFunction.ABORT_TRIGGER:
            self.wait_for_edge(None)
            self._tell(followed, JobState.DONE)
        elif function in SUPERIMPOSED:
            self.owned = True
            self._superimpose(followed)
        elif self.waits(job):
            self.following = followed
            self._tell(followed, JobState.BUSY)
            self._blend()
        else:
            self.owned = True
            self._on_cam = bool(cycle.cam)
            self._start(followed)

    def stop(self, reason: str) -> None:
        """The machine stops the axis: jobs end with an error, the axis comes to rest, its state is ErrorStop."""
        busy = [
            followed
            for followed in (self.current, self.following, self._added)
            if followed is not None and followed.open
        ]
        if not busy:
            return
        for followed in busy:
            self._fail(followed, self.problem(errors.JOB_STOPPED, followed.job, reason=reason))
        self.motion.uncouple()
        self.motion.join()
        self.current = self.following = self._added = None
        if self.homes and self.homing is not None:
            self.homing.cancel()
        elif self.driven and self.drive is not None:
            self.drive.brake()
        else:
            self.base.stop()
        self.error = errors.JOB_STOPPED.id
        self.state = MotionState.ERROR_STOP

    def let_go(self) -> None:
        """Somebody else says where the axis goes, or nobody: no motion is left, a probe still waits."""
        for followed in (self.current, self.following, self._added):
            if followed is not None and followed.open:
                self._tell(followed, JobState.ABORTED)
        self.current = self.following = self._added = self.motion.gear = None
        if self.homes and self.homing is not None:
            self.homing.forget()
        if self.driven and self.drive is not None:
            self.drive.forget()
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
        if self.driven and self.drive is not None:
            self._follow_drive(self.drive, cycle)
            return None
        stopping = self.current is None or self.current.job.function in (AxisFunction.STOP, AxisFunction.HALT)
        gear = self.motion.gear
        if gear is not None:
            self._follow(gear, cycle.hold)
        else:
            self.base.step(1.0 if stopping else cycle.override, cycle.hold and not stopping)
        if self._added is not None:
            self.motion.extra.step(cycle.override, cycle.hold)
        self._judge(cycle)
        if self._added is not None and self.motion.extra.arrived:
            self.motion.added()
            self._tell(self._added, JobState.DONE)
            self._added = None
        return self.position

    @property
    def driven(self) -> bool:
        """The drive moves the axis by itself, or comes to rest from that."""
        return self.drive is not None and not self.drive.over

    def _follow_drive(self, drive: DriveOrder, cycle: AxisCycle) -> None:
        """One cycle of an axis that its drive moves: it tracks, and goes on from where it stands."""
        current = self.current
        drive.step(cycle.override, cycle.hold)
        if drive.over:
            self.motion.begin(cycle.actual)
            return
        if drive.runs_away:  # every drive brakes by itself: this one's torque does not
            problem = Problem(errors.JOB_RUNS_AWAY, {"axis": self.name, "speed": drive.speed, "allowed": drive.allowed})
            if current is not None and current.open:
                self._fail(current, problem)
            else:
                self.problems.append(problem)
            self.current, self.error = None, errors.JOB_RUNS_AWAY.id
            drive.forget()
            return
        if current is None or current.job.function not in BY_DRIVE:
            return
        if drive.late or drive.at_limit:
            entry = errors.JOB_DRIVE_LATE if drive.late else errors.JOB_AT_LIMIT
            self._fail(current, self.problem(entry, current.job))
            self.current = None
            drive.brake()
            return
        self._tell(current, JobState.REACHED if drive.reached else JobState.ACTIVE)

    @property
    def homes(self) -> bool:
        """The axis looks for its reference, or comes to rest from that."""
        return self.homing is not None and not self.homing.over

    def _home(self, homing: AxisHoming, cycle: AxisCycle) -> None:
        """One cycle of homing; where the coordinates shift, `shift` has that for the caller."""
        current = self.current
        self.shift = homing.step(bool(cycle.cam), cycle.actual, 0.0, cycle.override, cycle.hold)
        if homing.phase is HomingPhase.LATE:
            homing.phase = HomingPhase.STOPPING
        elif homing.phase is not HomingPhase.DONE and homing.phase is not HomingPhase.FAILED:
            return
        self.motion.set_base_limits()
        if current is None or current.job.function is not AxisFunction.HOME:
            return
        if homing.phase is HomingPhase.DONE:
            self.referenced = True
            self._end(current)
            return
        self._fail(current, self.problem(errors.JOB_HOME_FAILED, current.job))
        self.current = None
        self.error = errors.JOB_HOME_FAILED.id
        self.state = MotionState.ERROR_STOP

    @property
    def position(self) -> float:
        """The set-point."""
        return self.motion.position

    @property
    def standing(self) -> bool:
        """The set-point rests."""
        return not self.owned or (self.motion.standing and not self.homes and not self.driven)

    @property
    def moving(self) -> bool:
        """A job has the axis, or it does not yet rest."""
        return self.owned and (self.current is not None or self._added is not None or not self.standing)

    def latch(self, position: float) -> None:
        """The probe has seen the edge that is waited for, where the axis was at `position`."""
        followed = self.probe.wait(None)
        if followed is not None:
            self.recorded = position
            followed.answer = Answer(JobState.DONE, 0, position)
            self.changed.append(followed)

    def wait_for_edge(self, followed: Followed | None) -> None:
        """The probe waits for this job from now on, or for none."""
        before = self.probe.wait(followed)
        self.recorded = None
        if before is not None:
            self._tell(before, JobState.ABORTED)

    def _absent(self, cycle: AxisCycle) -> None:
        """The axis is off, or belongs to the path."""
        if self.owned:
            if cycle.fault and self.current is not None:
                self._fail(
                    self.current, self.problem(errors.JOB_STOPPED, self.current.job, reason="its drive has failed")
                )
                self.error = errors.JOB_STOPPED.id
            self.let_go()
        if cycle.enabled:
            self.state = MotionState.ERROR_STOP if self.error else MotionState.STANDSTILL
        else:
            self.state = MotionState.ERROR_STOP if cycle.fault else MotionState.DISABLED

    def _judge(self, cycle: AxisCycle) -> None:
        """What the present job has reached, and what follows it."""
        current = self.current
        if current is None:
            if self.standing and self._added is None:
                self.owned = False
                self.state = MotionState.ERROR_STOP if self.error else MotionState.STANDSTILL
            return
        function = current.job.function
        base = self.base
        if function in MOVES:
            passed = base.goal is Goal.SPEED
            if passed or (base.arrived and (cycle.in_position or self.following is not None)):
                self._end(current)
        elif function is AxisFunction.HALT:
            if base.standstill and cycle.in_position:
                self._end(current)
        elif function is AxisFunction.STOP:
            if current.open and base.standstill and cycle.in_position:
                self._tell(current, JobState.DONE)
            if not current.open and not cycle.stop_hold:
                self.current = None
        elif self.motion.gear is None:
            if base.at_limit:
                self._fail(current, self.problem(errors.JOB_AT_LIMIT, current.job))
                self.current = None
                base.stop()
            else:
                self._tell(current, JobState.REACHED if base.arrived else JobState.ACTIVE)
                if base.arrived and self.following is not None:
                    self._end(current)

    def _end(self, current: Followed) -> None:
        """A job is done; the one that waits begins."""
        self._tell(current, JobState.DONE)
        self.current, following = None, self.following
        self.following = None
        if following is not None:
            refused = aims_beyond(self, following.job)
            if refused is None:
                self._start(following)
                return
            self._fail(following, refused)
            self.base.stop()

    # ------------------------------------------------------------------ beginning

    def _start(self, followed: Followed) -> None:
        """The job takes the axis over, from whatever is in motion."""
        job, before = followed.job, self.current
        dynamics = dynamics_of(job, self._limits)
        target = self.target(job)
        for other in (before, self.following, self._added):
            if other is not None and other.open:
                self._tell(other, JobState.ABORTED)
        self.motion.uncouple()
        self.motion.join()
        self._added = self.following = None
        self.current = followed
        self.motion.set_base_limits()
        function = job.function
        if self.homes and self.homing is not None:
            self.homing.cancel()
        elif function is AxisFunction.HOME and self.homing is not None:
            self.motion.begin(self.position)
            self.homing.begin(self._on_cam)
        elif function in BY_DRIVE and self.drive is not None:
            self.drive.begin(job, dynamics)
        elif self.driven and self.drive is not None:
            self.drive.brake(dynamics)
        elif function in MOVES:
            self.base.move_to(target - self.motion.offset, dynamics)
        elif function is AxisFunction.MOVE_VELOCITY:
            self.base.move_at(self.motion.endless_velocity(job), dynamics)
        elif function is AxisFunction.GEAR_IN:
            self.motion.couple(self._gear_of(job, dynamics))
        elif function is AxisFunction.GEAR_OUT:
            self.base.move_at(self.base.velocity, dynamics)
        else:
            self.base.stop(dynamics)
        self.state = STATES[function]
        self._tell(followed, JobState.DONE if function is AxisFunction.GEAR_OUT else JobState.ACTIVE)
        if function is AxisFunction.GEAR_OUT:
            onwards = replace(job, function=AxisFunction.MOVE_VELOCITY, number=0)  # nobody waits for it
            self.current = None if self.base.standstill else Followed(onwards, Answer(JobState.ACTIVE))

    def _gear_of(self, job: Job, dynamics: Dynamics) -> Gear:
        masters = self.motion.masters
        master, actual = masters.numbers[job.master], bool(job.mode & ACTUAL_VALUES)
        phase = job.position if job.mode & PHASE_COMPENSATION else None
        ratio = job.numerator / job.denominator
        return Gear(master, ratio, dynamics, masters.of(master, actual), self.motion.catch, actual=actual, phase=phase)

    def target(self, job: Job) -> float:
        """Where a motion leads, in coordinates of the axis."""
        function = job.function
        if function is AxisFunction.MOVE_ABSOLUTE:
            return self.motion.target(job)
        discrete = self.current is not None and self.current.job.function in MOVES
        if function is AxisFunction.MOVE_ADDITIVE and discrete:
            return self.base.target + self.motion.offset + job.position
        return self.position + job.position

    def waits(self, job: Job) -> bool:
        """The job begins when the present one is done."""
        return (
            job.buffer_mode is not BufferMode.ABORTING
            and job.function not in (AxisFunction.STOP, *SUPERIMPOSED)
            and self.current is not None
            and self.current.open
        )

    def _blend(self) -> None:
        """The present move passes its target as the buffer mode of the next one says."""
        current, following = self.current, self.following
        if current is not None and following is not None:
            self.motion.blend(current.job, following.job)

    # ------------------------------------------------------------------ superimposed motion

    def _superimpose(self, followed: Followed) -> None:
        job = followed.job
        if self._added is not None:
            self._tell(self._added, JobState.ABORTED)
            self._added = None
            self.motion.join()
        current = self.current
        if current is None and self.base.standstill:
            room: Dynamics | None = dynamics_of(job, self._limits)
        else:  # without a job the base comes to rest from what was joined
            room = self.motion.room(job, current.job if current is not None and current.open else None)
        if room is None:
            what = "velocity and acceleration of both are more than it can"
            self._fail(followed, self.problem(errors.JOB_NO_ROOM, job, what=what))
            return
        self._added = followed
        self.motion.add(job.position, room)
        if current is None:
            self.state = MotionState.DISCRETE_MOTION
        self._tell(followed, JobState.ACTIVE)

    # ------------------------------------------------------------------ gear

    def _follow(self, gear: Gear, hold: bool) -> None:
        """One cycle of a slave."""
        current = self.current
        assert current is not None
        locked = gear.begin is not None
        reason = self.motion.follow(gear, hold)
        if reason:
            self._lose_gear(reason)
            if locked:  # else the approach has moved it already
                self.base.step()
        elif gear.caught:
            self._tell(current, JobState.REACHED)

    def _lose_gear(self, reason: str) -> None:
        current = self.current
        assert current is not None
        self._fail(current, self.problem(errors.JOB_GEAR_LOST, current.job, what=reason))
        self.motion.uncouple()
        self.motion.join()
        if self._added is not None:
            self._tell(self._added, JobState.ABORTED)
        self.current = self._added = None
        self.base.stop()
        self.error = errors.JOB_GEAR_LOST.id
        self.state = MotionState.ERROR_STOP

    # ------------------------------------------------------------------ telling

    def problem(self, entry: ErrorEntry, job: Job, **values: object) -> Problem:
        """What is wrong with a job of this axis."""
        return Problem(entry, {"axis": self.name, "function": spelt(job), **values})

    def _fail(self, followed: Followed, problem: Problem) -> None:
        self.problems.append(problem)
        followed.answer = Answer(JobState.ERROR, problem.entry.id)
        self.changed.append(followed)

    def _tell(self, followed: Followed, state: JobState) -> None:
        if followed.answer.state is not state:
            followed.answer = Answer(state)
            self.changed.append(followed)
