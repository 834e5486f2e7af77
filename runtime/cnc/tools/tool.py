"""A tool: the record that a D word selects (programming manual 18520–18534, 21099–21126), and the table of its fields.

One row per field decides how the field is called in the machine's tool list, in CSV files, on the command line and in programs.
Inside everything is mm, degrees, rev/min and degrees/s²; kinematic parameters are in the manual's internal units (0.1 µm,
0.0001°), as programs exchange them.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, fields, replace
from enum import Enum, IntEnum
from typing import Any

from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import ErrorEntry

OFFSETS = 32  # axis offsets of a tool
PARAMETERS = 60  # free values
KIN_PARAMETERS = 70
GREATEST_NUMBER = 2**31 - 1
LENGTH_LIMIT = 214_748.0  # mm: what a signed 32 bit number of 0.1 µm holds


class ToolType(IntEnum):
    MILLING = 0
    TURNING = 1
    GRINDING = 2


@dataclass(frozen=True, slots=True)
class ToolId:
    """What identifies a tool: its type, the single tool of this type, and the record of that tool (lines 29324–29343)."""

    basic: int = 0
    sister: int = 0
    variant: int = 0

    def __str__(self) -> str:
        return f"{self.basic}" if not (self.sister or self.variant) else f"{self.basic}/{self.sister}/{self.variant}"


@dataclass(frozen=True, slots=True)
class Tool:
    """The data of one tool; tuples hold the elements up to the last one that is not 0."""

    number: int
    name: str = ""
    type: int = ToolType.MILLING
    sub_type: int = 0
    valid: bool = True
    radius: float = 0.0
    length: float = 0.0
    offsets: tuple[float, ...] = ()  # by channel index of the axis
    parameters: tuple[float, ...] = ()
    cutter_position: int = 0  # of a turning tool, 1…9
    tool_fixed: bool = False
    kin_id: int = 0
    kin_parameters: tuple[float, ...] = ()
    spindle: int = 0  # logical axis number, 0 none
    min_speed: float = 0.0
    max_speed: float = 0.0  # 0: not limited by the tool
    max_acceleration: float = 0.0  # 0: not limited by the tool
    wear_constant: float = 0.0  # 0.1 µm per m
    basic: int = 0  # 0: the number itself
    sister_valid: bool = False
    sister: int = 0
    variant_valid: bool = False
    variant: int = 0

    @property
    def id(self) -> ToolId:
        """What identifies the tool."""
        sister = self.sister if self.sister_valid else 0
        return ToolId(self.basic or self.number, sister, self.variant if self.variant_valid else 0)

    def value(self, name: str, index: int = 0) -> Any:
        """A field, or the element `index` of it."""
        found = getattr(self, name)
        if isinstance(found, tuple):
            return found[index] if index < len(found) else 0.0
        return found

    def with_value(self, name: str, value: Any, index: int = 0) -> Tool:
        """The tool with a field, or an element of it, changed; FieldError if the value cannot be that."""
        field = FIELDS[name]
        value = field.checked(value)
        if not field.count:
            return replace(self, **{name: value})
        elements = list(getattr(self, name))
        elements += [0.0] * (index + 1 - len(elements))
        elements[index] = value
        while elements and elements[-1] == 0.0:
            elements.pop()
        made: Any = tuple(elements)
        return replace(self, **{name: made})


class FieldError(ValueError):
    """A value that a field cannot have: a catalogue entry with its values, place still unknown."""

    def __init__(self, entry: ErrorEntry, **values: object) -> None:
        super().__init__(entry.text.format(**values))
        self.entry, self.values = entry, values


class Kind(Enum):
    """What a field holds; the text says its unit."""

    TEXT = ""
    INTEGER = "whole number"
    FLAG = "0 or 1"
    LENGTH = "mm"
    OFFSET = "mm or degrees"
    NUMBER = "number"
    SPEED = "rev/min"
    ACCELERATION = "degrees/s^2"


@dataclass(frozen=True, slots=True)
class Field:
    """`count` elements, 0 for a single value. `listed`: its name in a tool list behind `wz[i].`, `factor`: what a number there
    is multiplied with. `variable`: its name behind `V.G.WZ[j].`, `written`: programs may write it."""

    name: str
    kind: Kind
    listed: str = ""
    variable: str = ""
    count: int = 0
    factor: float = 1.0
    least: float = -math.inf
    greatest: float = math.inf
    written: bool = True

    def checked(self, value: Any) -> Any:
        """The value in the field's type. Raises FieldError."""
        if self.kind is Kind.TEXT:
            if not isinstance(value, str) or len(value) > _LONGEST_NAME or not value.isprintable():
                raise FieldError(catalogue.NAME_INVALID, name=value, limit=_LONGEST_NAME)
            return value
        if isinstance(value, str) or not math.isfinite(value):
            raise FieldError(catalogue.VALUE_INVALID, field=self.name, value=value, kind=self.kind.value)
        if self.kind in (Kind.INTEGER, Kind.FLAG) and value != round(value):
            raise FieldError(catalogue.VALUE_INVALID, field=self.name, value=value, kind=self.kind.value)
        if not self.least <= value <= self.greatest:
            raise FieldError(
                catalogue.VALUE_RANGE, field=self.name, value=value, least=self.least, greatest=self.greatest
            )
        if self.kind is Kind.FLAG:
            return bool(value)
        return int(value) if self.kind is Kind.INTEGER else float(value)


