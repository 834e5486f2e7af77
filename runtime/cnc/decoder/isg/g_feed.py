"""Feed: what F means, linear change within a block, override off."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed_word import FeedChange
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.decoder.modal import FeedMode
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group
from runtime.diagnostics.catalogue import language as catalogue


def _feed_mode(number: int, mode: FeedMode, syntax: str) -> None:
    @g_function(number, Group.FEED_MODE, "isg.g.feed-mode-g93-g94-g95-g194", syntax=syntax)
    def select(x: Execution, call: GCall) -> None:
        x.modal.feed_mode = mode
        x.modal_changed()


_feed_mode(93, FeedMode.TIME, "G93 F<s>")
_feed_mode(94, FeedMode.PER_MINUTE, "G94 F..")
_feed_mode(95, FeedMode.PER_REVOLUTION, "G95 F..")
_feed_mode(194, FeedMode.PERCENT, "G194 F<percent>")


def _feed_change(number: int, change: FeedChange) -> None:
    @g_function(
        number, Group.FEED_CHANGE, "isg.g.feed-interpolation-g193-g293", modal=False, syntax=f"G{number} <axis>.. F.."
    )
    def select(x: Execution, call: GCall) -> None:
        """The feed goes linearly from the one before to the one of the block."""
        before = x.modal.feed
        if before is None or before <= 0 or x.modal.feed_mode is not FeedMode.PER_MINUTE:
            raise LineError(catalogue.FEED_CHANGE_START, call.column, number=number)
        x.feed_change = (change, before)


_feed_change(193, FeedChange.PATH)
_feed_change(293, FeedChange.TIME)


@g_function(166, Group.OVERRIDE, "isg.g.override-off-g166", modal=False, syntax="G166 <axis>..")
def override_off(x: Execution, call: GCall) -> None:
    """In this block every override counts as 100 percent."""
    x.override_off = True
