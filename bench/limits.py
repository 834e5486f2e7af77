"""What axes are asked for at most, against what they can: random programs under a restless operator.

Velocity, acceleration and jerk are differences of the set-points. The axes of these programs allow no jump of velocity, so
nothing is left out: corners are stops, or curves of G261.

PROGRAMS in the environment says how many, 50 without it.
"""

from __future__ import annotations

import os
import random

import numpy as np
import numpy.typing as npt

from bench.figure import Figure
from runtime.cnc.blocks import Block, ContourChange, Contouring, Source
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation import smooth
from runtime.kernels import warm_up
from tests.cnc.interpolator.driving import PERIOD, drive
from tests.cnc.interpolator.test_laws import random_blocks, random_limits, restless

Floats = npt.NDArray[np.float64]

ALLOWED = {"velocity": 1.005, "acceleration": 1.005, "jerk": 1.05}


def ratios(seed: int) -> Floats:
    """Greatest velocity, acceleration and jerk of any axis in a random program, each over its limit, (3,); also of one that its
    operator lets come no further."""
    rng = random.Random(seed)
    limits = random_limits(rng)
    axes = AxisLimits(limits.velocity, limits.acceleration, limits.jerk, np.zeros(3))
    blocks, _ = random_blocks(rng, rng.randint(1, 8), np.zeros(3))
    stream: list[Block] = blocks
    if seed % 2:
        stream = list(smooth([ContourChange(Source("p", 1), Contouring(deviation=0.05)), *blocks], axes))
    run = drive(stream, axes, np.zeros(3), restless(rng, seed % 4), budget=4000, most=60_000, keep_records=False)
    if len(run.path) < 4:
        return np.zeros(3)  # nothing moves in it
    velocity = np.diff(run.path, axis=0) / PERIOD
    acceleration = np.diff(velocity, axis=0) / PERIOD
    jerk = np.diff(acceleration, axis=0) / PERIOD
    greatest = (limits.velocity, limits.acceleration, limits.jerk)
    return np.array(
        [(np.abs(row) / limit).max() for row, limit in zip((velocity, acceleration, jerk), greatest, strict=True)]
    )


def measure() -> list[Figure]:
    """The worst of all programs."""
    warm_up()
    programs = int(os.environ.get("PROGRAMS", "50"))
    worst = np.array([ratios(seed) for seed in range(programs)])
    return [
        Figure(f"greatest {name} of an axis over its limit, {programs} programs", float(worst[:, k].max()), "", limit)
        for k, (name, limit) in enumerate(ALLOWED.items())
    ]
