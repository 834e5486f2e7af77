"""The external variables (V.E): an area of bytes that NC program and PLC share, and the directory of what lies where.

The kernel gives the values no meaning. They are zero at start-up and stay over program changes and resets. A value is written
by one store of its size, so nobody sees half a number; texts end with a zero byte and are not guarded.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Sequence
from dataclasses import dataclass
from typing import Protocol

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.errors import HliError
from runtime.hli.layout import EXTERNAL_BYTES, EXTERNAL_DIMENSIONS, EXTERNAL_NAMES, EXTERNAL_PATH, Hli
from runtime.hli.memory import get_text, put_text

TEXT = "STRING"
_FORMATS: dict[str, tuple[struct.Struct, int, int]] = {
    # type -> how it is stored, least and greatest value of whole numbers
    "BOOLEAN": (struct.Struct("=B"), 0, 1),
    "CHAR": (struct.Struct("=B"), 0, 2**8 - 1),
    "SGN08": (struct.Struct("=b"), -(2**7), 2**7 - 1),
    "UNS08": (struct.Struct("=B"), 0, 2**8 - 1),
    "SGN16": (struct.Struct("=h"), -(2**15), 2**15 - 1),
    "UNS16": (struct.Struct("=H"), 0, 2**16 - 1),
    "SGN32": (struct.Struct("=i"), -(2**31), 2**31 - 1),
    "UNS32": (struct.Struct("=I"), 0, 2**32 - 1),
    "SGN64": (struct.Struct("=q"), -(2**63), 2**63 - 1),
    "UNS64": (struct.Struct("=Q"), 0, 2**64 - 1),
    "REAL32": (struct.Struct("=f"), 0, 0),
    "REAL64": (struct.Struct("=d"), 0, 0),
}
KINDS: tuple[str, ...] = (*_FORMATS, TEXT)  # their places here are their numbers in the motion queue
_REALS = ("REAL32", "REAL64")
_GREATEST_REAL32 = 3.4028234e38


class ExternalEntry(Protocol):
    """A variable or an element of a structure, as the machine description lays it out.

    `path` below V.E with dots, indices of arrays of structures in brackets; `size` bytes of one value; `dims` of the array it
    is, empty for a single value.
    """

    @property
    def path(self) -> str: ...
    @property
    def offset(self) -> int: ...
    @property
    def kind(self) -> str: ...
    @property
    def size(self) -> int: ...
    @property
    def dims(self) -> Sequence[int]: ...
    @property
    def access(self) -> object: ...
    @property
    def synchronous(self) -> bool: ...


@dataclass(frozen=True, slots=True)
class ExternalVariable:
    """A line of the directory."""

    path: str
    kind: str
    offset: int
    size: int
    dims: tuple[int, ...]
    access: str
    synchronous: bool


def external_area(hli: Hli) -> memoryview:
    """The area, EXTERNAL_BYTES bytes, writable."""
    return memoryview(hli.external).cast("B")


def describe_external(hli: Hli, entries: Iterable[ExternalEntry]) -> None:
    """Write the directory: the CNC, before anybody else attaches. Raises HliError for what the area cannot hold."""
    count = 0
    for entry in entries:
        end = entry.offset + entry.size * math.prod(entry.dims)
        fits = count < EXTERNAL_NAMES and len(entry.path.encode()) < EXTERNAL_PATH
        fits = fits and len(entry.dims) <= EXTERNAL_DIMENSIONS and entry.offset >= 0 and end <= EXTERNAL_BYTES
        if not fits or entry.kind not in KINDS or (entry.kind != TEXT and entry.size != size_of(entry.kind)):
            raise HliError(catalogue.EXTERNAL_NOT_LAID_OUT, path=entry.path, bytes=EXTERNAL_BYTES, names=EXTERNAL_NAMES)
        line = hli.external_names[count]
        put_text(line, "path_r", entry.path)
        put_text(line, "kind_r", entry.kind)
        put_text(line, "access_r", str(entry.access))
        line.offset_r, line.size_r, line.synchronous_r = entry.offset, entry.size, entry.synchronous
        for i in range(EXTERNAL_DIMENSIONS):
            line.dimensions_r[i] = entry.dims[i] if i < len(entry.dims) else 0
        count += 1
    hli.external_count_r = count


def external_variables(hli: Hli) -> list[ExternalVariable]:
    """The directory, in the order of the description."""
    return [
        ExternalVariable(
            path=get_text(line, "path_r"),
            kind=get_text(line, "kind_r"),
            offset=int(line.offset_r),
            size=int(line.size_r),
            dims=tuple(int(d) for d in line.dimensions_r if d),
            access=get_text(line, "access_r"),
            synchronous=bool(line.synchronous_r),
        )
        for line in hli.external_names[: hli.external_count_r]
    ]


def size_of(kind: str) -> int:
    """Bytes of one value; of a text it is the description's choice, 0 here."""
    return _FORMATS[kind][0].size if kind in _FORMATS else 0


def read_external(area: memoryview, offset: int, kind: str, size: int) -> float | int | str:
    """The value at `offset`; a text without its end mark. 0 or "" for a place outside of the area."""
    if kind not in _FORMATS:
        return bytes(area[offset : offset + size]).split(b"\0", 1)[0].decode("utf-8", "replace")
    stored = _FORMATS[kind][0]
    if not 0 <= offset <= len(area) - stored.size:
        return 0
    value: float | int = stored.unpack_from(area, offset)[0]
    return value


def write_external(area: memoryview, offset: int, kind: str, size: int, value: float | str) -> bool:
    """Store a value: whole numbers are rounded to the nearest (halves up) and end at the limits of their type, texts are cut.

    FALSE, and nothing is stored, for a value that is no number or no text, or a place outside of the area. Never raises.
    """
    if kind not in _FORMATS:
        return _write_text(area, offset, size, value)
    stored, least, greatest = _FORMATS[kind]
    if isinstance(value, str) or not 0 <= offset <= len(area) - stored.size:
        return False
    if kind in _REALS:
        if kind == "REAL32" and math.isfinite(value):
            value = max(-_GREATEST_REAL32, min(float(value), _GREATEST_REAL32))
        stored.pack_into(area, offset, value)
        return True
    if math.isnan(value):
        return False
    if kind == "BOOLEAN":
        whole = int(abs(value) >= 0.5)
    elif isinstance(value, int):
        whole = value
    elif math.isinf(value):
        whole = greatest if value > 0.0 else least
    else:
        whole = math.floor(value + 0.5)
    stored.pack_into(area, offset, max(least, min(whole, greatest)))
    return True


def _write_text(area: memoryview, offset: int, size: int, value: float | str) -> bool:
    if not isinstance(value, str) or size < 1 or not 0 <= offset <= len(area) - size:
        return False
    data = value.encode("utf-8", "replace")[: size - 1].decode("utf-8", "ignore").encode()
    area[offset : offset + size] = data.ljust(size, b"\0")
    return True
