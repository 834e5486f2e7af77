"""What of a running machine outlives it: read from the HLI, also from that of a runtime that has just died."""

from __future__ import annotations

from runtime.config.machine import Machine
from runtime.hli.layout import Hli
from runtime.hli.units import LENGTH
from runtime.scheduler.alarms import history
from runtime.scheduler.retained import Retained


def retained_of(machine: Machine, hli: Hli) -> Retained:
    """Positions of all axes (mm, degrees), zero offsets, alarm history."""
    positions = {axis.name: hli.axes[i].status.actual_position_r * LENGTH for i, axis in enumerate(machine.axes)}
    offsets = {channel.name: dict(channel.zero_offsets) for channel in machine.channels}
    return Retained(positions, offsets, history(hli))
