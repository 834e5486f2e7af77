"""What of a running machine outlives it: read from the HLI, also from that of a runtime that has just died."""

from __future__ import annotations

from typing import Any

import numpy as np

from runtime.cnc.block_search import PointOfInterruption
from runtime.config.machine import Machine
from runtime.hli.layout import Hli
from runtime.hli.units import LENGTH
from runtime.scheduler.alarms import history
from runtime.scheduler.retained import Retained
from runtime.scheduler.search_orders import point_in


def retained_of(machine: Machine, hli: Hli) -> Retained:
    """Positions of all axes (mm, degrees), zero offsets, where the program was interrupted, alarm history."""
    positions = {axis.name: hli.axes[i].status.actual_position_r * LENGTH for i, axis in enumerate(machine.axes)}
    offsets = {channel.name: dict(channel.zero_offsets) for channel in machine.channels}
    point = point_in(hli, len(machine.channels[0].axes))
    return Retained(positions, offsets, history(hli), {} if point is None else _kept(point))


def _kept(point: PointOfInterruption) -> dict[str, Any]:
    return {
        "program": point.program,
        "begin": [float(place) for place in point.begin],
        "way": point.way,
        "line": point.line,
        "n": point.n,
    }


def interruption_in(retained: Retained, n_axes: int) -> PointOfInterruption | None:
    """The point of interruption that was kept; None without one, or of another machine."""
    kept = retained.interruption
    if not kept or len(kept["begin"]) != n_axes:
        return None
    return PointOfInterruption(kept["program"], np.array(kept["begin"]), kept["way"], kept["line"], kept["n"])
