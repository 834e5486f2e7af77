"""V.G.: data of the channel (programming manual 21060–21550)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable


@variable("V.G.BLOCK_NR", "isg.var.g-block-feed-circle", "last programmed block number")
def block_number(x: Execution) -> float:
    return float(x.block_number)
