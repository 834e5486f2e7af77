"""G193 and G293: the feed changes linearly over the path or over the time of a block (programming manual 3953–4005).

The block is handed over in pieces of equal length, each with the feed of its middle; the slopes of the interpolator join them.
Over the path the feed is v0 + (v1 - v0) s / L; over the time the acceleration is constant, so v² is linear in s.
"""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, Floats, Line, Polyline
from runtime.cnc.decoder.feed_word import FeedChange

PIECES = 64  # the feed of a piece is off by at most 1/128 of the change


def feeds(change: FeedChange, first: float, last: float) -> Floats:
    """The feeds of the pieces, (PIECES,), from `first` to `last` in mm/min."""
    middle = (np.arange(PIECES) + 0.5) / PIECES
    if change is FeedChange.PATH:
        return first + (last - first) * middle
    squares: Floats = first**2 + (last**2 - first**2) * middle
    return np.sqrt(squares)


def changing_line(line: Line, change: FeedChange, first: float) -> Polyline:
    """A straight move whose feed goes from `first` to its own."""
    shares = np.linspace(0.0, 1.0, PIECES + 1)[:, None]
    points = line.start + shares * (line.end - line.start)
    points[-1] = line.end
    number = -1 if line.source.n is None else line.source.n
    return Polyline(
        line.source.program,
        points,
        feeds(change, first, line.feed),
        np.full(PIECES, line.source.line, np.int64),
        np.full(PIECES, number, np.int64),
        line.end - line.end_pcs * (1.0 if line.pcs_gain is None else line.pcs_gain),
        line.pcs_gain,
        plane=line.plane,
        one_block=True,
    )


def changing_arc(arc: Arc, change: FeedChange, first: float) -> list[Arc]:
    """An arc whose feed goes from `first` to its own."""
    axes = list(arc.plane)
    shares = np.linspace(0.0, 1.0, PIECES + 1)
    points = arc.start + shares[:, None] * (arc.end - arc.start)
    begin = math.atan2(arc.start[axes[1]] - arc.centre[1], arc.start[axes[0]] - arc.centre[0])
    turned = begin + shares * math.radians(arc.angle)
    points[:, axes[0]] = arc.centre[0] + arc.radius * np.cos(turned)
    points[:, axes[1]] = arc.centre[1] + arc.radius * np.sin(turned)
    points[0], points[-1] = arc.start, arc.end
    speeds = feeds(change, first, arc.feed)
    return [
        replace(
            arc,
            start=points[i],
            end=points[i + 1],
            feed=float(speeds[i]),
            end_pcs=arc.programmed(points[i + 1]),
            angle=arc.angle / PIECES,
        )
        for i in range(PIECES)
    ]
