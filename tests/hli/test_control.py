"""Control units from the CNC's side: who commands, what is requested, what is in force."""

from __future__ import annotations

import itertools

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Problem
from runtime.hli.control import AxisCommands, Changes, ChannelCommands, ModeOrders, OneShot, sample_bool, sample_uns32
from runtime.hli.layout import BoolUnit, Hli, Mode, State, Uns32Unit
from runtime.hli.memory import HliMemory, get_text, put_text
from runtime.hli.modes import Wish


@pytest.fixture
def hli() -> Hli:
    return HliMemory.private().hli


@pytest.mark.spec("hli.mech.control-unit", "hli.mech.plc-present", "hli.mech.gui-redirect")
@pytest.mark.parametrize(("present", "enable", "command", "operator"), list(itertools.product([False, True], repeat=4)))
def test_the_plc_commands_only_what_it_has_claimed(present: bool, enable: bool, command: bool, operator: bool) -> None:
    unit = BoolUnit(enable_w=enable, command_w=command)
    in_force = sample_bool(unit, present, operator)
    assert in_force == (command if present and enable else operator)
    assert unit.state_r == in_force
    assert unit.request_r == operator, "the operator's wish is always to be seen"


def test_whole_numbers_go_the_same_way() -> None:
    unit = Uns32Unit(enable_w=True, command_w=700)
    assert sample_uns32(unit, False, 1000) == 1000
    assert sample_uns32(unit, True, 1000) == 700
    assert (unit.request_r, unit.state_r) == (1000, 700)


@pytest.mark.spec("hli.mech.operation-without-plc")
def test_without_a_plc_axes_are_released_and_override_is_full(hli: Hli) -> None:
    channel = ChannelCommands(hli.channels[0], hli.operator[0])
    axis = AxisCommands(hli.axes[0])
    channel.sample()
    axis.sample()
    assert (channel.override, channel.feed_hold, channel.single_block, channel.optional_stop) == (
        1,
        False,
        False,
        False,
    )
    assert (axis.drive_on, axis.release, axis.feed_hold, axis.override) == (True, True, False, 1)
    assert channel.modes.take(present=False) is None


@pytest.mark.spec("hli.mech.operation-without-plc", "hli.ax.cu.release-feedhold", "hli.ax.cu.feedhold")
def test_a_plc_may_serve_one_element_and_leave_the_rest(hli: Hli) -> None:
    axis = AxisCommands(hli.axes[0])
    hli.axes[0].plc_present_w = True
    hli.axes[0].control.release_feedhold.enable_w = True
    axis.sample()
    assert (axis.release, axis.drive_on, axis.feed_hold) == (False, True, False)
    assert not hli.axes[0].control.release_feedhold.state_r


@pytest.mark.spec("hli.ch.cu.override", "hli.sp.cu.override")
def test_override_is_limited_and_counts_only_if_valid(hli: Hli) -> None:
    channel = ChannelCommands(hli.channels[0], hli.operator[0], max_override=1200)
    hli.operator[0].override_w = 1500
    channel.sample()
    assert channel.override == 1.2
    assert hli.channels[0].control.override.state_r == 1200
    hli.channels[0].plc_present_w = True
    hli.channels[0].control.override_valid.enable_w = True  # commanded FALSE
    channel.sample()
    assert channel.override == 1.0
    axis = AxisCommands(hli.axes[3])
    hli.axes[3].plc_present_w = True
    hli.axes[3].control.override.enable_w = True
    hli.axes[3].control.override.command_w = 500
    axis.sample()
    assert axis.override == 0.5


@pytest.mark.spec("hli.ch.cu.feedhold", "hli.ch.cu.single-step", "hli.ch.cu.optional-stop", "hli.ch.cu.skip-levels")
def test_the_operator_switches_what_no_plc_claims(hli: Hli) -> None:
    channel = ChannelCommands(hli.channels[0], hli.operator[0])
    operator = hli.operator[0]
    operator.feedhold_w = operator.single_block_w = operator.optional_stop_w = True
    operator.program_block_ignore_w = 0b101
    channel.sample()
    assert (channel.feed_hold, channel.single_block, channel.optional_stop, channel.skip_levels) == (
        True,
        True,
        True,
        5,
    )
    hli.channels[0].plc_present_w = True
    hli.channels[0].control.feedhold.enable_w = True
    channel.sample()
    assert not channel.feed_hold
    assert hli.channels[0].control.feedhold.request_r
    assert channel.single_block


