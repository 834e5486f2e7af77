"""Curves that replace a corner between two path elements: kernels.

                       corner
     pre ──────────●┄┄┄┄┄●               ●  begin and end of the curve, a before and b behind the corner
                     ╲    ┊              ◆  interim point, where its two polynomials meet
                       ◆  ┊
                        ╲ ┊
                         ●  post

The two polynomials of degree 4 form one spline with a single inner knot. At its ends it has place, direction and curvature of
the shortened elements, at the interim point three continuous derivatives: that determines it. What is free is how fast the
parameter runs at the ends: 1 for a straight transition, a little less the sharper the corner is, which spreads the curvature.

The deviation of the result is measured between places of curve and corner at the same parameter, which is never less than
the distance of the curve from the corner and of any of its places from the programmed path.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.elements import arc_at, line_at
from runtime.cnc.geometry.polynomial_table import TERMS, WIDTH
from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]
Elements = npt.NDArray[np.void]

LINE, ARC = 0, 1
PIECES = 4  # polynomials of a curve at most

ELEMENT = np.dtype(
    [
        ("kind", "i8"),  # LINE, ARC
        ("start", "f8", (WIDTH,)),
        ("end", "f8", (WIDTH,)),
        ("length", "f8"),  # along the main axes, 0 if they rest
        ("axis0", "i8"),
        ("axis1", "i8"),
        ("centre0", "f8"),
        ("centre1", "f8"),
        ("angle", "f8"),  # radians, signed
        ("radius", "f8"),
        ("feed", "f8"),  # mm/s
    ],
    align=True,
)

SETTINGS = np.dtype(
    [
        ("method", "i8"),  # BY_DEVIATION …
        ("deviation", "f8"),  # mm
        ("before", "f8"),  # corner distances, mm
        ("behind", "f8"),
        ("tracking", "f8"),  # deviation of tracking axes, 0: not watched; of SOFT their distance, negative: not watched
        ("share", "f8"),  # of a block that a corner may take, 0…0.5
        ("angle", "f8"),  # radians: greatest change of direction between lines
        ("point", "f8", (MAIN_AXES,)),  # interim point, NaN: none
        ("least", "f8"),  # SOFT: share of the acceleration to begin with, greatest share, weight of the ramp time
        ("most", "f8"),
        ("ramp", "f8"),
    ],
    align=True,
)

BY_DEVIATION, BY_DISTANCE, SOFT, THROUGH_POINT, WHOLE = 0, 1, 2, 3, 4

WHOLE_RAMP = 0.4  # of the curve of WHOLE, in which its acceleration rises, and falls

SHORTEST = 5e-4  # mm: a corner distance below it is none
SAME = 1e-9  # of unit vectors: tangential
MOST_ARC = math.pi / 2
_PLACES = 16  # where a curve is compared with its corner
_NARROWINGS = 40
_CERTAIN = 1.0 - 1e-9


@kernel
def element_at(e: np.void, s: float, n: int, q: Floats, dq: Floats, ddq: Floats) -> None:
    """Place and derivatives by the length of an element at length `s`."""
    share = s / e["length"]
    for axis in range(n):
        ddq[axis] = 0.0
    if e["kind"] == LINE:
        line_at(e["start"], e["end"], share, e["length"], n, q, dq)
        return
    arc_at(
        e["start"], e["end"], e["axis0"], e["axis1"], e["centre0"], e["centre1"], e["angle"], share, e["length"], n, q, dq
    )  # fmt: skip
    turn = e["angle"] / e["length"]
    ddq[e["axis0"]] = -turn * turn * (q[e["axis0"]] - e["centre0"])
    ddq[e["axis1"]] = -turn * turn * (q[e["axis1"]] - e["centre1"])


@kernel
def quartics(
    p0: Floats, d0: Floats, s0: Floats, p1: Floats, d1: Floats, s1: Floats, h0: float, h1: float, n: int, out: Floats
) -> None:
    """Two quartics over h0 and h1 with place, first and second derivative at both ends; `out` (≥ 2, TERMS, n)."""
    h = h0 + h1
    share = h0 / h
    for axis in range(n):
        b0, b5 = p0[axis], p1[axis]
        b1, b4 = b0 + d0[axis] * h0 / 4.0, b5 - d1[axis] * h1 / 4.0
        b2 = b1 + (d0[axis] + s0[axis] * h0 / 3.0) * h / 4.0
        b3 = b4 - (d1[axis] - s1[axis] * h1 / 3.0) * h / 4.0
        q2, q3, q4 = b1 + share * (b2 - b1), b2 + share * (b3 - b2), b3 + share * (b4 - b3)
        r3, r4 = q2 + share * (q3 - q2), q3 + share * (q4 - q3)
        middle = r3 + share * (r4 - r3)
        from_control_points(out[0], axis, b0, b1, q2, r3, middle)
        from_control_points(out[1], axis, middle, r4, q4, b4, b5)


@kernel
def from_control_points(c: Floats, axis: int, b0: float, b1: float, b2: float, b3: float, b4: float) -> None:
    """Coefficients of a quartic from its Bézier points."""
    c[0, axis] = b0
    c[1, axis] = 4.0 * (b1 - b0)
    c[2, axis] = 6.0 * (b2 - 2.0 * b1 + b0)
    c[3, axis] = 4.0 * (b3 - 3.0 * b2 + 3.0 * b1 - b0)
    c[4, axis] = b4 - 4.0 * b3 + 6.0 * b2 - 4.0 * b1 + b0
    c[5, axis] = 0.0


@kernel
def through_point(
    p0: Floats,
    d0: Floats,
    s0: Floats,
    p1: Floats,
    d1: Floats,
    s1: Floats,
    h0: float,
    h1: float,
    point: Floats,
    out: Floats,
) -> None:
    """In the main axes: two quartics that meet in `point` with two continuous derivatives."""
    for axis in range(point.shape[0]):
        b0, b4, c4 = p0[axis], point[axis], p1[axis]
        b1, c3 = b0 + d0[axis] * h0 / 4.0, c4 - d1[axis] * h1 / 4.0
        b2 = 2.0 * b1 - b0 + s0[axis] * h0 * h0 / 12.0
        c2 = 2.0 * c3 - c4 + s1[axis] * h1 * h1 / 12.0
        slope = ((c2 - b4) / (h1 * h1) + (b4 - b2) / (h0 * h0)) / (2.0 / h0 + 2.0 / h1)
        from_control_points(out[0], axis, b0, b1, b2, b4 - h0 * slope, b4)
        from_control_points(out[1], axis, b4, b4 + h1 * slope, c2, c3, c4)


@kernel
def value(c: Floats, axis: int, u: float) -> float:
    """One axis of an element (TERMS, n) at u."""
    here = 0.0
    for power in range(TERMS - 1, -1, -1):
        here = here * u + c[power, axis]
    return here


@kernel
def deviations(
    pre: np.void, post: np.void, a: float, b: float, n: int, out: Floats, work: Floats
) -> tuple[float, float]:
    """Greatest distance, in the main axes and of any tracking axis, of two polynomials from the corner they replace."""
    main, tracking = 0.0, 0.0
    for piece in range(2):
        e, way = (pre, a) if piece == 0 else (post, b)
        for place in range(_PLACES + 1):
            u = place / _PLACES
            s = e["length"] - way + way * u if piece == 0 else way * u
            element_at(e, s, n, work[0], work[1], work[2])
            square = 0.0
            for axis in range(n):
                off = value(out[piece], axis, u) - work[0, axis]
                if axis < MAIN_AXES:
                    square += off * off
                else:
                    tracking = max(tracking, abs(off))
            main = max(main, square)
    return math.sqrt(main), tracking


@kernel
def blend(pre: np.void, post: np.void, a: float, b: float, pace: float, n: int, out: Floats, work: Floats) -> None:
    """The spline from `a` before the end of `pre` to `b` behind the start of `post`."""
    element_at(pre, pre["length"] - a, n, work[0], work[1], work[2])
    element_at(post, b, n, work[3], work[4], work[5])
    # the control points next to the knot may not pass the corner, or the curve has a loop
    least = min(pace, min(4.0 * a / (2.0 * a + b), 4.0 * b / (2.0 * b + a)))
    for axis in range(n):
        work[1, axis] *= least
        work[2, axis] *= least * least
        work[4, axis] *= least
        work[5, axis] *= least * least
    quartics(work[0], work[1], work[2], work[3], work[4], work[5], a, b, n, out)


@kernel
def soft_curve(pre: np.void, post: np.void, a: float, ramp: float, t0: Floats, t1: Floats, n: int, out: Floats) -> None:
    """Four polynomials in which the acceleration rises over `ramp` (share of the time, 0…0.5), stays and falls.

    The direction is t0 + (t1 - t0) φ(τ) with φ from 0 to 1; lines only. The pieces meet at ramp, 1/2 and 1 - ramp.
    """
    top = 1.0 / (1.0 - ramp)
    flat = 0.5 - ramp
    for axis in range(n):
        begin, end = pre["end"][axis] - a * t0[axis], post["start"][axis] + a * t1[axis]
        turn = t1[axis] - t0[axis]
        for piece in range(PIECES):
            for power in range(TERMS):
                out[piece, power, axis] = 0.0
        out[0, 0, axis] = begin
        out[0, 1, axis] = 2.0 * a * t0[axis] * ramp
        out[0, 3, axis] = 2.0 * a * turn * top * ramp * ramp / 6.0
        at = begin + out[0, 1, axis] + out[0, 3, axis]
        slope = 2.0 * a * (t0[axis] + turn * top * ramp / 2.0)
        bend = 2.0 * a * turn * top
        out[1, 0, axis], out[1, 1, axis], out[1, 2, axis] = at, slope * flat, bend * flat * flat / 2.0
        at += out[1, 1, axis] + out[1, 2, axis]
        slope += bend * flat
        out[2, 0, axis], out[2, 1, axis], out[2, 2, axis] = at, slope * flat, bend * flat * flat / 2.0
        # the last one is the first one backwards
        c1, c3 = 2.0 * a * t1[axis] * ramp, -2.0 * a * turn * top * ramp * ramp / 6.0
        out[3, 0, axis] = end - c1 - c3
        out[3, 1, axis] = c1 + 3.0 * c3
        out[3, 2, axis] = -3.0 * c3
        out[3, 3, axis] = c3


@kernel
def soft_distance(
    feed: float, share: float, weight: float, t0: Floats, t1: Floats, acceleration: Floats, jerk: Floats, n: int
) -> tuple[float, float]:
    """Corner distance and share of the ramp at which the axes turn with `share` of their acceleration at `feed`."""
    turning, rising = 0.0, 0.0
    for axis in range(n):
        change = abs(t1[axis] - t0[axis])
        if change > 1e-12:
            turning = max(turning, feed * change / (share * acceleration[axis]))
            rising = max(rising, weight * share * acceleration[axis] / jerk[axis])
    time = turning + rising if turning >= rising else 2.0 * math.sqrt(turning * rising)
    if not time > 0.0:
        return 0.0, 0.5
    return feed * time / 2.0, min(max(rising / time, 0.05), 0.499)


@kernel
def longest(e: np.void, share: float) -> float:
    """How much of an element a corner may take."""
    way: float = share * e["length"]
    if e["kind"] == ARC and e["radius"] * abs(e["angle"]) > 0.0:
        way = min(way, MOST_ARC / abs(e["angle"]) * e["length"])
    return way


@kernel
def corner_curve(
    pre: np.void,
    post: np.void,
    settings: np.void,
    velocity: Floats,
    acceleration: Floats,
    jerk: Floats,
    n: int,
    out: Floats,
    work: Floats,
) -> tuple[int, float, float]:
    """The curve at the corner between two elements: number of polynomials in `out` (PIECES, TERMS, n), 0 for none, and
    by how much the elements are shortened. `work` (6, n) is scratch."""
    if not (pre["length"] > 0.0 and post["length"] > 0.0):
        return 0, 0.0, 0.0
    element_at(pre, pre["length"], n, work[0], work[1], work[2])
    element_at(post, 0.0, n, work[3], work[4], work[5])
    same, mirrored, product, track_turn = True, True, 0.0, False
    for axis in range(n):
        same = same and abs(work[4, axis] - work[1, axis]) <= SAME
        mirrored = mirrored and abs(work[4, axis] + work[1, axis]) <= SAME
        if axis < MAIN_AXES:
            product += work[1, axis] * work[4, axis]
        else:
            track_turn = track_turn or abs(work[4, axis] - work[1, axis]) > SAME
    turn = math.acos(min(max(product, -1.0), 1.0))
    through = settings["method"] == THROUGH_POINT
    if (same or mirrored) and not through:
        return 0, 0.0, 0.0
    if turn < 1e-7 and not (track_turn and settings["tracking"] > 0.0) and not through:
        return 0, 0.0, 0.0
    lines = pre["kind"] == LINE and post["kind"] == LINE
    if lines and turn > settings["angle"] + 1e-9:
        return 0, 0.0, 0.0
    most_a, most_b = longest(pre, settings["share"]), longest(post, settings["share"])
    if settings["method"] == SOFT and lines:
        return soft_corner(pre, post, settings, velocity, acceleration, jerk, min(most_a, most_b), n, out, work)
    if settings["method"] == WHOLE:
        return whole_corner(pre, post, settings, min(most_a, most_b), n, out, work) if lines else (0, 0.0, 0.0)
    a, b = min(settings["before"], most_a), min(settings["behind"], most_b)
    if settings["before"] == settings["behind"]:
        a = b = min(a, b)
    if through:
        point_curve(pre, post, a, b, settings, n, out, work)
        return 2, a, b
    pace = 1.0 - 0.2 * turn / math.pi
    if settings["method"] == BY_DEVIATION:
        a = b = min(most_a, most_b)
    if min(a, b) < SHORTEST:
        return 0, 0.0, 0.0
    watched = settings["method"] == BY_DEVIATION
    tracked = settings["tracking"] > 0.0 and settings["method"] != SOFT
    blend(pre, post, a, b, pace, n, out, work)
    if not (watched or tracked):
        return 2, a, b
    main, tracking = deviations(pre, post, a, b, n, out, work)
    shrink = 1.0
    if watched and main > settings["deviation"]:
        shrink = settings["deviation"] / main
    if tracked and tracking > settings["tracking"]:
        shrink = min(shrink, settings["tracking"] / tracking)
    if shrink == 1.0:
        return 2, a, b
    if lines:  # everything is in proportion to the distances
        shrink *= _CERTAIN
        a, b = a * shrink, b * shrink
        if min(a, b) < SHORTEST:
            return 0, 0.0, 0.0
        blend(pre, post, a, b, pace, n, out, work)
        return 2, a, b
    low, high = 0.0, 1.0
    for _ in range(_NARROWINGS):
        middle = 0.5 * (low + high)
        if middle * min(a, b) < SHORTEST:
            low = middle
            continue
        blend(pre, post, a * middle, b * middle, pace, n, out, work)
        main, tracking = deviations(pre, post, a * middle, b * middle, n, out, work)
        if (watched and main > settings["deviation"] * _CERTAIN) or (tracked and tracking > settings["tracking"]):
            high = middle
        else:
            low = middle
        if high - low < 1e-4 and low * min(a, b) >= SHORTEST:
            break
    a, b = a * low, b * low
    if min(a, b) < SHORTEST:
        return 0, 0.0, 0.0
    blend(pre, post, a, b, pace, n, out, work)
    return 2, a, b


@kernel
def soft_corner(
    pre: np.void,
    post: np.void,
    settings: np.void,
    velocity: Floats,
    acceleration: Floats,
    jerk: Floats,
    most: float,
    n: int,
    out: Floats,
    work: Floats,
) -> tuple[int, float, float]:
    """The dynamically optimised curve between lines, whose directions stand in `work` 1 and 4."""
    t0, t1 = work[1], work[4]
    feed = min(pre["feed"], post["feed"])
    for axis in range(n):
        fastest = max(abs(t0[axis]), abs(t1[axis]))
        if fastest > 0.0:
            feed = min(feed, velocity[axis] / fastest)
    if settings["before"] >= 0.0:
        most = min(most, settings["before"])
    if settings["tracking"] >= 0.0:
        for axis in range(MAIN_AXES, n):
            fastest = max(abs(t0[axis]), abs(t1[axis]))
            if fastest > 0.0:
                most = min(most, settings["tracking"] / fastest)
    a, ramp = soft_distance(feed, settings["least"], settings["ramp"], t0, t1, acceleration, jerk, n)
    if a > most:
        a, ramp = soft_distance(feed, settings["most"], settings["ramp"], t0, t1, acceleration, jerk, n)
    a = min(a, most)
    if a < SHORTEST:
        return 0, 0.0, 0.0
    soft_curve(pre, post, a, ramp, t0, t1, n, out)
    return PIECES, a, a


@kernel
def whole_corner(
    pre: np.void, post: np.void, settings: np.void, most: float, n: int, out: Floats, work: Floats
) -> tuple[int, float, float]:
    """The longest curve between lines, whose directions stand in `work` 1 and 4, within distance and deviation.

    It is the same from both ends, so its middle is the place that is farthest from the corner's legs, and nearest to it.
    """
    a = min(most, settings["before"])
    if a < SHORTEST:
        return 0, 0.0, 0.0
    soft_curve(pre, post, a, WHOLE_RAMP, work[1], work[4], n, out)
    off = 0.0
    for axis in range(min(MAIN_AXES, n)):
        off += (out[2, 0, axis] - post["start"][axis]) ** 2
    off = math.sqrt(off)
    if off > settings["deviation"]:
        a *= settings["deviation"] / off * _CERTAIN
        if a < SHORTEST:
            return 0, 0.0, 0.0
        soft_curve(pre, post, a, WHOLE_RAMP, work[1], work[4], n, out)
    return PIECES, a, a


@kernel
def point_curve(
    pre: np.void, post: np.void, a: float, b: float, settings: np.void, n: int, out: Floats, work: Floats
) -> None:
    """A curve through the interim point; tracking axes go along as at any corner."""
    element_at(pre, pre["length"] - a, n, work[0], work[1], work[2])
    element_at(post, b, n, work[3], work[4], work[5])
    h0, h1 = 0.0, 0.0
    last = min(MAIN_AXES, n)
    for axis in range(last):
        h0 += (settings["point"][axis] - work[0, axis]) ** 2
        h1 += (settings["point"][axis] - work[3, axis]) ** 2
    h0, h1 = max(math.sqrt(h0), 1e-3), max(math.sqrt(h1), 1e-3)
    for axis in range(last, n):  # over their own way, or they would run far ahead
        work[1, axis] *= a / h0
        work[4, axis] *= b / h1
    quartics(work[0], work[1], work[2], work[3], work[4], work[5], h0, h1, n, out)
    through_point(work[0], work[1], work[2], work[3], work[4], work[5], h0, h1, settings["point"][:last], out)


@kernel
def corner_curves(
    elements: Elements,
    settings: Elements,
    velocity: Floats,
    acceleration: Floats,
    jerk: Floats,
    count: Ints,
    trims: Floats,
    out: Floats,
) -> None:
    """The curves between m elements: `count` (m - 1,) polynomials, `trims` (m - 1, 2), `out` (m - 1, PIECES, TERMS, n)."""
    n = velocity.shape[0]
    work = np.zeros((6, n))
    for corner in range(elements.shape[0] - 1):
        count[corner], trims[corner, 0], trims[corner, 1] = corner_curve(
            elements[corner], elements[corner + 1], settings[0], velocity, acceleration, jerk, n, out[corner], work
        )  # fmt: skip


@warms("contour curves")
def _warm_up() -> None:
    ones = np.ones(2)
    element = np.ones(1, dtype=ELEMENT)  # splines ask for one from outside of the kernels
    element_at(element[0], 1.0, 2, ones, ones, ones)
    corner_curves(
        np.zeros(2, dtype=ELEMENT), np.zeros(1, dtype=SETTINGS), ones, ones, ones, np.zeros(1, dtype=np.int64),
        np.zeros((1, 2)), np.zeros((1, PIECES, TERMS, 2)),
    )  # fmt: skip
