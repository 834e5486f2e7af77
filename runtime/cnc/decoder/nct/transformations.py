"""Rotation, scaling and mirror image of programmed points, in the order in which they were switched on (manual lines 4306-4503).

    programmed numbers ─ … ─ switched on second ─ switched on first ─ mirror image ─▶ point of the local system

What is switched on first acts on the centre of what comes second, so the later one is the nearer to the programmed point. The
mirror image stands outside of both. Lengths in mm, angles in degrees, points as lists of n axes.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Turned:
    """A rotation by `angle` degrees, counter-clockwise, in a plane of two axes about `centre`."""

    plane: tuple[int, int]
    angle: float
    centre: tuple[float, float]

    def image(self, point: list[float]) -> None:
        """Turn a point, in place."""
        self._turn(point, self.angle)

    def source(self, point: list[float]) -> None:
        """Turn a point back, in place."""
        self._turn(point, -self.angle)

    def _turn(self, point: list[float], angle: float) -> None:
        first, second = self.plane
        c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
        x, y = point[first] - self.centre[0], point[second] - self.centre[1]
        point[first] = self.centre[0] + c * x - s * y
        point[second] = self.centre[1] + s * x + c * y


@dataclass(frozen=True, slots=True)
class Scaled:
    """Scaling of the linear axes about `centre`, (n,), by one factor, so that arcs stay arcs."""

    factor: float
    centre: tuple[float, ...]
    axes: tuple[int, ...]

    def image(self, point: list[float]) -> None:
        """Scale a point, in place."""
        for axis in self.axes:
            point[axis] = self.centre[axis] + self.factor * (point[axis] - self.centre[axis])

    def source(self, point: list[float]) -> None:
        """Scale a point back, in place."""
        for axis in self.axes:
            point[axis] = self.centre[axis] + (point[axis] - self.centre[axis]) / self.factor


@dataclass(slots=True)
class Transformations:
    """What is switched on. `mirrors`: axis → coordinate at which it is mirrored; `nested`: at most one of each kind, in order."""

    mirrors: dict[int, float] = field(default_factory=dict)
    nested: list[Turned | Scaled] = field(default_factory=list)

    @property
    def turned(self) -> Turned | None:
        """The rotation that is switched on."""
        return next((step for step in self.nested if isinstance(step, Turned)), None)

    @property
    def scaled(self) -> Scaled | None:
        """The scaling that is switched on."""
        return next((step for step in self.nested if isinstance(step, Scaled)), None)

    @property
    def none(self) -> bool:
        """Programmed numbers are points of the local system."""
        return not self.mirrors and not self.nested

    def switch_on(self, step: Turned | Scaled) -> None:
        """One that is on already keeps its place in the order."""
        for place, other in enumerate(self.nested):
            if type(other) is type(step):
                self.nested[place] = step
                return
        self.nested.append(step)

    def is_last(self, kind: type[Turned | Scaled]) -> bool:
        """Whether nothing was switched on behind this kind, so that it may be switched off."""
        return not self.nested or isinstance(self.nested[-1], kind) or not any(isinstance(s, kind) for s in self.nested)

    def switch_off(self, kind: type[Turned | Scaled]) -> None:
        """Switch off a rotation or a scaling."""
        self.nested = [step for step in self.nested if not isinstance(step, kind)]

    def image(self, numbers: Sequence[float]) -> list[float]:
        """The point of the local system that programmed numbers mean."""
        point = list(numbers)
        for step in reversed(self.nested):
            step.image(point)
        self._mirror(point)
        return point

    def source(self, local: Sequence[float]) -> list[float]:
        """The numbers with which a point of the local system is programmed."""
        point = list(local)
        self._mirror(point)
        for step in self.nested:
            step.source(point)
        return point

    def _mirror(self, point: list[float]) -> None:
        for axis, value in self.mirrors.items():
            point[axis] = 2.0 * value - point[axis]
