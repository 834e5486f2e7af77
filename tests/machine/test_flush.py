"""#FLUSH in its three kinds, and a decoder that holds: blocks in, path and link out."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path

import pytest

from runtime.cnc.blocks import (
    Block,
    Flush,
    FlushKind,
    Hold,
    Message,
    Receiver,
    Synch,
    Technology,
    TechnologyFunction,
)
from runtime.cnc.decoder.outside import Outside
from runtime.cnc.path_preparation import PumpState
from runtime.config.machine import Machine
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import StopCondition
from tests.machine.scripted_blocks import Contour, MessagePlc, Script, Scripted, at, positions, speeds_at
from tests.machine.scripted_plc import ScriptedPlc


@pytest.mark.parametrize(
    ("kind", "speed"), [(None, 100.0), (FlushKind.CONTINUE, 100.0), (FlushKind.STOP, 0.0), (FlushKind.WAIT, 0.0)]
)
@pytest.mark.spec("isg.add.flush", "isg.add.flush-continue")
def test_only_continue_passes_without_a_stop(demo: Machine, kind: FlushKind | None, speed: float) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)
        if kind is not None:
            yield Flush(at(2), kind)
        yield from contour.to(100.0, 3)

    scripted = Scripted(demo, script)
    assert speeds_at(scripted, 50.0) == pytest.approx(speed, abs=1e-6)
    scripted.finish()
    assert scripted.x == pytest.approx(100.0)
    assert scripted.alarms == []


@pytest.mark.spec("isg.add.flush")
def test_decoding_goes_on_over_a_flush_and_the_stop_is_short(demo: Machine) -> None:
    decoded: list[int] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)
        yield Flush(at(2), FlushKind.STOP)
        decoded.append(3)
        yield from contour.to(100.0, 3)

    scripted = Scripted(demo, script)
    assert scripted.x < 1.0
    assert decoded == [3]
    speeds_at(scripted, 50.0)
    cycles = 0
    while scripted.path.path_velocity == 0.0:
        scripted.simulation.cycle()
        cycles += 1
    assert cycles <= 3
    assert scripted.stop == StopCondition.NONE


@pytest.mark.spec("isg.add.flush-wait")
def test_the_decoder_goes_on_when_the_path_has_come_there_and_knows_where_the_axes_are(demo: Machine) -> None:
    seen: list[tuple[list[float], list[float]]] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for x in (40.0, 60.0):
            yield from contour.to(x, int(x))
            yield Flush(at(2), FlushKind.WAIT)
            seen.append((positions(outside.command_position()), positions(outside.actual_position())))

    scripted = Scripted(demo, script)
    speeds_at(scripted, 39.0)
    assert seen == []
    scripted.finish()
    assert [command for command, _ in seen] == [[40.0, 0.0, 0.0], [60.0, 0.0, 0.0]]
    assert [actual for _, actual in seen] == [[40.0, 0.0, 0.0], [60.0, 0.0, 0.0]]


@pytest.mark.spec("isg.add.flush-wait")
def test_real_axes_get_time_to_come_to_rest(demo: Machine) -> None:
    seen: list[tuple[float, bool]] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(20.0, 1)
        yield Flush(at(2), FlushKind.WAIT)
        actual = outside.actual_position()
        assert actual is not None
        seen.append((float(actual[0]), abs(float(actual[0]) - 20.0) <= demo.axes[0].in_position))

    scripted = Scripted(demo, script, ideal=False)
    scripted.finish()
    ((actual, near),) = seen
    assert near
    assert actual != 20.0  # really measured: a servo is not yet exactly there


@pytest.mark.parametrize("synch", [Synch.MOS, Synch.MNS_SNS])
@pytest.mark.spec("isg.add.flush-wait")
def test_functions_of_every_kind_must_have_been_taken(demo: Machine, synch: Synch) -> None:
    went_on: list[bool] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(10.0, 1)
        yield TechnologyFunction(at(2), Technology.M, 9, 0.0, synch)
        yield Flush(at(3), FlushKind.WAIT)
        went_on.append(True)

    scripted = Scripted(demo, script, partner=lambda memory: ScriptedPlc(memory, {(1, 9): None}))
    plc = scripted.simulation.plc
    assert isinstance(plc, ScriptedPlc)
    if synch is Synch.MOS:  # taking is all that is asked of it
        scripted.until(lambda: plc.taken == [(1, 9)])
        scripted.run(0.01)
        assert went_on
    else:
        scripted.run(1.0)
        assert scripted.stop & StopCondition.WAIT_TECHNOLOGY
        assert not went_on
        scripted.hli.channels[0].techno_unit_std_sync[0].done_w = True
        scripted.run(0.01)
        assert went_on
    scripted.finish()


@pytest.mark.spec("isg.add.flush-wait")
def test_a_mos_function_that_nobody_takes_holds_the_decoder(demo: Machine) -> None:
    went_on: list[bool] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield TechnologyFunction(at(2), Technology.M, 9, 0.0, Synch.MOS)
        yield Flush(at(3), FlushKind.WAIT)
        went_on.append(True)

    scripted = Scripted(demo, script, partner=lambda memory: MessagePlc(memory))
    scripted.run(0.5)
    assert scripted.stop & StopCondition.WAIT_TECHNOLOGY
    assert not went_on
    scripted.hli.channels[0].techno_unit_std_sync[0].please_rw = False  # taken
    scripted.run(0.01)
    assert went_on


@pytest.mark.spec("isg.add.flush-wait")
def test_messages_must_have_been_taken(demo: Machine) -> None:
    went_on: list[bool] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        outside.tell(Message(at(1), "first", Receiver.PLC))
        yield Message(at(2), "second", Receiver.PLC)
        yield Flush(at(3), FlushKind.WAIT)
        went_on.append(True)

    scripted = Scripted(demo, script, partner=lambda memory: MessagePlc(memory))
    plc = scripted.simulation.plc
    assert isinstance(plc, MessagePlc)
    scripted.run(0.5)
    assert scripted.stop == StopCondition.MESSAGE
    assert not went_on
    plc.takes = True
    scripted.finish()
    assert went_on
    assert plc.texts == ["first", "second"]


def test_an_abort_ends_a_flush_that_waits_and_the_next_program_runs(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield TechnologyFunction(at(1), Technology.M, 9, 0.0, Synch.MNS_SNS)
        yield Flush(at(2), FlushKind.WAIT)
        yield from contour.to(10.0, 3)

    scripted = Scripted(demo, script, partner=lambda memory: ScriptedPlc(memory, {(1, 9): None}))
    scripted.run(0.2)
    scripted.hli.operator[0].reset_rw = True
    scripted.finish()
    assert scripted.x == 0.0

    def other(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(30.0, 1)
        yield Flush(at(2), FlushKind.WAIT)

    scripted.script = other
    scripted.run(0.1)
    scripted.start()
    scripted.finish()
    assert scripted.x == pytest.approx(30.0)


# --------------------------------------------------------------------------------------------- hold


def waiting_for(value: int) -> Script:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(20.0, 1)
        while outside.external[0] != value:
            yield Hold(at(2), "V.E.A == 5")
        yield from contour.to(40.0, 3)

    return script


def test_a_decoder_that_holds_is_asked_again_in_every_cycle_and_the_path_before_it_runs(demo: Machine) -> None:
    scripted = Scripted(demo, waiting_for(5))
    scripted.until(lambda: scripted.x >= 20.0 - 1e-9)
    scripted.run(0.1)
    assert scripted.stop == StopCondition.NO_BLOCKS | StopCondition.PROGRAM_WAITS
    assert scripted.simulation.preparation.poll() is PumpState.HELD
    scripted.simulation.outside.external[0] = 5
    scripted.run(0.01)
    assert scripted.stop == StopCondition.NONE
    scripted.finish()
    assert scripted.x == pytest.approx(40.0)


def test_a_program_that_holds_at_its_first_block_tells_so_and_can_be_aborted(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        while True:
            yield Hold(at(1), "never")

    scripted = Scripted(demo, script)
    scripted.run(0.1)
    assert scripted.stop & StopCondition.PROGRAM_WAITS
    scripted.hli.operator[0].reset_rw = True
    scripted.finish()
    assert scripted.events(EventKind.RESET)


def test_two_runs_are_the_same_bytes(demo: Machine, tmp_path: Path) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield Message(at(1), "begins")
        yield from contour.to(20.0, 2)
        yield Flush(at(3), FlushKind.WAIT)
        outside.tell(Message(at(4), f"at {positions(outside.actual_position())} {outside.now()}", Receiver.PLC))
        yield Flush(at(5), FlushKind.STOP)
        yield from contour.to(0.0, 6)

    for name in "ab":
        scripted = Scripted(demo, script, trace=tmp_path / name)
        scripted.finish()
        scripted.simulation.close(scripted.simulation._result(scripted.simulation.time))
    for file in ("blocks.jsonl", "events.jsonl", "samples.npz", "summary.json"):
        assert (tmp_path / "a" / file).read_bytes() == (tmp_path / "b" / file).read_bytes()
