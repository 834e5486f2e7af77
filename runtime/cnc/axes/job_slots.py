"""Axis jobs of the whole machine in the cycle: from the slots of the HLI to the set-points, and back what became of them."""

from __future__ import annotations

from collections import deque
from collections.abc import Callable
from typing import Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.drive_order import TORQUE_MODES, VELOCITY_MODES, DriveAbilities, DriveOrder
from runtime.cnc.axes.gear import MasterPlaces
from runtime.cnc.axes.homing import AxisHoming, HomingDrive
from runtime.cnc.axes.job_probe import DRIVE_PROBES
from runtime.cnc.axes.job_values import AxisCycle, Followed, spelt
from runtime.cnc.axes.jobs import AxisJobs
from runtime.cnc.axes.torque_governor import usual_gain
from runtime.config.machine import Axis, AxisType, Machine
from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.errors import Problem
from runtime.drives import (
    PROBE_2_SHIFT,
    PROBE_FALLING,
    PROBE_HAS_FALLEN,
    PROBE_HAS_RISEN,
    PROBE_IS_ON,
    PROBE_ON,
    PROBE_RISING,
    DriveImage,
    DriveMode,
)
from runtime.hli.axis_jobs import Answer, JobSlot
from runtime.hli.layout import Hli, JobState, MotionState
from runtime.hli.units import LENGTH

Commands = Callable[[int], tuple[float, bool]]  # index of an axis -> override, hold


def _probes(axis: Axis) -> frozenset[tuple[int, int]]:
    """Number and edge of the touch probes that the drive of an axis latches."""
    if axis.drive is None:
        return frozenset()
    edges = {"rising": 2, "falling": 1}
    names = [name.split("_") for name in axis.drive.process_data if name.startswith("probe_")]
    return frozenset((DRIVE_PROBES + int(number) - 1, edges[edge]) for _, number, edge in names)


def _drive_order(
    axis: Axis, i: int, image: DriveImage, period: float, torque_limits: npt.NDArray[np.float64]
) -> DriveOrder:
    """What the drive of an axis can be told to do by itself."""
    drive = axis.drive
    assert drive is not None
    offered = {DriveMode[name.upper()] for name in drive.modes} - {drive.runs_in(spindle=False)}
    tells_torque = "torque" in drive.process_data
    abilities = DriveAbilities(
        next((mode for mode in VELOCITY_MODES if mode in offered), None),
        next((mode for mode in TORQUE_MODES if mode in offered and tells_torque), None),
        tells_torque and "torque_limit" in drive.process_data,
        drive.max_torque or 1.0,
        drive.torque_gain or usual_gain(axis.acceleration),
    )
    least = -np.inf if axis.position_min is None else axis.position_min
    greatest = np.inf if axis.position_max is None else axis.position_max
    return DriveOrder(image, i, period, least, greatest, abilities, torque_limits)


class References(Protocol):
    """Cams and references of the axes, by their index in the machine."""

    def cam(self, axis: int) -> bool | None:
        """Whether the axis stands on its reference cam, None if nobody tells."""

    def shift(self, axis: int, way: float) -> None:
        """The coordinates of the axis shift as a whole."""

    def refer(self, axis: int, has_reference: bool) -> None:
        """The axis has its reference, or has lost it."""


