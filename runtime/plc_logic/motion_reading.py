"""Blocks that switch an axis on, and tell its state and its values (PLCopen part 1)."""

from __future__ import annotations

from typing import Self

from runtime.hli.layout import MotionState
from runtime.plc_logic.areas import AxisPort


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
