"""TIME of IEC 61131-3: durations are seconds in this library, and these functions read and write the standard's texts."""

from __future__ import annotations

import re

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.plc_logic.errors import PlcError

_UNITS = {"d": 86_400.0, "h": 3_600.0, "m": 60.0, "s": 1.0, "ms": 1e-3, "us": 1e-6, "ns": 1e-9}
_ORDER = list(_UNITS)
_PART = re.compile(r"(\d+(?:\.\d+)?)(ms|us|ns|d|h|m|s)_?")
_PREFIX = re.compile(r"(?:t|time|lt|ltime)#", re.IGNORECASE)


def TIME(text: str) -> float:  # noqa: N802 - the standard's name
    """Seconds of a duration literal (clause 6.3.3 of edition 3): `TIME("T#1h30m")`, "T#-2.5s", "T#1d_2h_3m_4s_5ms".

    The prefix may be left out. Units go from great to small, each once, and only the last may have a fraction.
    Raises PlcError.
    """
    wrong = PlcError(catalogue.PLC_CONVERSION, value=text, kind="TIME", why="write it like T#1h30m or T#2.5s")
    prefix = _PREFIX.match(text)
    rest = text[prefix.end() :] if prefix else text
    sign = -1.0 if rest.startswith("-") else 1.0
    rest = rest.removeprefix("-").lower()
    seconds, last, fraction = 0.0, -1, False
    while rest:
        part = _PART.match(rest)
        if part is None or fraction or _ORDER.index(part[2]) <= last:
            raise wrong
        seconds += float(part[1]) * _UNITS[part[2]]
        last, fraction = _ORDER.index(part[2]), "." in part[1]
        rest = rest[part.end() :]
    if last < 0 or text.endswith("_"):
        raise wrong
    return sign * seconds


def TIME_TO_STRING(seconds: float) -> str:  # noqa: N802 - the standard's name
    """The duration as the standard spells it, whole milliseconds: 5405.25 is T#1h30m5s250ms."""
    whole = round(abs(seconds) * 1000.0)
    parts = []
    for unit, milliseconds in (("d", 86_400_000), ("h", 3_600_000), ("m", 60_000), ("s", 1000), ("ms", 1)):
        count, whole = divmod(whole, milliseconds)
        if count:
            parts.append(f"{count}{unit}")
    sign = "-" if seconds < 0 and parts else ""
    return f"T#{sign}{''.join(parts) or '0s'}"
