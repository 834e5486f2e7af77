"""The variables that programs make themselves: V.P, V.S, V.L, V.CYC, P arrays (programming manual 21800–22129).

A `Scope` is one set of them. Scalars are plain dictionary entries; arrays and typed variables carry what their declaration says.
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.diagnostics.catalogue import language as catalogue

DIMENSIONS = 4  # of an array (line 21951)
MAX_ELEMENTS = 1_000_000
STRING_MOST = 126  # characters of STRING[i] (line 21865)

_INTEGERS = {
    "BOOLEAN": (0, 1),
    "SGN08": (-(2**7), 2**7 - 1),
    "UNS08": (0, 2**8 - 1),
    "SGN16": (-(2**15), 2**15 - 1),
    "UNS16": (0, 2**16 - 1),
    "SGN32": (-(2**31), 2**31 - 1),
    "UNS32": (0, 2**32 - 1),
}
_BYTES = {"BOOLEAN": 1, "08": 1, "16": 2, "32": 4, "64": 8}  # by the last letters of the name
_STRING = re.compile(r"STRING(?:\[(\d+)\])?$")


@dataclass(frozen=True, slots=True)
class Type:
    """A declared type: `name`, for strings the greatest length."""

    name: str
    length: int = 0

    @classmethod
    def of(cls, text: str) -> Type:
        """From the text of a declaration; "" is REAL64. CalculationError for what is no type."""
        if not text or text == "REAL64":
            return REAL
        match = _STRING.match(text)
        if match:
            length = int(match.group(1) or STRING_MOST)
            if length > STRING_MOST:
                raise CalculationError(catalogue.TYPE_INVALID, text, type=text)
            return cls("STRING", length)
        if text not in _INTEGERS:
            raise CalculationError(catalogue.TYPE_INVALID, text, type=text)
        return cls(text)

    @property
    def bytes(self) -> int:
        """What a value takes in the memory of V.CYC variables; a string with the zero behind it."""
        if self.name == "STRING":
            return self.length + 1
        return _BYTES.get(self.name) or _BYTES[self.name[-2:]]

    @property
    def initial(self) -> float | str:
        """What a variable holds without an initial value."""
        return "" if self.name == "STRING" else 0.0

    def converted(self, value: object, name: str) -> float | str:
        """`value` as the type holds it: whole numbers rounded, halves upward. CalculationError if it does not fit."""
        if isinstance(value, np.ndarray):
            raise CalculationError(catalogue.SETS_MIXED, name)
        if self.name == "STRING":
            if not isinstance(value, str):
                raise CalculationError(catalogue.NUMBER_NOT_ALLOWED, name, what=name)
            if len(value) > self.length:
                raise CalculationError(catalogue.STRING_TOO_LONG, name, limit=self.length)
            return value
        if not isinstance(value, float):
            raise CalculationError(catalogue.STRING_NOT_ALLOWED, name, what=name)
        if not math.isfinite(value):
            raise CalculationError(catalogue.RESULT_RANGE, name, value=value)
        if self.name == "REAL64":
            return value
        if self.name == "BOOLEAN":
            return float(abs(value) >= 0.5)
        least, most = _INTEGERS[self.name]
        if not least - 0.5 <= value < most + 0.5:
            raise CalculationError(catalogue.RESULT_RANGE, name, value=value)
        return float(round_half_up(value))


REAL = Type("REAL64")


@dataclass(slots=True)
class Array:
    """An array: sizes of its dimensions and its elements, the last index fastest."""

    type: Type
    dimensions: tuple[int, ...]
    elements: list[float | str]

    def position(self, name: str, indices: tuple[float, ...]) -> int:
        """Place of an element in `elements`; CalculationError for an index out of range."""
        if len(indices) != len(self.dimensions):
            raise CalculationError(catalogue.ARRAY_NEEDED, name, given=len(indices))
        place = 0
        for index, size in zip(indices, self.dimensions, strict=True):
            if not -0.5 <= index < size - 0.5:
                raise CalculationError(catalogue.ARRAY_INDEX, name, value=index, last=size - 1)
            place = place * size + round_half_up(index)
        return place


class Scope:
    """One set of variables; `prefix` names them in errors. `limit` bounds how many there may be."""

    def __init__(self, prefix: str, limit: int = 20_000) -> None:
        self.prefix = prefix
        self.limit = limit
        self.scalars: dict[str, float | str] = {}
        self.types: dict[str, Type] = {}
        self.arrays: dict[str, Array] = {}

    def __contains__(self, name: str) -> bool:
        return name in self.scalars or name in self.arrays

    def read(self, name: str) -> float | str:
        """A scalar; CalculationError if there is none."""
        value = self.scalars.get(name)
        if value is None:
            raise self.missing(name)
        return value

    def write(self, name: str, value: object) -> None:
        """Set a scalar; without a declaration it becomes a REAL64 (or a string, if a string is assigned)."""
        kind = self.types.get(name)
        if kind is None:
            if name in self.arrays:
                raise CalculationError(catalogue.ARRAY_NEEDED, self.prefix + name, given=0)
            self._room(name)
            kind = Type("STRING", STRING_MOST) if isinstance(value, str) else REAL
            self.types[name] = kind
        self.scalars[name] = kind.converted(value, self.prefix + name)

    def read_element(self, name: str, indices: tuple[float, ...]) -> float | str:
        array = self.array(name, len(indices))
        return array.elements[array.position(self.prefix + name, indices)]

    def write_element(self, name: str, value: object, indices: tuple[float, ...]) -> None:
        array = self.array(name, len(indices))
        place = array.position(self.prefix + name, indices)
        array.elements[place] = array.type.converted(value, self.prefix + name)

    def array(self, name: str, given: int = 0) -> Array:
        """An array; CalculationError if there is none."""
        array = self.arrays.get(name)
        if array is None:
            if name in self.scalars:
                raise CalculationError(catalogue.ARRAY_NEEDED, self.prefix + name, given=given)
            raise self.missing(name)
        return array

    def missing(self, name: str) -> CalculationError:
        return CalculationError(catalogue.VARIABLE_UNSET, self.prefix + name, name=self.prefix + name)

    def declare(self, name: str, type_text: str, dimensions: tuple[float, ...], values: Sequence[object]) -> None:
        """Make a variable anew: a scalar, or an array with its initial values row by row, the rest at the initial value."""
        kind = Type.of(type_text)
        full = self.prefix + name
        if not type_text and values and isinstance(values[0], str):
            kind = Type("STRING", STRING_MOST)
        self._room(name)
        self.delete(name)
        if not dimensions:
            if len(values) > 1:
                raise CalculationError(catalogue.ARRAY_NEEDED, full, given=0)
            self.types[name] = kind
            self.scalars[name] = kind.converted(values[0], full) if values else kind.initial
            return
        if len(dimensions) > DIMENSIONS:
            raise CalculationError(catalogue.ARRAY_DIMENSIONS, full, limit=DIMENSIONS)
        sizes = tuple(round_half_up(size) for size in dimensions)
        count = int(np.prod([max(size, 0) for size in sizes], dtype=np.float64))
        if min(sizes) < 1 or count > MAX_ELEMENTS:
            raise CalculationError(catalogue.ARRAY_SIZE, full, limit=MAX_ELEMENTS)
        if len(values) > count:
            raise CalculationError(catalogue.ARRAY_VALUES, full, given=len(values), count=count)
        elements: list[float | str] = [kind.converted(value, full) for value in values]
        elements += [kind.initial] * (count - len(elements))
        self.arrays[name] = Array(kind, sizes, elements)

    @property
    def bytes(self) -> int:
        """What all variables take together."""
        scalars = sum(kind.bytes for kind in self.types.values())
        return scalars + sum(array.type.bytes * len(array.elements) for array in self.arrays.values())

    def delete(self, name: str) -> bool:
        """Remove a variable; whether there was one."""
        there = name in self
        self.scalars.pop(name, None)
        self.types.pop(name, None)
        self.arrays.pop(name, None)
        return there

    def exists(self, name: str, indices: tuple[float, ...]) -> float:
        """1.0 for a scalar without indices, or an array with valid ones."""
        if not indices:
            return float(name in self.scalars)
        array = self.arrays.get(name)
        if array is None:
            return 0.0
        try:
            array.position(name, indices)
        except CalculationError:
            return 0.0
        return 1.0

    def size(self, name: str, dimension: float) -> float:
        """Elements of a dimension, counted from 1; -1.0 without that dimension or for what is no array."""
        array = self.arrays.get(name)
        if array is None or not 0.5 <= dimension < len(array.dimensions) + 0.5:
            return -1.0
        return float(array.dimensions[round_half_up(dimension) - 1])

    def _room(self, name: str) -> None:
        if name not in self and len(self.scalars) + len(self.arrays) >= self.limit:
            raise CalculationError(catalogue.VARIABLE_LIMIT, self.prefix + name, limit=self.limit)
