"""Programs in which path and spindle move together, cycle by cycle: what both are told, as arrays."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.config.machine import Machine
from tests.machine.test_spindles import Run, machine_with

Floats = npt.NDArray[np.float64]
TYPES = {f"m{number}_synch": "MVS_SVS" for number in (3, 4, 5, 19)}


class Told(NamedTuple):
    """Per cycle: position of the axes (k, 3), angle and speed of the spindle (degrees, degrees/s), together or not."""

    axes: Floats
    angle: Floats
    speed: Floats
    together: npt.NDArray[np.bool_]

    @property
    def sections(self) -> list[slice]:
        """The cycles of each section."""
        edges = np.diff(np.concatenate([[0], self.together.astype(np.int64), [0]]))
        return [slice(a, b) for a, b in zip(np.flatnonzero(edges == 1), np.flatnonzero(edges == -1), strict=True)]


class Followed(Run):
    """A run that keeps what it has told."""

    def __init__(self, demo: Machine, text: str, folder: Path, *, ideal: bool = True, **changes: object) -> None:
        machine = machine_with(demo, TYPES, **changes)
        path = folder / "t.nc"
        path.write_text("%T\n" + text)
        super().__init__(machine, path, ideal=ideal)
        self.machine = machine
        self._rows: list[tuple[float, ...]] = []

    def cycle(self, count: int = 1) -> None:
        """So many cycles."""
        for _ in range(count):
            self.simulation.cycle()
            spindle = self.spindles[0]
            self._rows.append(
                (*self.path.position[:3], spindle.planned_angle, spindle.set_point, float(self.channel.together.active))
            )

    def until(self, condition: Callable[[], bool], limit: float = 30.0) -> None:
        for _ in range(round(limit / self.simulation.period)):
            if condition():
                return
            self.cycle()
        raise AssertionError(f"did not happen: {self.channel.stop_condition}, {self.simulation.problems}")

    @property
    def told(self) -> Told:
        rows = np.array(self._rows)
        return Told(rows[:, :3], rows[:, 3], rows[:, 4], rows[:, 5] > 0.0)

    @property
    def z(self) -> float:
        return float(self.path.position[2])

    def ids(self) -> list[int]:
        """Of the errors that were told."""
        return [problem.entry.id for problem in self.simulation.problems]


def assert_within_limits(
    machine: Machine, told: Told, period: float, axes: Mapping[int, str] = {0: "X", 2: "Z"}
) -> None:
    """What was told to the axes keeps their velocity, acceleration and jerk."""
    velocity = np.diff(told.axes, axis=0) / period
    acceleration = np.diff(velocity, axis=0) / period
    jerk = np.diff(acceleration, axis=0) / period
    for k in axes:
        axis = machine.axes[k]
        assert np.abs(velocity[:, k]).max() <= axis.velocity * 1.0001
        assert np.abs(acceleration[:, k]).max() <= axis.acceleration * 1.001
        assert np.abs(jerk[:, k]).max() <= axis.jerk * 1.01
