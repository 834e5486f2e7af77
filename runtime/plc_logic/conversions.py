"""Conversions of IEC 61131-3 to the elementary types, with their ranges: TO_INT, TO_BYTE, TO_REAL, TO_STRING and so on.

The rules:

- a number that the type cannot hold is an error (PlcError: the path stops, the text names value and range), never a wrong number;
  who wants the nearest number says LIMIT first;
- a real number becomes a whole one by rounding to the nearest, halves to the even one (IEC 60559); TRUNC is there for the other;
- a bit string (BYTE ... LWORD) takes the lowest bits of a whole number, as between bit strings of two lengths;
- a text is read as the standard's literal: "16#FF", "2#1010_0001", "-12", "1.5E3", "TRUE".
"""

from __future__ import annotations

import math
import re
import struct

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.plc_logic.errors import PlcError
from runtime.plc_logic.iec_time import TIME, TIME_TO_STRING

Value = bool | int | float | str

RANGES: dict[str, tuple[int, int]] = {
    name: (0, 2**bits - 1) if name.startswith("U") else (-(2 ** (bits - 1)), 2 ** (bits - 1) - 1)
    for name, bits in (
        *(("SINT", 8), ("INT", 16), ("DINT", 32), ("LINT", 64)),
        *(("USINT", 8), ("UINT", 16), ("UDINT", 32), ("ULINT", 64)),
    )
}
WIDTHS = {"BYTE": 8, "WORD": 16, "DWORD": 32, "LWORD": 64}
_BASED = re.compile(r"([+-]?)(2|8|16)#([0-9a-f_]+)", re.IGNORECASE)
_REAL_MAX = 3.4028234663852886e38


def _wrong(value: Value, kind: str, why: str) -> PlcError:
    return PlcError(catalogue.PLC_CONVERSION, value=value, kind=kind, why=why)


def _number(value: Value, kind: str) -> int | float:
    """The number that a value is."""
    if isinstance(value, bool):
        return int(value)
    if isinstance(value, int | float):
        return value
    text = value.strip()
    if text.upper() in ("TRUE", "FALSE"):
        return int(text.upper() == "TRUE")
    try:
        if (based := _BASED.fullmatch(text)) is not None:
            number = int(based[3], int(based[2]))
            return -number if based[1] == "-" else number
        return float(text) if re.search(r"[.eEnN]", text) else int(text)
    except ValueError:
        raise _wrong(value, kind, "it is no number") from None


def _whole(value: Value, kind: str) -> int:
    number = _number(value, kind)
    if isinstance(number, float):
        if not math.isfinite(number):
            raise _wrong(value, kind, "it is no finite number")
        number = round(number)
    return number


def _integer(value: Value, kind: str) -> int:
    number = _whole(value, kind)
    low, high = RANGES[kind]
    if not low <= number <= high:
        raise _wrong(value, kind, f"it goes from {low} to {high}")
    return number


def _bits(value: Value, kind: str) -> int:
    return _whole(value, kind) & ((1 << WIDTHS[kind]) - 1)


def TO_SINT(IN: Value) -> int:  # noqa: N802
    """-128 ... 127."""
    return _integer(IN, "SINT")


def TO_INT(IN: Value) -> int:  # noqa: N802
    """-32768 ... 32767."""
    return _integer(IN, "INT")


def TO_DINT(IN: Value) -> int:  # noqa: N802
    """32 bits with sign."""
    return _integer(IN, "DINT")


def TO_LINT(IN: Value) -> int:  # noqa: N802
    """64 bits with sign."""
    return _integer(IN, "LINT")


def TO_USINT(IN: Value) -> int:  # noqa: N802
    """0 ... 255."""
    return _integer(IN, "USINT")


def TO_UINT(IN: Value) -> int:  # noqa: N802
    """0 ... 65535."""
    return _integer(IN, "UINT")


def TO_UDINT(IN: Value) -> int:  # noqa: N802
    """32 bits without sign."""
    return _integer(IN, "UDINT")


def TO_ULINT(IN: Value) -> int:  # noqa: N802
    """64 bits without sign."""
    return _integer(IN, "ULINT")


def TO_BYTE(IN: Value) -> int:  # noqa: N802
    """The lowest 8 bits."""
    return _bits(IN, "BYTE")


def TO_WORD(IN: Value) -> int:  # noqa: N802
    """The lowest 16 bits."""
    return _bits(IN, "WORD")


def TO_DWORD(IN: Value) -> int:  # noqa: N802
    """The lowest 32 bits."""
    return _bits(IN, "DWORD")


def TO_LWORD(IN: Value) -> int:  # noqa: N802
    """The lowest 64 bits."""
    return _bits(IN, "LWORD")


def TO_BOOL(IN: Value) -> bool:  # noqa: N802
    """Everything but 0 is TRUE."""
    return _number(IN, "BOOL") != 0


def TO_REAL(IN: Value) -> float:  # noqa: N802
    """The nearest number of 32 bits (IEC 60559 binary32)."""
    number = float(_number(IN, "REAL"))
    if math.isfinite(number) and abs(number) > _REAL_MAX:
        raise _wrong(IN, "REAL", f"it goes to {_REAL_MAX}")
    return float(struct.unpack("<f", struct.pack("<f", number))[0])


def TO_LREAL(IN: Value) -> float:  # noqa: N802
    """The nearest number of 64 bits."""
    try:
        return float(_number(IN, "LREAL"))
    except OverflowError:
        raise _wrong(IN, "LREAL", "it goes to 1.8E308") from None


def TO_TIME(IN: Value) -> float:  # noqa: N802
    """Seconds: of a text "T#2s", or of a number of milliseconds, as whole numbers are in the standard's TIME."""
    return TIME(IN) if isinstance(IN, str) else _number(IN, "TIME") / 1000.0


def TO_STRING(IN: Value) -> str:  # noqa: N802
    """TRUE and FALSE, whole numbers in decimal, real numbers in the shortest text that is the same number."""
    if isinstance(IN, bool):
        return "TRUE" if IN else "FALSE"
    return IN if isinstance(IN, str) else repr(IN)


def BCD_TO_INT(IN: int) -> int:  # noqa: N802
    """16#1234 is 1234. Raises PlcError for a digit above 9."""
    text = f"{IN:x}"
    if IN < 0 or not text.isdecimal():
        raise _wrong(IN, "BCD", f"16#{text} has digits that are none")
    return int(text)


def INT_TO_BCD(IN: int) -> int:  # noqa: N802
    """1234 is 16#1234. Raises PlcError below 0."""
    if IN < 0:
        raise _wrong(IN, "BCD", "it has no sign")
    return int(str(IN), 16)


__all__ = [name for name in globals() if name.startswith("TO_")] + [
    "BCD_TO_INT",
    "INT_TO_BCD",
    "TIME",
    "TIME_TO_STRING",
]
