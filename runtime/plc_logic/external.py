"""The external variables (V.E) by name, as the program sees them.

    self.external.PART_COUNT += 1
    self.external.TOOL.LENGTH = 120.5
    self.external.GRID[2][3] = True
    if self.external.PALLET[1].LOADED: ...

Nothing is buffered: what is read is what stands there now, what is written the NC program sees at once. The names come from the
directory in the HLI.
"""

from __future__ import annotations

import difflib
import math
from collections.abc import Iterable, Iterator
from dataclasses import dataclass, field
from typing import Any, TypeAlias

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.hli.external import (
    TEXT,
    ExternalVariable,
    external_area,
    external_variables,
    read_external,
    write_external,
)
from runtime.hli.layout import Hli
from runtime.plc_logic.errors import PlcError

Value: TypeAlias = float | int | bool | str


@dataclass(slots=True)
class _Shape:
    """What stands at a name, whatever its indices are: a variable, or a structure with what is below it.

    `depth` is how many indices stand in front of its own, `extents` are those of its own.
    """

    path: str
    area: memoryview
    depth: int = 0
    extents: tuple[int, ...] = ()
    variable: ExternalVariable | None = None
    below: dict[str, _Shape] = field(default_factory=dict)

    def child(self, name: str) -> _Shape:
        found = self.below.get(name)
        if found is None:
            near = difflib.get_close_matches(name, self.below, n=3) or list(self.below)
            path = f"{self.path}.{name}" if self.path else name
            raise PlcError(catalogue.PLC_EXTERNAL_NAME, path=path, known=", ".join(near) or "none")
        return found

    def get(self, indices: tuple[int, ...]) -> External:
        """What stands here at these indices, those of the levels above included."""
        if len(indices) < self.depth + len(self.extents):
            return ExternalArray(self, indices)
        variable = self.variable
        if variable is None:
            return ExternalStructure(self, indices)
        value = read_external(self.area, _offset(variable, indices), variable.kind, variable.size)
        return bool(value) if variable.kind == "BOOLEAN" else value

    def set(self, indices: tuple[int, ...], value: object) -> None:
        """Give the variable here its value."""
        variable = self.variable
        whole = len(indices) < self.depth + len(self.extents)
        kind = "array" if whole else "structure" if variable is None else variable.kind
        good = isinstance(value, str) if kind == TEXT else isinstance(value, bool | int | float)
        if whole or variable is None or not good or (isinstance(value, float) and math.isnan(value)):
            raise PlcError(catalogue.PLC_EXTERNAL_VALUE, path=_spelt(self.path, indices), kind=kind, value=value)
        assert isinstance(value, bool | int | float | str)
        write_external(self.area, _offset(variable, indices), variable.kind, variable.size, value)


def _offset(variable: ExternalVariable, indices: tuple[int, ...]) -> int:
    return variable.offset + sum(map(int.__mul__, indices, variable.strides))


def _spelt(path: str, indices: tuple[int, ...]) -> str:
    """The path with indices in the place of their marks; those that are not given yet vanish."""
    for index in indices:
        path = path.replace("[]", f"[{index}]", 1)
    return path.replace("[]", "")


class ExternalStructure:
    """Elements by name; an unknown name, or a value that does not fit, raises PlcError."""

    __slots__ = ("_indices", "_shape")

    _shape: _Shape
    _indices: tuple[int, ...]

    def __init__(self, shape: _Shape, indices: tuple[int, ...]) -> None:
        object.__setattr__(self, "_shape", shape)
        object.__setattr__(self, "_indices", indices)

    def __getattr__(self, name: str) -> Any:  # which type it is, only the machine description knows
        if name.startswith("__"):
            raise AttributeError(name)
        return self._shape.child(name).get(self._indices)

    def __setattr__(self, name: str, value: object) -> None:
        self._shape.child(name).set(self._indices, value)

    def __dir__(self) -> Iterable[str]:
        return list(self._shape.below)


class ExternalArray:
    """Elements by index from 0; an index outside raises PlcError."""

    __slots__ = ("_extent", "_indices", "_shape")

    def __init__(self, shape: _Shape, indices: tuple[int, ...]) -> None:
        self._shape, self._indices = shape, indices
        self._extent = shape.extents[len(indices) - shape.depth]

    def __len__(self) -> int:
        return self._extent

    def __getitem__(self, index: int) -> Any:
        return self._shape.get(self._with(index))

    def __setitem__(self, index: int, value: object) -> None:
        self._shape.set(self._with(index), value)

    def __iter__(self) -> Iterator[Any]:
        return (self[index] for index in range(self._extent))

    def _with(self, index: int) -> tuple[int, ...]:
        if not 0 <= index < self._extent:
            path = _spelt(self._shape.path, self._indices)
            raise PlcError(catalogue.PLC_EXTERNAL_INDEX, path=path, index=index, last=self._extent - 1)
        return (*self._indices, index)


External: TypeAlias = Value | ExternalStructure | ExternalArray


def external_of(hli: Hli) -> ExternalStructure:
    """All external variables of the directory in the HLI."""
    area = external_area(hli)
    root = _Shape("", area)
    for variable in external_variables(hli):
        here = root
        parts = variable.path.split(".")
        for level, part in enumerate(parts, 1):
            depth, own = here.depth + len(here.extents), part.count("[]")
            path = ".".join(parts[:level])
            shape = _Shape(path, area, depth, variable.dims[depth : depth + own])
            here = here.below.setdefault(part.removesuffix("[]" * own), shape)
        here.variable = variable
    return ExternalStructure(root, ())
