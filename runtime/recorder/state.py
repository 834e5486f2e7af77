"""The state of the objects of the cycle, for a keyframe: what of it is told and what not, and how it is put into a controller
that was just built. `noting` takes it from a running one.

No pickle: a recording is data from somewhere. What is told are numbers, texts, arrays, and the attributes of objects of this
runtime by name; what is restored are the attributes of objects that the fresh controller has, or new ones of its classes.
Of everything that the outside owns (HLI, queues, drives, the machine description) nothing is taken: the border restores that.

A value is an atom itself, or a list [tag, …]. Objects, lists, dictionaries and arrays have numbers in the order in which they are
met, so that what two places share is shared again.
"""

from __future__ import annotations

import base64
import importlib
import json
from collections import deque
from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.diagnostics.catalogue import CATALOGUE

ATOMS = frozenset({int, float, str, bool, type(None)})
_KEPT_MODULES = ("runtime.hli.layout", "runtime.config", "runtime.fieldbus", "runtime.recorder", "runtime.kernels")
_KEPT_CLASSES = {
    "MotionQueue", "PreparationLink", "EventRing", "DriveImage", "HliMemory", "QueueTexts", "QueueLimits", "DecoderReports",
    "RecorderRing", "BusFigures", "PlcProcess", "InlinePlc",
}  # fmt: skip


_MISSING = object()


class StateError(Exception):
    """The state cannot be taken or restored; the text tells why."""


@cache
def slots_of(cls: Any) -> tuple[str, ...]:
    """The slots of a class, those of its bases first."""
    found: list[str] = []
    for base in reversed(cls.__mro__):
        slots = base.__dict__.get("__slots__", ())
        found += (
            [slots] if isinstance(slots, str) else [name for name in slots if name not in ("__dict__", "__weakref__")]
        )
    return tuple(found)


def attributes_of(value: object) -> dict[str, Any]:
    """All attributes of an object, in the order in which they were made; those that are set."""
    cls: Any = type(value)
    names = slots_of(cls)
    own: dict[str, Any] = getattr(value, "__dict__", {})
    return {name: getattr(value, name) for name in names if hasattr(value, name)} | own if names else own


@cache
def kept(cls: Any) -> bool:
    """Objects of a class that the outside owns: whoever restores has his own."""
    module = cls.__module__
    return not module.startswith("runtime.") or module.startswith(_KEPT_MODULES) or cls.__name__ in _KEPT_CLASSES


def _address(array: npt.NDArray[Any]) -> int:
    return int(array.__array_interface__["data"][0])


class Outside:
    """What is no state of the cycle: arrays that lie in these memories are left out, and of the queues it is told which."""

    def __init__(self, *memories: npt.NDArray[Any], queues: Sequence[object] = ()) -> None:
        self.queues = list(queues)
        self._spans = [(_address(memory), _address(memory) + memory.nbytes) for memory in memories]
        self._known: dict[int, tuple[object, bool]] = {}

    def has(self, array: npt.NDArray[Any]) -> bool:
        """Whether an array lies in one of them."""
        known = self._known.get(id(array))
        if known is not None and known[0] is array:
            return known[1]
        at = _address(array)
        found = any(begin <= at < end for begin, end in self._spans)
        if len(self._known) < 4096:
            self._known[id(array)] = (array, found)
        return found


def restore(root: object, text: bytes, outside: Outside) -> None:
    """Put a captured state into a controller that was just built. Raises StateError if they do not fit."""
    objects: list[Any] = []
    for line in filter(bytes.strip, text.splitlines()):
        objects += json.loads(line)
    _Restoring(objects, outside).into(root)


