"""V.G.WZ, V.G.WZ_AKT, V.TOOL: the data of the tools, of the active one, and what was programmed last (21099–21177, 29388–29409).

V.G.WZ[j] is the tool table: what is written there holds for every D word that comes. V.G.WZ_AKT is what is in force: what is
written there acts like a D word and is gone with the next one. Lengths count in mm or inch, whatever is selected.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.isg.variables_channel import index_between
from runtime.cnc.decoder.tool_management import read_outside
from runtime.cnc.decoder.tool_words import move_at_once
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import as_number
from runtime.cnc.tools.table import ToolTableError
from runtime.cnc.tools.tool import FIELDS, GREATEST_NUMBER, Field, FieldError, Kind, Tool
from runtime.cnc.tools.written import expect_radius
from runtime.diagnostics.catalogue import tools as catalogue

_TABLE, _ACTIVE, _WEAR = "isg.var.g-tool-table", "isg.var.g-active-tool", "isg.var.g-tool-wear"
_ID = "isg.toolext.v-tool-variables"
_UNITS = {Kind.LENGTH: "mm, inch", Kind.OFFSET: "mm, inch, deg", Kind.SPEED: "rev/min", Kind.ACCELERATION: "deg/s^2"}
_MEANINGS = {
    "type": "type: 0 milling, 1 turning, 2 grinding",
    "sub_type": "sub-category",
    "valid": "1 if the tool may be used",
    "radius": "radius",
    "length": "length",
    "offsets": "offset in an axis",
    "parameters": "free value 0…59",
    "cutter_position": "position of the cutting edge of a turning tool",
    "tool_fixed": "1 if the tool cannot be aligned",
    "kin_id": "number of its kinematics",
    "kin_parameters": "kinematic parameter 0…69, 0.1 µm or 0.0001 deg",
    "spindle": "logical axis number of its spindle",
    "min_speed": "least speed",
    "max_speed": "greatest speed",
    "max_acceleration": "greatest acceleration of its spindle",
    "sister_valid": "1 if it has a sister tool",
    "sister": "number of the sister tool",
    "variant_valid": "1 if it has a variant",
    "variant": "number of the variant",
}


def shown(x: Execution, field: Field, value: Any, index: int) -> float:
    """A datum as the program sees it."""
    if field.kind is Kind.LENGTH:
        return x.shown_length(value)
    return x.shown(index, value) if field.kind is Kind.OFFSET else float(value)


def changed(x: Execution, tool: Tool, field: Field, value: Any, index: int, name: str) -> Tool:
    """The tool with a datum as the program has written it. CalculationError for a value that it cannot have."""
    number = as_number(value, name)
    if field.kind is Kind.LENGTH:
        number = x.length(number)
    elif field.kind is Kind.OFFSET:
        number = x.axis_value(index, number)
    try:
        return tool.with_value(field.name, number, index)
    except FieldError as error:
        raise CalculationError(error.entry, name, **error.values) from None


# ---------------------------------------------------------------------------------------------------- the table


def in_table(x: Execution, value: float, name: str) -> Tool:
    """The tool with a number. CalculationError if there is none."""
    number = index_between(value, 0, GREATEST_NUMBER, name)
    if x.setup.tools.external:
        return read_outside(x, number, name)
    try:
        tool = x.memory.tools.get(number)
    except ToolTableError as error:
        raise CalculationError(error.problem.entry, name, **error.problem.values) from None
    if tool is None:
        raise CalculationError(catalogue.TOOL_MISSING, name, number=number)
    return tool


def _is_valid(x: Execution, value: float) -> float:
    """V.G.WZ[j].OK: of a tool that is not there it is 0, so that a program can ask."""
    try:
        return float(in_table(x, value, "V.G.WZ").valid)
    except CalculationError as error:
        if error.entry is not catalogue.TOOL_MISSING:
            raise
        return 0.0


def enter(x: Execution, tool: Tool, name: str) -> None:
    """Write a tool back into the table."""
    try:
        x.memory.tools.put(tool)
    except ToolTableError as error:
        raise CalculationError(error.problem.entry, name, **error.problem.values) from None
    x.memory.tool_writes += 1


def _table_variable(field: Field) -> None:
    path = _path("V.G.WZ[]", field)
    name = f"V.G.WZ[j].{field.variable}"

    def read(x: Execution, number: float, *indices: float) -> float:
        index = _element(field, indices, name)
        return shown(x, field, in_table(x, number, name).value(field.name, index), index)

    def write(x: Execution, value: Any, number: float, *indices: float) -> None:
        if x.setup.tools.external:
            raise CalculationError(catalogue.TABLE_FOREIGN, name)
        tool, index = in_table(x, number, name), _element(field, indices, name)
        tool = changed(x, tool, field, value, index, name)
        try:
            expect_radius(tool, field.name)
        except FieldError as error:
            raise CalculationError(error.entry, name, **error.values) from None
        enter(x, tool, name)

    _register(path, _TABLE, field, _is_valid if field.name == "valid" else read, write)


# ---------------------------------------------------------------------------------------------------- the active tool


def change_active(x: Execution, field: Field, value: Any, index: int, name: str) -> None:
    """A datum of the active tool: it acts like a D word."""
    move_at_once(x, x.tools.change(changed(x, x.tools.active, field, value, index, name)))


def _active_variable(field: Field) -> None:
    path = _path("V.G.WZ_AKT", field)
    name = f"V.G.WZ_AKT.{field.variable}"

    def read(x: Execution, *indices: float) -> float:
        index = _element(field, indices, name)
        return shown(x, field, x.tools.active.value(field.name, index), index)

    def write(x: Execution, value: Any, *indices: float) -> None:
        change_active(x, field, value, _element(field, indices, name), name)

    _register(path, _ACTIVE, field, read, write)


def _path(head: str, field: Field) -> str:
    """V[i] is the same as V.<axis>."""
    brackets = "[]" if field.count and field.kind is not Kind.OFFSET else ""
    return f"{head}.{field.variable}{brackets}"


def _element(field: Field, indices: tuple[float, ...], name: str) -> int:
    return index_between(indices[0], 0, field.count - 1, name) if indices else 0


def _register(path: str, spec: str, field: Field, read: Callable[..., float], write: Callable[..., None]) -> None:
    syntax = path.replace("WZ[]", "WZ[j]").replace("[]", "[i]")
    variable(path, spec, _MEANINGS[field.name], unit=_UNITS.get(field.kind, ""), syntax=syntax)(read)
    if field.written:
        writes(path)(write)


for _field in FIELDS.values():
    if _field.variable:
        _table_variable(_field)
        _active_variable(_field)


@variable("V.G.WZ[].ME", _TABLE, "unit of the data of a tool: 0, mm", syntax="V.G.WZ[j].ME")
def unit(x: Execution, number: float) -> float:
    in_table(x, number, "V.G.WZ[j].ME")
    return 0.0


@variable("V.G.WZ_AKT.ME", _ACTIVE, "unit of the data of the active tool: 0, mm")
def active_unit(x: Execution) -> float:
    return 0.0


@variable("V.G.WZR", _ACTIVE, "radius of the active tool, older name", unit="mm, inch")
def radius(x: Execution) -> float:
    return x.shown_length(x.tools.active.radius)


@writes("V.G.WZR")
def set_radius(x: Execution, value: float) -> None:
    change_active(x, FIELDS["radius"], value, 0, "V.G.WZR")


@variable("V.G.WZL", _ACTIVE, "length of the active tool, older name", unit="mm, inch")
def length(x: Execution) -> float:
    return x.shown_length(x.tools.active.length)


@writes("V.G.WZL")
def set_length(x: Execution, value: float) -> None:
    change_active(x, FIELDS["length"], value, 0, "V.G.WZL")


@variable("V.G.D_AKT", _ACTIVE, "number of the active tool data, 0 with D0")
def data(x: Execution) -> float:
    return float(x.tools.data)


@variable("V.G.T_AKT", _ACTIVE, "number of the tool that was programmed last: V.TOOL.BASIC")
def tool(x: Execution) -> float:
    return float(x.tools.id.basic)


@variable("V.G.TOOL_LIST_INVOKE", "isg.var.g-invoke-counters", "how often programs have written to the tool table")
def table_writes(x: Execution) -> float:
    return float(x.memory.tool_writes)


# ---------------------------------------------------------------------------------------------------- wear


@variable("V.G.WZ_AKT.WEAR_CONST", _WEAR, "wear constant of the active tool", unit="0.1 µm/m")
def wear_constant(x: Execution) -> float:
    return x.tools.active.wear_constant


@writes("V.G.WZ_AKT.WEAR_CONST")
def set_wear_constant(x: Execution, value: float) -> None:
    change_active(x, FIELDS["wear_constant"], value, 0, "V.G.WZ_AKT.WEAR_CONST")


@variable("V.G.WZ_AKT.WEAR_RADIUS", _WEAR, "0: wear that the online compensation has added, which is not there")
def wear_of_radius(x: Execution) -> float:
    return 0.0


@variable("V.G.WZ_AKT.WEAR_RADIUS_CONT", _WEAR, "0: its continuous part")
def continuous_wear(x: Execution) -> float:
    return 0.0


@variable("V.G.WZ_AKT.WEAR.<axis>", _WEAR, "0: wear that the online compensation has added in an axis")
def wear_of_axis(x: Execution, axis: int) -> float:
    return 0.0


# ---------------------------------------------------------------------------------------------------- identification


@variable("V.TOOL.BASIC", _ID, "number of the tool that was programmed last")
def basic(x: Execution) -> float:
    return float(x.tools.id.basic)


@variable("V.TOOL.SISTER", _ID, "its sister number")
def sister(x: Execution) -> float:
    return float(x.tools.id.sister)


@variable("V.TOOL.VARIANT", _ID, "its variant number")
def variant(x: Execution) -> float:
    return float(x.tools.id.variant)
