"""The tool of a running program: what T and D have selected, and what of it stands in the coordinates.

`Execution.tools.radius` is the radius that a radius compensation works with: of the active record, with what the program has
written over it, mm, signed (a negative one changes the side). Whenever it changes a `ToolRadius` block says so in the stream, so
that a later stage knows from which block on it holds; a program starts with radius 0.

Selecting a tool moves nothing (programming manual 18536–18565): length and axis offsets are a part of the offsets, which each
axis takes up with its next absolute word. With P-CHAN-00100 the D word itself moves the axes; `tool_words` makes that motion.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from runtime.cnc.blocks import Floats, ToolRadius
from runtime.cnc.decoder.control_areas import tell
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.tools.tool import NO_TOOL, Tool, ToolId

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

_Z = 2


class Tooling:
    """`active`: the record of the last D word as the program has changed it. `id`: of the last T word."""

    def __init__(self, x: Execution) -> None:
        self._x = x
        self.active: Tool = NO_TOOL
        self.id = ToolId()
        self.length_axis = _Z if x.setup.tools.length_stays else -1  # of #TLAX, -1: the third axis of the plane
        self.length_sign = 1.0
        self.fetched: Tool | None = None  # of the external tool management, for the D word in work
        self.known: dict[
            int, Tool | tuple[int, int]
        ] = {}  # what it has told for V.G.WZ[j], or the request and its cycle
        self.moved = False  # axes were moved by a D word since the last block end
        self._left_out = False  # neither length nor offsets count (#MCS ON)
        self._until_next = False  # until the next D word
        self._late: set[int] = set()  # axes that never move by a D word itself: see `assigned`

    @property
    def data(self) -> int:
        """Number of the active record, 0 with D0."""
        return self.active.number

    @property
    def radius(self) -> float:
        """Radius of the active tool, mm; 0 with D0."""
        return self.active.radius

    def use(self, tool: Tool) -> dict[int, float]:
        """Make a record the active one; by how much the offset of each axis that D may move at once has changed."""
        if self._until_next:
            self._left_out = self._until_next = False
        return self.change(tool)

    def change(self, tool: Tool) -> dict[int, float]:
        """The data of the active tool change. As `use`."""
        before = self.active.radius
        self.active = tool
        if self._x.setup.tools.external:
            self._x.memory.tool_left = tool if tool.number else None
        if tool.radius != before:
            self._x.emit(ToolRadius(self._x.source_in_work(), tool.radius))
        changed = self.include()
        return {axis: way for axis, way in changed.items() if axis not in self._late}

    def include(self) -> dict[int, float]:
        """Bring the data of the active tool into the offsets; the change of each axis, mm or degrees."""
        coordinates = self._x.coordinates
        before = coordinates.offsets.tool
        offsets = [self.active.value("offsets", axis) for axis in range(len(before))]
        axis = self.length_axis if self.length_axis >= 0 else 3 - sum(PLANE_AXES[self._x.modal.plane])
        if self._left_out:
            offsets = [0.0] * len(before)
        elif axis < len(offsets):
            offsets[axis] += self.length_sign * self.active.length
        changed = {axis: new - old for axis, (old, new) in enumerate(zip(before, offsets, strict=True)) if new != old}
        if changed:
            coordinates.offsets.tool = offsets
            coordinates.update()
        if self._x.memory.active_areas:  # another tool is somewhere else
            tell(self._x)
        return changed

    def assign_length(self, axis: int, sign: float) -> None:
        """#TLAX: the length acts in an axis, with a sign; -1: in the third axis of the plane."""
        self.length_axis, self.length_sign = axis, sign
        self.assigned()

    def mounted(self) -> Floats:
        """By how much the tip of the tool lies beside the axes, (n_axes,), whatever of it counts in the coordinates."""
        offsets = [self.active.value("offsets", axis) for axis in range(len(self._x.setup.axes))]
        axis = self.length_axis if self.length_axis >= 0 else 3 - sum(PLANE_AXES[self._x.modal.plane])
        if axis < len(offsets):
            offsets[axis] += self.length_sign * self.active.length
        return np.array(offsets)

    def leave_out(self, *, until_next: bool) -> None:
        """Length and offsets do not count, until `take_in` or (`until_next`) the next D word."""
        self._left_out, self._until_next = True, until_next
        self.assigned()

    def take_in(self) -> None:
        """They count again."""
        self._left_out = self._until_next = False
        self.assigned()

    def assigned(self) -> None:
        """The plane, or the axis of the length, is another one: the length goes over with the next absolute words.

        The decoder does not know of an axis whether that has come, and a D word that moves at once could move it the wrong way
        meanwhile: these axes keep to absolute words until the program ends.
        """
        self._late |= self.include().keys()
