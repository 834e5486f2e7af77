"""The mode unit: legal steps, jobs of several steps, and refusals that leave everything as it was."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.layout import Mode, State
from runtime.hli.modes import STEPS, Action, Refusal, Transition, Wish, Work, next_step, work_of


def carry_out(mode: Mode, state: State, wish: Wish | None) -> tuple[list[Action], Mode, State, str]:
    """Do all steps, each successful; the actions, where they led, and which program was loaded."""
    actions, loaded = [], ""
    while wish is not None:
        step = next_step(mode, state, wish)
        if step is None:
            break
        assert isinstance(step, Transition), step
        actions.append(step.action)
        loaded = step.parameter or loaded
        mode, state, wish = step.mode, step.state, step.rest
        assert len(actions) < 10
    return actions, mode, state, loaded


@pytest.mark.spec("hli.mode.unit", "hli.mode.automatic", "hli.mode.standby", "hli.ch.cu.program-start-abort")
def test_start_from_standby_selects_loads_and_starts() -> None:
    actions, mode, state, loaded = carry_out(
        Mode.STANDBY, State.SELECTED, Wish(Mode.AUTOMATIC, State.ACTIVE, "plate.nc")
    )
    assert actions == [Action.SELECT, Action.LOAD, Action.START]
    assert (mode, state, loaded) == (Mode.AUTOMATIC, State.ACTIVE, "plate.nc")


@pytest.mark.parametrize(
    ("state", "to_state", "parameter", "actions"),
    [
        (State.SELECTED, State.READY, "a.nc", [Action.LOAD]),
        (State.READY, State.ACTIVE, "", [Action.START]),
        (State.READY, State.ACTIVE, "b.nc", [Action.LOAD, Action.START]),
        (State.READY, State.READY, "b.nc", [Action.LOAD]),
        (State.READY, State.SELECTED, "b.nc", [Action.UNLOAD]),
        (State.ACTIVE, State.HOLD, "", [Action.HOLD]),
        (State.HOLD, State.ACTIVE, "", [Action.CONTINUE]),
        (State.ACTIVE, State.SELECTED, "", [Action.ABORT]),
        (State.HOLD, State.SELECTED, "", [Action.ABORT]),
        (State.ERROR, State.SELECTED, "", [Action.RESET]),
        (State.ACTIVE, State.ACTIVE, "", []),
        (State.HOLD, State.HOLD, "", []),
    ],
)
@pytest.mark.spec("hli.mode.states")
def test_steps_inside_automatic(state: State, to_state: State, parameter: str, actions: list[Action]) -> None:
    done, mode, after, loaded = carry_out(Mode.AUTOMATIC, state, Wish(Mode.AUTOMATIC, to_state, parameter))
    assert (done, mode, after) == (actions, Mode.AUTOMATIC, to_state)
    assert loaded == (parameter if Action.LOAD in actions else "")


def test_a_ready_program_is_unloaded_before_the_mode_is_left() -> None:
    actions, mode, state, _ = carry_out(Mode.AUTOMATIC, State.READY, Wish(Mode.STANDBY, State.SELECTED))
    assert actions == [Action.UNLOAD, Action.SELECT]
    assert (mode, state) == (Mode.STANDBY, State.SELECTED)


@pytest.mark.parametrize(
    ("mode", "state", "wish", "entry"),
    [
        (Mode.STANDBY, State.SELECTED, Wish(Mode.MDI, State.ACTIVE), catalogue.MODE_NO_PROGRAM),
        (Mode.STANDBY, State.SELECTED, Wish(Mode.MANUAL, State.ACTIVE, "G200\r\nG0 X1"), catalogue.MODE_MANUAL_TEXT),
        (Mode.STANDBY, State.SELECTED, Wish(Mode.MANUAL, State.READY, "G0 X1"), catalogue.MODE_MANUAL_TEXT),
        (Mode.AUTOMATIC, State.ACTIVE, Wish(Mode.MANUAL, State.ACTIVE), catalogue.MODE_PROGRAM_RUNS),
        (Mode.STANDBY, State.SELECTED, Wish(99, 99), catalogue.MODE_NOT_AVAILABLE),
        (Mode.STANDBY, State.SELECTED, Wish(Mode.AUTOMATIC, 99), catalogue.MODE_TRANSITION),
        (Mode.STANDBY, State.SELECTED, Wish(Mode.STANDBY, State.ACTIVE, "a.nc"), catalogue.MODE_TRANSITION),
        (Mode.STANDBY, State.SELECTED, Wish(Mode.AUTOMATIC, State.ACTIVE), catalogue.MODE_NO_PROGRAM),
        (Mode.AUTOMATIC, State.SELECTED, Wish(Mode.AUTOMATIC, State.READY), catalogue.MODE_NO_PROGRAM),
        (Mode.AUTOMATIC, State.SELECTED, Wish(Mode.AUTOMATIC, State.HOLD), catalogue.MODE_TRANSITION),
        (Mode.AUTOMATIC, State.READY, Wish(Mode.AUTOMATIC, State.HOLD), catalogue.MODE_TRANSITION),
        (Mode.AUTOMATIC, State.ACTIVE, Wish(Mode.AUTOMATIC, State.READY), catalogue.MODE_TRANSITION),
        (Mode.AUTOMATIC, State.ACTIVE, Wish(Mode.AUTOMATIC, State.ACTIVE, "b.nc"), catalogue.MODE_PROGRAM_RUNS),
        (Mode.AUTOMATIC, State.HOLD, Wish(Mode.AUTOMATIC, State.ACTIVE, "b.nc"), catalogue.MODE_PROGRAM_RUNS),
        (Mode.AUTOMATIC, State.ACTIVE, Wish(Mode.STANDBY, State.SELECTED), catalogue.MODE_PROGRAM_RUNS),
        (Mode.AUTOMATIC, State.ERROR, Wish(Mode.AUTOMATIC, State.ACTIVE, "b.nc"), catalogue.MODE_RESET_FIRST),
        (Mode.AUTOMATIC, State.ERROR, Wish(Mode.STANDBY, State.SELECTED), catalogue.MODE_RESET_FIRST),
        (
            Mode.AUTOMATIC,
            State.SELECTED,
            Wish(Mode.AUTOMATIC, State.ACTIVE, "a.nc", from_state=State.READY),
            catalogue.MODE_FROM,
        ),
        (
            Mode.STANDBY,
            State.SELECTED,
            Wish(Mode.AUTOMATIC, State.ACTIVE, "a.nc", from_mode=Mode.AUTOMATIC),
            catalogue.MODE_FROM,
        ),
    ],
)
@pytest.mark.spec("hli.mode.unit", "hli.mode.states")
def test_refusals_name_the_reason(mode: Mode, state: State, wish: Wish, entry: ErrorEntry) -> None:
    refused = next_step(mode, state, wish)
    assert isinstance(refused, Refusal)
    assert refused.problem.entry is entry
    assert refused.problem.text  # every value that the text needs is there


def test_the_expected_start_counts_for_the_first_step_only() -> None:
    wish = Wish(Mode.AUTOMATIC, State.ACTIVE, "a.nc", from_mode=Mode.STANDBY, from_state=State.SELECTED)
    actions, *_ = carry_out(Mode.STANDBY, State.SELECTED, wish)
    assert actions == [Action.SELECT, Action.LOAD, Action.START]


_modes = st.sampled_from(list(Mode))


@given(
    mode=_modes,
    state=st.sampled_from([s for s in State if s is not State.DESELECTED]),
    to_mode=st.integers(0, 7),
    to_state=st.integers(0, 8),
    parameter=st.sampled_from(["", "a.nc", "G0 X1\r\nG200"]),
)
def test_an_order_is_either_refused_as_a_whole_or_reaches_its_end(
    mode: Mode, state: State, to_mode: int, to_state: int, parameter: str
) -> None:
    wish = Wish(to_mode, to_state, parameter)
    if mode is Mode.STANDBY and state not in (State.SELECTED, State.ERROR):
        return  # does not exist
    first = next_step(mode, state, wish)
    if isinstance(first, Refusal):
        assert first.problem.text
        return
    _, mode_after, state_after, _ = carry_out(mode, state, wish)
    assert (mode_after, state_after) == (to_mode, to_state)


@pytest.mark.parametrize(
    ("mode", "parameter", "content", "text"),
    [
        (Mode.AUTOMATIC, "plate.nc", "plate.nc", False),
        (Mode.MDI, "G0 X1", "G0 X1", True),
        (Mode.MANUAL, "", "G200", True),
        (Mode.MANUAL, "G91\nG200 X1", "G91\nG200 X1", True),
        (Mode.HOMING, "G74 X2 Z1", "G74 X2 Z1", True),
        (Mode.HOMING, "", "rpf.nc", False),
    ],
)
def test_what_a_mode_executes(mode: Mode, parameter: str, content: str, text: bool) -> None:
    actions, *_ = carry_out(Mode.STANDBY, State.SELECTED, Wish(mode, State.ACTIVE, parameter))
    assert actions == [Action.SELECT, Action.LOAD, Action.START]
    assert work_of(mode, parameter) == Work(mode, content, text)


def test_the_table_has_no_way_out_of_error_but_reset() -> None:
    assert [STEPS[key] for key in STEPS if key[0] is State.ERROR] == [(Action.RESET, State.SELECTED)]
