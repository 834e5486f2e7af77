"""The speed of the spindle for a constant cutting speed: n = v / (2 π r)."""

from __future__ import annotations

import math


def turning_speed(velocity: float, radius: float, limit: float) -> float:
    """rev/min for a cutting speed in mm/min at a radius in mm, at most `limit` (rev/min)."""
    around = 2.0 * math.pi * abs(radius)
    return min(velocity / around, limit) if around > 0.0 else limit
