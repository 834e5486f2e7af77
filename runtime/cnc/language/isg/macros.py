"""Macros: quoted names that stand for a piece of NC text (programming manual lines 1388–1431, 25995–26160).

A definition `"NAME" = "content"` is taken out of the block; the name of a defined macro is replaced by its content, again
and again. A quoted text that is no macro stays where it is: a string, or an error of the grammar.
"""

from __future__ import annotations

import re

from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.environment import Environment
from runtime.diagnostics.catalogue import language as catalogue

MACRO_DEPTH = 20  # a macro in a macro; the manual gives no number
MAX_EXPANDED = 16_000  # characters of a block after replacement

_QUOTED = r'"((?:\\.|[^"\\])*)"'
_DEFINITION = re.compile(rf'(?<![\w\]"+=,\[])[ \t]*{_QUOTED}[ \t]*=(?!=)[ \t]*{_QUOTED}')
_NAME = re.compile(_QUOTED)
_CALL_BEFORE = re.compile(r"(?:^|[^A-Za-z0-9_.])([Ll]{1,2})[ \t]*$")
_LITERAL_BEFORE = re.compile(
    r"#(?:MSG|ADD|FILE|ERROR)\b[^\"]*\[[^\]]*$|(?:EXIST|MACRO_LENGTH|MACRO_CONTENT)\[[ \t]*$|SEQUENCE[ \t]*\[[^\]]*$",
    re.IGNORECASE,
)


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
    """What a macro may not contain (line 26133)."""
    if "$" in content:
        raise LineError(catalogue.MACRO_CONTENT, column, name=name, what="a $ statement")


def _replaced(text: str, environment: Environment, own: dict[str, str], depth: int) -> str:
    out, end = "", 0
    for match in _NAME.finditer(text):
        name, before = match.group(1), text[: match.start()]
        content = own.get(name)
        if content is None:
            content = environment.macro(name)
        out += text[end : match.start()]
        end = match.end()
        literal = _LITERAL_BEFORE.search(before)
        if content is None or (literal and not _is_argument(before)):
            called = _CALL_BEFORE.search(before) if content is None else None
            out += f" {name}" if called else match.group()
            continue
        if depth >= MACRO_DEPTH:
            raise LineError(catalogue.MACRO_DEPTH, match.start() + 1, name=name, limit=MACRO_DEPTH)
        inner = _replaced(re.sub(r"\\(.)", r"\1", content), environment, own, depth + 1)
        called = _CALL_BEFORE.search(before)
        out += f" {inner}" if called else inner
        if len(out) > MAX_EXPANDED:
            raise LineError(catalogue.MACRO_DEPTH, match.start() + 1, name=name, limit=MACRO_DEPTH)
    return out + text[end:]


def _is_argument(before: str) -> bool:
    """Whether a quoted name in a message stands behind the text: an argument, which may be a macro."""
    opened = before.rfind("[")
    return re.search(r"#(?:MSG|ADD)\b", before[:opened], re.I) is not None and '"' in before[opened:]
