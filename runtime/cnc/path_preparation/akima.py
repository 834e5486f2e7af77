"""Akima splines: cubics through points, whose tangents follow from five neighbours each.

The tangent at a point is a mean of the slopes before and behind it, each with the weight of how little the polygon bends on
its side; the slopes are those of the chord length, and the weights are those of the main axes, so that the curve does not
depend on how the part lies on the machine. Direction is continuous, curvature is not.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.polynomials import MAIN_AXES

Floats = npt.NDArray[np.float64]


def akima(points: Floats, before: Floats, behind: Floats, start: Floats | None, end: Floats | None) -> Floats:
    """Coefficients (m - 1, 6, n) of the curve through points (m, n), m at least 2.

    `before`, `behind` (0…2, n): further points on both sides that the curve has gone or will go through. `start`, `end` (n,):
    given tangents per mm of the main axes, NaN where an axis has none; they count where there are no further points.
    """
    everything = np.vstack([before, points, behind])
    way = np.diff(everything, axis=0)
    length = np.linalg.norm(way[:, :MAIN_AXES], axis=1)
    slope = way / length[:, None]
    first, last = slope[0], slope[-1]
    ahead = [2.0 * first - slope[1], 3.0 * first - 2.0 * slope[1]] if len(slope) > 1 else [first, first]
    after = [2.0 * last - slope[-2], 3.0 * last - 2.0 * slope[-2]] if len(slope) > 1 else [last, last]
    slopes = np.vstack([ahead[1], ahead[0], slope, after[0], after[1]])  # of leg k at k + 2
    bend = np.linalg.norm(np.diff(slopes, axis=0)[:, :MAIN_AXES], axis=1)
    right, left = bend[2:], bend[:-2]  # of point k: |s(k+1) - s(k)|, |s(k-1) - s(k-2)|
    total = right + left
    share = np.where(total > 1e-12, right / np.where(total > 1e-12, total, 1.0), 0.5)
    tangent = share[:, None] * slopes[1:-2] + (1.0 - share)[:, None] * slopes[2:-1]
    tangent = tangent[len(before) : len(before) + len(points)]
    speed = np.linalg.norm(tangent[:, :MAIN_AXES], axis=1)
    flat = speed < 1e-6
    tangent[~flat] /= speed[~flat, None]
    for given, at in ((start, 0), (end, -1)):
        if given is not None:
            tangent[at] = np.where(np.isnan(given), tangent[at], given)
    inside = slice(len(before), len(before) + len(points) - 1)
    h = length[inside][:, None]
    leg, t0, t1 = way[inside], tangent[:-1] * h, tangent[1:] * h
    made = np.zeros((len(points) - 1, 6, points.shape[1]))
    made[:, 0], made[:, 1] = points[:-1], t0
    made[:, 2] = 3.0 * leg - 2.0 * t0 - t1
    made[:, 3] = t0 + t1 - 2.0 * leg
    return made
