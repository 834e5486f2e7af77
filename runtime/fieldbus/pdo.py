"""Process data objects: what is in them, and how a dictionary turns that into bytes.

A PDO is planned as a row of objects (`PdoPlan`), laid out with the types of an object dictionary (`PdoLayout`), which
gives one precompiled `struct` for all its values. Master and simulated nodes use the same.
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum
from struct import Struct
from typing import Final

import canopen
from canopen.objectdictionary import ODVariable, datatypes

INVALID: Final = 0x8000_0000  # bit 31 of a COB-ID: the PDO does not exist
NO_RTR: Final = 0x4000_0000  # bit 30 of a TPDO's COB-ID: no remote request
MAX_BITS: Final = 64

SYNCHRONOUS: Final = 1  # transmission types: with every SYNC,
EVENT: Final = 255  # when something changes
LAST_SYNCHRONOUS: Final = 240

PREDEFINED: Final = 4  # PDOs of one direction that have a COB-ID in the predefined connection set of CiA 301
LAST_PDO: Final = 512  # of one direction
FREE_COB_IDS: Final = range(0x680, 0x6E0)  # that CiA 301 gives to nobody: for PDOs beyond the predefined ones

STRUCT_CODES: Final[dict[int, str]] = {
    datatypes.INTEGER8: "b",
    datatypes.INTEGER16: "h",
    datatypes.INTEGER32: "i",
    datatypes.INTEGER64: "q",
    datatypes.UNSIGNED8: "B",
    datatypes.UNSIGNED16: "H",
    datatypes.UNSIGNED32: "I",
    datatypes.UNSIGNED64: "Q",
}
VALUE_RANGES: Final[dict[int, tuple[int, int]]] = {
    kind: (-(1 << bits - 1), (1 << bits - 1) - 1) if code.islower() else (0, (1 << bits) - 1)
    for kind, code in STRUCT_CODES.items()
    for bits in (Struct("<" + code).size * 8,)
}

ObjectKey = tuple[int, int]
"""Index and sub-index of an object."""


class Direction(Enum):
    """As the node sees it: the first communication parameter, the first mapping parameter, the first COB-ID."""

    RECEIVE = (0x1400, 0x1600, 0x200)
    TRANSMIT = (0x1800, 0x1A00, 0x180)


@dataclass(frozen=True, slots=True)
class PdoPlan:
    """One PDO of a node, numbered from 1: in the predefined connection set of CiA 301, or with a COB-ID of its own."""

    direction: Direction
    number: int
    objects: tuple[ObjectKey, ...]
    transmission: int = SYNCHRONOUS
    event_timer_ms: int = 0
    inhibit_time: int = 0  # in 100 µs: the shortest between two of them
    own_cob_id: int | None = None  # beyond the predefined ones

    @property
    def communication_index(self) -> int:
        return self.direction.value[0] + self.number - 1

    @property
    def mapping_index(self) -> int:
        return self.direction.value[1] + self.number - 1

    def cob_id(self, node: int) -> int:
        if self.own_cob_id is not None:
            return self.own_cob_id
        assert self.number <= PREDEFINED
        return self.direction.value[2] + 0x100 * (self.number - 1) + node


@dataclass(frozen=True, slots=True)
class PdoLayout:
    """The objects of a PDO and the one struct of all of them, little-endian."""

    objects: tuple[ObjectKey, ...]
    codec: Struct

    def mapping_entries(self, od: canopen.ObjectDictionary) -> list[int]:
        """What stands in the mapping parameter: index, sub-index, bits."""
        return [i << 16 | s << 8 | len(find_variable(od, i, s)) for i, s in self.objects]


def find_variable(od: canopen.ObjectDictionary, index: int, subindex: int = 0) -> ODVariable:
    """An entry of the dictionary; raises KeyError."""
    variable = od.get_variable(index, subindex)
    if variable is None or (variable.subindex != subindex):
        raise KeyError(object_name(index, subindex))
    return variable


def object_name(index: int, subindex: int = 0) -> str:
    """`0x60C2:1`, and `0x6085` for sub-index 0."""
    return f"0x{index:04X}:{subindex}" if subindex else f"0x{index:04X}"


def lay_out(od: canopen.ObjectDictionary, objects: tuple[ObjectKey, ...]) -> PdoLayout:
    """The layout of these objects with the types of `od`.

    Raises KeyError for an object that `od` does not have, ValueError for one that cannot be mapped, or
    if all are too long.
    """
    codes = "<"
    for index, subindex in objects:
        variable = find_variable(od, index, subindex)
        code = STRUCT_CODES.get(variable.data_type or 0)
        if code is None or not variable.pdo_mappable:
            raise ValueError(f"{object_name(index, subindex)} cannot be mapped into a PDO")
        codes += code
    codec = Struct(codes)
    if codec.size * 8 > MAX_BITS:
        raise ValueError(f"{codec.size * 8} bits do not fit into a PDO")
    return PdoLayout(objects, codec)
