"""What a block consists of after parsing: its words with their expressions, or a control statement."""

from __future__ import annotations

from dataclasses import dataclass
from enum import Enum, IntEnum, auto


class WordKind(IntEnum):
    """What a word does; the meaning of `Word.index` stands behind it."""

    AXIS = auto()  # channel axis index
    INTERPOLATION = auto()  # 0 I, 1 J, 2 K
    RADIUS = auto()
    FEED = auto()
    SPEED = auto()
    TOOL = auto()
    M = auto()
    H = auto()
    G = auto()  # G number
    DWELL = auto()  # 0 seconds, 1 revolutions of the spindle
    ASSIGNMENT = auto()
    CALL_LOCAL = auto()
    CALL_GLOBAL = auto()


@dataclass(frozen=True, slots=True)
class Expression:
    """An expression as Python source over `p` (the P parameters) and the names of `compiler.NAMES`.

    `constant` is its value if it is a plain number. `binding` tells how tight the source binds: 1 a bare sum, 2 a bare
    product, 3 anything that may stand everywhere. `depth` counts nested brackets.
    """

    source: str
    constant: float | None = None
    binding: int = 3
    depth: int = 0


@dataclass(frozen=True, slots=True)
class Word:
    """One word; `column` counts from 1. For ASSIGNMENT `target` is the source of the parameter number."""

    kind: WordKind
    column: int
    value: Expression | None = None
    index: int = 0
    extra: Expression | None = None  # additional value of an M or H function
    target: str = ""
    name: str = ""  # of a call


class Control(Enum):
    """Control statements."""

    IF = "$IF"
    ELSEIF = "$ELSEIF"
    ELSE = "$ELSE"
    ENDIF = "$ENDIF"
    FOR = "$FOR"
    ENDFOR = "$ENDFOR"
    WHILE = "$WHILE"
    ENDWHILE = "$ENDWHILE"


@dataclass(frozen=True, slots=True)
class ControlStatement:
    """A control statement with its expressions: the condition, or start, end and step of `$FOR`."""

    control: Control
    column: int
    expressions: tuple[Expression, ...] = ()
    target: str = ""  # number of the counter of $FOR, as source


@dataclass(frozen=True, slots=True)
class ParsedBlock:
    """One block. `skip_level` is 0 if it is never skipped."""

    words: tuple[Word, ...] = ()
    control: ControlStatement | None = None
    number: Expression | None = None
    skip_level: int = 0
