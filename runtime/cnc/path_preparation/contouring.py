"""Contouring (G61, G261, #CONTOUR MODE; programming manual 9569–10580): a corner becomes a curve between shortened blocks.

    Line, [M, BlockEnd], Line        →        Line', Polynomials, [M, BlockEnd], Polynomials, Line'

The last motion is held back until the next one is known. What stands between them is done where the settings say: before,
within or behind the curve. Corners don't know of each other, as each takes at most half of a block; so a run of short lines
is one call of a kernel and stays arrays.

A corner is passed exactly where no curve can be: exact stop, M00, #FLUSH or waiting for the outside between the blocks, no
motion of the main axes, arcs whose radius is not constant, curves that other stages have made.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field, replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import (
    Arc,
    AxisLimitChange,
    Block,
    BlockEnd,
    ContourAction,
    ContourChange,
    Contouring,
    ContourMethod,
    ExactStop,
    Floats,
    Flush,
    Hold,
    Line,
    Polyline,
    Polynomials,
    Stop,
    StopKind,
    programmed_way,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.contour_curves import (
    ARC,
    BY_DEVIATION,
    BY_DISTANCE,
    ELEMENT,
    LINE,
    PIECES,
    SETTINGS,
    SOFT,
    THROUGH_POINT,
    WHOLE,
    corner_curves,
)
from runtime.cnc.geometry.polynomial_table import TERMS
from runtime.cnc.geometry.polynomials import MAIN_AXES
from runtime.cnc.path_preparation.motion_pieces import (
    NO_LENGTH,
    Motion,
    Origin,
    interleaved,
    joined,
    moves,
    shortened,
    without_empty,
)
from runtime.diagnostics.catalogue.motion import CONTOUR_AT_END
from runtime.diagnostics.errors import Place, Problem

Elements = npt.NDArray[np.void]
Counts = npt.NDArray[np.int64]

RADIUS_ERROR = 1e-4  # mm: an arc whose radius changes more is no circle
LEAST_RELEVANT = 0.032  # mm (line 9672)
SHORT = 0.016  # mm (line 9707): a block below it is replaced by a line that begins where the skipped ones do

_METHODS = {
    ContourMethod.DEVIATION: BY_DEVIATION,
    ContourMethod.DISTANCE: BY_DISTANCE,
    ContourMethod.SOFT: SOFT,
    ContourMethod.POINT: THROUGH_POINT,
    ContourMethod.WHOLE: WHOLE,
}
_ENDS = {ContourAction.BEFORE: "before", ContourAction.WITHIN: "within", ContourAction.BEHIND: "behind"}


@dataclass(slots=True)
class _Held:
    """The motion that waits for the next one, `taken` mm of its start gone already, and what came behind it."""

    motion: Motion
    element: np.void
    contouring: Contouring
    taken: float
    once: bool
    between: list[Block] = field(default_factory=list)
    skipped: list[Motion] = field(default_factory=list)  # short blocks, also in `between`


class ContouringStage:
    """The stage; a new one for each program. `limits` of the axes are for the dynamically optimised curves."""

    def __init__(self, limits: AxisLimits) -> None:
        self.warnings: list[Problem] = []
        self._limits = limits
        self._modal: Contouring | None = None
        self._once: ContourChange | None = None
        self._held: _Held | None = None

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            if isinstance(block, Line | Arc | Polyline):
                yield from self._motion(block)
            elif isinstance(block, ContourChange):
                yield from self._change(block)
            elif isinstance(block, Hold | Flush | ExactStop | Polynomials | Stop):
                if isinstance(block, Stop) and block.kind is StopKind.PROGRAM_END:
                    self._at_end()
                yield from self._release()
                yield block
            else:
                if isinstance(block, AxisLimitChange):
                    self._limits = block.limits
                if self._held is not None:
                    self._held.between.append(block)
                else:
                    yield block
        yield from self._release()

    # ------------------------------------------------------------------ settings

    def _change(self, change: ContourChange) -> Iterator[Block]:
        if change.once:
            self._once = change
            return
        self._modal = change.contouring
        if change.contouring is None and not change.keeps and self._held is not None and not self._held.once:
            yield from self._release()

    def _settings(self, motion: Motion) -> tuple[Contouring | None, bool]:
        """The settings of the corner at the end of a motion, and whether they are those of G61."""
        if self._once is not None:
            origin, asked = Origin.of(motion), self._once.source
            if (asked.line, asked.program) == (origin.line, origin.program):
                return self._once.contouring, True
            self._once = None
        return self._modal, False

    # ------------------------------------------------------------------ motion

    def _motion(self, block: Motion) -> Iterator[Block]:
        contouring, once = self._settings(block)
        if contouring is None and self._held is None:
            yield block
        elif not isinstance(block, Polyline):
            yield from self._one(block, self._element(block), contouring, once)
        else:
            run = without_empty(block)
            yield from self._run(run, self._elements(run), contouring, once)

    def _run(self, run: Polyline, elements: Elements, contouring: Contouring | None, once: bool) -> Iterator[Block]:
        """A run of lines: its corners are contoured together, as far as each is for itself."""
        k = len(elements)
        apart = contouring is not None and (
            contouring.relevant > 0.0 or contouring.relevant_tracking > 0.0 or contouring.constant_velocity
        )
        if k == 1 or (apart and not run.one_block):
            for i in range(k):
                yield from self._one(moves(run, i, i + 1), elements[i], contouring, once)
            return
        if contouring is None or run.one_block:  # of a curve only the ends are corners
            yield from self._one(moves(run, 0, 1), elements[0], None, once)
            yield from self._release()
            last = k if contouring is None else k - 1
            if last > 1:
                yield moves(run, 1, last)
            if last < k:
                yield from self._one(moves(run, k - 1, k), elements[k - 1], contouring, once)
            return
        yield from self._one(moves(run, 0, 1), elements[0], contouring, once)
        held, self._held = self._held, None
        begin, taken = (1, 0.0) if held is None else (0, held.taken)
        run, elements = moves(run, begin, k), elements[begin:]
        count, trims, curves = self._curves(contouring, elements)
        last = len(elements) - 1
        if last and taken == 0.0 and not count.any():
            yield moves(run, 0, last)
        elif last:
            made = interleaved(run, elements["length"][:-1], count, trims, curves, taken, _ENDS[contouring.action])
            yield replace(made, check_jerk=contouring.check_jerk != 0)
        if last:
            taken = float(trims[-1, 1])
        yield from self._hold(moves(run, last, last + 1), elements[last], contouring, taken, once)

    def _one(self, motion: Motion, element: np.void, contouring: Contouring | None, once: bool) -> Iterator[Block]:
        """A single element: first the corner before it, then it waits itself."""
        taken = 0.0
        if self._held is not None:
            if not element["length"] > 0.0 and _no_way(motion):
                self._held.between.extend(_block_end(motion))
                return
            if self._skips(self._held, element):
                self._held.between += [motion, *_block_end(motion)]
                self._held.skipped.append(motion)
                return
            if self._held.skipped and element["length"] < SHORT:
                motion = _line_to(self._held, motion)
                element = self._element(motion)
            count, trims, curves = self._curves(self._held.contouring, np.stack([self._held.element, element]))
            if count[0]:
                yield from self._corner(self._held, motion, float(trims[0, 0]), curves[0, : count[0]])
                taken, self._held = float(trims[0, 1]), None
        yield from self._release()
        yield from self._hold(motion, element, contouring, taken, once)

    def _hold(
        self, motion: Motion, element: np.void, contouring: Contouring | None, taken: float, once: bool
    ) -> Iterator[Block]:
        """Keep a motion for the corner at its end; where there is none it goes on at once."""
        if contouring is None or not element["length"] > 0.0:
            rest = shortened(motion, taken, 0.0, float(element["length"]))
            if rest is not None:
                yield rest
            return
        self._held = _Held(motion, element, contouring, taken, once)

    def _corner(self, held: _Held, motion: Motion, trim: float, curves: Floats) -> Iterator[Block]:
        """The shortened motion, the curve, and what stood between at its place."""
        settings, action, origin = held.contouring, held.contouring.action, Origin.of(held.motion)
        line = shortened(held.motion, held.taken, trim, float(held.element["length"]))
        skipped = {id(block) for block in held.skipped}
        between = [*_block_end(held.motion), *(block for block in held.between if id(block) not in skipped)]
        if line is not None:
            yield replace(line, one_block=True) if isinstance(line, Polyline) else line
        middle = len(curves) // 2
        first = replace(origin.polynomials(curves[:middle]), end_feed=origin.end_feed)
        second = Origin.of(motion).polynomials(curves[middle:])

        def marked(curve: Polynomials) -> Polynomials:
            checked = settings.check_jerk != 0
            return replace(curve, constant_velocity=settings.constant_velocity, check_jerk=checked)

        whole = joined(first, second) if action is not ContourAction.WITHIN or _only_an_end(between) else None
        if action is ContourAction.BEFORE:
            yield from between
        if whole is not None:
            if action is ContourAction.WITHIN and between:
                whole.block_ends[middle - 1] = True
            yield marked(whole)
        else:
            yield marked(first)
            if action is ContourAction.WITHIN:
                yield from between
            yield marked(second)
        if action is ContourAction.BEHIND:
            yield from between

    def _skips(self, held: _Held, element: np.void) -> bool:
        """The block is too short to be a partner, and the path is still near the end of the last one that was not."""
        settings, n = held.contouring, self._limits.n
        if settings.relevant <= 0.0 and settings.relevant_tracking <= 0.0:
            return False
        least = max(settings.relevant, LEAST_RELEVANT)
        way = element["end"][:n] - element["start"][:n]
        away = element["end"][:n] - held.element["end"][:n]
        return bool(
            float(np.linalg.norm(way[:MAIN_AXES])) < least
            and float(np.linalg.norm(away[:MAIN_AXES])) < least
            and (np.abs(way[MAIN_AXES:]) <= settings.relevant_tracking).all()
            and (np.abs(away[MAIN_AXES:]) <= settings.relevant_tracking).all()
        )

    def _release(self) -> Iterator[Block]:
        """Hand on what is held, up to its programmed end."""
        held, self._held = self._held, None
        if held is not None:
            rest = shortened(held.motion, held.taken, 0.0, float(held.element["length"]))
            if rest is not None:
                yield rest
            yield from held.between

    def _at_end(self) -> None:
        """The program ends: a corner that was asked for by G61 never came."""
        if self._held is not None and self._held.once:
            origin = Origin.of(self._held.motion)
            self.warnings.append(Problem(CONTOUR_AT_END, {}, Place(origin.program, origin.line)))

    # ------------------------------------------------------------------ numbers for the kernel

    def _curves(self, contouring: Contouring, elements: Elements) -> tuple[Counts, Floats, Floats]:
        """Count of polynomials, shortenings (m - 1, 2) and polynomials of the corners between m elements."""
        corners, limits = len(elements) - 1, self._limits
        count = np.zeros(corners, dtype=np.int64)
        trims, curves = np.zeros((corners, 2)), np.zeros((corners, PIECES, TERMS, limits.n))
        settings = _settings_of(contouring, elements[0])
        corner_curves(
            elements, settings, limits.velocity, limits.least_acceleration, limits.least_jerk, count, trims, curves
        )
        return count, trims, curves

    def _elements(self, run: Polyline) -> Elements:
        made, n = np.zeros(len(run.feeds), dtype=ELEMENT), self._limits.n
        made["start"][:, :n], made["end"][:, :n] = run.points[:-1], run.points[1:]
        made["feed"] = run.feeds / 60.0
        made["length"] = _main_length(np.diff(run.points, axis=0))
        return made

    def _element(self, motion: Motion) -> np.void:
        if isinstance(motion, Polyline):
            return _first(self._elements(motion))
        made, n = np.zeros(1, dtype=ELEMENT), self._limits.n
        made["start"][0, :n], made["end"][0, :n] = motion.start, motion.end
        made["feed"] = math.inf if isinstance(motion, Line) and motion.rapid else motion.feed / 60.0
        way = motion.end - motion.start
        if isinstance(motion, Line):
            made["kind"], made["length"] = LINE, _main_length(way[None])
            return _first(made)
        first, second = motion.plane
        radius = math.hypot(motion.start[first] - motion.centre[0], motion.start[second] - motion.centre[1])
        at_end = math.hypot(motion.end[first] - motion.centre[0], motion.end[second] - motion.centre[1])
        angle = math.radians(motion.angle)
        way[first] = way[second] = 0.0
        made["kind"], made["axis0"], made["axis1"] = ARC, first, second
        made["centre0"], made["centre1"] = motion.centre
        made["radius"], made["angle"] = radius, angle
        if abs(at_end - radius) <= RADIUS_ERROR and radius * abs(angle) > NO_LENGTH:
            made["length"] = math.hypot(radius * angle, float(np.linalg.norm(way[:MAIN_AXES])))
        return _first(made)


def _first(elements: Elements) -> np.void:
    first: np.void = elements[0]
    return first


def _settings_of(contouring: Contouring, pre: np.void) -> Elements:
    made = np.zeros(1, dtype=SETTINGS)
    soft = contouring.method is ContourMethod.SOFT
    whole = contouring.method is ContourMethod.WHOLE
    made["method"], made["deviation"] = (
        _METHODS[contouring.method],
        contouring.whole_deviation if whole else contouring.deviation,
    )
    made["before"] = contouring.whole_distance if whole else contouring.before
    made["behind"] = contouring.before if soft else contouring.behind
    made["tracking"] = contouring.tracking_distance if soft else contouring.tracking_deviation
    made["share"], made["angle"] = (1.0 - contouring.remain) / 2.0, math.radians(contouring.greatest_angle)
    made["least"], made["most"] = contouring.least_acceleration, contouring.greatest_acceleration
    made["ramp"] = contouring.ramp_time
    for axis, place in enumerate(contouring.point):
        made["point"][0, axis] = pre["end"][axis] if place is None else place
    return made


def _main_length(way: Floats) -> Floats:
    """Lengths (k,) of ways (k, n) along the main axes; 0 where others move so much more that these are not the path."""
    main = np.sqrt((way[:, :MAIN_AXES] ** 2).sum(axis=1))
    others = np.sqrt((way[:, MAIN_AXES:] ** 2).sum(axis=1))
    length: Floats = np.where((main > NO_LENGTH) & (main > 1e-6 * others), main, 0.0)
    return length


def _no_way(motion: Motion) -> bool:
    start, end = (motion.points[0], motion.points[-1]) if isinstance(motion, Polyline) else (motion.start, motion.end)
    return not isinstance(motion, Arc) and bool((np.abs(end - start) <= NO_LENGTH).all())


def _block_end(motion: Motion) -> list[Block]:
    """The block end that a move of a run carries in itself."""
    if isinstance(motion, Polyline) and not motion.one_block:
        return [BlockEnd(Origin.of(motion).source)]
    return []


def _only_an_end(between: list[Block]) -> bool:
    return not between or (len(between) == 1 and isinstance(between[0], BlockEnd))


def _line_to(held: _Held, motion: Motion) -> Line:
    """The line from the end of what is held to the end of a short block."""
    origin = Origin.of(motion)
    start = held.motion.points[-1] if isinstance(held.motion, Polyline) else held.motion.end
    end = motion.points[-1] if isinstance(motion, Polyline) else motion.end
    return Line(
        origin.source, start, end, origin.feed, math.isinf(origin.feed),
        programmed_way(end - origin.pcs_shift, origin.pcs_gain),
        origin.plane or (0, 1), None, origin.end_feed, origin.override_off, origin.pcs_gain,
    )  # fmt: skip
