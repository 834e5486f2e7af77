"""The motion blocks of PLCopen part 1, on axes of the machine.

    self.move(Axis=self.axes["B"], Execute=go, Position=90.0, Velocity=30.0)

Called in every cycle, as all blocks. A rising edge of Execute gives the job; Busy until it has ended, Active while it moves the
axis, then Done, CommandAborted (another job took the axis) or Error with ErrorID, for one call at least and as long as Execute is
TRUE. An axis takes one job per PLC cycle: the second one waits for the next cycle, only MC_Stop overtakes.

Positions mm or degrees, velocities per second; Acceleration, Deceleration and Jerk of 0 are those of the axis.

Every block is the same: `_FUNCTION`, the inputs of the job that its call hands on (`_INPUTS`), perhaps an output of its own.
Power, state and values of an axis are in `motion_reading`.
"""

from __future__ import annotations

from typing import ClassVar, Self

from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, BufferMode, Direction, JobState
from runtime.plc_logic.areas import AxisPort
from runtime.plc_logic.motion_reading import (
    MC_Power,
    MC_ReadActualPosition,
    MC_ReadActualVelocity,
    MC_ReadAxisError,
    MC_ReadCommandPosition,
    MC_ReadStatus,
    MC_SetOverride,
)

__all__ = [
    "BufferMode",
    "Direction",
    "MC_AbortTrigger",
    "MC_GearIn",
    "MC_GearOut",
    "MC_Halt",
    "MC_Home",
    "MC_MoveAbsolute",
    "MC_MoveAdditive",
    "MC_MoveRelative",
    "MC_MoveSuperimposed",
    "MC_MoveVelocity",
    "MC_MoveVelocityByDrive",
    "MC_Phasing",
    "MC_Power",
    "MC_ReadActualPosition",
    "MC_ReadActualVelocity",
    "MC_ReadAxisError",
    "MC_ReadCommandPosition",
    "MC_ReadStatus",
    "MC_Reset",
    "MC_SetOverride",
    "MC_Stop",
    "MC_TorqueControl",
    "MC_TouchProbe",
]

_ENDED = (JobState.DONE, JobState.ABORTED, JobState.ERROR)
_DYNAMICS = ("acceleration", "deceleration", "jerk")
_MOVE = ("position", "velocity", *_DYNAMICS)


class _Execute:
    """What the blocks with Execute have in common."""

    __slots__ = (
        "Active",
        "Busy",
        "CommandAborted",
        "Done",
        "Error",
        "ErrorID",
        "_axis",
        "_execute",
        "_job",
        "_number",
        "_reached",
        "_recorded",
        "_shown",
    )
    _FUNCTION: ClassVar[AxisFunction]
    _INPUTS: ClassVar[tuple[str, ...]] = ()  # names of Job, in the order in which a call hands their values on

    def __init__(self) -> None:
        self._clear()
        self._execute = False
        self._axis: AxisPort | None = None
        self._job: Job | None = None  # under way
        self._number: int | None = None  # None: the slot was in use
        self._reached = False  # the job goes on and has reached what it wants
        self._recorded = 0.0  # position of the answer of a job that was done

    def _clear(self) -> None:
        self.Done = self.Busy = self.Active = self.CommandAborted = self.Error = False
        self.ErrorID = 0
        self._shown = False  # an end was shown for one call

    def _order(self, axis: AxisPort, execute: bool, *inputs: float | int) -> Self:
        """The whole call of a block: on a rising edge the job with these inputs, then what became of it."""
        rising = execute and not self._execute
        self._execute = bool(execute)
        if rising or (self._job is None and not execute and self._shown):
            self._clear()
        if rising:
            values = dict(zip(self._INPUTS, inputs, strict=True))
            self._axis, self._job, self._number = axis, Job(self._FUNCTION, **values), None  # type: ignore[arg-type]
            self.Busy = True
        self._follow()
        return self

    def _follow(self) -> None:
        """Give the job if it was not yet, and look what became of it."""
        axis, job = self._axis, self._job
        if axis is None or job is None:
            self._shown = self._shown or self.Done or self.CommandAborted or self.Error
            return
        if self._number is None:
            self._number = axis.jobs.give(job)
            return
        answer = axis.jobs.answer(self._number)
        self.Active = answer.state in (JobState.ACTIVE, JobState.REACHED)
        self._reached = answer.state is JobState.REACHED
        if answer.state in _ENDED:
            self.Busy = self.Active = False
            self.Done = answer.state is JobState.DONE
            self.CommandAborted = answer.state is JobState.ABORTED
            self.Error = answer.state is JobState.ERROR
            self.ErrorID = answer.error
            if self.Done:
                self._recorded = answer.position
            self._job = None


# --------------------------------------------------------------------------------------------- one axis


