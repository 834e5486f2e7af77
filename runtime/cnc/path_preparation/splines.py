"""Curves over the targets of straight moves: HSC B-splines, B-splines and Akima splines (manual lines 9013–10922).

    Line, Line, [M], Polyline, Arc, Line        →        Polynomials, [M], Polynomials, Arc, Polynomials

Moves are collected as legs of a polygon until the curve ends, or a window of WINDOW legs is full; every leg becomes one
polynomial (some more near a corner to which an HSC spline is held). What stands between moves is done at the end of the leg
before it. At the border of two windows a B-spline passes the middle of a leg in its direction and without curvature, an Akima
spline knows its neighbours on both sides: so the memory is bounded and nothing shows at the border.

A curve ends, and passes its last target exactly, at arcs, exact stop, M00, #FLUSH, waiting for the outside, moves without the
main axes, moves with E or G166, turns by 180°, and where the settings say so.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    ExactStop,
    Floats,
    Flush,
    Hold,
    Line,
    Polyline,
    Polynomials,
    Spline,
    SplineChange,
    SplineKind,
    Stop,
    Tangent,
)
from runtime.cnc.geometry.bsplines import merged, spans, steered
from runtime.cnc.geometry.contour_curves import ELEMENT, element_at
from runtime.cnc.geometry.polynomials import MAIN_AXES, TERMS
from runtime.cnc.path_preparation.akima import akima
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.motion_pieces import NO_LENGTH, Motion, Origin, moves
from runtime.diagnostics.catalogue.smoothing import SPLINE_POINTS
from runtime.diagnostics.errors import Place

Ints = npt.NDArray[np.int64]

WINDOW = 1024  # legs
CUT = 16  # of the last legs of a window the longest one is cut
CONTEXT = 3  # legs that an Akima spline looks ahead and back
BACK = math.radians(179.0)  # a turn beyond it is the way back
MERGE_SHARE = 0.25  # of the tolerance, for merging
_LEAST = {SplineKind.AKIMA: 3, SplineKind.BSPLINE: 4, SplineKind.HSC: 2}


@dataclass(slots=True)
class _Legs:
    """Legs of the curve that is being collected: k + 1 places, and what belongs to each leg."""

    points: list[Floats] = field(default_factory=list)
    origins: list[Origin] = field(default_factory=list)  # one per leg, shared between the legs of a run
    feeds: list[float] = field(default_factory=list)
    lines: list[int] = field(default_factory=list)
    numbers: list[int] = field(default_factory=list)
    ends: list[bool] = field(default_factory=list)  # an NC block ends with the leg
    actions: dict[int, list[Block]] = field(default_factory=dict)  # behind so many legs

    def __len__(self) -> int:
        return len(self.feeds)

    def array(self) -> Floats:
        return np.array(self.points)

    def split(self, count: int) -> tuple[_Legs, _Legs]:
        """The first `count` legs, and the rest."""
        first = _Legs(
            self.points[: count + 1], self.origins[:count], self.feeds[:count], self.lines[:count],
            self.numbers[:count], self.ends[:count], {k: v for k, v in self.actions.items() if k <= count},
        )  # fmt: skip
        rest = _Legs(
            self.points[count:], self.origins[count:], self.feeds[count:], self.lines[count:], self.numbers[count:],
            self.ends[count:], {k - count: v for k, v in self.actions.items() if k > count},
        )  # fmt: skip
        return first, rest


class SplineStage:
    """The stage; a new one for each program. Raises PathError for a spline with too few points."""

    def __init__(self) -> None:
        self._spline: Spline | None = None
        self._legs = _Legs()
        self._behind: Floats = np.zeros((0, 0))  # places that an Akima spline has passed, before the first leg
        self._tangent: Floats | None = None  # of the arc or line before the curve
        self._points = 0  # of the curve that the program has selected
        self._ending = False  # it is deselected, and waits for the direction of the next motion

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            if self._ending and isinstance(block, Line | Arc | Polyline):
                yield from self._deselect(_direction(block, at_end=False))
            if isinstance(block, SplineChange):
                yield from self._change(block)
            elif self._spline is None:
                if isinstance(block, Line | Arc | Polyline):
                    self._tangent = _direction(block, at_end=True)
                yield block
            elif isinstance(block, Line | Polyline):
                yield from self._straight(block)
            elif isinstance(block, Arc | Hold | Flush | ExactStop | Stop | Polynomials):
                if self._ending:
                    yield from self._deselect(None)
                tangent = _direction(block, at_end=False) if isinstance(block, Arc) else None
                yield from self._finish(tangent)
                if isinstance(block, Arc):
                    self._tangent = _direction(block, at_end=True)
                yield block
            elif len(self._legs):
                self._legs.actions.setdefault(len(self._legs), []).append(block)
            else:
                yield block
        yield from self._finish(None)

    def _change(self, change: SplineChange) -> Iterator[Block]:
        if self._spline is not None and change.spline is None:
            self._expect_points(self._spline, change)
            if self._spline.kind is SplineKind.AKIMA and self._spline.end is Tangent.TANGENTIAL and len(self._legs):
                self._ending = True
                return
        yield from self._deselect(None)
        self._spline = change.spline

    def _deselect(self, tangent: Floats | None) -> Iterator[Block]:
        yield from self._finish(tangent)
        self._spline, self._points, self._ending = None, 0, False

    def _expect_points(self, spline: Spline, change: SplineChange) -> None:
        """PathError for too few vertices; with all tangents given an Akima spline needs two."""
        least = _LEAST[spline.kind]
        if spline.kind is SplineKind.AKIMA and Tangent.AUTO not in (spline.start, spline.end):
            least = 2
        if 0 < self._points < least:
            place = Place(change.source.program, change.source.line)
            raise PathError(SPLINE_POINTS, place, points=self._points, least=least, kind=spline.kind.value)

    # ------------------------------------------------------------------ collecting

    def _straight(self, block: Line | Polyline) -> Iterator[Block]:
        """Legs for the curve, stretch by stretch: a move that is none of it ends it, a sharp corner begins a new one."""
        spline = self._spline
        assert spline is not None
        run, origin = _as_run(block), Origin.of(block)
        own_ends = isinstance(block, Polyline) and not block.one_block
        ways = np.diff(run.points, axis=0)
        length = np.sqrt((ways[:, :MAIN_AXES] ** 2).sum(axis=1))
        still = np.abs(ways).max(axis=1) <= NO_LENGTH
        outside = (length <= NO_LENGTH) & ~still
        if isinstance(block, Line) and (block.end_feed is not None or block.override_off):
            outside |= ~still
        if spline.kind is SplineKind.HSC:
            if spline.without_rapid:
                outside |= np.isinf(run.feeds) & ~still
            if spline.longest > 0.0:
                outside |= length > spline.longest
        sharp = np.zeros(len(length), dtype=np.bool_)
        sharp[1:] = _turns(ways[:-1], ways[1:]) > _sharpest(spline)
        breaks = np.flatnonzero(still | outside | sharp)
        begin = 0
        for at in [*breaks.tolist(), len(length)]:
            yield from self._stretch(spline, run, begin, at, origin, own_ends)
            begin = at
            if at < len(length) and still[at]:
                self._without_way(run, at, own_ends)
                begin = at + 1
            elif at < len(length) and outside[at]:
                single = moves(run, at, at + 1)
                yield from self._finish(_direction(single, at_end=False))
                self._tangent = _direction(single, at_end=True)
                yield block if isinstance(block, Line) else single
                self._points = 0
                begin = at + 1
            elif at < len(length):
                yield from self._finish(None)

    def _without_way(self, run: Polyline, i: int, own_ends: bool) -> None:
        """A move of no length is no vertex; the end of its NC block stays."""
        if own_ends and len(self._legs):
            number = int(run.numbers[i])
            source = replace(Origin.of(run).source, line=int(run.lines[i]), n=None if number < 0 else number)
            self._legs.actions.setdefault(len(self._legs), []).append(BlockEnd(source))

    def _stretch(
        self, spline: Spline, run: Polyline, begin: int, end: int, origin: Origin, own_ends: bool
    ) -> Iterator[Block]:
        """The moves `begin` to before `end` as legs."""
        while begin < end:
            legs = self._legs
            if legs.points:
                way, before = run.points[begin + 1] - run.points[begin], legs.points[-1] - legs.points[-2]
                if _turns(before[None], way[None])[0] > _sharpest(spline):
                    yield from self._finish(None)
                    legs = self._legs
            if not legs.points:
                legs.points.append(run.points[begin])
                self._points += self._points == 0
            stop = min(end, begin + WINDOW - len(legs))
            legs.points.extend(run.points[begin + 1 : stop + 1])
            legs.origins.extend([origin] * (stop - begin))
            legs.feeds.extend(run.feeds[begin:stop].tolist())
            legs.lines.extend(run.lines[begin:stop].tolist())
            legs.numbers.extend(run.numbers[begin:stop].tolist())
            legs.ends.extend([own_ends] * (stop - begin))
            self._points += stop - begin
            begin = stop
            if len(legs) >= WINDOW:
                yield from self._window(spline)

    # ------------------------------------------------------------------ curves

    def _window(self, spline: Spline) -> Iterator[Block]:
        """Hand on most of what was collected."""
        if spline.kind is SplineKind.AKIMA:
            first, rest = self._legs.split(len(self._legs) - CONTEXT)
            ahead = np.array(rest.points[1:])[:2]
            start = self._start(spline) if not len(self._behind) else None
            made = akima(first.array(), self._behind_of(first), ahead, start, None)
            yield from _handed_on(first, made, np.arange(len(first)))
            self._behind = np.array(first.points[-3:-1])
            self._legs = rest
            return
        points = self._legs.array()
        way = np.linalg.norm(np.diff(points[-CUT - 1 :], axis=0)[:, :MAIN_AXES], axis=1)
        at = len(self._legs) - CUT + int(np.argmax(way))
        first, rest = self._legs.split(at + 1)
        first.points[-1] = rest_start = 0.5 * (points[at] + points[at + 1])
        first.ends[-1] = False
        behind = first.actions.pop(at + 1, [])
        half = _Legs(
            [rest_start, points[at + 1]], self._legs.origins[at : at + 1], self._legs.feeds[at : at + 1],
            self._legs.lines[at : at + 1], self._legs.numbers[at : at + 1], self._legs.ends[at : at + 1],
        )  # fmt: skip
        yield from self._bspline(spline, first)
        half.points += rest.points[1:]
        half.origins += rest.origins
        half.feeds += rest.feeds
        half.lines += rest.lines
        half.numbers += rest.numbers
        half.ends += rest.ends
        half.actions = {k + 1: v for k, v in rest.actions.items()}
        if behind:
            half.actions[1] = behind + half.actions.get(1, [])
        self._legs = half

    def _finish(self, tangent: Floats | None) -> Iterator[Block]:
        """The curve ends at the last target; `tangent`: of the motion behind it."""
        legs, self._legs = self._legs, _Legs()
        spline = self._spline
        if len(legs) and spline is not None:
            if spline.kind is SplineKind.AKIMA:
                start = self._start(spline) if not len(self._behind) else None
                end = _given(spline.end, spline.end_vector, tangent)
                nothing = np.zeros((0, legs.array().shape[1]))
                made = akima(legs.array(), self._behind_of(legs), nothing, start, end)
                yield from _handed_on(legs, made, np.arange(len(legs)))
            else:
                yield from self._bspline(spline, legs)
            self._tangent = None
        self._behind = np.zeros((0, 0))

    def _behind_of(self, legs: _Legs) -> Floats:
        return self._behind if len(self._behind) else np.zeros((0, len(legs.points[0])))

    def _start(self, spline: Spline) -> Floats | None:
        return _given(spline.start, spline.start_vector, self._tangent)

    def _bspline(self, spline: Spline, legs: _Legs) -> Iterator[Block]:
        """The curve over legs, in pieces where a corner stays sharp."""
        if spline.merge:
            legs = _merged(spline, legs)
        share = 1.0 - MERGE_SHARE if spline.merge else 1.0
        tolerance, tracking = spline.deviation * share, spline.tracking_deviation * share
        points = legs.array()
        m, n = points.shape
        size = 3 * m + 6
        near, off, track = np.zeros(m), np.zeros(m), np.zeros(m)
        c, t = np.zeros((size, n)), np.zeros(size)
        leg = np.zeros(size, dtype=np.int64)
        count, failed = steered(points, tolerance, tracking, near, c, t, leg, off, track)
        sharp = set(np.flatnonzero(near > 0.0).tolist()) if spline.sharp or spline.sharp_tracking else set()
        if failed > 0:
            sharp.add(failed)
        if sharp:
            at_leg = min(sharp)
            first, rest = legs.split(at_leg)
            yield from self._bspline(spline, first)
            yield from self._bspline(
                replace(spline, merge=False, deviation=tolerance, tracking_deviation=tracking), rest
            )
            return
        made = np.zeros((count - 1, TERMS, n))
        spans(c, t, 2, count + 1, made)
        _straightened(made)
        yield from _handed_on(legs, made, leg[2 : count + 1])


def _handed_on(legs: _Legs, made: Floats, leg: Ints) -> Iterator[Block]:
    """Polynomials (k, 6, n) of legs, `leg` (k,) which one; cut where something is to be done, or the offsets change."""
    last = np.append(leg[1:] != leg[:-1], True)
    for count, actions in list(legs.actions.items()):  # the end of a block needs no place of its own
        if isinstance(actions[0], BlockEnd) and not legs.ends[count - 1]:
            legs.ends[count - 1] = True
            legs.actions[count] = actions[1:]
            if not actions[1:]:
                del legs.actions[count]
    cuts = {count for count in legs.actions if count > 0}
    cuts |= {i for i in range(1, len(legs)) if not _alike(legs.origins[i - 1], legs.origins[i])}
    borders = [0, *sorted(cut for cut in cuts if cut < len(legs)), len(legs)]
    feeds, lines, numbers = np.array(legs.feeds), np.array(legs.lines), np.array(legs.numbers)
    ends = np.array(legs.ends)
    for begin, end in pairwise(borders):
        actions = legs.actions.get(end, [])
        there = slice(int(np.searchsorted(leg, begin)), int(np.searchsorted(leg, end)))
        origin, mine = legs.origins[begin], leg[there]
        block_ends = last[there] & ends[mine]
        yield replace(
            origin.polynomials(made[there]),
            feeds=feeds[mine],
            lines=lines[mine],
            numbers=numbers[mine],
            block_ends=block_ends,
        )
        yield from actions


def _alike(first: Origin, second: Origin) -> bool:
    """Whether elements of both can share a run."""
    if first is second:
        return True
    one, two = first.pcs_gain, second.pcs_gain
    same = one is two or (one is not None and two is not None and np.array_equal(one, two))
    return bool(same and first.program == second.program and np.array_equal(first.pcs_shift, second.pcs_shift))


def _straightened(made: Floats) -> None:
    """Straight spans (k, 6, n) get a parameter that runs evenly: on a long leg between close points it hardly moves at first."""
    way = made[:, 1:].sum(axis=1)
    square = (way**2).sum(axis=1)
    safe = np.where(square > 0.0, square, 1.0)
    away = np.zeros(len(made))
    for power in (1, 2, 3):
        along = (made[:, power] * way).sum(axis=1) / safe
        away = np.maximum(away, np.abs(made[:, power] - along[:, None] * way).max(axis=1))
    straight = (square > 0.0) & (away <= 1e-12 * np.sqrt(safe))
    made[straight, 1], made[straight, 2:] = way[straight], 0.0


def _merged(spline: Spline, legs: _Legs) -> _Legs:
    """Legs of which several have become one, where nothing is to be done between them."""
    points = legs.array()
    kept = np.zeros(len(points), dtype=np.bool_)
    borders = sorted({0, len(legs), *(k for k in legs.actions if 0 < k < len(legs))})
    borders = sorted({*borders, *(i for i in range(1, len(legs)) if legs.origins[i] is not legs.origins[i - 1])})
    for begin, end in pairwise(borders):
        part = np.zeros(end - begin + 1, dtype=np.bool_)
        merged(
            points[begin : end + 1],
            spline.deviation * MERGE_SHARE,
            spline.tracking_deviation * MERGE_SHARE if spline.tracking_deviation > 0.0 else math.inf,
            part,
        )
        kept[begin : end + 1] |= part
    places = np.flatnonzero(kept)
    chosen = places[1:] - 1  # the leg that ends at a kept place stands for those before it
    number = {int(place): i for i, place in enumerate(places)}
    return _Legs(
        [legs.points[i] for i in places],
        [legs.origins[i] for i in chosen],
        [min(legs.feeds[a:b]) for a, b in pairwise(places)],
        [legs.lines[i] for i in chosen],
        [legs.numbers[i] for i in chosen],
        [legs.ends[i] for i in chosen],
        {number[k]: v for k, v in legs.actions.items()},
    )


def _given(kind: Tangent, vector: tuple[float, ...] | None, neighbour: Floats | None) -> Floats | None:
    """The tangent at an end per mm of the main axes, NaN for axes without one; None: the points decide."""
    if kind is Tangent.TANGENTIAL:
        return neighbour
    if kind is Tangent.USER and vector is not None:
        given = np.array(vector)
        length = float(np.linalg.norm(given[:MAIN_AXES]))
        if length > 0.0:
            given[:MAIN_AXES] /= length
            return given
    return None


def _as_run(block: Line | Polyline) -> Polyline:
    if isinstance(block, Polyline):
        return block
    origin = Origin.of(block)
    return Polyline(
        origin.program, np.vstack([block.start, block.end]), np.array([origin.feed]), np.array([origin.line]),
        np.array([origin.number]), origin.pcs_shift, origin.pcs_gain, origin.plane, one_block=True,
    )  # fmt: skip


def _turns(first: Floats, second: Floats) -> Floats:
    """Change of direction (k,) between ways (k, n) in the main axes, radians."""
    one, two = first[:, :MAIN_AXES], second[:, :MAIN_AXES]
    product = (one * two).sum(axis=1)
    square = (one * one).sum(axis=1) * (two * two).sum(axis=1) - product * product
    turns: Floats = np.arctan2(np.sqrt(np.maximum(square, 0.0)), product)
    return turns


def _sharpest(spline: Spline) -> float:
    return min(math.radians(spline.greatest_angle), BACK)


def _direction(motion: Motion, *, at_end: bool) -> Floats | None:
    """Derivative of all axes by the way of the main axes at the start or end of a motion; None if these rest."""
    if isinstance(motion, Arc):
        n = len(motion.start)
        element = np.zeros(1, dtype=ELEMENT)
        first, second = motion.plane
        way = motion.end - motion.start
        way[first] = way[second] = 0.0
        angle = math.radians(motion.angle)
        length = math.hypot(motion.radius * angle, float(np.linalg.norm(way[:MAIN_AXES])))
        if length <= NO_LENGTH:
            return None
        element["kind"], element["length"], element["angle"] = 1, length, angle
        element["start"][0, :n], element["end"][0, :n] = motion.start, motion.end
        element["axis0"], element["axis1"] = first, second
        element["centre0"], element["centre1"] = motion.centre
        q, dq, ddq = np.zeros(n), np.zeros(n), np.zeros(n)
        element_at(element[0], length if at_end else 0.0, n, q, dq, ddq)
        return dq
    points = motion.points if isinstance(motion, Polyline) else np.vstack([motion.start, motion.end])
    way = points[-1] - points[-2] if at_end else points[1] - points[0]
    length = float(np.linalg.norm(way[:MAIN_AXES]))
    return way / length if length > NO_LENGTH else None