class _Restoring:
    def __init__(self, objects: list[Any], outside: Outside) -> None:
        self._objects = objects
        self._outside = outside
        self._made: dict[int, Any] = {}

    def into(self, root: object) -> None:
        self._object(0, root)

    def _value(self, told: Any, present: Any) -> Any:
        """What `told` says; `present` is what the fresh controller has in this place."""
        if not isinstance(told, list):
            return told
        tag = told[0]
        if tag == "k":
            return present
        if tag == "q":
            return self._outside.queues[told[1]]
        if tag == "#":
            number = told[1]
            return self._made[number] if number in self._made else self._object(number, present)
        if tag == "t":
            before = present if type(present) is tuple and len(present) == len(told[1]) else [None] * len(told[1])
            return tuple(self._value(one, old) for one, old in zip(told[1], before, strict=True))
        if tag == "e":
            cls = _class(told[1], told[2])
            return cls(told[3]) if told[4] else cls[told[3]]
        if tag == "m":
            owner = getattr(present, "__self__", None)
            return getattr(self._value(told[1], owner), told[2])
        if tag == "n":
            return np.dtype(told[1]).type(told[2])
        if tag == "c":
            return CATALOGUE[told[1]]
        if tag == "b":
            return base64.b64decode(told[1])
        if tag == "v":
            cls = _class(told[1], told[2])
            before = present if type(present) is cls else [None] * len(told[3])
            return cls(*[self._value(one, old) for one, old in zip(told[3], before, strict=True)])
        raise StateError(f"unknown tag {tag}")

    def _object(self, number: int, present: Any) -> Any:
        told = self._objects[number]
        if told[0] == "a":
            return self._array(number, told, present)
        if told[0] == "l":
            return self._container(number, told, present)
        cls = _class(told[1], told[2])
        made = present if type(present) is cls else cls.__new__(cls)
        self._made[number] = made
        for name, value in told[3]:
            old = getattr(made, name, _MISSING)
            new = self._value(value, None if old is _MISSING else old)
            if new is not old:
                object.__setattr__(made, name, new)
        return made

    def _array(self, number: int, told: list[Any], present: Any) -> npt.NDArray[Any]:
        values = np.frombuffer(base64.b64decode(told[3]), dtype=_dtype(told[1], present)).reshape(told[2])
        fits = isinstance(present, np.ndarray) and present.shape == values.shape and not self._outside.has(present)
        made = present if fits and present.dtype == values.dtype else values.copy()
        if made is present:
            present[...] = values
        self._made[number] = made
        return made

    def _container(self, number: int, told: list[Any], present: Any) -> Any:
        kinds: dict[str, Callable[[], Any]] = {
            "list": list,
            "set": set,
            "dict": dict,
            "deque": lambda: deque(maxlen=told[3]),
        }
        made = present if type(present).__name__ == told[1] else kinds[told[1]]()
        self._made[number] = made
        if isinstance(made, dict):
            before = dict(made)
            items = []
            for key, one in told[2]:
                name = self._value(key, None)
                items.append((name, self._value(one, before.get(name))))
            made.clear()
            made.update(items)
            return made
        old = list(made)
        same = len(old) == len(told[2])
        content = [self._value(one, old[k] if same else None) for k, one in enumerate(told[2])]
        made.clear()
        if isinstance(made, set):
            made.update(content)
        else:
            made.extend(content)
        return made


def _dtype(text: str, present: Any) -> np.dtype[Any]:
    """Records have no text of their own: theirs is that of the array in this place."""
    if text.startswith("|V"):
        if not isinstance(present, np.ndarray):
            raise StateError("an array of records without a place")
        of_place: np.dtype[Any] = present.dtype
        return of_place
    return np.dtype(text)


def _class(module: str, name: str) -> Any:
    """A class of this runtime, and nothing else. Raises StateError."""
    if not module.startswith("runtime."):
        raise StateError(f"{module}.{name} is no class of the runtime")
    found: Any = importlib.import_module(module)
    for part in name.split("."):
        found = getattr(found, part)
    if not isinstance(found, type):
        raise StateError(f"{module}.{name} is no class")
    return found
