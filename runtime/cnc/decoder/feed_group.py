"""The axes that the F word refers to (programming manual 15569–15722, P-CHAN-00011, P-CHAN-00096).

The way of these axes is driven at F, all others arrive with them. The queue measures a path along the main axes (or along the
others if no main axis moves): a feed is converted by the ratio of both lengths.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import language as catalogue

MAIN_AXES = 3


@dataclass(frozen=True, slots=True)
class FeedGroup:
    """`factors`: weight of each axis, 0 for axes that only go along; () is 1 for the main axes. `weakest`: the axis with the
    longest way moves at F. `reference`: a rotary axis whose degrees count as mm on a circle with a radius (mm)."""

    factors: tuple[float, ...] = ()
    weakest: bool = False
    reference: tuple[int, float] | None = None

    @property
    def plain(self) -> bool:
        """The path is measured as the queue does it."""
        main = self.factors[:MAIN_AXES]
        usual = all(f == 1.0 for f in main) and not any(self.factors[MAIN_AXES:])
        return usual and not self.weakest and self.reference is None

    def line_length(self, way: list[float]) -> float:
        """The way (n,) of a straight move that is driven at F; 0 if none of the feed axes moves."""
        if self.weakest:
            return max((abs(w) for w in way), default=0.0)
        weighted = [f * w for f, w in zip(self.factors, way, strict=True)] if self.factors else way[:MAIN_AXES]
        if self.reference is not None:
            axis, radius = self.reference
            if axis < len(weighted):
                weighted[axis] = 0.0
            return math.hypot(*weighted, math.radians(way[axis]) * radius)
        return math.hypot(*weighted)

    def arc_length(self, way: list[float], along: float, column: int) -> float:
        """The same for an arc of length `along`, with the way of all axes. LineError for some of the main axes only."""
        if (
            self.plain or self.reference is not None
        ):  # with a reference radius G01 is driven, and nothing else is changed
            return along
        if self.weakest:
            return max([along, *(abs(w) for w in way[MAIN_AXES:])])
        main = self.factors[:MAIN_AXES]
        others = [f * w for f, w in zip(self.factors[MAIN_AXES:], way[MAIN_AXES:], strict=True)]
        if any(main) and len(set(main)) > 1:
            raise LineError(catalogue.FEED_GROUP_CIRCLE, column)
        return math.hypot(main[0] * along, *others)


MAIN_GROUP = FeedGroup()


def queue_length(way: list[float]) -> float:
    """The length of a straight move as the queue measures it."""
    return math.hypot(*way[:MAIN_AXES]) or math.hypot(*way[MAIN_AXES:])
