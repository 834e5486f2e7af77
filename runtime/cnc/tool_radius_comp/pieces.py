"""Parts of a tool path that belong to no element of the contour: approaches, exits, what goes around a corner."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

import numpy as np

from runtime.cnc.blocks import Arc, Floats, Line
from runtime.cnc.tool_radius_comp.elements import CIRCLE, LINE, LINES, NO_LENGTH, Element
from runtime.cnc.tool_radius_comp.meeting import NEAR

Point = tuple[float, float]


@dataclass(frozen=True, slots=True)
class Piece:
    """A line to `end`, or an arc to it about `centre` by `angle` rad, counter-clockwise positive; `feed` if it has its own."""

    end: Point
    centre: Point | None = None
    angle: float = 0.0
    feed: float | None = None


def element_piece(e: Element) -> Piece:
    """The piece of a joined offset element, from its begin to its end."""
    end = float(e["ex"]), float(e["ey"])
    if e["kind"] == LINE or e["radius"] <= NEAR:
        return Piece(end)
    angle = math.copysign(1.0, e["turn"]) * float(e["end"] - e["begin"]) / float(e["radius"])
    return Piece(end, (float(e["mx"]), float(e["my"])), angle)


def corner_pieces(e: Element) -> list[Piece]:
    """What is inserted behind an element up to the begin of the next one."""
    following = float(e["nx"]), float(e["ny"])
    here = float(e["ex"]), float(e["ey"])
    if e["insert"] == CIRCLE:
        centre = float(e["x1"]), float(e["y1"])
        ux, uy = here[0] - centre[0], here[1] - centre[1]
        vx, vy = following[0] - centre[0], following[1] - centre[1]
        angle = math.atan2(ux * vy - uy * vx, ux * vx + uy * vy)
        sense = -math.copysign(1.0, e["o1"])  # around the corner, which lies on the other side than the tool
        return [Piece(following, centre, angle if angle * sense > 0.0 else angle + sense * 2.0 * math.pi)]
    if e["insert"] != LINES:
        return []
    corners = [(float(e["ix"]), float(e["iy"])), (float(e["jx"]), float(e["jy"]))][: int(e["points"])]
    return [
        Piece(point) for before, point in zip([here, *corners], [*corners, following], strict=True) if before != point
    ]


def in_pieces(
    block: Line | Arc,
    start: Floats,
    pieces: list[Piece],
    plane: tuple[int, int],
    feed: float,
    end: Floats | None = None,
) -> Iterator[Line | Arc]:
    """The pieces of a way from `start` on as motions of a block; axes beside the plane go to `end` in share of the length."""
    lengths = [_length(begin, piece) for begin, piece in zip(_begins(start, plane, pieces), pieces, strict=True)]
    whole, gone = sum(lengths), 0.0
    here = start
    for number, (piece, length) in enumerate(zip(pieces, lengths, strict=True), 1):
        gone += length
        there = start.copy()
        if end is not None:
            share = gone / whole if whole > 0.0 and number < len(pieces) else 1.0
            there = start + share * (end - start)
        there[plane[0]], there[plane[1]] = piece.end
        if length > NO_LENGTH or np.abs(there - here).max() > NO_LENGTH:
            own = feed if piece.feed is None else piece.feed
            yield (
                straight(block, here, there, own)
                if piece.centre is None
                else _arc(block, here, there, piece, plane, own)
            )
            here = there


def _begins(start: Floats, plane: tuple[int, int], pieces: list[Piece]) -> list[tuple[float, float]]:
    here = float(start[plane[0]]), float(start[plane[1]])
    return [here, *(piece.end for piece in pieces)][: len(pieces)]


def _length(begin: tuple[float, float], piece: Piece) -> float:
    if piece.centre is None:
        return math.dist(begin, piece.end)
    return math.dist(begin, piece.centre) * abs(piece.angle)


def straight(block: Line | Arc, start: Floats, end: Floats, feed: float) -> Line:
    """A line of a block's own, from `start` to `end`, (n_axes,)."""
    return Line(
        block.source, start, end, feed, math.isinf(feed), block.programmed(end), block.plane, None,
        None, block.override_off, block.pcs_gain,
    )  # fmt: skip


def _arc(block: Line | Arc, start: Floats, end: Floats, piece: Piece, plane: tuple[int, int], feed: float) -> Arc:
    assert piece.centre is not None
    radius = math.hypot(start[plane[0]] - piece.centre[0], start[plane[1]] - piece.centre[1])
    return Arc(
        block.source, start, end, feed, block.programmed(end), plane, np.array(piece.centre), radius,
        math.degrees(piece.angle), None, None, block.override_off, block.pcs_gain,
    )  # fmt: skip
