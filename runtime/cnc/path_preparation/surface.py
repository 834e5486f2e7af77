"""#HSC [SURFACE]: legs that don't depend on where the programmed points are (programming manual 9205–9467).

Most of the tolerance goes into a polygon of means of the programmed path (`geometry/fairing.py`), the rest into the B-spline over
it. Both deviations are measured, so their sum is kept.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Arc, ArcPieces, Floats, Polyline, Segmentation, Spline
from runtime.cnc.geometry.fairing import faired
from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.cnc.path_preparation.legs import Legs, alike
from runtime.cnc.path_preparation.segmentation import arc_in_pieces

Flags = npt.NDArray[np.bool_]

FAIRING = 0.66  # of the tolerance
CURVE = 0.28  # of it for the B-spline; the rest is for arcs that become chords
CHORD = 0.05  # of the tolerance: chord error of an arc
MOST_TURN = math.radians(15.0)  # of a chord of an arc
CERTAIN = 1.0 - 1e-9


def exact_arc(arc: Arc, spline: Spline) -> bool:
    """Whether an arc stays one; a small one becomes part of the curve."""
    if not spline.arcs or arc.end_feed is not None or arc.override_off:
        return True
    if not arc.radius > spline.deviation:
        return False
    return abs(arc.angle) >= spline.least_angle and arc.radius >= spline.least_radius


def as_chords(arc: Arc, spline: Spline) -> Polyline | None:
    """A small arc as lines; None if it has no radius."""
    if not arc.radius > 0.0:
        return None
    error = min(CHORD * spline.deviation, arc.radius * (1.0 - math.cos(0.5 * MOST_TURN)))
    (made,) = arc_in_pieces(arc, Segmentation(arcs=True, mode=ArcPieces.CHORD_ERROR, parameter=error))
    return made if isinstance(made, Polyline) else None


def faired_legs(spline: Spline, legs: Legs) -> tuple[Legs, Floats, Floats]:
    """Legs of means, and what is left of the tolerances at each of their points, (k,): main axes, any other axis.

    Block ends inside of a new leg come at its end; where something is to be done, or the feed changes, a new leg begins.
    """
    legs.ends_from_actions()
    points, m = legs.array(), len(legs) + 1
    s = np.zeros(m)
    np.cumsum(np.sqrt((np.diff(points, axis=0)[:, :MAIN_AXES] ** 2).sum(axis=1)), out=s[1:])
    rapid = np.isinf(np.array(legs.feeds))
    tolerance, tracking = tolerances(spline, rapid)
    fixed = np.zeros(m, dtype=np.bool_)
    fixed[[k for k in legs.actions if 0 < k < m]] = True
    feeds = np.array(legs.feeds)
    fixed[1:-1] |= feeds[1:] != feeds[:-1]
    fixed[[i for i in range(1, m - 1) if not alike(legs.origins[i - 1], legs.origins[i])]] = True
    size = 8 * m + 256
    out, place, leg = np.zeros((size, points.shape[1])), np.zeros(size), np.zeros(size, dtype=np.int64)
    share, pinned = FAIRING * CERTAIN, np.zeros(m, dtype=np.bool_)
    count = faired(points, s, share * tolerance, share * tracking, fixed, out, place, leg, pinned)
    if count == 0:
        return legs, (1.0 - CHORD) * tolerance * CERTAIN, _watched((1.0 - CHORD) * tracking * CERTAIN)
    number = np.searchsorted(place[:count], s, side="left")  # the new leg at whose end each programmed point lies
    ends = np.zeros(count, dtype=np.bool_)
    ends[number[1:][np.array(legs.ends)]] = True
    of = np.minimum(np.searchsorted(s, 0.5 * (place[: count - 1] + place[1:count]), side="right") - 1, m - 2).tolist()
    made = Legs(
        list(out[:count].copy()), [legs.origins[i] for i in of], [legs.feeds[i] for i in of], [legs.lines[i] for i in of],
        [legs.numbers[i] for i in of], ends[1:].tolist(), {int(number[k]): v for k, v in legs.actions.items()},
    )  # fmt: skip
    on = leg[:count]
    left, whole = CURVE * CERTAIN, (1.0 - CHORD) * CERTAIN
    main = left * np.minimum(tolerance[on], tolerance[np.minimum(on + 1, m - 1)])
    other = left * np.minimum(tracking[on], tracking[np.minimum(on + 1, m - 1)])
    main[number[pinned]], other[number[pinned]] = (
        whole * tolerance[pinned],
        whole * tracking[pinned],
    )  # nothing is used yet
    return made, main, _watched(other)


def tolerances(spline: Spline, rapid: Flags) -> tuple[Floats, Floats]:
    """The tolerances at the m + 1 points of m legs, infinite: none; between two rapid ones there are others."""
    both = np.concatenate([rapid[:1], rapid[1:] & rapid[:-1], rapid[-1:]])
    main = np.where(both, spline.rapid_deviation or spline.deviation, spline.deviation)
    rapid_tracking = spline.tracking_deviation if spline.rapid_tracking is None else spline.rapid_tracking
    tracking = np.where(both, rapid_tracking, spline.tracking_deviation)
    return main, np.where(tracking > 0.0, tracking, np.inf)


def _watched(tolerance: Floats) -> Floats:
    """0 instead of infinity for what is not watched."""
    watched: Floats = np.where(np.isfinite(tolerance), tolerance, 0.0)
    return watched
