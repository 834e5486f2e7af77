"""Codes that say how the path is driven: exact stop and continuous cutting (manual lines 2039–2072)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import GCall, Group, g_code


@g_code("9", Group.ONE_SHOT, "nct.feed.exact-stop-g09-g61-g64", meaning="exact stop at the end of the block")
def exact_stop(x: NctExecution, call: GCall) -> None:
    """The path stops at the end of this block; without a motion there is nothing to stop."""
    x.stops_here = True


@g_code("61", Group.FEED_CONTROL, "nct.feed.exact-stop-g09-g61-g64", meaning="exact stop at the end of every block")
def exact_stop_mode(x: NctExecution, call: GCall) -> None:
    x.modal.exact_stop = True
    x.modal_changed()


@g_code("64", Group.FEED_CONTROL, "nct.feed.exact-stop-g09-g61-g64", meaning="continuous cutting")
def continuous(x: NctExecution, call: GCall) -> None:
    x.modal.exact_stop = False
    x.modal_changed()
