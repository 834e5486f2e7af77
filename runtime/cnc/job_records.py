"""Axis jobs of a program in records of the motion queue, and out of them."""

from __future__ import annotations

from runtime.cnc.blocks import AxisJob, AxisJobWait, Source
from runtime.cnc.motion_queue import ActionKind, GateReason, MotionQueue, RecordKind, Records
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, Direction

# an action has no place of its own on the path: the numbers of the job stand in fields of a motion
_POSITION, _VELOCITY, _ACCELERATION, _DECELERATION, _JERK, _NUMERATOR, _DENOMINATOR = range(7)


def write_job(record: Records, block: AxisJob) -> None:
    """The job as an action; dynamics of the axis are 0."""
    job = block.job
    record["kind"], record["action"] = RecordKind.ACTION, ActionKind.AXIS_JOB
    record["area"], record["size"], record["offset"] = block.axis, int(job.function), int(job.direction)
    record["axis0"], record["axis1"] = job.master, job.mode
    record["number"], record["sense"] = block.id, block.waits
    values = record["start"][0]
    values[_POSITION], values[_VELOCITY] = job.position, job.velocity
    values[_ACCELERATION], values[_DECELERATION] = job.acceleration or 0.0, job.deceleration or 0.0
    values[_JERK], values[_NUMERATOR], values[_DENOMINATOR] = job.jerk or 0.0, job.numerator, job.denominator


def write_wait(record: Records, block: AxisJobWait) -> None:
    """The gate."""
    record["kind"], record["reason"], record["number"] = RecordKind.GATE, GateReason.AXIS_JOBS, block.id


def read_job(queue: MotionQueue, index: int) -> AxisJob:
    """The job of an absolute index; valid while it is not freed."""
    record = queue.record(index)
    values = record["start"].tolist()
    n = int(record["n"])
    job = Job(
        AxisFunction(int(record["size"])),
        position=values[_POSITION],
        velocity=values[_VELOCITY],
        acceleration=values[_ACCELERATION] or None,
        deceleration=values[_DECELERATION] or None,
        jerk=values[_JERK] or None,
        direction=Direction(int(record["offset"])),
        mode=int(record["axis1"]),
        master=int(record["axis0"]),
        numerator=values[_NUMERATOR],
        denominator=values[_DENOMINATOR],
    )
    source = Source(queue.program_name(int(record["program"])), int(record["line"]), None if n < 0 else n)
    return AxisJob(source, int(record["area"]), job, int(record["number"]), bool(record["sense"]))
