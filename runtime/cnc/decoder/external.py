"""External variables (V.E): named places in an area that program, PLC and operator share (programming manual 22131–22226).

An asynchronous variable is read and written at decoding time. A synchronous one belongs to the interpolator: writing it is a
block of its own in the stream, reading it lets the preparation come into step first.
"""

from __future__ import annotations

import itertools
import struct
from collections.abc import Callable, Iterable
from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.cnc.blocks import ExternalWrite
from runtime.cnc.decoder.outside import Outside
from runtime.cnc.decoder.user_variables import Type
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.hli.external import ExternalEntry

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

FORMATS = {
    "BOOLEAN": "<B",
    "SGN08": "<b",
    "UNS08": "<B",
    "SGN16": "<h",
    "UNS16": "<H",
    "SGN32": "<i",
    "UNS32": "<I",
    "REAL64": "<d",
}


@dataclass(slots=True)
class ExternalItem:
    """An elementary variable, bound to the running program."""

    entry: ExternalEntry
    outside: Outside
    execution: Execution

    @property
    def kind(self) -> ValueKind:
        return ValueKind.STRING if self.entry.kind == "STRING" else ValueKind.NUMBER

    @property
    def synchronous(self) -> bool:
        return self.entry.synchronous

    @property
    def writable(self) -> bool:
        return "w" in self.entry.access

    def place(self, indices: tuple[float, ...]) -> int:
        """Offset of an element; CalculationError for an index out of range."""
        entry, offset = self.entry, self.entry.offset
        for index, count, stride in zip(indices, entry.dims, entry.strides, strict=True):
            if not -0.5 <= index < count - 0.5:
                raise CalculationError(catalogue.ARRAY_INDEX, "V.E.", name=entry.path, value=index, last=count - 1)
            offset += round_half_up(index) * stride
        return offset

    def read(self, *indices: float) -> float | str:
        entry, offset = self.entry, self.place(indices)
        if entry.kind == "STRING":
            raw = bytes(self.outside.external[offset : offset + entry.size])
            return raw.split(b"\0", 1)[0].decode("latin-1")
        return float(struct.unpack_from(FORMATS[entry.kind], self.outside.external, offset)[0])

    def write(self, value: object, *indices: float) -> None:
        """At once, or in the stream if the variable is synchronous."""
        entry, offset = self.entry, self.place(indices)
        kind = Type("STRING", entry.size - 1) if entry.kind == "STRING" else Type(entry.kind)
        self._put(offset, kind.converted(value, entry.path), entry.synchronous)

    def clear(self, indices: tuple[float, ...], synchronous: bool) -> None:
        """Set every element whose first indices are given to zero; in the stream if `synchronous`."""
        entry = self.entry
        kind: float | str = "" if entry.kind == "STRING" else 0.0
        for rest in itertools.product(*(range(count) for count in entry.dims[len(indices) :])):
            self._put(self.place((*indices, *map(float, rest))), kind, synchronous)

    def _put(self, offset: int, fitting: float | str, synchronous: bool) -> None:
        entry = self.entry
        if synchronous:
            x = self.execution
            x.emit(ExternalWrite(x.source_in_work(), offset, entry.kind, entry.size, fitting))
            return
        put(self.outside.external, offset, entry.kind, entry.size, fitting)

    def exists(self, *indices: float) -> float:
        try:
            self.place(indices)
        except (CalculationError, ValueError):
            return 0.0
        return 1.0


def put(area: memoryview, offset: int, kind: str, size: int, value: float | str) -> None:
    """Write a value that fits its type into the area."""
    if isinstance(value, str):
        area[offset : offset + size] = value.encode("latin-1", "replace")[: size - 1].ljust(size, b"\0")
    elif kind == "REAL64":
        struct.pack_into("<d", area, offset, value)
    else:
        struct.pack_into(FORMATS[kind], area, offset, round_half_up(value))


def _full(path: str) -> str:
    """The path as programs write it."""
    return path if path.startswith("V.E.") else f"V.E.{path}"


class ExternalVariables:
    """The external variables that are configured, by their paths."""

    def __init__(self, entries: Iterable[ExternalEntry], outside: Outside, execution: Execution) -> None:
        self._items = {_full(entry.path): ExternalItem(entry, outside, execution) for entry in entries}

    def item(self, path: str, column: int) -> ExternalItem:
        """The variable of a path; LineError if it is not configured or names a structure."""
        item = self._items.get(path)
        if item is None:
            shown = path.replace("[]", "[..]")
            if any(name.startswith(f"{path}[") for name in self._items):
                raise LineError(catalogue.ARRAY_NEEDED, column, name=path, given=0)
            known = ", ".join(sorted({name.split(".")[2].split("[")[0] for name in self._items})) or "none"
            raise LineError(
                catalogue.VARIABLE_UNKNOWN, column, name=shown, hint=f"configured external variables: {known}"
            )
        return item

    def below(self, path: str) -> list[ExternalItem]:
        """All elementary variables of a variable, array or structure."""
        return [item for name, item in self._items.items() if name == path or name.startswith((f"{path}.", f"{path}["))]

    def sizes(self, path: str) -> Callable[..., float]:
        """A callable that gives the sizes of an array's dimensions."""
        items = self.below(path)
        known = path.count("[]")
        prefix = path

        def size(dimension: float, *_: float) -> float:
            if not items:
                return -1.0
            own = 0
            rest = _full(items[0].entry.path)[len(prefix) :]
            while rest.startswith("[]"):
                own, rest = own + 1, rest[2:]
            if not 0.5 <= dimension < own + 0.5:
                return -1.0
            return float(items[0].entry.dims[known + round_half_up(dimension) - 1])

        return size