class MachineJobs:
    """Built once; `step` is called in every cycle after the path has given its set-points."""

    def __init__(
        self,
        machine: Machine,
        hli: Hli,
        image: DriveImage,
        path: list[int],
        ordered: deque[tuple[int, Followed]] | None = None,
        references: References | None = None,
        torque_limits: npt.NDArray[np.float64] | None = None,
    ) -> None:
        """`path`: indices of the axes of the channel; `ordered`: jobs of its program with their axes, taken in every cycle.

        `references`: who knows cams and references of the axes; without it no axis can look for its reference.
        `torque_limits` (n,): of the PLC.
        """
        self._references = references
        self._ordered = deque[tuple[int, Followed]]() if ordered is None else ordered
        self._of_program: list[list[Followed]] = [[] for _ in machine.axes]
        self._image = image
        self._names = [axis.name for axis in machine.axes]
        self._path = [i in path for i in range(len(machine.axes))]
        numbers = {axis.log_axis: i for i, axis in enumerate(machine.axes) if axis.type is not AxisType.SPINDLE}
        masters = MasterPlaces(numbers, image.target_position, image.actual_position)
        period = machine.cycle.period
        self.axes: list[AxisJobs | None] = [
            None
            if axis.type is AxisType.SPINDLE
            else AxisJobs(
                axis.name,
                i,
                Dynamics(axis.velocity, axis.acceleration, axis.jerk),
                period,
                -np.inf if axis.position_min is None else axis.position_min,
                np.inf if axis.position_max is None else axis.position_max,
                masters,
                absolute=axis.homing is None,
                probes=_probes(axis),
                modulo=axis.type is AxisType.ROTARY and axis.position_min is None and axis.position_max is None,
            )
            for i, axis in enumerate(machine.axes)
        ]
        for i, (axis, jobs) in enumerate(zip(machine.axes, self.axes, strict=True)):
            if jobs is not None and axis.homing is not None and references is not None:
                jobs.homing = AxisHoming(axis, jobs.base, HomingDrive(image, i), period)
        allowed = np.full(len(machine.axes), np.inf) if torque_limits is None else torque_limits
        for i, (axis, jobs) in enumerate(zip(machine.axes, self.axes, strict=True)):
            if jobs is not None and axis.drive is not None:
                jobs.drive = _drive_order(axis, i, image, period, allowed)
        self._slots = [JobSlot(hli.axes[i]) for i in range(len(machine.axes))]
        self._units = [slot.unit for slot in self._slots]
        self._armed = [False] * len(machine.axes)  # the drive waits for the edge of its probe
        self._before: list[tuple[bool, bool, bool] | None] = [None] * len(machine.axes)
        self.problems: list[tuple[int, Problem]] = []  # with the axis; taken by the controller

    # ------------------------------------------------------------------ the cycle

    def step(
        self,
        enabled: list[bool],
        path_active: bool,
        faults: npt.NDArray[np.int8],
        in_position: npt.NDArray[np.bool_],
        commands: Commands,
    ) -> None:
        """One cycle: take what the slots hold and what the program orders, move the axes that jobs have, answer."""
        while self._ordered:
            axis, followed = self._ordered.popleft()
            self._of_program[axis].append(followed)
        for i, jobs in enumerate(self.axes):
            unit = self._units[i]
            waits = unit.command_semaphor_rw or self._of_program[i]
            if jobs is None:
                if waits:
                    self._refuse_spindle(i)
                continue
            state = (enabled[i], path_active and self._path[i], bool(faults[i]))
            if not (waits or jobs.owned or jobs.probe.input or state != self._before[i]):
                continue
            self._before[i] = state
            self._step_axis(i, jobs, state, bool(in_position[i]), commands)

    def _step_axis(
        self, i: int, jobs: AxisJobs, state: tuple[bool, bool, bool], in_position: bool, commands: Commands
    ) -> None:
        image, unit = self._image, self._units[i]
        override, hold = commands(i)
        on, in_path, fault = state
        actual = float(image.actual_position[i])
        cycle = AxisCycle(
            on, fault, in_path, float(image.target_position[i]), actual, in_position, override, hold, unit.stop_hold_w
        )
        references = self._references if jobs.homing is not None else None
        if references is not None:
            cycle.cam = references.cam(i)
        homed = jobs.homes
        job = self._slots[i].take()
        if job is not None:
            jobs.give(job, cycle)
        for followed in self._of_program[i]:
            jobs.take(followed, cycle)
        self._of_program[i].clear()
        self._step_probe(i, jobs, actual)
        place = jobs.step(cycle)
        if references is not None:
            self._tell_reference(i, jobs, references, homed)
        if place is not None:
            image.target_position[i] = place
        if jobs.changed or jobs.problems or unit.motion_state_r != jobs.state or unit.error_id_r != jobs.error:
            self._tell(i, jobs)

    def _tell_reference(self, i: int, jobs: AxisJobs, references: References, homed: bool) -> None:
        """What homing has done in this cycle; `homed`: it was under way before."""
        if jobs.homes and not homed:
            references.refer(i, False)
        if jobs.shift:
            references.shift(i, jobs.shift)
            jobs.shift = 0.0
        if jobs.referenced:
            jobs.referenced = False
            references.refer(i, True)

    def _step_probe(self, i: int, jobs: AxisJobs, actual: float) -> None:
        """An input of the image is seen once per cycle; a probe of the drive is latched by the drive itself."""
        image, number = self._image, jobs.probe.input
        if 0 < number < DRIVE_PROBES:
            bit = number - 1
            byte = int(image.digital_in[bit // 8]) if bit // 8 < len(image.digital_in) else 0
            if jobs.probe.edge(bool(byte >> bit % 8 & 1)):
                jobs.latch(actual)
        if number < DRIVE_PROBES:
            if self._armed[i]:
                image.probe_function[i], self._armed[i] = 0, False
            return
        if image.probe_function[i] and not self._armed[i]:
            return  # a measuring run has it: the job waits
        second = number > DRIVE_PROBES
        status = int(image.probe_status[i]) >> (PROBE_2_SHIFT if second else 0)
        stored, edge = (PROBE_HAS_RISEN, PROBE_RISING) if jobs.probe.rises else (PROBE_HAS_FALLEN, PROBE_FALLING)
        if not self._armed[i]:  # what an earlier order has latched must be gone
            self._armed[i] = not status & PROBE_IS_ON
            image.probe_function[i] = (PROBE_ON | edge) << (PROBE_2_SHIFT if second else 0) if self._armed[i] else 0
        elif status & stored:
            jobs.latch(float(image.probe_position[i, 2 * second + (not jobs.probe.rises)]))
            image.probe_function[i], self._armed[i] = 0, False

    def _tell(self, i: int, jobs: AxisJobs) -> None:
        slot, unit = self._slots[i], self._units[i]
        for followed in jobs.changed:
            if followed.job.number:
                slot.answer(followed.job.number, followed.answer)
        jobs.changed.clear()
        for problem in jobs.problems:
            self.problems.append((i, problem))
        jobs.problems.clear()
        unit.motion_state_r = jobs.state
        unit.error_id_r = jobs.error
        if jobs.recorded is not None:
            unit.probe_position_r = round(jobs.recorded / LENGTH)
        unit.probe_recorded_r = jobs.recorded is not None

    def _refuse_spindle(self, i: int) -> None:
        for followed in self._of_program[i]:  # the decoder lets none through
            followed.answer = Answer(JobState.ERROR, errors.JOB_SPINDLE.id)
        self._of_program[i].clear()
        slot = self._slots[i]
        job = slot.take()
        if job is not None:
            values = {"axis": self._names[i], "function": spelt(job)}
            self.problems.append((i, Problem(errors.JOB_SPINDLE, values)))
            slot.answer(job.number, Answer(JobState.ERROR, errors.JOB_SPINDLE.id))

    # ------------------------------------------------------------------ orders of the machine

    def stop(self, reason: str) -> None:
        """Every job ends, its axis comes to rest."""
        for jobs in self.axes:
            if jobs is not None:
                jobs.stop(reason)

    def let_go(self) -> None:
        """The drives brake by themselves (quick stop)."""
        for i, jobs in enumerate(self.axes):
            if jobs is not None and jobs.owned:
                jobs.stop("quick stop")
                jobs.let_go()
                self._tell(i, jobs)

    def reset(self) -> None:
        """Jobs under way end, probes wait no longer; axes that rest leave ErrorStop."""
        self.stop("reset")
        for i, jobs in enumerate(self.axes):
            if jobs is not None:
                jobs.reset()
                jobs.wait_for_edge(None)
                self._tell(i, jobs)

    # ------------------------------------------------------------------ what the others want to know

    @property
    def standing(self) -> bool:
        """No job moves an axis."""
        return all(jobs is None or jobs.standing for jobs in self.axes)

    def moved_path_axis(self) -> int | None:
        """An axis of the channel that a job has."""
        for i, jobs in enumerate(self.axes):
            if jobs is not None and self._path[i] and jobs.moving:
                return i
        return None

    def owns(self, i: int) -> bool:
        """Whether jobs say where an axis goes."""
        jobs = self.axes[i]
        return jobs is not None and jobs.owned

    def state(self, i: int) -> MotionState:
        """State of an axis in PLCopen's diagram; spindles are outside of it."""
        jobs = self.axes[i]
        return MotionState.DISABLED if jobs is None else jobs.state
