"""What of a running machine outlives it: read from the HLI, also from that of a runtime that has just died."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np

from runtime.cnc.block_search import PointOfInterruption
from runtime.config.machine import Machine
from runtime.hli.layout import Hli, ReferenceState
from runtime.hli.memory import put_text
from runtime.hli.units import LENGTH
from runtime.scheduler.alarms import history
from runtime.scheduler.retained import Retained, RetainedError, RetainedStore
from runtime.scheduler.search_orders import point_in


class Keeper:
    """Writes what is retained, whenever it has changed. What cannot be written is told by the cycle, as an alarm."""

    def __init__(self, machine: Machine, store: RetainedStore) -> None:
        self._machine, self._store = machine, store
        self._before: Retained | None = None  # what was kept last, by this run or by the one before
        self._kept: Retained | None = None  # what this run has written
        self._tried: list[tuple[int, float]] = []  # references when it was written, or tried to
        self._absolute = [i for i, axis in enumerate(machine.axes) if axis.homing and axis.homing.absolute]

    def urgent(self, hli: Hli) -> bool:
        """An axis with an absolute encoder was homed, or has lost its reference: that does not wait for the next second.

        Without supply a moment later it would have to be homed again, or, worse, be taken for one that has its reference.
        """
        return bool(self._absolute) and self._references(hli) != self._tried

    def _references(self, hli: Hli) -> list[tuple[int, float]]:
        areas = [hli.axes[i].reference for i in self._absolute]
        return [(int(area.state_r), float(area.origin_r)) for area in areas]

    def keep(self, hli: Hli) -> None:
        """Once a second, when it is urgent, and at the end."""
        self._tried = self._references(hli)
        if self._before is None:
            self._before, _ = self._store.load()
        data = retained_of(self._machine, hli, self._before)
        if data == self._kept:  # disks wear out
            return
        platform = hli.platform
        try:
            self._store.save(data)
        except RetainedError as error:
            if not platform.not_retained_w:
                put_text(platform, "not_retained_text_w", error.problem.text)
                platform.not_retained_w = True
        else:
            self._kept = self._before = data
            platform.not_retained_w = False


def retained_of(machine: Machine, hli: Hli, before: Retained | None = None) -> Retained:
    """Positions of all axes (mm, degrees), zero offsets, references, where the program was interrupted, alarm history.

    `before`: what was kept until now, of axes of which nothing is said yet.
    """
    references = _references(machine, hli, {} if before is None else before.references)
    positions = {axis.name: hli.axes[i].status.actual_position_r * LENGTH for i, axis in enumerate(machine.axes)}
    offsets = {channel.name: dict(channel.zero_offsets) for channel in machine.channels}
    point = point_in(hli, len(machine.channels[0].axes))
    return Retained(positions, offsets, history(hli), references, {} if point is None else _kept(point))


def _references(machine: Machine, hli: Hli, before: Mapping[str, Mapping[str, Any]]) -> dict[str, Mapping[str, Any]]:
    """Of the axes with an absolute encoder that have been homed."""
    found: dict[str, Mapping[str, Any]] = {}
    for area, axis in zip(hli.axes, machine.axes, strict=False):
        reference = area.reference
        if axis.homing is None or axis.homing.absolute is None or axis.drive is None:
            continue
        if reference.state_r == ReferenceState.KEPT:
            found[axis.name] = {
                "origin": float(reference.origin_r),
                "place": float(reference.place_r),
                "identity": [int(reference.vendor_r), int(reference.product_r), int(reference.serial_r)],
                "increments_per_unit": axis.drive.increments_per_unit,
            }
        elif reference.state_r == ReferenceState.UNKNOWN and axis.name in before:
            found[axis.name] = before[axis.name]
    return found


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