_LONGEST_NAME = 60
_REV_PER_MIN = 1e-3 / 6.0  # of 0.001 degrees/s
_INTERNAL = 1e-4  # mm, inch or degrees per number of a list
_INT32 = 2**31 - 1


def _length(name: str, listed: str, variable: str) -> Field:
    return Field(name, Kind.LENGTH, listed, variable, 0, _INTERNAL, -LENGTH_LIMIT, LENGTH_LIMIT)


def _flag(name: str, listed: str, variable: str) -> Field:
    return Field(name, Kind.FLAG, listed, variable, 0, 1.0, 0, 1)


def _whole(name: str, listed: str, variable: str, greatest: int = _INT32, *, written: bool = True) -> Field:
    return Field(name, Kind.INTEGER, listed, variable, 0, 1.0, 0, greatest, written)


FIELDS: dict[str, Field] = {
    field.name: field
    for field in (
        Field("name", Kind.TEXT),
        _whole("type", "typ", "TYPE", 2, written=False),
        _whole("sub_type", "sub_type", "SUB_TYPE", written=False),
        _flag("valid", "gueltig", "OK"),
        _length("radius", "radius", "R"),
        _length("length", "laenge", "L"),
        Field("offsets", Kind.OFFSET, "ax_versatz", "V.<axis>", OFFSETS, _INTERNAL, -LENGTH_LIMIT, LENGTH_LIMIT),
        Field("parameters", Kind.NUMBER, "param", "P", PARAMETERS),
        _whole("cutter_position", "srk_lage", "SRK_ID", 9),
        _flag("tool_fixed", "tool_fixed", "TOOL_FIXED"),
        _whole("kin_id", "kin_id", "KIN_ID", 65535),
        Field("kin_parameters", Kind.NUMBER, "kinematic.param", "KIN_PARAM", KIN_PARAMETERS),
        _whole("spindle", "log_ax_nr_spdl", "SPDL_AX_NR", 65535),
        Field("min_speed", Kind.SPEED, "vb_min", "S_MIN_SPEED", 0, _REV_PER_MIN, 0.0),
        Field("max_speed", Kind.SPEED, "vb_max", "S_MAX_SPEED", 0, _REV_PER_MIN, 0.0),
        Field("max_acceleration", Kind.ACCELERATION, "a_max", "S_MAX_ACC", 0, 1.0, 0.0),
        Field("wear_constant", Kind.NUMBER, "grinding_wear_const", "", 0, 1.0, 0.0),
        _whole("basic", "tool_id.basic", ""),
        _flag("sister_valid", "tool_id.sister_valid", "SISTER_VALID"),
        _whole("sister", "tool_id.sister", "SISTER"),
        _flag("variant_valid", "tool_id.variant_valid", "VARIANT_VALID"),
        _whole("variant", "tool_id.variant", "VARIANT"),
    )
}
assert [*FIELDS] == [field.name for field in fields(Tool)][1:]

NO_TOOL = Tool(0)
"""What holds with D0."""
