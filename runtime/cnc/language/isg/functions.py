"""The mathematical functions and operators of the dialect (programming manual lines 1433–1600), registered by name.

Numbers are float, strings str. What has no value raises CalculationError, whose `name` is what stands in the program text.
"""

from __future__ import annotations

import math
import operator
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any, TypeVar

import numpy as np

from runtime.cnc.language import angles
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

BIT_MAX = 2**32 - 1  # operands and results of bit operators are unsigned 32 bit (line 1470)
TRUE_FROM = 0.5  # a value counts as true from here on (line 1487)


@dataclass(frozen=True, slots=True)
class Function:
    """A function of the expression language: how many arguments of which kind `call` takes, and what it gives."""

    name: str
    least: int
    most: int
    takes: tuple[ValueKind, ...]  # of the arguments; the last one holds for those that follow
    gives: ValueKind
    spec: str
    call: Callable[..., float | str]


FUNCTIONS: dict[str, Function] = {}

# Functions of the manual that cannot be had, and why (lines 1597–1633).
UNSUPPORTED = {
    "ENCRYPT": "the manual does not tell its method, and what it makes could not be read elsewhere",
    "BLANK_HAS_KEY": "there are no blanks of a scene (#SCENE ADD)",
    "BLANK_VALUE_OF_KEY": "there are no blanks of a scene (#SCENE ADD)",
}
Call = TypeVar("Call", bound=Callable[..., float | str])
MANY = 1000  # arguments of a function that takes any number of them


def function(
    name: str,
    spec: str,
    arguments: int = 1,
    *,
    takes: tuple[ValueKind, ...] = (ValueKind.NUMBER,),
    gives: ValueKind = ValueKind.NUMBER,
    least: int | None = None,
) -> Callable[[Call], Call]:
    """Register a function with `arguments` arguments, the last of which may be left out down to `least`."""

    def register(call: Call) -> Call:
        FUNCTIONS[name] = Function(name, arguments if least is None else least, arguments, takes, gives, spec, call)
        return call

    return register


def _in_range(name: str, compute: Callable[[], float]) -> float:
    """The value of `compute`, or an error if it is no finite number."""
    try:
        value = compute()
    except OverflowError:
        value = math.inf
    if not math.isfinite(value):
        raise CalculationError(catalogue.RESULT_RANGE, name, value=value)
    return value


def require_finite(value: float, name: str) -> float:
    """`value`, or an error naming what it was for."""
    if not math.isfinite(value):
        raise CalculationError(catalogue.RESULT_RANGE, name, value=value)
    return value


# -- operators -----------------------------------------------------------------------------------------------------


def divide(a: float, b: float) -> float:
    if b == 0:
        raise CalculationError(catalogue.DIVISION_BY_ZERO, "/")
    return a / b


def modulo(a: float, b: float) -> float:
    """The remainder, with the sign of the dividend (the manual shows positive operands only)."""
    if b == 0:
        raise CalculationError(catalogue.DIVISION_BY_ZERO, "MOD")
    require_finite(a, "MOD")
    return math.fmod(a, b)


def power(a: float, b: float) -> float:
    if a == 0 and b < 0:
        raise CalculationError(catalogue.DIVISION_BY_ZERO, "**")
    if a < 0 and not float(b).is_integer():
        raise CalculationError(catalogue.DOMAIN, "**", value=a)
    return _in_range("**", lambda: math.pow(a, b))


def _bits(value: float, name: str) -> int:
    if not 0 <= value <= BIT_MAX:
        raise CalculationError(catalogue.OPERAND_NEGATIVE, name, value=value)
    return int(value)


def bit_and(a: float, b: float) -> float:
    return float(_bits(a, "&") & _bits(b, "&"))


def bit_or(a: float, b: float) -> float:
    return float(_bits(a, "|") | _bits(b, "|"))


def bit_xor(a: float, b: float) -> float:
    return float(_bits(a, "^") ^ _bits(b, "^"))


