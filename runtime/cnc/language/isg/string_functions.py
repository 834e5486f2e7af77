"""String functions (programming manual lines 1637–1753): positions count from 1, counts stand before positions."""

from __future__ import annotations

import math

from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import MANY, as_number, function, require_finite, round_half_up
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

_NUMBER, _STRING, _ANY = ValueKind.NUMBER, ValueKind.STRING, ValueKind.ANY
STRING_LIMIT = 10_000  # characters; no manual number, it keeps a loop from eating the memory


def _size(value: float, name: str) -> int:
    """A count or position: a whole number from 0 on, halves rounded upward."""
    if not -0.5 <= value <= STRING_LIMIT:
        raise CalculationError(catalogue.STRING_POSITION, name, value=value)
    return round_half_up(value)


def _at(value: float, name: str, length: int) -> int:
    """A position in a string of `length` characters, counted from 1."""
    position = _size(value, name)
    if not 1 <= position <= length:
        raise CalculationError(catalogue.STRING_POSITION, name, value=value)
    return position


def _limited(text: str, name: str) -> str:
    if len(text) > STRING_LIMIT:
        raise CalculationError(catalogue.STRING_TOO_LONG, name, limit=STRING_LIMIT)
    return text


_SUBSTRINGS = "isg.lex.string-substrings"
_EDIT = "isg.lex.string-edit"
_CONVERSION = "isg.lex.string-conversion"


@function("LEFT", _SUBSTRINGS, 2, takes=(_STRING, _NUMBER), gives=_STRING)
def left_part(text: str, count: float) -> str:
    return text[: _size(count, "LEFT")]


@function("MID", _SUBSTRINGS, 3, takes=(_STRING, _NUMBER, _NUMBER), gives=_STRING)
def middle_part(text: str, count: float, position: float) -> str:
    begin = max(_size(position, "MID"), 1) - 1
    return text[begin : begin + _size(count, "MID")]


@function("RIGHT", _SUBSTRINGS, 2, takes=(_STRING, _NUMBER), gives=_STRING)
def right_part(text: str, count: float) -> str:
    return text[max(0, len(text) - _size(count, "RIGHT")) :]


@function("LEN", _SUBSTRINGS, takes=(_STRING,))
def text_length(text: str) -> float:
    return float(len(text))


@function("ORD", "isg.lex.string-ord", 2, takes=(_STRING, _NUMBER), least=1)
def character_value(text: str, position: float = 1.0) -> float:
    if not text:
        return 0.0
    if not 1 <= round_half_up(position) <= len(text):
        raise CalculationError(catalogue.ORD_POSITION, "ORD", value=position)
    return float(ord(text[round_half_up(position) - 1]))


@function("FIND", _EDIT, 2, takes=(_STRING,))
def text_position(text: str, wanted: str) -> float:
    return float(text.find(wanted) + 1)


@function("DELETE", _EDIT, 3, takes=(_STRING, _NUMBER, _NUMBER), gives=_STRING)
def text_without(text: str, count: float, position: float) -> str:
    begin = _at(position, "DELETE", len(text)) - 1
    return text[:begin] + text[begin + _size(count, "DELETE") :]


@function("INSERT", _EDIT, 3, takes=(_STRING, _STRING, _NUMBER), gives=_STRING)
def text_inserted(text: str, inserted: str, position: float) -> str:
    """`inserted` behind the character at `position`; 0 puts it in front."""
    behind = _size(position, "INSERT")
    if behind > len(text):
        raise CalculationError(catalogue.STRING_POSITION, "INSERT", value=position)
    return _limited(text[:behind] + inserted + text[behind:], "INSERT")


@function("REPLACE", _EDIT, 4, takes=(_STRING, _STRING, _NUMBER, _NUMBER), gives=_STRING)
def text_replaced(text: str, inserted: str, count: float, position: float) -> str:
    begin = _at(position, "REPLACE", len(text)) - 1
    return _limited(text[:begin] + inserted + text[begin + _size(count, "REPLACE") :], "REPLACE")


@function("INT_TO_STR", _CONVERSION, gives=_STRING)
def integer_text(value: float) -> str:
    return str(math.trunc(require_finite(value, "INT_TO_STR")))


@function("REAL_TO_STR", _CONVERSION, gives=_STRING)
def real_text(value: float) -> str:
    """Up to six decimals, at least one: the manual gives no number of them."""
    text = f"{require_finite(value, 'REAL_TO_STR'):.6f}".rstrip("0")
    return text + "0" if text.endswith(".") else text


def _parsed(text: str, name: str) -> float:
    try:
        value = float(text.strip())
    except ValueError:
        value = math.nan
    if not math.isfinite(value):
        raise CalculationError(catalogue.STRING_NO_NUMBER, name, text=text)
    return value


@function("STR_TO_INT", _CONVERSION, takes=(_STRING,))
def text_integer(text: str) -> float:
    return float(math.trunc(_parsed(text, "STR_TO_INT")))


@function("STR_TO_REAL", _CONVERSION, takes=(_STRING,))
def text_real(text: str) -> float:
    return _parsed(text, "STR_TO_REAL")


@function("FSTRING", "isg.lex.fstring", MANY, takes=(_ANY,), gives=_STRING, least=1)
def composed(*parts: float | str) -> str:
    """Numbers without decimals where they are whole, else as REAL_TO_STR writes them."""
    texts = [part if isinstance(part, str) else plain_text(as_number(part, "FSTRING")) for part in parts]
    return _limited("".join(texts), "FSTRING")


def plain_text(value: float) -> str:
    """A number as people write it."""
    return str(int(value)) if value.is_integer() else real_text(value)


@function("IS_STRING", "isg.sub.cycle-parameters", takes=(_ANY,))
def is_string(value: object) -> float:
    return float(isinstance(value, str))


@function("IS_NUMBER", "isg.sub.cycle-parameters", takes=(_ANY,))
def is_number(value: object) -> float:
    return float(isinstance(value, float))
