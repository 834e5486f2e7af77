"""Blocks in branches that are passed over: only block numbers and control statements are looked at (manual 8241–8326)."""

from __future__ import annotations

import re

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.language.isg.comments import blank_comments

_NUMBER = re.compile(r"[\s/]*\d*\s*[Nn][ \t]*")
_PLAIN = re.compile(r"\d+|[Pp]+\d+")
_CONTROL = re.compile(r"\$")


def check_passed(x: Execution, text: str) -> None:
    """Raises LineError for a block number that is no expression and for a control statement that is not understood."""
    if "$" not in text and "N" not in text and "n" not in text:
        return
    blanked = blank_comments(text)
    number = _NUMBER.match(blanked)
    if number is not None and not _PLAIN.match(blanked, number.end()):
        end = _closed(blanked, number.end())
        x.parser.parse(blanked[:end], x.environment)  # "NXY" has no value
    control = next((m for m in _CONTROL.finditer(blanked) if blanked.count('"', 0, m.start()) % 2 == 0), None)
    if control is None:
        return
    if "GOTO" in blanked[control.start() : control.start() + 5].upper():  # other words may stand in front of it
        blanked = " " * control.start() + blanked[control.start() :]
    x.parser.parse(blanked, x.environment)


def _closed(text: str, begin: int) -> int:
    """Where the bracket that begins at `begin` ends; the end of the text if there is none or it stays open."""
    depth = 0
    for i in range(begin, len(text)):
        depth += (text[i] == "[") - (text[i] == "]")
        if depth == 0:
            return i + 1 if text[i] == "]" else len(text)
    return len(text)