class MC_MoveAbsolute(_Execute):  # noqa: N801 - PLCopen's name
    """To a position. Direction tells the way of a modulo axis."""

    __slots__ = ()
    _FUNCTION = AxisFunction.MOVE_ABSOLUTE
    _INPUTS = (*_MOVE, "direction", "buffer_mode")

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Position: float = 0.0,
        Velocity: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
        Direction: Direction = Direction.SHORTEST,
        BufferMode: BufferMode = BufferMode.ABORTING,
    ) -> Self:
        return self._order(Axis, Execute, Position, Velocity, Acceleration, Deceleration, Jerk, Direction, BufferMode)


class MC_MoveRelative(_Execute):  # noqa: N801
    """A way from where the axis is when the job begins."""

    __slots__ = ()
    _FUNCTION = AxisFunction.MOVE_RELATIVE
    _INPUTS = (*_MOVE, "buffer_mode")

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Distance: float = 0.0,
        Velocity: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
        BufferMode: BufferMode = BufferMode.ABORTING,
    ) -> Self:
        return self._order(Axis, Execute, Distance, Velocity, Acceleration, Deceleration, Jerk, BufferMode)


class MC_MoveAdditive(MC_MoveRelative):  # noqa: N801
    """A way from the target of the move under way; without one, as MC_MoveRelative."""

    __slots__ = ()
    _FUNCTION = AxisFunction.MOVE_ADDITIVE


class MC_MoveSuperimposed(_Execute):  # noqa: N801
    """A way on top of the motion under way, which goes on."""

    __slots__ = ()
    _FUNCTION = AxisFunction.MOVE_SUPERIMPOSED
    _INPUTS = _MOVE

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Distance: float = 0.0,
        VelocityDiff: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
    ) -> Self:
        return self._order(Axis, Execute, Distance, VelocityDiff, Acceleration, Deceleration, Jerk)


class MC_MoveVelocity(_Execute):  # noqa: N801
    """Endless motion; InVelocity while it has its velocity. At a software limit it comes to rest with an error."""

    __slots__ = ()
    _FUNCTION = AxisFunction.MOVE_VELOCITY
    _INPUTS = ("velocity", *_DYNAMICS, "direction", "buffer_mode")

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Velocity: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
        Direction: Direction = Direction.POSITIVE,
        BufferMode: BufferMode = BufferMode.ABORTING,
    ) -> Self:
        return self._order(Axis, Execute, Velocity, Acceleration, Deceleration, Jerk, Direction, BufferMode)

    @property
    def InVelocity(self) -> bool:  # noqa: N802
        return self._reached


class MC_MoveVelocityByDrive(_Execute):  # noqa: N801
    """Endless motion that the drive carries out in a velocity mode (`modes` of the drive); InVelocity while it has it.

    Begins at rest, or takes the place of an order to the drive; MC_Halt and MC_Stop end it. It keeps the software limits.
    """

    __slots__ = ()
    _FUNCTION = AxisFunction.VELOCITY_BY_DRIVE
    _INPUTS = ("velocity", "acceleration", "deceleration", "direction")

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Velocity: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Direction: Direction = Direction.POSITIVE,
    ) -> Self:
        return self._order(Axis, Execute, Velocity, Acceleration, Deceleration, Direction)

    @property
    def InVelocity(self) -> bool:  # noqa: N802
        return self._reached


class MC_TorqueControl(_Execute):  # noqa: N801
    """A torque (share of the rated one, with its sign) up to a velocity; InTorque while the drive tells that torque.

    TorqueRamp in shares per second, 0: at once. A drive that has cyclic_synchronous_torque or profile_torque among its `modes`,
    and torque in `process_data`, gets the torque itself, which the control takes back where the velocity would be passed. Any
    other one does it in a velocity mode with a torque limit (`modes`, and torque and torque_limit in `process_data`);
    `drive_mode` of the axis tells which. Ends as MC_MoveVelocityByDrive.
    """

    __slots__ = ()
    _FUNCTION = AxisFunction.TORQUE_CONTROL
    _INPUTS = ("torque", "torque_ramp", "velocity", "acceleration", "deceleration", "direction")

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Torque: float = 0.0,
        TorqueRamp: float = 0.0,
        Velocity: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Direction: Direction = Direction.POSITIVE,
    ) -> Self:
        return self._order(Axis, Execute, Torque, TorqueRamp, Velocity, Acceleration, Deceleration, Direction)

    @property
    def InTorque(self) -> bool:  # noqa: N802
        return self._reached


class MC_Halt(_Execute):  # noqa: N801
    """To rest; another job may take the axis meanwhile."""

    __slots__ = ()
    _FUNCTION = AxisFunction.HALT
    _INPUTS = (*_DYNAMICS, "buffer_mode")

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
        BufferMode: BufferMode = BufferMode.ABORTING,
    ) -> Self:
        return self._order(Axis, Execute, Deceleration, Deceleration, Jerk, BufferMode)


