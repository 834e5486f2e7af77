"""#CONTROL AREA: work spaces that the tool may not leave, protection spaces that it may not enter (manual 16429–16626)."""

from __future__ import annotations

from runtime.cnc.decoder.additions import expect_no_line
from runtime.cnc.decoder.control_areas import OpenArea, activate, tell
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import control_areas as errors
from runtime.diagnostics.catalogue import language as catalogue

_DEFINE, _SELECT, _CLEAR = (f"isg.add.control-area-{name}" for name in ("define", "select", "clear"))
MOST = 20
_GREATEST_ID = 2**31
_ID = (Key("ID"),)
_FLAGS = ("WORK", "PROT", "POLY", "CIRC")


def _id(call: StatementCall) -> int | None:
    value = call.number("ID")
    if value is None:
        return None
    if not (-0.5 < value < _GREATEST_ID and abs(value - round_half_up(value)) < 1e-6):
        raise call.error(errors.SPACE_ID, "ID", value=value)
    return round_half_up(value)


def _known(x: Execution, call: StatementCall) -> int | None:
    """The ID of a defined area, None if none is given."""
    number = _id(call)
    if number is not None and number not in x.memory.control_areas:
        raise call.error(errors.SPACE_UNKNOWN, "ID", number=number)
    return number


def _expect_closed(x: Execution, call: StatementCall) -> None:
    if x.open_area is not None:
        raise call.error(errors.SPACE_TWICE, "", line=x.open_area.line)


@statement(
    "CONTROL AREA BEGIN",
    _DEFINE,
    syntax=(
        "#CONTROL AREA BEGIN [ID=.. WORK|PROT POLY|CIRC MIN_EXCUR=.. MAX_EXCUR=.. {EXCUR_AX=<axis>|EXCUR_AXNR=..} "
        "{MONITOR_LVL=MCS}]"
    ),
    form=Form.KEYS,
    keys=(
        Key("ID", needed=True),
        *(Key(flag, KeyKind.FLAG) for flag in _FLAGS),
        Key("MIN_EXCUR", needed=True),
        Key("MAX_EXCUR", needed=True),
        Key("EXCUR_AX", KeyKind.AXIS),
        Key("EXCUR_AXNR"),
        Key("MONITOR_LVL", KeyKind.WORD, ("MCS", "IMCS")),
    ),
)
def begin(x: Execution, call: StatementCall) -> None:
    """The blocks up to END are the contour of a space in the plane, in machine coordinates; they move nothing."""
    _expect_closed(x, call)
    expect_no_line(x)
    expect_none(x, "#CONTROL AREA BEGIN", call.column)
    number = _id(call)
    assert number is not None
    for one, other in (("WORK", "PROT"), ("POLY", "CIRC")):
        if call.given(one) == call.given(other):
            raise call.error(errors.SPACE_KEYS, "", what=f"either {one} or {other} is needed")
    if call.text("MONITOR_LVL") == "IMCS":
        raise call.error(errors.SPACE_KEYS, "MONITOR_LVL", what="IMCS needs a kinematic transformation of two steps")
    if number in x.memory.active_areas:
        raise call.error(errors.SPACE_ACTIVE, "ID", number=number, what="defined anew")
    if number not in x.memory.control_areas and len(x.memory.control_areas) >= MOST:
        raise call.error(errors.SPACES_FULL, "", limit=MOST)
    plane = x.modal.plane
    excursion = _excursion(x, call)
    if max(*PLANE_AXES[plane], excursion) >= len(x.setup.axes) or excursion in PLANE_AXES[plane]:
        raise call.error(errors.SPACE_KEYS, "", what="the channel needs the axes of the plane and another one")
    if not all(x.setup.linear[axis] for axis in PLANE_AXES[plane]):
        raise call.error(errors.SPACE_KEYS, "", what="the axes of the plane have to be linear")
    low, high = (x.axis_value(excursion, call.needed(key)) for key in ("MIN_EXCUR", "MAX_EXCUR"))
    if not low < high:
        raise call.error(errors.SPACE_KEYS, "MIN_EXCUR", what="MIN_EXCUR has to be less than MAX_EXCUR")
    x.open_area = OpenArea(number, call.given("WORK"), call.given("CIRC"), plane, excursion, low, high, x.source.line)
    x.modal_changed()


