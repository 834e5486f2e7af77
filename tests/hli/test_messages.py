"""The handshake of messages for the PLC."""

from __future__ import annotations

import pytest

from runtime.hli.layout import MESSAGE_TEXT
from runtime.hli.memory import HliMemory
from runtime.hli.messages import INFORMATION, MESSAGE, MessagePort, MessageTaker, Waiting


def both(memory: HliMemory) -> tuple[MessagePort, MessageTaker]:
    channel = memory.hli.channels[0]
    channel.plc_present_w = True
    return MessagePort(channel), MessageTaker(channel)


def test_one_at_a_time_each_once_and_in_order(shared: HliMemory) -> None:
    port, taker = both(shared)
    request = shared.hli.channels[0].msg_mc_control.request_r
    for number, text in enumerate("abc", 1):
        port.put(Waiting(text, text == "b", number))
    assert taker.offered() is None
    seen, confirmed = [], []
    for _ in range(4):
        confirmed.append(port.poll())
        message = taker.offered()
        if message is not None:
            seen.append((message.text, message.information, request.typ))
            assert port.poll() == 0  # not before it is taken
            taker.take(message)
    assert seen == [("a", False, MESSAGE), ("b", True, INFORMATION), ("c", False, MESSAGE)]
    assert confirmed == [0, 1, 2, 3]
    assert port.waiting == 0


def test_messages_of_the_path_are_told_apart(shared: HliMemory) -> None:
    port, taker = both(shared)
    port.put(Waiting("decoded", False, 4))
    port.put(Waiting("on the path", False, 0))
    assert (port.waiting, port.waiting_of_path) == (2, 1)
    port.poll()
    offered = taker.offered()
    assert offered is not None
    taker.take(offered)
    assert port.poll() == 4
    assert (port.waiting, port.waiting_of_path) == (1, 1)


def test_a_message_that_was_withdrawn_is_not_taken_for_the_next_one(shared: HliMemory) -> None:
    port, taker = both(shared)
    port.put(Waiting("old", False, 1))
    port.poll()
    old = taker.offered()
    assert old is not None
    port.drop_all()
    assert taker.offered() is None
    port.put(Waiting("new", False, 2))
    port.poll()
    taker.take(old)  # late
    new = taker.offered()
    assert new is not None
    assert new.text == "new"
    assert port.poll() == 0


def test_long_texts_end_at_a_letter(shared: HliMemory) -> None:
    port, taker = both(shared)
    port.put(Waiting("ä" * 300, False, 1))
    port.poll()
    offered = taker.offered()
    assert offered is not None
    assert offered.text == "ä" * ((MESSAGE_TEXT - 1) // 2)


@pytest.mark.spec("hli.mech.operation-without-plc")
def test_nobody_there_takes_everything_at_once_also_what_was_out_already(shared: HliMemory) -> None:
    port, _ = both(shared)
    for number in (1, 2, 3):
        port.put(Waiting("x", False, number))
    port.poll()
    shared.hli.channels[0].plc_present_w = False  # it has logged off
    assert port.poll() == 3
    assert port.waiting == 0
    assert not shared.hli.channels[0].msg_mc_control.request_semaphor_rw
