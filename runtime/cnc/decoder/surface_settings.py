"""What of the constant surface speed of NCT programs outlives them."""

from __future__ import annotations

from dataclasses import dataclass

PER_METRE = 1000.0  # mm


@dataclass(slots=True)
class SurfaceSettings:
    """`velocity` in mm/min, `axis` by its address, `limit` in rev/min, 0 for none."""

    velocity: float = 0.0
    axis: str = "X"
    limit: float = 0.0
