"""The geometry of G02 and G03: from what is programmed to centre, radius and opening angle (programming manual
2193–2634).

Everything here happens in the plane: points are pairs in machine coordinates, mm, in the order of the plane's two
axes, so that a positive angle is counter-clockwise. Errors are raised as CircleError and get their place from the
decoder.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.cnc.decoder.geometry_error import GeometryError
from runtime.diagnostics.catalogue import language as catalogue

Point = tuple[float, float]

RESOLUTION = 1e-4  # mm, the manual's 0.1 µm
SAME_POINT = RESOLUTION / 2  # nearer than this, two points round to the same one
RADIUS_LIMIT = 1e9  # mm
FULL = 360.0  # degrees


class CircleError(GeometryError):
    """The circle is not possible."""


@dataclass(frozen=True, slots=True)
class Circle:
    """Centre and radius in mm, signed opening angle in degrees, counter-clockwise positive."""

    centre: Point
    radius: float
    angle: float


def by_centre(start: Point, end: Point, centre: Point, clockwise: bool, shift: float, share: float) -> Circle:
    """The arc around `centre`; start and end at the same point give a full circle.

    A centre that is not equally far from start and end is moved the shortest way to where it is (G165). The shift may
    be at most `shift` mm and at most `share` of the resulting radius; of the two readings of the manual's limit
    (lines 4884–4892) this is the stricter one. One resolution step is always allowed.
    """
    if math.dist(start, end) > SAME_POINT:
        moved = _onto_bisector(start, end, centre)
        distance = math.dist(moved, centre)
        limit = max(RESOLUTION, min(shift, share * math.dist(moved, start)))
        if distance > limit:
            raise CircleError(catalogue.CENTRE_DEVIATION, shift=distance, limit=limit)
        centre = moved
    return Circle(centre, _radius(start, centre), _opening(start, end, centre, clockwise))


def by_radius(start: Point, end: Point, radius: float, clockwise: bool) -> Circle:
    """The shorter arc for a positive radius, the longer one for a negative radius."""
    distance = math.dist(start, end)
    size = abs(radius)
    if distance <= SAME_POINT:
        raise CircleError(catalogue.RADIUS_FULL_CIRCLE)
    if size <= SAME_POINT:
        raise CircleError(catalogue.RADIUS_ZERO)
    if size > RADIUS_LIMIT:
        raise CircleError(catalogue.RADIUS_RANGE, radius=size, limit=RADIUS_LIMIT)
    half = distance / 2
    if half > size + RESOLUTION:
        raise CircleError(catalogue.RADIUS_TOO_SMALL, radius=size, distance=distance, needed=half)
    size = max(size, half)
    # The centre lies beside the middle of the chord: left of the way from start to end for the shorter arc
    # counter-clockwise, and on the other side if one of the two is turned around. (a + b)(a - b) keeps the digits of
    # a² - b² for flat arcs.
    height = math.sqrt(max(0.0, (size + half) * (size - half)))
    side = 1.0 if (radius > 0) != clockwise else -1.0
    along = ((end[0] - start[0]) / distance, (end[1] - start[1]) / distance)
    centre = (
        (start[0] + end[0]) / 2 - side * height * along[1],
        (start[1] + end[1]) / 2 + side * height * along[0],
    )
    angle = 2 * math.degrees(math.asin(min(1.0, half / size)))
    if radius < 0:
        angle = 360.0 - angle
    return Circle(centre, size, -angle if clockwise else angle)


def by_opening_angle(start: Point, centre: Point, opening: float, clockwise: bool) -> tuple[Circle, Point]:
    """The arc around `centre` that opens by `opening` degrees (0 to 360), and its end (#CANG, lines 2420–2451)."""
    if not 0.0 < opening <= FULL:
        raise CircleError(catalogue.OPENING_ANGLE, angle=opening)
    radius = _radius(start, centre)
    angle = -opening if clockwise else opening
    if opening == FULL:
        return Circle(centre, radius, angle), start
    cosine, sine = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    x, y = start[0] - centre[0], start[1] - centre[1]
    return Circle(centre, radius, angle), (centre[0] + cosine * x - sine * y, centre[1] + sine * x + cosine * y)


def by_kept_centre(start: Point, end: Point, centre: Point, clockwise: bool, difference: float, share: float) -> Circle:
    """The arc around exactly `centre` (G164); `radius` is that of the start, the end may have another one.

    Both radii may differ by `difference` mm (P-CHAN-00171) and, if `share` is not 0, by that share of the radius at
    the start (P-CHAN-00172). One resolution step is always allowed, so that `difference` 0 asks for a true arc. Only a
    start and end at the same point give a full circle.
    """
    radius, last = _radius(start, centre), _radius(end, centre)
    limit = max(RESOLUTION, min(difference, share * radius) if share > 0.0 else difference)
    if abs(last - radius) > limit:
        raise CircleError(catalogue.RADIUS_DIFFERENCE, start=radius, end=last, limit=limit)
    return Circle(centre, radius, _opening(start, end, centre, clockwise))


def turns_with_pitch(angle: float, height: float, pitch: float) -> float:
    """Opening angle of a helix with a programmed pitch (lines 2480–2584), signed like `angle`.

    `angle` is the opening angle of the plain arc, `height` the way of the third axis, `pitch` > 0 its way per turn.
    The target direction is passed after a, a + 1, a + 2 … turns (a: the plain arc). From the turns that the pitch
    asks for, a surplus of up to half a turn is dropped and a larger one filled up to the next passage; never fewer
    turns than the plain arc.
    """
    plain = abs(angle) / 360.0
    surplus = abs(height) / pitch - plain
    if surplus <= 0:
        return angle
    whole = math.floor(surplus)
    if surplus - whole > 0.5:
        whole += 1
    return math.copysign((plain + whole) * 360.0, angle)


def _radius(point: Point, centre: Point) -> float:
    """Distance of a point of the circle from its centre, if a circle can have it as its radius."""
    radius = math.dist(point, centre)
    if radius <= SAME_POINT:
        raise CircleError(catalogue.RADIUS_ZERO)
    if radius > RADIUS_LIMIT:
        raise CircleError(catalogue.RADIUS_RANGE, radius=radius, limit=RADIUS_LIMIT)
    return radius


def _onto_bisector(start: Point, end: Point, centre: Point) -> Point:
    """The point of the perpendicular bisector of start and end that is nearest to `centre`."""
    chord = (end[0] - start[0], end[1] - start[1])
    square = chord[0] ** 2 + chord[1] ** 2
    off = ((centre[0] - (start[0] + end[0]) / 2) * chord[0] + (centre[1] - (start[1] + end[1]) / 2) * chord[1]) / square
    return centre[0] - off * chord[0], centre[1] - off * chord[1]


def _opening(start: Point, end: Point, centre: Point, clockwise: bool) -> float:
    first = math.atan2(start[1] - centre[1], start[0] - centre[0])
    last = math.atan2(end[1] - centre[1], end[0] - centre[0])
    difference = math.degrees(last - first)
    if math.dist(start, end) <= SAME_POINT:  # a full circle, give or take the rounding of the points
        difference = (difference + 180.0) % 360.0 - 180.0
        return difference - 360.0 if clockwise else difference + 360.0
    difference %= 360.0
    return difference - 360.0 if clockwise else difference
