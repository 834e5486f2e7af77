"""The handshake of an external tool management: nothing is lost, nothing is taken for the answer to something else."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.hli.layout import Channel
from runtime.hli.tools import (
    Identity,
    ManagedTool,
    RequestKind,
    ToolLife,
    ToolLifePort,
    ToolOrder,
    ToolRequests,
    ToolStore,
)

DATA, PREPARE, SAVE = RequestKind.DATA, RequestKind.PREPARE, RequestKind.SAVE


def both() -> tuple[Channel, ToolRequests, ToolStore]:
    channel = Channel()
    channel.plc_present_w = True
    return channel, ToolRequests(channel), ToolStore(channel)


def taken(store: ToolStore) -> ToolOrder:
    order = store.take()
    assert order is not None
    return order


def test_requests_are_taken_in_their_order_and_answered() -> None:
    _, decoder, plc = both()
    assert plc.take() is None
    decoder.ask(SAVE, Identity(1), (1.5, 2.5))
    number = decoder.ask(DATA, Identity(7, 2, 3))
    saved = taken(plc)
    assert (saved.kind, saved.id, saved.parameters[:3]) == (SAVE, Identity(1), [1.5, 2.5, 0.0])
    assert plc.take() is None  # the next one comes when the decoder looks again
    assert decoder.answered(number) is None
    order = taken(plc)
    assert (order.kind, order.id) == (DATA, Identity(7, 2, 3))
    plc.give(order, ManagedTool(Identity(7, 2), radius=5.0, parameters=(3.0,)))
    answer = decoder.answered(number)
    assert answer is not None
    assert answer.tool is not None
    assert (answer.tool.radius, answer.tool.id, answer.tool.parameters[0]) == (5.0, Identity(7, 2), 3.0)


def test_a_refusal_carries_its_reason() -> None:
    _, decoder, plc = both()
    number = decoder.ask(DATA, Identity(7))
    plc.refuse(taken(plc), "worn out")
    answer = decoder.answered(number)
    assert answer is not None
    assert (answer.tool, answer.reason) == (None, "worn out")


def test_a_late_answer_is_not_taken_for_another_request() -> None:
    _, decoder, plc = both()
    decoder.ask(DATA, Identity(7))
    late = taken(plc)
    decoder.forget()
    number = decoder.ask(DATA, Identity(8))
    plc.give(late, ManagedTool(Identity(7)))
    assert decoder.answered(number) is None
    plc.give(taken(plc), ManagedTool(Identity(8)))
    answer = decoder.answered(number)
    assert answer is not None
    assert answer.tool is not None
    assert answer.tool.id == Identity(8)


def test_what_was_withdrawn_is_not_there_any_more() -> None:
    _, decoder, plc = both()
    decoder.ask(PREPARE, Identity(1))
    decoder.ask(DATA, Identity(1))
    decoder.forget()
    assert plc.take() is None


def test_of_several_announcements_only_the_last_one_waits() -> None:
    _, decoder, plc = both()
    for basic in range(1, 100):
        decoder.ask(PREPARE, Identity(basic))
    assert taken(plc).id == Identity(1)
    decoder.hand_over()
    assert taken(plc).id == Identity(99)
    decoder.hand_over()
    assert plc.take() is None


def test_without_a_plc_nothing_waits() -> None:
    channel, decoder, plc = both()
    channel.plc_present_w = False
    assert not decoder.present
    decoder.ask(DATA, Identity(1))
    channel.plc_present_w = True
    decoder.hand_over()
    assert plc.take() is None


@given(
    st.floats(-1000, 1000),
    st.lists(st.floats(-1000, 1000), max_size=32),
    st.floats(0, 30_000),
    st.lists(st.floats(allow_nan=False), max_size=60),
)
def test_a_tool_goes_over_as_it_is(radius: float, offsets: list[float], speed: float, parameters: list[float]) -> None:
    _, decoder, plc = both()
    number = decoder.ask(DATA, Identity(1))
    plc.give(
        taken(plc), ManagedTool(Identity(1), radius, radius, offsets, max_speed=speed, parameters=parameters, type=2)
    )
    answer = decoder.answered(number)
    assert answer is not None
    assert answer.tool is not None
    tool = answer.tool
    assert [tool.radius, tool.length] == pytest.approx([radius, radius], abs=6e-5)
    assert list(tool.offsets[: len(offsets)]) == pytest.approx(offsets, abs=6e-5)
    assert tool.max_speed == pytest.approx(speed, abs=1e-3)
    assert list(tool.parameters[: len(parameters)]) == parameters
    assert not any(tool.parameters[len(parameters) :])
    assert tool.type == 2


# -- tool life -----------------------------------------------------------------------------------------------------


def test_reports_of_tool_life_are_handed_over_one_by_one() -> None:
    channel, _, plc = both()
    port = ToolLifePort(channel)
    for basic in (1, 2):
        port.put(ToolLife(Identity(basic), 1.5 * basic, 20.25 * basic))
    assert plc.take_life() is None
    found = []
    for _ in range(4):
        port.step()
        found.append(plc.take_life())
    first, second, *rest = found
    assert rest == [None, None]
    assert first is not None
    assert second is not None
    assert (first.id, second.id) == (Identity(1), Identity(2))
    assert [first.time, second.time] == [1.5, 3.0]
    assert [first.distance, second.distance] == pytest.approx([20.25, 40.5])


def test_reports_that_nobody_takes_are_counted_and_without_a_plc_there_are_none() -> None:
    channel, _, plc = both()
    port = ToolLifePort(channel)
    for _ in range(20):
        port.put(ToolLife(Identity(1), 1.0, 1.0))
    assert port.lost == 4
    port.step()
    channel.plc_present_w = False
    port.step()
    port.put(ToolLife(Identity(2), 1.0, 1.0))
    port.step()
    assert plc.take_life() is None
