"""The state of the objects of the cycle, noted in one cycle of a running machine and told in those behind it.

    survey   some objects in each of the cycles before: which objects there are, and what can change in them
    note     in the cycle of the keyframe: shallow copies of all that can change, and a look whether there is anything new
    tell     some objects in each of the cycles behind it: JSON, as `state.restore` reads it

To walk over all objects in one cycle would make it late. But a copy of the attributes of an object that is known is one call, and
so is to see that all of them are atoms, or the same objects as before; only what is new is looked at more closely. What never
changes (frozen, tuples, enums) is not copied: it can be read later as well.
"""

from __future__ import annotations

import base64
import enum
import json
import types
from collections import deque
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field
from functools import cache
from itertools import chain
from operator import attrgetter, is_, itemgetter
from typing import Any

import numpy as np

from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.errors import ErrorEntry
from runtime.recorder.state import ATOMS, Outside, StateError, attributes_of, kept, slots_of

MOST_BYTES = 1_000_000  # of arrays, which are copied in one cycle
SURVEYED = 24  # objects looked at in one cycle
TOLD = 10  # objects of which text is made in one cycle
NEW = 32  # objects that may be new since the survey; with more of them the cycle would be late
_CONTAINERS = (list, deque, set, dict)


@cache
def _frozen(cls: Any) -> bool:
    """Objects whose attributes stay what they are."""
    parameters = getattr(cls, "__dataclass_params__", None)
    return parameters is not None and bool(parameters.frozen)


def _entry(value: Any) -> bool:
    """One of the catalogue, which whoever restores has as well."""
    return isinstance(value, ErrorEntry) and CATALOGUE.get(value.id) is value


def _several(places: list[int]) -> Callable[[Any], tuple[Any, ...]]:
    """The items in those places, as a tuple whatever their number is."""
    if not places:
        return lambda items: ()
    if len(places) == 1:
        place = places[0]
        return lambda items: (items[place],)
    return itemgetter(*places)


@dataclass(slots=True)
class Noted:
    """What `note` has copied: attributes, items or bytes by the identity of what they are of."""

    ids: list[int]
    copies: list[Any]
    content: dict[int, Any] = field(default_factory=dict)


class _Survey:
    """Which objects there are. `known` keeps them all alive, so that an identity is never that of two."""

    def __init__(self) -> None:
        self.known: dict[int, object] = {}
        self.bytes = 0
        self.plain: list[object] = []  # with a dictionary of attributes
        self.slotted: list[tuple[Callable[[Any], Any], object]] = []
        self.odd: list[object] = []  # with both, or a slot that is not set
        self.lists: list[list[Any]] = []  # of atoms only
        self.mixed: list[Any] = []  # other containers
        self.arrays: list[np.ndarray[Any, Any]] = []
        self.dicts: list[dict[str, Any]] = []
        self.ids: list[int] = []
        self.length = -1  # of all attributes of plain and slotted objects in a row
        self.expected: list[Any] = []  # those that are no atoms
        self.references = self.atoms = _several([])

    def attributes(self, dicts: list[dict[str, Any]], rows: list[tuple[Any, ...]]) -> list[Any]:
        """All attributes in a row."""
        return [*chain.from_iterable(map(dict.values, dicts)), *chain.from_iterable(rows)]

    def close(self) -> list[Any]:
        """Everything is looked at: where in the row the references are. What has come up meanwhile and is not known."""
        self.dicts = [one.__dict__ for one in self.plain]
        row = self.attributes(self.dicts, [get(one) for get, one in self.slotted])
        self.length = len(row)
        references = [place for place, one in enumerate(row) if type(one) not in ATOMS]
        self.references = _several(references)
        apart = set(references)
        self.atoms = _several([place for place in range(len(row)) if place not in apart])
        self.expected = [row[place] for place in references]
        slotted = [one for _, one in self.slotted]
        self.ids = [id(one) for one in (*self.plain, *slotted, *self.lists, *self.arrays, *self.mixed, *self.odd)]
        return [one for one in self.expected if id(one) not in self.known]


