"""Random numeric expressions with their values, by the priorities of the manual (programming manual lines 1509–1533).

    10 **    9 * / MOD    8 + -    7 &    6 ^    5 |    4 == != <= >= < >    3 && AND    2 XOR    1 || OR

A term is text and value at once: it is put together from smaller ones, with brackets where the priorities need them and now and
then where they do not. A sign stands between ** and *; ** goes to the right, all others to the left.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass

from hypothesis import strategies as st

ATOM, SIGN, POWER = 11.0, 9.5, 10.0
UNSIGNED = 2**32 - 1  # the greatest operand of bit operators (line 1470)
RANGE = float(UNSIGNED)  # literals and parameters

Value = float | None  # None: there is no value, the program ends with an error
Meaning = Callable[[float, float], Value]


@dataclass(frozen=True, slots=True)
class Term:
    """`strength` is the priority of its outermost operator."""

    text: str
    value: Value
    strength: float = ATOM

    def within(self, weakest: float) -> str:
        """The text where nothing weaker than `weakest` may stand bare."""
        return self.text if self.strength >= weakest else f"[{self.text}]"


# -- operators -----------------------------------------------------------------------------------------------------


def _finite(value: float) -> Value:
    return value if math.isfinite(value) else None


def _power(a: float, b: float) -> Value:
    try:
        result: object = a**b
    except (OverflowError, ZeroDivisionError):
        return None
    return _finite(result) if isinstance(result, float) else None  # of a negative number with a fraction: complex


def _remainder(a: float, b: float) -> Value:
    return None if b == 0 else math.copysign(abs(a) % abs(b), a)  # the sign of the dividend


def _bitwise(meaning: Callable[[int, int], int]) -> Meaning:
    def call(a: float, b: float) -> Value:
        if not (0 <= a <= UNSIGNED and 0 <= b <= UNSIGNED):
            return None
        return float(meaning(math.floor(a), math.floor(b)))

    return call


def _logical(meaning: Callable[[bool, bool], bool]) -> Meaning:
    def call(a: float, b: float) -> Value:
        return None if a < 0 or b < 0 else float(meaning(a >= 0.5, b >= 0.5))

    return call


_OPERATORS: Mapping[str, tuple[float, Meaning]] = {
    "**": (10, _power),
    "*": (9, lambda a, b: _finite(a * b)),
    "/": (9, lambda a, b: None if b == 0 else _finite(a / b)),
    "MOD": (9, _remainder),
    "+": (8, lambda a, b: _finite(a + b)),
    "-": (8, lambda a, b: _finite(a - b)),
    "&": (7, _bitwise(lambda a, b: a & b)),
    "^": (6, _bitwise(lambda a, b: a ^ b)),
    "|": (5, _bitwise(lambda a, b: a | b)),
    "==": (4, lambda a, b: float(a == b)),
    "!=": (4, lambda a, b: float(a != b)),
    "<=": (4, lambda a, b: float(a <= b)),
    ">=": (4, lambda a, b: float(a >= b)),
    "<": (4, lambda a, b: float(a < b)),
    ">": (4, lambda a, b: float(a > b)),
    "AND": (3, _logical(lambda a, b: a and b)),
    "XOR": (2, _logical(lambda a, b: a != b)),
    "OR": (1, _logical(lambda a, b: a or b)),
}
_SPELLINGS = {"MOD": ("MOD", "mod"), "AND": ("AND", "&&", "and"), "XOR": ("XOR", "xor"), "OR": ("OR", "||", "Or")}


def binary(operator: str, left: Term, right: Term, spelling: str = "", blank: str = " ") -> Term:
    """Two terms and an operator between them."""
    strength, meaning = _OPERATORS[operator]
    known = left.value is not None and right.value is not None
    value = meaning(float(left.value), float(right.value)) if known else None  # type: ignore[arg-type]
    if operator == "**":
        texts = left.within(ATOM), right.within(SIGN)
    else:
        texts = left.within(strength), right.within(strength + 0.1)
    spelling = spelling or operator
    blank = " " if spelling.isalpha() else blank
    return Term(f"{texts[0]}{blank}{spelling}{blank}{texts[1]}", value, strength)


def signed(sign: str, operand: Term) -> Term:
    """A sign in front of a term."""
    value = operand.value
    if sign == "-" and value is not None:
        value = -value
    return Term(sign + operand.within(SIGN), value, SIGN)


# -- functions -----------------------------------------------------------------------------------------------------


def _root(x: float) -> Value:
    return math.sqrt(x) if x >= 0 else None


def _half_up(x: float) -> Value:
    whole = float(math.floor(x))
    return whole + 1.0 if x - whole >= 0.5 else whole


def _complement(x: float) -> Value:
    return float(UNSIGNED - math.floor(x)) if 0 <= x <= UNSIGNED else None


EXACT: Mapping[str, Callable[[float], Value]] = {
    "ABS": abs,
    "SQR": lambda x: _finite(x * x),
    "SQRT": _root,
    "INT": lambda x: float(math.floor(x) if x >= 0 else math.ceil(x)),
    "FRACT": lambda x: math.fmod(x, 1.0),
    "ROUND": _half_up,
    "CEIL": lambda x: float(math.ceil(x)),
    "FLOOR": lambda x: float(math.floor(x)),
    "SIGN": lambda x: float(x > 0) - float(x < 0),
    "NOT": lambda x: None if x < 0 else float(x < 0.5),
    "INV": _complement,
}
EXACT_OF_TWO: Mapping[str, Callable[[float, float], Value]] = {"MIN": min, "MAX": max}

# Names, smallest and greatest argument, meaning; where tangents and logarithms are steep nothing is asked.
SMOOTH: Mapping[str, tuple[float, float, Callable[[float], float]]] = {
    "SIN": (-720, 720, lambda x: math.sin(math.radians(x))),
    "COS": (-720, 720, lambda x: math.cos(math.radians(x))),
    "TAN": (-80, 80, lambda x: math.tan(math.radians(x))),
    "COT": (10, 170, lambda x: 1.0 / math.tan(math.radians(x))),
    "ASIN": (-1, 1, lambda x: math.degrees(math.asin(x))),
    "ACOS": (-1, 1, lambda x: math.degrees(math.acos(x))),
    "ATAN": (-100, 100, lambda x: math.degrees(math.atan(x))),
    "ACOT": (-100, 100, lambda x: math.degrees(math.atan2(1.0, x))),
    "EXP": (-10, 10, math.exp),
    "LN": (0.01, 1000, math.log),
    "DEXP": (-5, 5, lambda x: 10.0**x),
    "LOG": (0.01, 1000, math.log10),
}


def function(name: str, *arguments: Term) -> Term:
    """A call of one of EXACT or EXACT_OF_TWO."""
    text = f"{name}[{', '.join(argument.text for argument in arguments)}]"
    values = [float(argument.value) for argument in arguments if argument.value is not None]
    if len(values) < len(arguments):
        return Term(text, None)
    return Term(text, EXACT[name](*values) if name in EXACT else EXACT_OF_TWO[name](*values))


# -- random ones ---------------------------------------------------------------------------------------------------

# The parameters that every term may read, and one that nobody has written.
PARAMETERS: Mapping[int, float] = {1: 3.0, 2: -2.0, 3: 0.25, 12: 1000.0, 700: 0.0}
UNWRITTEN = 8

_LITERALS = (
    *(
        Term(text, float(text))
        for text in ("0", "1", "2", "3", "7", "10", "255", "0.25", ".5", "7.", "007", "1.5e2", "2e-1")
    ),
    *(Term("'H1F'", 31.0), Term("'16#ff'", 255.0), Term("'0x0E'", 14.0), Term("'2#1011'", 11.0), Term("'B101'", 5.0)),
    *(Term("'02#11'", 3.0), Term("'8#17'", 15.0), Term("'08#7'", 7.0), Term("TRUE", 1.0), Term("false", 0.0)),
)
_READS = (
    *(Term(f"P{number}", value) for number, value in PARAMETERS.items()),
    *(Term("P[10 + 2]", 1000.0), Term("PP1", PARAMETERS[3]), Term("p1", 3.0)),
)

_numbers = st.integers(0, 4000).map(lambda quarters: Term(f"{quarters / 4:g}", quarters / 4))
_operands = st.one_of(_numbers, st.sampled_from(_LITERALS), st.sampled_from(_READS))
unwritten = Term(f"P{UNWRITTEN}", None)


def _operations(inner: st.SearchStrategy[Term]) -> st.SearchStrategy[Term]:
    blanks = st.sampled_from(("", " ", "  "))

    def of(operator: str) -> st.SearchStrategy[Term]:
        spellings = st.sampled_from(_SPELLINGS.get(operator, (operator,)))
        return st.builds(binary, st.just(operator), inner, inner, spellings, blanks)

    return st.one_of(
        st.sampled_from(list(_OPERATORS)).flatmap(of),
        st.sampled_from(list(_OPERATORS)).flatmap(of),
        st.builds(signed, st.sampled_from("+-"), inner),
        st.builds(function, st.sampled_from(list(EXACT)), inner),
        st.builds(function, st.sampled_from(list(EXACT_OF_TWO)), inner, inner),
        inner.map(lambda term: Term(f"[{term.text}]", term.value)),
    )


expressions = st.recursive(_operands, _operations, max_leaves=12)
with_unwritten_parameter = st.builds(binary, st.sampled_from(list(_OPERATORS)), expressions, st.just(unwritten))


def _smooth_term(name: str) -> st.SearchStrategy[Term]:
    low, high, meaning = SMOOTH[name]
    arguments = st.integers(math.ceil(low * 100), math.floor(high * 100)).map(lambda hundredths: hundredths / 100)
    return arguments.map(lambda x: Term(f"{name}[{x:.2f}]", meaning(x)))


# Functions whose last digits nobody promises, in expressions that do not make small differences great: to be compared closely,
# not exactly.
smooth_expressions = st.recursive(
    st.one_of(
        st.sampled_from(list(SMOOTH)).flatmap(_smooth_term),
        st.tuples(st.integers(-50, 50), st.integers(-50, 50)).map(
            lambda yx: Term(f"ATAN2[{yx[0]}, {yx[1]}]", math.degrees(math.atan2(*yx)))
        ),
        st.just(Term("PI", math.pi)),
    ),
    lambda inner: st.one_of(
        st.builds(binary, st.sampled_from(["+", "-", "*"]), inner, st.sampled_from(_LITERALS)),
        st.builds(binary, st.sampled_from(["+", "-"]), inner, inner),
    ),
    max_leaves=4,
)
