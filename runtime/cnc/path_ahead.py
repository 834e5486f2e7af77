"""Where the path will lead the axes: the elements that are known, for who moves axes beside it or stops it before one of them."""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import RecordKind

Floats = npt.NDArray[np.float64]


class PathAhead(NamedTuple):
    """k elements from the one in work on. `distance` (k,): way until each begins, mm, not above 0 for the one in work.

    `lowest`, `highest` (k, n_axes): a box around each, of a line in work around the rest of it; that of an arc contains its whole
    circle.
    """

    distance: Floats
    lowest: Floats
    highest: Floats


def path_ahead(path: Interpolator, most: int) -> PathAhead | None:
    """The next elements among at most `most` records; None if no motion is known."""
    queue = path.queue
    begin = path.next_index
    count = min(queue.written - begin, most)
    if count <= 0:
        return None
    records = queue.records[np.arange(begin, begin + count) % queue.capacity]
    records = records[records["kind"] <= RecordKind.POLYNOMIAL]
    if not len(records):
        return None
    n = queue.n_axes
    in_work = queue.kind(begin) <= RecordKind.POLYNOMIAL and path.index == begin
    starts = records["start"][:, :n].copy()
    if in_work and records["kind"][0] == RecordKind.LINE:
        starts[0] = path.position  # what is behind it no longer counts
    lowest = np.minimum(starts, records["end"][:, :n])
    highest = np.maximum(starts, records["end"][:, :n])
    for i in np.flatnonzero(records["kind"] == RecordKind.ARC).tolist():
        arc = records[i]
        axes = (int(arc["axis0"]), int(arc["axis1"]))
        centre = np.array([arc["centre0"], arc["centre1"]])
        radius = float(np.hypot(*(arc["start"][list(axes)] - centre)))
        for axis, middle in zip(axes, centre, strict=True):
            lowest[i, axis], highest[i, axis] = middle - radius, middle + radius
    lengths = records["length"]
    distance = np.cumsum(lengths) - lengths
    if in_work:
        distance -= lengths[0] - path.remaining
    return PathAhead(distance, lowest, highest)
