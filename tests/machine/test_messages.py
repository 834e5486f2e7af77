"""Messages of the NC program: when they go out, who gets them, and what waits for them."""

from __future__ import annotations

import json
from collections.abc import Iterator
from pathlib import Path

import pytest

from runtime.cnc.blocks import Block, Flush, FlushKind, Hold, Message, Receiver
from runtime.cnc.decoder.outside import Outside
from runtime.config.machine import Machine
from runtime.diagnostics.events import RECEIVERS, EventKind
from runtime.hli.layout import StopCondition
from runtime.plc_logic.areas import ChannelPort
from tests.machine.scripted_blocks import Contour, MessagePlc, Script, Scripted, at, speeds_at


def with_plc(demo: Machine, script: Script, *, takes: bool = False) -> tuple[Scripted, MessagePlc]:
    scripted = Scripted(demo, script, partner=lambda memory: MessagePlc(memory, takes=takes))
    plc = scripted.simulation.plc
    assert isinstance(plc, MessagePlc)
    return scripted, plc


def test_receivers_of_events_are_those_of_blocks() -> None:
    assert tuple(receiver.value for receiver in Receiver) == RECEIVERS


@pytest.mark.spec("isg.add.msg")
def test_a_message_of_the_path_comes_where_it_stands_and_slows_nothing(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)
        yield Message(at(2), "half way: ü", Receiver.HMI)
        yield from contour.to(100.0, 3)

    scripted = Scripted(demo, script)
    assert speeds_at(scripted, 50.0) == pytest.approx(100.0)
    (event,) = scripted.events(EventKind.MESSAGE)
    assert (event.text, event.line, event.n, RECEIVERS[event.number]) == ("half way: ü", 2, 20, "HMI")
    assert event.path_pos == pytest.approx(scripted.path.path_position)
    assert 50.0 <= event.path_pos < 50.2
    scripted.finish()


@pytest.mark.spec("isg.add.msg")
def test_a_message_of_decoding_time_comes_before_the_path_is_there(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)
        outside.tell(Message(at(2), "decoded"))

    scripted = Scripted(demo, script)
    scripted.run(0.01)
    (event,) = scripted.events(EventKind.MESSAGE)
    assert (event.text, event.line, RECEIVERS[event.number]) == ("decoded", 2, "ISG_DIAG_BED")
    assert event.path_pos < 1.0
    scripted.finish()


