"""Pieces of motions: what smoothing leaves of a block, and polynomials that belong to it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import Arc, Floats, Line, Polyline, Polynomials, Source, machine_way, programmed_way
from runtime.cnc.geometry.elements import arc_at

NO_LENGTH = 1e-9  # mm

Motion = Line | Arc | Polyline


@dataclass(frozen=True, slots=True)
class Origin:
    """What an element inherits from the block that it belongs to; the fields are those of Polynomials."""

    program: str
    line: int
    number: int
    feed: float
    pcs_shift: Floats
    pcs_gain: Floats | None
    plane: tuple[int, int] | None
    end_feed: float | None
    override_off: bool

    @classmethod
    def of(cls, motion: Motion) -> Origin:
        """Of a line or an arc, or of the last move of a run."""
        if isinstance(motion, Polyline):
            return cls(
                motion.program, int(motion.lines[-1]), int(motion.numbers[-1]), float(motion.feeds[-1]),
                motion.pcs_shift, motion.pcs_gain, motion.plane, None, False,
            )  # fmt: skip
        source, gain = motion.source, motion.pcs_gain
        return cls(
            source.program, source.line, -1 if source.n is None else source.n,
            np.inf if isinstance(motion, Line) and motion.rapid else motion.feed,
            motion.end - machine_way(motion.end_pcs, gain), gain, motion.plane,
            motion.end_feed, motion.override_off,
        )  # fmt: skip

    @property
    def source(self) -> Source:
        """The place in the program."""
        return Source(self.program, self.line, None if self.number < 0 else self.number)

    def polynomials(self, coefficients: Floats) -> Polynomials:
        """A run (k, 6, n_axes) that belongs to the block."""
        k = len(coefficients)
        return Polynomials(
            self.program, coefficients, np.full(k, self.feed), np.full(k, self.line, dtype=np.int64),
            np.full(k, self.number, dtype=np.int64), np.zeros(k, dtype=np.bool_), self.pcs_shift, self.pcs_gain,
            self.plane, override_off=self.override_off,
        )  # fmt: skip


def moves(run: Polyline, begin: int, end: int) -> Polyline:
    """The moves `begin` to before `end` of a run."""
    return replace(
        run,
        points=run.points[begin : end + 1],
        feeds=run.feeds[begin:end],
        lines=run.lines[begin:end],
        numbers=run.numbers[begin:end],
    )


def lines_of(run: Polyline) -> Iterator[Line]:
    """A run as single moves."""
    for i, feed in enumerate(run.feeds.tolist()):
        number = int(run.numbers[i])
        source = Source(run.program, int(run.lines[i]), None if number < 0 else number)
        end = run.points[i + 1]
        programmed = programmed_way(end - run.pcs_shift, run.pcs_gain)
        plane = run.plane or (0, 1)
        yield Line(source, run.points[i], end, feed, bool(np.isinf(feed)), programmed, plane, pcs_gain=run.pcs_gain)


def without_empty(run: Polyline) -> Polyline:
    """A run without the moves that have no way in any axis (P-CHAN-00254 is 0); the last one stays if all are such."""
    there: npt.NDArray[np.bool_] = np.any(np.abs(np.diff(run.points, axis=0)) > NO_LENGTH, axis=1)
    if there.all():
        return run
    if not there.any():
        there[-1] = True
    kept = np.flatnonzero(there)
    return replace(
        run,
        points=np.vstack([run.points[:1], run.points[kept + 1]]),
        feeds=run.feeds[kept],
        lines=run.lines[kept],
        numbers=run.numbers[kept],
    )


def shortened(motion: Motion, taken: float, trim: float, length: float) -> Motion | None:
    """A single motion of `length` without `taken` at its start and `trim` at its end; None if nothing is left."""
    if taken == 0.0 and trim == 0.0:
        return motion
    if length - taken - trim <= NO_LENGTH:
        return None
    low, high = taken / length, 1.0 - trim / length
    if isinstance(motion, Arc):
        start, end = _place(motion, low, length), _place(motion, high, length)
        return replace(
            motion,
            start=start,
            end=end,
            end_pcs=motion.programmed(end),
            angle=motion.angle * (high - low),
            end_feed=motion.end_feed if trim == 0.0 else None,
        )
    if isinstance(motion, Polyline):
        way = motion.points[1] - motion.points[0]
        points = np.vstack([motion.points[0] + way * low, motion.points[0] + way * high])
        if trim == 0.0:
            points[1] = motion.points[1]
        return replace(motion, points=points)
    way = motion.end - motion.start
    end = motion.end if trim == 0.0 else motion.start + way * high
    return replace(
        motion,
        start=motion.start + way * low,
        end=end,
        end_pcs=motion.programmed(end),
        end_feed=motion.end_feed if trim == 0.0 else None,
    )


def _place(arc: Arc, share: float, length: float) -> Floats:
    n = len(arc.start)
    q, dq = np.zeros(n), np.zeros(n)
    first, second = arc.plane
    arc_at(
        arc.start, arc.end, first, second, float(arc.centre[0]), float(arc.centre[1]), np.radians(arc.angle), share,
        length, n, q, dq,
    )  # fmt: skip
    return q


def joined(first: Polynomials, second: Polynomials) -> Polynomials | None:
    """Two runs as one; None where they can't share programmed coordinates or override."""
    same_gain = (first.pcs_gain is None and second.pcs_gain is None) or (
        first.pcs_gain is not None and second.pcs_gain is not None and np.array_equal(first.pcs_gain, second.pcs_gain)
    )
    if (
        not same_gain
        or not np.array_equal(first.pcs_shift, second.pcs_shift)
        or first.override_off != second.override_off
        or first.end_feed is not None
        or first.program != second.program
    ):
        return None
    return replace(
        first,
        coefficients=np.concatenate([first.coefficients, second.coefficients]),
        feeds=np.concatenate([first.feeds, second.feeds]),
        lines=np.concatenate([first.lines, second.lines]),
        numbers=np.concatenate([first.numbers, second.numbers]),
        block_ends=np.concatenate([first.block_ends, second.block_ends]),
        end_feed=second.end_feed,
    )


