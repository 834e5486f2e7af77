"""Clocks: a fixed grid, late cycles counted and left out, no drift."""

from __future__ import annotations

import signal
import time

import pytest

from runtime.scheduler import clock as clock_module
from runtime.scheduler.clock import Clock, RealTimeClock, VirtualClock

MS = 1_000_000


class HostTime:
    """The host's clock and sleep, under the test's control."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 5_000 * MS
        self.oversleep = 0
        self.interruptions = 0
        monkeypatch.setattr(time, "monotonic_ns", lambda: self.now)
        monkeypatch.setattr(clock_module, "_clock_nanosleep", lambda: self._sleep)

    def _sleep(self, kind: int, flags: int, due: object, remaining: object) -> bool:
        assert (kind, flags) == (time.CLOCK_MONOTONIC, 1)
        if self.interruptions:
            self.interruptions -= 1
            return True
        timespec = due._obj  # type: ignore[attr-defined]
        self.now = max(self.now, timespec.seconds * 1_000_000_000 + timespec.nanoseconds + self.oversleep)
        return False


@pytest.fixture
def host(monkeypatch: pytest.MonkeyPatch) -> HostTime:
    return HostTime(monkeypatch)


def test_cycles_are_one_period_apart(host: HostTime) -> None:
    clock = RealTimeClock(0.001)
    start = host.now
    for cycle in range(1, 4):
        host.now += 300_000  # work
        assert clock.wait() == 0
        assert clock.cycle == cycle
        assert host.now == start + 300_000 + cycle * MS  # the grid begins with the first wait
    assert clock.now() == pytest.approx(0.003)
    assert clock.overruns == 0


def test_one_late_wake_up_does_not_shift_the_next(host: HostTime) -> None:
    clock = RealTimeClock(0.001)
    clock.wait()
    host.oversleep = 40_000
    assert clock.wait() == 40_000
    host.oversleep = 0
    assert clock.wait() == 0
    assert clock.now_ns() == 3 * MS


def test_work_that_is_too_long_starts_the_next_cycle_at_once_and_late(host: HostTime) -> None:
    clock = RealTimeClock(0.001)
    clock.wait()
    host.now += 1_300_000
    assert clock.wait() == 300_000
    assert clock.overruns == 1
    host.now += 100_000
    assert clock.wait() == 0  # on the grid again
    assert clock.now_ns() == 3 * MS
    assert clock.overruns == 1


def test_periods_that_are_gone_are_counted_and_left_out(host: HostTime) -> None:
    clock = RealTimeClock(0.001)
    clock.wait()
    host.now += 4_250_000  # due times at 1, 2, 3 and 4 ms passed
    assert clock.wait() == 250_000
    assert (clock.overruns, clock.cycle) == (4, 2)
    clock.wait()
    assert clock.now_ns() == 6 * MS


def test_a_signal_does_not_end_the_sleep(host: HostTime) -> None:
    clock = RealTimeClock(0.001)
    host.interruptions = 3
    assert clock.wait() == 0
    assert clock.now_ns() == MS


def test_the_real_sleep_lasts_until_the_due_time() -> None:
    clock = RealTimeClock(0.002)
    clock.wait()
    before = time.monotonic_ns()
    for _ in range(5):
        clock.wait()
    if clock.overruns == 0:
        assert time.monotonic_ns() - before >= 4 * 2 * MS
    assert clock.cycle == 6
    assert clock.now() >= 0.012


def test_a_real_signal_is_handled_during_the_sleep() -> None:
    seen: list[int] = []
    old = signal.signal(signal.SIGALRM, lambda number, frame: seen.append(number))
    try:
        clock = RealTimeClock(0.05)
        signal.setitimer(signal.ITIMER_REAL, 0.005)
        clock.wait()
    finally:
        signal.signal(signal.SIGALRM, old)
    assert seen == [signal.SIGALRM]
    assert clock.now() >= 0.05


def test_virtual_time_is_exact_and_the_same_every_time() -> None:
    clock: Clock = VirtualClock(0.001)
    assert clock.now() == 0.0
    assert [clock.wait() for _ in range(1_000_000)].count(0) == 1_000_000
    assert clock.now() == 1000.0
    assert clock.now_ns() == 1000 * 1_000_000_000
    assert (clock.cycle, clock.overruns) == (1_000_000, 0)


@pytest.mark.parametrize("kind", [RealTimeClock, VirtualClock])
def test_a_period_is_positive(kind: type[RealTimeClock | VirtualClock]) -> None:
    with pytest.raises(ValueError, match="longer than 0"):
        kind(0.0)
