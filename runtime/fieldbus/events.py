"""Text for what the bus tells the cycle: a `DriveEvent` is four numbers, a `Problem` can be read."""

from __future__ import annotations

import os

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import Problem
from runtime.drives import DriveEvent, DriveState
from runtime.fieldbus.error_codes import emergency_text, nmt_state_text


def problem_of(event: DriveEvent, machine: Machine) -> Problem:
    """The catalogue entry of an event with its values filled in: axis or node, code and its meaning."""
    if event.axis >= 0:
        owner = f"axis {machine.axes[event.axis].name}"
    else:
        place = event.node, event.bus
        nodes = (f"I/O node {n}" for n, io in enumerate(machine.fieldbus.io) if (io.node, io.bus or "") == place)
        owner = next(nodes, "the bus")
    channel = f" {machine.fieldbus.all_buses()[event.bus].channel}" if machine.fieldbus.buses else ""
    values = {
        "owner": owner, "node": event.node, "code": event.code, "meaning": _meaning(event), "bus": channel,
    }  # fmt: skip
    return Problem(CATALOGUE[event.error_id], values)


def _meaning(event: DriveEvent) -> str:
    if event.text or event.error_id == catalogue.NODE_REJOINED.id:
        return event.text
    if event.error_id == catalogue.NODE_LEFT_OPERATIONAL.id:
        return nmt_state_text(event.code)
    if event.error_id == catalogue.DRIVE_DISABLED.id:
        return DriveState(event.code).name.lower().replace("_", " ")
    if event.error_id in (catalogue.BUS_GONE.id, catalogue.ONE_BUS_GONE.id):
        return os.strerror(event.code).lower() if event.code else "frames can be neither sent nor received"
    if event.error_id == catalogue.DRIVE_FAULT.id and not event.code:
        return "the drive named no cause"
    return emergency_text(event.code)
