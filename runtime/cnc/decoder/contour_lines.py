"""Contour lines: straight moves by their angle, #ANG (programming manual 2701–2952).

Points are pairs in machine coordinates, mm, in the order of the plane's two axes; angles are degrees from the first
axis towards the second. A line is a ray: its target lies ahead of its start in the direction of the angle, or at the
start itself.

    #ANG X         one line, or the first of two (case 1)        the target follows at once
    #ANG           the first of two                              waits for the next block:
    #ANG X Y         case 2                                      corner: where both lines meet; end: as programmed
    #ANG X           special case 2-1                            the other coordinate of the end is that of the start
    #ANG             special case 2-2                            corner and end are the start, nothing moves in the plane
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.cnc.decoder.circles import RESOLUTION
from runtime.cnc.decoder.geometry_error import GeometryError
from runtime.diagnostics.catalogue import language as catalogue

Point = tuple[float, float]
Coordinates = tuple[float | None, float | None]

PARALLEL = 1e-9  # sine of the angle between two lines, or share of a line along an axis: below it, it is 0
_AXIS_DIRECTIONS = {0.0: (1.0, 0.0), 90.0: (0.0, 1.0), 180.0: (-1.0, 0.0), 270.0: (0.0, -1.0)}


class ContourLineError(GeometryError):
    """The contour line is not possible."""


@dataclass(frozen=True, slots=True)
class _Waiting:
    """A first line whose target is not known yet."""

    start: Point
    angle: float


class ContourLines:
    """What the decoder keeps about contour lines between its blocks; one for each program run.

    The decoder calls, for every block in its order,

    - `add(start, angle, coordinates, absolute)` for a block with #ANG. A list of one point: the target of this block.
      None: the block has to wait; the decoder keeps its words, feed, corner and functions, and does not move its
      position. A list of two points: the target of the block that waited, then that of this one; the decoder makes
      both motions now, in this order. `start` is the decoder's position, which for the second block is not known yet
      and not looked at. Coordinates are machine coordinates, already made absolute in a block with G91; for a second
      block with G91 they can't be and are refused, whatever they hold.
    - `expect_none()` before every other block with motion, before a change of plane, and at the end of the program.

    Errors are ContourLineError without a place; they leave nothing waiting.
    """

    def __init__(self) -> None:
        self._waiting: _Waiting | None = None

    @property
    def waiting(self) -> bool:
        """A block waits for the next one to get its target."""
        return self._waiting is not None

    def add(self, start: Point, angle: float, coordinates: Coordinates, absolute: bool = True) -> list[Point] | None:
        """A block with #ANG; `coordinates`: those of the target in the plane that are programmed, None for the others."""
        if self._waiting is not None:
            first, self._waiting = self._waiting, None
            if not absolute and coordinates != (None, None):
                raise ContourLineError(catalogue.CONTOUR_LINE_INCREMENTAL)
            return list(two_lines(first.start, first.angle, angle, coordinates))
        if coordinates == (None, None):
            self._waiting = _Waiting(start, angle)
            return None
        return [one_line(start, angle, coordinates)]

    def expect_none(self) -> None:
        """Something comes that is no contour line: none may be waiting for a second one."""
        if self._waiting is not None:
            first, self._waiting = self._waiting, None
            raise ContourLineError(catalogue.CONTOUR_LINE_UNDETERMINED, angle=first.angle)


def direction(angle: float) -> Point:
    """Unit vector of an angle in degrees, exact along the axes."""
    turned = angle % 360.0
    return _AXIS_DIRECTIONS.get(turned) or (math.cos(math.radians(turned)), math.sin(math.radians(turned)))


def one_line(start: Point, angle: float, coordinates: Coordinates) -> Point:
    """The target of a line by its angle and at least one coordinate.

    Both coordinates are taken as they are if they lie within RESOLUTION of the line. Raises ContourLineError if the
    target does not lie ahead, lies beside the line, or the angle does not determine it (a line along X, and only Y).
    """
    x, y = coordinates
    if x is not None and y is not None:
        _expect_on_ray(start, angle, (x, y))
        return x, y
    along = direction(angle)
    given = 0 if x is not None else 1
    value = coordinates[given]
    if value is None:
        raise ContourLineError(catalogue.CONTOUR_LINE_UNDETERMINED, angle=angle)
    way = value - start[given]
    if abs(along[given]) < PARALLEL:
        if abs(way) <= RESOLUTION:  # on the line, but where?
            raise ContourLineError(catalogue.CONTOUR_LINE_UNDETERMINED, angle=angle)
        raise _unreachable(coordinates, angle)
    share = way / along[given]
    if share < 0.0 and abs(way) > RESOLUTION:
        raise _unreachable(coordinates, angle)
    other = start[1 - given] + max(share, 0.0) * along[1 - given]
    return (value, other) if given == 0 else (other, value)


def two_lines(start: Point, first: float, second: float, coordinates: Coordinates) -> tuple[Point, Point]:
    """Corner and end of two lines by their angles and what is programmed of the end (cases 2, 2-1, 2-2).

    Raises ContourLineError if the lines are parallel, or the corner or the end does not lie ahead.
    """
    if coordinates == (None, None):
        return start, start
    x, y = coordinates
    end = (start[0] if x is None else x, start[1] if y is None else y)
    (a, b), (c, d) = direction(first), direction(second)
    sine = a * d - b * c
    if abs(sine) < PARALLEL:
        raise ContourLineError(catalogue.CONTOUR_LINE_PARALLEL, first=first, second=second)
    way = end[0] - start[0], end[1] - start[1]
    to_corner = (way[0] * d - way[1] * c) / sine
    to_end = (a * way[1] - b * way[0]) / sine
    if to_corner < -RESOLUTION:
        raise _unreachable(end, first)
    if to_end < -RESOLUTION:
        raise _unreachable(end, second)
    along = max(to_corner, 0.0)
    return (start[0] + along * a, start[1] + along * b), end


def _expect_on_ray(start: Point, angle: float, target: Point) -> None:
    along = direction(angle)
    way = target[0] - start[0], target[1] - start[1]
    beside = abs(along[0] * way[1] - along[1] * way[0])
    if beside > RESOLUTION:
        raise ContourLineError(catalogue.CONTOUR_LINE_OVERDETERMINED, angle=angle, distance=beside)
    if along[0] * way[0] + along[1] * way[1] < -RESOLUTION:
        raise _unreachable(target, angle)


def _unreachable(target: Coordinates, angle: float) -> ContourLineError:
    text = ", ".join("–" if value is None else f"{value:.6g}" for value in target)
    return ContourLineError(catalogue.CONTOUR_LINE_UNREACHABLE, target=f"target ({text})", angle=angle)
