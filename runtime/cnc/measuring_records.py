"""The record of the gate at which a measuring run begins.

`start` of an axis that measures is 2 · signal + edge, 0 of one that does not; `end` is the number of the touch probe plus
4 · (bit of its level + 1). `number` holds the flags.
"""

from __future__ import annotations

from typing import Any

from runtime.cnc.blocks import Measurement, Probe, ProbeSignal
from runtime.cnc.motion_queue import GateReason, RecordKind, Records

THROUGH, MAY_BE_DEFLECTED, SIGNAL_NEEDED, LIMITED = 1, 2, 4, 8


def measurement(record: Records, block: Measurement) -> None:
    """Fill the record of the gate."""
    record["kind"], record["reason"] = RecordKind.GATE, GateReason.MEASURE
    record["number"] = (
        THROUGH * block.through
        + MAY_BE_DEFLECTED * block.may_be_deflected
        + SIGNAL_NEEDED * block.signal_needed
        + LIMITED * block.limited
    )
    for probe in block.probes:
        record["start"][0, probe.axis] = 2 * int(probe.signal) + probe.rising
        record["end"][0, probe.axis] = probe.number + 4 * (probe.level + 1)


def probes_of(record: Any, n_axes: int) -> tuple[Probe, ...]:
    """The probes of a measuring run, from the record of its gate."""
    found = []
    for axis in range(n_axes):
        coded, place = int(record["start"][axis]), int(record["end"][axis])
        if coded:
            found.append(Probe(axis, ProbeSignal(coded // 2), place % 4, place // 4 - 1, bool(coded % 2)))
    return tuple(found)
