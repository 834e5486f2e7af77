"""Block search in an NCT program: finding the block at which it is to be entered, before it is executed."""

from __future__ import annotations

from runtime.cnc.decoder.nct.frames import Frame
from runtime.cnc.language.nct.program_file import BlockText, Unit, number_of
from runtime.cnc.search_target import BlockSearch, SearchKind

_IN_THE_TEXT = (SearchKind.FILE_OFFSET, SearchKind.BLOCK_NUMBER, SearchKind.LINE)


class TargetFinder:
    """Tells at which block the execution comes to the target. Every block is a line, so a line is a block."""

    def __init__(self, target: BlockSearch, main: Unit) -> None:
        self._target = target
        self._main = main
        self._left = max(target.passes, 1)
        self.pending = target.kind in _IN_THE_TEXT

    def reached(self, frame: Frame, block: BlockText) -> bool:
        """Called before a block is executed, once for each time; every call with a hit counts as a pass."""
        if not self._concerns(frame.unit) or not self._at(block):
            return False
        self._left -= 1
        if self._left > 0:
            return False
        self.pending = False
        return True

    def _concerns(self, unit: Unit) -> bool:
        program = self._target.program
        return unit is self._main if not program else program in (unit.text.path.name, unit.name)

    def _at(self, block: BlockText) -> bool:
        kind, value = self._target.kind, self._target.value
        if kind is SearchKind.LINE:
            return block.line == value
        if kind is SearchKind.FILE_OFFSET:
            return block.offset <= value < block.following
        return number_of(block.text) == value
