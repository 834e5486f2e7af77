"""The motion blocks of PLCopen part 1, on axes of the machine.

    self.move(Axis=self.axes["B"], Execute=go, Position=90.0, Velocity=30.0)

Called in every cycle, as all blocks. A rising edge of Execute gives the job; Busy until it has ended, Active while it moves the
axis, then Done, CommandAborted (another job took the axis) or Error with ErrorID, for one call at least and as long as Execute is
TRUE. An axis takes one job per PLC cycle: the second one waits for the next cycle, only MC_Stop overtakes.

Positions mm or degrees, velocities per second; Acceleration, Deceleration and Jerk of 0 are those of the axis.
"""

from __future__ import annotations

from typing import Self

from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, BufferMode, Direction, JobState, MotionState
from runtime.plc_logic.areas import AxisPort

_ENDED = (JobState.DONE, JobState.ABORTED, JobState.ERROR)


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
        "_shown",
    )

    def __init__(self) -> None:
        self.Done = self.Busy = self.Active = self.CommandAborted = self.Error = False
        self.ErrorID = 0
        self._execute = False
        self._axis: AxisPort | None = None
        self._job: Job | None = None  # under way
        self._number: int | None = None  # None: the slot was in use
        self._shown = False  # an end was shown for one call

    def _rises(self, execute: bool) -> bool:
        """Whether a job is to be given in this call."""
        rising = execute and not self._execute
        self._execute = bool(execute)
        if rising or (self._job is None and not execute and self._shown):
            self._clear()
        return rising

    def _clear(self) -> None:
        self.Done = self.Busy = self.Active = self.CommandAborted = self.Error = self._shown = False
        self.ErrorID = 0

    def _begin(self, axis: AxisPort, job: Job) -> None:
        self._axis, self._job, self._number = axis, job, None
        self.Busy = True

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
        self._reached(answer.state is JobState.REACHED)
        if answer.state in _ENDED:
            self.Busy = self.Active = False
            self.Done = answer.state is JobState.DONE
            self.CommandAborted = answer.state is JobState.ABORTED
            self.Error = answer.state is JobState.ERROR
            self.ErrorID = answer.error
            self._ended(answer.position)
            self._job = None

    def _reached(self, reached: bool) -> None:
        """For blocks whose job goes on when it has reached what it wants."""

    def _ended(self, position: float) -> None:
        """For blocks that read something of the answer."""


class _Move(_Execute):
    """A motion by Position or Distance."""

    __slots__ = ()
    _function = AxisFunction.MOVE_ABSOLUTE

    def _call(
        self,
        Axis: AxisPort,
        Execute: bool,
        way: float,
        Velocity: float,
        Acceleration: float,
        Deceleration: float,
        Jerk: float,
        BufferMode: BufferMode,
        direction: Direction = Direction.SHORTEST,
    ) -> Self:
        if self._rises(Execute):
            self._begin(
                Axis,
                Job(
                    self._function,
                    way,
                    Velocity,
                    Acceleration,
                    Deceleration,
                    Jerk,
                    direction=direction,
                    buffer_mode=BufferMode,
                ),
            )
        self._follow()
        return self


class MC_MoveAbsolute(_Move):  # noqa: N801 - PLCopen's name
    """To a position. Direction tells the way of a modulo axis."""

    __slots__ = ()

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
        return self._call(Axis, Execute, Position, Velocity, Acceleration, Deceleration, Jerk, BufferMode, Direction)


class MC_MoveRelative(_Move):  # noqa: N801
    """A way from where the axis is when the job begins."""

    __slots__ = ()
    _function = AxisFunction.MOVE_RELATIVE

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
        return self._call(Axis, Execute, Distance, Velocity, Acceleration, Deceleration, Jerk, BufferMode)


class MC_MoveAdditive(MC_MoveRelative):  # noqa: N801
    """A way from the target of the move under way; without one, as MC_MoveRelative."""

    __slots__ = ()
    _function = AxisFunction.MOVE_ADDITIVE


class MC_MoveSuperimposed(_Move):  # noqa: N801
    """A way on top of the motion under way, which goes on."""

    __slots__ = ()
    _function = AxisFunction.MOVE_SUPERIMPOSED

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
        return self._call(Axis, Execute, Distance, VelocityDiff, Acceleration, Deceleration, Jerk, BufferMode.ABORTING)


