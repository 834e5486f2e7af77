"""Chamfers and roundings in the plane (programming manual 5478–5555): where they leave one element and meet the next.

Everything is seen from the corner K, which is the origin. An element is what it is there: heading h, the normal n to
its left, curvature k (counter-clockwise positive, 0 for a line) and how much of it there is.

              · · P                P: centre of the rounding, distance r from both elements, on the side
            ·  /  |                   to which the path turns. It is found for a turn to the left; a turn
          ·  r    | r                 to the right is mirrored before and after.
         T1 ──────+── K            t: way along the element from K to the tangent point T
                   \\ T2

Centre. The point of an element at the way t has the normal n(t), and P = T + r n(t). With the centre of curvature
n/k that gives, for lines and arcs alike,

    n(t) = (n - k P) / (1 - k r)        and from |n(t)| = 1        k (|P|² - r²) = 2 (n·P - r).

Two elements: with q = |P|² - r², P is linear in q, and q has a quadratic equation. Its root that vanishes with r
belongs to this corner, the other one to another crossing of the two elements. It stays the root of the same sign as
long as there is one, so that no choice remains.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

Vector = tuple[float, float]

TANGENTIAL = 1e-4  # rad: a smaller turn is no corner, a turn that lacks less to 180 degrees goes back the same way
FIT = 1e-7  # mm: by so much a size may exceed an element, it is the rounding of the numbers
_STEPS = 256  # places where the length of a chamfer between arcs is looked at, to find the first that fits
_HALVINGS = 60


@dataclass(frozen=True, slots=True)
class Element:
    """A neighbour of the corner: unit vector of travel there, curvature (1/mm), length in the plane (mm)."""

    heading: Vector
    curvature: float
    length: float

    @property
    def normal(self) -> Vector:
        return -self.heading[1], self.heading[0]

    def mirrored(self) -> Element:
        return Element((self.heading[0], -self.heading[1]), -self.curvature, self.length)

    def way_of_chord(self, chord: float) -> float:
        """Way along the element from the corner to the point at distance `chord`; inf where there is none."""
        half = abs(self.curvature) * chord / 2
        if half == 0.0:
            return chord
        return 2 * math.asin(half) / abs(self.curvature) if half <= 1.0 else math.inf

    def longest_chord(self) -> float:
        """Greatest distance from the corner up to which the element only goes away from it, mm."""
        k = abs(self.curvature)
        if k == 0.0:
            return self.length
        return 2 / k * math.sin(min(k * self.length, math.pi) / 2)


@dataclass(frozen=True, slots=True)
class Insert:
    """What is cut off both elements (mm along them), and for a rounding centre (from the corner) and opening angle
    (radians, counter-clockwise positive)."""

    first: float
    second: float
    centre: Vector = (0.0, 0.0)
    angle: float = 0.0


class TooLargeError(Exception):
    """The size does not fit; `largest` is the greatest one that does, mm."""

    def __init__(self, largest: float) -> None:
        super().__init__(largest)
        self.largest = largest


def turn(first: Element, second: Element) -> float:
    """Change of direction at the corner, radians from -π to π, to the left positive."""
    (a, b), (c, d) = first.heading, second.heading
    return math.atan2(a * d - b * c, a * c + b * d)


def rounding(first: Element, second: Element, radius: float) -> Insert:
    """The arc of `radius` that leaves `first` and meets `second` tangentially. Raises TooLargeError.

    The elements must turn by more than TANGENTIAL, and by less than 180 degrees minus TANGENTIAL.
    """
    if turn(first, second) < 0.0:
        left = rounding(first.mirrored(), second.mirrored(), radius)
        return Insert(left.first, left.second, (left.centre[0], -left.centre[1]), -left.angle)
    insert = _to_the_left(first, second, radius)
    if insert is None:
        raise TooLargeError(_largest(lambda size: _to_the_left(first, second, size) is not None, radius))
    return insert


def chamfer(first: Element, second: Element, width: float) -> Insert:
    """The line between the points of both elements that are `width` away from the corner. Raises TooLargeError."""
    largest = min(first.longest_chord(), second.longest_chord())
    if width > largest + FIT:
        raise TooLargeError(largest)
    width = min(width, largest)
    return Insert(min(first.way_of_chord(width), first.length), min(second.way_of_chord(width), second.length))


def chamfer_by_length(first: Element, second: Element, length: float) -> Insert:
    """The chamfer, equally wide on both elements, that is `length` long itself. Raises TooLargeError.

    Between arcs that come together again there may be two; it is the narrower one.
    """
    largest = min(first.longest_chord(), second.longest_chord())

    def reach(width: float) -> float:
        # Both chords are `width` long, so that only the angle between them counts. A chord is turned against the
        # tangent at the corner by half the angle of its arc: the angle between both was 180° - turn.
        bent = first.curvature * first.way_of_chord(width) + second.curvature * second.way_of_chord(width)
        return 2 * width * abs(math.cos((turn(first, second) + bent / 2) / 2))

    low, greatest = 0.0, 0.0
    for step in range(1, _STEPS + 1):
        high = largest * step / _STEPS
        there = reach(high)
        greatest = max(greatest, there)
        if there >= length or (step == _STEPS and there >= length - FIT):
            width = _largest(lambda size: reach(size) < length, high, low)
            return chamfer(first, second, width)
        low = high
    raise TooLargeError(greatest)


def _to_the_left(first: Element, second: Element, radius: float) -> Insert | None:
    """The rounding of a turn to the left, None if it does not fit."""
    if max(first.curvature, second.curvature) * radius >= 1.0:
        return None  # it would enclose the element instead of touching it from within
    (n0, n1), (m0, m1) = first.normal, second.normal
    determinant = n0 * m1 - n1 * m0  # sine of the turn
    # P = a + b q
    a = radius * (m1 - n1) / determinant, radius * (n0 - m0) / determinant
    k, c = first.curvature / 2, second.curvature / 2
    b = (k * m1 - c * n1) / determinant, (c * n0 - k * m0) / determinant
    # |b|² q² - 2 half q + free = 0
    half = 0.5 - (a[0] * b[0] + a[1] * b[1])
    free = a[0] ** 2 + a[1] ** 2 - radius**2
    square = b[0] ** 2 + b[1] ** 2
    discriminant = half**2 - square * free
    if half <= 0.0 or discriminant < 0.0:
        return None  # the elements come together before the circle has room
    q = free / (half + math.sqrt(discriminant))
    centre = a[0] + b[0] * q, a[1] + b[1] * q
    back, on = -_way(first, centre), _way(second, centre)
    angle = turn(first, second) + first.curvature * back + second.curvature * on
    if not (0.0 <= back <= first.length + FIT and 0.0 <= on <= second.length + FIT and 0.0 < angle < 2 * math.pi):
        return None
    return Insert(min(back, first.length), min(on, second.length), centre, angle)


def _way(element: Element, centre: Vector) -> float:
    """Way along an element from the corner to the foot of the perpendicular from `centre`."""
    (h0, h1), k = element.heading, element.curvature
    along = h0 * centre[0] + h1 * centre[1]
    if k == 0.0:
        return along
    return math.atan2(k * along, 1.0 - k * (h0 * centre[1] - h1 * centre[0])) / k


def _largest(fits: Callable[[float], bool], too_large: float, low: float = 0.0) -> float:
    """The greatest size that fits: all below it do, none above up to `too_large`."""
    high = too_large
    for _ in range(_HALVINGS):
        middle = (low + high) / 2
        if fits(middle):
            low = middle
        else:
            high = middle
    return low
