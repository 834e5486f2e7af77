"""Axes of the channel that a program moves beside its path (INDP_SYN, INDP_ASYN), each with its own interpolator.

    path:         ──── stands here ─┬── goes on, the axis at its target already ──────▶
    own motion:                     └── offset from target to place ──▶ 0

The path takes the target of an own motion as the place of the axis as soon as the motion begins; until the axis is there, the
offset is what is left to go. So nothing has to be taken over at the end, and whoever adds the offset knows where the axis is.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.single_axis import SingleAxis
from runtime.config.machine import Axis

Floats = npt.NDArray[np.float64]


class IndependentAxes:
    """Of one channel. `step` costs nothing while no axis moves by itself."""

    def __init__(self, axes: Sequence[Axis], period: float) -> None:
        self._motions = [SingleAxis(Dynamics(axis.velocity, axis.acceleration, axis.jerk), period) for axis in axes]
        self._targets = [0.0] * len(axes)
        self.moving: set[int] = set()  # channel indices
        self.offset: Floats = np.zeros(len(axes))  # from the target to the place of each axis, mm or degrees

    def drop(self) -> None:
        """A program starts, or the axes brake by themselves: no motion is left."""
        self.moving.clear()
        self.offset[:] = 0.0

    def start(self, axis: int, place: float, target: float, dynamics: Dynamics) -> None:
        """From rest at `place` to `target`, with what of `dynamics` the axis can."""
        motion = self._motions[axis]
        motion.restart(place)
        motion.move_to(target, dynamics)
        self._targets[axis] = target
        self.offset[axis] = place - target
        self.moving.add(axis)

    def stop(self) -> None:
        """The program is aborted: they come to rest wherever they are."""
        for axis in self.moving:
            self._motions[axis].stop()

    def step(self, override: float, holds: Sequence[bool]) -> None:
        """One cycle; `holds` (n_axes,): a hold brakes an axis, and it goes on behind it."""
        for axis in tuple(self.moving):
            motion = self._motions[axis]
            self.offset[axis] = motion.step(override, holds[axis]) - self._targets[axis]
            if motion.arrived and motion.moves_to_target:
                self.moving.discard(axis)

    def arrived(self, axes: int) -> bool:
        """None of the axes (bits) is on its way."""
        return not any(axes >> axis & 1 for axis in self.moving)

    @property
    def at_rest(self) -> bool:
        """No axis moves by itself."""
        return all(self._motions[axis].standstill for axis in self.moving)
