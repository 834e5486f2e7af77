"""pydantic's findings in the words of a machine builder: one table from pydantic's error types to catalogue entries."""

from __future__ import annotations

import types
from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass
from difflib import get_close_matches
from typing import Annotated, Any, Union, get_args, get_origin

from pydantic import BaseModel
from pydantic_core import ErrorDetails

from runtime.config.contradictions import ContradictionError, Location
from runtime.config.machine import Machine
from runtime.config.quantities import UnitError
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.errors import ErrorEntry, Place

_EXPECTED = {  # pydantic error type -> what belongs there
    "int_type": "a whole number",
    "float_type": "a number",
    "finite_number": "a finite number",
    "bool_type": "true or false",
    "string_type": "text",
    "tuple_type": "a list",
    "dict_type": "a mapping (key: value)",
    "model_type": "a mapping (key: value)",
    "path_type": "a path",
    "enum": "text",
}
_BOUNDS = {  # pydantic error type -> how the bound in its context reads
    "greater_than": ("gt", "it must be greater than {}"),
    "greater_than_equal": ("ge", "it must be {} or more"),
    "less_than": ("lt", "it must be less than {}"),
    "less_than_equal": ("le", "it must be {} or less"),
}
_LENGTHS = {
    "too_short": ("min_length", "at least {} belong here"),
    "too_long": ("max_length", "at most {} are possible"),
    "string_too_short": ("min_length", "at least {} belong here"),
    "string_too_long": ("max_length", "at most {} are possible"),
}
_PATTERN_RULES = {  # by the last key of the location; None stands for a key of a mapping
    "name": "An axis name is a letter A to Q or S to Z, then letters, digits and underscores, 16 characters at most.",
    None: "The zero offsets that can be set here are G54 to G59.",
}
_INTERNAL = {  # dimension -> the unit of a plain number
    "length": "mm",
    "angle": "degrees",
    "velocity": "mm/s",
    "angular velocity": "degrees/s",
    "acceleration": "mm/s^2",
    "angular acceleration": "degrees/s^2",
    "jerk": "mm/s^3",
    "angular jerk": "degrees/s^3",
    "time": "seconds",
}


@dataclass(frozen=True, slots=True)
class Explanation:
    """A mistake in our words; `at_key` says that the key itself is wrong, not its value; `place` is in another file."""

    entry: ErrorEntry
    location: Location
    values: Mapping[str, object]
    at_key: bool = False
    place: Place | None = None


def explain(details: Iterable[ErrorDetails], given: Callable[[Location], str]) -> Iterator[Explanation]:
    """One explanation per mistake; `given(location)` is the text that stands at a location."""
    for detail in details:
        yield from _explain(detail, given)