def _truth(value: float, name: str) -> bool:
    if not value >= 0:
        raise CalculationError(catalogue.OPERAND_NEGATIVE, name, value=value)
    return value >= TRUE_FROM


def logic_and(a: float, b: float) -> float:
    first, second = _truth(a, "AND"), _truth(b, "AND")
    return float(first and second)


def logic_or(a: float, b: float) -> float:
    first, second = _truth(a, "OR"), _truth(b, "OR")
    return float(first or second)


def logic_xor(a: float, b: float) -> float:
    return float(_truth(a, "XOR") != _truth(b, "XOR"))


# -- operands whose kind is only known at execution ----------------------------------------------------------------


def as_number(value: object, what: str) -> float:
    """The value if it is a number."""
    if isinstance(value, float):
        return value
    if isinstance(value, np.ndarray):
        raise CalculationError(catalogue.SETS_MIXED, what)
    raise CalculationError(catalogue.STRING_NOT_ALLOWED, what, what=what)


def as_string(value: object, what: str) -> str:
    """The value if it is a string."""
    if isinstance(value, str):
        return value
    if isinstance(value, np.ndarray):
        raise CalculationError(catalogue.SETS_MIXED, what)
    raise CalculationError(catalogue.NUMBER_NOT_ALLOWED, what, what=what)


def add(a: object, b: object) -> object:
    """Sum of numbers, join of strings, sum of whole sets of values axis by axis."""
    if isinstance(a, float) and isinstance(b, float):
        return a + b
    if isinstance(a, str) and isinstance(b, str):
        return a + b
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a + b
    raise _mixed(a, b, "+")


def subtract(a: object, b: object) -> object:
    """Difference of numbers or of whole sets of values."""
    if isinstance(a, float) and isinstance(b, float):
        return a - b
    if isinstance(a, np.ndarray) and isinstance(b, np.ndarray):
        return a - b
    raise _mixed(a, b, "-")


def _mixed(a: object, b: object, sign: str) -> CalculationError:
    if isinstance(a, np.ndarray) or isinstance(b, np.ndarray):
        return CalculationError(catalogue.SETS_MIXED, sign)
    return CalculationError(catalogue.KINDS_MIXED, sign, operator=sign)


_ORDER: dict[str, Callable[[Any, Any], bool]] = {
    "==": operator.eq,
    "!=": operator.ne,
    "<": operator.lt,
    "<=": operator.le,
    ">": operator.gt,
    ">=": operator.ge,
}


def compare(a: object, sign: str, b: object) -> float:
    """Comparison of two numbers or two strings, the latter in the order of their characters."""
    if (isinstance(a, float) and isinstance(b, float)) or (isinstance(a, str) and isinstance(b, str)):
        return float(_ORDER[sign](a, b))
    raise _mixed(a, b, sign)


# -- numbers -------------------------------------------------------------------------------------------------------

_NUMERIC = "isg.lex.numeric-functions"
_ROUNDING = "isg.lex.rounding-functions"
_TRIGONOMETRY = "isg.lex.trigonometry"


@function("ABS", _NUMERIC)
def absolute(x: float) -> float:
    return abs(x)


@function("SQR", _NUMERIC)
def square(x: float) -> float:
    return _in_range("SQR", lambda: x * x)


@function("SQRT", _NUMERIC)
def square_root(x: float) -> float:
    """The manual asks for arguments above 0 (line 1458); the root of 0 is 0 and breaks nothing, so 0 is allowed."""
    if not x >= 0:
        raise CalculationError(catalogue.DOMAIN, "SQRT", value=x)
    return math.sqrt(x)


@function("EXP", _NUMERIC)
def exponential(x: float) -> float:
    return _in_range("EXP", lambda: math.exp(x))


@function("LN", _NUMERIC)
def natural_logarithm(x: float) -> float:
    if not x > 0:
        raise CalculationError(catalogue.DOMAIN, "LN", value=x)
    return math.log(x)


