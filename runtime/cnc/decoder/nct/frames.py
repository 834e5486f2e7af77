"""Program levels of the NCT dialect: where each is in its program, and what belongs to it alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Any

from runtime.cnc.blocks import Source
from runtime.cnc.decoder.nct.variables import Locals, no_locals
from runtime.cnc.language.nct.program_file import BlockText, Section, Unit


class Level(Enum):
    """Why a program level was entered."""

    MAIN = auto()
    SUBPROGRAM = auto()  # M98 and codes that do the same: the local variables stay those of the caller
    MACRO = auto()  # G65, G66 and codes that do the same: local variables of its own


@dataclass(slots=True)
class Frame:
    """One program level. `offset` and `line` are those of its next block, `work` is the block in work.

    `passes` is how often its program runs in all, `done` how often it has come to its end. `loops` are the running loops, the
    innermost last, in a form of the control flow's own. `locals`: its local variables, those of the caller in a subprogram; in
    a macro they begin as `arguments` in each pass. `modal_calls`: the macros that its blocks call (see `macros`).
    `called_by`: the code that has called it, if it is one that the machine has chosen for that.
    """

    unit: Unit
    section: Section
    offset: int
    line: int
    level: Level = Level.MAIN
    passes: int = 1
    done: int = 0
    work: BlockText | None = None
    loops: list[Any] = field(default_factory=list)
    locals: Locals = field(default_factory=no_locals)
    arguments: Locals | None = None
    modal_calls: list[Any] = field(default_factory=list)
    called_by: str = ""
    shown: Source | None = None  # the call that stands for all blocks of the level

    @property
    def number(self) -> int:
        """The number of its program, 0 without."""
        return self.section.number or 0

    def go_to(self, block: BlockText) -> None:
        """The next block is this one."""
        self.offset, self.line = block.offset, block.line

    def begin(self) -> None:
        """The next block is the first one of the program."""
        self.offset, self.line = self.section.begin, self.section.line
        self.loops.clear()
