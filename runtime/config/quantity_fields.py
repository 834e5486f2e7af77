"""Types of fields that hold a quantity: a number in the internal unit, or text with a unit."""

from __future__ import annotations

from typing import Annotated

from pydantic import BeforeValidator, Field, ValidationInfo

from runtime.config.quantities import parse_quantity


def _quantity(dimension: str) -> BeforeValidator:
    def parse(value: object, info: ValidationInfo) -> float:
        axis_type = info.data.get("type") if info.data else None  # of the axis the quantity belongs to
        return parse_quantity(value, dimension, angular=None if axis_type is None else axis_type != "linear")

    return BeforeValidator(parse)


Length = Annotated[float, _quantity("length")]
Velocity = Annotated[float, _quantity("velocity"), Field(gt=0)]
VelocityStep = Annotated[float, _quantity("velocity"), Field(ge=0)]
Acceleration = Annotated[float, _quantity("acceleration"), Field(gt=0)]
Jerk = Annotated[float, _quantity("jerk"), Field(gt=0)]
Seconds = Annotated[float, _quantity("time"), Field(gt=0)]
