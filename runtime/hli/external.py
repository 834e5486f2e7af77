"""The external variables (V.E): an area of bytes that NC program and PLC share, and the directory of what lies where.

The kernel gives the values no meaning. They are zero at start-up and stay over program changes and resets. A value is written
by one store of its size, so nobody sees half a number; texts end with a zero byte and are not guarded.
"""

from __future__ import annotations

import math
import struct
from collections.abc import Iterable, Mapping
from dataclasses import dataclass
from typing import Protocol

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.errors import HliError
from runtime.hli.layout import EXTERNAL_BYTES, EXTERNAL_INDICES, EXTERNAL_NAMES, EXTERNAL_PATH, Hli
from runtime.hli.memory import get_text, put_text

TEXT = "STRING"
ENCODING = "latin-1"  # one byte per letter: a text of n letters fits into n bytes and its end mark
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


class _Extent(Protocol):
    """Where values lie, and who may do what with them."""

    @property
    def offset(self) -> int: ...
    @property
    def size(self) -> int: ...
    @property
    def dims(self) -> tuple[int, ...]: ...
    @property
    def strides(self) -> tuple[int, ...]: ...
    @property
    def access(self) -> str: ...
    @property
    def synchronous(self) -> bool: ...


class ExternalEntry(_Extent, Protocol):
    """An elementary variable, or an elementary element of a structure, as the machine description lays it out.

    `path` as it is written, with [] where an index belongs, with or without "V.E." in front; `offset` of the value with all
    indices 0; `dims` and `strides` (bytes) of the indices from the left; `size` bytes of one value.
    """

    @property
    def path(self) -> str: ...
    @property
    def kind(self) -> str: ...


@dataclass(frozen=True, slots=True)
class ExternalVariable:
    """A line of the directory; see `ExternalEntry`."""

    path: str
    kind: str
    offset: int
    size: int
    dims: tuple[int, ...]
    strides: tuple[int, ...]
    access: str
    synchronous: bool


class _LaidOut(_Extent, Protocol):
    """An element of a layout whose paths have no marks of indices, at every level of its structures."""

    @property
    def type(self) -> str: ...
    @property
    def elementary(self) -> bool: ...


def directory_of(elements: Mapping[str, _LaidOut]) -> list[ExternalVariable]:
    """The directory of a layout: its elementary elements, with [] where their indices belong.

    An element has the indices of what it is part of, and then its own: so the ones of each level are known from both.
    """
    variables = []
    for path, element in elements.items():
        if not element.elementary:
            continue
        names = path.split(".")
        marked, before = [], 0
        for level, name in enumerate(names, 1):
            here = len(elements[".".join(names[:level])].dims)
            marked.append(name + "[]" * (here - before))
            before = here
        variables.append(
            ExternalVariable(
                ".".join(marked),
                element.type,
                element.offset,
                element.size,
                element.dims,
                element.strides,
                element.access,
                element.synchronous,
            )
        )
    return variables


def external_area(hli: Hli) -> memoryview:
    """The area, EXTERNAL_BYTES bytes, writable."""
    return memoryview(hli.external).cast("B")


def describe_external(hli: Hli, entries: Iterable[ExternalEntry]) -> None:
    """Write the directory: the CNC, before anybody else attaches. Raises HliError for what the area cannot hold."""
    count = 0
    for entry in entries:
        path = entry.path.removeprefix("V.E.")
        if count >= EXTERNAL_NAMES or not _fits(entry, path):
            raise HliError(catalogue.EXTERNAL_NOT_LAID_OUT, path=path, bytes=EXTERNAL_BYTES, names=EXTERNAL_NAMES)
        line = hli.external_names[count]
        put_text(line, "path_r", path)
        put_text(line, "kind_r", entry.kind)
        put_text(line, "access_r", entry.access)
        line.offset_r, line.size_r, line.synchronous_r = entry.offset, entry.size, entry.synchronous
        for i in range(EXTERNAL_INDICES):
            line.extents_r[i] = entry.dims[i] if i < len(entry.dims) else 0
            line.strides_r[i] = entry.strides[i] if i < len(entry.dims) else 0
        count += 1
    hli.external_count_r = count


def _fits(entry: ExternalEntry, path: str) -> bool:
    """Every value of it lies in the area, and the directory has room for its name and its indices."""
    dims, strides, size = entry.dims, entry.strides, entry.size
    if len(path.encode()) >= EXTERNAL_PATH or not path.count("[]") == len(dims) == len(strides) <= EXTERNAL_INDICES:
        return False
    if entry.kind not in KINDS or size < 1 or (entry.kind != TEXT and size != size_of(entry.kind)):
        return False
    if any(extent < 1 for extent in dims) or any(stride < 1 for stride in strides):
        return False
    last = entry.offset + sum((extent - 1) * stride for extent, stride in zip(dims, strides, strict=True))
    return entry.offset >= 0 and last + size <= EXTERNAL_BYTES


def external_variables(hli: Hli) -> list[ExternalVariable]:
    """The directory, in the order of the description."""
    variables = []
    for line in hli.external_names[: min(hli.external_count_r, EXTERNAL_NAMES)]:
        dims = tuple(int(extent) for extent in line.extents_r if extent)
        variables.append(
            ExternalVariable(
                path=get_text(line, "path_r"),
                kind=get_text(line, "kind_r"),
                offset=int(line.offset_r),
                size=int(line.size_r),
                dims=dims,
                strides=tuple(int(stride) for stride in line.strides_r[: len(dims)]),
                access=get_text(line, "access_r"),
                synchronous=bool(line.synchronous_r),
            )
        )
    return variables


def size_of(kind: str) -> int:
    """Bytes of one value; of a text it is the description's choice, 0 here."""
    return _FORMATS[kind][0].size if kind in _FORMATS else 0


def read_external(area: memoryview, offset: int, kind: str, size: int) -> float | int | str:
    """The value at `offset`; a text without its end mark. 0 or "" for a place outside of the area."""
    if kind not in _FORMATS:
        return bytes(area[offset : offset + size]).split(b"\0", 1)[0].decode(ENCODING)
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
    area[offset : offset + size] = value.encode(ENCODING, "replace")[: size - 1].ljust(size, b"\0")
    return True
