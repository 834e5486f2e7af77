"""G303: an arc in space through three points (programming manual 2638–2697)."""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import SpatialArc
from runtime.cnc.decoder.arcs import through_three_points
from runtime.cnc.decoder.circles import Circle
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import feed_of, require_feed
from runtime.cnc.decoder.motion import programmed_at, target
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue

MAIN_AXES = 3


def spatial_arc(x: Execution, block: CompiledBlock) -> None:
    """The motion of a G303 block; the position moves along. LineError, CircleError."""
    if len(x.setup.axes) < MAIN_AXES:
        raise LineError(catalogue.ARC_MAIN_AXES, block.column(WordKind.G), axes=len(x.setup.axes))
    if x.block is not None and x.block.feed >= 0:
        x.take_feed()
    require_feed(x, block)
    coordinates = x.coordinates
    start = coordinates.position
    interim = coordinates.target({i: x.length(v) for i, v in x.letters.items()}, x.modal.incremental)
    end = target(x, block)
    arc = through_three_points(np.array(start[:3]), np.array(interim[:3]), np.array(end[:3]))
    flat = Circle((0.0, 0.0), arc.radius, arc.angle)
    feed = feed_of(x, block, start, end, ((0, 1), flat))
    programmed = np.array(programmed_at(x, end))
    x.emit(SpatialArc(x.source, np.array(start), np.array(end), feed, programmed, arc.centre, arc.normal, arc.angle))
    coordinates.moved(end)
    x.moved_by_function = True
