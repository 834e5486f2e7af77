"""Expressions become Python source while they are parsed: compiled once, no tree is ever walked when a block is
executed.

Sums and products are written without brackets where Python's rules agree with the manual's (long chains stay flat,
which matters to Python's own parser); every other operator is a call or is bracketed, so Python's precedence decides
nothing.
"""

from __future__ import annotations

import ast
from collections.abc import Sequence
from dataclasses import replace

import runtime.cnc.language.isg.string_functions  # noqa: F401 - registers them
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.functions import BIT_MAX, FUNCTIONS, UNSUPPORTED, divide, power
from runtime.cnc.language.isg.words import Expression, ValueKind
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
_COMPARISONS = ("==", "!=", "<", "<=", ">", ">=")
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


def text(content: str) -> Expression:
    """A string literal."""
    return Expression(repr(content), kind=ValueKind.STRING)


def literal_text(expression: Expression) -> str | None:
    """The text of a string literal, None for anything else."""
    if expression.kind is not ValueKind.STRING or expression.source[0] not in "'\"":
        return None
    return str(ast.literal_eval(expression.source))


def computed(expression: Expression) -> float:
    """The value of an expression of plain numbers with + - * / **; CalculationError if it has none."""
    return float(eval(expression.source, {"divide": divide, "power": power}))


def number(expression: Expression, what: str, column: int) -> Expression:
    """The expression where only a number makes sense: refused if it is a string, tested at execution if that is open."""
    if expression.kind is ValueKind.NUMBER:
        return expression
    if expression.kind is ValueKind.STRING:
        name = literal_text(expression)
        if name is not None:  # the name of a macro that does not exist, most likely
            raise LineError(catalogue.MACRO_UNDEFINED, column, name=name)
        raise LineError(catalogue.STRING_NOT_ALLOWED, column, what=what)
    return _join(column, TIGHT, "as_number(", expression, f", {what!r})")


def string(expression: Expression, what: str, column: int) -> Expression:
    """The expression where only a string makes sense."""
    if expression.kind is ValueKind.STRING:
        return expression
    if expression.kind is ValueKind.NUMBER:
        raise LineError(catalogue.NUMBER_NOT_ALLOWED, column, what=what)
    return _join(column, TIGHT, "as_string(", expression, f", {what!r})", kind=ValueKind.STRING)


def binary(left: Expression, operator: str, right: Expression, column: int) -> Expression:
    """`left operator right`."""
    operator = operator.upper()
    numbers = left.kind is ValueKind.NUMBER and right.kind is ValueKind.NUMBER
    if not numbers and (operator == "+" or operator in _COMPARISONS):
        return _of_any_kind(left, operator, right, column)
    if not numbers and operator == "-" and ValueKind.STRING not in (left.kind, right.kind):
        return _join(column, TIGHT, "subtract(", left, ", ", right, ")", kind=ValueKind.ANY)
    left, right = number(left, operator, column), number(right, operator, column)
    if operator in ("+", "-"):
        return _join(column, SUM, _part(left, SUM), f" {operator} ", _part(right, PRODUCT))
    if operator == "*":
        return _join(column, PRODUCT, _part(left, PRODUCT), " * ", _part(right, TIGHT))
    if operator in _CALLS:
        return _join(column, TIGHT, f"{_CALLS[operator]}(", _part(left, SUM), ", ", _part(right, SUM), ")")
    # a comparison gives 1 or 0
    return _join(column, TIGHT, "(1.0 if ", _part(left, SUM), f" {operator} ", _part(right, SUM), " else 0.0)")


def _of_any_kind(left: Expression, operator: str, right: Expression, column: int) -> Expression:
    """Join or comparison where at least one side may be a string."""
    kinds = {left.kind, right.kind}
    if kinds == {ValueKind.NUMBER, ValueKind.STRING}:
        raise LineError(catalogue.KINDS_MIXED, column, operator=operator)
    if operator == "+":
        kind = ValueKind.STRING if ValueKind.STRING in kinds else ValueKind.ANY
        return _join(column, TIGHT, "add(", left, ", ", right, ")", kind=kind)
    return _join(column, TIGHT, "compare(", left, f", {operator!r}, ", right, ")")


