"""Control flow: GOTO, IF, WHILE … DO … END (programmer's manual lines 7435–7608).

A program is read line by line, nothing of it is kept. A jump looks for its block behind the block in work first, then from the
start of the program on to there; a loop that is not entered looks for its END. What was found is kept by where it was asked for,
so a jump that is executed again reads nothing.

    frame.loops   the running loops of a level, the innermost last
    _Found        a block, and the loops around it that its search has seen begin
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator
from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.cnc.decoder.nct.frames import Frame
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct.comments import without_comments
from runtime.cnc.language.nct.compiler import CompiledBlock
from runtime.cnc.language.nct.functions import number, whole
from runtime.cnc.language.nct.program_file import BlockText, number_of
from runtime.cnc.language.nct.words import Control
from runtime.diagnostics.catalogue import nct as words
from runtime.diagnostics.catalogue import nct_macros as catalogue

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.execution import NctExecution

LOOPS = (1, 2, 3)
KEPT = 20_000  # results of searches
LOOKED_AT = 4096  # blocks of a search between two questions whether to go on
_LOOP = re.compile(r"(?<![A-Z])(DO|END)[ \t]*(\d+)")


class SearchInterrupted(Exception):  # noqa: N818 - it is none: nobody wants the program any more
    """A search through a long program was given up."""


@dataclass(frozen=True, slots=True)
class Loop:
    """A running loop: the number behind DO, and its first block."""

    number: int
    begin: BlockText


@dataclass(frozen=True, slots=True)
class _Found:
    """Where a search has ended: `around` are the loops that begin in what was read and contain the block; `open` how many of
    the loops that contain the begin of the search contain it too."""

    block: BlockText
    around: tuple[Loop, ...]
    open: int


@dataclass(slots=True)
class _Nesting:
    """The loops around a place that moves down a program; `open` of those at the begin of the search are still around it."""

    open: int
    around: list[Loop]

    def pass_over(self, block: BlockText) -> None:
        for keyword, found in loop_words(block.text):
            if keyword == "DO":
                self.around.append(Loop(found, block))
            elif self.around:
                self.around.pop()
            else:
                self.open = max(self.open - 1, 0)


def loop_words(text: str) -> list[tuple[str, int]]:
    """DO and END of a block with their numbers, comments left out. A block whose comments are faulty has none: what is wrong with
    it is told when it is executed."""
    upper = text.upper()
    if "DO" not in upper and "END" not in upper:
        return []
    try:
        blanked, _ = without_comments(text)
    except LineError:
        return []
    return [(found[1], int(found[2])) for found in _LOOP.finditer(blanked)]


class Flow:
    """Of one execution. All calls raise LineError and CalculationError at the block in work; SearchInterrupted when `interrupted`
    says so."""

    def __init__(self, execution: NctExecution) -> None:
        self._x = execution
        self.interrupted: Callable[[], bool] = lambda: False
        self._found: dict[tuple[int, int, str, int], _Found] = {}

    def execute(self, block: CompiledBlock) -> bool:
        """The control statement of a block; True: the rest of the block (behind THEN) is executed."""
        statement = block.control
        assert statement is not None
        frame = self._x.level
        if statement.control is Control.IF:
            assert block.condition is not None
            if not block.condition():
                return False
            if block.target is None:
                return True
        column = statement.column
        target = whole(number(block.target())) if block.target is not None else 0
        if statement.control in (Control.GOTO, Control.IF):
            self.go_to(frame, block.source, target, column)
            return False
        if target not in LOOPS or statement.target is None or statement.target.constant is None:
            raise LineError(catalogue.LOOP_NUMBER, column, number=target)
        if statement.control is Control.END:
            self._end(frame, target, column)
        else:
            self._begin(frame, block, target, column)
        return False

    # ------------------------------------------------------------------ loops

    def _begin(self, frame: Frame, block: CompiledBlock, target: int, column: int) -> None:
        """DO, WHILE DO: the first pass, or one more."""
        loops: list[Loop] = frame.loops
        if not (loops and loops[-1].begin.offset == block.source.offset):
            for loop in loops:
                if loop.number == target:
                    raise LineError(catalogue.LOOP_TWICE, column, number=target, line=loop.begin.line)
            loops.append(Loop(target, block.source))
        if block.condition is None or block.condition():
            return
        loops.pop()
        frame.go_to(self._behind(frame, block.source, target, column))

    def _end(self, frame: Frame, target: int, column: int) -> None:
        loops: list[Loop] = frame.loops
        if not any(loop.number == target for loop in loops):
            raise LineError(catalogue.LOOP_MISSING, column, number=target)
        innermost = loops[-1]
        if innermost.number != target:
            values = {"number": target, "inner": innermost.number, "line": innermost.begin.line}
            raise LineError(catalogue.LOOP_OVERLAPS, column, **values)
        frame.go_to(innermost.begin)

    def _behind(self, frame: Frame, begin: BlockText, target: int, column: int) -> BlockText:
        """The block behind the END of a loop that is left at its head."""
        nesting = _Nesting(1, [])

        def closes(block: BlockText) -> bool:
            nesting.pass_over(block)
            return nesting.open == 0

        found = self._kept(
            (id(frame.unit), begin.offset, "END", target),
            lambda: self._first(frame.unit.blocks(begin.following, begin.line + 1), closes),
        )
        if found is None or ("END", target) not in loop_words(found.block.text):
            raise LineError(catalogue.LOOP_OPEN, column, number=target)
        end = found.block
        return BlockText("", end.line + 1, end.following, end.following)

    # ------------------------------------------------------------------ jumps

    def go_to(self, frame: Frame, begin: BlockText, target: int, column: int) -> None:
        """Go on at a block number of the level's program; loops around the block in work that do not contain it end."""
        key = (id(frame.unit), begin.offset, "N", target)
        found = self._kept(key, lambda: self._numbered(frame, begin, target))
        if found is None:
            raise LineError(words.NO_BLOCK, column, number=target)
        running: list[Loop] = frame.loops
        if found.open < 0:  # looked for from the start: the loops around it are all known
            kept = [loop for loop in running if loop in found.around]
            inner = [loop for loop in found.around if loop not in running]
        else:
            kept, inner = running[: found.open], list(found.around)
        if inner:
            raise LineError(catalogue.JUMP_INTO_LOOP, column, number=target, line=inner[0].begin.line)
        frame.loops = kept
        frame.go_to(found.block)

    def _numbered(self, frame: Frame, begin: BlockText, target: int) -> _Found | None:
        unit = frame.unit
        nesting = _Nesting(len(frame.loops), [])

        def wanted(block: BlockText) -> bool:
            if number_of(block.text) == target:
                return True
            nesting.pass_over(block)
            return False

        block = self._first_block(unit.blocks(begin.following, begin.line + 1), wanted)
        if block is not None:
            return _Found(block, tuple(nesting.around), nesting.open)
        nesting = _Nesting(0, [])
        section = frame.section
        block = self._first_block(unit.blocks(section.begin, section.line), wanted, last=begin.offset)
        return None if block is None else _Found(block, tuple(nesting.around), -1)

    # ------------------------------------------------------------------ searches

    def _kept(self, key: tuple[int, int, str, int], search: Callable[[], _Found | None]) -> _Found | None:
        found = self._found.get(key)
        if found is None:
            found = search()
            if found is not None:
                if len(self._found) >= KEPT:
                    self._found.clear()
                self._found[key] = found
        return found

    def _first(self, blocks: Iterator[BlockText], wanted: Callable[[BlockText], bool]) -> _Found | None:
        block = self._first_block(blocks, wanted)
        return None if block is None else _Found(block, (), 0)

    def _first_block(
        self, blocks: Iterator[BlockText], wanted: Callable[[BlockText], bool], last: int | None = None
    ) -> BlockText | None:
        for count, block in enumerate(blocks, 1):
            if count % LOOKED_AT == 0 and self.interrupted():
                raise SearchInterrupted
            if wanted(block):
                return block
            if last is not None and block.offset >= last:
                return None
        return None
