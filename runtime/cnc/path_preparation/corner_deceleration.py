"""G13: over the last millimetres of a block the feed falls linearly to the corner feed (programming manual 4469–4560).

A stage behind tool radius compensation, as the distance counts along the corrected path. The way before the corner is handed
on in pieces of equal length, each with the feed of its middle. A block that is shorter than the distance begins on the
falling line. It acts with the slope STEP only (lines 4501–4504), on moves at feed.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, Block, BlockEnd, DynamicsChange, Floats, Line, Polyline
from runtime.cnc.dynamic_settings import USUAL, CornerDeceleration, Slope
from runtime.cnc.path_preparation.motion_pieces import lines_of

PIECES = 32  # the feed of a piece is off by at most 1/64 of the change


class CornerDecelerations:
    """The stage. Chamfers and roundings are blocks of their own here."""

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        settings = USUAL
        for block in blocks:
            if isinstance(block, DynamicsChange):
                settings = block.settings
            corner = settings.corner if settings.slope is Slope.STEP else None
            if corner is None:
                yield block
            elif isinstance(block, Line) and not block.rapid:
                yield from _line(block, corner)
            elif isinstance(block, Arc) and math.isfinite(block.feed):
                yield from _arc(block, corner)
            elif isinstance(block, Polyline) and not block.one_block:
                for line in lines_of(block):
                    yield from (line,) if line.rapid else _line(line, corner)
                    yield BlockEnd(line.source)
            else:
                yield block


def _shares(length: float, corner: CornerDeceleration) -> Floats:
    """Where the pieces begin and end, as shares of a block of so many mm: first the way before the corner, if there is any."""
    begin = max(1.0 - corner.distance / length, 0.0)
    shares = np.linspace(begin, 1.0, PIECES + 1)
    return np.concatenate([[0.0], shares]) if begin > 0.0 else shares


def _feeds(shares: Floats, length: float, feed: float, corner: CornerDeceleration) -> Floats:
    """The feed of every piece, mm/min."""
    middle = 0.5 * (shares[1:] + shares[:-1])
    left = np.minimum((1.0 - middle) * length / corner.distance, 1.0)
    lowest = corner.feed_of(feed)
    feeds: Floats = lowest + (feed - lowest) * left
    if len(feeds) > PIECES:
        feeds[0] = feed
    return feeds


def _line(line: Line, corner: CornerDeceleration) -> Iterator[Block]:
    """A straight move whose feed falls at its end."""
    length = float(np.linalg.norm((line.end - line.start)[:3]))
    if not length > 0.0:
        yield line
        return
    shares = _shares(length, corner)
    feeds = _feeds(shares, length, line.feed, corner)
    points = line.start + shares[:, None] * (line.end - line.start)
    points[-1] = line.end
    for i, feed in enumerate(feeds):
        end = points[i + 1]
        at_end = line.end_feed if i == len(feeds) - 1 else None
        yield replace(line, start=points[i], end=end, feed=float(feed), end_pcs=line.programmed(end), end_feed=at_end)


def _arc(arc: Arc, corner: CornerDeceleration) -> Iterator[Block]:
    """The same for an arc or helix."""
    axes = list(arc.plane)
    linear = arc.end - arc.start
    linear[axes] = 0.0
    length = math.hypot(arc.radius * math.radians(arc.angle), float(np.linalg.norm(linear[:3])))
    if not length > 0.0:
        yield arc
        return
    shares = _shares(length, corner)
    feeds = _feeds(shares, length, arc.feed, corner)
    begin = math.atan2(arc.start[axes[1]] - arc.centre[1], arc.start[axes[0]] - arc.centre[0])
    turned = begin + shares * math.radians(arc.angle)
    points = arc.start + shares[:, None] * linear
    points[:, axes[0]] = arc.centre[0] + arc.radius * np.cos(turned)
    points[:, axes[1]] = arc.centre[1] + arc.radius * np.sin(turned)
    points[0], points[-1] = arc.start, arc.end
    for i, feed in enumerate(feeds):
        yield replace(
            arc,
            start=points[i],
            end=points[i + 1],
            feed=float(feed),
            end_pcs=arc.programmed(points[i + 1]),
            angle=arc.angle * float(shares[i + 1] - shares[i]),
            end_feed=arc.end_feed if i == len(feeds) - 1 else None,
        )
