"""Keys of channel parameters: `prog_start.g_gruppe[4].nr` ↔ ("prog_start", "g_gruppe", 4, "nr")."""

from __future__ import annotations

import re

Key = tuple[str | int, ...]

_KEY = re.compile(
    r"[A-Za-z0-9_]*[A-Za-z_][A-Za-z0-9_]*(?:\[[0-9]{1,9}\])*(?:\.[A-Za-z0-9_]*[A-Za-z_][A-Za-z0-9_]*(?:\[[0-9]{1,9}\])*)*\Z"
)
_STEP = re.compile(r"\[(\d+)\]|([A-Za-z0-9_]+)")


def parse_key(text: str) -> Key | None:
    """The steps of a written key; None if it has not the form of one."""
    if not _KEY.match(text):
        return None
    return tuple(int(index) if index else name for index, name in _STEP.findall(text))


def key_text(key: Key) -> str:
    """A key as it is written in a list file."""
    text = ""
    for step in key:
        text += f"[{step}]" if isinstance(step, int) else f".{step}" if text else step
    return text


def pattern_of(key: Key) -> str:
    """A key without the numbers: `spindel[].bezeichnung`."""
    return key_text(key) if all(isinstance(step, str) for step in key) else re.sub(r"\[\d+\]", "[]", key_text(key))
