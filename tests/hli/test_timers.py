"""The counters of #TIMER."""

from __future__ import annotations

from runtime.hli.layout import Hli
from runtime.hli.timers import GREATEST_MS, Timers

MS = 1_000_000
HOUR = 3_600_000 * MS


def test_a_counter_counts_between_start_and_stop_and_goes_on_at_the_next_start() -> None:
    hli = Hli()
    timers, others = Timers(hli), Timers(hli)  # of another channel: the same counters

    def at(ms: float) -> None:
        hli.head.time_ns_r = int(ms * MS)

    at(100)
    assert timers.act("READ", 5) == 0
    assert timers.act("START", 5) == 0
    at(150.9)
    assert others.act("READ", 5) == 50
    assert timers.act("READ", 6) == 0
    at(200)
    assert timers.act("START", 5) == 100  # runs already
    at(300)
    assert others.act("STOP", 5) == 200
    at(400)
    assert timers.act("STOP", 5) == 200
    assert timers.act("START", 5) == 200
    at(450)
    assert timers.act("READ", 5) == 250
    assert timers.act("CLEAR", 5) == 0
    at(500)
    assert timers.act("READ", 5) == 0  # stopped too


def test_what_was_latched_stays_until_the_next_time() -> None:
    hli = Hli()
    timers = Timers(hli)
    timers.act("START", 0)
    hli.head.time_ns_r = 7 * MS
    timers.latch(0)
    hli.head.time_ns_r = 9 * MS
    timers.act("CLEAR", 0)
    assert timers.latched(0) == 7


def test_a_counter_ends_at_1193_hours() -> None:
    hli = Hli()
    timers = Timers(hli)
    timers.act("START", 127)
    hli.head.time_ns_r = 1193 * HOUR
    assert timers.act("READ", 127) == 1193 * 3_600_000
    hli.head.time_ns_r = 1194 * HOUR
    assert timers.act("READ", 127) == GREATEST_MS
    timers.latch(127)
    assert timers.latched(127) == GREATEST_MS


def test_numbers_that_do_not_exist_do_nothing() -> None:
    timers = Timers(Hli())
    for number in (-1, 128):
        assert timers.act("START", number) == 0
        timers.latch(number)
        assert timers.latched(number) == 0
