"""The master's CiA 402 state machine: tables, and the law that it never enables a drive that is not fit."""

from __future__ import annotations

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.drives import DriveState
from runtime.fieldbus import cia402
from runtime.fieldbus.cia402 import CONTROLWORDS, DriveControl, Wish, drive_state
from runtime.fieldbus.simulator.device_states import STATUSWORDS

DEFINED = {0x0000, 0x0002, 0x0006, 0x0007, 0x000F, 0x0080}
ENABLING = {cia402.SHUTDOWN, cia402.SWITCH_ON, cia402.ENABLE_OPERATION}
S = STATUSWORDS


@pytest.mark.parametrize(
    ("statusword", "state"),
    [
        (0x0000, DriveState.NOT_READY_TO_SWITCH_ON),
        (0x0020, DriveState.NOT_READY_TO_SWITCH_ON),
        (0x0250, DriveState.SWITCH_ON_DISABLED),
        (0x0240, DriveState.SWITCH_ON_DISABLED),
        (0x0231, DriveState.READY_TO_SWITCH_ON),
        (0x0233, DriveState.SWITCHED_ON),
        (0x1637, DriveState.OPERATION_ENABLED),
        (0x0617, DriveState.QUICK_STOP_ACTIVE),
        (0x023F, DriveState.FAULT_REACTION_ACTIVE),
        (0x001F, DriveState.FAULT_REACTION_ACTIVE),
        (0x0218, DriveState.FAULT),
        (0x0238, DriveState.FAULT),
        (0x0001, DriveState.NOT_READY_TO_SWITCH_ON),  # a pattern of no state
        (0x000C, DriveState.NOT_READY_TO_SWITCH_ON),
    ],
)
def test_status_words_tell_the_state(statusword: int, state: DriveState) -> None:
    assert drive_state(statusword) is state


def test_every_state_has_a_control_word_for_every_wish() -> None:
    assert set(CONTROLWORDS) == set(DriveState)
    for words in CONTROLWORDS.values():
        assert len(words) == len(Wish)
        assert set(words) <= DEFINED


def test_only_a_switched_on_drive_is_enabled_and_only_by_wish() -> None:
    for state, words in CONTROLWORDS.items():
        for wish, word in zip(Wish, words, strict=True):
            if word == cia402.ENABLE_OPERATION:
                assert wish is Wish.ENABLE
                assert state in (DriveState.SWITCHED_ON, DriveState.OPERATION_ENABLED)
            if word == cia402.FAULT_RESET:
                assert (state, wish) == (DriveState.FAULT, Wish.ACKNOWLEDGE)


def run(control: DriveControl, *steps: tuple[int, bool, bool, bool]) -> list[int]:
    words = []
    for statusword, enable, quick_stop, reset in steps:
        control.observe(statusword)
        words.append(control.order(enable, quick_stop, reset))
    return words


def test_enabling_goes_through_all_states() -> None:
    states = (S[s] for s in (DriveState.SWITCH_ON_DISABLED, DriveState.READY_TO_SWITCH_ON, DriveState.SWITCHED_ON))
    assert run(DriveControl(), *((s, True, False, False) for s in states)) == [0x0006, 0x0007, 0x000F]


def test_a_fault_that_goes_by_itself_does_not_enable_again() -> None:
    control = DriveControl()
    run(control, (S[DriveState.OPERATION_ENABLED], True, False, False), (S[DriveState.FAULT], True, False, False))
    words = run(control, *[(S[DriveState.SWITCH_ON_DISABLED], True, False, False)] * 3)
    assert words == [0, 0, 0]
    # withdrawing the enable and giving it again is consent
    words = run(control, *((S[DriveState.SWITCH_ON_DISABLED], enable, False, False) for enable in (False, True)))
    assert words == [0, cia402.SHUTDOWN]


def test_an_acknowledged_fault_lets_the_drive_come_back() -> None:
    control = DriveControl()
    run(control, (S[DriveState.FAULT], True, False, False))
    assert run(control, (S[DriveState.FAULT], True, False, True)) == [cia402.FAULT_RESET]
    assert run(control, (S[DriveState.SWITCH_ON_DISABLED], True, False, True)) == [cia402.SHUTDOWN]


def test_the_reset_bit_falls_again_and_needs_a_new_edge() -> None:
    control = DriveControl()
    words = run(control, *[(S[DriveState.FAULT], True, False, True)] * 30)
    assert words == [cia402.FAULT_RESET] * cia402.RESET_PULSE_CYCLES + [0] * (30 - cia402.RESET_PULSE_CYCLES)


def test_a_fault_that_goes_long_after_its_reset_went_by_itself() -> None:
    control = DriveControl()
    run(control, *[(S[DriveState.FAULT], True, False, True)] * (cia402.ACKNOWLEDGED_CYCLES + 2))
    assert run(control, (S[DriveState.SWITCH_ON_DISABLED], True, False, True)) == [0]


def test_a_held_reset_does_not_acknowledge_the_next_fault() -> None:
    control = DriveControl()
    run(control, (S[DriveState.FAULT], True, False, True), (S[DriveState.SWITCH_ON_DISABLED], True, False, True))
    assert run(control, (S[DriveState.FAULT], True, False, True)) == [0]


def test_a_drive_that_disables_itself_stays_disabled() -> None:
    control = DriveControl()
    run(control, (S[DriveState.OPERATION_ENABLED], True, False, False))
    words = run(control, *[(S[DriveState.SWITCH_ON_DISABLED], True, False, False)] * 2)
    assert control.locked
    assert words == [0, 0]


statuswords = st.one_of(st.sampled_from(sorted(STATUSWORDS.values())), st.integers(0, 0xFFFF))
steps = st.lists(st.tuples(statuswords, st.booleans(), st.booleans(), st.booleans()), max_size=60)


@settings(max_examples=300, deadline=None)
@given(steps)
def test_no_sequence_enables_a_faulted_drive_or_orders_something_undefined(
    sequence: list[tuple[int, bool, bool, bool]],
) -> None:
    control = DriveControl()
    faulted = False  # a fault that nobody has dealt with
    acknowledged = False
    reset_before = False
    for statusword, enable, quick_stop, reset in sequence:
        state = control.observe(statusword)
        word = control.order(enable, quick_stop, reset)
        assert word in DEFINED
        edge = reset and not reset_before
        reset_before = reset
        if state in cia402.FAULT_STATES:
            assert word in (0x0000, 0x0080)
            acknowledged = state is DriveState.FAULT and (acknowledged or edge)
            faulted = not acknowledged
        elif not enable or edge:
            faulted = False
        if state not in cia402.FAULT_STATES:
            acknowledged = False
        if faulted and state is not DriveState.OPERATION_ENABLED and state is not DriveState.SWITCHED_ON:
            assert word not in ENABLING, f"{word:#06x} in {state.name}"
        if word == cia402.ENABLE_OPERATION:
            assert enable
            assert not quick_stop
            assert not faulted
            assert state in (DriveState.SWITCHED_ON, DriveState.OPERATION_ENABLED)
        if word == cia402.FAULT_RESET:
            assert state is DriveState.FAULT