def _excursion(x: Execution, call: StatementCall) -> int:
    """The axis of the third direction: the one that is named, else the main axis across the plane."""
    named = call.argument("EXCUR_AX")
    value = call.number("EXCUR_AXNR")
    if named is not None and value is not None:
        raise call.error(errors.SPACE_KEYS, "EXCUR_AXNR", what="EXCUR_AX and EXCUR_AXNR exclude each other")
    if named is not None:
        return named.index
    if value is None:
        return 3 - sum(PLANE_AXES[x.modal.plane])
    numbers = x.setup.log_axes
    if value not in numbers:
        known = ", ".join(f"{name} {n}" for name, n in zip(x.setup.axes, numbers, strict=False)) or "none has a number"
        raise call.error(catalogue.LOGICAL_AXIS, "EXCUR_AXNR", value=value, known=known)
    return numbers.index(round_half_up(value))


@statement("CONTROL AREA END", _DEFINE)
def end(x: Execution, call: StatementCall) -> None:
    """The definition is complete; it is kept until the control is switched off."""
    area, x.open_area = x.open_area, None
    x.modal_changed()
    if area is None:
        raise call.error(errors.SPACE_NOT_BEGUN)
    x.memory.control_areas[area.number] = area.closed(call.column)


@statement("CONTROL AREA ON", _SELECT, syntax="#CONTROL AREA ON [ID=..]", form=Form.KEYS, keys=_ID, modal=True)
def watch(x: Execution, call: StatementCall) -> None:
    """The space is watched, and those that were already; the tool has to be in a permitted place."""
    _expect_closed(x, call)
    expect_no_line(x)
    expect_none(x, "#CONTROL AREA ON", call.column)
    number = _known(x, call)
    activate(x, [] if number is None else [number], call.column)


@statement("CONTROL AREA ON ALL", _SELECT, modal=True)
def watch_all(x: Execution, call: StatementCall) -> None:
    """All spaces that are defined are watched."""
    _expect_closed(x, call)
    expect_no_line(x)
    expect_none(x, "#CONTROL AREA ON ALL", call.column)
    activate(x, list(x.memory.control_areas), call.column)


@statement(
    "CONTROL AREA OFF",
    _SELECT,
    syntax="#CONTROL AREA OFF [[ID=..]]",
    form=Form.KEYS,
    keys=_ID,
    optional=True,
    modal=True,
)
def watch_no_more(x: Execution, call: StatementCall) -> None:
    """The space is no longer watched; without an ID the one that was selected last."""
    _expect_closed(x, call)
    number = _known(x, call)
    active = x.memory.active_areas
    if number is None and active:
        active.pop()
    elif number in active:
        active.remove(number)
    tell(x)


@statement("CONTROL AREA OFF ALL", _SELECT, modal=True)
def watch_none(x: Execution, call: StatementCall) -> None:
    """No space is watched."""
    _expect_closed(x, call)
    x.memory.active_areas.clear()
    tell(x)


@statement(
    "CONTROL AREA CLEAR", _CLEAR, syntax="#CONTROL AREA CLEAR [ID=..]", form=Form.KEYS, keys=(Key("ID", needed=True),)
)
def forget(x: Execution, call: StatementCall) -> None:
    """Delete a definition that is not active."""
    _expect_closed(x, call)
    number = _known(x, call)
    assert number is not None
    if number in x.memory.active_areas:
        raise call.error(errors.SPACE_ACTIVE, "ID", number=number, what="deleted")
    del x.memory.control_areas[number]


@statement("CONTROL AREA CLEAR ALL", _CLEAR)
def forget_all(x: Execution, call: StatementCall) -> None:
    """Delete all definitions, if none is active."""
    _expect_closed(x, call)
    if x.memory.active_areas:
        raise call.error(errors.SPACE_ACTIVE, "", number=x.memory.active_areas[-1], what="deleted")
    x.memory.control_areas.clear()
