"""Codes that say how the path is driven: exact stop, continuous cutting, tapping (manual lines 2039–2078)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import GCall, Group, g_code


@g_code("9", Group.ONE_SHOT, "nct.feed.exact-stop-g09-g61-g64", meaning="exact stop at the end of the block")
def exact_stop(x: NctExecution, call: GCall) -> None:
    """The path stops at the end of this block; without a motion there is nothing to stop."""
    x.stops_here = True


@g_code("61", Group.FEED_CONTROL, "nct.feed.exact-stop-g09-g61-g64", meaning="exact stop at the end of every block")
def exact_stop_mode(x: NctExecution, call: GCall) -> None:
    _mode(x, exact_stop=True)


@g_code("64", Group.FEED_CONTROL, "nct.feed.exact-stop-g09-g61-g64", meaning="continuous cutting")
def continuous(x: NctExecution, call: GCall) -> None:
    _mode(x)


@g_code("63", Group.FEED_CONTROL, "nct.feed.override-inhibit-g63", meaning="stop and override have no effect")
def tapping(x: NctExecution, call: GCall) -> None:
    _mode(x, tapping=True)


def _mode(x: NctExecution, *, exact_stop: bool = False, tapping: bool = False) -> None:
    """G61, G63, G64: each of them ends the others."""
    x.modal.exact_stop = exact_stop
    x.modal_changed()
    if tapping is not x.suppressed.tapping:
        x.suppressed.tapping = tapping
        x.tell_suppression()
