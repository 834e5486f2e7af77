"""Which offset table a process works with: the machine's own, or a copy of it for checks and simulations."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from runtime.cnc.tools.offset_table import (
    MemoryOffsets,
    OffsetsOutOfReach,
    OffsetTable,
    OffsetTableError,
    SqliteOffsets,
)
from runtime.config.machine import Machine
from runtime.scheduler.retained import state_directory

FILE = "offsets.db"


def offset_file(machine: Machine, environment: Mapping[str, str]) -> Path:
    """The file of the machine's table."""
    return state_directory(machine.state_directory, environment) / FILE


def open_offsets(machine: Machine, environment: Mapping[str, str]) -> SqliteOffsets:
    """The machine's table itself; it is made if it is not there. Raises OffsetTableError."""
    return SqliteOffsets(offset_file(machine, environment))


def machine_offsets(machine: Machine, environment: Mapping[str, str]) -> OffsetTable:
    """The machine's table; if it cannot be opened, one that says so to every program."""
    try:
        return open_offsets(machine, environment)
    except OffsetTableError as error:
        return OffsetsOutOfReach(error)


def copied_offsets(machine: Machine, environment: Mapping[str, str]) -> MemoryOffsets:
    """What the machine's table holds now. Raises OffsetTableError."""
    if not offset_file(machine, environment).exists():
        return MemoryOffsets()
    table = open_offsets(machine, environment)
    try:
        channels = table.channels()
        work = {channel: table.work_offsets(channel) for channel in channels}
        variables = {channel: table.variables(channel) for channel in channels}
        boxes = {channel: box for channel in channels if (box := table.stroke_box(channel)) is not None}
        return MemoryOffsets(table.registers(), work, variables, boxes)
    finally:
        table.close()
