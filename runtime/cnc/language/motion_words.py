"""What the motion of a block is made from, in whichever dialect it is written: kinds of words, and where they stand."""

from __future__ import annotations

from enum import IntEnum, auto
from typing import Protocol


class WordKind(IntEnum):
    """What a word does; the meaning of `Word.index` stands behind it."""

    AXIS = auto()  # channel axis index
    INTERPOLATION = auto()  # 0 I, 1 J, 2 K
    RADIUS = auto()
    FEED = auto()
    END_FEED = auto()  # E
    SPEED = auto()
    TOOL = auto()
    TOOL_DATA = auto()  # D
    M = auto()
    H = auto()
    G = auto()  # G number
    DWELL = auto()  # 0 seconds, 1 revolutions of the spindle
    ASSIGNMENT = auto()
    DECLARATION = auto()
    ADDITION = auto()  # one of ADDITIONS; `name` without #
    CALL_LOCAL = auto()
    CALL_GLOBAL = auto()
    RETURN = auto()  # M17 or M29 with brackets
    GOTO = auto()
    SPINDLE_POSITION = auto()  # S.POS
    SPINDLE_OFFSET = auto()  # S.OFFSET
    BRACKET = (
        auto()
    )  # S[..] or X[..]: channel axis index, -1 for a spindle; with a `job` that of another axis; `name` as written
    KEY = auto()  # in such a bracket: REV, POS …; `target` is a literal value


class MotionBlock(Protocol):
    """A block with a motion as the decoder's geometry sees it; what its words say stands in the `Execution`.

    `axes`: channel axis index and a slot of the dialect's own. `radius`: -1 if no radius is programmed. `signs`: channel axis
    index, and the signs directly behind its name that choose a direction.
    """

    @property
    def axes(self) -> tuple[tuple[int, int], ...]: ...

    @property
    def radius(self) -> int: ...

    @property
    def signs(self) -> tuple[tuple[int, str], ...]: ...

    def column(self, kind: WordKind, index: int | None = None) -> int:
        """Column of the first word of this kind, 1 if there is none."""
