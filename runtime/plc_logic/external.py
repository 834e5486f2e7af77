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
import re
from collections.abc import Iterable, Iterator, Mapping
from typing import TypeAlias

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
_INDEX = re.compile(r"\[(\d+)\]")


class _Place:
    """One value: how it is read and written."""

    __slots__ = ("area", "kind", "offset", "path", "size")

    def __init__(self, area: memoryview, path: str, kind: str, offset: int, size: int) -> None:
        self.area, self.path, self.kind, self.offset, self.size = area, path, kind, offset, size

    def read(self) -> Value:
        value = read_external(self.area, self.offset, self.kind, self.size)
        return bool(value) if self.kind == "BOOLEAN" else value

    def write(self, value: object) -> None:
        good = isinstance(value, str) if self.kind == TEXT else isinstance(value, bool | int | float)
        if not good or (isinstance(value, float) and math.isnan(value)):
            raise PlcError(catalogue.PLC_EXTERNAL_VALUE, path=self.path, kind=self.kind, value=value)
        assert isinstance(value, bool | int | float | str)
        write_external(self.area, self.offset, self.kind, self.size, value)


class ExternalStructure:
    """Elements by name; an unknown name, or a value that does not fit, raises PlcError."""

    __slots__ = ("_elements", "_path")

    _elements: Mapping[str, _Element]
    _path: str

    def __init__(self, path: str, elements: Mapping[str, _Element]) -> None:
        object.__setattr__(self, "_path", path)
        object.__setattr__(self, "_elements", elements)

    def __getattr__(self, name: str) -> External:
        if name.startswith("__"):
            raise AttributeError(name)
        return _get(self._element(name))

    def __setattr__(self, name: str, value: object) -> None:
        _set(self._element(name), value)

    def __dir__(self) -> Iterable[str]:
        return list(self._elements)

    def _element(self, name: str) -> _Element:
        element = self._elements.get(name)
        if element is None:
            near = difflib.get_close_matches(name, self._elements, n=3) or list(self._elements)
            path = f"{self._path}.{name}" if self._path else name
            raise PlcError(catalogue.PLC_EXTERNAL_NAME, path=path, known=", ".join(near) or "none")
        return element


class ExternalArray:
    """Elements by index from 0; an index outside raises PlcError."""

    __slots__ = ("_elements", "_path")

    def __init__(self, path: str, elements: Mapping[int, _Element]) -> None:
        self._path, self._elements = path, elements

    def __len__(self) -> int:
        return max(self._elements, default=-1) + 1

    def __getitem__(self, index: int) -> External:
        return _get(self._element(index))

    def __setitem__(self, index: int, value: object) -> None:
        _set(self._element(index), value)

    def __iter__(self) -> Iterator[External]:
        return (_get(self._elements[index]) for index in sorted(self._elements))

    def _element(self, index: int) -> _Element:
        element = self._elements.get(index)
        if element is None:
            raise PlcError(catalogue.PLC_EXTERNAL_INDEX, path=self._path, index=index, last=len(self) - 1)
        return element


_Element: TypeAlias = _Place | ExternalStructure | ExternalArray
External: TypeAlias = Value | ExternalStructure | ExternalArray


def _get(element: _Element) -> External:
    return element.read() if isinstance(element, _Place) else element


def _set(element: _Element, value: object) -> None:
    if not isinstance(element, _Place):
        kind = "structure" if isinstance(element, ExternalStructure) else "array"
        raise PlcError(catalogue.PLC_EXTERNAL_VALUE, path=element._path, kind=kind, value=value)
    element.write(value)


_Tree = dict[str | int, "_Tree | _Place"]


def external_of(hli: Hli) -> ExternalStructure:
    """All external variables of the directory in the HLI."""
    root: _Tree = {}
    area = external_area(hli)
    for variable in external_variables(hli):
        _plant(root, area, variable)
    return _structure("", root)


def _plant(root: _Tree, area: memoryview, variable: ExternalVariable) -> None:
    """Put every value of a variable to its place in the tree of names and indices."""
    way: list[str | int] = []
    for part in variable.path.split("."):
        way += [part.partition("[")[0], *(int(index) for index in _INDEX.findall(part))]
    for count in range(math.prod(variable.dims)):
        indices: list[int] = []
        rest = count
        for dimension in reversed(variable.dims):
            rest, index = divmod(rest, dimension)
            indices.insert(0, index)
        path = variable.path + "".join(f"[{index}]" for index in indices)
        place = _Place(area, path, variable.kind, variable.offset + count * variable.size, variable.size)
        here = root
        steps = [*way, *indices]
        for step in steps[:-1]:
            below = here.setdefault(step, {})
            if isinstance(below, _Place):
                break  # a name that is a variable and a structure: the first one stays
            here = below
        else:
            here.setdefault(steps[-1], place)


def _structure(path: str, tree: _Tree) -> ExternalStructure:
    elements = {str(name): _grown(f"{path}.{name}" if path else str(name), below) for name, below in tree.items()}
    return ExternalStructure(path, elements)


def _grown(path: str, tree: _Tree | _Place) -> _Element:
    if isinstance(tree, _Place):
        return tree
    if all(isinstance(key, int) for key in tree):
        return ExternalArray(path, {int(i): _grown(f"{path}[{i}]", below) for i, below in tree.items()})
    return _structure(path, tree)
