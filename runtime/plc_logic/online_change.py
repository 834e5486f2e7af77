"""Online change: the state of a running program taken over into a new version of it.

What `setup` has made is compared: the old version's start, what became of it, the new version's start.

    old start   now   new start        new state
    5           8     5                8     unchanged in the text: keeps its state
    5           8     6                6     changed in the text: begins anew
    -           3     -                3     made while it ran: kept
    -           -     7                7     new in the text

That goes down into objects, lists and dictionaries: a TON whose PT was changed gets the new PT and keeps the time it has
counted. What is bound to the machine (`io`, ports of axes and channels) is the new program's. Everything is copied, so the old
program can go on if the new one is refused.
"""

from __future__ import annotations

import sys
import types
from collections.abc import Iterator, Mapping
from copy import deepcopy
from dataclasses import dataclass
from enum import Enum
from typing import Any

State = dict[str, Any]

_PLAIN = (bool, int, float, complex, str, bytes, type(None))
_CODE = (type, types.ModuleType, types.FunctionType, types.BuiltinFunctionType)
_HEAP_TYPE = 1 << 9  # a class written in Python
_MISSING = object()


@dataclass(frozen=True, slots=True)
class TakenOver:
    """Attributes of the program: those that kept their state, and those that begin anew as the text has changed."""

    kept: tuple[str, ...]
    changed: tuple[str, ...]


def start_of(program: object, bound: Mapping[str, object]) -> State:
    """A copy of what `setup` has made; `bound`: what belongs to the machine and is no state."""
    copier = _Copier(bound, program, program)
    return {name: copier.copy(value) for name, value in vars(program).items() if name not in bound}


def take_over(old: object, old_start: Mapping[str, Any], new: object, bound: Mapping[str, object]) -> TakenOver:
    """Put the state of `old` into `new`, which has run its `setup`.

    Raises ValueError if something of the old state has no place in the new version.
    """
    now = {name: value for name, value in vars(old).items() if name not in bound}
    start = {name: value for name, value in vars(new).items() if name not in bound}
    changed = tuple(name for name in start if name not in old_start or not _same(old_start[name], start[name]))
    merged = _Merge(_Copier(bound, old, new)).mapping(old_start, now, start)
    for name in start.keys() - merged.keys():
        del vars(new)[name]
    vars(new).update(merged)
    return TakenOver(tuple(name for name in merged if name in now and name not in changed), changed)


class _Copier:
    """Copies values; instances of the old version's classes become instances of the new one's."""

    def __init__(self, bound: Mapping[str, object], old: object, new: object) -> None:
        self.leaves = {id(value) for value in _machine_parts(bound)}
        self._memo: dict[int, Any] = {id(old): new, id(new): new}
        self._alive: list[object] = []  # whose ids are in the memo
        self._renews = old is not new
        self._module = type(old).__module__
        self._namespace = _namespace(type(new))

    def copy(self, value: Any) -> Any:
        if id(value) in self.leaves or isinstance(value, _CODE):
            return value
        if isinstance(value, _PLAIN) and not isinstance(value, Enum):
            return value
        if id(value) in self._memo:
            return self._memo[id(value)]
        copied = self._copy(value)
        self._memo[id(value)] = copied
        self._alive.append(value)
        return copied

    def _copy(self, value: Any) -> Any:
        kind = type(value)
        if kind is list:
            copied: Any = []
            self._memo[id(value)] = copied
            copied.extend(self.copy(item) for item in value)
            return copied
        if kind is dict:
            copied = {}
            self._memo[id(value)] = copied
            copied.update((self.copy(key), self.copy(item)) for key, item in value.items())
            return copied
        if kind in (tuple, set, frozenset):
            return kind(self.copy(item) for item in value)
        if isinstance(value, types.MethodType):  # the step of a sequence: the method of that name goes on
            return _required(self.copy(value.__self__), value.__func__.__name__)
        if isinstance(value, Enum):
            return _required(self._renewed(kind), value.name)
        if _is_object(value):
            target = self._renewed(kind)
            copied = target.__new__(target)
            self._memo[id(value)] = copied
            for name, item in _fields(value).items():
                object.__setattr__(copied, name, self.copy(item))
            return copied
        try:
            return deepcopy(value)
        except Exception:  # a socket, a lock: goes on as it is
            return value

    def _renewed(self, kind: type) -> Any:
        """The new version of a class; ValueError if it stood in the program's module and is gone."""
        if not self._renews or "<locals>" in kind.__qualname__:
            return kind
        own = kind.__module__ == self._module
        namespace = self._namespace if own else vars(sys.modules.get(kind.__module__, types))
        first, *rest = kind.__qualname__.split(".")
        found: Any = namespace.get(first)
        for part in rest:
            found = getattr(found, part, None)
        if own and not isinstance(found, type):
            raise ValueError(f"a variable holds a {kind.__qualname__}, which is there no more")
        return found if isinstance(found, type) else kind


