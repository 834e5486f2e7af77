"""The F word: its range, its unit, and where it is kept (programming manual 5260–5287, 6906–6920)."""

from __future__ import annotations

import math
from enum import Enum
from typing import TYPE_CHECKING

from runtime.cnc.decoder.modal import INCH, FeedMode
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.motion_words import MotionBlock, WordKind
from runtime.diagnostics.catalogue import language as catalogue

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution


class FeedChange(Enum):
    """Over what the feed of a block changes linearly, by its G function."""

    PATH = 193
    TIME = 293


def enter_feed(x: Execution, block: MotionBlock, value: float) -> None:
    """Keep an F as the feed of the active mode. LineError for one that cannot be."""
    modal = x.modal
    inch = modal.inch and modal.feed_mode in (FeedMode.PER_MINUTE, FeedMode.PER_REVOLUTION)
    feed = value * (INCH if inch else 1.0)
    if modal.feed_mode is FeedMode.PER_MINUTE:
        feed *= x.setup.feed_factor
    if not 0 <= feed < math.inf:
        raise LineError(catalogue.FEED_INVALID, block.column(WordKind.FEED), value=value)
    if modal.feed_mode is FeedMode.PERCENT and feed >= 100:
        raise LineError(catalogue.FEED_PERCENT, block.column(WordKind.FEED), value=value)
    modal.feed = feed
