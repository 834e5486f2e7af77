"""Synchronisation types of technology functions (P-CHAN-00041, manual line 1838)."""

from __future__ import annotations

SYNCH_VALUES = {  # every type and flag of the manual
    "NOT_VALID": -1,
    "NO_SYNCH": 0x0,
    "MOS": 0x1,
    "MVS_SVS": 0x2,
    "MVS_SNS": 0x4,
    "MNS_SNS": 0x8,
    "MNE_SNS": 0x20,
    "MVS_SLM": 0x4000,
    "MVS_SLP": 0x8000,
    "PLC_INFO": 0x20000,
    "MOS_TS": 0x40000,
    "MEP_MOS": 0x100000,
    "MET_MOS": 0x200000,
    "BWD_SYNCH": 0x400000,
    "FWD_SYNCH": 0x800000,
    "MEP_SVS": 0x1000000,
    "MET_SVS": 0x2000000,
    "FAW_SYNCH": 0x10000000,
}
SYNCH_FLAGS = ("PLC_INFO", "BWD_SYNCH", "FWD_SYNCH", "FAW_SYNCH")  # may be added to a type with "|"
SYNCH_TYPES = tuple(name for name in SYNCH_VALUES if name not in SYNCH_FLAGS)
_NOT_VALID_VALUES = (-1, 0x80000000, 0xFFFFFFFF)


class SynchNameError(ValueError):
    """A text or number that names no synchronisation type; `part` is the wrong part of it."""

    def __init__(self, part: str) -> None:
        self.part = part
        super().__init__(f"{part!r} is no synchronisation type; known: {', '.join(SYNCH_VALUES)}")


class SynchCountError(ValueError):
    """Not exactly one type, with flags or without."""


def synch_names(value: str | int) -> tuple[str, ...]:
    """The type and then the flags of a synchronisation, from names or numbers (0x… or decimal) joined by "|".

    Raises SynchNameError, SynchCountError.
    """
    names: list[str] = []
    parts = [part.strip() for part in str(value).split("|")]
    for part in parts:
        names += [name for name in _names_of(part) if name not in names]
    if all(name in SYNCH_FLAGS for name in names) and not any(part.upper() in SYNCH_FLAGS for part in parts):
        names.append("NO_SYNCH")  # a number in which no type has its bit
    types = [name for name in names if name not in SYNCH_FLAGS]
    flags = [name for name in names if name in SYNCH_FLAGS]
    if len(types) != 1:
        raise SynchCountError(
            f"exactly one of {', '.join(SYNCH_TYPES)} is expected, with {', '.join(SYNCH_FLAGS)} added or not"
        )
    return (*types, *flags)


def _names_of(part: str) -> list[str]:
    if part.upper() in SYNCH_VALUES:
        return [part.upper()]
    try:
        number = int(part, 0)
    except ValueError:
        raise SynchNameError(part) from None
    if number in _NOT_VALID_VALUES:
        return ["NOT_VALID"]
    names = [name for name, bit in SYNCH_VALUES.items() if bit > 0 and number & bit]
    if number < 0 or sum(SYNCH_VALUES[name] for name in names) != number:
        raise SynchNameError(part)
    return names or ["NO_SYNCH"]