class StateNotes:
    """The state of everything that `root` leads to, but for what is `outside`."""

    def __init__(self, root: object, outside: Outside) -> None:
        self._root, self._outside = root, outside
        self._queues = {id(queue): number for number, queue in enumerate(outside.queues)}
        self._survey = _Survey()
        self._new: list[object] = []  # found by `note`, since the survey
        self._open: list[Any] = []  # not yet looked at

    # ------------------------------------------------------------------ survey

    def survey(self) -> Iterator[None]:
        """Look at everything, some objects in each step. Raises StateError if there is too much of it."""
        survey = self._survey = _Survey()
        self._new, self._open = [], []
        todo: list[Any] = [self._root]
        done = 0
        while todo:
            found = self._look_at(todo.pop(), todo)
            if found is not None:
                self._sort(found)
                done += 1
                if done % SURVEYED == 0:
                    yield
        yield
        self._open = survey.close()

    def _look_at(self, value: Any, todo: list[Any]) -> Any:
        """What has not been seen yet is known from now on, and what it leads to is `todo`; `value` if it can change."""
        cls: Any = type(value)
        known = self._survey.known
        if cls in ATOMS or id(value) in known:
            return None
        known[id(value)] = value
        if isinstance(value, tuple):
            todo.extend(value)
            return None
        if isinstance(value, enum.Enum | np.generic) or cls is bytes:
            return None
        if cls is types.MethodType:
            todo.append(value.__self__)
            return None
        if cls is np.ndarray:
            return self._array(value)
        if cls in _CONTAINERS:
            todo.extend(value)
            if cls is dict:
                todo.extend(value.values())
            return value
        if _entry(value) or callable(value) or kept(cls):
            return None
        for name, one in attributes_of(value).items():
            if name in getattr(cls, "SCRATCH", ()):
                known[id(one)] = one  # and what it leads to is no state
            else:
                todo.append(one)
        return None if _frozen(cls) else value

    def _array(self, value: np.ndarray[Any, Any]) -> Any:
        if self._outside.has(value):
            return None
        self._survey.bytes += value.nbytes
        if self._survey.bytes > MOST_BYTES or value.dtype.hasobject:
            raise StateError(f"an array of {value.nbytes} bytes is too large")
        return value

    def _sort(self, value: Any) -> None:
        """Put what can change among its like."""
        cls: Any = type(value)
        survey = self._survey
        names = slots_of(cls)
        if cls is np.ndarray:
            survey.arrays.append(value)
        elif cls is list and ATOMS.issuperset(map(type, value)):
            survey.lists.append(value)
        elif cls in _CONTAINERS:
            survey.mixed.append(value)
        elif not names:
            survey.plain.append(value)
        elif hasattr(value, "__dict__") or not all(hasattr(value, name) for name in names):
            survey.odd.append(value)
        elif len(names) == 1:
            name = names[0]
            survey.slotted.append((lambda one: (getattr(one, name),), value))
        else:
            survey.slotted.append((attrgetter(*names), value))

    # ------------------------------------------------------------------ note

    def note(self) -> Noted | None:
        """Copies of all that can change, as it is now; None if more is new than one cycle can look at: then in the next one."""
        survey = self._survey
        dicts = [*map(dict.copy, survey.dicts)]
        rows = [get(one) for get, one in survey.slotted]
        lists = [*map(list.copy, survey.lists)]
        mixed = [one.copy() for one in survey.mixed]
        odd = [attributes_of(one).copy() for one in survey.odd]
        arrays = [one.tobytes() for one in survey.arrays]
        noted = Noted(survey.ids, [*dicts, *rows, *lists, *arrays, *mixed, *odd])
        suspects = self._changed(survey.attributes(dicts, rows))
        suspects += chain.from_iterable(one.values() for one in odd)
        for one in mixed:
            suspects += one
            if type(one) is dict:
                suspects += one.values()
        if not ATOMS.issuperset(map(type, chain.from_iterable(lists))):
            suspects += chain.from_iterable(lists)
        for value in self._new:
            suspects += self._copy(value, noted)
        known = survey.known
        todo = self._open
        todo += [one for one in suspects if type(one) not in ATOMS and id(one) not in known]
        found = 0
        while todo:
            value = self._look_at(todo.pop(), todo)
            if value is not None:
                self._new.append(value)
                self._copy(value, noted)
                found += 1
                if found > NEW:
                    return None
        return noted

    def _changed(self, row: list[Any]) -> list[Any]:
        """Of all attributes in a row those that are other objects than in the survey."""
        survey = self._survey
        if len(row) != survey.length:
            return row
        references, atoms = survey.references(row), survey.atoms(row)
        changed: list[Any] = []
        if not all(map(is_, references, survey.expected)):
            changed += [now for now, before in zip(references, survey.expected, strict=True) if now is not before]
        if not ATOMS.issuperset(map(type, atoms)):
            changed += atoms
        return changed

    def _copy(self, value: Any, noted: Noted) -> list[Any]:
        """Note one that the survey has not; what is in it."""
        if type(value) is np.ndarray:
            noted.content[id(value)] = value.tobytes()
            return []
        copy = noted.content[id(value)] = value.copy() if type(value) in _CONTAINERS else attributes_of(value).copy()
        if type(value) is dict:
            return [*copy, *copy.values()]
        return [*copy.values()] if isinstance(copy, dict) else [*copy]

    # ------------------------------------------------------------------ tell

    def tell(self, noted: Noted) -> Iterator[bytes]:
        """The text of what was noted, some objects at a time. Raises StateError if something of it is missing."""
        noted.content.update(zip(noted.ids, noted.copies, strict=True))
        return _Telling(self._root, noted.content, self._outside, self._queues).pieces()


