"""Arcs in space (G303) become what the queue knows: an arc where they lie parallel to a main plane, else a run of lines.

The lines are chords: their ends lie on the arc, and between them the path is off by at most CHORD_ERROR, which is
below what any axis resolves. The chords are √(8 · CHORD_ERROR · radius) long, 0.09 mm at a radius of 100 mm; at the
speed that the acceleration of the axes allows on the curve that is a handful per cycle at any radius.
"""

from __future__ import annotations

import math
from collections.abc import Iterable, Iterator

import numpy as np

from runtime.cnc.blocks import Arc, Block, Polyline, SpatialArc, machine_way

CHORD_ERROR = 1e-5  # mm
GREATEST_STEP = math.pi / 16  # rad: arcs so tiny that CHORD_ERROR would make them polygons stay round


class SpatialArcs:
    """The stage. It stands in front of the software limits, which then check the points that are driven.

    The run of an arc is one NC block (`Polyline.one_block`): single block stops at the BlockEnd behind it.
    """

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            yield in_parts(block) if isinstance(block, SpatialArc) else block


def in_parts(arc: SpatialArc) -> Arc | Polyline:
    """An arc in space as an arc of a main plane, or as chords."""
    main = int(np.argmax(np.abs(arc.normal)))
    radius = float(np.linalg.norm(arc.start[:3] - arc.centre))
    tilt = math.hypot(*(float(arc.normal[axis]) for axis in range(3) if axis != main))
    if 2.0 * radius * tilt > CHORD_ERROR:
        return _chords(arc, radius)
    plane = (main + 1) % 3, (main + 2) % 3
    return Arc(
        arc.source,
        arc.start,
        arc.end,
        arc.feed,
        arc.end_pcs,
        plane,
        arc.centre[list(plane)],
        radius,
        math.copysign(arc.angle, arc.normal[main]),
        pcs_gain=arc.pcs_gain,
    )


def _chords(arc: SpatialArc, radius: float) -> Polyline:
    """The arc as a run of lines; what rounding leaves to the end is spread over the run."""
    angle = math.radians(arc.angle)
    # A chord over the angle a is off by r (1 - cos a/2) = 2 r sin² a/4, which also holds its digits for large radii.
    step = 4.0 * math.asin(math.sqrt(min(CHORD_ERROR / (2.0 * radius), 1.0)))
    count = max(1, math.ceil(angle / min(step, GREATEST_STEP)))
    share = np.linspace(0.0, 1.0, count + 1)[:, None]
    points = arc.start + share * (arc.end - arc.start)
    along = arc.start[:3] - arc.centre
    across = np.cross(arc.normal, along)
    turned = arc.centre + np.cos(angle * share) * along + np.sin(angle * share) * across
    points[:, :3] = turned + share * (arc.end[:3] - turned[-1])
    points[0], points[-1] = arc.start, arc.end
    number = -1 if arc.source.n is None else arc.source.n
    return Polyline(
        arc.source.program,
        points,
        np.full(count, arc.feed),
        np.full(count, arc.source.line, dtype=np.int64),
        np.full(count, number, dtype=np.int64),
        arc.end - machine_way(arc.end_pcs, arc.pcs_gain),
        arc.pcs_gain,
        one_block=True,
    )
