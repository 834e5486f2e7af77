"""The mode unit: which mode and state may follow which, and how an order is carried out step by step.

An order names where to; the way there may have several steps (select AUTOMATIC, load the program, start it).
`next_step` finds the next of them; the channel carries it out, and asks again with what is left of the order when the
step is done. Nothing here keeps state: mode and state are the channel's.

    DESELECTED ──select──▶ SELECTED ──load──▶ READY ──start──▶ ACTIVE ◀─continue── HOLD
                              ▲                 │               │  └─────hold──────▶ │
                              └─────unload──────┴────abort──────┴────────abort───────┘
                              └──reset── ERROR ◀── any state, on an error
"""

from __future__ import annotations

import re
from dataclasses import dataclass, replace
from enum import Enum, auto

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Problem
from runtime.hli.layout import Mode, State

# What is loaded where the order names nothing: a text of NC blocks, in HOMING the name of a program
DEFAULT_PARAMETER = {Mode.MANUAL: "G200", Mode.HOMING: "rpf.nc"}
_ENDS_BY_HAND = re.compile(r"\bG0*200\b[^;(\r\n]*$", re.IGNORECASE)


class Action(Enum):
    """What the channel does in a step."""

    SELECT = auto()  # change the mode
    LOAD = auto()  # open the program named by the parameter
    START = auto()
    HOLD = auto()
    CONTINUE = auto()
    UNLOAD = auto()  # forget the loaded program
    ABORT = auto()  # stop on the path, end the program
    RESET = auto()


@dataclass(frozen=True, slots=True)
class Wish:
    """An order of the mode unit; `from_mode` and `from_state` 0 are not checked."""

    to_mode: int
    to_state: int
    parameter: str = ""  # NC program, in MDI, MANUAL and HOMING NC blocks; needed to load
    from_mode: int = 0
    from_state: int = 0


@dataclass(frozen=True, slots=True)
class Transition:
    """One step: do `action`; then the channel is in `mode` and `state`, and `rest` is still to be done (None:
    finished)."""

    action: Action
    mode: Mode
    state: State
    parameter: str = ""
    rest: Wish | None = None


@dataclass(frozen=True, slots=True)
class Refusal:
    """The order is not carried out; mode and state stay."""

    problem: Problem


# Every mode but STANDBY: (state, wanted state) -> (action, state after it). A step that does not reach the wanted one is a step
# on the way.
STEPS: dict[tuple[State, State], tuple[Action, State]] = {
    (State.SELECTED, State.READY): (Action.LOAD, State.READY),
    (State.SELECTED, State.ACTIVE): (Action.LOAD, State.READY),
    (State.READY, State.ACTIVE): (Action.START, State.ACTIVE),
    (State.READY, State.SELECTED): (Action.UNLOAD, State.SELECTED),
    (State.ACTIVE, State.HOLD): (Action.HOLD, State.HOLD),
    (State.ACTIVE, State.SELECTED): (Action.ABORT, State.SELECTED),
    (State.HOLD, State.ACTIVE): (Action.CONTINUE, State.ACTIVE),
    (State.HOLD, State.SELECTED): (Action.ABORT, State.SELECTED),
    (State.ERROR, State.SELECTED): (Action.RESET, State.SELECTED),
}

PROGRAM_END: dict[State, State] = {State.ACTIVE: State.SELECTED}  # what the end of the program makes of the state
RUNNING = (State.ACTIVE, State.HOLD)


def next_step(mode: Mode, state: State, wish: Wish) -> Transition | Refusal | None:
    """The next step towards `wish` from `mode` and `state`; None if there is nothing left to do."""
    if refusal := _refuse(mode, state, wish):
        return refusal
    to_mode, to_state = Mode(wish.to_mode), State(wish.to_state)
    if to_mode != mode:
        if state is State.READY:
            return Transition(Action.UNLOAD, mode, State.SELECTED, rest=_after_first(wish))
        return _step(Action.SELECT, to_mode, State.SELECTED, wish)
    if state is State.READY and wish.parameter and to_state in (State.READY, State.ACTIVE):  # another program
        return _step(Action.LOAD, mode, State.READY, replace(wish, parameter=""), wish.parameter)
    if state is to_state:
        return None
    action, after = STEPS[state, to_state]
    if action is Action.LOAD:
        return _step(action, mode, after, replace(wish, parameter=""), wish.parameter)
    return _step(action, mode, after, wish)


