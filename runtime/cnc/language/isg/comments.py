"""Comments and the character set of a block (programming manual lines 950–1085 and 1231–1269)."""

from __future__ import annotations

from runtime.cnc.language.errors import LineError as LineError
from runtime.diagnostics.catalogue import language as catalogue


def blank_comments(text: str) -> str:
    """The line with its comments replaced by blanks, so that columns stay true.

    "(" opens a comment that ends at its ")" or with the line; inner comments need their ")". ";" runs to the line
    end. A bracket inside a quoted string opens no comment. Separators that nobody sees (TAB, form feed, ETX ...)
    become blanks. Raises LineError.
    """
    if "(" not in text and ";" not in text and ")" not in text and text.isprintable() and text.isascii():
        return text
    out: list[str] = []
    opened: list[int] = []
    quoted = False
    for column, character in enumerate(text, 1):
        if opened:
            if character == "(":
                opened.append(column)
            elif character == ")":
                opened.pop()
            out.append(" ")
        elif quoted:
            quoted = character != '"'
            out.append(character)
        elif character == "(":
            opened.append(column)
            out.append(" ")
        elif character == ";":
            break
        elif character == ")":
            raise LineError(catalogue.COMMENT_CLOSE, column)
        elif character in "\t\v\f\r\x03\x1a\0":
            out.append(" ")
        elif not " " <= character <= "~":
            raise LineError(catalogue.CHARACTER_INVALID, column, character=character)
        else:
            quoted = character == '"' and '"' in text[column:]
            out.append(character)
    if len(opened) > 1:
        raise LineError(catalogue.COMMENT_OPEN, opened[-1])
    return "".join(out)
