"""What two traces of a program have to do with each other: times, paths, and where time is won or lost.

Both paths are followed together: for every sample of one, the nearest place of the other is searched for around the place that
was nearest before, so that a contour which is run through several times is compared with itself in order.
"""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Place, TandemError
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

STRAIGHT = 1e-7  # mm: samples so near to a straight line are its part
WINDOW = 5.0  # mm of path searched on both sides of where the nearest place is expected
_FIXED = ("t", "v_path", "line")


class TraceError(TandemError):
    """A folder that holds no trace, or one of another machine."""


@dataclass(frozen=True, slots=True)
class Trace:
    """A trace folder: `t` (k,) s from 0 on, `positions` (k, n) mm or degrees, `v_path` (k,) mm/s, `line` (k,)."""

    folder: Path
    axes: tuple[str, ...]
    t: Floats
    positions: Floats
    v_path: Floats
    line: Ints
    errors: tuple[str, ...] = ()

    @property
    def period(self) -> float:
        """s between two samples."""
        return float(self.t[1] - self.t[0]) if len(self.t) > 1 else 1e-3

    @property
    def time(self) -> float:
        return float(self.t[-1] - self.t[0] + self.period) if len(self.t) else 0.0

    @property
    def s(self) -> Floats:
        """Way along the path at every sample, (k,), mm (degrees where only rotary axes move)."""
        steps = np.diff(self.positions, axis=0, prepend=self.positions[:1])
        main = np.linalg.norm(steps[:, :3], axis=1)
        others = np.linalg.norm(steps[:, 3:], axis=1)
        way: Floats = np.cumsum(np.where(main > 0.0, main, others))
        return way


def read_trace(folder: Path) -> Trace:
    """The samples and errors of a trace folder; TraceError if there are none."""
    file = folder / "samples.npz"
    try:
        with np.load(file) as samples:
            arrays = {name: samples[name] for name in samples.files}
        summary = json.loads((folder / "summary.json").read_text(encoding="utf-8"))
    except (OSError, ValueError, KeyError) as error:
        raise TraceError(system.NO_TRACE, Place(str(folder)), reason=str(error)) from None
    if not all(name in arrays for name in _FIXED) or not len(arrays["t"]):
        raise TraceError(system.NO_TRACE, Place(str(folder)), reason="it holds no samples")
    axes = tuple(name for name in arrays if name not in _FIXED)
    positions = np.column_stack([arrays[name] for name in axes])
    t = np.asarray(arrays["t"], dtype=float)
    return Trace(folder, axes, t - t[0], positions, arrays["v_path"], arrays["line"], tuple(summary.get("errors", ())))


@dataclass(frozen=True, slots=True)
class LineTime:
    """How long the path was in a program line, s, in both traces."""

    line: int
    first: float
    second: float

    @property
    def won(self) -> float:
        """s that the second one takes longer; negative: it is faster."""
        return self.second - self.first


@dataclass(frozen=True, slots=True)
class Difference:
    """`deviation`: greatest distance of the paths, mm, in `line` at `place` (n,) of the second one. `distance` (k,): of every
    sample of the second trace; `at` (k,) the way along the first path where it is nearest."""

    first: Trace
    second: Trace
    deviation: float
    line: int
    place: Floats
    distance: Floats
    at: Floats
    lines: Sequence[LineTime] = field(default=())

    @property
    def axes(self) -> Mapping[str, float]:
        """Greatest distance of the end positions per axis."""
        ends = np.abs(self.first.positions[-1] - self.second.positions[-1])
        return dict(zip(self.first.axes, ends.tolist(), strict=True))


def compare(first: Trace, second: Trace) -> Difference:
    """Raises TraceError for traces of different axes."""
    if first.axes != second.axes:
        reason = f"axes {' '.join(second.axes)}, not {' '.join(first.axes)}"
        raise TraceError(system.NO_TRACE, Place(str(second.folder)), reason=reason)
    distance, at = deviations(first.positions, second.positions)
    back, _ = deviations(second.positions, first.positions)
    of_second = float(distance.max()) >= float(back.max())
    trace, worst = (second, int(np.argmax(distance))) if of_second else (first, int(np.argmax(back)))
    return Difference(
        first,
        second,
        max(float(distance.max()), float(back.max())),
        int(trace.line[worst]),
        trace.positions[worst],
        distance,
        at,
        _line_times(first, second),
    )


