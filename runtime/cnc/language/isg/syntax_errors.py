"""Where the grammar gives up, say in the user's words what is wrong."""

from __future__ import annotations

import re

from lark import UnexpectedCharacters, UnexpectedInput, UnexpectedToken

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.words import Control
from runtime.diagnostics.catalogue import language as catalogue

# What the dialect has and this grammar has not yet: pattern at the place → name in the message.
_UNSUPPORTED: tuple[tuple[re.Pattern[str], str], ...] = (
    (re.compile(r"#\s*([A-Za-z]+(?:[ _]+[A-Za-z]+)*)"), "statement #{0}"),
    (re.compile(r"#"), "statement #"),
    (re.compile(r"(V\.[A-Za-z0-9_.@+-]*)"), "variable {0}"),
    (re.compile(r"(@\w*)"), "cycle parameter {0}"),
    (re.compile(r"\\"), "line continuation \\"),
    (re.compile(r":"), "label"),
    (re.compile(r"[Rr]\s*1?(?=[^\w=]|$)"), "reading the circle radius R"),
)
_QUOTED = re.compile(r'"((?:\\.|[^"\\])*)"?')
_CONTROLS = frozenset((*(control.value[1:] for control in Control), "GOTO"))
_AXIS_BRACKET = re.compile(r"([ABCQS-Z][A-Za-z0-9_]*)\s*\[\s*$")
_BRACKET_COMMAND = re.compile(r"[MH]\s*\d+|[A-Z][A-Z_]+(?![A-Za-z]*\[)")
_CONTROL_WORD = re.compile(r"\$[A-Za-z]+")
_BRACKETED_CALL = re.compile(r"[Ll]{1,2}\s*(CYCLE|SEQUENCE)$")
_LAST_ADDRESS = re.compile(r"(\$?[A-Za-z][A-Za-z0-9_]*|[^\s])$")


def explain(text: str, error: UnexpectedInput, addresses: Addresses) -> LineError:
    """The LineError for a place that the grammar does not take. `text` is the block with blanked comments."""
    position, expected = _place(text, error)
    column = position + 1
    rest = text[position:]
    bracket = _unbalanced(text)
    wants_value = "NUMBER" in expected
    if not rest.strip():
        if bracket is not None:
            return bracket
        control = _CONTROL_WORD.search(text)
        if control and not wants_value:
            return LineError(catalogue.CONTROL_INCOMPLETE, column, statement=control.group().upper())
        return LineError(catalogue.VALUE_MISSING, len(text.rstrip()) or 1, address=_before(text))
    if rest[0] == "$":
        return _control(rest, column)
    quoted = _QUOTED.match(rest)
    if quoted:
        return LineError(catalogue.MACRO_UNDEFINED, column, name=quoted.group(1))
    for pattern, what in _UNSUPPORTED:
        match = pattern.match(rest)
        if match and (wants_value or what != "reading the circle radius R"):
            name = what.format(*(group.strip() for group in match.groups()))
            return LineError(catalogue.NOT_SUPPORTED, column, what=name)
    if rest[0] == "]" and bracket is not None:
        return bracket
    if rest[0] == "[" and not wants_value:
        previous = text[:position].rstrip()
        call = _BRACKETED_CALL.search(previous)
        what = call.group() if call else "label or bracketed command" if previous else "label"
        return LineError(catalogue.NOT_SUPPORTED, column, what=f"{what} {rest.split(']')[0]}]")
    bracketed = _AXIS_BRACKET.search(text[:position])
    command = _BRACKET_COMMAND.match(rest)
    if bracketed is not None and command is not None:
        what = f"bracket command {bracketed.group(1)}[{command.group()} ..]"
        return LineError(catalogue.NOT_SUPPORTED, column, what=what)
    if wants_value:
        if bracket is not None and not rest[0].isalnum():
            return bracket
        return LineError(catalogue.VALUE_MISSING, column, address=_before(text[:position]))
    if rest[0].isalpha():
        return LineError(catalogue.ADDRESS_UNKNOWN, column, address=rest[0], axes=", ".join(addresses.axes))
    return bracket or LineError(catalogue.SYNTAX, column, found=rest.split()[0][:20])


def _place(text: str, error: UnexpectedInput) -> tuple[int, set[str]]:
    """Index into the text and the names of the terminals that could have stood there."""
    if isinstance(error, UnexpectedCharacters):
        return error.pos_in_stream or 0, set(error.allowed or ())
    if isinstance(error, UnexpectedToken):
        if error.token.type == "$END":
            return len(text), set(error.accepts or error.expected)
        return error.token.start_pos or 0, set(error.accepts or error.expected)
    return len(text), set()


def _unbalanced(text: str) -> LineError | None:
    opened: list[int] = []
    for column, character in enumerate(text, 1):
        if character == "[":
            opened.append(column)
        elif character == "]":
            if not opened:
                return LineError(catalogue.BRACKET_CLOSE, column)
            opened.pop()
    return LineError(catalogue.BRACKET_OPEN, opened[-1]) if opened else None


def _before(text: str) -> str:
    match = _LAST_ADDRESS.search(text.rstrip(" ="))
    return match.group(1) if match else text.strip()[-1:] or "block"


def _control(rest: str, column: int) -> LineError:
    match = re.match(r"\$[A-Za-z]*", rest)
    statement = match.group().upper() if match else "$"
    if statement[1:] in _CONTROLS:
        return LineError(catalogue.CONTROL_PLACE, column, statement=statement)
    return LineError(catalogue.CONTROL_UNKNOWN, column, statement=statement)