class _Telling:
    """Numbers objects in the order in which they are met, and makes text of them in that order."""

    def __init__(self, root: object, content: dict[int, Any], outside: Outside, queues: dict[int, int]) -> None:
        self._content, self._outside, self._queues = content, outside, queues
        self._numbers: dict[int, int] = {}
        self._objects: list[Any] = []  # by their numbers
        self._value(root)

    def pieces(self) -> Iterator[bytes]:
        at = 0
        while at < len(self._objects):
            end = min(at + TOLD, len(self._objects))
            told = [self._object(value) for value in self._objects[at:end]]
            yield json.dumps(told, default=_bytes_as_text, separators=(",", ":")).encode() + b"\n"
            at = end

    def _value(self, value: Any) -> Any:
        cls: Any = type(value)
        if cls in ATOMS:
            return value
        number = self._numbers.get(id(value))
        if number is not None:
            return ("#", number)
        if cls is tuple:
            return ("t", [self._value(one) for one in value])
        if isinstance(value, enum.Enum):
            by_value = isinstance(value.value, int | str)
            return ("e", cls.__module__, cls.__qualname__, value.value if by_value else value.name, by_value)
        if cls is types.MethodType:
            return ("m", self._value(value.__self__), value.__name__)
        if isinstance(value, np.generic):
            return ("n", value.dtype.str, value.item())
        if _entry(value):
            return ("c", value.id)
        if cls is bytes:
            return ("b", value)
        if isinstance(value, tuple) and cls.__module__.startswith("runtime."):
            return ("v", cls.__module__, cls.__qualname__, [self._value(one) for one in value])
        if id(value) in self._queues:
            return ("q", self._queues[id(value)])
        if cls is np.ndarray:
            if self._outside.has(value):
                return ("k",)
        elif cls not in _CONTAINERS and (kept(cls) or callable(value)):
            return ("k",)
        number = self._numbers[id(value)] = len(self._objects)
        self._objects.append(value)
        return ("#", number)

    def _object(self, value: Any) -> Any:
        cls: Any = type(value)
        content = attributes_of(value) if _frozen(cls) else self._content.get(id(value))
        if content is None:
            raise StateError(f"a {cls.__name__} was not noted")
        if cls is np.ndarray:
            return ("a", value.dtype.str, value.shape, content)
        if cls is dict:
            items = [(self._value(key), self._value(one)) for key, one in content.items()]
            return ("l", "dict", items, None)
        if cls in _CONTAINERS:
            return ("l", cls.__name__, [self._value(one) for one in content], getattr(value, "maxlen", None))
        named = content.items() if isinstance(content, dict) else zip(slots_of(cls), content, strict=True)
        scratch = getattr(cls, "SCRATCH", ())
        return ("o", cls.__module__, cls.__qualname__, [(n, self._value(one)) for n, one in named if n not in scratch])


def _bytes_as_text(value: object) -> str:
    if isinstance(value, bytes):
        return base64.b64encode(value).decode()
    raise StateError(f"a {type(value).__name__} has no place in a recording")
