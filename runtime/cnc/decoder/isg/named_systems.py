"""#CS ADD, SELECT, SET, DEL, TRACK: a stack of coordinate systems with names (programming manual 27907–28155).

#CS ADD [BASE] [..]   #CS ADD [PART] [..]   #CS ADD [HOLE] [..]     each lies in the one before
#CS SELECT [PART]                                                   programmed coordinates count in PART: BASE and PART
"""

from __future__ import annotations

import numpy as np

from runtime.cnc.decoder.coordinates import MAIN
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.coordinate_systems import id_of, placement_of, title
from runtime.cnc.decoder.isg.registry import StatementCall, statement, variable
from runtime.cnc.decoder.system_state import STACKED, System
from runtime.cnc.decoder.systems import (
    Changing,
    check_link,
    expect_main_axes,
    expect_no_machine_mode,
    new_system,
)
from runtime.cnc.geometry.frames import HERE, Frame
from runtime.cnc.language.isg.syntax import Form
from runtime.diagnostics.catalogue import coordinates as errors

_RESERVED = ("ACS", "MCS", "IMCS")
_OF_KINEMATICS = ("MCS", "IMCS")
_NAME_LENGTH = 8
_VALUES = "[<v1>,<v2>,<v3>,<p1>,<p2>,<p3>]"


def _expect_possible(x: Execution, call: StatementCall) -> None:
    expect_main_axes(x, title(call), call.column)
    expect_no_machine_mode(x, title(call), call.column)


def _name(call: StatementCall) -> str:
    name = id_of(call)
    if not name:
        raise call.error(errors.SYSTEM_VALUES, "", statement=title(call), what="the name is missing")
    return name


def _place(x: Execution, call: StatementCall) -> int:
    """Which of the stack, from 0. LineError for a name that it does not have."""
    name = _name(call)
    names = [system.name for system in x.systems.stack]
    if name not in names:
        known = ", ".join(names) or "none"
        raise call.error(errors.SYSTEM_UNKNOWN, "ID", name=name, statement=title(call), known=known, group="CS")
    return names.index(name)


def _placement(x: Execution, call: StatementCall) -> Frame:
    placement = placement_of(x, call)
    return HERE if placement is None else placement


@statement("CS ADD", "isg.cs.cs-add", syntax=f"#CS ADD [<name>] {_VALUES}", form=Form.SYSTEM)
def add(x: Execution, call: StatementCall) -> None:
    """A named coordinate system on top of the stack; coordinates count in it when it is selected."""
    _expect_possible(x, call)
    systems, name = x.systems, _name(call)
    if systems.groups["CS"].active:
        raise call.error(errors.SYSTEMS_MIXED, "", statement=title(call), other="a system of #CS ON")
    if name in _RESERVED:
        raise call.error(errors.NAME_RESERVED, "ID", name=name)
    if len(name) > _NAME_LENGTH:
        raise call.error(errors.NAME_LENGTH, "ID", name=name, limit=_NAME_LENGTH)
    if any(system.name == name for system in systems.stack):
        raise call.error(errors.NAME_TWICE, "ID", name=name)
    if len(systems.stack) >= STACKED:
        raise call.error(errors.DEFINITIONS_FULL, "", statement=title(call), limit=STACKED)
    systems.stack.append(new_system(x, name, _placement(x, call)))


@statement(
    "CS SELECT",
    "isg.cs.select",
    "isg.cs.select-mcs-imcs",
    syntax="#CS SELECT [<name>]",
    form=Form.SYSTEM,
    modal=True,
)
def select(x: Execution, call: StatementCall) -> None:
    """Programmed coordinates count in this system of the stack; those above wait. Offsets of systems that are left end."""
    _expect_possible(x, call)
    name = _name(call)
    if name in _OF_KINEMATICS:
        raise call.error(errors.NO_KINEMATICS, "ID", name=name)
    count = _place(x, call) + 1
    _select(x, call, count)


def _select(x: Execution, call: StatementCall, count: int) -> None:
    systems = x.systems
    for system in systems.stack[systems.selected : count]:
        check_link(x, system.placement, title(call), call.column)
    with Changing(x):
        for place in range(systems.selected, count):
            below = systems.stack[place]
            systems.stack[place] = new_system(x, below.name, below.placement)
        systems.selected = count