@pytest.mark.spec("hli.mech.message", "isg.add.msg", "isg.add.msg-info")
def test_the_plc_gets_them_in_order_one_at_a_time(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        outside.tell(Message(at(1), "one", Receiver.PLC))
        outside.tell(Message(at(1), "RED,20,BOLD", Receiver.PLC, information=True))
        yield Message(at(2), "two", Receiver.PLC)
        yield Message(at(3), "not for the PLC", Receiver.EVENT_LOGGER)
        yield Message(at(4), "BLUE", Receiver.PLC, information=True)
        yield from contour.to(10.0, 5)

    scripted, plc = with_plc(demo, script, takes=True)
    scripted.finish()
    scripted.run(0.1)
    assert plc.texts == ["one", "RED,20,BOLD", "two", "BLUE"]
    assert plc.information == [False, True, False, True]
    assert scripted.texts == ["one", "RED,20,BOLD", "two", "not for the PLC", "BLUE"]
    assert [event.value for event in scripted.events(EventKind.MESSAGE)] == [0.0, 1.0, 0.0, 0.0, 1.0]


@pytest.mark.spec("hli.mech.message", "isg.add.msg")
def test_the_path_stops_after_ten_messages_that_nobody_takes(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for k in range(1, 15):
            yield from contour.to(10.0 * k, k)
            yield Message(at(k), f"message {k}", Receiver.PLC)
        yield from contour.to(0.0, 20)

    scripted, plc = with_plc(demo, script)
    scripted.run(3.0)
    assert scripted.stop == StopCondition.MESSAGE
    assert scripted.x == pytest.approx(100.0)  # exactly there: the place of the tenth
    assert len(scripted.texts) == 10
    plc.takes = True
    scripted.finish()
    scripted.run(0.1)
    assert plc.texts == [f"message {k}" for k in range(1, 15)]


@pytest.mark.spec("isg.add.msg")
def test_messages_without_motion_pile_up_to_ten_as_well(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for k in range(300):
            yield Message(at(1), f"{k}", Receiver.PLC)
        yield from contour.to(5.0, 2)

    scripted, plc = with_plc(demo, script)
    scripted.run(2.0)
    assert len(scripted.texts) == 10
    plc.takes = True
    scripted.finish()
    scripted.run(0.1)
    assert plc.texts == [f"{k}" for k in range(300)]
    assert scripted.x == pytest.approx(5.0)


@pytest.mark.spec("isg.add.msg")
def test_a_path_in_motion_stops_for_messages_of_decoding_time_that_nobody_takes(demo: Machine) -> None:
    told: list[int] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(500.0, 1)
        for k in range(100):
            while not outside.room():
                yield Hold(at(2), "messages are taken")
            told.append(outside.tell(Message(at(2), f"{k}", Receiver.PLC)))

    scripted, plc = with_plc(demo, script)
    scripted.run(1.0)
    assert scripted.stop & StopCondition.MESSAGE
    assert scripted.path.standstill
    assert scripted.x < 100.0
    assert len(scripted.texts) == 10
    assert len(told) == 26  # and sixteen on their way
    plc.takes = True
    scripted.finish()
    scripted.run(0.1)
    assert plc.texts == [f"{k}" for k in range(100)]


def test_a_decoder_that_tells_without_end_loses_nothing(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for k in range(100):
            outside.tell(Message(at(1), f"{k}"))
        yield from contour.to(5.0, 2)

    scripted = Scripted(demo, script)
    scripted.finish()
    assert scripted.texts == [f"{k}" for k in range(100)]


@pytest.mark.parametrize("receiver", list(Receiver))
@pytest.mark.spec("hli.mech.message", "isg.add.msg")
def test_syn_ack_holds_the_path_until_its_receiver_has_taken_it(demo: Machine, receiver: Receiver) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)
        yield Message(at(2), "may I?", receiver, acknowledge=True)
        yield from contour.to(100.0, 3)

    scripted, plc = with_plc(demo, script)
    assert speeds_at(scripted, 50.0) == 0.0
    if receiver is Receiver.PLC:
        scripted.run(1.0)
        assert scripted.x == pytest.approx(50.0)
        assert scripted.stop == StopCondition.MESSAGE
        plc.takes = True
    scripted.finish()
    assert scripted.x == pytest.approx(100.0)
    assert scripted.texts == ["may I?"]


@pytest.mark.spec("hli.mech.message", "isg.add.msg")
def test_ack_holds_the_decoder_until_the_plc_has_taken_it(demo: Machine) -> None:
    went_on: list[str] = []

    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for receiver in (Receiver.HMI, Receiver.PLC):
            number = outside.tell(Message(at(1), "may I?", receiver))
            while not outside.taken(number):
                yield Hold(at(1), "acknowledgement")
            went_on.append(receiver.value)

    scripted, plc = with_plc(demo, script)
    scripted.run(1.0)
    assert went_on == ["HMI"]
    assert scripted.stop & StopCondition.PROGRAM_WAITS
    plc.takes = True
    scripted.finish()
    assert went_on == ["HMI", "PLC"]


@pytest.mark.spec("hli.mech.operation-without-plc")
def test_without_a_plc_messages_for_it_count_as_taken(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for k in range(30):
            yield Message(at(1), f"{k}", Receiver.PLC, acknowledge=k == 29)
        yield Flush(at(2), FlushKind.WAIT)
        yield from contour.to(5.0, 3)

    scripted = Scripted(demo, script)
    scripted.finish()
    assert scripted.texts == [f"{k}" for k in range(30)]


def test_a_message_at_the_end_of_a_program_waits_for_the_plc_beyond_it(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(5.0, 1)
        yield Message(at(2), "finished", Receiver.PLC)

    scripted, plc = with_plc(demo, script)
    scripted.finish()
    assert plc.texts == []
    plc.takes = True
    scripted.run(0.1)
    assert plc.texts == ["finished"]


def test_a_reset_withdraws_what_was_not_taken(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        for k in range(20):
            yield Message(at(1), f"{k}", Receiver.PLC)

    scripted, plc = with_plc(demo, script)
    scripted.run(0.2)
    unit = scripted.hli.channels[0].msg_mc_control
    assert unit.request_semaphor_rw
    scripted.hli.operator[0].reset_rw = True
    scripted.finish()
    assert not unit.request_semaphor_rw
    plc.takes = True
    scripted.run(0.1)
    assert plc.texts == []


@pytest.mark.spec("hli.mech.message")
def test_messages_of_the_plc_reach_the_operator_in_their_order(demo: Machine) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        yield from contour.to(50.0, 1)

    scripted, _ = with_plc(demo, script)
    port = ChannelPort(scripted.hli.channels[0])
    assert all(port.tell(f"text {number}", information=number == 2) for number in range(10))
    assert not port.tell("one too many")
    for _ in range(10):
        port.update()
        assert scripted.hli.channels[0].msg_mc_control.command_semaphor_rw
        port.update()  # the CNC has not taken it: nothing is written over
        scripted.run(0.001)
    told = [event for event in scripted.events(EventKind.MESSAGE) if event.text.startswith("text")]
    assert [(event.text, event.value) for event in told] == [(f"text {n}", float(n == 2)) for n in range(10)]
    assert {RECEIVERS[event.number] for event in told} == {"HMI"}
    assert {event.line for event in told} == {0}
    assert port.tell("there is room again")
    scripted.finish()


def test_trace_and_summary_have_the_messages(demo: Machine, tmp_path: Path) -> None:
    def script(contour: Contour, outside: Outside) -> Iterator[Block]:
        outside.tell(Message(at(1), "first"))
        yield Message(at(2), "second", Receiver.HMI, information=True)
        yield from contour.to(5.0, 3)

    scripted = Scripted(demo, script, trace=tmp_path)
    scripted.finish()
    scripted.simulation.close(scripted.simulation._result(scripted.simulation.time))
    events = [json.loads(line) for line in (tmp_path / "events.jsonl").read_text().splitlines()]
    messages = {event["text"]: event for event in events if event["event"] == "message"}
    assert {text: (m["line"], m["n"], m["receiver"]) for text, m in messages.items()} == {
        "first": (1, 10, "ISG_DIAG_BED"),
        "second": (2, 20, "HMI"),
    }
    rows = [json.loads(line) for line in (tmp_path / "blocks.jsonl").read_text().splitlines()]
    assert rows[0] == {
        "line": 2, "n": 20, "program": "script", "type": "message", "text": "second", "receiver": "HMI",
        "acknowledge": False, "information": True,
    }  # fmt: skip
    assert sorted(json.loads((tmp_path / "summary.json").read_text())["messages"]) == ["first", "second"]
