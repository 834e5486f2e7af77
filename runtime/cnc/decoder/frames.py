"""Program levels: where each is, and what belongs to it alone."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto

from runtime.cnc.blocks import Source
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.decoder.user_variables import Scope
from runtime.cnc.dynamic_settings import DynamicSettings
from runtime.cnc.language.isg.index import Section, Unit
from runtime.cnc.language.text import ProgramText


class Level(Enum):
    """Why a program level was entered."""

    MAIN = auto()
    SUBPROGRAM = auto()
    CYCLE = auto()
    SEQUENCE = auto()
    START = auto()  # the configured program at program start
    FINAL = auto()  # the configured program before the program end


@dataclass(slots=True)
class Loop:
    """A running loop; of `$FOR` the end, the step and its counter stand in it."""

    end: float = 0.0
    step: float = 0.0


@dataclass(slots=True)
class Modal:
    """A modal cycle: what is called again after each block (with motion)."""

    unit: Unit
    section: Section
    name: str
    transfer: dict[int, float | str]
    after_motion: bool


@dataclass(slots=True)
class Sequence:
    """A block sequence: entries and rows of plain runs where it begins and ends, and how often it still runs."""

    begin: tuple[int, int]
    end: tuple[int, int] | None
    repeat: int
    call: tuple[ProgramText, int]  # file and offset of the call itself
    end_at_call: bool
    end_at_mark: bool

    def over(self, position: tuple[int, int]) -> bool:
        """Whether the next block lies outside of the sequence."""
        return position < self.begin or (self.end is not None and position > self.end)


@dataclass(slots=True)
class Frame:
    """One program level. `loops` holds the running loops by the entry of their first statement."""

    unit: Unit
    section: Section
    index: int
    level: Level = Level.SUBPROGRAM
    loops: dict[int, Loop] = field(default_factory=dict)
    local: Scope = field(default_factory=lambda: Scope("V.L."))
    cycle: Scope = field(default_factory=lambda: Scope("V.CYC."))
    transfer: dict[int, float | str] | None = None  # @P of a cycle
    given: frozenset[int] = frozenset()  # numbers of the @P that the call gave
    saved: ModalState | None = None  # to be restored at the end of a cycle
    dynamics: DynamicSettings | None = None  # what held when the cycle was called
    retain: bool = False  # #RETAIN CYCLE CHANGES
    modal: Modal | None = None  # a modal cycle that this level has called
    sequence: Sequence | None = None
    row: int = 0  # first row of a plain run that is to be executed, where a jump leads into a run
    optional: list[float] | None = None  # #OPTIONAL EXECUTION ON: machine position of the axes there
    target_row: int = -1  # row of that run at which a block search enters the program
    name: str = ""
    version: list[int] | None = None  # V.G.PROG_VERSION as this level has written it
    shown: Source | None = None  # the call that stands for all blocks of the level (P-CHAN-00211)
