"""G303: an arc in space through three points (programming manual 2638–2697)."""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import Corner, SpatialArc
from runtime.cnc.decoder.arcs import through_three_points
from runtime.cnc.decoder.circles import Circle
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.feed import feed_of, require_feed
from runtime.cnc.decoder.motion import pcs_gain, programmed_at, target
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue

MAIN_AXES = (0, 1, 2)


def spatial_arc(x: Execution, block: CompiledBlock, corner: Corner | None) -> None:
    """The arc from here over the interim point I, J, K to the target; both count as G90 or G91 says. The position moves
    along. LineError, CircleError.
    """
    if len(x.setup.axes) < len(MAIN_AXES):
        raise LineError(catalogue.ARC_MAIN_AXES, block.column(WordKind.G), axes=len(x.setup.axes))
    _expect_bare(x, block, corner)
    require_feed(x, block)
    x.expect_path_start(block.column(WordKind.AXIS))
    coordinates = x.coordinates
    start = coordinates.position
    interim = coordinates.target({i: x.length(v) for i, v in x.letters.items()}, x.modal.incremental)
    end = target(x, block)
    arc = through_three_points(np.array(start[:3]), np.array(interim[:3]), np.array(end[:3]))
    feed = feed_of(x, block, start, end, (MAIN_AXES, Circle((0.0, 0.0), arc.radius, arc.angle)))
    x.emit(
        SpatialArc(
            x.source,
            np.array(start),
            np.array(end),
            feed,
            np.array(programmed_at(x, end)),
            arc.centre,
            arc.normal,
            arc.angle,
            pcs_gain(x),
        )
    )
    coordinates.moved(end)


def _expect_bare(x: Execution, block: CompiledBlock, corner: Corner | None) -> None:
    for word, kind, given in (
        ("a chamfer or rounding", WordKind.ADDITION, corner is not None),
        ("R", WordKind.RADIUS, block.radius >= 0),
        ("E", WordKind.END_FEED, x.end_feed is not None),
        ("G166", WordKind.G, x.override_off),
        ("a linear feed change", WordKind.G, x.feed_change is not None),
    ):
        if given:
            raise LineError(catalogue.ARC_BESIDE, block.column(kind), word=word)
