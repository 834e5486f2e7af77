"""The report file of #MSG SAVE: always extended, never emptied, with backups if asked for (programming manual 13507–13553,
16357–16425).

Lines are counted as writes. When one more would pass the limit, `test.log` becomes `test1.bak` and a new file begins; the number
of the last backup and the lines are kept until the control is started again, or another file is named.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from runtime.cnc.decoder.memory import ChannelMemory

DEFAULT_NAME = "message.txt"


@dataclass(frozen=True, slots=True)
class Backups:
    """How many writes a report file takes before it becomes a backup, and how many backups there are; 0: none are made."""

    lines: int = 0
    count: int = 0

    @property
    def wanted(self) -> bool:
        return self.lines > 0 and self.count > 0


def append(path: Path, text: str, backups: Backups, memory: ChannelMemory) -> None:
    """Write a text behind what is in the file. Raises OSError."""
    kept = memory.report
    if kept.path != path:
        kept.path, kept.lines, kept.backup = path, 0, 0
    if backups.wanted and kept.lines >= backups.lines:
        kept.backup = kept.backup % backups.count + 1
        if path.exists():
            path.replace(path.with_name(f"{path.stem}{kept.backup}.bak"))
        kept.lines = 0
    flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_NONBLOCK
    with os.fdopen(os.open(path, flags, 0o644), "wb") as file:
        file.write(text.encode("utf-8", "replace"))
    kept.lines += 1
