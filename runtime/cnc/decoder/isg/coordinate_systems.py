"""#CS, #ACS and #BCS: coordinate systems in space by their IDs (programming manual 26906–27523).

    #CS DEF [2] [10,0,5,0,0,45]    stored
    #CS ON [2]                     activated; [values] too: stored and activated
    #CS ON [10,0,5]                activated, and no longer known when it ends
    #CS OFF, #CS OFF ALL

Nothing moves. A system lies in the one that is active below it, by three shifts (mm, inch) and three angles (degrees).
"""

from __future__ import annotations

import numpy as np

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.motion import POSITION_LIMIT
from runtime.cnc.decoder.system_state import DEFINITIONS, Group, System
from runtime.cnc.decoder.systems import (
    Changing,
    check_link,
    expect_main_axes,
    expect_no_machine_mode,
    new_system,
)
from runtime.cnc.geometry.frames import HERE, SEQUENCES, Frame, rotation_of
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import coordinates as errors

_SHIFTS = 3
_COMPONENTS = 6
_GREATEST_ID = 2**31
_VALUES = "[<v1>,<v2>,<v3>,<p1>,<p2>,<p3>]"


def title(call: StatementCall) -> str:
    """The statement as it is written."""
    return "#" + call.syntax.name


def placement_of(x: Execution, call: StatementCall) -> Frame | None:
    """The frame that the values of a statement tell, None without any. LineError for too many of them."""
    values = [0.0] * _COMPONENTS
    given = False
    for argument, value in call:
        if argument.name == "ID":
            continue
        given = True
        if argument.index >= _COMPONENTS:
            raise call.error(errors.SYSTEM_VALUES, "", statement=title(call), what="there are more than six values")
        if not abs(value) <= POSITION_LIMIT:
            what = f"{value:g} is beyond ±{POSITION_LIMIT:.0f}"
            raise call.error(errors.SYSTEM_VALUES, "", statement=title(call), what=what)
        values[argument.index] = value
    if not given:
        return None
    shift = [x.length(value) for value in values[:_SHIFTS]]
    turned = rotation_of(values[_SHIFTS:], x.systems.sequence, fixed=x.systems.fixed)
    return Frame(turned, np.array(shift))


def id_of(call: StatementCall) -> str:
    """Number or name of the system, "" without."""
    argument = call.argument("ID")
    if argument is None:
        return ""
    if argument.value is None:
        return argument.text
    value = call.needed("ID")
    if not (0.5 <= value < _GREATEST_ID and abs(value - round_half_up(value)) < 1e-6):
        raise call.error(errors.SYSTEM_ID, "ID", value=value)
    return str(round_half_up(value))


def _known(x: Execution, name: str, group: Group) -> Frame | None:
    return group.defined.get(name) or x.systems.configured.get(name)


def _unknown(x: Execution, call: StatementCall, name: str, group: str) -> Exception:
    known = ", ".join((*x.systems.groups[group].defined, *x.systems.configured)) or "none"
    return call.error(errors.SYSTEM_UNKNOWN, "ID", name=name, statement=title(call), known=known, group=group)


def _define(x: Execution, call: StatementCall, group: str, name: str, placement: Frame) -> None:
    """Store a definition; one of a configured name is changed for all groups, until the program ends."""
    state = x.systems.groups[group]
    if name in x.systems.configured:
        x.systems.configured[name] = placement
        return
    if name not in state.defined and len(state.defined) >= DEFINITIONS:
        raise call.error(errors.DEFINITIONS_FULL, "", statement=title(call), limit=DEFINITIONS)
    state.define(name, placement)


def _expect_possible(x: Execution, call: StatementCall) -> None:
    expect_main_axes(x, title(call), call.column)
    expect_no_machine_mode(x, title(call), call.column)


def _activate(x: Execution, call: StatementCall, group: str) -> None:
    systems, state = x.systems, x.systems.groups[group]
    name, placement = id_of(call), placement_of(x, call)
    passing = not name and placement is not None
    if group == "CS" and systems.stack:
        raise call.error(errors.SYSTEMS_MIXED, "", statement=title(call), other="a stack of #CS ADD")
    if not name and placement is None:
        name = next(reversed(state.defined), "")
        if not name:
            raise call.error(errors.SYSTEM_NONE, "", statement=title(call), what="none is defined")
    found = placement if placement is not None else _known(x, name, state)
    if found is None:
        raise _unknown(x, call, name, group)
    check_link(x, found, title(call), call.column)
    if placement is not None:
        name = name or state.free_id()
        _define(x, call, group, name, placement)
    with Changing(x):
        state.active.append(new_system(x, name, found, passing=passing))


def _end(x: Execution, call: StatementCall, group: str, *, everything: bool) -> None:
    state = x.systems.groups[group]
    if call.argument("ID") is not None or any(True for _ in call):
        raise call.error(errors.OFF_WITH_ID, "", statement=title(call))
    if not state.active:
        x.warn(errors.NOTHING_TO_END, call.column, statement=title(call))
        return
    with Changing(x):
        ended = [state.active.pop() for _ in range(len(state.active) if everything else 1)]
    _forget(state, ended)


