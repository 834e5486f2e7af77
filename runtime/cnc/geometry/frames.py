"""Rigid frames in space: how a coordinate system lies in another one, and the conventions of its three rotations.

    outer = rotation · inner + origin

Everything is pure geometry of the three main axes, mm and degrees. Matrices (3, 3) are orthonormal with determinant 1.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

AXES = "XYZ"
SEQUENCES = ("XYZ", "XYX", "XZY", "XZX", "YXZ", "YXY", "YZX", "YZY", "ZXY", "ZXZ", "ZYX", "ZYZ")
USUAL_SEQUENCE = "ZYX"  # yaw, pitch, roll
NO_TURN = 1e-12  # of an element of the matrix: below it a frame is only shifted


@dataclass(frozen=True, slots=True)
class Frame:
    """A frame in another one: `rotation` (3, 3), `origin` (3,) in mm, in the coordinates of the outer one."""

    rotation: Floats
    origin: Floats

    @classmethod
    def shifted(cls, origin: Sequence[float]) -> Frame:
        """Not rotated."""
        return cls(np.eye(3), np.array(origin, dtype=np.float64))

    @property
    def only_shifted(self) -> bool:
        """The axes point as those of the outer frame do."""
        return bool(np.abs(self.rotation - np.eye(3)).max() < NO_TURN)

    def holding(self, inner: Frame) -> Frame:
        """A frame that lies in this one, seen from where this one lies."""
        return Frame(self.rotation @ inner.rotation, self.rotation @ inner.origin + self.origin)

    def outer(self, point: Sequence[float] | Floats) -> Floats:
        """A point (3,) or points (k, 3) of this frame in the outer one."""
        there: Floats = np.asarray(point) @ self.rotation.T + self.origin
        return there

    def inner(self, point: Sequence[float] | Floats) -> Floats:
        """A point (3,) or points (k, 3) of the outer frame in this one."""
        here: Floats = (np.asarray(point) - self.origin) @ self.rotation
        return here


HERE = Frame.shifted((0.0, 0.0, 0.0))


def turn_about(axis: int, angle: float) -> Floats:
    """The rotation (3, 3) about a main axis by degrees, mathematically positive. Quarter turns are exact."""
    quarters = angle / 90.0
    if quarters == round(quarters):
        c, s = ((1.0, 0.0), (0.0, 1.0), (-1.0, 0.0), (0.0, -1.0))[round(quarters) % 4]
    else:
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    matrix = np.eye(3)
    first, second = (axis + 1) % 3, (axis + 2) % 3
    matrix[first, first] = matrix[second, second] = c
    matrix[first, second], matrix[second, first] = -s, s
    return matrix


def rotation_of(angles: Sequence[float], sequence: str = USUAL_SEQUENCE, *, fixed: bool = False) -> Floats:
    """The rotation (3, 3) of three angles in degrees.

    The letters of `sequence` are the axes in the order of the rotations. Where they are three different axes `angles` belong to
    X, Y and Z, whatever the order is (programming manual 26969–26987); of an Euler sequence like ZXZ to the first, second and
    third rotation. Each rotation is about the axes as those before have left them, or with `fixed` about those of the start.
    """
    made = np.eye(3)
    different = len(set(sequence)) == len(AXES)
    for place, letter in enumerate(sequence):
        axis = AXES.index(letter)
        turn = turn_about(axis, angles[axis if different else place])
        made = turn @ made if fixed else made @ turn
    return made
