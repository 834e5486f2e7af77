"""Expressions: the manual's operators, priorities and functions."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import FUNCTIONS
from runtime.cnc.language.isg.words import ValueKind
from tests.cnc.decoder.programs import decode

ADDRESSES = Addresses(("X", "Y", "Z"))


def value(text: str, **parameters: float) -> float:
    """The value of an expression; `P1=..` sets parameters."""
    program = "".join(f"{name} = {number!r}\n" for name, number in parameters.items())
    run = decode(program + f"P99 = {text}\n")
    if run.problem:
        raise CalculationError(run.problem.entry, "P99", **run.problem.values)
    return run.parameters[99]


# -- priorities ----------------------------------------------------------------------------------------------------

# The table of the manual (line 1509), strongest first; a sign binds like a product's factor, ** to the right.
LEVELS: list[tuple[str, ...]] = [
    ("**",),
    ("*", "/", "MOD"),
    ("+", "-"),
    ("&",),
    ("^",),
    ("|",),
    ("<=", ">=", "==", "<", ">", "!="),
    ("&&", "AND"),
    ("XOR",),
    ("||", "OR"),
]
SIGN_LEVEL = 0.5  # between ** and *
STRENGTH = {operator: level for level, operators in enumerate(LEVELS) for operator in operators}


def bits(a: float) -> int:
    if not 0 <= a < 2**32:
        raise ArithmeticError
    return int(a)


def truth(a: float) -> bool:
    if a < 0:
        raise ArithmeticError
    return a >= 0.5


def raised(a: float, b: float) -> float:
    a, b = float(a), float(b)
    result: object = a**b
    if not isinstance(result, float) or not math.isfinite(result):
        raise ArithmeticError
    return result


def remainder(a: float, b: float) -> float:
    if b == 0:
        raise ArithmeticError
    return math.fmod(a, b)


MEANING: dict[str, Callable[[float, float], float]] = {
    "**": raised,
    "*": lambda a, b: a * b,
    "/": lambda a, b: a / b,
    "MOD": remainder,
    "+": lambda a, b: a + b,
    "-": lambda a, b: a - b,
    "&": lambda a, b: bits(a) & bits(b),
    "^": lambda a, b: bits(a) ^ bits(b),
    "|": lambda a, b: bits(a) | bits(b),
    "<=": lambda a, b: a <= b,
    ">=": lambda a, b: a >= b,
    "==": lambda a, b: a == b,
    "<": lambda a, b: a < b,
    ">": lambda a, b: a > b,
    "!=": lambda a, b: a != b,
    "&&": lambda a, b: truth(a) & truth(b),
    "AND": lambda a, b: truth(a) & truth(b),
    "XOR": lambda a, b: truth(a) ^ truth(b),
    "||": lambda a, b: truth(a) | truth(b),
    "OR": lambda a, b: truth(a) | truth(b),
}


@dataclass(frozen=True)
class Node:
    operator: str  # "" for a number, "neg" for a sign
    left: Node | None = None
    right: Node | None = None
    number: float = 0.0

    def evaluate(self) -> float:
        if self.operator == "":
            return self.number
        assert self.right is not None
        if self.operator == "neg":
            return -self.right.evaluate()
        assert self.left is not None
        return float(MEANING[self.operator](self.left.evaluate(), self.right.evaluate()))

    @property
    def strength(self) -> float:
        if self.operator == "":
            return -1
        return SIGN_LEVEL if self.operator == "neg" else STRENGTH[self.operator]

    def text(self) -> str:
        """With as few brackets as the table allows."""
        if self.operator == "":
            return f"{self.number:g}"
        assert self.right is not None
        if self.operator == "neg":
            return f"-{bracketed(self.right, self.right.strength <= SIGN_LEVEL)}"
        assert self.left is not None
        if self.operator == "**":  # to the right; a sign may stand in the exponent
            left = bracketed(self.left, self.left.strength < 0)
            return f"{left}**{bracketed(self.right, self.right.strength <= SIGN_LEVEL)}"
        left = bracketed(self.left, self.left.strength <= self.strength)
        return f"{left} {self.operator} {bracketed(self.right, self.right.strength < self.strength)}"


def bracketed(node: Node, bare: bool) -> str:
    return node.text() if bare else f"[{node.text()}]"


numbers = st.sampled_from([0, 0.25, 0.5, 1, 2, 3, 5, 7.5, 10, 255]).map(lambda n: Node("", number=n))
nodes = st.recursive(
    numbers,
    lambda inner: st.one_of(
        st.builds(Node, st.sampled_from(list(STRENGTH)), inner, inner),
        st.builds(Node, st.just("neg"), st.none(), inner),
    ),
    max_leaves=12,
)


@pytest.mark.spec("isg.lex.arithmetic-operators", "isg.lex.bit-operators", "isg.lex.logic-operators")
@given(nodes)
def test_priorities_are_those_of_the_manual(node: Node) -> None:
    try:
        expected = node.evaluate()
        if not abs(expected) < 2**32:
            raise ArithmeticError
    except ArithmeticError:
        with pytest.raises(CalculationError):
            value(node.text())
    else:
        assert value(node.text()) == expected


@pytest.mark.spec("isg.lex.arithmetic-operators", "isg.flow.if")
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("1 + 2 * 3 ** 2", 19),
        ("2 ** 3 ** 2", 512),
        ("-2 ** 2", -4),
        ("2 ** -1", 0.5),
        ("11 MOD 3", 2),
        ("10 - 3 - 2", 5),
        ("100 / 10 / 2", 5),
        ("5 & 4 == 4", 1),  # bit operators bind tighter than comparisons, unlike C
        ("1 | 6 ^ 3 & 2", 5),
        ("1 OR 1 XOR 1", 1),  # OR is weakest
        ("1 XOR 0 AND 0", 1),
        ("3 >= -5", 1),
        ("[[1 + 2] * [3 - 1]] / 4", 1.5),
        ("1 - -1", 2),
        ("0.3 - [0.1 + 0.2] * 1", 0.3 - (0.1 + 0.2)),
        ("TRUE + PI * FALSE", 1),
        ("true or false", 1),
        ("2and 1", 1),
        ("1+" * 1900 + "1", 1901),
    ],
)
def test_expressions(text: str, expected: float) -> None:
    assert value(text) == expected


@pytest.mark.spec(
    "isg.lex.numeric-functions", "isg.lex.trigonometry", "isg.lex.rounding-functions", "isg.lex.min-max-sign"
)
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("ABS[2 - 4]", 2),
        ("SQR[3]", 9),
        ("SQRT[SQR[3] + SQR[4]]", 5),
        ("EXP[1]", math.e),
        ("LN[EXP[2]]", 2),
        ("DEXP[2]", 100),
        ("LOG[1000]", 3),
        ("INV[0]", 4294967295),
        ("INV['16#FFFFFFFE']", 1),
        ("NOT[0.5]", 0),
        ("NOT[0.49]", 1),
        ("sin[30]", 0.5),
        ("SIN[180]", 0),
        ("COS[60]", 0.5),
        ("COS[-90]", 0),
        ("SIN[-90]", -1),
        ("TAN[45]", 1),
        ("TAN[180]", 0),
        ("COT[90]", 0),
        ("COT[45]", 1),
        ("ASIN[1]", 90),
        ("ACOS[-1]", 180),
        ("ATAN[1]", 45),
        ("ATAN2[100,100]", 45),
        ("ATAN2[-1, -1]", -135),
        ("ATAN2[0,0]", 0),
        ("ACOT[1]", 45),
        ("ACOT[-1]", 135),
        ("INT[123.567]", 123),
        ("INT[-1.5]", -1),
        ("FRACT[123.567]", 0.567),
        ("ROUND[77.5]", 78),
        ("ROUND[45.4]", 45),
        ("ROUND[-2.5]", -2),
        ("CEIL[8.3]", 9),
        ("FLOOR[8.7]", 8),
        ("MIN[2, -3]", -3),
        ("MAX[2, SIGN[-3]]", 2),
        ("SIGN[0]", 0),
        ("SIGN[-0.1]", -1),
    ],
)
def test_functions(text: str, expected: float) -> None:
    assert value(text) == pytest.approx(expected, abs=1e-12)


def test_every_function_is_tested() -> None:
    source = open(__file__).read()  # noqa: SIM115
    assert [name for name in NUMERIC if f"{name}[" not in source.replace("sin[", "SIN[")] == []


NUMERIC = sorted(name for name, function in FUNCTIONS.items() if ValueKind.STRING not in function.takes)


@given(st.sampled_from(NUMERIC), st.floats(-1e9, 1e9), st.floats(-1e9, 1e9))
def test_functions_give_a_finite_number_or_a_program_error(name: str, x: float, y: float) -> None:
    function = FUNCTIONS[name]
    assert ValueKind.STRING not in function.takes
    try:
        result = function.call(*(x, y)[: function.most])
    except CalculationError:
        return
    assert isinstance(result, str) or math.isfinite(result)


@given(st.integers(-1000, 1000))
def test_angles_are_degrees(angle: int) -> None:
    assert value(f"SIN[{angle}]") == pytest.approx(math.sin(math.radians(angle)), abs=1e-12)
    assert value(f"COS[{angle}]") == pytest.approx(math.cos(math.radians(angle)), abs=1e-12)


def test_bits_are_cut_to_integers() -> None:
    assert value("P1 & P2", P1=6.9, P2=3.2) == 2
