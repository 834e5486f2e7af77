"""What memories consist of: the elementary items of a ctypes structure or of a record of NumPy."""

from __future__ import annotations

import ctypes as c
from collections.abc import Iterable, Iterator
from dataclasses import dataclass
from typing import Any

import numpy as np

_FLAG_END = "_rw"
_FLAGS = frozenset(  # guards that are no semaphores: counted up, or raised, behind the data
    {
        "plc_error_count_w", "process_lost_w", "sequence_r", "sequence", "alarm_count_r", "external_count_r", "magic_r",
        "done_w", "plc_present_w", "not_retained_w",
    }
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Element:
    """An elementary item of a memory: where it lies, its size in bytes (1 for text), whether it guards others, and what it is
    (character of a NumPy type)."""

    name: str
    offset: int
    size: int
    count: int
    flag: bool
    kind: str = "B"


def elements_of(kind: Any, name: str = "", offset: int = 0) -> Iterator[Element]:
    """Every elementary item of a ctypes structure; arrays of elementary items are one item."""
    if issubclass(kind, c.Structure):
        for field, of, *_ in kind._fields_:
            yield from elements_of(of, f"{name}.{field}" if name else field, offset + getattr(kind, field).offset)
        return
    if issubclass(kind, c.Array):
        of = kind._type_
        if not issubclass(of, c.Structure | c.Array):
            yield Element(name, offset, c.sizeof(of), kind._length_, False, np.dtype(of).char)
            return
        for i in range(kind._length_):
            yield from elements_of(of, f"{name}[{i}]", offset + i * c.sizeof(of))
        return
    last = name.rsplit(".", 1)[-1]
    yield Element(name, offset, c.sizeof(kind), 1, last.endswith(_FLAG_END) or last in _FLAGS, np.dtype(kind).char)


def elements_of_record(kind: np.dtype[Any], flags: Iterable[str], offset: int = 0) -> Iterator[Element]:
    """The items of one record of a NumPy type; `flags` are the names of those that guard others."""
    for name in kind.names or ():
        of, at = kind.fields[name][:2]  # type: ignore[index]
        base, shape = (of.subdtype[0], of.subdtype[1]) if of.subdtype else (of, ())
        text = base.kind == "S"
        count = int(np.prod(shape, dtype=np.int64)) * (base.itemsize if text else 1)
        yield Element(name, offset + at, 1 if text else base.itemsize, count, name in flags, "B" if text else base.char)
