"""The counters of #TIMER: shared by all channels, by decoder and cycle, on the runtime's clock.

They go on over program changes and resets. START lets a counter go on from where it stands, CLEAR brings it to 0 and stops it.
A counter has no lock: programs that act on the same one at the same time disturb each other's measurement.
"""

from __future__ import annotations

from typing import Literal

from runtime.hli.layout import TIMERS, Hli, Timer

Command = Literal["START", "STOP", "CLEAR", "READ"]
GREATEST_MS = 2**32 - 1  # 1193 hours: a counter stands there


class Timers:
    """Counters 0…127. The time is that of the cycle, so that counts are the same in every run of a simulation."""

    def __init__(self, hli: Hli) -> None:
        self._head = hli.head
        self._timers: list[Timer] = [hli.timers[i] for i in range(TIMERS)]

    def act(self, command: Command, number: int) -> int:
        """Carry out a command; the count after it, ms. Nothing for numbers that do not exist."""
        if not 0 <= number < TIMERS:
            return 0
        timer, now = self._timers[number], int(self._head.time_ns_r)
        if command == "START":
            if not timer.running_r:
                timer.started_ns_r = now
                timer.running_r = True
        elif command == "STOP":
            timer.counted_ns_r = _counted(timer, now)
            timer.running_r = False
        elif command == "CLEAR":
            timer.running_r = False
            timer.counted_ns_r = 0
        return min(_counted(timer, now) // 1_000_000, GREATEST_MS)

    def latch(self, number: int) -> None:
        """Keep the present count for whoever reads it later: READ on the path."""
        if 0 <= number < TIMERS:
            self._timers[number].latched_r = self.act("READ", number)

    def latched(self, number: int) -> int:
        """The count kept by the last `latch`, ms."""
        return int(self._timers[number].latched_r) if 0 <= number < TIMERS else 0


def _counted(timer: Timer, now: int) -> int:
    counted = int(timer.counted_ns_r)
    return counted + max(now - int(timer.started_ns_r), 0) if timer.running_r else counted