def _line_times(first: Trace, second: Trace) -> list[LineTime]:
    """The time of every line, that with the greatest difference first."""
    size = int(max(first.line.max(), second.line.max())) + 1
    times = [np.bincount(trace.line, minlength=size) * trace.period for trace in (first, second)]
    found = [LineTime(line, float(times[0][line]), float(times[1][line])) for line in range(size)]
    return sorted((one for one in found if one.first or one.second), key=lambda one: (-abs(one.won), one.line))


# ---------------------------------------------------------------------------------------------------- paths


def deviations(path: Floats, points: Floats) -> tuple[Floats, Floats]:
    """Distance of successive points (k, n) from a path (m, n) that they follow, and the way along it where it is nearest."""
    corners = np.ascontiguousarray(path[corner_points(path)])
    way = np.concatenate([[0.0], np.cumsum(np.linalg.norm(np.diff(corners, axis=0), axis=1))])
    distance, at = np.zeros(len(points)), np.zeros(len(points))
    follow(corners, way, np.ascontiguousarray(points), distance, at)
    return distance, at


@kernel
def corner_points(path: Floats) -> Ints:
    """Samples that a polyline needs to be the path (m, n): the first, the last, and where its direction changes."""
    m, n = path.shape
    kept = np.zeros(m, dtype=np.int64)
    count = 1
    last = 0
    for i in range(1, m - 1):
        square, along = 0.0, 0.0
        for k in range(n):
            square += (path[i + 1, k] - path[last, k]) ** 2
            along += (path[i + 1, k] - path[last, k]) * (path[i, k] - path[last, k])
        off = 0.0
        share = along / square if square > 0.0 else 0.0
        for k in range(n):
            off += (path[last, k] + share * (path[i + 1, k] - path[last, k]) - path[i, k]) ** 2
        if off > STRAIGHT**2 or share < 0.0 or share > 1.0:
            kept[count] = i
            count += 1
            last = i
    if m > 1:
        kept[count] = m - 1
        count += 1
    return kept[:count]


@kernel
def follow(path: Floats, way: Floats, points: Floats, distance: Floats, at: Floats) -> None:
    """Fill the distance of every point from the polyline `path` (m, n), whose corners lie at `way` (m,), and the way there."""
    m, n = path.shape
    expected = 0.0
    segment = 0
    for i in range(points.shape[0]):
        if i > 0:
            square = 0.0
            for k in range(n):
                square += (points[i, k] - points[i - 1, k]) ** 2
            expected = min(expected + np.sqrt(square), way[m - 1])
        while segment > 0 and way[segment] > expected - WINDOW:
            segment -= 1
        while segment < m - 2 and way[segment + 1] < expected - WINDOW:
            segment += 1
        best, place = np.inf, expected
        j = segment
        while m > 1 and j < m - 1 and (way[j] <= expected + WINDOW or j == segment):
            square, along = 0.0, 0.0
            for k in range(n):
                step = path[j + 1, k] - path[j, k]
                square += step * step
                along += step * (points[i, k] - path[j, k])
            share = min(max(along / square, 0.0), 1.0) if square > 0.0 else 0.0
            off = 0.0
            for k in range(n):
                off += (path[j, k] + share * (path[j + 1, k] - path[j, k]) - points[i, k]) ** 2
            there = way[j] + share * (way[j + 1] - way[j])
            nearer = abs(there - expected) < abs(place - expected)
            if off < best - 1e-18 or (off <= best + 1e-18 and nearer):
                best, place = off, there
            j += 1
        if m == 1:
            best = 0.0
            for k in range(n):
                best += (path[0, k] - points[i, k]) ** 2
        distance[i], at[i] = np.sqrt(best), place
        expected = place


@warms("comparison of traces")
def _warm_up() -> None:
    path = np.zeros((2, 3))
    corner_points(path)
    follow(path, np.zeros(2), path, np.zeros(2), np.zeros(2))
