"""The text of #MSG and #ADD: format elements and their values (programming manual 13389–13447).

%d %D  whole number with sign       %f %F  real number, 3.4567800000E+001
%u %U  whole number without sign    %s %S  string, content of a macro
%%     a percent sign
"""

from __future__ import annotations

import math
import re
from collections.abc import Sequence

from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.diagnostics.catalogue import language as catalogue

MOST_VALUES = 10
_MARK = re.compile(r"%(.?)", re.DOTALL)
_KINDS = "dufs"


def marks_of(text: str) -> list[str]:
    """The letters of the format elements, in lower case. CalculationError for a % with anything else behind it."""
    marks = []
    for match in _MARK.finditer(text):
        letter = match.group(1).lower()
        if letter == "%":
            continue
        if not letter or letter not in _KINDS:
            raise CalculationError(catalogue.MESSAGE_MARK, match.group(), mark=match.group())
        marks.append(letter)
    return marks


def check_count(text: str, values: int, statement: str) -> list[str]:
    """The format elements of a text; CalculationError if there are not as many values."""
    marks = marks_of(text)
    if values > MOST_VALUES:
        raise CalculationError(catalogue.MESSAGE_VALUES, statement, statement=statement, limit=MOST_VALUES)
    if len(marks) != values:
        raise CalculationError(catalogue.MESSAGE_MARKS, statement, statement=statement, marks=len(marks), values=values)
    return marks


def composed(text: str, values: Sequence[object], statement: str) -> str:
    """The text with the values in the places of its format elements; CalculationError if they do not fit."""
    marks = check_count(text, len(values), statement)
    shown = iter([_shown(mark, value, statement) for mark, value in zip(marks, values, strict=True)])
    return _MARK.sub(lambda match: "%" if match.group(1) == "%" else next(shown), text)


def _shown(mark: str, value: object, statement: str) -> str:
    wanted = "a string" if mark == "s" else "a number without sign" if mark == "u" else "a number"
    if mark == "s":
        if isinstance(value, str):
            return value
    elif isinstance(value, float) and math.isfinite(value):
        if mark == "f":
            return real(value)
        whole = round_half_up(value)
        if mark == "d" or whole >= 0:
            return str(whole)
    given = f"{value:.9g}" if isinstance(value, float) else "a string" if isinstance(value, str) else "a set of values"
    raise CalculationError(
        catalogue.MESSAGE_VALUE, statement, mark=f"%{mark}", statement=statement, wanted=wanted, given=given
    )


def real(value: float) -> str:
    """A real number with ten decimals and an exponent of three digits."""
    digits, exponent = f"{value:.10E}".split("E")
    return f"{digits}E{exponent[0]}{int(exponent[1:]):03d}"
