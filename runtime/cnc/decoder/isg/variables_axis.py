"""V.A.: data of the axes (programming manual 21624–21733)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable


@variable(
    "V.A.ABS.<axis>",
    "isg.var.a-coordinates",
    "absolute coordinate of the last block with all offsets",
    unit="mm, inch, deg",
)
def absolute(x: Execution, axis: int) -> float:
    return x.shown(axis, x.coordinates.position[axis])
