"""A polygon that hardly depends on where the programmed one has its points: kernels.

    programmed   ●──●────●─●───────●      places are taken at distances of their own, each the mean of the path around it,
    faired       ◆────◆────◆────◆──◆      with a weight that falls linearly to both sides over the reach w

The reach is as long as the tolerance allows at each point: on a curve of radius R the mean lies w²/12R inside, at a corner that
turns by φ it is w/3·sin(φ/2) off. It changes by at most half of the way, so that it never reaches over the ends; neighbouring
places are STEP·w apart. A corner between legs that are long beside its reach stays as it is: the curve over the polygon has more
to gain there than means have. Both polygons are compared at the same length of the programmed one: between two corners of either
both are straight, so the greatest distance is that at a corner. It is no less than the distance of either from the other.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

STEP = 0.6  # of the reach, between two places
MEAN = 0.62  # of the tolerance for the means; the rest is for the chords between them
GROWTH = 0.5  # of the way, by which the reach may change
REACH = 48  # programmed points that a mean takes in on each side
ROUNDS = 24
SHRINK = 0.8  # of the reach where the tolerances are exceeded
FAR = 2.0 / (
    1.0 - GROWTH
)  # reaches from a point, from where no mean takes it in: two places further a long leg is one span
ALONE = 4.0  # reaches: a corner whose legs are longer than that is left to the curve
LEAST = 1e-3  # mm: a shorter reach is none


@kernel
def mean_off(points: Floats, s: Floats, at: float, leg: int, w: float, here: Floats, off: Floats) -> None:
    """The place `here` (n,) at length `at` on leg `leg`, and by how much the mean over the reach `w` is `off` it (n,).

    `points` (m, n) at lengths `s` (m,); the reach stays within them. Simpson's rule is exact: weight times place is a quadratic.
    """
    n = points.shape[1]
    share = (at - s[leg]) / (s[leg + 1] - s[leg])
    for axis in range(n):
        here[axis] = points[leg, axis] + share * (points[leg + 1, axis] - points[leg, axis])
        off[axis] = 0.0
    if not w > 0.0:
        return
    for side in range(2):
        i, a = leg, at
        reached = False
        while not reached:
            if side == 0:
                b = max(s[i], at - w)
                reached = s[i] <= at - w or i == 0
            else:
                b = min(s[i + 1], at + w)
                reached = s[i + 1] >= at + w or i == s.shape[0] - 2
            middle = 0.5 * (a + b)
            length = s[i + 1] - s[i]
            factor = abs(b - a) / (6.0 * w)
            wa, wm, wb = 1.0 - abs(a - at) / w, 1.0 - abs(middle - at) / w, 1.0 - abs(b - at) / w
            for axis in range(n):
                slope = (points[i + 1, axis] - points[i, axis]) / length
                begin = points[i, axis] - here[axis]
                pa, pm, pb = (
                    begin + slope * (a - s[i]),
                    begin + slope * (middle - s[i]),
                    begin + slope * (b - s[i]),
                )
                off[axis] += factor * (wa * pa + 4.0 * wm * pm + wb * pb)
            a = b
            i += -1 if side == 0 else 1


@kernel
def excess(off: Floats, tolerance: float, tracking: float) -> float:
    """How often the tolerances go into an offset (n,): main axes together, each other axis for itself; infinite: not watched."""
    square, most = 0.0, 0.0
    for axis in range(off.shape[0]):
        if axis < MAIN_AXES:
            square += off[axis] * off[axis]
        else:
            most = max(most, abs(off[axis]) / tracking)
    return max(most, math.sqrt(square) / tolerance)


@kernel
def smooth_reach(s: Floats, w: Floats) -> None:
    """Let the reach `w` (m,) change slowly along the length `s` (m,)."""
    m = s.shape[0]
    for i in range(1, m):
        w[i] = min(w[i], w[i - 1] + GROWTH * (s[i] - s[i - 1]))
    for i in range(m - 2, -1, -1):
        w[i] = min(w[i], w[i + 1] + GROWTH * (s[i + 1] - s[i]))


@kernel
def reaches(points: Floats, s: Floats, tolerance: Floats, tracking: Floats, w: Floats, work: Floats) -> None:
    """The reach `w` (m,) at each point with which its mean stays within the tolerances (m,). `work` (2, n) is scratch."""
    m = s.shape[0]
    w[0] = w[m - 1] = 0.0
    for i in range(1, m - 1):
        before, behind = s[i] - s[max(i - REACH, 0)], s[min(i + REACH, m - 1)] - s[i]
        reach = min(before, behind)
        if i > 1:
            reach = min(reach, 1.5 * w[i - 1] + GROWTH * (s[i] - s[i - 1]))
        if reach < LEAST:
            reach = min(before, behind)
        for _ in range(2 * ROUNDS):
            if reach < LEAST:
                break
            mean_off(points, s, s[i], i, reach, work[0], work[1])
            over = excess(work[1], MEAN * tolerance[i], MEAN * tracking[i])
            if over <= 1.0:
                break
            reach *= min(max(1.0 / over, 0.3), 0.95)
        w[i] = reach if reach >= LEAST else 0.0


@kernel
def march(
    points: Floats, s: Floats, w: Floats, least: float, fixed: Flags, out: Floats, place: Floats, leg_at: npt.NDArray[np.int64],
    work: Floats,
) -> int:  # fmt: skip
    """Take places along the path: means `out` (k, n) at lengths `place` (k,) on legs `leg_at` (k,); 0 if `out` is too short.

    `fixed` (m,): points at whose length a place is needed; `least`: they don't come nearer on their own. Points without a reach
    are places, too.
    """
    m = s.shape[0]
    place[0], leg_at[0], k = 0.0, 0, 1
    out[0] = points[0]
    i, at = 0, 0.0
    while at < s[m - 1]:
        reach = min(w[i] + GROWTH * (at - s[i]), w[i + 1] + GROWTH * (s[i + 1] - at))
        if i == 0 or i == m - 2:  # the ends keep their direction
            step = max(STEP * reach, 0.3 * (s[i + 1] - s[i]))
        else:
            step = max(STEP * reach, least)
        if at - s[i] >= FAR * w[i]:
            step = max(step, s[i + 1] - FAR * w[i + 1] - at)
        # the next point that has to be met
        j = i + 1
        while j < m - 1 and not fixed[j] and w[j] > 0.0 and s[j] < at + 2.0 * step:
            j += 1
        left = s[j] - at
        met = j == m - 1 or fixed[j] or not w[j] > 0.0
        if met and left <= 1.25 * step:
            at, i = s[j], j
        else:
            if met and left < 2.0 * step:
                step = 0.5 * left
            at += step
            while i < m - 2 and s[i + 1] <= at:
                i += 1
        if k >= out.shape[0]:
            return 0
        on = min(i, m - 2)
        reach = min(w[on] + GROWTH * (at - s[on]), w[on + 1] + GROWTH * (s[on + 1] - at))
        if at >= s[m - 1]:
            out[k] = points[m - 1]
            at = s[m - 1]
        else:
            mean_off(points, s, at, on, reach if reach >= LEAST else 0.0, work[0], work[1])
            for axis in range(points.shape[1]):
                out[k, axis] = work[0, axis] + work[1, axis]
        place[k], leg_at[k] = at, on
        k += 1
    return k


@kernel
def faired(
    points: Floats, s: Floats, tolerance: Floats, tracking: Floats, fixed: Flags, out: Floats, place: Floats,
    leg_at: npt.NDArray[np.int64], pinned: Flags,
) -> int:  # fmt: skip
    """The faired polygon `out` (k, n) of `points` (m, n), its lengths `place` (k,) along them and their legs; returns k.

    `s` (m,): length in the main axes, rising. `tolerance`, `tracking` (m,): mm in the main axes, and of any other axis; infinite
    is not watched. `pinned` (m,) becomes which points stay as they are. 0: there is none within the tolerances.
    """
    m, n = points.shape
    w, work = np.zeros(m), np.zeros((3, n))
    least = np.inf
    for i in range(m):
        least = min(least, tolerance[i])
    reaches(points, s, tolerance, tracking, w, work)
    for i in range(m):
        pinned[i] = 0 < i < m - 1 and min(s[i] - s[i - 1], s[i + 1] - s[i]) > ALONE * w[i]
    for i in range(m):
        if pinned[i]:  # half of its legs are free for the curve
            w[i] = 0.0
            w[i - 1] = min(w[i - 1], 0.5 * (s[i] - s[i - 1]) / FAR)
            w[i + 1] = min(w[i + 1], 0.5 * (s[i + 1] - s[i]) / FAR)
    for _ in range(ROUNDS):
        smooth_reach(s, w)
        k = march(points, s, w, least, fixed, out, place, leg_at, work)
        if k == 0:
            return 0
        held = True
        for j in range(k):
            i = leg_at[j]
            share = (place[j] - s[i]) / (s[i + 1] - s[i])
            for axis in range(n):
                work[2, axis] = out[j, axis] - points[i, axis] - share * (points[i + 1, axis] - points[i, axis])
            if excess(work[2], min(tolerance[i], tolerance[i + 1]), min(tracking[i], tracking[i + 1])) > 1.0:
                held = False
                w[i], w[i + 1] = SHRINK * w[i], SHRINK * w[i + 1]
        j = 0
        for i in range(1, m - 1):
            while place[j + 1] < s[i]:
                j += 1
            share = (s[i] - place[j]) / (place[j + 1] - place[j])
            for axis in range(n):
                work[2, axis] = out[j, axis] + share * (out[j + 1, axis] - out[j, axis]) - points[i, axis]
            if excess(work[2], tolerance[i], tracking[i]) > 1.0:
                held = False
                w[i] = SHRINK * w[i] if w[i] > LEAST else 0.0
        if held:
            return k
    return 0


@warms("faired polygons")
def _warm_up() -> None:
    points = np.zeros((4, 2))
    points[:, 0] = np.arange(4)
    tolerance, s = np.full(4, 0.1), np.arange(4.0)
    faired(
        points, s, tolerance, tolerance, np.zeros(4, dtype=np.bool_), np.zeros((64, 2)), np.zeros(64),
        np.zeros(64, dtype=np.int64), np.zeros(4, dtype=np.bool_),
    )  # fmt: skip