def _explain(detail: ErrorDetails, given: Callable[[Location], str]) -> Iterator[Explanation]:
    location, kind, context = detail["loc"], detail["type"], detail.get("ctx", {})
    if at_key := bool(location) and location[-1] == "[key]":
        location = location[:-1]
    if kind == "value_error" and isinstance(context["error"], ContradictionError):
        for found in context["error"].contradictions:
            yield Explanation(found.entry, location + found.location, found.values, found.at_key, found.place)
        return
    key = path_text(location)
    raw = repr(location[-1]) if at_key else given(location)
    if kind == "extra_forbidden":
        owner, wrong = location[:-1], str(location[-1])
        known = _known_keys(owner)
        values: dict[str, object] = {
            "key": wrong,
            "owner": path_text(owner),
            "suggestion": _suggestion(wrong, known),
            "known": ", ".join(known),
        }
        yield Explanation(errors.KEY_UNKNOWN, location, values, at_key=True)
    elif kind == "missing":
        yield Explanation(errors.KEY_MISSING, location, {"key": location[-1], "owner": path_text(location[:-1])})
    elif kind in ("enum", "literal_error") and isinstance(detail["input"], str):
        allowed = str(context["expected"]).replace("'", "").replace(" or ", ", ").split(", ")
        values = {
            "key": key,
            "given": raw,
            "suggestion": _suggestion(detail["input"], allowed),
            "allowed": ", ".join(allowed),
        }
        yield Explanation(errors.UNKNOWN_CHOICE, location, values)
    elif kind in _EXPECTED or kind == "literal_error":
        values = {"key": key, "expected": _EXPECTED.get(kind, "text"), "given": raw}
        yield Explanation(errors.WRONG_TYPE, location, values, at_key)
    elif kind in _BOUNDS:
        name, text = _BOUNDS[kind]
        bound = text.format(f"{context[name]:g}" if isinstance(context[name], float) else context[name])
        yield Explanation(errors.OUT_OF_RANGE, location, {"key": key, "given": raw.strip("'"), "bound": bound}, at_key)
    elif kind in _LENGTHS:
        name, text = _LENGTHS[kind]
        length = len(detail["input"])
        if kind == "too_short" and length >= context[name]:
            return  # pydantic counts the valid entries only; the others have been explained themselves
        values = {"key": key, "given": length, "bound": text.format(context[name])}
        yield Explanation(errors.WRONG_LENGTH, location, values, at_key)
    elif kind == "string_pattern_mismatch":
        rule = _PATTERN_RULES[None if at_key else str(location[-1])]
        yield Explanation(errors.WRONG_PATTERN, location, {"key": key, "given": raw, "rule": rule}, at_key)
    elif kind == "value_error":
        yield _explain_value_error(context["error"], location, key, raw)
    else:
        yield Explanation(errors.UNSUITABLE, location, {"key": key, "reason": detail["msg"]}, at_key)


def _explain_value_error(error: Exception, location: Location, key: str, raw: str) -> Explanation:
    if isinstance(error, UnitError):
        values: dict[str, object] = {
            "key": key,
            "unit": error.unit,
            "dimension": error.dimension,
            "allowed": ", ".join(error.allowed),
            "internal": _INTERNAL[error.dimension],
        }
        return Explanation(errors.WRONG_UNIT, location, values)
    expected = str(error)
    if expected.endswith(" is expected"):
        values = {"key": key, "expected": expected.removesuffix(" is expected"), "given": raw}
        return Explanation(errors.WRONG_TYPE, location, values)
    return Explanation(errors.UNSUITABLE, location, {"key": key, "reason": expected})


def path_text(location: Location) -> str:
    """A location as it is spoken of: `axes[0].drive.node`; the root is "the machine"."""
    text = ""
    for step in location:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text or "the machine"


def _suggestion(wrong: str, known: Iterable[str]) -> str:
    close = get_close_matches(wrong.lower(), {name.lower(): name for name in known}, n=1)
    original = [name for name in known if close and name.lower() == close[0]]
    return f"; do you mean {original[0]!r}?" if original else ""


def _known_keys(location: Location) -> list[str]:
    model = _annotation_at(location)
    return list(model.model_fields) if isinstance(model, type) and issubclass(model, BaseModel) else []


def _annotation_at(location: Location) -> Any:
    """The type that the machine description has at a location."""
    annotation: Any = Machine
    for step in location:
        annotation = _bare(annotation)
        if isinstance(annotation, type) and issubclass(annotation, BaseModel):
            annotation = annotation.model_fields[str(step)].annotation
        else:  # tuple[T, ...] and dict[K, T]
            arguments = get_args(annotation)
            annotation = arguments[0] if get_origin(annotation) is tuple else arguments[1]
    return _bare(annotation)


def _bare(annotation: Any) -> Any:
    """Without `Annotated` and `| None`."""
    while True:
        origin = get_origin(annotation)
        if origin is Annotated:
            annotation = get_args(annotation)[0]
        elif origin in (Union, types.UnionType):
            annotation = next(a for a in get_args(annotation) if a is not type(None))
        else:
            return annotation
