"""#HSC [OPMODE 2]: curves through the points, straight where the part is prismatic (programming manual 10925–11055).

A leg is prismatic if the path turns sharply at one of its ends, or if it is much longer than those before. Prismatic legs stay
lines, whose corners are left to contouring; the curve between them goes over into them tangentially.
"""

from __future__ import annotations

from collections.abc import Iterator
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Block, Floats, Spline
from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.cnc.path_preparation.akima import akima
from runtime.cnc.path_preparation.legs import Legs, handed_on, straight_legs

Flags = npt.NDArray[np.bool_]

CONTEXT = 3  # legs that a curve looks ahead
BEFORE = 5  # blocks whose median length counts


class InterpolatingCurve:
    """One curve from its selection to its end; in windows, if it is long."""

    def __init__(self, spline: Spline) -> None:
        self._spline = spline
        self._lengths: list[float] = []  # of the legs before
        self._sharp = False  # the path turns sharply behind the last leg that was handed on
        self._behind: Floats | None = None  # places (0…2, n) of the curve before the first leg that waits
        self._line: Floats | None = None  # direction of a prismatic leg there

    def window(self, legs: Legs) -> tuple[Iterator[Block], Legs]:
        """The blocks of most of the legs, and the rest."""
        count = len(legs) - CONTEXT
        points = legs.array()
        marks, sharp = self._marks(points)
        first, rest = legs.split(count)
        ahead = points[count + 1 : count + (1 if marks[count] else 2 if marks[count + 1] else 3)]
        line = _direction(points[count + 1] - points[count]) if marks[count] else None
        self._sharp = bool(sharp[count - 1])
        return self._handed_on(first, marks[:count], ahead, line), rest

    def finish(self, legs: Legs) -> Iterator[Block]:
        """The blocks of all legs: the curve ends."""
        points = legs.array()
        return self._handed_on(legs, self._marks(points)[0], points[:0], None)

    def _marks(self, points: Floats) -> tuple[Flags, Flags]:
        """Which legs between points (k + 1, n) are prismatic (k,), and which corners between them are sharp (k - 1,)."""
        way = np.diff(points[:, :MAIN_AXES], axis=0)
        length = np.sqrt((way**2).sum(axis=1))
        marks = np.zeros(len(length), dtype=np.bool_)
        with np.errstate(invalid="ignore", divide="ignore"):
            cosine = (way[1:] * way[:-1]).sum(axis=1) / (length[1:] * length[:-1])
        sharp = cosine < self._spline.least_cosine
        marks[:-1] |= sharp
        marks[1:] |= sharp
        marks[0] |= self._sharp
        return marks | (length > self._spline.longest_factor * self._medians(length)), sharp

    def _medians(self, length: Floats) -> Floats:
        """The median length of up to five legs before each (k,), infinite for the first one."""
        before = np.concatenate([np.full(BEFORE - len(self._lengths), np.nan), self._lengths, length[:-1]])
        windows = np.lib.stride_tricks.sliding_window_view(before, BEFORE)
        medians: Floats = np.median(windows, axis=1)
        for i in np.flatnonzero(np.isnan(medians)).tolist():  # the beginning
            there = windows[i][~np.isnan(windows[i])]
            medians[i] = np.median(there) if len(there) else np.inf
        return medians

    def _handed_on(self, legs: Legs, marks: Flags, ahead: Floats, line: Floats | None) -> Iterator[Block]:
        """Legs as lines and curves; `ahead` (0…2, n): places behind the last leg, `line`: direction of a prismatic leg there."""
        points, k = legs.array(), len(legs)
        nothing = points[:0]
        borders = [0, *(np.flatnonzero(marks[1:] != marks[:-1]) + 1).tolist(), k]
        rest, behind, before = legs, self._behind, self._line
        for begin, end in pairwise(borders):
            part, rest = rest.split(end - begin)
            if marks[begin]:
                yield from straight_legs(part)
                before = _direction(points[end] - points[end - 1])
                behind = None
                continue
            last = end == k
            stop = line if last else _direction(points[end + 1] - points[end])
            made = akima(
                points[begin : end + 1], nothing if behind is None else behind, ahead if last else nothing, before, stop
            )
            yield from handed_on(part, made, np.arange(end - begin))
            before, behind = None, points[max(begin, end - 2) : end]
        self._line, self._behind = before, behind
        way = np.diff(points[:, :MAIN_AXES], axis=0)
        self._lengths = [*self._lengths, *np.sqrt((way**2).sum(axis=1)).tolist()][-BEFORE:]


def _direction(way: Floats) -> Floats:
    """The tangent of a leg, per mm of the main axes."""
    made: Floats = way / np.linalg.norm(way[:MAIN_AXES])
    return made