def _required(owner: Any, name: str) -> Any:
    found = getattr(owner, name, _MISSING)
    if found is _MISSING:
        spelt = owner.__qualname__ if isinstance(owner, type) else type(owner).__qualname__
        raise ValueError(f"a variable holds {spelt}.{name}, which is there no more")
    return found


def _namespace(program: type) -> Mapping[str, Any]:
    """The names of the module a class was made in: its functions know, sys.modules may have another version."""
    for member in vars(program).values():
        if isinstance(member, types.FunctionType):
            return member.__globals__
    return vars(sys.modules.get(program.__module__, types))


def _same_class(a: type, b: type) -> bool:
    """One class, or two versions of it."""
    return a is b or (a.__qualname__ == b.__qualname__ and a.__module__ == b.__module__)


class _Merge:
    """Three values into one: old start, now, new start."""

    def __init__(self, copier: _Copier) -> None:
        self._copier = copier
        self._done: set[int] = set()

    def value(self, start: Any, now: Any, new: Any) -> Any:
        copier = self._copier
        if id(new) in copier.leaves or isinstance(new, _CODE):
            return new
        if not _same_class(type(start), type(new)):
            return new
        if type(new) is dict and type(now) is dict:
            return self.mapping(start, now, new)
        if type(new) is list and type(now) is list and not _same(start, new):
            if len(start) == len(now) == len(new):
                return [self.value(*items) for items in zip(start, now, new, strict=True)]
            return new
        if _is_object(new) and _same_class(type(now), type(new)):
            if id(new) not in self._done:
                self._done.add(id(new))
                self._fields(start, now, new)
            return new
        return copier.copy(now) if _same(start, new) else new

    def mapping(self, start: Mapping[Any, Any], now: Mapping[Any, Any], new: Mapping[Any, Any]) -> dict[Any, Any]:
        """Key by key; what was made while it ran is kept, what was removed while it ran stays away."""
        merged: dict[Any, Any] = {}
        for key, value in new.items():
            if key in start and key in now:
                merged[key] = self.value(start[key], now[key], value)
            elif key not in start or not _same(start[key], value):
                merged[key] = value
        for key, value in now.items():
            if key not in start and key not in new:
                merged[key] = self._copier.copy(value)
        return merged

    def _fields(self, start: Any, now: Any, new: Any) -> None:
        merged = self.mapping(_fields(start), _fields(now), _fields(new))
        for name, value in merged.items():
            object.__setattr__(new, name, value)


def _is_object(value: object) -> bool:
    """Whether its state is what stands in its attributes."""
    kind = type(value)
    reduces = getattr(kind, "__reduce_ex__", None) is object.__reduce_ex__ and kind.__reduce__ is object.__reduce__
    plain = not isinstance(
        value, dict | list | tuple | set | frozenset | str | int | float | bytes | Enum | types.MethodType
    )
    return plain and reduces and kind.__flags__ & _HEAP_TYPE != 0


def _fields(value: object) -> dict[str, Any]:
    """Attributes of an object, those in slots included."""
    fields = dict(getattr(value, "__dict__", {}))
    for base in type(value).__mro__:
        slots = base.__dict__.get("__slots__", ())
        for name in (slots,) if isinstance(slots, str) else slots:
            spelt = f"_{base.__name__.lstrip('_')}{name}" if name.startswith("__") and not name.endswith("__") else name
            if spelt not in ("__dict__", "__weakref__") and (item := getattr(value, spelt, _MISSING)) is not _MISSING:
                fields[spelt] = item
    return fields


def _same(a: Any, b: Any, seen: frozenset[int] = frozenset()) -> bool:
    """Whether two values were made by the same text: the same structure with the same plain values."""
    if id(a) in seen:
        return True
    if isinstance(a, Enum) and isinstance(b, Enum):
        return type(a).__qualname__ == type(b).__qualname__ and a.name == b.name
    if not _same_class(type(a), type(b)):
        return False
    if isinstance(a, types.MethodType):
        return bool(a.__func__.__name__ == b.__func__.__name__)
    below = seen | {id(a)}
    if isinstance(a, dict):
        return a.keys() == b.keys() and all(_same(a[key], b[key], below) for key in a)
    if isinstance(a, list | tuple):
        return len(a) == len(b) and all(_same(x, y, below) for x, y in zip(a, b, strict=True))
    if _is_object(a):
        return _same(_fields(a), _fields(b), below)
    try:
        return bool(a == b)
    except Exception:
        return False


def _machine_parts(bound: Mapping[str, object]) -> Iterator[object]:
    """What is bound, and the ports in it."""
    for value in bound.values():
        yield value
        if isinstance(value, list):
            yield from value
        elif isinstance(value, Mapping):
            yield from value.values()