@pytest.mark.spec("hli.ch.cu.continue", "hli.ch.cu.reset")
def test_nothing_written_between_look_and_sampling_is_lost(hli: Hli) -> None:
    control = hli.channels[0].control
    changes = Changes(control, "feedhold", "reset")
    assert changes.look()  # the first time
    control.feedhold.command_w = True  # after the look, while the units are sampled
    assert changes.look()
    assert not changes.look()
    control.mode_and_state.enable_w = True  # not among the elements that are looked at
    assert not changes.look()
    control.reset.enable_w = True  # the last of them
    assert changes.look()


def test_sampling_goes_on_where_something_is_written(hli: Hli) -> None:
    axis = AxisCommands(hli.axes[0])
    assert axis.sample()
    while axis.sample():  # its own writes
        pass
    hli.axes[0].plc_present_w = True
    assert axis.sample()
    hli.axes[0].control.feedhold.command_w = hli.axes[0].control.feedhold.enable_w = True
    assert axis.sample()
    assert axis.feed_hold


def test_one_shots_act_once_per_order(hli: Hli) -> None:
    channel = ChannelCommands(hli.channels[0], hli.operator[0])
    hli.operator[0].reset_rw = True
    seen = []
    for _ in range(3):
        channel.sample()
        seen.append(channel.reset)
    assert seen == [True, False, False]
    assert not hli.operator[0].reset_rw, "the CNC takes the operator's flag"

    hli.channels[0].plc_present_w = True
    unit = hli.channels[0].control.reset
    unit.enable_w = unit.command_w = True
    seen = []
    for _ in range(3):
        channel.sample()
        seen.append(channel.reset)
    assert seen == [True, False, False]
    assert unit.state_r, "the PLC sees that it can take the command back"
    unit.command_w = False
    channel.sample()
    unit.command_w = True
    channel.sample()
    assert channel.reset


@pytest.mark.spec("hli.mech.gui-redirect")
def test_a_one_shot_that_the_plc_claims_is_only_requested(hli: Hli) -> None:
    unit, operator = hli.channels[0].control.continue_motion, hli.operator[0]
    one_shot = OneShot(unit, operator, "continue_motion_rw")
    unit.enable_w = True
    operator.continue_motion_rw = True
    assert not one_shot.sample(present=True)
    assert unit.request_r
    assert not operator.continue_motion_rw
    unit.command_w = True  # the PLC agrees
    assert one_shot.sample(present=True)
    assert not unit.request_r


def _order(hli: Hli, parameter: str) -> None:
    order = hli.operator[0].order_w
    order.to_mode, order.to_state = Mode.AUTOMATIC, State.ACTIVE
    put_text(order, "parameter", parameter)
    hli.operator[0].order_semaphor_rw = True


def _command(hli: Hli, parameter: str) -> None:
    unit = hli.channels[0].control.mode_and_state
    unit.enable_w = True
    unit.command_w.to_mode, unit.command_w.to_state = Mode.AUTOMATIC, State.ACTIVE
    put_text(unit.command_w, "parameter", parameter)
    unit.command_semaphor_rw = True


def _orders(hli: Hli) -> ModeOrders:
    return ModeOrders(hli.channels[0].control.mode_and_state, hli.operator[0])


@pytest.mark.spec("hli.mech.control-unit-usage-check", "hli.mode.unit")
def test_the_operators_order_is_answered_when_the_channel_has_decided(hli: Hli) -> None:
    orders = _orders(hli)
    _order(hli, "a.nc")
    taken = orders.take(present=False)
    assert taken is not None
    assert taken.wish == Wish(Mode.AUTOMATIC, State.ACTIVE, "a.nc")
    assert hli.operator[0].order_semaphor_rw, "no answer yet"
    assert orders.take(present=False) is None, "one order at a time"
    orders.answer(Problem(catalogue.MODE_NO_PROGRAM))
    assert not hli.operator[0].order_semaphor_rw
    assert hli.operator[0].answer_r == catalogue.MODE_NO_PROGRAM.id
    assert "program" in get_text(hli.operator[0], "answer_text_r")
    _order(hli, "b.nc")
    assert orders.take(present=False) is not None
    orders.answer()
    assert hli.operator[0].answer_r == 0


