"""G functions of the offsets: zero offsets."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.language.isg.syntax import Group


def select_zero_offset(x: Execution, index: int) -> None:
    """Make a stored data set the active one; it acts with the next absolute word of each axis."""
    x.modal.zero_offset = index
    stored, enabled = x.memory.zero_offsets[index], x.memory.zero_enabled[index]
    x.coordinates.offsets.zero = [float(v) for v in stored * enabled]
    x.coordinates.update()


def _zero_offset(number: int) -> None:
    @g_function(number, Group.ZERO_OFFSET, "isg.g.zero-offset-g53-g59")
    def select(x: Execution, call: GCall) -> None:
        select_zero_offset(x, number - 53)


for _number in range(53, 60):
    _zero_offset(_number)