class MC_Stop(_Execute):  # noqa: N801
    """To rest, and no other job is taken as long as Execute is TRUE (state Stopping)."""

    __slots__ = ()
    _FUNCTION = AxisFunction.STOP
    _INPUTS = _DYNAMICS

    def __call__(self, Axis: AxisPort, Execute: bool, Deceleration: float = 0.0, Jerk: float = 0.0) -> Self:
        if self._execute is not bool(Execute):
            Axis.jobs.hold_stop(bool(Execute))
        return self._order(Axis, Execute, Deceleration, Deceleration, Jerk)


class MC_Home(_Execute):  # noqa: N801
    """Homing: at the cam or by the drive, as the machine description says, and to the position of the reference.

    An axis with an absolute encoder has its reference, the job is done at once.
    """

    __slots__ = ()
    _FUNCTION = AxisFunction.HOME

    def __call__(self, Axis: AxisPort, Execute: bool) -> Self:
        return self._order(Axis, Execute)


class MC_Reset(_Execute):  # noqa: N801
    """Leaves ErrorStop. A fault of the drive is acknowledged by a reset of the machine, which ends a program too."""

    __slots__ = ()
    _FUNCTION = AxisFunction.RESET

    def __call__(self, Axis: AxisPort, Execute: bool) -> Self:
        if Execute and not self._execute and Axis.error:
            Axis.reset()
        return self._order(Axis, Execute)


# --------------------------------------------------------------------------------------------- several axes


class MC_GearIn(_Execute):  # noqa: N801
    """The slave follows the master's velocity times RatioNumerator / RatioDenominator; InGear when it does.

    Mode 0 follows the master's commanded place, 128 its actual one. With 256 beside it the slave also goes to where it is
    ratio · place of the master + PhaseShift.
    """

    __slots__ = ()
    _FUNCTION = AxisFunction.GEAR_IN
    _INPUTS = ("master", "numerator", "denominator", *_DYNAMICS, "mode", "buffer_mode", "position")

    def __call__(
        self,
        Master: AxisPort,
        Slave: AxisPort,
        Execute: bool,
        RatioNumerator: float = 1.0,
        RatioDenominator: float = 1.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
        Mode: int = 0,
        BufferMode: BufferMode = BufferMode.ABORTING,
        PhaseShift: float = 0.0,
    ) -> Self:
        ratio = (Master.number, RatioNumerator, RatioDenominator)
        return self._order(Slave, Execute, *ratio, Acceleration, Deceleration, Jerk, Mode, BufferMode, PhaseShift)

    @property
    def InGear(self) -> bool:  # noqa: N802
        return self._reached


class MC_GearOut(_Execute):  # noqa: N801
    """The slave leaves its master and goes on with its velocity."""

    __slots__ = ()
    _FUNCTION = AxisFunction.GEAR_OUT

    def __call__(self, Slave: AxisPort, Execute: bool) -> Self:
        return self._order(Slave, Execute)


class MC_Phasing(_Execute):  # noqa: N801
    """Shifts the slave against its master by PhaseShift."""

    __slots__ = ()
    _FUNCTION = AxisFunction.PHASING
    _INPUTS = (*_MOVE, "master")

    def __call__(
        self,
        Master: AxisPort,
        Slave: AxisPort,
        Execute: bool,
        PhaseShift: float = 0.0,
        Velocity: float = 0.0,
        Acceleration: float = 0.0,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
    ) -> Self:
        return self._order(Slave, Execute, PhaseShift, Velocity, Acceleration, Deceleration, Jerk, Master.number)


# --------------------------------------------------------------------------------------------- probes


class MC_TouchProbe(_Execute):  # noqa: N801
    """RecordedPosition is where the axis was at the next edge of an input.

    TriggerInput: number of the digital input in the image, from 1, seen once per cycle; or 513 or 514: touch probe 1 or 2 of
    the drive of the axis, which latches the position at the edge itself (`process_data` of the drive). Mode 1 falling, 2 rising
    edge.
    """

    __slots__ = ()
    _FUNCTION = AxisFunction.TOUCH_PROBE
    _INPUTS = ("master", "mode")

    def __call__(self, Axis: AxisPort, Execute: bool, TriggerInput: int = 1, Mode: int = 2) -> Self:
        return self._order(Axis, Execute, TriggerInput, Mode)

    @property
    def RecordedPosition(self) -> float:  # noqa: N802
        return self._recorded


class MC_AbortTrigger(_Execute):  # noqa: N801
    """A probe no longer waits."""

    __slots__ = ()
    _FUNCTION = AxisFunction.ABORT_TRIGGER

    def __call__(self, Axis: AxisPort, Execute: bool) -> Self:
        return self._order(Axis, Execute)
