"""The report file of #MSG SAVE: always extended, never emptied, with backups if asked for (programming manual 13507–13553,
16357–16425).

Lines are counted as writes. When one more would pass the limit, `test.log` becomes `test1.bak` and a new file begins; the number
of the last backup and the lines are kept until the control is started again.
"""

from __future__ import annotations

import os
from dataclasses import dataclass
from pathlib import Path

from runtime.cnc.decoder.memory import ChannelMemory

DEFAULT_NAME = "message.txt"


@dataclass(slots=True)
class ReportFile:
    """What #FILE NAME sets: name of the file, lines per file and number of backups (0: no backups)."""

    name: str = DEFAULT_NAME
    lines_most: int = 0
    backups_most: int = 0

    def append(self, path: Path, text: str, memory: ChannelMemory) -> None:
        """Write behind what is there. Raises OSError."""
        if self.lines_most > 0 and self.backups_most > 0 and memory.report_lines >= self.lines_most:
            memory.report_backups = memory.report_backups % self.backups_most + 1
            if path.exists():
                path.replace(path.with_name(f"{path.stem}{memory.report_backups}.bak"))
            memory.report_lines = 0
        flags = os.O_WRONLY | os.O_CREAT | os.O_APPEND | os.O_NOFOLLOW | os.O_NONBLOCK
        descriptor = os.open(path, flags, 0o644)
        with os.fdopen(descriptor, "wb") as file:
            file.write(text.encode("utf-8", "replace"))
        memory.report_lines += 1
