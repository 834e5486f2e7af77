"""Work and protection spaces: prisms over a polygon or a circle, and whether a path of chords stays in or out of them.

A space lies in three axes: two that span its contour, and one along which it reaches from `low` to `high`. What lies less than
EDGE beyond a border counts as on it, so a path may run along a border, and the chords of a curve (off by at most CHORD_ERROR)
may touch it.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

EDGE = 1e-3  # mm
CHORD_ERROR = 1e-4  # mm


@dataclass(frozen=True, slots=True, eq=False)
class Polygon:
    """`corners` (k, 2), mm; the last one is joined to the first."""

    corners: Floats

    def depth(self, points: Floats) -> Floats:
        """How far points (n, 2) lie inside of the border, (n,); negative: outside."""
        begin, end = self.corners, np.roll(self.corners, -1, axis=0)
        along = end - begin
        square = (along**2).sum(axis=1)
        away = points[:, None, :] - begin
        share = np.clip((away * along).sum(axis=2) / np.where(square > 0.0, square, 1.0), 0.0, 1.0)
        distance = np.linalg.norm(away - share[:, :, None] * along, axis=2).min(axis=1)
        x, y = points[:, :1], points[:, 1:]
        crosses = (begin[:, 1] > y) != (end[:, 1] > y)
        with np.errstate(divide="ignore", invalid="ignore"):
            at = begin[:, 0] + (y - begin[:, 1]) / (end[:, 1] - begin[:, 1]) * along[:, 0]
        inside = (crosses & (x < at)).sum(axis=1) % 2 == 1
        made: Floats = np.where(inside, distance, -distance)
        return made

    def crossings(self, start: Floats, way: Floats) -> list[float]:
        """The shares of a line from `start` over `way` (2,) at which it meets the border."""
        begin, along = self.corners, np.roll(self.corners, -1, axis=0) - self.corners
        away = begin - start
        across = way[0] * along[:, 1] - way[1] * along[:, 0]
        with np.errstate(divide="ignore", invalid="ignore"):
            share = (away[:, 0] * along[:, 1] - away[:, 1] * along[:, 0]) / across
        # where the line runs along an edge the ends of the edge count: they are those of its neighbours
        return [float(s) for s in share if 0.0 < s < 1.0]


@dataclass(frozen=True, slots=True, eq=False)
class Disc:
    """`centre` (2,), `radius` in mm."""

    centre: Floats
    radius: float

    def depth(self, points: Floats) -> Floats:
        """As of a polygon."""
        made: Floats = self.radius - np.linalg.norm(points - self.centre, axis=1)
        return made

    def crossings(self, start: Floats, way: Floats) -> list[float]:
        """As of a polygon; and where the line is nearest to the centre."""
        away = start - self.centre
        a, b, c = float(way @ way), float(away @ way), float(away @ away) - self.radius**2
        if a == 0.0:
            return []
        root = math.sqrt(max(b * b - a * c, 0.0))
        return [s for s in ((-b - root) / a, -b / a, (-b + root) / a) if 0.0 < s < 1.0]


@dataclass(frozen=True, slots=True, eq=False)
class ControlArea:
    """A space of the machine: `work` may not be left, a protection space not be entered.

    `axes`: channel indices of the two axes of the contour and the one of the excursion, `low` and `high` of which are in mm.
    """

    number: int
    work: bool
    axes: tuple[int, int, int]
    contour: Polygon | Disc
    low: float
    high: float

    def first_violation(self, points: Floats) -> int:
        """The first line of a path of `points` (k + 1, n_axes) that is not permitted, -1 if all are."""
        own = points[:, list(self.axes)]
        depth = self.contour.depth(own[:, :2])
        height = np.minimum(own[:, 2] - self.low, self.high - own[:, 2])
        within = np.minimum(depth, height)  # at most so far inside
        room = within if self.work else -within  # and at least so far away from the border on the permitted side
        length = np.linalg.norm(np.diff(own, axis=0), axis=1)
        for line in np.flatnonzero(room[:-1] <= length):
            if self._is_wrong(own[line], own[line + 1]):
                return int(line)
        return -1

    def permits(self, place: Sequence[float] | Floats) -> bool:
        """Whether a place (n_axes,) is permitted."""
        own = np.array([[place[axis] for axis in self.axes]], dtype=np.float64)
        return not self._is_wrong(own[0], own[0])

    def _is_wrong(self, start: Floats, end: Floats) -> bool:
        """Whether a line between two places (3,) has a part on the wrong side: it is looked at between all borders it meets."""
        way = end - start
        shares = [0.0, 1.0, *self.contour.crossings(start[:2], way[:2])]
        if way[2] != 0.0:
            shares += [s for s in ((border - start[2]) / way[2] for border in (self.low, self.high)) if 0.0 < s < 1.0]
        shares.sort()
        at = np.array([*shares, *(0.5 * (a + b) for a, b in pairwise(shares))])
        places = start + at[:, None] * way
        depth = self.contour.depth(places[:, :2])
        height = np.minimum(places[:, 2] - self.low, self.high - places[:, 2])
        inside = np.minimum(depth, height)
        return bool((inside < -EDGE).any() if self.work else (inside > EDGE).any())


def polynomial_points(coefficients: Floats) -> Floats:
    """Places on an element (6, n_axes), (k + 1, n_axes): chords that are off by at most CHORD_ERROR."""
    power = np.arange(6)
    bend = float(np.linalg.norm((power * (power - 1))[:, None] * np.abs(coefficients), axis=1).sum())  # of q'', at most
    count = max(1, math.ceil(math.sqrt(bend / (8.0 * CHORD_ERROR))))
    share = np.linspace(0.0, 1.0, count + 1)
    made: Floats = (share[:, None] ** power) @ coefficients
    return made


def circle_points(
    start: Floats, end: Floats, plane: tuple[int, int], centre: Floats, radius: float, angle: float
) -> Floats:
    """Places on an arc or a helix over `angle` degrees, (k + 1, n_axes): chords that are off by at most CHORD_ERROR."""
    step = 4.0 * math.asin(math.sqrt(min(CHORD_ERROR / (2.0 * max(radius, CHORD_ERROR)), 1.0)))
    count = max(1, math.ceil(math.radians(abs(angle)) / min(step, math.pi / 16)))
    share = np.linspace(0.0, 1.0, count + 1)[:, None]
    turn = math.radians(angle)
    axes = list(plane)
    away = start[axes] - centre

    def turned(by: Floats | float) -> Floats:
        c, s = np.cos(by), np.sin(by)
        return np.concatenate([away[0] * c - away[1] * s, away[0] * s + away[1] * c], axis=-1)

    made: Floats = start + share * (end - start)
    missing = end[axes] - centre - turned(np.array([turn]))
    made[:, axes] = centre + turned(turn * share) + share * missing
    return made
