"""Sine and cosine of angles in degrees, exact at multiples of 90: comparisons in programs hold there."""

from __future__ import annotations

import math

_SINE_OF_QUARTERS = (0.0, 1.0, 0.0, -1.0)


def sine(degrees: float) -> float:
    """SIN[180] is 0 and not 1.2e-16."""
    quarters, rest = divmod(math.fmod(degrees, 360.0), 90.0)
    return _SINE_OF_QUARTERS[int(quarters) % 4] if rest == 0 else math.sin(math.radians(degrees))


def cosine(degrees: float) -> float:
    quarters, rest = divmod(math.fmod(degrees, 360.0), 90.0)
    return _SINE_OF_QUARTERS[(int(quarters) + 1) % 4] if rest == 0 else math.cos(math.radians(degrees))