def _forget(state: Group, ended: list[System]) -> None:
    """Definitions that were made for an activation alone end with it."""
    for system in ended:
        if system.passing:
            state.defined.pop(system.name, None)


def _group(group: str, *specs: str) -> None:
    linked = ("isg.cs.linkage", "isg.cs.rotation-default") if group != "BCS" else ()

    @statement(f"{group} DEF", *specs, syntax=f"#{group} DEF [[<id>]] {_VALUES}", form=Form.SYSTEM)
    def define(x: Execution, call: StatementCall) -> None:
        """Store a coordinate system, under the next free ID if none is given."""
        _expect_possible(x, call)
        placement = placement_of(x, call)
        if placement is None:
            raise call.error(errors.SYSTEM_VALUES, "", statement=title(call), what="there are no values")
        _define(x, call, group, id_of(call) or x.systems.groups[group].free_id(), placement)

    @statement(
        f"{group} ON",
        *specs,
        *linked,
        "isg.cs.offsets-layer",
        "chan.cs.predefined",
        syntax=(f"#{group} ON", f"#{group} ON [<id>]", f"#{group} ON [[<id>]] {_VALUES}"),
        form=Form.SYSTEM,
        optional=True,
        modal=True,
    )
    def activate(x: Execution, call: StatementCall) -> None:
        """Programmed coordinates count in this coordinate system; without an argument the one that was defined last."""
        _expect_possible(x, call)
        _activate(x, call, group)

    @statement(f"{group} OFF", *specs, form=Form.SYSTEM, optional=True, modal=True)
    def end(x: Execution, call: StatementCall) -> None:
        """The system of this group that was activated last ends, with its offsets."""
        _expect_possible(x, call)
        _end(x, call, group, everything=False)

    @statement(f"{group} OFF ALL", *specs, "isg.cs.off-all", form=Form.SYSTEM, optional=True, modal=True)
    def end_all(x: Execution, call: StatementCall) -> None:
        """All systems of this group end."""
        _expect_possible(x, call)
        _end(x, call, group, everything=True)


_group("CS", "isg.cs.cs-def-on-off")
_group("ACS", "isg.cs.acs")
_group("BCS", "isg.cs.bcs")


def _store_active(group: str) -> None:
    @statement(
        f"{group} DEF ACT", "isg.cs.def-act", syntax=f"#{group} DEF ACT [[<id>]]", form=Form.SYSTEM, optional=True
    )
    def store(x: Execution, call: StatementCall) -> None:
        """Store what all active systems make together, without the offsets that are programmed in them."""
        _expect_possible(x, call)
        chain = x.systems.chain
        if not chain:
            raise call.error(errors.SYSTEM_NONE, "", statement=title(call), what="none is active")
        whole = HERE
        for system in chain:
            whole = whole.holding(system.placement)
        _define(x, call, group, id_of(call) or x.systems.groups[group].free_id(), whole)


_store_active("CS")
_store_active("ACS")

# ---------------------------------------------------------------------------------------------------- modes

_MODES = ("isg.cs.mode-rotation", "chan.cs.rotation", "isg.cs.axes-offsets-mode")


@statement(
    "CS MODE ON",
    *_MODES,
    syntax="#CS MODE ON [[ROTATION_SEQUENCE=..] [ROTATION_MODE_FIXED] [AXES_OFFSETS_LAYER_SPECIFIC]]",
    form=Form.KEYS,
    keys=(
        Key("ROTATION_SEQUENCE", KeyKind.WORD, SEQUENCES),
        Key("ROTATION_MODE_FIXED", KeyKind.FLAG),
        Key("AXES_OFFSETS_LAYER_SPECIFIC", KeyKind.FLAG),
    ),
    modal=True,
)
def mode_on(x: Execution, call: StatementCall) -> None:
    """How the angles of systems that are defined from here on count, and whether offsets of axes behind the main axes add up."""
    expect_no_machine_mode(x, title(call), call.column)
    systems = x.systems
    systems.sequence = call.text("ROTATION_SEQUENCE", systems.sequence) or systems.sequence
    systems.fixed |= call.given("ROTATION_MODE_FIXED")
    systems.specific |= call.given("AXES_OFFSETS_LAYER_SPECIFIC")


@statement(
    "CS MODE OFF",
    *_MODES,
    syntax="#CS MODE OFF [ROTATION_SEQUENCE | ROTATION_MODE_FIXED | AXES_OFFSETS_LAYER_SPECIFIC]",
    form=Form.KEYS,
    keys=tuple(
        Key(name, KeyKind.FLAG) for name in ("ROTATION_SEQUENCE", "ROTATION_MODE_FIXED", "AXES_OFFSETS_LAYER_SPECIFIC")
    ),
    modal=True,
)
def mode_off(x: Execution, call: StatementCall) -> None:
    """Sequence and mode of the rotation as they are configured; offsets of axes behind the main axes do not add up."""
    expect_no_machine_mode(x, title(call), call.column)
    systems = x.systems
    if call.given("ROTATION_SEQUENCE"):
        systems.sequence = systems.usual[0]
    if call.given("ROTATION_MODE_FIXED"):
        systems.fixed = systems.usual[1]
    if call.given("AXES_OFFSETS_LAYER_SPECIFIC"):
        systems.specific = False
