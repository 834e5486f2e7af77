"""Expressions of the NCT dialect become Python source while they are parsed: no tree is walked when a block is executed.

A value is a number, or None for a vacant variable. Every operation is a call of a name that the executing namespace has to have:

    read(n)  number_of(v)  write(n, v)              variables; `number_of` checks a computed number, `#[..]`
    negate  add  subtract  multiply  divide  modulo  bit_and  bit_or  bit_xor
    EQ NE GT LT GE LE                               comparisons
    NOT SQRT SIN COS TAN ASIN ACOS ATAN EXP LN ABS BCD BIN FIX FUP

Numbers of the text are constants; a sign in front of a number makes another constant.
"""

from __future__ import annotations

from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct.words import Expression
from runtime.diagnostics.catalogue import nct as catalogue

MOST_BRACKETS = 5  # nested (line 7405)
OPERATORS = {
    "+": "add", "-": "subtract", "*": "multiply", "/": "divide", "MOD": "modulo",
    "AND": "bit_and", "OR": "bit_or", "XOR": "bit_xor",
}  # fmt: skip


def literal(text: str) -> Expression:
    """A number of the text."""
    return Expression.number(float(text))


def call(name: str, *operands: Expression) -> Expression:
    """`name(operand, …)`."""
    names = frozenset({name}).union(*(operand.names for operand in operands))
    source = f"{name}({', '.join(operand.source for operand in operands)})"
    return Expression(source, None, names, max(operand.depth for operand in operands))


def signed(sign: str, operand: Expression) -> Expression:
    """A sign in front of an operand."""
    if sign == "+":
        return operand
    if operand.constant is not None:
        return Expression.number(-operand.constant)
    return call("negate", operand)


def bracketed(inner: Expression, column: int) -> Expression:
    """An expression in brackets. LineError for too many of them."""
    depth = inner.depth + 1
    if depth > MOST_BRACKETS:
        raise LineError(catalogue.MACRO_STATEMENT, column, reason=f"brackets are nested deeper than {MOST_BRACKETS}")
    return Expression(inner.source, inner.constant, inner.names, depth)


def numbered(text: str, column: int) -> Expression:
    """The number of `#12`. LineError for one that is not whole."""
    if not text.isdigit():
        raise LineError(catalogue.VARIABLE_NUMBER_TEXT, column, text=text)
    return Expression(text, float(text))


def read(number: Expression) -> Expression:
    """The value of a variable."""
    return call("read", number)
