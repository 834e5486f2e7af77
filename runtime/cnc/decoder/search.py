"""Block search in the decoder: finding the block at which the program is to be entered, before it is executed."""

from __future__ import annotations

import re
from pathlib import Path

from runtime.cnc.decoder.frames import Frame
from runtime.cnc.language.isg.index import Unit
from runtime.cnc.language.isg.scan import PlainRows
from runtime.cnc.search_target import BlockSearch, SearchKind

_BLOCK_NUMBER = re.compile(r"[\s/]*\d*\s*[Nn]\s*(\d+)")
_IN_THE_TEXT = (SearchKind.FILE_OFFSET, SearchKind.BLOCK_NUMBER, SearchKind.LINE)


class TargetFinder:
    """Tells at which entry, and at which row of a plain run, the execution comes to the target.

    A line without a block of its own (empty, comment) stands for the block that follows it.
    """

    def __init__(self, target: BlockSearch, main: Unit) -> None:
        self._target = target
        self._main = main
        self._left = max(target.passes, 1)
        self._before: tuple[Frame, int, int] | None = None  # frame, entry and line of what was executed last
        self.pending = target.kind in _IN_THE_TEXT
        self._line = target.value if target.kind is SearchKind.LINE else -1
        if target.kind is SearchKind.FILE_OFFSET and not target.program:
            self._line = line_at(main.text.path, target.value)

    def row(self, frame: Frame, unit: Unit, entry: int, rows: PlainRows | None) -> int:
        """The row of the entry at which the target is, -1 if it is not here; `rows` of a plain run from `frame.row` on.

        Called before an entry is executed, once for each time; every call with a hit counts as a pass.
        """
        before, self._before = self._before, (frame, entry, self._last_line(unit, entry))
        found = self._found(frame, unit, entry, rows, before) if self._concerns(unit) else -1
        if found < 0:
            return -1
        self._left -= 1
        if self._left > 0:
            return -1
        self.pending = False
        return found

    def _concerns(self, unit: Unit) -> bool:
        program = self._target.program
        if not program:
            return unit is self._main
        if unit.text.path.name != program and unit.name != program:
            return False
        if self._target.kind is SearchKind.FILE_OFFSET and self._line < 0:
            self._line = line_at(unit.text.path, self._target.value)
        return True

    def _last_line(self, unit: Unit, entry: int) -> int:
        return unit.line(entry) + max(unit.count(entry) - 1, 0)

    def _found(
        self, frame: Frame, unit: Unit, entry: int, rows: PlainRows | None, before: tuple[Frame, int, int] | None
    ) -> int:
        first, count = unit.line(entry), unit.count(entry)
        if self._target.kind is not SearchKind.BLOCK_NUMBER:
            if count and first + frame.row <= self._line < first + count:
                return self._line - first
            if self._line == first:
                return 0
            follows = before is not None and before[0] is frame and before[1] + 1 == entry and frame.row == 0
            return 0 if follows and before is not None and before[2] < self._line < first else -1
        if rows is not None:
            hits = [row for row in range(frame.row, count) if rows.number[row] == self._target.value]
            return hits[0] if hits else -1
        match = _BLOCK_NUMBER.match(unit.block_text(entry).text)
        return 0 if match and int(match.group(1)) == self._target.value else -1


def line_at(path: Path, offset: int) -> int:
    """The line (from 1) of a file in which the byte at `offset` lies."""
    line = 1
    with path.open("rb") as file:
        while offset > 0:
            part = file.read(min(offset, 1 << 20))
            if not part:
                break
            line += part.count(b"\n")
            offset -= len(part)
    return line
