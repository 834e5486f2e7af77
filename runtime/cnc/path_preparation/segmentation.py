"""#SEGMENTATION (programming manual 17178–17323): lines in pieces, arcs in shorter arcs or in lines. One NC block stays one."""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, ArcPieces, Block, Line, Polyline, Segmentation, SegmentationChange
from runtime.cnc.path_preparation.motion_pieces import Origin, moves

MAIN_AXES = 3
MOST = 100_000  # pieces of one block


class SegmentationStage:
    """The stage; a new one for each program."""

    def __init__(self) -> None:
        self._chosen = Segmentation()

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            if isinstance(block, SegmentationChange):
                self._chosen = block.segmentation
            elif isinstance(block, Line) and self._chosen.lines and block.end_feed is None and not block.override_off:
                yield line_in_pieces(block, self._chosen.length)
            elif isinstance(block, Polyline) and self._chosen.lines:
                yield from _run(block, self._chosen.length)
            elif isinstance(block, Arc) and self._chosen.arcs:
                yield from arc_in_pieces(block, self._chosen)
            else:
                yield block


def _count(way: float, length: float) -> int:
    return min(max(math.ceil(way / length * (1.0 - 1e-12)), 1), MOST)


def line_in_pieces(line: Line, length: float) -> Line | Polyline:
    """A line in equal pieces of at most `length`; the line itself if it is no longer."""
    count = _count(float(np.linalg.norm((line.end - line.start)[:MAIN_AXES])), length)
    if count == 1:
        return line
    origin = Origin.of(line)
    points = np.linspace(line.start, line.end, count + 1)
    points[-1] = line.end
    return Polyline(
        origin.program, points, np.full(count, origin.feed), np.full(count, origin.line, dtype=np.int64),
        np.full(count, origin.number, dtype=np.int64), origin.pcs_shift, origin.pcs_gain, origin.plane, one_block=True,
    )  # fmt: skip


def _run(run: Polyline, length: float) -> Iterator[Polyline]:
    """A run with its long moves in pieces: short ones stay together."""
    way = np.sqrt((np.diff(run.points, axis=0)[:, :MAIN_AXES] ** 2).sum(axis=1))
    begin = 0
    for at in np.flatnonzero(way > length * (1.0 + 1e-12)).tolist():
        if begin < at:
            yield moves(run, begin, at)
        count = _count(float(way[at]), length)
        points = np.linspace(run.points[at], run.points[at + 1], count + 1)
        points[-1] = run.points[at + 1]
        whole = replace(
            run,
            points=points,
            feeds=np.full(count, run.feeds[at]),
            lines=np.full(count, run.lines[at]),
            numbers=np.full(count, run.numbers[at]),
            one_block=True,
        )
        yield moves(whole, 0, count - 1)
        yield replace(moves(whole, count - 1, count), one_block=run.one_block)
        begin = at + 1
    if begin < len(run.feeds):
        yield moves(run, begin, len(run.feeds))


def arc_in_pieces(arc: Arc, chosen: Segmentation) -> Iterator[Arc | Polyline]:
    """An arc as shorter arcs, or as chords of a length or within an error; the last piece has its E word."""
    angle = math.radians(arc.angle)
    first, second = arc.plane
    radius = math.hypot(arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1])
    linear = arc.end - arc.start
    linear[first] = linear[second] = 0.0
    length = math.hypot(radius * angle, float(np.linalg.norm(linear[:MAIN_AXES])))
    if chosen.mode is ArcPieces.CHORD_ERROR:
        step = 2.0 * math.acos(max(1.0 - chosen.parameter / radius, 0.0)) if radius > 0.0 else math.pi
        count = min(max(math.ceil(abs(angle) / step * (1.0 - 1e-12)), 1), MOST)
    else:
        count = _count(length, chosen.parameter)
    share = np.linspace(0.0, 1.0, count + 1)
    x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
    turned = angle * share
    cos, sin = np.cos(turned), np.sin(turned)
    points = arc.start + share[:, None] * (arc.end - arc.start)
    for axis, place in ((first, arc.centre[0] + x * cos - y * sin), (second, arc.centre[1] + x * sin + y * cos)):
        points[:, axis] = place + share * (arc.end[axis] - place[-1])
    points[0], points[-1] = arc.start, arc.end
    if chosen.mode is ArcPieces.ARCS:
        for i in range(count):
            yield replace(
                arc,
                start=points[i],
                end=points[i + 1],
                end_pcs=arc.programmed(points[i + 1]),
                angle=arc.angle / count,
                end_feed=arc.end_feed if i == count - 1 else None,
            )
        return
    origin = Origin.of(arc)
    yield Polyline(
        origin.program, points, np.full(count, origin.feed), np.full(count, origin.line, dtype=np.int64),
        np.full(count, origin.number, dtype=np.int64), origin.pcs_shift, origin.pcs_gain, origin.plane, one_block=True,
    )  # fmt: skip
