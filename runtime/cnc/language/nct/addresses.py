"""The addresses of the dialect: what may stand behind each of them (programmer's manual lines 215–298, 1632–1706)."""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue

COORDINATES = "XYZUVWABC"
COORDINATE_LIMIT = 99_999.999  # mm or degrees, IS-B (line 1660)
COORDINATE_LIMIT_INCH = 3937.0078
NUMBER_LIMIT = 99_999_999.0  # eight digits (line 1634)


@dataclass(frozen=True, slots=True)
class Address:
    """What a value behind an address may be: its limits, how many decimals are kept, whether a sign, a decimal point and the
    operator I may stand there. `unique`: one word of it in a block is enough, unless the block is a list of arguments."""

    meaning: str
    least: float
    most: float
    decimals: int = 0
    sign: bool = False
    operator: bool = False
    unique: bool = True


_COORDINATE = Address("coordinate", -COORDINATE_LIMIT, COORDINATE_LIMIT, 5, sign=True, operator=True)
_AUXILIARY = Address("auxiliary coordinate", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True)

ADDRESSES: dict[str, Address] = {
    **dict.fromkeys(COORDINATES, _COORDINATE),
    "R": Address("radius, auxiliary data", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True, operator=True),
    "I": _AUXILIARY,
    "J": _AUXILIARY,
    "K": _AUXILIARY,
    "E": _AUXILIARY,
    "F": Address("feed", 0.0, 250_000.0, 7),
    "G": Address("preparatory function", 0.0, 999.9, 1, unique=False),
    "S": Address("spindle speed", 0, 99_999),
    "M": Address("miscellaneous function", 0, 999, unique=False),
    "T": Address("tool number", 0, 9999),
    "H": Address("number of a length compensation", 0, 999),
    "D": Address("number of a radius compensation", 0, 999),
    "L": Address("number of repetitions", 0, 9999),
    "P": Address("auxiliary data, dwell, program number", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True),
    "Q": Address("auxiliary data", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True),
    "N": Address("argument of a macro call", 0, 99_999),
    ",C": Address("chamfer", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True),
    ",R": Address("rounding", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True),
    ",A": Address("angle of a straight line", -NUMBER_LIMIT, NUMBER_LIMIT, 5, sign=True),
}


def rounded(value: float, decimals: int) -> float:
    """The value as an address takes it: halves go away from zero, X1.23456 is 1.235 with three decimals (line 1658)."""
    scale = 10.0**decimals
    size = math.floor(abs(value) * scale + 0.5 + 1e-9) / scale
    return math.copysign(size, value) if size else 0.0


def checked(name: str, value: float, column: int) -> float:
    """The value behind an address, rounded to the decimals that it has. LineError beyond its limits."""
    address = ADDRESSES[name]
    if not math.isfinite(value):
        raise LineError(
            catalogue.VALUE_EXCESS, column, address=name, value=value, least=address.least, most=address.most
        )
    value = rounded(value, address.decimals)
    if not address.least <= value <= address.most:
        raise LineError(
            catalogue.VALUE_EXCESS, column, address=name, value=value, least=address.least, most=address.most
        )
    return value
