"""How long frames stand on the wire."""

from __future__ import annotations

from collections.abc import Iterable
from typing import Final

from runtime.config.machine import Bus
from runtime.fieldbus.exchange import IO_REFRESH
from runtime.fieldbus.links import Links
from runtime.fieldbus.pdo import LAST_SYNCHRONOUS

# A classic frame with an 11-bit identifier: 44 bits + data, 3 bits of pause. The 34 bits from start of frame to CRC,
# and the data, are stuffed: at worst one bit in four (ISO 11898-1). Half of the worst case is the estimate for
# process data.
FRAME_BITS: Final = tuple(47 + 8 * n + (34 + 8 * n - 1) // 4 / 2 for n in range(9))


def load(data_lengths: Iterable[int], seconds: float, bitrate: float) -> float:
    """Share of the bus, 0...1 and above, that frames of these data lengths (bytes) take in `seconds`."""
    return sum(FRAME_BITS[n] for n in data_lengths) / (seconds * bitrate)


def planned_load(links: Links, bus: Bus, period: float) -> float:
    """Share of a bus that the process data and heartbeats of its nodes take at a cycle of `period` s, 0...1 and above."""
    bits = FRAME_BITS[1 if bus.sync_counter else 0] / period
    for link in links:
        for plan, layout in link.layouts.items():
            every = plan.transmission * period if plan.transmission <= LAST_SYNCHRONOUS else IO_REFRESH
            bits += FRAME_BITS[layout.codec.size] / every
    bits += (len(links) + 1) * FRAME_BITS[1] / bus.heartbeat
    return bits / bus.bitrate
