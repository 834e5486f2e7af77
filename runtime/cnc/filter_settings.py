"""What #FILTER sets for the filters of all axes of a channel; everything that is not programmed is what each axis has."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(frozen=True, slots=True)
class FilterSettings:
    """The state behind a #FILTER.

    `order` in cycles, or `order_time` in s; `share` 0…1; `cut_off` in Hz; `quality` 0…1. `deviation`, mm or degrees: no axis
    comes farther off its path, 0: that is not watched. `corner_factor` multiplies the jump of velocity at corners.
    """

    on: bool = False
    order: int | None = None
    order_time: float | None = None
    share: float | None = None
    cut_off: float | None = None
    quality: float | None = None
    deviation: float = 0.0
    corner_factor: float = 1.0
