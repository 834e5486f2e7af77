"""G functions of the feed: what F means."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.decoder.modal import FeedMode
from runtime.cnc.language.isg.syntax import Group


def _feed_mode(number: int, mode: FeedMode, syntax: str) -> None:
    @g_function(number, Group.FEED_MODE, "isg.g.feed-mode-g93-g94-g95-g194", syntax=syntax)
    def select(x: Execution, call: GCall) -> None:
        x.modal.feed_mode = mode
        x.modal_changed()


_feed_mode(93, FeedMode.TIME, "G93 F<s>")
_feed_mode(94, FeedMode.PER_MINUTE, "G94 F..")
_feed_mode(95, FeedMode.PER_REVOLUTION, "G95 F..")
_feed_mode(194, FeedMode.PERCENT, "G194 F<percent>")
