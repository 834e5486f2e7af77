"""Approach and exit in segments with feeds of their own (#TRC SPLIT).

    entering   ── programmed feed ──▶ segment 1 ──▶ segment 2 ──▶ contour ──▶ segment 2 ──▶ segment 1 ──▶ …   leaving

Where the way is too short for both, the second keeps its length and all the rest is the first.
"""

from __future__ import annotations

import math

from runtime.cnc.blocks import Approach, ApproachSplit
from runtime.cnc.tool_radius_comp.approach import RIGHT_ANGLE, turn_to_tool
from runtime.cnc.tool_radius_comp.elements import LINE, NO_LENGTH, Element, Elements
from runtime.cnc.tool_radius_comp.pieces import Piece, Point

Plane = tuple[int, int]

_SPLIT = (Approach.DIRECT, Approach.INDIRECT, Approach.ON_PATH, Approach.WITHOUT_BLOCK)


def can_be_split(approach: Approach, block: Elements, first: Element) -> bool:
    """Whether an approach is split: a line to an inside corner, with G236 to an acute one (manual line 20612).

    `block` (1,) is the approach as it is programmed, `first` the element behind it; an exit is seen backwards.
    """
    if approach not in _SPLIT or block["kind"][0] != LINE or first["o0"] == 0.0:
        return False
    turn = turn_to_tool(block[0], first)
    return turn > RIGHT_ANGLE if approach is Approach.ON_PATH else turn >= 0.0


def in_segments(start: Point, pieces: list[Piece], split: ApproachSplit, plane: Plane, leaving: bool) -> list[Piece]:
    """The line from `start` in its segments; anything but one line stays as it is."""
    if len(pieces) != 1 or pieces[0].centre is not None or (split.axis is not None and split.axis not in plane):
        return pieces
    end = pieces[0].end
    if split.axis is None:
        whole = math.dist(start, end)
    else:
        at = plane.index(split.axis)
        whole = abs(end[at] - start[at])
    parts = _from_contour(whole, split)
    made: list[Piece] = []
    gone = 0.0
    for length, feed in parts if leaving else reversed(parts):
        gone += length
        share = gone / whole if len(made) + 1 < len(parts) else 1.0
        place = start[0] + share * (end[0] - start[0]), start[1] + share * (end[1] - start[1])
        made.append(Piece(end if share == 1.0 else place, feed=feed))
    return made


def _from_contour(whole: float, split: ApproachSplit) -> list[tuple[float, float | None]]:
    """Lengths and feeds from the contour outwards; the rest of the way has no feed of its own."""
    if whole <= NO_LENGTH:
        return [(whole, split.feeds[-1])]
    parts: list[tuple[float, float | None]] = []
    rest = whole
    for length, feed in zip(reversed(split.lengths), reversed(split.feeds), strict=True):
        part = min(length, rest)
        if part > NO_LENGTH:
            parts.append((part, feed))
        rest -= part
    if rest > NO_LENGTH:
        parts.append((rest, None))
    return parts
