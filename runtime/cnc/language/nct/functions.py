"""Arithmetic of the NCT dialect: operators, comparisons and functions (programmer's manual lines 6618–6689, 7260–7434).

A value is a float, or None for a vacant one: a variable that was never given a value. In calculations it counts as 0, and what
is calculated is never vacant. What has no value raises CalculationError, whose `name` is what stands in the program text.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import TypeVar

from runtime.cnc.language import angles
from runtime.cnc.language.errors import CalculationError
from runtime.diagnostics.catalogue import nct_macros as catalogue

Value = float | None

MANTISSA = 2.0**-31  # what the 32 bits of a variable's mantissa cannot tell apart, as a share (line 6625)
BITS_LEAST, BITS_MOST = -(2**31), 2**31 - 1
DECIMAL_MOST = 99_999_999  # of BCD and BIN (line 7371)


def number(value: Value) -> float:
    """The value in a calculation: a vacant one counts as 0."""
    return 0.0 if value is None else value


def whole(value: float) -> int:
    """The nearest whole number, halves away from zero, as addresses take variables (line 6607)."""
    return math.floor(value + 0.5) if value >= 0 else math.ceil(value - 0.5)


def _finite(value: float, name: str) -> float:
    if not math.isfinite(value):
        raise CalculationError(catalogue.RESULT_RANGE, name)
    return value


# -- operators -----------------------------------------------------------------------------------------------------


def negate(a: Value) -> float:
    return 0.0 - number(a)


def add(a: Value, b: Value) -> float:
    return _finite(number(a) + number(b), "+")


def subtract(a: Value, b: Value) -> float:
    return _finite(number(a) - number(b), "-")


def multiply(a: Value, b: Value) -> float:
    return _finite(number(a) * number(b), "*")


def divide(a: Value, b: Value) -> float:
    divisor = number(b)
    if divisor == 0:
        raise CalculationError(catalogue.DIVISION_BY_ZERO, "/")
    return _finite(number(a) / divisor, "/")


def modulo(a: Value, b: Value) -> float:
    """The remainder, with the sign of the dividend (the manual shows positive operands only)."""
    divisor = number(b)
    if divisor == 0:
        raise CalculationError(catalogue.DIVISION_BY_ZERO, "MOD")
    return math.fmod(number(a), divisor)


def _bits(value: Value, name: str) -> int:
    a = number(value)
    if not BITS_LEAST - 0.5 < a < BITS_MOST + 0.5:
        raise CalculationError(catalogue.BITS, name, value=a)
    return whole(a)


def bit_and(a: Value, b: Value) -> float:
    return float(_bits(a, "AND") & _bits(b, "AND"))


def bit_or(a: Value, b: Value) -> float:
    return float(_bits(a, "OR") | _bits(b, "OR"))


def bit_xor(a: Value, b: Value) -> float:
    return float(_bits(a, "XOR") ^ _bits(b, "XOR"))


# -- comparisons ---------------------------------------------------------------------------------------------------


def _order(value: Value) -> tuple[float, bool]:
    """What values are compared by: a vacant one is 0, but a little greater than the number 0 (lines 6664–6688)."""
    return number(value), value is None


COMPARISONS: dict[str, Callable[[Value, Value], bool]] = {
    "EQ": lambda a, b: _order(a) == _order(b),
    "NE": lambda a, b: _order(a) != _order(b),
    "GT": lambda a, b: _order(a) > _order(b),
    "LT": lambda a, b: _order(a) < _order(b),
    "GE": lambda a, b: _order(a) >= _order(b),
    "LE": lambda a, b: _order(a) <= _order(b),
}


# -- functions -----------------------------------------------------------------------------------------------------


@dataclass(frozen=True, slots=True)
class Function:
    """A function of one operand."""

    name: str
    spec: str
    call: Callable[[Value], float]


FUNCTIONS: dict[str, Function] = {}
Call = TypeVar("Call", bound=Callable[[Value], float])


def function(name: str, spec: str = "nct.expr.functions") -> Callable[[Call], Call]:
    """Register a function."""

    def register(call: Call) -> Call:
        FUNCTIONS[name] = Function(name, spec, call)
        return call

    return register


@function("NOT", "nct.expr.bitwise")
def bit_not(a: Value) -> float:
    return float(~_bits(a, "NOT"))


@function("SQRT")
def square_root(a: Value) -> float:
    x = number(a)
    if x < 0:
        raise CalculationError(catalogue.DOMAIN, "SQRT", value=x)
    return math.sqrt(x)


@function("SIN")
def sine(a: Value) -> float:
    return angles.sine(number(a))


@function("COS")
def cosine(a: Value) -> float:
    return angles.cosine(number(a))


@function("TAN")
def tangent(a: Value) -> float:
    x = number(a)
    denominator = angles.cosine(x)
    if denominator == 0:
        raise CalculationError(catalogue.DOMAIN, "TAN", value=x)
    return angles.sine(x) / denominator


@function("ASIN")
def arc_sine(a: Value) -> float:
    x = number(a)
    if not -1 <= x <= 1:
        raise CalculationError(catalogue.DOMAIN, "ASIN", value=x)
    return math.degrees(math.asin(x))


@function("ACOS")
def arc_cosine(a: Value) -> float:
    x = number(a)
    if not -1 <= x <= 1:
        raise CalculationError(catalogue.DOMAIN, "ACOS", value=x)
    return math.degrees(math.acos(x))


@function("ATAN")
def arc_tangent(a: Value) -> float:
    return math.degrees(math.atan(number(a)))


@function("EXP")
def exponential(a: Value) -> float:
    try:
        return math.exp(number(a))
    except OverflowError:
        raise CalculationError(catalogue.RESULT_RANGE, "EXP") from None


@function("LN")
def natural_logarithm(a: Value) -> float:
    x = number(a)
    if not x > 0:
        raise CalculationError(catalogue.DOMAIN, "LN", value=x)
    return math.log(x)


@function("ABS")
def absolute(a: Value) -> float:
    return abs(number(a))


@function("BCD")
def to_decimal_code(a: Value) -> float:
    """A whole number as binary-coded decimal: 19 becomes 16#19, which is 25."""
    x = number(a)
    if not -0.5 < x < DECIMAL_MOST + 0.5:
        raise CalculationError(catalogue.DECIMAL_CODE, "BCD", value=x)
    return float(int(str(whole(x)), 16))


@function("BIN")
def from_decimal_code(a: Value) -> float:
    """The number that a binary-coded decimal is: 25, which is 16#19, becomes 19."""
    x = number(a)
    digits = f"{whole(x):x}" if x > -0.5 else "-"
    if not digits.isdecimal() or int(digits) > DECIMAL_MOST:
        raise CalculationError(catalogue.DECIMAL_CODE, "BIN", value=x)
    return float(int(digits))


def _near_whole(x: float) -> float:
    """A number that differs from a whole one by less than a variable's mantissa holds is that whole one.

    The control has 32 bits there and a float 53, in which 3 * 0.1 * 10 is a little more than 3: FUP must not make 4 of it.
    """
    nearest = float(whole(x))
    return nearest if abs(x - nearest) <= MANTISSA * abs(x) else x


@function("FIX")
def without_fraction(a: Value) -> float:
    """Towards zero."""
    return float(math.trunc(_near_whole(number(a))))


@function("FUP")
def next_whole(a: Value) -> float:
    """Away from zero to the next whole number; a whole number stays."""
    x = _near_whole(number(a))
    return float(math.ceil(x) if x >= 0 else math.floor(x))