@pytest.mark.spec("hli.mech.control-unit-usage-check")
def test_a_command_is_taken_once_and_only_with_enable(hli: Hli) -> None:
    orders, unit = _orders(hli), hli.channels[0].control.mode_and_state
    _command(hli, "plc.nc")
    unit.enable_w = False
    assert orders.take(present=True) is None
    assert unit.command_semaphor_rw, "not taken: the PLC has not claimed the unit"
    unit.enable_w = True
    taken = orders.take(present=True)
    assert taken is not None
    assert (taken.wish.parameter, taken.by_operator) == ("plc.nc", False)
    assert not unit.command_semaphor_rw
    put_text(unit.command_w, "parameter", "later.nc")
    orders.answer()
    assert orders.take(present=True) is None, "data left behind has no further effect"


@pytest.mark.spec("hli.mech.gui-redirect", "hli.mech.control-unit-usage-check")
def test_a_claimed_unit_turns_orders_into_requests_one_by_one(hli: Hli) -> None:
    orders, unit = _orders(hli), hli.channels[0].control.mode_and_state
    unit.enable_w = True
    _order(hli, "first.nc")
    assert orders.take(present=True) is None
    assert unit.request_semaphor_rw
    assert get_text(unit.request_r, "parameter") == "first.nc"
    assert not hli.operator[0].order_semaphor_rw, "handed over"
    _order(hli, "second.nc")
    assert orders.take(present=True) is None
    assert get_text(unit.request_r, "parameter") == "first.nc", "never overwritten"
    assert hli.operator[0].order_semaphor_rw
    unit.request_semaphor_rw = False  # the PLC has copied it
    orders.take(present=True)
    assert get_text(unit.request_r, "parameter") == "second.nc"


def test_a_request_is_dropped_when_the_plc_is_gone_and_carried_out_when_it_gives_the_unit_back(hli: Hli) -> None:
    orders, unit = _orders(hli), hli.channels[0].control.mode_and_state
    unit.enable_w = True
    _order(hli, "a.nc")
    orders.take(present=True)
    assert orders.take(present=False) is None, "nothing starts because the PLC went away"
    assert not unit.request_semaphor_rw
    _order(hli, "b.nc")
    orders.take(present=True)
    unit.enable_w = False
    taken = orders.take(present=True)
    assert taken is not None
    assert taken.wish.parameter == "b.nc"


@pytest.mark.spec("hli.mech.control-unit-usage-check")
@given(
    st.lists(st.sampled_from(["operator", "plc", "claim", "give back", "copy", "take", "take", "answer"]), max_size=60)
)
def test_no_order_is_lost_or_carried_out_twice(script: list[str]) -> None:
    """Whatever the order of events: what was handed in comes out once, per giver in the order of handing in."""
    hli = HliMemory.private().hli
    orders, unit, operator = _orders(hli), hli.channels[0].control.mode_and_state, hli.operator[0]
    numbers = itertools.count()
    given_in: dict[str, list[str]] = {"o": [], "p": []}
    out: dict[str, list[str]] = {"o": [], "p": []}

    def take() -> None:
        if (order := orders.take(present=True)) is not None:
            out[order.wish.parameter[0]].append(order.wish.parameter)
            orders.answer()

    def hand_in(giver: str) -> None:
        name = f"{giver}{next(numbers)}"
        given_in[giver].append(name)
        (_order if giver == "o" else _command)(hli, name)

    for event in [*script, "give back", "take", "take", "take", "take"]:
        if event == "operator" and not operator.order_semaphor_rw:
            hand_in("o")
        elif event == "plc" and not unit.command_semaphor_rw:
            hand_in("p")
        elif event == "claim":
            unit.enable_w = True
        elif event == "give back" and not unit.command_semaphor_rw:
            unit.enable_w = False
        elif event == "copy" and unit.request_semaphor_rw and not unit.command_semaphor_rw:
            unit.command_w = unit.request_r
            unit.request_semaphor_rw = False
            unit.enable_w = unit.command_semaphor_rw = True
        elif event in ("take", "answer"):
            take()
    unit.enable_w = bool(unit.command_semaphor_rw)
    take()
    unit.enable_w = False
    take()
    take()
    assert out == given_in
