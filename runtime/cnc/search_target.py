"""Where a program is entered when it does not start at its beginning (block search), and how the axes get there."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class SearchKind(IntEnum):
    """What the place is told by, with the numbers of the HLI."""

    NONE = 0
    FILE_OFFSET = 1  # position in the file of the program
    BLOCK_COUNTER = 3  # blocks with motion that have ended, as the HLI shows them
    BLOCK_NUMBER = 4  # N word
    LINE = 5  # line of the file (our number)
    INTERRUPTION = 6  # way along the path since the start of the program (our number)


@dataclass(frozen=True, slots=True)
class BlockSearch:
    """The place, and the return to it.

    `value`: offset in bytes, counter, block number or line. `passes`: how often the block is come to, for blocks in loops and
    subprograms; `program`: the file of the subprogram that it stands in, "" for the main program. `covered`: share of the
    first motion from there on that is left out too, 0 to 1. For INTERRUPTION `way` in mm, and `line` that the path has to
    be on there, 0 if it is not to be checked.

    `automatic`: the axes go back to the contour without being asked to; `without_stop`: the program goes on from there
    without being told to. `feed` of the return in mm/min, 0: that of the motion. `ranks` (n_axes,): the turn of each axis on
    the way back, from 1; 0 everywhere: the tool axis last, or first where it moves away from the workpiece.
    """

    kind: SearchKind
    value: int = 0
    passes: int = 1
    program: str = ""
    covered: float = 0.0
    way: float = 0.0
    line: int = 0
    automatic: bool = False
    without_stop: bool = False
    feed: float = 0.0
    ranks: tuple[int, ...] = ()
