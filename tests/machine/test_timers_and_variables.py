"""Counters and external variables: at decoding time and on the path."""

from __future__ import annotations

from collections.abc import Iterator

import pytest

from runtime.cnc.blocks import Block, Dwell, ExternalWrite, Flush, FlushKind, TimerAction, TimerCommand
from runtime.cnc.decoder.outside import Outside
from runtime.config.machine import Machine
from runtime.hli.external import read_external
from tests.machine.scripted_blocks import Contour, Scripted, at


@pytest.mark.spec("isg.add.timer")
def test_a_counter_of_the_path_measures_the_path(demo: Machine) -> None:
    """From the cycle after the move to the one after the dwell: 0.5 s and what the gate takes."""
    read: list[int] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(100.0, 1)
        yield TimerAction(at(2), TimerCommand.START, 11)
        yield Dwell(at(3), 0.5)
        yield TimerAction(at(4), TimerCommand.READ, 11)
        yield Flush(at(5), FlushKind.WAIT)
        read.append(outside.latched(11))
        yield Dwell(at(6), 0.25)
        yield TimerAction(at(7), TimerCommand.STOP, 11)
        yield Dwell(at(8), 1.0)
        yield TimerAction(at(9), TimerCommand.READ, 11)
        yield Flush(at(10), FlushKind.WAIT)
        read.append(outside.latched(11))
        yield TimerAction(at(11), TimerCommand.CLEAR, 11)
        yield Flush(at(12), FlushKind.WAIT)
        read.append(outside.latched(11))  # until the next READ
        read.append(outside.timer(TimerCommand.READ, 11))

    first = Scripted(demo, script)
    first.finish()
    assert read[0] == pytest.approx(500, abs=3)
    assert read[1] == pytest.approx(750, abs=8)
    assert read[2:] == [read[1], 0]
    before = list(read)
    read.clear()
    Scripted(demo, script).finish()
    assert read == before


@pytest.mark.spec("isg.add.timer")
def test_a_counter_of_decoding_time_runs_ahead_of_the_path_and_goes_on_over_programs(demo: Machine) -> None:
    read: list[int] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        outside.timer(TimerCommand.START, 127)
        yield Dwell(at(1), 0.5)
        read.append(outside.timer(TimerCommand.READ, 127))  # decoded at once

    scripted = Scripted(demo, script)
    scripted.finish()
    assert read == [0]
    scripted.start()  # START of a counter that runs changes nothing
    scripted.finish()
    assert read[1] == pytest.approx(500, abs=8)


@pytest.mark.spec("isg.var.g-channel-state")
def test_the_cycles_of_the_interpolator_are_counted_and_are_the_same_in_every_run(demo: Machine) -> None:
    read: list[int] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        assert outside.operating_mode() == 2
        yield Flush(at(1), FlushKind.WAIT)
        read.append(outside.cycle())
        yield Dwell(at(2), 0.5)
        yield Flush(at(3), FlushKind.WAIT)
        read.append(outside.cycle())

    Scripted(demo, script).finish()
    assert (read[1] - read[0]) * demo.cycle.period == pytest.approx(0.5, abs=8e-3)
    before = list(read)
    read.clear()
    Scripted(demo, script).finish()
    assert read == before


def test_a_write_on_the_path_comes_where_it_stands(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield ExternalWrite(at(1), 16, "STRING", 20, "roughing")
        yield from contour.to(50.0, 2)
        yield ExternalWrite(at(3), 8, "REAL64", 8, 2.5)
        yield ExternalWrite(at(3), 24000, "SGN16", 2, 1e9)
        yield from contour.to(100.0, 4)

    scripted = Scripted(demo, script)
    area = scripted.simulation.outside.external
    assert len(area) == 65536
    scripted.until(lambda: scripted.x > 49.8)
    assert read_external(area, 8, "REAL64", 8) == 0.0
    assert read_external(area, 16, "STRING", 20) == "roughing"
    scripted.until(lambda: scripted.x > 50.0)
    assert read_external(area, 8, "REAL64", 8) == 2.5
    assert read_external(area, 24000, "SGN16", 2) == 32767  # as far as the type goes
    scripted.finish()


@pytest.mark.spec("hli.area.external-variables")
def test_values_are_zero_at_start_and_stay_over_programs_and_resets(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        outside.external[100] += 1
        yield ExternalWrite(at(1), 200, "UNS08", 1, 7)

    scripted = Scripted(demo, script)
    scripted.finish()
    area = scripted.simulation.outside.external
    assert sum(area) == 8
    scripted.hli.operator[0].reset_rw = True
    scripted.run(0.1)
    scripted.start()
    scripted.finish()
    assert (area[100], area[200]) == (2, 7)


def test_many_texts_wait_for_a_free_place(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(10.0, 1)
        for k in range(200):
            yield ExternalWrite(at(2), 8 * k, "STRING", 8, f"t{k}")
        yield from contour.to(0.0, 3)

    scripted = Scripted(demo, script)
    scripted.finish()
    area = scripted.simulation.outside.external
    assert [read_external(area, 8 * k, "STRING", 8) for k in range(200)] == [f"t{k}" for k in range(200)]
    assert scripted.alarms == []
