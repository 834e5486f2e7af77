"""NC text in, motion out: decode a program and drive its blocks through stages, writer, queue and interpolator."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation import CornerDecelerations
from runtime.cnc.path_preparation.weight_tables import PathWeights
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.interpolator.driving import PERIOD, Drive, Floats, Schedule, always, drive, limits

LIMITS = limits(400.0, 2000.0, 40_000.0, 5.0)


@dataclass(frozen=True)
class Driven:
    """A program that was driven; element k of the arrays belongs to cycle k."""

    run: Drive

    @property
    def t(self) -> Floats:
        t: Floats = np.arange(1.0, self.run.cycles + 1.0) * PERIOD
        return t

    @property
    def time(self) -> float:
        """s, to the last motion."""
        return float(self.t[np.flatnonzero(np.array(self.run.v) > 0.0)[-1]])

    @property
    def s(self) -> Floats:
        return np.array(self.run.s)

    @property
    def feed(self) -> Floats:
        """Path velocity in mm/min."""
        return np.array(self.run.v) * 60.0

    @property
    def axes(self) -> tuple[Floats, Floats]:
        """Greatest velocity and acceleration of each axis, (n,), differentiated from its set-points."""
        path = np.vstack([np.zeros(self.run.path.shape[1]), self.run.path])
        v = np.diff(path, axis=0) / PERIOD
        return np.abs(v).max(axis=0), np.abs(np.diff(v, axis=0)).max(axis=0) / PERIOD

    @property
    def acceleration(self) -> Floats:
        """Along the path, mm/s²."""
        return np.array(self.run.a)

    @property
    def jerk(self) -> Floats:
        """Along the path, mm/s³."""
        return np.diff(np.array([0.0, *self.run.a])) / PERIOD

    def feed_at(self, way: float) -> float:
        """mm/min at a place of the path, mm."""
        return float(np.interp(way, self.s, self.feed))

    def records(self, name: str) -> list[float]:
        """A field of the elements in the queue."""
        return [float(r[name]) for _, r in sorted(self.run.elements.items()) if r["kind"] <= 1]


def driven(
    text: str,
    axes: AxisLimits = LIMITS,
    setup: DecoderSetup = SETUP,
    weights: PathWeights | None = None,
    schedule: Schedule = always,
    most: int = 60_000,
) -> Driven:
    """Drive a program from 0 0 0."""
    decoded = decode(text, setup)
    assert decoded.problem is None, decoded.problem
    stages = CornerDecelerations()(decoded.blocks)
    run = drive(stages, axes, np.zeros(3), schedule, weights=weights, most=most)
    assert run.finished
    return Driven(run)
