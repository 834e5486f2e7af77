"""The slot for jobs of an axis (hli.mech.single-axis-commanding), from both sides.

PLC   command_w ── semaphor ──▶ CNC       at most one job per axis and PLC cycle; a stop overwrites what waits
PLC   ◀── answers_r[number % JOBS] ── CNC       what became of the last jobs
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from runtime.diagnostics.catalogue.axis_jobs import JOB_UNKNOWN
from runtime.hli.layout import JOBS, Axis, AxisFunction, BufferMode, Direction, JobState
from runtime.hli.units import LENGTH, SPEED


@dataclass(frozen=True, slots=True)
class Job:
    """A job in mm, degrees and seconds; None where the dynamics of the axis count."""

    function: AxisFunction
    position: float = 0.0  # position, distance or phase
    velocity: float = 0.0
    acceleration: float | None = None
    deceleration: float | None = None
    jerk: float | None = None
    direction: Direction = Direction.SHORTEST
    buffer_mode: BufferMode = BufferMode.ABORTING
    mode: int = 0
    master: int = 0  # logical axis number, or number of the probe input
    numerator: float = 1.0
    denominator: float = 1.0
    torque: float = 0.0  # share of the rated torque
    torque_ramp: float = 0.0  # shares per second, 0: at once
    number: int = 0


class Answer(NamedTuple):
    """What became of a job."""

    state: JobState
    error: int = 0
    position: float = 0.0  # recorded by the probe


class JobGiver:
    """The PLC's side, of one axis."""

    def __init__(self, axis: Axis) -> None:
        self._unit = axis.job
        self._number = max((int(answer.number_r) for answer in self._unit.answers_r), default=0)

    def give(self, job: Job) -> int | None:
        """Put a job into the slot; its number, or None if the slot is in use (then try again in the next cycle)."""
        unit = self._unit
        if unit.command_semaphor_rw and job.function is not AxisFunction.STOP:
            return None
        unit.command_semaphor_rw = False  # a stop takes the place of what waits
        self._number += 1
        command = unit.command_w
        command.number = self._number
        command.function = job.function
        command.buffer_mode = job.buffer_mode
        command.direction = job.direction
        command.mode = job.mode
        command.master = job.master
        command.position = round(job.position / LENGTH)
        command.velocity = round(job.velocity / SPEED)
        command.acceleration = job.acceleration or 0.0
        command.deceleration = job.deceleration or 0.0
        command.jerk = job.jerk or 0.0
        command.numerator = job.numerator
        command.denominator = job.denominator
        command.torque, command.torque_ramp = job.torque, job.torque_ramp
        unit.command_semaphor_rw = True
        return self._number

    def hold_stop(self, hold: bool) -> None:
        """Whether the axis stays in the state Stopping."""
        self._unit.stop_hold_w = hold

    def answer(self, number: int) -> Answer:
        """What became of a job; one of which nothing is known any more was overtaken by others."""
        answer = self._unit.answers_r[number % JOBS]
        if answer.number_r == number:
            return Answer(JobState(answer.state_r), answer.error_r, answer.position_r * LENGTH)
        waits = self._unit.command_semaphor_rw and self._unit.command_w.number == number
        return Answer(JobState.BUSY if waits else JobState.ABORTED)


class JobSlot:
    """The CNC's side, of one axis."""

    def __init__(self, axis: Axis) -> None:
        self.unit = axis.job

    def take(self) -> Job | None:
        """The job that waits; None without one, and for one whose numbers are none of this interface."""
        unit = self.unit
        if not unit.command_semaphor_rw:
            return None
        command = unit.command_w
        number = int(command.number)
        try:
            job = Job(
                function=AxisFunction(command.function),
                position=command.position * LENGTH,
                velocity=command.velocity * SPEED,
                acceleration=command.acceleration if command.acceleration > 0.0 else None,
                deceleration=command.deceleration if command.deceleration > 0.0 else None,
                jerk=command.jerk if command.jerk > 0.0 else None,
                direction=Direction(command.direction or Direction.SHORTEST),
                buffer_mode=BufferMode(command.buffer_mode),
                mode=int(command.mode),
                master=int(command.master),
                numerator=float(command.numerator),
                denominator=float(command.denominator),
                torque=float(command.torque),
                torque_ramp=float(command.torque_ramp),
                number=number,
            )
        except ValueError:
            job = None
        unit.command_semaphor_rw = False
        unit.commands_taken_r += 1
        if job is None:
            self.answer(number, Answer(JobState.ERROR, JOB_UNKNOWN.id))
        return job

    def answer(self, number: int, answer: Answer) -> None:
        """Tell what became of a job."""
        told = self.unit.answers_r[number % JOBS]
        told.number_r = 0
        told.state_r = answer.state
        told.error_r = answer.error
        told.position_r = round(answer.position / LENGTH)
        told.number_r = number
