"""What every axis travels on a motion: the sum of its ways there and back, for the display of #DIST TO GO."""

from __future__ import annotations

import math

import numpy as np

from runtime.cnc.blocks import Arc, Block, Floats, Line, Polyline, Polynomials

PLACES = 65  # of a polynomial at which its axes are looked at


def axis_travel(block: Block) -> Floats | float:
    """Ways (n_axes,) of a motion, mm or degrees; 0 for anything else."""
    if isinstance(block, Polyline):
        ways: Floats = np.abs(np.diff(block.points, axis=0)).sum(axis=0)
        return ways
    if isinstance(block, Polynomials):
        powers = np.linspace(0.0, 1.0, PLACES)[:, None] ** np.arange(block.coefficients.shape[1])
        places = np.einsum("up,kpn->kun", powers, block.coefficients)
        along: Floats = np.abs(np.diff(places, axis=1)).sum(axis=(0, 1))
        return along
    if isinstance(block, Arc):
        return _arc(block)
    return np.abs(block.end - block.start) if isinstance(block, Line) else 0.0


def _arc(arc: Arc) -> Floats:
    ways: Floats = np.abs(arc.end - arc.start)
    first, second = arc.plane
    x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
    begin, turn, radius = math.atan2(y, x), math.radians(arc.angle), math.hypot(x, y)
    for axis, shift in ((first, 0.0), (second, 0.5 * math.pi)):
        low, high = sorted((begin - shift, begin - shift + turn))
        turning = [k * math.pi for k in range(math.ceil(low / math.pi), math.floor(high / math.pi) + 1)]
        ways[axis] = radius * np.abs(np.diff(np.cos([low, *turning, high]))).sum()
    return ways
