"""M17 and M29 with brackets: how many levels are left, and where the program goes on (programming manual lines 6646–6721).

M17 [MAIN | JUMPS=<levels>  N<number> | [<LABEL>]]      everything may be missing
"""

from __future__ import annotations

import re
from dataclasses import replace
from typing import TYPE_CHECKING

from runtime.cnc.language.isg import expressions
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.words import Expression, Word
from runtime.diagnostics.catalogue import language as catalogue

if TYPE_CHECKING:
    from runtime.cnc.language.isg.parser import BlockParser

_LEVELS = re.compile(r"[ \t]*(?:(MAIN)(?![A-Za-z0-9_])|JUMPS(?![A-Za-z_])[ \t]*=?)?", re.IGNORECASE)
_LABEL = re.compile(r"\[[ \t]*([A-Za-z_][A-Za-z0-9_]*)[ \t]*\][ \t]*$")
_NUMBER = re.compile(r"[Nn](?=[ \t]*[\d\[PpV])")


def parse_return(word: Word, blocks: BlockParser) -> Word:
    """The RETURN word with its parts; `word.name` is its text. Raises LineError."""
    text = word.name
    begin, end = text.index("[") + 1, len(text) - 1
    levels = _LEVELS.match(text, begin, end)
    assert levels is not None  # it may be empty
    main = levels.group(1) is not None
    target = levels.end()
    jumps: Expression | None = None
    if levels.group().strip() and not main:
        target = _target(text, levels.end(), end)
        jumps = _number(text, levels.end(), target, "JUMPS", word, blocks)
    rest = text[target:end]
    label = _LABEL.match(rest.lstrip())
    number = _NUMBER.match(rest.lstrip())
    at = target + len(rest) - len(rest.lstrip())
    values = (jumps, _number(text, at + 1, end, "N", word, blocks) if number else None)
    if rest.strip() and not (label or number):
        raise LineError(catalogue.RETURN_TARGET, word.column + at, text=rest.strip())
    return replace(word, target="MAIN" if main else "", values=values, name=label.group(1).upper() if label else "")


def _target(text: str, begin: int, end: int) -> int:
    """Where the target begins behind JUMPS=..; `end` if there is none."""
    depth = 0
    for i in range(begin, end):
        apart = not (text[i - 1].isalnum() or text[i - 1] in "_.")
        if depth == 0 and apart and i > begin and (_NUMBER.match(text, i) or _LABEL.match(text[i:end])):
            return i
        depth += (text[i] == "[") - (text[i] == "]")
    return end


def _number(text: str, begin: int, end: int, what: str, word: Word, blocks: BlockParser) -> Expression:
    column = word.column + begin
    if not text[begin:end].strip():
        raise LineError(catalogue.VALUE_MISSING, column, address=what)
    return expressions.number(blocks.expression(text[begin:end], column), what, column)
