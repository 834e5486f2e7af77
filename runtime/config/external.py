"""External variables (V.E): how they are described, and where each one lies in the area that CNC and PLC share.

The rule of the layout, which a PLC program in another language can follow as well, since it is that of C structures:

- variables lie in the order of the description, members in the order of their structure;
- a value of n bytes begins at a multiple of n: BOOLEAN, SGN08, UNS08 1; SGN16, UNS16 2; SGN32, UNS32 4; REAL64 8;
- STRING[n] takes n + 1 bytes (a zero ends the text) and begins anywhere;
- a structure begins at, and its size is rounded up to, a multiple of the greatest alignment among its members;
- the elements of an array follow each other without a gap, the last index counts fastest;
- numbers are little-endian, BOOLEAN is 0 or 1.

The area has 65536 bytes. Access rights and synchronism of a structure go down to its members, which may have their own.
"""

from __future__ import annotations

import math
import re
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass
from difflib import get_close_matches
from typing import TYPE_CHECKING, Annotated, Literal

from pydantic import Field

from runtime.config.contradictions import Contradiction, Location
from runtime.config.model import Model, Several
from runtime.diagnostics.catalogue import configuration as errors

if TYPE_CHECKING:
    from runtime.config.machine import Machine

AREA_SIZE = 65536  # bytes
SIZES = {"BOOLEAN": 1, "SGN08": 1, "UNS08": 1, "SGN16": 2, "UNS16": 2, "SGN32": 4, "UNS32": 4, "REAL64": 8}
_NAME = re.compile(r"[A-Za-z_]\w{0,63}\Z", re.ASCII)
_STRING = re.compile(r"STRING\[(\d{1,5})\]\Z")
_INDEX = re.compile(r"\[(\d+)\]")

Access = Literal["read", "write", "read_write"]
Extent = Annotated[int, Field(ge=1, le=AREA_SIZE)]


class Member(Model):
    """A member of a structure; without `access` and `synchronous` it has those of what it is a member of."""

    name: str
    type: str  # an elementary type, STRING[n], or the name of a structure
    dims: Several[Extent] = Field(default=(), max_length=8)
    access: Access | None = None
    synchronous: bool | None = None


class ExternalVariable(Model):
    """An external variable; `access` is what NC programs may do."""

    name: str
    type: str
    dims: Several[Extent] = Field(default=(), max_length=8)
    access: Access = "read_write"
    synchronous: bool = False  # read and written when the path is there, not when the program is decoded


class ExternalError(LookupError):
    """A path or index that leads to no external variable; the text says why."""


@dataclass(frozen=True, slots=True)
class ExternalElement:
    """An external variable, a member of one, or an array of them.

    `path` is the name without indices ("TOOL.OFFSET"), `type` an elementary type, STRING or the name of a structure;
    `size` the bytes of one element. `dims` and `strides` (in bytes) belong to all indices along the path, from the
    left; `offset` is where the element with all indices 0 begins, in bytes from the start of the area.
    """

    path: str
    type: str
    offset: int
    size: int
    dims: tuple[int, ...]
    strides: tuple[int, ...]
    access: Access
    synchronous: bool
    elementary: bool

    @property
    def readable(self) -> bool:
        return self.access != "write"

    @property
    def writable(self) -> bool:
        return self.access != "read"

    def at(self, indices: Sequence[int]) -> int:
        """The offset of the element with these indices; raises ExternalError."""
        if len(indices) != len(self.dims):
            raise ExternalError(f"V.E.{self.path} has {len(self.dims)} indices, not {len(indices)}")
        offset = self.offset
        for index, extent, stride in zip(indices, self.dims, self.strides, strict=True):
            if not 0 <= index < extent:
                raise ExternalError(f"V.E.{self.path}: index {index} is not within 0 to {extent - 1}")
            offset += index * stride
        return offset


@dataclass(frozen=True, slots=True)
class ExternalPlace:
    """One element of an external variable; `offset` and `size` in bytes."""

    path: str
    type: str
    offset: int
    size: int
    access: Access
    synchronous: bool


@dataclass(frozen=True, slots=True)
class ExternalLayout:
    """Where the external variables lie: path without indices → element; `size` bytes are in use."""

    elements: Mapping[str, ExternalElement]
    size: int

    @classmethod
    def of(cls, machine: Machine) -> ExternalLayout:
        """The layout of a machine's variables, in the order of its description."""
        return cls.lay_out(machine.structures, machine.external_variables)

    @classmethod
    def lay_out(
        cls, structures: Mapping[str, Sequence[Member]], variables: Sequence[ExternalVariable]
    ) -> ExternalLayout:
        """The layout of described variables, which have to be free of mistakes (`external_mistakes`)."""
        elements: dict[str, ExternalElement] = {}
        end = 0
        for variable in variables:
            size, alignment = _measure(variable.type, structures)
            begin = _rounded_up(end, alignment)
            for element in _elements(variable, "", begin, (), (), variable.access, variable.synchronous, structures):
                elements[element.path] = element
            end = begin + size * math.prod(variable.dims)
        return cls(elements, end)

    def element(self, path: str) -> ExternalElement:
        """The element at a path without indices; raises ExternalError with the nearest path."""
        found = self.elements.get(path)
        if found is None:
            close = get_close_matches(path, self.elements, n=1)
            raise ExternalError(f"V.E.{path} is not described" + (f"; do you mean V.E.{close[0]}?" if close else ""))
        return found

    def resolve(self, path: str, *indices: int) -> ExternalPlace:
        """One element: `resolve("TOOL[2].OFFSET[1]")` or `resolve("TOOL.OFFSET", 2, 1)`; raises ExternalError."""
        written = [int(index) for index in _INDEX.findall(path)]
        element = self.element(_INDEX.sub("", path))
        offset = element.at((*written, *indices))
        return ExternalPlace(element.path, element.type, offset, element.size, element.access, element.synchronous)

    def leaves(self, path: str) -> tuple[ExternalElement, ...]:
        """The elementary elements at and below a path without indices; raises ExternalError."""
        self.element(path)
        return tuple(
            element
            for name, element in self.elements.items()
            if element.elementary and (name == path or name.startswith(path + "."))
        )


