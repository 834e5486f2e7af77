"""What the cycle runs by: a real clock that sleeps until absolute times, or a virtual one that just counts.

    due     |         |         |         |         |        one period apart, on a fixed grid
    work    |####     |###########  #     |###      |
                                ^ the due time passed during the work: an overrun; the next cycle starts at once, late

A cycle that is late by a whole period or more leaves out what is gone, so that the cycles (and with them SYNC) stay on
the grid: no burst of cycles makes up for lost time. The machine then moves slower for a moment; it never moves faster.
"""

from __future__ import annotations

import ctypes
import os
import time
from collections.abc import Callable
from typing import Protocol

_CLOCK_MONOTONIC = 1
_TIMER_ABSTIME = 1
_NS = 1_000_000_000


class Clock(Protocol):
    """Gives the beat of the cycle. Times in s since the start of the clock, if not said otherwise."""

    period: float
    cycle: int  # cycles begun; 0 before the first wait()
    overruns: int  # due times that passed while work was still on

    def now(self) -> float:
        """Seconds since the start."""

    def now_ns(self) -> int:
        """Nanoseconds since the start."""

    def wait(self) -> int:
        """Sleep until the next cycle is due; returns by how many ns it starts late."""


class RealTimeClock:
    """CLOCK_MONOTONIC with absolute-time sleep: one late cycle does not shift those after it.

    The clock starts with the first `wait`, which returns one period later. `wait` releases the GIL and keeps nothing
    that it allocates.
    """

    def __init__(self, period: float) -> None:
        """`period` in s, more than 0; ValueError otherwise."""
        self._period_ns = round(period * _NS)
        if self._period_ns <= 0:
            raise ValueError(f"a period is longer than 0 s, not {period}")
        self.period = period
        self.cycle = 0
        self.overruns = 0
        self._start_ns = time.monotonic_ns()
        self._due_ns = 0  # on CLOCK_MONOTONIC; 0: not started
        self._due = _Timespec()
        self._due_pointer = ctypes.byref(self._due)
        self._sleep = _clock_nanosleep()

    def now(self) -> float:
        return (time.monotonic_ns() - self._start_ns) / _NS

    def now_ns(self) -> int:
        return time.monotonic_ns() - self._start_ns

    def wait(self) -> int:
        now = time.monotonic_ns()
        if self._due_ns == 0:
            self._start_ns = self._due_ns = now
        self._due_ns += self._period_ns
        if now > self._due_ns:
            gone = (now - self._due_ns) // self._period_ns
            self.overruns += gone + 1
            self._due_ns += gone * self._period_ns
        else:
            self._due.seconds, self._due.nanoseconds = divmod(self._due_ns, _NS)
            while self._sleep(_CLOCK_MONOTONIC, _TIMER_ABSTIME, self._due_pointer, None):
                pass  # EINTR: a signal came, its Python handler has run; the due time is still the same
            now = time.monotonic_ns()
        self.cycle += 1
        return max(0, now - self._due_ns)


class VirtualClock:
    """Time that passes when it is waited for, and only then: simulations are fast, and the same every time."""

    def __init__(self, period: float) -> None:
        """`period` in s, more than 0; ValueError otherwise."""
        self._period_ns = round(period * _NS)
        if self._period_ns <= 0:
            raise ValueError(f"a period is longer than 0 s, not {period}")
        self.period = period
        self.cycle = 0
        self.overruns = 0

    def now(self) -> float:
        return self.cycle * self._period_ns / _NS

    def now_ns(self) -> int:
        return self.cycle * self._period_ns

    def wait(self) -> int:
        self.cycle += 1
        return 0


class WallClockWatch:
    """Tells when the wall clock was set: it and the monotonic clock have gone by different amounts.

    Nothing moves by the wall clock; it only stands in what is told, and who compares times has to know. `wall` and `monotonic`
    give seconds; a step is at least `least` s within a call and the next one, so that slewing (NTP) is none.
    """

    def __init__(self, wall: Callable[[], float], monotonic: Callable[[], float], least: float = 1.0) -> None:
        self._wall, self._monotonic, self._least = wall, monotonic, least
        self._offset = wall() - monotonic()

    def step(self) -> float:
        """Seconds by which it was set since the last call, 0.0 if it was not."""
        before, self._offset = self._offset, self._wall() - self._monotonic()
        by = self._offset - before
        return by if abs(by) >= self._least else 0.0


class _Timespec(ctypes.Structure):
    _fields_ = (("seconds", ctypes.c_long), ("nanoseconds", ctypes.c_long))

    seconds: int
    nanoseconds: int


def _clock_nanosleep() -> ctypes._NamedFuncPointer:
    function = ctypes.CDLL(None).clock_nanosleep  # calls through CDLL release the GIL
    function.argtypes = (ctypes.c_int, ctypes.c_int, ctypes.c_void_p, ctypes.c_void_p)
    function.restype = _interrupted
    return function


def _interrupted(result: int) -> bool:
    """True for EINTR; clock_nanosleep returns the error number instead of setting errno."""
    if result not in (0, 4):
        raise OSError(result, os.strerror(result))
    return result == 4
