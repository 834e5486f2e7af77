"""Errors of the CNC on their way to the PLC. Filters of errors (P-CHAN-00380 …) are not there."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.errors import Problem, Reaction, Severity
from runtime.hli.describe import describe_machine
from runtime.hli.error_messages import WAITING, Body, ErrorMessage, ErrorPort, ErrorTaker
from runtime.hli.memory import HliMemory
from runtime.plc_logic.areas import ChannelPort
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc


def message(number: int) -> ErrorMessage:
    return ErrorMessage(number, f"error {number}", Severity.ERROR, Reaction.STOP_ON_PATH, axis=3)


def test_one_waits_until_it_is_taken_and_the_next_follows() -> None:
    memory = HliMemory.private()
    channel = memory.hli.channels[0]
    channel.plc_present_w = True
    port, taker = ErrorPort(channel), ErrorTaker(channel)
    assert taker.take() is None
    port.put(message(1))
    port.put(message(2))
    port.poll()
    port.poll()
    assert channel.mc_error.message_r.error_id_r == 1
    assert taker.take() == message(1)
    assert taker.take() is None, "the next one comes with the next cycle"
    port.poll()
    assert (channel.mc_error.sequence_r, channel.mc_error.message_r.body_type_r) == (2, Body.NONE)
    assert taker.take() == message(2)
    port.poll()
    assert taker.take() is None


@pytest.mark.spec("chan.channel-id")
@pytest.mark.parametrize(("own", "number"), [(0, 1), (7, 7)])
def test_an_error_tells_the_number_of_its_channel(demo: Machine, own: int, number: int) -> None:
    described = demo.channels[0]
    parameters = described.parameters.model_copy(update={"channel_id": own})
    machine = demo.model_copy(update={"channels": (described.model_copy(update={"parameters": parameters}),)})
    memory = HliMemory.private()
    describe_machine(memory.hli, machine)
    channel = memory.hli.channels[0]
    channel.plc_present_w = True
    port = ErrorPort(channel)
    port.put(message(1))
    port.poll()
    assert (channel.number_r, channel.mc_error.message_r.channel_r) == (number, number)


def test_of_too_many_the_first_ones_are_kept_and_nobody_gets_what_is_old() -> None:
    memory = HliMemory.private()
    channel = memory.hli.channels[0]
    port, taker = ErrorPort(channel), ErrorTaker(channel)
    port.put(message(0))
    port.poll()
    channel.plc_present_w = True
    port.poll()
    assert taker.take() is None, "it was told when no PLC was there"
    for number in range(WAITING + 5):
        port.put(message(number))
    taken = []
    for _ in range(WAITING + 5):
        port.poll()
        if (found := taker.take()) is not None:
            taken.append(found.id)
    assert taken == list(range(WAITING))
    assert channel.mc_error.left_out_r == 5


def test_the_plc_is_told_what_the_machine_and_the_program_have(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    port = ChannelPort(driven.hli.channels[0])
    while port.take_error() is not None:
        driven.watch(1)
    driven.simulation.controller.alarm(Problem(alarms.OFFSET_LEAVES, {"axis": "Y", "offset": 1.5}), axis=1)
    driven.watch(2)
    error = port.take_error()
    assert error is not None
    assert (error.id, error.axis, error.severity) == (alarms.OFFSET_LEAVES.id, 2, Severity.ERROR)
    assert error.reaction == alarms.OFFSET_LEAVES.reaction
    assert (error.program, error.line) == ("", 0)
    assert "Y" in error.text
    assert error.cycle == driven.simulation.controller.cycle_number - 2
    driven.reset()
    driven.watch(50)
    driven.start("%W\nN10 G01 X10 F1000\nN20 G01 X[1/0]\nN30 M30\n")
    driven.until_done()
    found = []
    while (error := port.take_error()) is not None:
        found.append(error)
        driven.watch(1)
    wrong = found[-1]
    assert wrong.line == 3
    assert wrong.program.endswith("w.nc")
    assert driven.hli.channels[0].mc_error.message_r.body_type_r == Body.NC_PROGRAM
