"""Path elements: where a line or an arc is, and which way it goes, at a share of its length. Kernels, pure mathematics.

    share 0 ───────────────── share 1          q   position of the axes, mm or degrees
    start      q(s), q'(s)        end          q'  its derivative by the path length s (1, or degrees per mm)

An arc turns the radius vector of its start about the centre. What is missing at the end to the programmed end
(rounding of the program, slightly different radii) is added in proportion to the share, so that the end is met
exactly and nothing jumps.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]


@kernel
def line_at(start: Floats, end: Floats, share: float, length: float, n: int, q: Floats, dq: Floats) -> None:
    """Write q(share) and q' of a line of `length` to the first `n` of `q`, `dq`; share 1 gives `end` to the bit."""
    for i in range(n):
        difference = end[i] - start[i]
        q[i] = end[i] if share >= 1.0 else start[i] + difference * share
        dq[i] = difference / length


@kernel
def arc_at(
    start: Floats,
    end: Floats,
    axis0: int,
    axis1: int,
    centre0: float,
    centre1: float,
    angle: float,
    share: float,
    length: float,
    n: int,
    q: Floats,
    dq: Floats,
) -> None:
    """Write q(share) and q' of an arc or helix; `angle` is the signed opening angle in radians, axes are indices."""
    line_at(start, end, share, length, n, q, dq)
    x, y = start[axis0] - centre0, start[axis1] - centre1
    cos_all, sin_all = math.cos(angle), math.sin(angle)
    missing0 = end[axis0] - (centre0 + x * cos_all - y * sin_all)
    missing1 = end[axis1] - (centre1 + x * sin_all + y * cos_all)
    cos_here, sin_here = math.cos(angle * share), math.sin(angle * share)
    radius0, radius1 = x * cos_here - y * sin_here, x * sin_here + y * cos_here
    turn = angle / length
    dq[axis0] = missing0 / length - turn * radius1
    dq[axis1] = missing1 / length + turn * radius0
    if share < 1.0:
        q[axis0] = centre0 + radius0 + missing0 * share
        q[axis1] = centre1 + radius1 + missing1 * share


def greatest_cosine(first: float, last: float) -> float:
    """Greatest |cos φ| for φ between two angles in radians, in either order."""
    low, high = min(first, last), max(first, last)
    if math.floor(high / math.pi) > math.floor(low / math.pi):
        return 1.0
    return max(abs(math.cos(low)), abs(math.cos(high)))


def cosine_range(first: float, last: float) -> tuple[float, float]:
    """Smallest and greatest cos φ for φ between two angles in radians, in either order."""
    low, high = min(first, last), max(first, last)
    ends = (math.cos(low), math.cos(high))
    turn = 2.0 * math.pi
    greatest = 1.0 if math.floor(high / turn) > math.floor(low / turn) or low % turn == 0.0 else max(ends)
    half = (low - math.pi) / turn, (high - math.pi) / turn
    smallest = -1.0 if math.floor(half[1]) > math.floor(half[0]) else min(ends)
    return smallest, greatest


@warms("path elements")
def _warm_up() -> None:
    a, b = np.zeros(8), np.ones(8)
    q, dq = np.zeros(8), np.zeros(8)
    line_at(a, b, 0.5, 1.0, 3, q, dq)
    arc_at(a, b, 0, 1, 1.0, 0.0, 1.0, 0.5, 1.0, 3, q, dq)
