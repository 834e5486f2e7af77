"""What a master sends by the clock, whatever the nodes do: SYNC with its counter, TIME, heartbeat, questions to guarded nodes."""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterable
from typing import Final

import can

from runtime.config.machine import Bus
from runtime.fieldbus.dialogue import SYNC, TIME
from runtime.fieldbus.network import fill

OPERATIONAL: Final = 5
DAYS_1970_TO_1984: Final = 5113


class Beat:
    """`send` puts a frame on the bus; what it raises comes through. `guarded`: ids of nodes without a heartbeat."""

    def __init__(
        self, bus: Bus, guarded: Iterable[int], send: Callable[[can.Message], None], wall_clock: Callable[[], float]
    ) -> None:
        self._bus = bus
        self._send = send
        self._wall_clock = wall_clock
        self._sync = can.Message(arbitration_id=SYNC, is_extended_id=False, dlc=1 if bus.sync_counter else 0)
        self._time = can.Message(arbitration_id=TIME, is_extended_id=False, dlc=6)
        self.heartbeat = can.Message(arbitration_id=0x700 + bus.master_node, data=[OPERATIONAL], is_extended_id=False)
        self._guards = [
            can.Message(arbitration_id=0x700 + node, is_extended_id=False, is_remote_frame=True, dlc=1)
            for node in guarded
        ]
        self._count = 0
        self._next_time = 0.0  # s
        self._next_heartbeat = 0.0

    def sync(self, now: float) -> None:
        """SYNC, counted if so configured; now and then the time before it."""
        bus = self._bus
        if bus.time_stamp and now >= self._next_time:
            self._next_time = now + bus.time_stamp
            fill(self._time, time_of_day(self._wall_clock()))
            self._send(self._time)
        if bus.sync_counter:
            self._count = self._count % bus.sync_counter + 1
            fill(self._sync, bytes((self._count,)))
        self._send(self._sync)
        if now >= self._next_heartbeat:
            self._next_heartbeat = max(self._next_heartbeat + bus.heartbeat, now)
            self._send(self.heartbeat)
            for request in self._guards:
                self._send(request)

    def heartbeat_due(self, now: float) -> bool:
        """Whether a heartbeat is due on a bus that is gone; the next one after the same time."""
        if now < self._next_heartbeat:
            return False
        self._next_heartbeat = now + self._bus.heartbeat
        return True


def time_of_day(seconds: float) -> bytes:
    """TIME_OF_DAY of CiA 301 for a time in s since 1970: ms since midnight, days since 1984, UTC."""
    days, in_day = divmod(seconds, 86_400.0)
    return struct.pack("<IH", int(in_day * 1000.0), int(days) - DAYS_1970_TO_1984)
