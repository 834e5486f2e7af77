"""How much of the acceleration curvature may take along a run of short lines: what the way ahead makes worth it. Kernel.

     v² ▲      most that curvature allows           each element gets the share of the acceleration for curvature at which
        │ ╲  ╭───╮    ╭──                           v²(s) is possible; what it leaves is as much as v²(s) needs there to
        │  ╲╱    ╲╱╲ ╱                              speed up and to brake
        │  ╱  v²(s) ╲
        └─╱─────────────────▶ s

v²(s) is the fastest motion without a jerk limit that keeps the feed at 100 % and the acceleration of every axis: from the
start up as fast as it can, and from the end down. Nothing depends on it for safety: the limits of an element hold
together whatever share was chosen, and never less than LEFT of what it could do on a straight line is left to brake.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]

MOST = 0.9  # of the acceleration, for curvature
LEFT = 0.3  # of the acceleration along the path on a straight line: what is left at least to speed up and brake


@kernel
def along_curve(
    square: float, direction: Floats, curvature: Floats, kappa: float, acceleration: Floats, least: float
) -> float:
    """Greatest acceleration along the path at v² = `square`, ≥ 0: the better of two bounds that both hold (see `dynamics`).

    `direction`, `curvature` (n,): |u| and |k|; `kappa`: |k| of all axes; `least`: acceleration of the weakest one concerned.
    """
    axes, plain = np.inf, np.inf
    for axis in range(direction.shape[0]):
        if direction[axis] > 0.0:
            axes = min(axes, (acceleration[axis] - curvature[axis] * square) / direction[axis])
            plain = min(plain, acceleration[axis] / direction[axis])
    across = kappa * square
    circle = math.sqrt(least * least - across * across) if across < least else 0.0
    return min(max(axes, circle), plain)


@kernel
def greatest_square(direction: Floats, curvature: Floats, kappa: float, acceleration: Floats, least: float) -> float:
    """Greatest v² that takes no more than MOST and leaves LEFT along the path; inf on a straight line."""
    if kappa <= 0.0:
        return np.inf
    plain = np.inf
    for axis in range(direction.shape[0]):
        if direction[axis] > 0.0:
            plain = min(plain, acceleration[axis] / direction[axis])
    left = LEFT * plain
    most, axes = np.inf, np.inf
    for axis in range(direction.shape[0]):
        if curvature[axis] > 0.0:
            most = min(most, MOST * acceleration[axis] / curvature[axis])
            axes = min(axes, (acceleration[axis] - left * direction[axis]) / curvature[axis])
    circle = math.sqrt(least * least - left * left) / kappa if left < least else 0.0
    return min(most, max(axes, circle))


@kernel
def curve_shares(
    direction: Floats, curvature: Floats, length: Floats, acceleration: Floats, cap: Floats, free: float, shares: Floats
) -> None:
    """Fill `shares` (m,) with the share of the acceleration, from `free` to MOST, that curvature may take on each line.

    `direction`, `curvature` (m, n): |u| and |k| of m lines of lengths (m,); `acceleration` (n,); `cap` (m + 1,): greatest
    velocities at their ends, whatever the curvature.
    """
    m, n = direction.shape
    kappa, least = np.zeros(m), np.zeros(m)
    square = np.empty(m + 1)
    for i in range(m + 1):
        square[i] = cap[i] * cap[i]
    for i in range(m):
        weakest, sum_of_squares = np.inf, 0.0
        for axis in range(n):
            sum_of_squares += curvature[i, axis] * curvature[i, axis]
            if direction[i, axis] > 0.0 or curvature[i, axis] > 0.0:
                weakest = min(weakest, acceleration[axis])
        kappa[i], least[i] = math.sqrt(sum_of_squares), weakest
        most = greatest_square(direction[i], curvature[i], kappa[i], acceleration, weakest)
        square[i], square[i + 1] = min(square[i], most), min(square[i + 1], most)
    for sense in range(2):
        for step in range(m):
            i = step if sense == 0 else m - 1 - step
            here, there = (i, i + 1) if sense == 0 else (i + 1, i)
            if square[there] <= square[here]:
                continue
            # less is possible the faster it is: what is possible at the upper end of what is possible here
            a = along_curve(square[here], direction[i], curvature[i], kappa[i], acceleration, least[i])
            top = min(square[here] + 2.0 * a * length[i], square[there])
            a = along_curve(top, direction[i], curvature[i], kappa[i], acceleration, least[i])
            square[there] = min(square[there], square[here] + 2.0 * a * length[i])
    for i in range(m):
        top, share = max(square[i], square[i + 1]), free
        for axis in range(n):
            share = max(share, curvature[i, axis] * top / acceleration[axis])
        shares[i] = min(share, MOST)


@warms("shares of curvature")
def _warm_up() -> None:
    one = np.ones((1, 2))
    curve_shares(one, one, np.ones(1), np.ones(2), np.ones(2), 0.5, np.zeros(1))
