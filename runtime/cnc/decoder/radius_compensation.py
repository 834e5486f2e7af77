"""What the decoder knows of radius compensation: it tells the stage behind it what holds, and keeps apart what forbids itself.

G functions and #TRC set the modal state only. Before the next motion or function `follow` looks whether that or mirroring makes
another compensation than the stage was told, and tells it. The radius of the tool is told by `Tooling`.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from runtime.cnc.blocks import Approach, Arc, Block, Line, RadiusCompensation
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import radius as catalogue

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

NO_LENGTH = 1e-9  # mm: below it a block moves nothing in the plane

# Statements that empty the preparation, or change axes or coordinate systems (manual lines 20887–20947): their beginnings.
FORBIDDEN = (
    "AX DEF",
    "AX LINK",
    "AX REQUEST",
    "AX RELEASE",
    "CALL AX",
    "CAX",
    "CHANNEL INIT",
    "CLEAR CONFIG",
    "ACS",
    "BCS",
    "CS",
    "CYL",
    "FACE",
    "FLUSH",
    "FLUSH WAIT",
    "GET CMDPOS",
    "GET ACTPOS",
    "GET MANUAL OFFSETS",
    "SET IPO SOLLPOS",
    "SET DEC LR SOLL",
    "LOAD CONFIG",
    "MCS ON",
    "MCS OFF",
    "MCS TO WCS",
    "OTC OFF",
    "PRESET",
    "PTP",
    "PUT AX",
    "SET AX",
    "TRACK CS",
    "TRAFO",
    "WCS TO MCS",
)
FORBIDDEN_G = frozenset({200, 201, 303})
_PERMITTED = "FLUSH CONTINUE"

_NEED_EXIT = (Approach.DIRECT, Approach.INDIRECT, Approach.ON_PATH, Approach.INSIDE_CORNER, Approach.TANGENTIAL)


class Compensation:
    """The compensation of one program run. `told` is what the stage knows, None as long as nothing was compensated."""

    def __init__(self) -> None:
        self.tangential = 0  # column of G05 in the block in work, 0 without
        self.told: RadiusCompensation | None = None
        self._moves = 0  # motions in the plane since G41 or G42
        self._direction = (0.0, 0.0)  # at the end of the last one
        self._last_offset = 0.0  # mm to the left, of the last one
        self.exit_open = False  # G40 was programmed, its exit block not yet

    @property
    def active(self) -> bool:
        """The stage compensates, or is about to."""
        return self.told is not None and self.told.side != 0

    @property
    def watches(self) -> bool:
        """It has to see every motion: no fast roads."""
        return self.exit_open or (
            self.told is not None and self.told.side != 0 and self.told.approach is Approach.WITHOUT_BLOCK
        )

    def follow(self, x: Execution) -> None:
        """Tell the stage if another compensation holds now."""
        side, modal, told = x.modal.compensation_side, x.modal, self.told
        if told is None and not side:
            return
        first, second = plane = PLANE_AXES[modal.plane]
        if side and max(plane) < len(x.coordinates.gain) and x.coordinates.gain[first] * x.coordinates.gain[second] < 0:
            side = -side
        before = told.side if told is not None else 0
        approach = told.approach if told is not None else modal.approach
        if side == 0 or before == 0 or self.tangential:
            approach = Approach.TANGENTIAL if self.tangential else modal.approach
        now = RadiusCompensation(x.source, side, approach, plane, modal.compensation)
        if told is not None and (told.side, told.settings) == (side, modal.compensation):
            return
        if told is not None and side == before == 0:
            return
        self.told = now
        x.emit(now)
        if before == 0:
            self._moves, self.exit_open = 0, False
        elif side == 0:
            self._leave(x, now)
        x.modal_changed()

    def _leave(self, x: Execution, now: RadiusCompensation) -> None:
        """G40: the exit block has to follow, or the program goes on from where the tool is (G239)."""
        self.exit_open = now.approach in _NEED_EXIT
        if now.approach is Approach.WITHOUT_BLOCK and self._moves > 1:
            position = x.coordinates.position.copy()
            offset, (dx, dy) = self._last_offset, self._direction
            position[now.plane[0]] -= dy * offset
            position[now.plane[1]] += dx * offset
            x.coordinates.moved(position)

    def note(self, x: Execution, block: Block) -> None:
        """A block goes to the stage: motions in the plane count."""
        told = self.told
        if told is None or not isinstance(block, Line | Arc):
            return
        first, second = told.plane
        if isinstance(block, Arc):
            if block.plane != told.plane:
                return
            sense = math.copysign(1.0, block.angle)
            dx = sense * float(block.centre[1] - block.end[second])
            dy = sense * float(block.end[first] - block.centre[0])
        else:
            dx, dy = float(block.end[first] - block.start[first]), float(block.end[second] - block.start[second])
        length = math.hypot(dx, dy)
        if length <= NO_LENGTH:
            return
        self._direction = dx / length, dy / length
        self._last_offset = told.side * x.tools.radius
        self._moves += 1
        if self.exit_open:
            self.exit_open = False
            x.modal_changed()


def expect_none(x: Execution, command: str, column: int) -> None:
    """LineError for a command that is not allowed between G41 or G42 and G40, nor before the exit block."""
    if x.modal.compensation_side or x.compensation.active:
        raise LineError(catalogue.FORBIDDEN, column, command=command)
    if x.compensation.exit_open:
        raise LineError(catalogue.EXIT_MISSING, column, command=command)


def forbids(name: str) -> bool:
    """Whether a statement forbids itself beside radius compensation."""
    return name != _PERMITTED and any(f"{name} ".startswith(f"{beginning} ") for beginning in FORBIDDEN)
