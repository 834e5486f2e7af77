"""FIR filters of set-points: weights, and how far they can lead an axis off its path. Kernels.

A filter of `half` h weights the 2h + 1 set-points around the one of h cycles ago. All weights are ≥ 0 and their sum is 1, so
no velocity, acceleration or jerk of the axis is greater than before; and both sides are equal, so everything comes h cycles
later and nothing else is shifted.

    moving average   all equal
    Gaussian         a bell whose standard deviation is `quality` · h / 3
    windowed sinc    sin(2π f t)/(2π f t) under a raised cosine, no wider than to its first zero:
                     behind it weights would be negative
    time delay       one weight, h cycles later than the middle

How far off the path: with v the velocity of the axis and j cycles of period T to both sides of the middle,

    q(-jT) + q(jT) - 2 q(0) = ∫ v(t) - v(-t) dt, 0…jT  ≤  A (jT)² + S jT

where the axis accelerates with A at most and may jump by S at corners.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]

NONE, MOVING_AVERAGE, GAUSSIAN, WINDOWED_SINC, TIME_DELAY = 0, 1, 2, 3, 4
MOST_HALF = 100  # cycles: an order of 200 at most
TAPS = 2 * MOST_HALF + 1
_EDGE = 3.0  # standard deviations of the bell from its middle to the end of the window


@kernel
def widest(kind: int, half: int, cut_off: float, period: float) -> int:
    """The greatest half, at most `half`, with which no weight is negative; `cut_off` in Hz."""
    if kind == WINDOWED_SINC:
        return min(half, int(0.5 / (cut_off * period) + 1e-9))
    return half


def filter_half(kind: int, order: int, cut_off: float, period: float) -> int:
    """The half of a filter of an order, cycles; an odd order is rounded down. A time delay is late by its whole order."""
    half = order if kind == TIME_DELAY else order // 2
    return int(widest(kind, min(half, MOST_HALF), cut_off, period))


@kernel
def one_side(kind: int, half: int, cut_off: float, quality: float, period: float, out: Floats) -> None:
    """The weights of the middle and of one side of it into `out` (≥ half + 1,); not for a time delay."""
    total = 0.0
    for j in range(half + 1):
        weight = 1.0
        if kind == GAUSSIAN and half > 0:
            z = j * _EDGE / (quality * half)
            weight = math.exp(-0.5 * z * z)
        elif kind == WINDOWED_SINC:
            x = 2.0 * math.pi * cut_off * period * j
            weight = (math.sin(x) / x if j > 0 else 1.0) * (0.54 + 0.46 * math.cos(math.pi * j / (half + 1)))
            weight = max(weight, 0.0)
        out[j] = weight
        total += weight if j == 0 else 2.0 * weight
    for j in range(half + 1):
        out[j] /= total


@kernel
def greatest_deviation(
    kind: int, half: int, share: float, period: float, side: Floats, velocity: float, acceleration: float, jump: float
) -> float:
    """How far an axis with these limits may come off its path, mm or degrees; `side` from `one_side`."""
    if kind == TIME_DELAY:
        return share * velocity * half * period
    found = 0.0
    for j in range(1, half + 1):
        way = j * period
        found += side[j] * way * (acceleration * way + jump)
    return share * found


@kernel
def fill_weights(
    kind: int,
    half: int,
    share: float,
    cut_off: float,
    quality: float,
    period: float,
    middle: int,
    axis: int,
    out: Floats,
) -> None:
    """The weights of an axis into `out` (TAPS, n), by the age of the set-point in cycles; `middle` is the age of the middle."""
    for age in range(out.shape[0]):
        out[age, axis] = 0.0
    if kind == TIME_DELAY:
        out[middle + half, axis] = share
    elif kind != NONE:
        side = np.empty(half + 1)
        one_side(kind, half, cut_off, quality, period, side)
        for j in range(half + 1):
            out[middle - j, axis] = share * side[j]
            out[middle + j, axis] = share * side[j]
    out[middle, axis] += 1.0 - share if kind != NONE else 1.0


@warms("FIR filter")
def _warm_up() -> None:
    side = np.zeros(2)
    half = widest(MOVING_AVERAGE, 1, 30.0, 0.001)
    one_side(MOVING_AVERAGE, half, 30.0, 1.0, 0.001, side)
    greatest_deviation(MOVING_AVERAGE, half, 1.0, 0.001, side, 1.0, 1.0, 0.0)
    fill_weights(MOVING_AVERAGE, half, 1.0, 30.0, 1.0, 0.001, 1, 0, np.zeros((TAPS, 1)))