class MC_MoveVelocity(_Move):  # noqa: N801
    """Endless motion; InVelocity while it has its velocity. At a software limit it comes to rest with an error."""

    __slots__ = ("InVelocity",)
    _function = AxisFunction.MOVE_VELOCITY

    def __init__(self) -> None:
        super().__init__()
        self.InVelocity = False

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
        self._call(Axis, Execute, 0.0, Velocity, Acceleration, Deceleration, Jerk, BufferMode, Direction)
        if self._job is None:
            self.InVelocity = False
        return self

    def _reached(self, reached: bool) -> None:
        self.InVelocity = reached


class MC_Halt(_Execute):  # noqa: N801
    """To rest; another job may take the axis meanwhile."""

    __slots__ = ()
    _function = AxisFunction.HALT

    def __call__(
        self,
        Axis: AxisPort,
        Execute: bool,
        Deceleration: float = 0.0,
        Jerk: float = 0.0,
        BufferMode: BufferMode = BufferMode.ABORTING,
    ) -> Self:
        if self._rises(Execute):
            self._begin(
                Axis,
                Job(
                    self._function,
                    acceleration=Deceleration,
                    deceleration=Deceleration,
                    jerk=Jerk,
                    buffer_mode=BufferMode,
                ),
            )
        self._follow()
        return self


class MC_Stop(_Execute):  # noqa: N801
    """To rest, and no other job is taken as long as Execute is TRUE (state Stopping)."""

    __slots__ = ()

    def __call__(self, Axis: AxisPort, Execute: bool, Deceleration: float = 0.0, Jerk: float = 0.0) -> Self:
        before = self._execute
        if self._rises(Execute):
            self._begin(Axis, Job(AxisFunction.STOP, acceleration=Deceleration, deceleration=Deceleration, jerk=Jerk))
        if before is not self._execute:
            Axis.jobs.hold_stop(self._execute)
        self._follow()
        return self


class MC_Home(_Execute):  # noqa: N801
    """Homing: at the cam or by the drive, as the machine description says, and to the position of the reference.

    An axis with an absolute encoder has its reference, the job is done at once.
    """

    __slots__ = ()

    def __call__(self, Axis: AxisPort, Execute: bool) -> Self:
        if self._rises(Execute):
            self._begin(Axis, Job(AxisFunction.HOME))
        self._follow()
        return self


class MC_Reset(_Execute):  # noqa: N801
    """Leaves ErrorStop. A fault of the drive is acknowledged by a reset of the machine, which ends a program too."""

    __slots__ = ()

    def __call__(self, Axis: AxisPort, Execute: bool) -> Self:
        if self._rises(Execute):
            self._begin(Axis, Job(AxisFunction.RESET))
            if Axis.error:
                Axis.reset()
        self._follow()
        return self


# --------------------------------------------------------------------------------------------- several axes


class MC_GearIn(_Execute):  # noqa: N801
    """The slave follows the master's velocity times RatioNumerator / RatioDenominator; InGear when it does.

    Mode 0 follows the master's commanded place, 128 its actual one.
    """

    __slots__ = ("InGear",)

    def __init__(self) -> None:
        super().__init__()
        self.InGear = False

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
    ) -> Self:
        if self._rises(Execute):
            self._begin(
                Slave,
                Job(
                    AxisFunction.GEAR_IN,
                    acceleration=Acceleration,
                    deceleration=Deceleration,
                    jerk=Jerk,
                    buffer_mode=BufferMode,
                    mode=Mode,
                    master=Master.number,
                    numerator=RatioNumerator,
                    denominator=RatioDenominator,
                ),
            )
        self._follow()
        if self._job is None:
            self.InGear = False
        return self

    def _reached(self, reached: bool) -> None:
        self.InGear = reached


class MC_GearOut(_Execute):  # noqa: N801
    """The slave leaves its master and goes on with its velocity."""

    __slots__ = ()

    def __call__(self, Slave: AxisPort, Execute: bool) -> Self:
        if self._rises(Execute):
            self._begin(Slave, Job(AxisFunction.GEAR_OUT))
        self._follow()
        return self


class MC_Phasing(_Move):  # noqa: N801
    """Shifts the slave against its master by PhaseShift."""

    __slots__ = ()
    _function = AxisFunction.PHASING

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
        return self._call(Slave, Execute, PhaseShift, Velocity, Acceleration, Deceleration, Jerk, BufferMode.ABORTING)


# --------------------------------------------------------------------------------------------- probes


