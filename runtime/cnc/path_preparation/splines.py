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
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    ContourChange,
    Contouring,
    ExactStop,
    Floats,
    Flush,
    Hold,
    JoinedBy,
    Line,
    Polyline,
    Polynomials,
    Source,
    Spline,
    SplineChange,
    SplineKind,
    Stop,
    Tangent,
)
from runtime.cnc.geometry.bsplines import CERTAIN, spans, steered
from runtime.cnc.geometry.contour_curves import ELEMENT, element_at
from runtime.cnc.geometry.polynomial_table import TERMS
from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.cnc.path_preparation.akima import akima
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.interpolating import InterpolatingCurve
from runtime.cnc.path_preparation.legs import (
    MERGE_SHARE,
    Legs,
    handed_on,
    merged_legs,
    straight_legs,
    straightened,
)
from runtime.cnc.path_preparation.motion_pieces import NO_LENGTH, Motion, Origin, moves
from runtime.cnc.path_preparation.surface import as_chords, exact_arc, faired_legs
from runtime.diagnostics.catalogue.smoothing import SPLINE_POINTS
from runtime.diagnostics.errors import Place

WINDOW = 1024  # legs
CUT = 16  # of the last legs of a window the longest one is cut
CONTEXT = 3  # legs that an Akima spline looks ahead and back
BACK = math.radians(179.0)  # a turn beyond it is the way back
_LEAST = {
    SplineKind.AKIMA: 3,
    SplineKind.BSPLINE: 4,
    SplineKind.HSC: 2,
    SplineKind.SURFACE: 2,
    SplineKind.INTERPOLATING: 2,
}


class SplineStage:
    """The stage; a new one for each program. Raises PathError for a spline with too few points."""

    def __init__(self) -> None:
        self._spline: Spline | None = None
        self._legs = Legs()
        self._behind: Floats = np.zeros((0, 0))  # places that an Akima spline has passed, before the first leg
        self._tangent: Floats | None = None  # of the arc or line before the curve
        self._points = 0  # of the curve that the program has selected
        self._curve: InterpolatingCurve | None = None
        self._behind_arc = False  # the curve begins at an arc, or what else interrupts it, that it is joined to
        self._delayed = False  # the next motion is none of the curve
        self._contouring: ContourChange | None = None  # what the program has selected last
        self._ending = False  # it is deselected, and waits for the direction of the next motion

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            if isinstance(block, ContourChange) and not block.once:
                self._contouring = block
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
            elif isinstance(block, Arc) and not self._delayed and _takes_arcs(self._spline):
                yield from self._arc(self._spline, block)
            elif isinstance(block, Arc | Hold | Flush | ExactStop | Stop | Polynomials):
                if self._ending:
                    yield from self._deselect(None)
                tangent = _direction(block, at_end=False) if isinstance(block, Arc) else None
                yield from self._finish(tangent)
                if isinstance(block, Arc):
                    self._tangent, self._delayed = _direction(block, at_end=True), False
                yield block
            elif len(self._legs):
                self._legs.actions.setdefault(len(self._legs), []).append(block)
            else:
                yield block
        yield from self._finish(None)

    def _arc(self, spline: Spline, arc: Arc) -> Iterator[Block]:
        """An arc is joined to the curve; under #HSC [SURFACE] a small one becomes part of it."""
        if spline.kind is SplineKind.SURFACE:
            chords = None if exact_arc(arc, spline) else as_chords(arc, spline)
            if chords is not None:
                yield from self._straight(chords)
                return
            if not spline.arcs:
                yield from self._finish(None)
                yield arc
                return
        yield from self._joined(spline, arc.source, arc)

    def _joined(self, spline: Spline, source: Source, motion: Motion | None) -> Iterator[Block]:
        """The curve ends, and begins anew behind a motion, or at a corner; curves of contouring lead from one to the other."""
        tracking = 0.0 if spline.kind is SplineKind.SURFACE else spline.tracking_deviation
        settings = Contouring(deviation=spline.deviation, tracking_deviation=tracking, check_jerk=spline.check_jerk)
        yield ContourChange(source, settings, keeps=True)
        yield from self._finish(None, into_arc=True)
        if motion is not None:
            yield motion
        before = self._contouring
        yield ContourChange(source, None if before is None else before.contouring, keeps=True)
        self._behind_arc = True

    def _change(self, change: SplineChange) -> Iterator[Block]:
        if self._spline is not None and change.spline is None:
            self._expect_points(self._spline, change)
            if self._spline.kind is SplineKind.AKIMA and self._spline.end is Tangent.TANGENTIAL and len(self._legs):
                self._ending = True
                return
        yield from self._deselect(None)
        self._spline = change.spline
        self._delayed = change.spline is not None and change.spline.delayed

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
        if spline.kind in (SplineKind.HSC, SplineKind.SURFACE):
            if spline.without_rapid:
                outside |= np.isinf(run.feeds) & ~still
            if spline.longest > 0.0:
                outside |= length > spline.longest
            if spline.most_tracking < math.inf:
                outside |= (np.sqrt((ways[:, MAIN_AXES:] ** 2).sum(axis=1)) > spline.most_tracking * length) & ~still
        joined = spline.joined is JoinedBy.CURVES
        if self._delayed and not still.all():
            first = int(np.argmin(still))
            outside[first] = True
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
                motion = block if isinstance(block, Line) else single
                if joined and not self._delayed:
                    yield from self._joined(spline, origin.source, motion)
                else:
                    yield from self._finish(_direction(single, at_end=False))
                    yield motion
                self._tangent, self._delayed = _direction(single, at_end=True), False
                self._points = 0
                begin = at + 1
            elif at < len(length):
                yield from self._corner(spline, origin.source)

    def _corner(self, spline: Spline, source: Source) -> Iterator[Block]:
        """A corner that is too sharp for the curve."""
        if spline.joined is JoinedBy.CURVES:
            yield from self._joined(spline, source, None)
        else:
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
                    yield from self._corner(spline, origin.source)
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
        if spline.kind is SplineKind.INTERPOLATING:
            blocks, self._legs = self._interpolating(spline).window(self._legs)
            yield from blocks
            return
        if spline.kind is SplineKind.AKIMA:
            first, rest = self._legs.split(len(self._legs) - CONTEXT)
            ahead = np.array(rest.points[1:])[:2]
            start = self._start(spline) if not len(self._behind) else None
            made = akima(first.array(), self._behind_of(first), ahead, start, None)
            yield from handed_on(first, made, np.arange(len(first)))
            self._behind = np.array(first.points[-3:-1])
            self._legs = rest
            return
        points = self._legs.array()
        way = np.linalg.norm(np.diff(points[-CUT - 1 :], axis=0)[:, :MAIN_AXES], axis=1)
        first, rest = self._legs.cut(len(self._legs) - CUT + int(np.argmax(way)))
        yield from self._between_arcs(spline, first, False)
        self._legs = rest

    def _finish(self, tangent: Floats | None, into_arc: bool = False) -> Iterator[Block]:
        """The curve ends at the last target; `tangent`: of the motion behind it, an arc to which it is joined or not."""
        legs, self._legs = self._legs, Legs()
        spline = self._spline
        if len(legs) and spline is not None:
            if spline.kind is SplineKind.AKIMA:
                start = self._start(spline) if not len(self._behind) else None
                end = _given(spline.end, spline.end_vector, tangent)
                nothing = np.zeros((0, legs.array().shape[1]))
                made = akima(legs.array(), self._behind_of(legs), nothing, start, end)
                yield from handed_on(legs, made, np.arange(len(legs)))
            elif spline.kind is SplineKind.INTERPOLATING:
                yield from self._interpolating(spline).finish(legs)
            else:
                yield from self._between_arcs(spline, legs, into_arc)
            self._tangent = None
        self._behind, self._behind_arc, self._curve = np.zeros((0, 0)), False, None

    def _interpolating(self, spline: Spline) -> InterpolatingCurve:
        if self._curve is None:
            self._curve = InterpolatingCurve(spline)
        return self._curve

    def _between_arcs(self, spline: Spline, legs: Legs, into_arc: bool) -> Iterator[Block]:
        """The curve; at an arc half a leg stays straight, so that contouring finds a line there."""
        if (self._behind_arc or into_arc) and len(legs) == 1:
            yield from straight_legs(legs)
            return
        if self._behind_arc:
            first, legs = legs.cut(0)
            yield from straight_legs(first)
            self._behind_arc = False
        last = None
        if into_arc:
            legs, last = legs.cut(len(legs) - 1)
        if len(legs) > 0:
            yield from self._bspline(spline, legs)
        if last is not None:
            yield from straight_legs(last)

    def _behind_of(self, legs: Legs) -> Floats:
        return self._behind if len(self._behind) else np.zeros((0, len(legs.points[0])))

    def _start(self, spline: Spline) -> Floats | None:
        return _given(spline.start, spline.start_vector, self._tangent)

    def _bspline(self, spline: Spline, legs: Legs) -> Iterator[Block]:
        """The curve over legs, within its tolerances."""
        if spline.kind is SplineKind.SURFACE:
            legs, tolerance, tracking = faired_legs(spline, legs)
        else:
            if spline.merge:
                legs = merged_legs(spline, legs)
            share = 1.0 - MERGE_SHARE if spline.merge else 1.0
            m = len(legs) + 1
            tolerance, tracking = np.full(m, spline.deviation * share), np.full(m, spline.tracking_deviation * share)
        yield from _steered(spline, legs, tolerance, tracking)


