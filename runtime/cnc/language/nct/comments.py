"""Comments and characters of a block (programmer's manual lines 299–330)."""

from __future__ import annotations

from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue

_BLANKS = "\t\v\f\r\x03\x1a\0"


def without_comments(text: str) -> tuple[str, str]:
    """The block in capitals with its comments replaced by blanks, so that columns stay true, and the text of its first comment.

    A comment goes from "(" to ")"; the manual knows no nested ones, an inner "(" is a character. Raises LineError.
    """
    if "(" not in text and ")" not in text and text.isascii() and text.isprintable():
        return text.upper(), ""
    out: list[str] = []
    comment, opened = "", 0
    inner: list[str] = []
    for column, character in enumerate(text, 1):
        if opened:
            if character == ")":
                comment = comment or "".join(inner)
                opened = 0
            else:
                inner.append(character)
            out.append(" ")
        elif character == "(":
            opened = column
            inner = []
            out.append(" ")
        elif character == ")":
            raise LineError(catalogue.COMMENT_CLOSE, column)
        elif character in _BLANKS:
            out.append(" ")
        elif not " " <= character <= "~":
            raise LineError(catalogue.CHARACTER, column, character=character)
        else:
            out.append(character.upper())
    if opened:
        raise LineError(catalogue.COMMENT_OPEN, opened)
    return "".join(out), comment
