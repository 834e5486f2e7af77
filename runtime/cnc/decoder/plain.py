"""Runs of plain blocks → polylines: what the scan kernel has read meets the modal state here, at execution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from runtime.cnc.blocks import Block, Floats, Polyline
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.modal import INCH, PLANE_AXES, Motion
from runtime.cnc.decoder.modulo import modulo_end
from runtime.cnc.language.isg.index import Unit
from runtime.cnc.language.isg.scan import NO_MOTION, PLUS, Ints, PlainRows
from runtime.kernels import kernel, warms

CHUNK = 4096  # moves per polyline
_KEPT_LINES = 1024  # runs up to this length stay scanned, for loops
_KEPT_RUNS = 256


@kernel
def trace_plain(
    values: Floats,
    given: Ints,
    motion: Ints,
    feed: Floats,
    number: Ints,
    first: int,
    count: int,
    first_line: int,
    mode: int,
    feed_now: float,
    incremental: bool,
    factor: Floats,
    feed_factor: float,
    offset: Floats,
    limit: float,
    modulo: Floats,
    shortest: bool,
    position: Floats,
    points: Floats,
    feeds: Floats,
    lines: Ints,
    numbers: Ints,
) -> tuple[int, int, int, float]:
    """Trace the rows `first` to before `count` from `position` on, which is moved along.

    `mode` 0 or 1 is the path condition, above 1 a circle; `feed_now` in mm/min, NaN for none. Stops in front of a row
    that needs the full decoder (a circle, a missing or wrong feed, a position out of range) and when `feeds` is full.
    `modulo` (n,) are the ranges of axes that turn without end, 0 for others; `shortest`: their signs choose no direction.
    Returns the next row, the count of moves, mode and feed. `points` gets the position before the first move first.
    """
    axes = position.size
    moves = 0
    points[0] = position
    row = first
    while row < count and moves < feeds.size:
        mode_here = mode if motion[row] == NO_MOTION else motion[row]
        feed_here = feed_now
        if not np.isnan(feed[row]):
            feed_here = feed[row] * feed_factor
            if not feed_here >= 0:
                break
        bits = given[row]
        if bits != 0:
            if mode_here > 1 or (mode_here == 1 and not feed_here > 0):
                break
            inside = True
            for axis in range(axes):
                target = position[axis]
                if bits & (1 << axis):
                    programmed = values[row, axis] * factor[axis]
                    if modulo[axis] == 0.0:
                        target = target + programmed if incremental else programmed + offset[axis]
                        if not abs(target) <= limit:
                            inside = False
                    elif incremental:
                        target = target + programmed
                    elif shortest or (bits >> PLUS & (1 << axis) == 0 and not np.signbit(values[row, axis])):
                        target = modulo_end(target, programmed + offset[axis], modulo[axis], 0)
                    else:
                        direction = -1 if np.signbit(programmed) else 1  # mirrored axes turn the other way
                        target = modulo_end(
                            target, abs(values[row, axis]) * factor[axis] + offset[axis], modulo[axis], direction
                        )
                    if not abs(programmed) <= limit:
                        inside = False
                points[moves + 1, axis] = target
            if not inside:
                break
            for axis in range(axes):
                position[axis] = points[moves + 1, axis]
            feeds[moves] = np.inf if mode_here == 0 else feed_here
            lines[moves] = first_line + row
            numbers[moves] = number[row]
            moves += 1
        mode = mode_here
        feed_now = feed_here
        row += 1
    return row, moves, mode, feed_now


@dataclass(frozen=True, slots=True)
class NeedsFull:
    """The line that the polyline could not take: to be executed by the full decoder, then the run goes on."""

    offset: int
    line: int


class PlainRuns:
    """Executes runs of plain blocks of one decoder."""

    def __init__(self, axes: tuple[str, ...], limit: float) -> None:
        self._axes = axes
        self._limit = limit
        self._kept: dict[tuple[int, int], tuple[PlainRows, int]] = {}

    def run(self, unit: Unit, entry: int, x: Execution, first: int, count: int) -> Iterator[Block | NeedsFull]:
        """The moves of a run from its row `first` to before `count`; modal state and position follow. Whoever gets a NeedsFull
        executes it before going on."""
        rows, base = self._rows(unit, entry)
        line = unit.line(entry)
        while first < count:
            if x.fast and x.frames[-1].modal is None:
                first, polyline = self._trace(unit, rows, first, count, line, x)
                if polyline is not None:
                    yield from x.stepwise(polyline)
            if first < count:
                yield NeedsFull(base + int(rows.starts[first]), line + first)
                first += 1

    def rows(self, unit: Unit, entry: int) -> PlainRows:
        """The rows of a run as they were scanned."""
        return self._rows(unit, entry)[0]

    def _rows(self, unit: Unit, entry: int) -> tuple[PlainRows, int]:
        """Scanned rows of the run, and the file offset that their starts count from; short runs stay, for loops."""
        key = (id(unit), entry)
        if key not in self._kept:
            rows, base = unit.rows(entry)
            if unit.count(entry) > _KEPT_LINES:
                return rows, base
            if len(self._kept) >= _KEPT_RUNS:
                self._kept.clear()
            self._kept[key] = (rows.head(unit.count(entry)), base)
        return self._kept[key]

    def _trace(
        self, unit: Unit, rows: PlainRows, first: int, count: int, line: int, x: Execution
    ) -> tuple[int, Polyline | None]:
        """As many rows as one polyline takes; the next row."""
        modal, coordinates = x.modal, x.coordinates
        room = min(CHUNK, count - first)
        points = np.empty((room + 1, len(self._axes)))
        feeds, lines, numbers = np.empty(room), np.empty(room, np.int64), np.empty(room, np.int64)
        position = np.array(coordinates.position)
        gain, shift = np.array(coordinates.gain), np.array(coordinates.shift)
        inch = np.where(x.setup.linear, INCH if modal.inch else 1.0, x.setup.rotary_unit)
        feed_factor = (INCH if modal.inch else 1.0) * x.setup.feed_factor
        following, moves, mode, feed = trace_plain(
            rows.values,
            rows.given,
            rows.motion,
            rows.feed,
            rows.number,
            first,
            count,
            line,
            int(modal.motion),
            np.nan if modal.feed is None else modal.feed,
            modal.incremental,
            inch * gain,
            feed_factor,
            shift,
            self._limit,
            np.array([x.modulo.size(axis) for axis in range(len(position))]),
            x.modulo.always_shortest,
            position,
            points,
            feeds,
            lines,
            numbers,
        )
        following = int(following)
        modal.motion = Motion(int(mode))
        modal.feed = None if np.isnan(feed) else float(feed)
        if following > first:
            last = rows.number[first:following]
            given = last[last >= 0]
            if len(given):
                x.block_number = int(given[-1])
        if not moves:
            return following, None
        coordinates.moved([float(p) for p in position])
        plain = bool((gain == 1.0).all())
        polyline = Polyline(
            unit.name,
            points[: moves + 1],
            feeds[:moves],
            lines[:moves],
            numbers[:moves],
            shift,
            None if plain else gain,
            PLANE_AXES[modal.plane],
        )
        return following, polyline


@warms("plain runs")
def _warm() -> None:
    rows = PlainRows.empty(1, 3)
    zeros = np.zeros(3)
    trace_plain(
        *rows[:5],
        0,
        1,
        1,
        1,
        100.0,
        False,
        np.ones(3),
        1.0,
        zeros,
        1e6,
        zeros,
        False,
        np.zeros(3),
        np.zeros((2, 3)),
        np.zeros(1),
        np.zeros(1, np.int64),
        np.zeros(1, np.int64),
    )