def _steered(spline: Spline, legs: Legs, tolerance: Floats, tracking: Floats) -> Iterator[Block]:
    """The B-spline over legs with tolerances at their k + 1 points, in pieces where a corner stays sharp."""
    points = legs.array()
    m, n = points.shape
    size = 3 * m + 6
    near, off, track = np.zeros(m), np.zeros(m), np.zeros(m)
    c, t = np.zeros((size, n)), np.zeros(size)
    leg = np.zeros(size, dtype=np.int64)
    count, failed = steered(points, tolerance, tracking, near, c, t, leg, off, track)
    sharp = (near > 0.0) if spline.sharp or spline.sharp_tracking else np.zeros(m, dtype=np.bool_)
    if failed > 0:
        sharp |= (tolerance > 0.0) & (off > CERTAIN * tolerance)
        sharp |= (tracking > 0.0) & (track > CERTAIN * tracking)
        sharp[failed] = True
    if sharp[1:-1].any():
        begin, rest = 0, legs
        for at in [*(np.flatnonzero(sharp[1:-1]) + 1).tolist(), m - 1]:
            part, rest = rest.split(at - begin)
            yield from _steered(spline, part, tolerance[begin : at + 1], tracking[begin : at + 1])
            begin = at
        return
    made = np.zeros((count - 1, TERMS, n))
    spans(c, t, 2, count + 1, made)
    straightened(made)
    yield from handed_on(legs, made, leg[2 : count + 1], check_jerk=spline.check_jerk != 0)


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


def _takes_arcs(spline: Spline) -> bool:
    """Arcs are part of the curve, or joined to it."""
    return spline.kind is SplineKind.SURFACE or (
        spline.kind is SplineKind.HSC and spline.joined is not JoinedBy.NOTHING
    )


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
