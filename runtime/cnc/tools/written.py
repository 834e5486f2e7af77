"""Data of tools as people write them: `radius=5`, `length="50 mm"`, `offset.X=0.2 inch`, `parameters[3]=7`, `type=turning`."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass

from runtime.cnc.tools.tool import FIELDS, Field, FieldError, Kind, Tool, ToolType
from runtime.config.quantities import UNITS, UnitError, parse_quantity
from runtime.diagnostics.catalogue import tools as catalogue

_ELEMENT = re.compile(r"(?P<name>[a-z_]+)(?:\[(?P<index>\d+)\]|\.(?P<axis>[A-Za-z][A-Za-z0-9_]*))?\Z")
_DIMENSIONS = {Kind.LENGTH: "length", Kind.SPEED: "angular velocity", Kind.ACCELERATION: "angular acceleration"}
_REV_PER_MIN = UNITS["angular velocity"]["rev/min"]  # in degrees/s
_FLAGS = {"0": 0.0, "1": 1.0, "no": 0.0, "yes": 1.0, "false": 0.0, "true": 1.0}
INCH = UNITS["length"]["inch"]


@dataclass(frozen=True, slots=True)
class ToolAxes:
    """The axes of the channel, by which offsets are named; `rotary`: indices of those whose offsets are angles."""

    names: Sequence[str]
    rotary: frozenset[int] = frozenset()


@dataclass(frozen=True, slots=True)
class Datum:
    """A field, or the element `index` of it."""

    field: Field
    index: int = 0


def datum_of(text: str, axes: ToolAxes) -> Datum:
    """What a name means. FieldError for one that is none."""
    match = _ELEMENT.match(text.strip())
    known = ", ".join(data_names(axes))
    if match is None:
        raise FieldError(catalogue.FIELD_UNKNOWN, field=text.strip(), known=known)
    name, index, axis = match["name"], match["index"], match["axis"]
    if name == "offset" and axis is not None:
        if axis not in axes.names:
            raise FieldError(catalogue.FIELD_UNKNOWN, field=text.strip(), known=known)
        return Datum(FIELDS["offsets"], list(axes.names).index(axis))
    field = FIELDS.get(name)
    if field is None or axis is not None or (index is None) != (field.count == 0):
        raise FieldError(catalogue.FIELD_UNKNOWN, field=text.strip(), known=known)
    if index is not None and int(index) >= field.count:
        raise FieldError(catalogue.ELEMENT_RANGE, key=text.strip(), field=name, last=field.count - 1)
    return Datum(field, int(index or 0))


def name_of(datum: Datum, axes: ToolAxes) -> str:
    """The name of a datum."""
    if not datum.field.count:
        return datum.field.name
    if datum.field.kind is Kind.OFFSET and datum.index < len(axes.names):
        return f"offset.{axes.names[datum.index]}"
    return f"{datum.field.name}[{datum.index}]"


def data_names(axes: ToolAxes) -> list[str]:
    """All names, those of elements with their first and last index."""
    names: list[str] = []
    for name, field in FIELDS.items():
        if field.kind is Kind.OFFSET:
            names += [f"offset.{axis}" for axis in axes.names]
        else:
            names.append(f"{name}[0…{field.count - 1}]" if field.count else name)
    return names


def with_written(tool: Tool, datum: Datum, text: str, axes: ToolAxes, *, inch: bool = False) -> Tool:
    """The tool with a datum as it is written; a length without a unit is mm, or inch. FieldError for what it cannot be."""
    field = datum.field
    value: float | str = text if field.kind is Kind.TEXT else _number(datum, text.strip(), axes, inch)
    tool = tool.with_value(field.name, value, datum.index)
    expect_radius(tool, field.name)
    return tool


def expect_radius(tool: Tool, changed: str) -> None:
    """FieldError for a negative radius: in a table it is a typing error, which would cut on the wrong side of the contour."""
    if changed == "radius" and tool.radius < 0:
        raise FieldError(catalogue.NEGATIVE_RADIUS, number=tool.number, value=tool.radius)


def _number(datum: Datum, text: str, axes: ToolAxes, inch: bool) -> float:
    field = datum.field
    try:
        if field.name == "type" and text.upper() in ToolType.__members__:
            return float(ToolType[text.upper()])
        if field.kind is Kind.FLAG:
            return _FLAGS[text.lower()]
        if field.kind in (Kind.INTEGER, Kind.NUMBER):
            return float(text)
        angular = field.kind is not Kind.LENGTH and (field.kind is not Kind.OFFSET or datum.index in axes.rotary)
        bare = _is_bare(text)
        value = parse_quantity(text, _DIMENSIONS.get(field.kind, "length"), angular=angular)
    except UnitError as error:
        values = {"field": name_of(datum, axes), "value": text, "units": ", ".join(error.allowed)}
        raise FieldError(catalogue.UNIT_WRONG, **values) from None
    except (ValueError, KeyError):
        kind = field.kind.value
        raise FieldError(catalogue.VALUE_INVALID, field=name_of(datum, axes), value=text, kind=kind) from None
    if field.kind is Kind.SPEED and not bare:
        return value / _REV_PER_MIN
    return value * INCH if inch and bare and not angular else value


def _is_bare(text: str) -> bool:
    """A number without a unit."""
    try:
        float(text)
    except ValueError:
        return False
    return True
