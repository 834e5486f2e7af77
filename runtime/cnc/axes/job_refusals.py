"""Why a job cannot begin. Nothing changes while that is found out."""

from __future__ import annotations

from typing import TYPE_CHECKING

from runtime.cnc.axes.job_probe import DRIVE_PROBES
from runtime.cnc.axes.job_values import BY_DRIVE, MOVES, SUPERIMPOSED, AxisCycle, wrong_values
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.errors import Problem
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, BufferMode, MotionState

if TYPE_CHECKING:
    from runtime.cnc.axes.jobs import AxisJobs


def refusal(jobs: AxisJobs, job: Job, cycle: AxisCycle) -> Problem | None:
    """Of a job that has just come."""
    function = job.function
    if function is AxisFunction.RESET:
        return None
    if not cycle.enabled:
        return jobs.problem(errors.JOB_DISABLED, job)
    if function is AxisFunction.ABORT_TRIGGER:
        return None
    if function is AxisFunction.TOUCH_PROBE:
        return _wrong_probe(jobs, job)
    return _taken(jobs, job, cycle) or _impossible(jobs, job, cycle)


def _taken(jobs: AxisJobs, job: Job, cycle: AxisCycle) -> Problem | None:
    """Somebody or something else has the axis."""
    function = job.function
    if cycle.in_path:
        return jobs.problem(errors.JOB_IN_PATH, job)
    if jobs.state is MotionState.ERROR_STOP:
        return jobs.problem(errors.JOB_ERROR_STOP, job)
    if jobs.state is MotionState.STOPPING and function is not AxisFunction.STOP:
        return jobs.problem(errors.JOB_STOPPING, job)
    if jobs.homes and function not in (AxisFunction.STOP, AxisFunction.HALT):
        return jobs.problem(errors.JOB_HOMES, job)
    stops = function in (AxisFunction.STOP, AxisFunction.HALT)
    if jobs.driven and not ((stops or function in BY_DRIVE) and job.buffer_mode is BufferMode.ABORTING):
        return jobs.problem(errors.JOB_BY_DRIVE, job)
    if function in BY_DRIVE:
        return _no_drive(jobs, job)
    if function is AxisFunction.HOME and not jobs.absolute:
        if jobs.homing is None or (cycle.cam is None and not jobs.homing.by_drive):
            return jobs.problem(errors.JOB_HOME, job)
        if jobs.moving:
            return jobs.problem(errors.JOB_HOME_MOVES, job)
    return None


def _no_drive(jobs: AxisJobs, job: Job) -> Problem | None:
    """The drive cannot move the axis by itself, or not now."""
    order = jobs.drive
    if order is None or order.mode_for(job.function) is None:
        what = "none of cyclic_synchronous_velocity and profile_velocity is among its `modes`"
        if job.function is AxisFunction.TORQUE_CONTROL:
            what = (
                "it needs torque in `process_data`, and cyclic_synchronous_torque or profile_torque among its `modes`; "
                "or torque and torque_limit, and cyclic_synchronous_velocity or profile_velocity"
            )
        return jobs.problem(errors.JOB_NO_DRIVE_MODE, job, what=what)
    if job.buffer_mode is not BufferMode.ABORTING or (jobs.moving and not jobs.driven):
        return jobs.problem(errors.JOB_DRIVE_MOVES, job)
    return None


def _impossible(jobs: AxisJobs, job: Job, cycle: AxisCycle) -> Problem | None:
    """What the job asks for cannot be."""
    function, motion = job.function, jobs.motion
    wrong = wrong_values(job, 0.0 if motion.modulo else job.position - jobs.position)
    if wrong:
        return jobs.problem(errors.JOB_VALUE, job, what=wrong)
    if jobs.waits(job):
        return jobs.problem(errors.JOB_BUFFER_FULL, job) if jobs.following is not None else None
    if function in (AxisFunction.GEAR_OUT, AxisFunction.PHASING) and motion.gear is None:
        return jobs.problem(errors.JOB_NO_GEAR, job)
    master = motion.masters.numbers.get(job.master)
    if function is AxisFunction.PHASING and job.master and (motion.gear is None or motion.gear.master != master):
        return jobs.problem(errors.JOB_OTHER_MASTER, job, master=job.master)
    if function is AxisFunction.GEAR_IN and master in (None, jobs.index):
        return jobs.problem(errors.JOB_MASTER, job, master=job.master)
    return aims_beyond(jobs, job)


def _wrong_probe(jobs: AxisJobs, job: Job) -> Problem | None:
    if job.mode not in (1, 2) or job.master < 1:
        what = "a probe has an input from 1 and mode 1 (falling) or 2 (rising)"
        return jobs.problem(errors.JOB_VALUE, job, what=what)
    if not jobs.probe.known(job):
        return jobs.problem(errors.JOB_NO_PROBE, job, number=job.master - DRIVE_PROBES + 1)
    return None


def aims_beyond(jobs: AxisJobs, job: Job) -> Problem | None:
    """A target outside of the software limits."""
    function, current, motion = job.function, jobs.current, jobs.motion
    if function in SUPERIMPOSED:
        moving = current is not None and current.job.function in MOVES and current.open
        target = (motion.base.target + motion.offset if moving else jobs.position) + job.position
    elif function in MOVES:
        target = jobs.target(job)
    else:
        return None
    if motion.least <= target <= motion.greatest:
        return None
    return jobs.problem(errors.JOB_LIMIT, job, position=target, least=motion.least, greatest=motion.greatest)
