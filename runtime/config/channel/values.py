"""From what stands in a file to the value of a parameter: type, range, words."""

from __future__ import annotations

import math
import re
from collections.abc import Iterable, Mapping
from difflib import get_close_matches

from runtime.config.channel.parameter import ChannelParameter, Value
from runtime.config.channel.synchronisation import (
    SynchCountError,
    SynchNameError,
    synch_names,
)
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.errors import ErrorEntry

_TYPE_LIMITS: dict[str, tuple[float, float]] = {
    "SGN08": (-(2**7), 2**7 - 1),
    "UNS08": (0, 2**8 - 1),
    "SGN16": (-(2**15), 2**15 - 1),
    "UNS16": (0, 2**16 - 1),
    "SGN32": (-(2**31), 2**31 - 1),
    "UNS32": (0, 2**32 - 1),
    "REAL64": (-math.inf, math.inf),
}
_INTEGER = re.compile(r"[-+]?[0-9]{1,30}\Z|0[xX][0-9a-fA-F]{1,16}\Z")
_REAL = re.compile(r"[-+]?(?:[0-9]+\.?[0-9]*|\.[0-9]+)(?:[eE][-+]?[0-9]+)?\Z")


class ValueMistakeError(ValueError):
    """A value that a parameter cannot have, as a catalogue entry with its values (without `key`)."""

    def __init__(self, entry: ErrorEntry, **values: object) -> None:
        self.entry: ErrorEntry = entry
        self.values: Mapping[str, object] = values
        super().__init__(entry.id)


def value_of(parameter: ChannelParameter, given: object) -> Value:
    """The value of a parameter from a plain value of YAML; raises ValueMistakeError.

    Flags and synchronisation types come out in their normal form: names joined by " | ".
    """
    value = _typed(parameter, given)
    if parameter.kind in _TYPE_LIMITS and value != parameter.default:
        _check_range(parameter, float(value))
    return value


def value_of_text(parameter: ChannelParameter, text: str) -> Value:
    """The same from the text of a list file, where numbers may be hexadecimal and BOOLEAN is 0 or 1."""
    given: object = text
    if parameter.kind in _TYPE_LIMITS or parameter.kind == "BOOLEAN":
        if _INTEGER.match(text):
            given = int(text, 16) if text[:2].lower() == "0x" else int(text)
        elif parameter.kind == "REAL64" and _REAL.match(text):
            given = float(text)
    return value_of(parameter, given)


def words_of(parameter: ChannelParameter) -> tuple[str, ...]:
    """The words that can stand as a value, for keywords, flags and synchronisation types."""
    return tuple(parameter.range.split("|")) if parameter.kind in ("KEYWORD", "FLAGS", "SYNCH") else ()


def _typed(parameter: ChannelParameter, given: object) -> Value:
    kind = parameter.kind
    if kind == "BOOLEAN":
        if isinstance(given, bool):
            return given
        if isinstance(given, int) and given in (0, 1):
            return bool(given)
        raise _wrong("0 or 1", given)
    if kind == "REAL64":
        if isinstance(given, (int, float)) and not isinstance(given, bool):
            if not math.isfinite(given):
                raise _wrong("a finite number", given)
            return float(given)
        raise _wrong("a number", given)
    if kind in _TYPE_LIMITS:
        if isinstance(given, int) and not isinstance(given, bool):
            return given
        raise _wrong("a whole number", given)
    if kind == "SYNCH":
        return _synchronisation(parameter, given)
    if kind == "KEYWORD":
        if isinstance(given, str) or (isinstance(given, int) and not isinstance(given, bool)):
            return _word(parameter, str(given))
        raise _wrong("text", given)
    if not isinstance(given, str):
        raise _wrong("text", given)
    if kind == "FLAGS":
        return " | ".join(_word(parameter, part.strip()) for part in given.split("|")) if given.strip() else ""
    if parameter.range and len(given) > int(parameter.range):
        raise ValueMistakeError(errors.WRONG_LENGTH, given=len(given), bound=f"at most {parameter.range} are possible")
    return given


def _wrong(expected: str, given: object) -> ValueMistakeError:
    shown = "nothing" if given is None or given == "" else repr(str(given)) if isinstance(given, (str, bool)) else given
    if isinstance(given, (dict, list)):
        shown = "a mapping" if isinstance(given, dict) else "a list"
    return ValueMistakeError(errors.WRONG_TYPE, expected=expected, given=shown)


def _word(parameter: ChannelParameter, given: str) -> str:
    words = words_of(parameter)
    found = parameter.spellings.get(given.upper()) or next((word for word in words if word == given.upper()), None)
    if found is None:
        raise _unknown_word(given, words)
    return found


def _unknown_word(given: str, words: Iterable[str]) -> ValueMistakeError:
    words = tuple(words)
    close = get_close_matches(given.upper(), words, n=1)
    return ValueMistakeError(
        errors.UNKNOWN_CHOICE,
        given=repr(given),
        suggestion=f"; do you mean {close[0]!r}?" if close else "",
        allowed=", ".join(words),
    )


def _synchronisation(parameter: ChannelParameter, given: object) -> str:
    if not isinstance(given, (str, int)) or isinstance(given, bool):
        raise _wrong("a synchronisation type", given)
    words = words_of(parameter)
    try:
        names = synch_names(given)
    except SynchNameError as error:
        raise _unknown_word(error.part, words) from None
    except SynchCountError as error:
        raise ValueMistakeError(errors.UNSUITABLE, reason=str(error)) from None
    for name in names:
        if name not in words:
            raise _unknown_word(name, words)
    return " | ".join(names)


def _check_range(parameter: ChannelParameter, value: float) -> None:
    low, high = _TYPE_LIMITS[parameter.kind]
    if low <= value <= high and (
        not parameter.range or any(_within(part, value, low, high) for part in parameter.range.split("|"))
    ):
        return
    shown = f"{value:g}" if parameter.kind == "REAL64" else f"{value:.0f}"
    raise ValueMistakeError(errors.OUT_OF_RANGE, given=shown, bound=_bound(parameter, low, high))


def _within(part: str, value: float, low: float, high: float) -> bool:
    if part.startswith(">"):
        return value > float(part[1:])
    first, _, last = part.partition("..")
    return _number(first, low, high) <= value <= _number(last or first, low, high)


def _number(text: str, low: float, high: float) -> float:
    named = {"MIN": low, "MAX": high, "MAX-1": high - 1}
    return named[text] if text in named else float(text)


def _bound(parameter: ChannelParameter, low: float, high: float) -> str:
    if parameter.kind == "REAL64":
        text = parameter.range.replace("..MAX", " or more").replace("MIN..0", "0 or less")
        return "it must be " + text.replace(">", "greater than ").replace("..", " to ").replace("|", " or ")
    parts = []
    for part in (parameter.range or "MIN..MAX").split("|"):
        first, _, last = part.partition("..")
        bounds = [f"{_number(bound, low, high):.0f}" for bound in (first, last) if bound]
        parts.append(" to ".join(bounds))
    return "it must be " + " or ".join(parts)
