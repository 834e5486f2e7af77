"""Expressions become Python source while they are parsed: compiled once, no tree is ever walked when a block is
executed.

Sums and products are written without brackets where Python's rules agree with the manual's (long chains stay flat,
which matters to Python's own parser); every other operator is a call or is bracketed, so Python's precedence decides
nothing.
"""

from __future__ import annotations

from collections.abc import Sequence

from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import BIT_MAX, FUNCTIONS
from runtime.cnc.language.isg.words import Expression
from runtime.diagnostics.catalogue import language as catalogue

NUMBER_LIMIT = float(BIT_MAX)  # of literals and parameters: signed 32 bit, and the results of bit operators
MAX_DEPTH = 60  # nested brackets; Python's parser allows 200
SUM, PRODUCT, TIGHT = 1, 2, 3

# operator -> name of the function in `compiler.NAMES`
_CALLS = {
    "/": "divide",
    "MOD": "modulo",
    "**": "power",
    "&": "bit_and",
    "|": "bit_or",
    "^": "bit_xor",
    "&&": "logic_and",
    "AND": "logic_and",
    "||": "logic_or",
    "OR": "logic_or",
    "XOR": "logic_xor",
}
_BASES = (("16#", 16), ("0X", 16), ("H", 16), ("02#", 2), ("2#", 2), ("B", 2), ("08#", 8), ("8#", 8))


def _number(value: float, text: str, column: int) -> Expression:
    if not abs(value) <= NUMBER_LIMIT:
        raise LineError(catalogue.NUMBER_RANGE, column, text=text, limit=NUMBER_LIMIT)
    return Expression(repr(value), constant=value)


def literal(text: str, column: int) -> Expression:
    """A decimal number."""
    return _number(float(text), text, column)


def based_literal(text: str, column: int) -> Expression:
    """A hexadecimal, binary or octal number in quotes (lines 1020–1066)."""
    body = text[1:-1].upper()
    for marker, base in _BASES:
        if body.startswith(marker):
            digits = body.removeprefix(marker).strip()
            try:
                if digits.isalnum():
                    return _number(float(int(digits, base)), text, column)
            except ValueError:
                break
    raise LineError(catalogue.LITERAL_BASE, column, text=text)


def binary(left: Expression, operator: str, right: Expression, column: int) -> Expression:
    """`left operator right`."""
    operator = operator.upper()
    if operator in ("+", "-"):
        return _join(column, SUM, _part(left, SUM), f" {operator} ", _part(right, PRODUCT))
    if operator == "*":
        return _join(column, PRODUCT, _part(left, PRODUCT), " * ", _part(right, TIGHT))
    if operator in _CALLS:
        return _join(column, TIGHT, f"{_CALLS[operator]}(", _part(left, SUM), ", ", _part(right, SUM), ")")
    # a comparison gives 1 or 0
    return _join(column, TIGHT, "(1.0 if ", _part(left, SUM), f" {operator} ", _part(right, SUM), " else 0.0)")


def signed(operator: str, operand: Expression, column: int) -> Expression:
    """`+operand` or `-operand`."""
    if operator == "+":
        return operand
    if operand.constant is not None:
        return Expression(f"({-operand.constant!r})", constant=-operand.constant)
    return _join(column, TIGHT, "(-", _part(operand, TIGHT), ")")


def call(name: str, arguments: Sequence[Expression], column: int) -> Expression:
    """A function of the table."""
    name = name.upper()
    function = FUNCTIONS.get(name)
    if function is None:
        raise LineError(catalogue.FUNCTION_UNKNOWN, column, function=name)
    if len(arguments) != function.arguments:
        raise LineError(
            catalogue.FUNCTION_ARGUMENTS, column, function=name, expected=function.arguments, given=len(arguments)
        )
    parts: list[str | Expression] = [f"{function.call.__name__}("]
    for argument in arguments:
        parts += [argument, ", "]
    return _join(column, TIGHT, *parts, ")")


def parameter(number: Expression, column: int) -> Expression:
    """The number of a computed parameter, P[number]."""
    return _join(column, TIGHT, "parameter_number(", number, ")")


def read(number: str, depth: int = 0) -> Expression:
    """The value of a parameter whose number is the source `number`."""
    return Expression(f"p[{number}]", None, TIGHT, depth)


def exists(number: Expression, table: str, column: int) -> Expression:
    """1 if `number` is in the table of that name, else 0; nothing is created and nothing can fail."""
    return _join(column, TIGHT, "(1.0 if ", number, f" in {table} else 0.0)")


def _part(expression: Expression, binding: int) -> Expression:
    """The expression, in brackets if it binds looser than its place asks for."""
    if expression.binding >= binding:
        return expression
    return Expression(f"({expression.source})", None, TIGHT, expression.depth + 1)


def _join(column: int, binding: int, *parts: str | Expression) -> Expression:
    source = "".join(part if isinstance(part, str) else part.source for part in parts)
    depth = max((part.depth for part in parts if isinstance(part, Expression)), default=0) + (binding == TIGHT)
    if depth > MAX_DEPTH:
        raise LineError(catalogue.EXPRESSION_DEPTH, column, limit=MAX_DEPTH)
    return Expression(source, None, binding, depth)
