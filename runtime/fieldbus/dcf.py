"""Device configuration files: what a device is to be set to, as DCF (CiA 306) or as concise DCF (CiA 302-3, object 0x1F22).

A concise DCF is a number of entries (u32), then each: index (u16), sub-index (u8), length in bytes (u32), data; little-endian.

Date and time of a configuration are objects 0x1020:1 and :2. A device that keeps them tells by them that it is configured
already; then nothing is downloaded.
"""

from __future__ import annotations

import configparser
import struct
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from canopen.objectdictionary import ObjectDictionaryError, datatypes

from runtime.diagnostics.catalogue import commissioning as errors
from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.objects import variables
from runtime.fieldbus.pdo import STRUCT_CODES, object_name

VERIFY_CONFIGURATION: Final = 0x1020
LARGEST: Final = 1_000_000  # bytes of a concise DCF
VALUES: Final = STRUCT_CODES.keys() | {
    datatypes.BOOLEAN,
    datatypes.REAL32,
    datatypes.REAL64,
    datatypes.VISIBLE_STRING,
    datatypes.OCTET_STRING,
    datatypes.UNICODE_STRING,
}
"""Types whose value can stand in a DCF; a domain is named there by a file."""

# What the master tells every node itself (communication; process data in `_left_out`), and objects whose writing is an order or
# a set-point, as they stand in a dump of a device that was in use: never downloaded.
_NEVER: Final = frozenset(
    {0x1005, 0x1006, 0x1007, 0x100C, 0x100D, 0x1010, 0x1011, 0x1012, 0x1016, 0x1017, 0x1019, VERIFY_CONFIGURATION}
    | {0x6040, 0x6060, 0x6071, 0x607A, 0x60B0, 0x60B1, 0x60B2, 0x60B8, 0x60C1, 0x60FE, 0x60FF, 0x6200, 0x6411}
)


@dataclass(frozen=True, slots=True)
class Entry:
    """One write."""

    index: int
    subindex: int
    data: bytes


@dataclass(frozen=True, slots=True)
class Configuration:
    """The writes of a node, in their order, and the date and time by which it is known."""

    entries: tuple[Entry, ...]
    stamp: tuple[int, int] | None = None  # days since 1984, ms since midnight


def read_configuration(path: str, node: int) -> Configuration:
    """The configuration in a DCF, or in a concise DCF (`.cdcf`, `.bin`). Raises FieldbusError (303120, 303121)."""
    if Path(path).suffix.lower() in (".cdcf", ".bin"):
        try:
            with Path(path).open("rb") as file:
                data = file.read(LARGEST + 1)
        except OSError as error:
            raise _unreadable(path, error.strerror or str(error)) from error
        entries = parse_concise(data, path)
    else:
        entries = list(_from_dcf(path, node))
    numbers = {
        entry.subindex: int.from_bytes(entry.data, "little") for entry in entries if entry.index == VERIFY_CONFIGURATION
    }
    stamp = (numbers[1], numbers[2]) if numbers.get(1) and 2 in numbers else None
    return Configuration(tuple(entry for entry in entries if not _left_out(entry.index)), stamp)


def _left_out(index: int) -> bool:
    return index in _NEVER or 0x1400 <= index < 0x1C00


def _from_dcf(path: str, node: int) -> Iterator[Entry]:
    """The objects with a `ParameterValue` that can be written."""
    try:
        od = read_dictionary(path, node)
    except OSError as error:
        raise _unreadable(path, error.strerror or str(error)) from error
    except (ValueError, KeyError, AttributeError, TypeError, configparser.Error, ObjectDictionaryError) as error:
        raise _unreadable(path, str(error).replace("\n", " ") or type(error).__name__) from error
    for variable in variables(od):
        raw = getattr(variable, "value_raw", None)
        if not raw or not variable.writable or variable.data_type not in VALUES:
            if raw and variable.writable and not _left_out(variable.index):
                raise _bad_value(path, variable.index, variable.subindex, "a value of its type cannot stand in a DCF")
            continue
        if variable.value is None:  # the parser passes over what it does not understand
            raise _bad_value(path, variable.index, variable.subindex, f"{raw!r} is no value of its type")
        try:
            data = bytes(variable.encode_raw(variable.value))
        except (struct.error, OverflowError, ValueError, ObjectDictionaryError):
            raise _bad_value(path, variable.index, variable.subindex, f"{raw} does not fit its type") from None
        yield Entry(variable.index, variable.subindex, data)


def parse_concise(data: bytes, file: str = "-") -> list[Entry]:
    """The entries of a concise DCF. Raises FieldbusError for one that is cut off, or longer than it says."""
    if len(data) > LARGEST:
        raise _unreadable(file, f"it is longer than {LARGEST} bytes")
    entries: list[Entry] = []
    try:
        (count,) = struct.unpack_from("<I", data)
        place = 4
        for _ in range(count):
            index, subindex, length = struct.unpack_from("<HBI", data, place)
            place += 7
            if place + length > len(data):
                raise _unreadable(file, f"it ends within the value of object {object_name(index, subindex)}")
            entries.append(Entry(index, subindex, data[place : place + length]))
            place += length
    except struct.error:
        raise _unreadable(file, f"it ends after {len(entries)} of its entries") from None
    if place != len(data):
        raise _unreadable(file, f"{len(data) - place} bytes follow its last entry")
    return entries


def concise(entries: Sequence[Entry]) -> bytes:
    """A concise DCF."""
    parts = [struct.pack("<I", len(entries))]
    parts += [struct.pack("<HBI", e.index, e.subindex, len(e.data)) + e.data for e in entries]
    return b"".join(parts)


def _unreadable(file: str, reason: str) -> FieldbusError:
    return FieldbusError(errors.DCF_UNREADABLE, file=file, reason=reason)


def _bad_value(file: str, index: int, subindex: int, reason: str) -> FieldbusError:
    return FieldbusError(errors.DCF_VALUE, file=file, object=object_name(index, subindex), reason=reason)