def interleaved(
    run: Polyline, length: Floats, count: npt.NDArray[np.int64], trims: Floats, curves: Floats, taken: float, ends: str
) -> Polynomials:
    """What is left of the first k lines of a run, each followed by the `count` (k,) polynomials of its curve.

    `curves` (k, 4, 6, n). `trims` (k, 2): taken from the end of the line, and from the start of the next; `taken` from that of
    the first one.
    The NC block of a line ends "before", "within" or "behind" its curve.
    """
    k, n = len(count), run.points.shape[1]
    before = np.concatenate([[taken], trims[:-1, 1]])
    left = length - before - trims[:, 0]
    line = (left > NO_LENGTH) | (count == 0) | (ends == "before")
    size = line.astype(np.int64) + count
    first = np.cumsum(size) - size
    total = int(size.sum())
    coefficients = np.zeros((total, 6, n))
    block_ends = np.zeros(total, dtype=np.bool_)
    points = run.points[: k + 1]
    way = np.diff(points, axis=0)
    with np.errstate(divide="ignore", invalid="ignore"):
        direction = np.where(length[:, None] > 0.0, way / length[:, None], 0.0)
    at = first[line]
    whole = (before == 0.0) & (trims[:, 0] == 0.0)
    begin = points[:-1] + direction * before[:, None]
    rest = np.where(whole[:, None], way, direction * np.maximum(left, 0.0)[:, None])
    coefficients[at, 0], coefficients[at, 1] = begin[line], rest[line]
    for piece in range(curves.shape[1]):
        there = count > piece
        coefficients[(first + line + piece)[there]] = curves[there, piece]
    if not run.one_block:
        last = {"before": first, "within": first + line + count // 2 - 1, "behind": first + size - 1}[ends]
        block_ends[np.where(count > 0, last, first)] = True
    parent = np.repeat(np.arange(k), size)
    # behind its middle a curve belongs to the next line
    place = np.arange(total) - first[parent] - line[parent]
    owner = np.where(place >= np.maximum(count[parent] // 2, 1), parent + 1, parent)
    return Polynomials(
        run.program, coefficients, run.feeds[owner], run.lines[owner], run.numbers[owner], block_ends, run.pcs_shift,
        run.pcs_gain, run.plane,
    )  # fmt: skip
