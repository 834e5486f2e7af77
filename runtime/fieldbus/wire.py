"""How long frames stand on the wire."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass
from typing import Final

from runtime.config.machine import Bus
from runtime.fieldbus.exchange import IO_REFRESH
from runtime.fieldbus.links import Links
from runtime.fieldbus.pdo import LAST_SYNCHRONOUS

# A classic frame with an 11-bit identifier: 44 bits + data, 3 bits of pause. The 34 bits from start of frame to CRC,
# and the data, are stuffed: at worst one bit in four (ISO 11898-1). Half of the worst case is the estimate for
# process data.
FRAME_BITS: Final = tuple(47 + 8 * n + (34 + 8 * n - 1) // 4 / 2 for n in range(9))


# A frame of CAN FD (ISO 11898-1:2015): 17 bits up to the switch of the bit rate and 12 behind the CRC at the nominal rate; ESI,
# DLC, data, stuff count, CRC of 17 bits and their 6 fixed stuff bits at that of the data phase. Stuffing as above.
FD_NOMINAL: Final = 17 + 12 + 16 / 4 / 2
FD_DATA: Final = tuple(5 + 8 * n + (5 + 8 * n) / 4 / 2 + 4 + 17 + 6 + 1 for n in range(9))


def frame_bits(bus: Bus) -> tuple[float, ...]:
    """How long frames with 0...8 bytes stand on the wire, in bits of the nominal rate."""
    if not bus.fd:
        return FRAME_BITS
    return tuple(FD_NOMINAL + bits * bus.bitrate / bus.data_bitrate for bits in FD_DATA)


def load(data_lengths: Iterable[int], seconds: float, bitrate: float) -> float:
    """Share of the bus, 0...1 and above, that frames of these data lengths (bytes) take in `seconds`."""
    return sum(FRAME_BITS[n] for n in data_lengths) / (seconds * bitrate)


@dataclass(frozen=True, slots=True)
class Traffic:
    """What the nodes of a bus and its master send, per second."""

    frames: float
    bits: float


def planned_traffic(links: Links, bus: Bus, period: float) -> Traffic:
    """Process data, SYNC and heartbeats at a cycle of `period` s; what happens now and then (SDO, EMCY) is not in it."""
    length = frame_bits(bus)
    heartbeats = (len(links) + 1) / bus.heartbeat
    frames, bits = heartbeats, heartbeats * length[1]
    sync = length[1 if bus.sync_counter else 0]
    frames, bits = frames + 1.0 / period, bits + sync / period
    if bus.time_stamp:
        frames, bits = frames + 1.0 / bus.time_stamp, bits + length[6] / bus.time_stamp
    for link in links:
        if link.guarded:  # questions of the master, beside the answers
            frames, bits = frames + 1.0 / bus.heartbeat, bits + length[0] / bus.heartbeat
        for plan, layout in link.layouts.items():
            every = plan.transmission * period if plan.transmission <= LAST_SYNCHRONOUS else IO_REFRESH
            if plan.inhibit_time:  # at worst
                every = plan.inhibit_time * 1e-4
            frames, bits = frames + 1.0 / every, bits + length[layout.codec.size] / every
    return Traffic(frames, bits)


def planned_load(links: Links, bus: Bus, period: float) -> float:
    """Share of a bus that the traffic of its nodes takes at a cycle of `period` s, 0...1 and above."""
    return planned_traffic(links, bus, period).bits / bus.bitrate
