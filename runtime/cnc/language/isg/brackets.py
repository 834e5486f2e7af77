"""Commands in brackets behind the name of a spindle or an axis: S[M3 REV500 M19 POS45], X[M20 H12=7] (lines 6783, 24444).

They are taken out of the block's text before its grammar sees it. `S[2 * 100]` is no such bracket: an expression begins in
none of the ways in which a command does.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING

from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.words import Expression, Word, WordKind
from runtime.diagnostics.catalogue import technology

if TYPE_CHECKING:
    from runtime.cnc.language.isg.parser import BlockParser

KEYS = (
    "REV", "POS", "CALLAX", "PUTAX", "GET_DYNAMIK_DATA", "GET_DYNAMIC_DATA", "DEFAULT_DYNAMIC_DATA", "DEFAULT_DYNAMIK_DATA",
    "FEED_LINK", "OVERRIDE", "SPEED_FACT", "ON", "OFF", "AUTO", "MAIN", "FACT", "CORR", "SRC",
)  # fmt: skip
_LETTER = r"[MHGmhg](?=[ \t]*(?:\d|[Pp]+\d|[Pp]\[|\[|V\.))"
_KEY = rf"(?:{'|'.join(sorted(KEYS, key=len, reverse=True))})(?![A-Za-z_])"
_COMMAND = re.compile(rf"(?<![A-Za-z_.@])(?:({_LETTER})|({_KEY}))", re.IGNORECASE)
_OPENING = re.compile(rf"(?<![\w.@#$])(S\w*|s\w*|[A-CQU-Z]\w*)[ \t]*\[[ \t]*(?:{_LETTER}|{_KEY})", re.IGNORECASE)
_QUOTED = re.compile(r"\"(?:\\.|[^\"\\])*\"|'[^']*'")
_VALUE_G = re.compile(r"(\d+)[ \t]*(=)?")


def take_brackets(text: str, parser: BlockParser) -> tuple[str, tuple[Word, ...]]:
    """Block text with the brackets blanked, and a word for each of them; raises LineError."""
    words: list[Word] = []
    at = 0
    while (match := _OPENING.search(text, at)) is not None:
        if any(quoted.start() < match.start() < quoted.end() for quoted in _QUOTED.finditer(text)):
            at = match.end()
            continue
        opening = text.index("[", match.end(1))
        closing = _closing(text, opening)
        words.append(_word(parser, match.group(1), match.start(1) + 1, text, opening + 1, closing))
        text = text[: match.start(1)] + " " * (closing + 1 - match.start(1)) + text[closing + 1 :]
        at = closing + 1
    return text, tuple(words)


def _closing(text: str, opening: int) -> int:
    depth = 0
    for place in range(opening, len(text)):
        depth += (text[place] == "[") - (text[place] == "]")
        if depth == 0:
            return place
    raise LineError(technology.BRACKET_OPEN, opening + 1)


def _word(parser: BlockParser, name: str, column: int, text: str, begin: int, end: int) -> Word:
    addresses = parser.addresses
    axis = addresses.axis(name)
    if axis < 0 and not addresses.has_spindle(name):
        known = ", ".join((*addresses.axes, *addresses.spindles))
        raise LineError(technology.BRACKET_NAME, column, name=name, known=known)
    inner = tuple(_commands(parser, text, begin, end))
    if axis >= 0:
        for word in inner:
            if word.kind not in (WordKind.M, WordKind.H):
                raise LineError(technology.AXIS_BRACKET, word.column, word=word.name or f"G{word.index}", name=name)
    return Word(WordKind.BRACKET, column, index=axis, name=name, inner=inner)


def _commands(parser: BlockParser, text: str, begin: int, end: int) -> Iterator[Word]:
    starts = [match for match in _COMMAND.finditer(text, begin, end) if _depth(text, begin, match.start()) == 0]
    if not starts or text[begin : starts[0].start()].strip():
        raise LineError(technology.BRACKET_COMMAND, begin + 1, text=text[begin:end].strip())
    for match, behind in zip(starts, [*(m.start() for m in starts[1:]), end], strict=True):
        yield _command(parser, text, match, behind)


def _depth(text: str, begin: int, place: int) -> int:
    return text.count("[", begin, place) - text.count("]", begin, place)


def _command(parser: BlockParser, text: str, match: re.Match[str], end: int) -> Word:
    column = match.start() + 1
    name = match.group().upper()
    at = match.end()
    if match.group(2):
        given = text[at:end].strip()
        if given.startswith("="):
            given, at = given[1:].strip(), text.index("=", at) + 1
        if name == "SRC":
            return Word(WordKind.KEY, column, name=name, target=given.upper())
        return Word(WordKind.KEY, column, _expression(parser, text, at, end) if given else None, name=name)
    if name == "G":
        number = _VALUE_G.match(text, at + len(text[at:end]) - len(text[at:end].lstrip()), end)
        if number is None:
            raise LineError(technology.BRACKET_COMMAND, column, text=text[match.start() : end].strip())
        assigned = number.group(2) is not None
        if not assigned and text[number.end() : end].strip():
            raise LineError(technology.BRACKET_COMMAND, column, text=text[match.start() : end].strip())
        value = _expression(parser, text, number.end(), end) if assigned else None
        return Word(WordKind.G, column, value, int(number.group(1)))
    kind = WordKind.M if name == "M" else WordKind.H
    equals = _equals(text, at, end)
    extra = _expression(parser, text, equals + 1, end) if equals >= 0 else None
    return Word(kind, column, _expression(parser, text, at, equals if equals >= 0 else end), extra=extra, name=name)


def _equals(text: str, begin: int, end: int) -> int:
    """The place of the = outside of brackets, -1 without."""
    for place in range(begin, end):
        if text[place] == "=" and _depth(text, begin, place) == 0:
            return place
    return -1


def _expression(parser: BlockParser, text: str, begin: int, end: int) -> Expression:
    source = text[begin:end]
    begin += len(source) - len(source.lstrip())
    return parser.expression(text[begin:end].rstrip(), begin + 1)
