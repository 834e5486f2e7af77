"""What a job is made of: its kind, its inputs, what was told of it last, and what the axis finds in a cycle."""

from __future__ import annotations

import math
from dataclasses import dataclass, field

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.hli.axis_jobs import Answer, Job
from runtime.hli.layout import AxisFunction, Direction, JobState, MotionState

MOVES = (AxisFunction.MOVE_ABSOLUTE, AxisFunction.MOVE_RELATIVE, AxisFunction.MOVE_ADDITIVE)
ENDLESS = (AxisFunction.MOVE_VELOCITY, AxisFunction.GEAR_IN, AxisFunction.GEAR_OUT)
BY_DRIVE = (AxisFunction.TORQUE_CONTROL, AxisFunction.VELOCITY_BY_DRIVE)
SUPERIMPOSED = (AxisFunction.MOVE_SUPERIMPOSED, AxisFunction.PHASING)
ACTUAL_VALUES, PHASE_COMPENSATION = 128, 256  # bits of the mode of a gear
STATES = {
    **dict.fromkeys((*MOVES, AxisFunction.HALT), MotionState.DISCRETE_MOTION),
    AxisFunction.MOVE_VELOCITY: MotionState.CONTINUOUS_MOTION,
    AxisFunction.GEAR_OUT: MotionState.CONTINUOUS_MOTION,
    **dict.fromkeys(BY_DRIVE, MotionState.CONTINUOUS_MOTION),
    AxisFunction.GEAR_IN: MotionState.SYNCHRONIZED_MOTION,
    AxisFunction.STOP: MotionState.STOPPING,
    AxisFunction.HOME: MotionState.HOMING,
}
_OPEN = (JobState.BUSY, JobState.ACTIVE, JobState.REACHED)
_UNTOLD = Answer(JobState.NONE)


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


def spelt(job: Job) -> str:
    """MC_MoveAbsolute."""
    return f"MC_{job.function.name.title().replace('_', '')}"


def dynamics_of(job: Job, limits: Dynamics) -> Dynamics:
    """What a job may use; what it does not say is that of the axis."""
    return Dynamics(
        abs(job.velocity) or limits.velocity,
        job.acceleration or limits.acceleration,
        job.jerk or limits.jerk,
        job.deceleration or job.acceleration or limits.acceleration,
    ).within(limits)


def wrong_values(job: Job, way: float) -> str:
    """What is wrong with the inputs of a job, "" nothing; `way`: from where the axis is to the position of the job."""
    function = job.function
    values = (job.position, job.velocity, job.acceleration or 1.0, job.deceleration or 1.0, job.jerk or 1.0)
    if not all(map(math.isfinite, (*values, job.numerator, job.denominator, job.torque, job.torque_ramp))):
        return "a value is no finite number"
    if function in (*MOVES, *SUPERIMPOSED, AxisFunction.MOVE_VELOCITY, *BY_DRIVE) and not job.velocity > 0.0:
        return "the velocity has to be above 0"
    if function in BY_DRIVE and job.direction not in (Direction.POSITIVE, Direction.NEGATIVE):
        return "the direction is positive or negative"
    if job.torque_ramp < 0.0:
        return "the ramp of the torque is below 0"
    if function is AxisFunction.GEAR_IN and job.denominator == 0.0:
        return "the denominator of the ratio is 0"
    against = {Direction.POSITIVE: way < 0.0, Direction.NEGATIVE: way > 0.0}.get(job.direction, False)
    if function is AxisFunction.MOVE_ABSOLUTE and against:
        return "the axis is not modulo, so the position lies only in the other direction"
    return ""