def _elements(
    described: ExternalVariable | Member,
    above: str,
    offset: int,
    dims: tuple[int, ...],
    strides: tuple[int, ...],
    access: Access,
    synchronous: bool,
    structures: Mapping[str, Sequence[Member]],
) -> Iterator[ExternalElement]:
    """The element of a variable or member that begins at `offset`, and those below it."""
    size, _ = _measure(described.type, structures)
    path = f"{above}.{described.name}" if above else described.name
    own = [size * math.prod(described.dims[i + 1 :]) for i in range(len(described.dims))]
    dims, strides = (*dims, *described.dims), (*strides, *own)
    members = structures.get(described.type)
    kind = "STRING" if _STRING.match(described.type) else described.type
    yield ExternalElement(path, kind, offset, size, dims, strides, access, synchronous, members is None)
    end = offset
    for member in members or ():
        member_size, alignment = _measure(member.type, structures)
        begin = _rounded_up(end, alignment)
        member_access = access if member.access is None else member.access
        member_synchronous = synchronous if member.synchronous is None else member.synchronous
        yield from _elements(member, path, begin, dims, strides, member_access, member_synchronous, structures)
        end = begin + member_size * math.prod(member.dims)


def _measure(name: str, structures: Mapping[str, Sequence[Member]]) -> tuple[int, int]:
    """Size and alignment of one value of a type, in bytes."""
    if name in SIZES:
        return SIZES[name], SIZES[name]
    if text := _STRING.match(name):
        return int(text[1]) + 1, 1
    end, greatest = 0, 1
    for member in structures[name]:
        size, alignment = _measure(member.type, structures)
        end = _rounded_up(end, alignment) + size * math.prod(member.dims)
        greatest = max(greatest, alignment)
    return _rounded_up(end, greatest), greatest


def _rounded_up(offset: int, alignment: int) -> int:
    return -(-offset // alignment) * alignment


def external_mistakes(
    structures: Mapping[str, Sequence[Member]], variables: Sequence[ExternalVariable]
) -> Iterator[Contradiction]:
    """What is wrong in the description of the external variables; locations count from the machine."""
    found = [*_names(structures, variables), *_types(structures, variables)]
    if not found:
        found = [*_recursions(structures)]
    if found:
        yield from found
        return
    for index, _ in enumerate(variables):
        size = ExternalLayout.lay_out(structures, variables[: index + 1]).size
        if size > AREA_SIZE:
            values = {"size": size, "name": variables[index].name, "area": AREA_SIZE}
            yield Contradiction(errors.EXTERNAL_TOO_LARGE, ("external_variables", index), values)
            return


def _described(
    structures: Mapping[str, Sequence[Member]], variables: Sequence[ExternalVariable]
) -> Iterator[tuple[Location, str, Sequence[Member | ExternalVariable]]]:
    """Every list of members or variables: where it stands, what its items are called, the items."""
    for name, members in structures.items():
        yield ("structures", name), f"Member of {name}", members
    yield ("external_variables",), "External variable", variables


def _names(
    structures: Mapping[str, Sequence[Member]], variables: Sequence[ExternalVariable]
) -> Iterator[Contradiction]:
    for name in structures:
        if not _NAME.match(name) or name in SIZES or name == "STRING":
            yield Contradiction(errors.EXTERNAL_NAME, ("structures", name), {"key": "structures", "given": name}, True)
    for location, what, items in _described(structures, variables):
        seen: set[str] = set()
        for index, item in enumerate(items):
            here: Location = (*location, index, "name")
            if not _NAME.match(item.name):
                yield Contradiction(errors.EXTERNAL_NAME, here, {"key": "name", "given": item.name})
            if item.name in seen:
                yield Contradiction(errors.EXTERNAL_TWICE, here, {"what": what, "name": item.name})
            seen.add(item.name)


def _types(
    structures: Mapping[str, Sequence[Member]], variables: Sequence[ExternalVariable]
) -> Iterator[Contradiction]:
    known = [*SIZES, "STRING[n]", *structures]
    for location, _, items in _described(structures, variables):
        for index, item in enumerate(items):
            text = _STRING.match(item.type)
            if item.type in SIZES or item.type in structures or (text and 1 <= int(text[1]) < AREA_SIZE):
                continue
            close = get_close_matches(item.type, known, n=1)
            values = {
                "key": f"type of {item.name}",
                "given": item.type,
                "suggestion": f"; do you mean {close[0]!r}?" if close else "",
                "known": ", ".join(known),
            }
            yield Contradiction(errors.EXTERNAL_TYPE, (*location, index, "type"), values)


def _recursions(structures: Mapping[str, Sequence[Member]]) -> Iterator[Contradiction]:
    """Structures that contain themselves, directly or through others."""
    finished: set[str] = set()

    def walk(name: str, above: tuple[str, ...]) -> Iterator[Contradiction]:
        if name in above:
            way = " → ".join((*above[above.index(name) :], name))
            yield Contradiction(errors.EXTERNAL_RECURSION, ("structures", name), {"name": name, "way": way}, True)
            return
        if name in finished:
            return
        finished.add(name)
        for member in structures[name]:
            if member.type in structures:
                yield from walk(member.type, (*above, name))

    for name in structures:
        yield from walk(name, ())
