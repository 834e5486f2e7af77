"""A short cut for blocks of letters and plain numbers that the scan kernel does not take (arcs, M and S functions ...).

CAM programs hold them by the hundred thousand, and the grammar takes half a millisecond for one. What is read here is
exactly what the grammar gives for the same text; whatever looks unusual is left to it.
"""

from __future__ import annotations

import re

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg import expressions
from runtime.cnc.language.isg.words import Expression, ParsedBlock, Word, WordKind

# Nothing in it can match in two ways, so that a text that does not match is given up in linear time, however long its
# numbers are. Possessive quantifiers would say the same, but over groups they match wrongly before Python 3.11.5.
_WORD = r"([A-CF-KMQ-Zf-kmr-t])[ \t]*([+-]?(?:\d+(?:\.\d*)?|\.\d+))[ \t]*"
_BLOCK = re.compile(rf"[ \t]*(?:[Nn][ \t]*(\d+)[ \t]*)?((?:{_WORD})+)")
_WORDS = re.compile(_WORD)
_KINDS = {
    "F": WordKind.FEED,
    "R": WordKind.RADIUS,
    "S": WordKind.SPEED,
    "T": WordKind.TOOL,
    "M": WordKind.M,
    "H": WordKind.H,
}
_AXES = "ABCQUVWXYZ"


def numeric_block(text: str, addresses: Addresses) -> ParsedBlock | None:
    """The block of a text without comments, None if it is one for the grammar. LineError as the grammar would raise."""
    match = _BLOCK.fullmatch(text)
    if match is None:
        return None
    words: list[Word] = []
    for found in _WORDS.finditer(text, match.start(2)):
        letter, digits = found.group(1, 2)
        column = found.start() + 1
        upper = letter.upper()
        if letter in _AXES:
            index = addresses.axis(letter)
            if index < 0:
                return None
            signs = digits[0] if digits[0] in "+-" else ""
            value = _value(digits, found.start(2))
            words.append(Word(WordKind.AXIS, column, value, index, name=letter, signs=signs))
        elif upper in _KINDS:
            if upper == "S" and not addresses.spindles:
                return None
            name = letter if upper == "S" else ""  # of a spindle
            words.append(Word(_KINDS[upper], column, _value(digits, found.start(2)), name=name))
        elif upper in "IJK":
            words.append(
                Word(WordKind.INTERPOLATION, column, _value(digits, found.start(2)), "IJK".index(upper), name=upper)
            )
        elif upper == "G" and digits.isdigit() and int(digits) != 4:
            words.append(Word(WordKind.G, column, None, int(digits)))
        else:
            return None
    number = None
    if match.group(1) is not None:
        number = _value(match.group(1), match.start(1))
    return ParsedBlock(tuple(words), number=number)


def _value(digits: str, start: int) -> Expression:
    if digits[0] == "-":
        return expressions.signed("-", expressions.literal(digits[1:], start + 2), start + 1)
    if digits[0] == "+":
        return expressions.literal(digits[1:], start + 2)
    return expressions.literal(digits, start + 1)
