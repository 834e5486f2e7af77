"""Numbers with units: text or number → mm or degrees, and seconds."""

from __future__ import annotations

import re

UNITS: dict[str, dict[str, float]] = {
    # dimension: unit -> factor to the internal unit
    "length": {"mm": 1.0, "m": 1000.0, "um": 1e-3, "µm": 1e-3, "inch": 25.4},
    "angle": {"deg": 1.0},
    "velocity": {"mm/s": 1.0, "m/min": 1000.0 / 60.0, "m/s": 1000.0, "mm/min": 1.0 / 60.0},
    "angular velocity": {"deg/s": 1.0, "rev/min": 6.0},
    "acceleration": {"mm/s^2": 1.0, "m/s^2": 1000.0},
    "angular acceleration": {"deg/s^2": 1.0, "rev/min/s": 6.0},
    "jerk": {"mm/s^3": 1.0, "m/s^3": 1000.0},
    "angular jerk": {"deg/s^3": 1.0, "rev/min/s^2": 6.0},
    "time": {"s": 1.0, "ms": 1e-3, "us": 1e-6, "µs": 1e-6, "min": 60.0},
}
_ANGULAR = {  # what a dimension is at an axis that turns
    "length": "angle",
    "velocity": "angular velocity",
    "acceleration": "angular acceleration",
    "jerk": "angular jerk",
}
_QUANTITY = re.compile(r"\s*([-+]?(?:\d+\.?\d*|\.\d+)(?:[eE][-+]?\d+)?)\s*(\S*)\s*\Z")


class UnitError(ValueError):
    """A quantity whose unit does not belong to its dimension."""

    def __init__(self, unit: str, dimension: str, allowed: tuple[str, ...]) -> None:
        self.unit, self.dimension, self.allowed = unit, dimension, allowed
        super().__init__(f"{unit!r} is no unit of {dimension}; known: {', '.join(allowed)}")


def parse_quantity(value: object, dimension: str, *, angular: bool | None = None) -> float:
    """A number in the internal unit of `dimension` from a number or a text with a unit.

    `angular` tells whether the quantity belongs to an axis that turns; None allows both. Raises UnitError for a unit of
    something else, ValueError for what is no quantity.
    """
    allowed = dict(UNITS[dimension]) if not (angular and dimension in _ANGULAR) else {}
    if angular is not False and dimension in _ANGULAR:
        allowed |= UNITS[_ANGULAR[dimension]]
    if isinstance(value, (int, float)) and not isinstance(value, bool):
        return float(value)
    if isinstance(value, str) and (match := _QUANTITY.match(value)):
        unit = match.group(2).replace("²", "^2").replace("³", "^3")
        if unit == "":
            return float(match.group(1))
        if unit in allowed:
            return float(match.group(1)) * allowed[unit]
        name = _ANGULAR.get(dimension, dimension) if angular else dimension
        raise UnitError(match.group(2), name, tuple(allowed))
    raise ValueError(f"a number with or without a unit ({', '.join(allowed)}) is expected")
