"""Macros: quoted names that stand for a piece of NC text (programming manual lines 1388–1431, 25995–26160).

A definition `"NAME" = "content"` is taken out of the block; the name of a defined macro is replaced by its content, again
and again. A quoted text that is no macro stays where it is: a string, or an error of the grammar.
"""

from __future__ import annotations

import re
from collections.abc import Iterator

from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.environment import Environment
from runtime.diagnostics.catalogue import language as catalogue

MACRO_DEPTH = 20  # a macro in a macro; the manual gives no number
MAX_EXPANDED = 16_000  # characters of a block after replacement

_QUOTED = r'"((?:\\.|[^"\\])*)"'
_DEFINITION = re.compile(rf'(?<![\w\]"+=,\[])[ \t]*{_QUOTED}[ \t]*=(?!=)[ \t]*{_QUOTED}')
_NAME = re.compile(_QUOTED)
_CALL_BEFORE = re.compile(r"(?:^|[^A-Za-z0-9_.])([Ll]{1,2})[ \t]*$")
_NAMED_BEFORE = re.compile(r"(?:EXIST|MACRO_LENGTH|MACRO_CONTENT)[ \t]*\[[ \t]*$", re.IGNORECASE)
_TEXTS = re.compile(rf"{_QUOTED}|#(MSG|ADD|FILE|ERROR)\b|(SEQUENCE)[ \t]*(?=\[)|(\[)|(\])", re.IGNORECASE)
_G_EXPRESSION = re.compile(r"(?<![A-Za-z0-9_.@#$])[Gg][ \t]*(\d[\d.]*(?:[ \t]*(?:\*\*|[-+*/])[ \t]*\d[\d.]*)+)")


def define_and_replace(text: str, environment: Environment) -> tuple[tuple[tuple[str, str], ...], str]:
    """The macro definitions of a block, and the block without them and with every macro replaced. Raises LineError."""
    definitions: list[tuple[str, str]] = []

    def note(match: re.Match[str]) -> str:
        definitions.append((match.group(1), match.group(2)))
        check_content(match.group(1), match.group(2), match.start() + 1)
        return " " * len(match.group())

    text = _DEFINITION.sub(note, text) if not re.match(r"\s*(?:N\S*\s*)?#", text) else text
    return tuple(definitions), _replaced(text, environment, dict(definitions), 0)


def check_content(name: str, content: str, column: int) -> None:
    """What a macro may not contain (line 26133): control statements, and levels of brackets that are not complete."""
    if "$" in content:
        raise LineError(catalogue.MACRO_CONTENT, column, name=name, what="a $ statement")
    depth = 0
    for character in _NAME.sub("", re.sub(r"\\(.)", r"\1", content)):
        depth += (character == "[") - (character == "]")
        if depth < 0:
            break
    if depth:
        raise LineError(catalogue.MACRO_CONTENT, column, name=name, what="an incomplete level of brackets")


def g_expressions(text: str) -> Iterator[re.Match[str]]:
    """Where a macro has put an expression of plain numbers behind a G: group 1 is the expression."""
    for match in _G_EXPRESSION.finditer(text):
        if not any(quoted.start() < match.start() < quoted.end() for quoted in _NAME.finditer(text)):
            yield match


def _replaced(text: str, environment: Environment, own: dict[str, str], depth: int, column: int = 0) -> str:
    """The text with its macros replaced; `column` is the place of the outermost one, where errors are told."""
    out, end = "", 0
    for match in _NAME.finditer(text):
        name, before = match.group(1), text[: match.start()]
        place = column or match.start() + 1
        content = own.get(name)
        if content is None:
            content = environment.macro(name)
        out += text[end : match.start()]
        end = match.end()
        if _literal(text, match):
            out += match.group()
            continue
        if content is None:
            called = _CALL_BEFORE.search(before)
            if depth and not called:  # a macro may contain no string of its own (line 26141)
                raise LineError(catalogue.MACRO_UNDEFINED, place, name=name)
            out += f" {name}" if called else match.group()
            continue
        if depth >= MACRO_DEPTH:
            raise LineError(catalogue.MACRO_DEPTH, place, name=name, limit=MACRO_DEPTH)
        inner = _replaced(re.sub(r"\\(.)", r"\1", content), environment, own, depth + 1, place)
        called = _CALL_BEFORE.search(before)
        out += f" {inner}" if called else inner
        if len(out) > MAX_EXPANDED:
            raise LineError(catalogue.MACRO_DEPTH, place, name=name, limit=MACRO_DEPTH)
    return out + text[end:]


def _literal(text: str, quoted: re.Match[str]) -> bool:
    """Whether a quoted text stands for itself: a name that is asked for, the text of a message, a file name, a whole value
    of a message (which may be a macro, but that is seen when the format element it belongs to is known)."""
    before = text[: quoted.start()]
    if _NAMED_BEFORE.search(before):
        return True
    statement, depth, opened = "", 0, 0
    for match in _TEXTS.finditer(before):
        if match.group(2) or match.group(3):
            statement, depth = (match.group(2) or match.group(3)).upper(), 0
        elif match.group(4) and statement:
            depth += 1
            opened = match.end() if depth == 1 else opened
        elif match.group(5) and statement:
            depth -= 1
            if depth <= 0:
                statement = ""
    if not statement or depth < 1:
        return False
    if statement not in ("MSG", "ADD"):
        return True
    first = not before[opened:].strip()
    whole = before.rstrip().endswith(",") and re.match(r"[ \t]*[,\]]", text[quoted.end() :]) is not None
    return depth == 1 and (first or whole)
