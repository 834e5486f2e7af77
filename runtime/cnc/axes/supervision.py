"""All axes between the interpolators and the drive image: enabling, take-over without a jump, monitoring.

While a drive is not enabled, or moves by itself, its axis is in tracking: the set-point is the actual position, so that enabling
never jumps. What the monitoring finds is handed to the caller as faults, once each; the axis stays in error until it is reset.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.config.machine import AxisType, Machine
from runtime.drives import DriveImage, DriveState
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]
States = npt.NDArray[np.int8]
Ints = npt.NDArray[np.int64]

FAULT_DRIVE = 1  # the drive is in fault or fault reaction
FAULT_OFFLINE = 2  # the node does not answer
FAULT_LAG = 3  # following error above its limit
FAULT_DROPPED = 4  # the drive left operation enabled although it should be in it


class AxisFault(NamedTuple):
    """What the monitoring found: axis index, one of FAULT_*, and the measured value (lag in mm, or the drive's code)."""

    axis: int
    kind: int
    value: float


@kernel
def _supervise(
    target: Floats,
    actual: Floats,
    state: States,
    wanted: Flags,
    enable: Flags,
    was_enabled: Flags,
    linear: Flags,
    lag_limit: Floats,
    lag_monitored: Flags,
    quick_stop: Flags,
    by_drive: Flags,
    grace: Ints,
    leave: Flags,
    faults: States,
    lag: Floats,
    new: States,
) -> int:
    """Fill `lag`, `faults` (0 or FAULT_*) and `enable`, let axes that are not enabled track, keep `was_enabled`.

    An axis that its drive moves by itself (`by_drive`: homing, profile modes) tracks as well.

    `leave`: the drive must first leave its enabled state, so that the axis takes over its position before it runs again.
    Returns how many axes have a new fault; `new` tells which. While an axis has `grace` (cycles) nothing is a fault of it.
    """
    count = 0
    for i in range(target.shape[0]):
        enabled = state[i] == 5  # OPERATION_ENABLED
        follows = enabled and not by_drive[i]
        lag[i] = target[i] - actual[i] if linear[i] and follows else 0.0
        found = 0
        if grace[i] > 0:
            grace[i] -= 1
            faults[i] = 0
        elif state[i] == 0 and wanted[i]:
            found = FAULT_OFFLINE
        elif state[i] >= 7:
            found = FAULT_DRIVE
        elif was_enabled[i] and wanted[i] and not enabled and not quick_stop[i]:
            found = FAULT_DROPPED
        elif abs(lag[i]) > lag_limit[i] and lag_monitored[i]:
            found = FAULT_LAG
        new[i] = 0
        if found != 0 and faults[i] == 0:
            faults[i] = found
            new[i] = 1
            leave[i] = True
            count += 1
        was_enabled[i] = enabled
        if not follows:
            target[i] = actual[i]
        if not enabled:
            leave[i] = False
        enable[i] = wanted[i] and faults[i] == 0 and not leave[i]
    return count


@warms("axis monitoring")
def _warm() -> None:
    floats, flags, states = np.ones(1), np.zeros(1, dtype=np.bool_), np.zeros(1, dtype=np.int8)
    grace = np.zeros(1, dtype=np.int64)
    _supervise(
        floats,
        floats,
        states,
        flags,
        flags,
        flags,
        flags,
        floats,
        flags,
        flags,
        flags,
        grace,
        flags,
        states,
        floats,
        states,
    )


class AxisSupervision:
    """Enabling and monitoring of all axes of the machine; arrays in the order of the machine description."""

    def __init__(self, machine: Machine, image: DriveImage) -> None:
        n = len(machine.axes)
        self.image = image
        self.lag: Floats = np.zeros(n)  # following error
        self.faults: npt.NDArray[np.int8] = np.zeros(n, dtype=np.int8)  # 0 or FAULT_*, kept until reset
        self._linear: Flags = np.array([axis.type is not AxisType.SPINDLE for axis in machine.axes])
        self.spindles: Flags = ~self._linear  # (n,)
        self._lag_limit: Floats = np.array([axis.following_error for axis in machine.axes])
        self.window: Floats = np.array([axis.in_position for axis in machine.axes])  # of standstill
        self.lag_monitored: Flags = np.ones(n, dtype=np.bool_)  # whose following error raises a fault
        self._was_enabled: Flags = np.zeros(n, dtype=np.bool_)
        self._new: States = np.zeros(n, dtype=np.int8)
        self._leave: Flags = np.zeros(n, dtype=np.bool_)
        self._grace: Ints = np.zeros(n, dtype=np.int64)  # cycles until an axis that was reset is judged again

    @property
    def enabled(self) -> Flags:
        """(n,) drives that take set-points."""
        states: Flags = self.image.state == DriveState.OPERATION_ENABLED
        return states

    @property
    def in_position(self) -> Flags:
        """(n,) following error within the window of standstill."""
        return np.abs(self.lag) <= self.window

    def monitor(self, wanted: Flags) -> list[AxisFault]:
        """After the fieldbus was read: new faults, and the enables and tracking set-points of this cycle.

        `wanted` (n,): the drives that shall be on. An axis in fault is not enabled until it is reset.
        """
        image = self.image
        image.reset_fault &= self._grace > 1
        count = _supervise(
            image.target_position,
            image.actual_position,
            image.state,
            wanted,
            image.enable,
            self._was_enabled,
            self._linear,
            self._lag_limit,
            self.lag_monitored,
            image.quick_stop,
            image.by_drive,
            self._grace,
            self._leave,
            self.faults,
            self.lag,
            self._new,
        )
        if not count:
            return []
        found = []
        for i in np.flatnonzero(self._new):
            kind = int(self.faults[i])
            found.append(AxisFault(int(i), kind, float(self.lag[i] if kind == FAULT_LAG else image.fault_code[i])))
        return found

    def quick_stop(self) -> None:
        """Every drive brakes by its own quick-stop ramp."""
        self.image.quick_stop[:] = True

    def reset(self, cycles: int) -> None:
        """Acknowledge faults; drives that do not run get `cycles` cycles before they are judged again, the others none."""
        image = self.image
        image.quick_stop[:] = False
        image.reset_fault[:] = True
        self._grace[:] = np.where((self.faults != 0) | ~self.enabled, cycles, 0)
        self._was_enabled &= self._grace == 0
        self.faults[:] = 0
