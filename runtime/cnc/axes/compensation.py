"""Backlash and pitch errors: the way between where an axis is and where its drive has to be.

    position of the drive = position of the axis + correction(position, direction)

The table says how far the axis stands beyond its position when it comes in positive direction; the correction takes that back. In
negative direction the drive has the backlash to go as well. The correction follows both at a limited speed, so that it never is a
jump of the set-point; what the drive tells is corrected by the same value, so that taking over a position is no jump either.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.config.machine import AxisType, Machine
from runtime.drives import DriveImage, DriveState
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
States = npt.NDArray[np.int8]

_ENABLED = int(DriveState.OPERATION_ENABLED)
_SMALLEST = 1e-7  # mm, degrees: less is no motion
_FARTHEST = 1.5  # times the way of a cycle: more is no motion, the coordinates have shifted


@kernel
def _error_at(place: float, places: Floats, errors: Floats, begin: int, end: int) -> float:
    """The error at a place, between the rows of the table; beyond its ends that of the end."""
    if place <= places[begin]:
        return float(errors[begin])
    if place >= places[end - 1]:
        return float(errors[end - 1])
    low, high = begin, end - 1
    while high - low > 1:
        middle = (low + high) // 2
        if places[middle] <= place:
            low = middle
        else:
            high = middle
    share = (place - places[low]) / (places[high] - places[low])
    return float(errors[low] + share * (errors[high] - errors[low]))


@kernel
def _compensate(
    axes: Ints,
    target: Floats,
    state: States,
    before: Floats,
    farthest: Floats,
    backlash: Floats,
    negative: States,
    first: Ints,
    places: Floats,
    errors: Floats,
    longest: Floats,
    correction: Floats,
) -> None:
    """One cycle. `axes` (n,) indices into the image; `first` (n + 1,) where the table of each begins in `places` and `errors`."""
    for k in range(axes.shape[0]):
        i = axes[k]
        way = target[i] - before[k]
        before[k] = target[i]
        enabled = state[i] == _ENABLED
        if enabled and _SMALLEST < abs(way) <= farthest[k]:
            negative[k] = way < 0.0
        begin, end = first[k], first[k + 1]
        wanted = -backlash[k] if negative[k] else 0.0
        if end > begin:
            wanted -= _error_at(target[i], places, errors, begin, end)
        change = wanted - correction[i]
        if enabled:  # else nothing follows the set-point
            change = min(max(change, -longest[k]), longest[k])
        correction[i] += change


@warms("compensation")
def _warm() -> None:
    floats, ints, states = np.zeros(1), np.zeros(1, dtype=np.int64), np.zeros(1, dtype=np.int8)
    first = np.zeros(2, dtype=np.int64)
    _compensate(ints, floats, states, floats, floats, floats, states, first, floats, floats, floats, floats)


class AxisCompensation:
    """Of all axes of the machine that have one; `step` in every cycle, behind the set-points."""

    def __init__(self, machine: Machine, image: DriveImage) -> None:
        self._image = image
        period = machine.cycle.period
        chosen = [
            (i, axis, axis.compensation)
            for i, axis in enumerate(machine.axes)
            if axis.compensation is not None and axis.type is not AxisType.SPINDLE
        ]
        tables = [np.array(compensation.rows()).reshape(-1, 2) for _, _, compensation in chosen]
        self._axes: Ints = np.array([i for i, _, _ in chosen], dtype=np.int64)
        self._before: Floats = image.target_position[self._axes].copy()
        self._farthest: Floats = np.array([_FARTHEST * axis.velocity * period for _, axis, _ in chosen])
        self._backlash: Floats = np.array([compensation.backlash for _, _, compensation in chosen])
        self._negative: States = np.zeros(len(chosen), dtype=np.int8)
        self._first: Ints = np.cumsum([0, *(len(table) for table in tables)])
        self._places: Floats = np.concatenate([np.zeros(0), *(table[:, 0] for table in tables)])
        self._errors: Floats = np.concatenate([np.zeros(0), *(table[:, 1] for table in tables)])
        self._longest: Floats = np.array([compensation.velocity * period for _, _, compensation in chosen])
        self.used = bool(chosen)

    def step(self) -> None:
        """The corrections of this cycle's set-points."""
        image = self._image
        _compensate(
            self._axes,
            image.target_position,
            image.state,
            self._before,
            self._farthest,
            self._backlash,
            self._negative,
            self._first,
            self._places,
            self._errors,
            self._longest,
            image.correction,
        )