@statement("CS SET", "isg.cs.set", syntax=f"#CS SET [<name>] {_VALUES}", form=Form.SYSTEM)
def change(x: Execution, call: StatementCall) -> None:
    """Another place of a system of the stack; where the axes stand is told anew. Its offsets, and those above, stay."""
    _expect_possible(x, call)
    place, placement = _place(x, call), _placement(x, call)
    if place < x.systems.selected:
        check_link(x, placement, title(call), call.column)
    _replace(x, x.systems.stack[place], placement)


def _replace(x: Execution, system: System, placement: Frame) -> None:
    with Changing(x):
        system.placement = placement


@statement("CS DEL", "isg.cs.del")
def delete(x: Execution, call: StatementCall) -> None:
    """The topmost system of the stack ends; if it was selected, the one below it is."""
    _expect_possible(x, call)
    systems = x.systems
    if not systems.stack:
        _delete_unnamed(x, call)
        return
    with Changing(x):
        systems.stack.pop()
        systems.selected = min(systems.selected, len(systems.stack))


def _delete_unnamed(x: Execution, call: StatementCall) -> None:
    """Without a stack: the last system of #CS ON (the manual does so in line 27576)."""
    state = x.systems.groups["CS"]
    if not state.active:
        x.warn(errors.NOTHING_TO_END, call.column, statement=title(call))
        return
    with Changing(x):
        ended = state.active.pop()
    if ended.passing:
        state.defined.pop(ended.name, None)


@statement("CS DEL ALL", "isg.cs.del")
def delete_all(x: Execution, call: StatementCall) -> None:
    """All systems of the stack end."""
    _expect_possible(x, call)
    if not x.systems.stack:
        x.warn(errors.NOTHING_TO_END, call.column, statement=title(call))
        return
    with Changing(x):
        x.systems.stack.clear()
        x.systems.selected = 0


# ---------------------------------------------------------------------------------------------------- variables


def _total(letter: str, axis: int) -> None:
    @variable(
        f"V.G.SELECTED_CS.TRANS.{letter}",
        "isg.cs.selected-trans-vars",
        "shift of the active coordinate system against the machine, with all offsets",
        unit="mm, inch",
    )
    def read(x: Execution) -> float:
        frame, _ = x.systems.placement(x.coordinates.mirror_axis)
        if not x.systems.chain:
            return 0.0
        return x.shown_length(float(frame.origin[axis]))


for _axis, _letter in enumerate("XYZ"):
    _total(_letter, _axis)


@statement("CS TRACK", "isg.cs.track", syntax="#CS TRACK [<name>] [<x>,<y>,<z>]", form=Form.SYSTEM)
def track(x: Execution, call: StatementCall) -> None:
    """A system of the stack is shifted so that the place of the axes has these coordinates in it; nothing moves."""
    _expect_possible(x, call)
    place = _place(x, call)
    given = {argument.index: value for argument, value in call if argument.name != "ID"}
    if sorted(given) != list(range(MAIN)):
        raise call.error(errors.SYSTEM_VALUES, "", statement=title(call), what="it takes three coordinates")
    wanted = np.array([x.length(given[axis]) for axis in range(MAIN)])
    systems, system, signs = x.systems, x.systems.stack[place], x.coordinates.mirror_axis
    with Changing(x):
        selected, systems.selected = systems.selected, place + 1
        whole, _ = systems.placement(signs)
        own = np.array(system.layer.total(signs)[:MAIN]) if place < selected else np.zeros(MAIN)
        systems.selected = selected
        # there = whole.outer(own + wanted); the origin of the system has to move by what is missing, seen from below it
        missing = np.array(_tool_place(x)) - whole.outer(own + wanted)
        below = system.placement.rotation @ whole.rotation.T
        system.placement = Frame(system.placement.rotation, system.placement.origin + below @ missing)


def _tool_place(x: Execution) -> list[float]:
    """Where the tool tip is on the machine: without the offsets that belong to the machine, (3,)."""
    o = x.coordinates.offsets
    machine = x.coordinates.machine()
    return [machine[axis] - o.clamp[axis] - o.tool[axis] - o.measuring[axis] for axis in range(MAIN)]