def signed(operator: str, operand: Expression, column: int) -> Expression:
    """`+operand` or `-operand`."""
    operand = number(operand, operator, column)
    if operator == "+":
        return operand
    if operand.constant is not None:
        return Expression(f"({-operand.constant!r})", constant=-operand.constant)
    return _join(column, TIGHT, "(-", _part(operand, TIGHT), ")")


def call(name: str, arguments: Sequence[Expression], column: int) -> Expression:
    """A function of the table."""
    name = name.upper()
    function = FUNCTIONS.get(name)
    if name in UNSUPPORTED:
        raise LineError(catalogue.FUNCTION_UNSUPPORTED, column, function=name, reason=UNSUPPORTED[name])
    if function is None:
        raise LineError(catalogue.FUNCTION_UNKNOWN, column, function=name)
    if not function.least <= len(arguments) <= function.most:
        expected = str(function.least) if function.least == function.most else f"{function.least} to {function.most}"
        raise LineError(catalogue.FUNCTION_ARGUMENTS, column, function=name, expected=expected, given=len(arguments))
    parts: list[str | Expression] = [f"{function.call.__name__}("]
    for index, argument in enumerate(arguments):
        kind = function.takes[min(index, len(function.takes) - 1)]
        if kind is ValueKind.NUMBER:
            argument = number(argument, name, column)
        elif kind is ValueKind.STRING:
            argument = string(argument, name, column)
        parts += [argument, ", "]
    return _join(column, TIGHT, *parts, ")", kind=function.gives)


def parameter(number: Expression, column: int) -> Expression:
    """The number of a computed parameter, P[number]."""
    return _join(column, TIGHT, "parameter_number(", number, ")")


def read(number: str, depth: int = 0, flush: bool = False) -> Expression:
    """The value of a parameter whose number is the source `number`."""
    return Expression(f"p[{number}]", None, TIGHT, depth, flush=flush)


def access(
    name: str, indices: Sequence[Expression], column: int, kind: ValueKind = ValueKind.NUMBER, flush: bool = False
) -> Expression:
    """A call of one of the environment's callables with indices."""
    parts: list[str | Expression] = [f"{name}("]
    for index in indices:
        parts += [number(index, "index", column), ", "]
    joined = _join(column, TIGHT, *parts, ")", kind=kind)
    return replace(joined, flush=True) if flush else joined


def named_call(name: str, arguments: Sequence[Expression], column: int, kind: ValueKind) -> Expression:
    """A call of a name of the namespace with strings as arguments."""
    parts: list[str | Expression] = [f"{name}("]
    for argument in arguments:
        parts += [string(argument, name.upper(), column), ", "]
    return _join(column, TIGHT, *parts, ")", kind=kind)


def exists(number: Expression, table: str, column: int) -> Expression:
    """1 if `number` is in the table of that name, else 0; nothing is created and nothing can fail."""
    return _join(column, TIGHT, "(1.0 if ", number, f" in {table} else 0.0)")


def _part(expression: Expression, binding: int) -> Expression:
    """The expression, in brackets if it binds looser than its place asks for."""
    if expression.binding >= binding:
        return expression
    return replace(
        expression, source=f"({expression.source})", constant=None, binding=TIGHT, depth=expression.depth + 1
    )


def _join(column: int, binding: int, *parts: str | Expression, kind: ValueKind = ValueKind.NUMBER) -> Expression:
    source = "".join(part if isinstance(part, str) else part.source for part in parts)
    operands = [part for part in parts if isinstance(part, Expression)]
    depth = max((part.depth for part in operands), default=0) + (binding == TIGHT)
    if depth > MAX_DEPTH:
        raise LineError(catalogue.EXPRESSION_DEPTH, column, limit=MAX_DEPTH)
    return Expression(source, None, binding, depth, kind, any(part.flush for part in operands))