@function("DEXP", _NUMERIC)
def power_of_ten(x: float) -> float:
    return _in_range("DEXP", lambda: math.pow(10.0, x))


@function("LOG", _NUMERIC)
def common_logarithm(x: float) -> float:
    if not x > 0:
        raise CalculationError(catalogue.DOMAIN, "LOG", value=x)
    return math.log10(x)


@function("INV", "isg.lex.bit-operators")
def bit_complement(x: float) -> float:
    return float(_bits(x, "INV") ^ BIT_MAX)


@function("NOT", "isg.lex.logic-operators")
def logic_not(x: float) -> float:
    return float(not _truth(x, "NOT"))


@function("INT", _ROUNDING)
def integer_part(x: float) -> float:
    return float(math.trunc(require_finite(x, "INT")))


@function("FRACT", _ROUNDING)
def fraction(x: float) -> float:
    return require_finite(x, "FRACT") - math.trunc(x)


@function("ROUND", _ROUNDING)
def nearest(x: float) -> float:
    """The nearest integer, halves upward."""
    return float(round_half_up(require_finite(x, "ROUND")))


@function("CEIL", _ROUNDING)
def ceiling(x: float) -> float:
    return float(math.ceil(require_finite(x, "CEIL")))


@function("FLOOR", _ROUNDING)
def floor(x: float) -> float:
    return float(math.floor(require_finite(x, "FLOOR")))


@function("MIN", "isg.lex.min-max-sign", 2)
def smaller(x: float, y: float) -> float:
    return min(x, y)


@function("MAX", "isg.lex.min-max-sign", 2)
def larger(x: float, y: float) -> float:
    return max(x, y)


@function("SIGN", "isg.lex.min-max-sign")
def sign(x: float) -> float:
    return float((x > 0) - (x < 0))


def round_half_up(x: float) -> int:
    """Rounding of N, M, H and parameter numbers to integers: halves upward."""
    whole = math.floor(x)
    return whole + 1 if x - whole >= 0.5 else whole


# -- angles in degrees ---------------------------------------------------------------------------------------------


@function("SIN", _TRIGONOMETRY)
def sine(x: float) -> float:
    return angles.sine(require_finite(x, "SIN"))


@function("COS", _TRIGONOMETRY)
def cosine(x: float) -> float:
    return angles.cosine(require_finite(x, "COS"))


@function("TAN", _TRIGONOMETRY)
def tangent(x: float) -> float:
    denominator = cosine(x)
    if denominator == 0:
        raise CalculationError(catalogue.DOMAIN, "TAN", value=x)
    return sine(x) / denominator


@function("COT", _TRIGONOMETRY)
def cotangent(x: float) -> float:
    denominator = sine(x)
    if denominator == 0:
        raise CalculationError(catalogue.DOMAIN, "COT", value=x)
    return cosine(x) / denominator


@function("ASIN", _TRIGONOMETRY)
def arc_sine(x: float) -> float:
    if not -1 <= x <= 1:
        raise CalculationError(catalogue.DOMAIN, "ASIN", value=x)
    return math.degrees(math.asin(x))


@function("ACOS", _TRIGONOMETRY)
def arc_cosine(x: float) -> float:
    if not -1 <= x <= 1:
        raise CalculationError(catalogue.DOMAIN, "ACOS", value=x)
    return math.degrees(math.acos(x))


@function("ATAN", _TRIGONOMETRY)
def arc_tangent(x: float) -> float:
    return math.degrees(math.atan(x))


@function("ATAN2", _TRIGONOMETRY, 2)
def arc_tangent_of_point(y: float, x: float) -> float:
    """Direction of the point (x, y); 0 for the origin (line 1561)."""
    return math.degrees(math.atan2(y, x)) if x != 0 or y != 0 else 0.0


@function("ACOT", _TRIGONOMETRY)
def arc_cotangent(x: float) -> float:
    """Between 0 and 180 degrees, so that it is continuous."""
    return 90.0 - math.degrees(math.atan(x))