def _step(action: Action, mode: Mode, after: State, wish: Wish, parameter: str = "") -> Transition:
    rest = None if (after == wish.to_state and mode == wish.to_mode) else _after_first(wish)
    return Transition(action, mode, after, parameter, rest)


def _after_first(wish: Wish) -> Wish:
    return replace(wish, from_mode=0, from_state=0)  # only the first step starts where the order expects it


def _refuse(mode: Mode, state: State, wish: Wish) -> Refusal | None:
    """Everything that speaks against the order as a whole, so that none of it is done by half."""
    names: dict[str, object] = {"mode": mode.name, "state": state.name}
    if wish.to_mode not in list(Mode):
        return Refusal(Problem(catalogue.MODE_NOT_AVAILABLE, {"mode": _name(Mode, wish.to_mode)}))
    to: dict[str, object] = {"to_mode": _name(Mode, wish.to_mode), "to_state": _name(State, wish.to_state)}
    no_way = Refusal(Problem(catalogue.MODE_TRANSITION, names | to))
    if wish.from_mode not in (0, mode) or wish.from_state not in (0, state):
        expected: dict[str, object] = {
            "from_mode": _name(Mode, wish.from_mode or mode),
            "from_state": _name(State, wish.from_state or state),
        }
        return Refusal(Problem(catalogue.MODE_FROM, names | expected))
    if wish.to_state not in list(State) or wish.to_state in (State.DESELECTED, State.ERROR):
        return no_way
    to_mode, to_state = Mode(wish.to_mode), State(wish.to_state)
    if state is State.ERROR and (to_mode, to_state) != (mode, State.SELECTED):
        return Refusal(Problem(catalogue.MODE_RESET_FIRST))
    if to_mode is Mode.STANDBY and to_state is not State.SELECTED:
        return no_way
    if state in RUNNING:
        if to_mode != mode:
            return Refusal(Problem(catalogue.MODE_PROGRAM_RUNS, names | {"what": f"mode {to_mode.name}"}))
        if wish.parameter and to_state in (State.READY, State.ACTIVE):
            return Refusal(Problem(catalogue.MODE_PROGRAM_RUNS, names | {"what": f"start of {wish.parameter}"}))
    if to_mode != mode:
        state = State.SELECTED  # where the new mode begins
    if to_state is not state and (state, to_state) not in STEPS:
        return no_way
    if to_state in (State.READY, State.ACTIVE):
        if state is State.SELECTED and not wish.parameter and to_mode not in DEFAULT_PARAMETER:
            return Refusal(Problem(catalogue.MODE_NO_PROGRAM))
        if to_mode is Mode.MANUAL and wish.parameter and not _ENDS_BY_HAND.search(wish.parameter.strip()):
            return Refusal(Problem(catalogue.MODE_MANUAL_TEXT))
    return None


@dataclass(frozen=True, slots=True)
class Work:
    """What a mode executes when it is started: a program file, or the NC blocks themselves."""

    mode: Mode
    content: str
    text: bool  # the content is NC blocks


def work_of(mode: Mode, parameter: str) -> Work:
    """The work of `mode` with the parameter it was loaded with."""
    text = mode in (Mode.MDI, Mode.MANUAL) or (mode is Mode.HOMING and bool(parameter))
    return Work(mode, parameter or DEFAULT_PARAMETER.get(mode, ""), text)


def _name(of: type[Mode] | type[State], value: int) -> str:
    return of(value).name if value in list(of) else str(value)