class MC_TouchProbe(_Execute):  # noqa: N801
    """RecordedPosition is where the axis was at the next edge of an input.

    TriggerInput: number of the digital input in the image, from 1, seen once per cycle; or 513 or 514: touch probe 1 or 2 of
    the drive of the axis, which latches the position at the edge itself (`process_data` of the drive). Mode 1 falling, 2 rising
    edge.
    """

    __slots__ = ("RecordedPosition",)

    def __init__(self) -> None:
        super().__init__()
        self.RecordedPosition = 0.0

    def __call__(self, Axis: AxisPort, Execute: bool, TriggerInput: int = 1, Mode: int = 2) -> Self:
        if self._rises(Execute):
            self._begin(Axis, Job(AxisFunction.TOUCH_PROBE, mode=Mode, master=TriggerInput))
        self._follow()
        return self

    def _ended(self, position: float) -> None:
        if self.Done:
            self.RecordedPosition = position


class MC_AbortTrigger(_Execute):  # noqa: N801
    """A probe no longer waits."""

    __slots__ = ()

    def __call__(self, Axis: AxisPort, Execute: bool) -> Self:
        if self._rises(Execute):
            self._begin(Axis, Job(AxisFunction.ABORT_TRIGGER))
        self._follow()
        return self


# --------------------------------------------------------------------------------------------- power and state


class MC_Power:  # noqa: N801
    """Switches the drive on while Enable is TRUE; Status when it takes set-points."""

    __slots__ = ("Error", "ErrorID", "Status")

    def __init__(self) -> None:
        self.Status = self.Error = False
        self.ErrorID = 0

    def __call__(self, Axis: AxisPort, Enable: bool) -> Self:
        Axis.drive_on = Enable
        self.Status = Axis.enabled
        self.Error = Axis.error
        self.ErrorID = Axis.error_id
        return self


class MC_ReadStatus:  # noqa: N801
    """One output per state of the axis; Valid while Enable is TRUE."""

    __slots__ = (
        *("ContinuousMotion", "Disabled", "DiscreteMotion", "ErrorStop", "Homing"),
        *("Standstill", "Stopping", "SynchronizedMotion", "Valid"),
    )

    def __init__(self) -> None:
        self.Valid = False
        self._show(None)

    def __call__(self, Axis: AxisPort, Enable: bool = True) -> Self:
        self.Valid = bool(Enable)
        self._show(Axis.motion_state if Enable else None)
        return self

    def _show(self, state: MotionState | None) -> None:
        self.Disabled = state is MotionState.DISABLED
        self.Standstill = state is MotionState.STANDSTILL
        self.Homing = state is MotionState.HOMING
        self.Stopping = state is MotionState.STOPPING
        self.DiscreteMotion = state is MotionState.DISCRETE_MOTION
        self.ContinuousMotion = state is MotionState.CONTINUOUS_MOTION
        self.SynchronizedMotion = state is MotionState.SYNCHRONIZED_MOTION
        self.ErrorStop = state is MotionState.ERROR_STOP


class _Read:
    """A value of the axis while Enable is TRUE."""

    __slots__ = ("Valid", "Value")

    def __init__(self) -> None:
        self.Valid = False
        self.Value = 0.0

    def __call__(self, Axis: AxisPort, Enable: bool = True) -> Self:
        self.Valid = bool(Enable)
        if Enable:
            self.Value = self._read(Axis)
        return self

    def _read(self, axis: AxisPort) -> float:
        raise NotImplementedError


class MC_ReadActualPosition(_Read):  # noqa: N801
    """Value is the actual position."""

    __slots__ = ()

    def _read(self, axis: AxisPort) -> float:
        return axis.position


class MC_ReadCommandPosition(_Read):  # noqa: N801
    """Value is the set-point."""

    __slots__ = ()

    def _read(self, axis: AxisPort) -> float:
        return axis.commanded_position


class MC_ReadActualVelocity(_Read):  # noqa: N801
    """Value is the actual velocity."""

    __slots__ = ()

    def _read(self, axis: AxisPort) -> float:
        return axis.velocity


class MC_ReadAxisError:  # noqa: N801
    """AxisErrorID tells why the axis is in ErrorStop, 0 it is not."""

    __slots__ = ("AxisErrorID", "Valid")

    def __init__(self) -> None:
        self.Valid = False
        self.AxisErrorID = 0

    def __call__(self, Axis: AxisPort, Enable: bool = True) -> Self:
        self.Valid = bool(Enable)
        self.AxisErrorID = Axis.error_id if Enable else 0
        return self


class MC_SetOverride:  # noqa: N801
    """Override of the axis for its jobs: VelFactor 1.0 is 100 %."""

    __slots__ = ("Enabled",)

    def __init__(self) -> None:
        self.Enabled = False

    def __call__(self, Axis: AxisPort, Enable: bool, VelFactor: float = 1.0) -> Self:
        if Enable:
            Axis.override = 100.0 * VelFactor
        self.Enabled = bool(Enable)
        return self
