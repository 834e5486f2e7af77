"""Cubic B-splines over control points whose knots are as far apart as the points are: kernels.

    C0 ──────── C1 ────── C2 ──── C3            a span of the curve for every leg of the polygon; it begins and ends
     ╲________            ____╱                 in C0 and C_k along the first and last leg, without curvature there
              ╲__________╱

Curvature is continuous. The curve is steered towards the polygon where it is too far off: two further control points at a
distance d before and behind a corner, so that it follows the legs up to there. d is made smaller until the deviation, measured
on the result, is within the tolerance; a corner that can't be kept so is told.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.polynomial_table import TERMS
from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Flags = npt.NDArray[np.bool_]

PLACES = 5  # parts of a span, at whose ends the deviation is measured
CERTAIN = 0.96  # of a tolerance: what may lie higher between two places
MOST_OF_LEG = 0.45  # that a further control point may be away from its corner
ROUNDS = 14
LEAST = 1e-4  # mm: control points don't come nearer


@kernel
def span_of(c: Floats, t: Floats, j: int, out: Floats) -> None:
    """Coefficients (TERMS, n) of the span between control points j and j + 1 of `c` (k, n) with knots `t` (k,)."""
    before, here, after, behind = t[j - 1], t[j], t[j + 1], t[j + 2]
    first, last = t[j - 2], t[j + 3]
    for axis in range(c.shape[1]):
        leg = c[j + 1, axis] - c[j, axis]
        b1 = c[j, axis] + leg * (here - before) / (behind - before)
        b2 = c[j, axis] + leg * (after - before) / (behind - before)
        left = c[j - 1, axis] + (c[j, axis] - c[j - 1, axis]) * (here - first) / (after - first)
        b0 = left + (b1 - left) * (here - before) / (after - before)
        right = c[j + 1, axis] + (c[j + 2, axis] - c[j + 1, axis]) * (after - here) / (last - here)
        b3 = b2 + (right - b2) * (after - here) / (behind - here)
        out[0, axis] = b0
        out[1, axis] = 3.0 * (b1 - b0)
        out[2, axis] = 3.0 * (b2 - 2.0 * b1 + b0)
        out[3, axis] = b3 - 3.0 * b2 + 3.0 * b1 - b0
        out[4, axis] = 0.0
        out[5, axis] = 0.0


@kernel
def share_of_leg(p: Floats, a: Floats, b: Floats) -> float:
    """Where a place is beside a leg, 0…1."""
    square, product = 0.0, 0.0
    for axis in range(min(MAIN_AXES, p.shape[0])):
        way = b[axis] - a[axis]
        square += way * way
        product += way * (p[axis] - a[axis])
    return min(max(product / square, 0.0), 1.0) if square > 0.0 else 0.0


@kernel
def distance_from_leg(p: Floats, a: Floats, b: Floats) -> float:
    """Squared distance of a place from a leg of the polygon, in the main axes."""
    share = share_of_leg(p, a, b)
    off = 0.0
    for axis in range(min(MAIN_AXES, p.shape[0])):
        off += (p[axis] - a[axis] - share * (b[axis] - a[axis])) ** 2
    return off


@kernel
def leg_length(a: Floats, b: Floats) -> float:
    """Length of a leg in the main axes."""
    square = 0.0
    for axis in range(min(MAIN_AXES, a.shape[0])):
        square += (b[axis] - a[axis]) ** 2
    return math.sqrt(square)


@kernel
def control_points(points: Floats, near: Floats, c: Floats, t: Floats, leg: Ints) -> int:
    """Fill the control points `c` and knots `t`, phantoms in front of and behind them, and the programmed leg of each span.

    `points` (m, n); `near` (m,): distance of the further control points from a corner, 0 for none. Returns the number of
    control points without the phantoms; the first one stands at 2.
    """
    m, n = points.shape
    k = 2
    t[2] = 0.0
    for axis in range(n):
        c[2, axis] = points[0, axis]
    for i in range(m - 1):
        length = leg_length(points[i], points[i + 1])
        start, end = near[i], length - near[i + 1]
        if near[i] > 0.0:
            leg[k] = i
            k += 1
            t[k] = t[k - 1] + start
            for axis in range(n):
                c[k, axis] = points[i, axis] + (points[i + 1, axis] - points[i, axis]) * (start / length)
        if near[i + 1] > 0.0:
            leg[k] = i
            k += 1
            t[k] = t[k - 1] + end - start
            for axis in range(n):
                c[k, axis] = points[i, axis] + (points[i + 1, axis] - points[i, axis]) * (end / length)
        leg[k] = i
        k += 1
        t[k] = t[k - 1] + (near[i + 1] if near[i + 1] > 0.0 else length - start)
        for axis in range(n):
            c[k, axis] = points[i + 1, axis]
    second = t[4] if k > 3 else 2.0 * t[3]
    t[1], t[0] = -t[3], -second
    before = t[k - 2] if k > 3 else t[k] - 2.0 * (t[k] - t[k - 1])
    t[k + 1], t[k + 2] = 2.0 * t[k] - t[k - 1], 2.0 * t[k] - before
    for axis in range(n):
        c[1, axis] = 2.0 * c[2, axis] - c[3, axis]
        c[k + 1, axis] = 2.0 * c[k, axis] - c[k - 1, axis]
    return k - 1


@kernel
def measure(
    points: Floats, c: Floats, t: Floats, leg: Ints, count: int, off: Floats, track: Floats, reach: Floats, work: Floats
) -> None:
    """How far the curve is from the polygon near each corner (m,), in the main axes, and the greatest of a tracking axis.

    Places of the curve are held against three legs, corners against the chords between these places; a tracking axis
    against what it is on the leg beside the place. `work` (TERMS + 2, n) and `reach` (m,) are scratch.
    """
    m, n = points.shape
    for i in range(m):
        off[i], track[i], reach[i] = 0.0, 0.0, np.inf
    span, p, before = work[:TERMS], work[TERMS], work[TERMS + 1]
    for j in range(2, count + 1):
        span_of(c, t, j, span)
        i = leg[j]
        for place in range(PLACES + 1):
            u = place / PLACES
            for axis in range(n):
                p[axis] = ((span[3, axis] * u + span[2, axis]) * u + span[1, axis]) * u + span[0, axis]
            least = distance_from_leg(p, points[i], points[i + 1])
            if i > 0:
                least = min(least, distance_from_leg(p, points[i - 1], points[i]))
            if i + 2 < m:
                least = min(least, distance_from_leg(p, points[i + 1], points[i + 2]))
            share = share_of_leg(p, points[i], points[i + 1])
            corner = i if share < 0.5 else i + 1
            off[corner] = max(off[corner], least)
            for axis in range(MAIN_AXES, n):
                wanted = points[i, axis] + (points[i + 1, axis] - points[i, axis]) * share
                track[corner] = max(track[corner], abs(p[axis] - wanted))
            if place > 0:
                reach[i] = min(reach[i], distance_from_leg(points[i], before, p))
                reach[i + 1] = min(reach[i + 1], distance_from_leg(points[i + 1], before, p))
            for axis in range(n):
                before[axis] = p[axis]
    for i in range(1, m - 1):
        off[i] = math.sqrt(max(off[i], reach[i]))
    if m > 2:  # the ends themselves are met: what is off beside them is so because of the next corner
        off[1], off[m - 2] = max(off[1], math.sqrt(off[0])), max(off[m - 2], math.sqrt(off[m - 1]))
        track[1], track[m - 2] = max(track[1], track[0]), max(track[m - 2], track[m - 1])


@kernel
def steered(
    points: Floats,
    tolerance: Floats,
    tracking: Floats,
    near: Floats,
    c: Floats,
    t: Floats,
    leg: Ints,
    off: Floats,
    track: Floats,
) -> tuple[int, int]:
    """Control points of a curve within `tolerance` (m,) at each corner (main axes) and `tracking` (m,); 0 is not watched.

    `near` (m,) holds and gets the distances of further control points. Returns the number of control
    points and the first corner that can't be kept within its tolerance, or -1.
    """
    m, n = points.shape
    work, reach = np.zeros((TERMS + 2, n)), np.zeros(m)
    count = control_points(points, near, c, t, leg)
    if not (tolerance.max() > 0.0 or tracking.max() > 0.0):
        return count, -1
    failed = -1
    for _ in range(ROUNDS):
        measure(points, c, t, leg, count, off, track, reach, work)
        failed = -1
        changed = False
        for i in range(m):
            allowed = np.inf
            if tolerance[i] > 0.0 and off[i] > CERTAIN * tolerance[i]:
                allowed = CERTAIN * tolerance[i] / off[i]
            if tracking[i] > 0.0 and track[i] > CERTAIN * tracking[i]:
                allowed = min(allowed, CERTAIN * tracking[i] / track[i])
            if allowed == np.inf or i == 0 or i == m - 1:
                continue
            most = MOST_OF_LEG * min(leg_length(points[i - 1], points[i]), leg_length(points[i], points[i + 1]))
            wanted = most if near[i] == 0.0 else near[i] * min(max(0.95 * allowed, 0.2), 0.8)
            if wanted < LEAST:
                if failed < 0:
                    failed = i
                continue
            near[i] = wanted
            changed = True
        if not changed:
            return count, failed
        count = control_points(points, near, c, t, leg)
    measure(points, c, t, leg, count, off, track, reach, work)
    for i in range(1, m - 1):
        if (tolerance[i] > 0.0 and off[i] > tolerance[i]) or (tracking[i] > 0.0 and track[i] > tracking[i]):
            return count, i
    return count, failed


@kernel
def spans(c: Floats, t: Floats, begin: int, end: int, out: Floats) -> None:
    """Coefficients (k, TERMS, n) of the spans `begin` to before `end`."""
    for j in range(begin, end):
        span_of(c, t, j, out[j - begin])


@kernel
def merged(points: Floats, most: float, tracking: float, kept: Flags) -> None:
    """Mark which of the points (m, n) stay when legs are merged that are no farther than `most` from the new one.

    `tracking`: the same for other axes. At most 32 legs become one; the first and the last point stay.
    """
    m, n = points.shape
    for i in range(m):
        kept[i] = False
    kept[0] = kept[m - 1] = True
    anchor = 0
    while anchor < m - 1:
        end = anchor + 1
        while end + 1 < m and end + 1 - anchor <= 32:
            fits = True
            length = leg_length(points[anchor], points[end + 1])
            for i in range(anchor + 1, end + 1):
                if distance_from_leg(points[i], points[anchor], points[end + 1]) > most * most:
                    fits = False
                way = leg_length(points[anchor], points[i])
                if way > length:
                    fits = False
                for axis in range(MAIN_AXES, n):
                    wanted = points[anchor, axis]
                    if length > 0.0:
                        wanted += (points[end + 1, axis] - points[anchor, axis]) * way / length
                    if abs(points[i, axis] - wanted) > tracking:
                        fits = False
            if not fits:
                break
            end += 1
        kept[end] = True
        anchor = end


@warms("B-splines")
def _warm_up() -> None:
    points = np.zeros((3, 2))
    points[:, 0] = np.arange(3)
    c, t, leg = np.zeros((16, 2)), np.zeros(16), np.zeros(16, dtype=np.int64)
    steered(points, np.full(3, 0.1), np.zeros(3), np.zeros(3), c, t, leg, np.zeros(3), np.zeros(3))
    spans(c, t, 2, 3, np.zeros((1, TERMS, 2)))
    merged(points, 0.1, 0.1, np.zeros(3, dtype=np.bool_))
