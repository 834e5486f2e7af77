"""How wide the filters of the set-points may be (#FILTER): as they are set, or less, so that AX_DEV is kept whatever is driven.

The deviation is bounded by what an axis can do at most (`geometry.fir_filter`), so it holds at any override, in every corner
and in every stop. A factor for corners (ACC_FACT) makes the axes jump more than they may; the filter spreads a jump over its
window, and the factor is never so great that more than the allowed jump is left within a cycle.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.cnc.filter_settings import FilterSettings
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.fir_filter import TIME_DELAY, filter_half, greatest_deviation, one_side
from runtime.config.fir_filter import FirFilter, limited_order

Floats = npt.NDArray[np.float64]

_CERTAIN = 1.01  # of the limits of the axes: what numbers and cycles may be off


@dataclass(frozen=True, slots=True)
class FilterOrders:
    """`halves` of the filters (n_axes,), cycles, 0: none; `corner_factors` (n_axes,) of the jumps of velocity."""

    halves: tuple[int, ...]
    corner_factors: tuple[float, ...]


def filter_orders(
    settings: FilterSettings, filters: Sequence[FirFilter | None], limits: AxisLimits, period: float
) -> FilterOrders:
    """What the settings become for axes with these filters and limits; `period` in s."""
    made = [_of_axis(settings, given, limits, axis, period) for axis, given in enumerate(filters)]
    return FilterOrders(tuple(half for half, _ in made), tuple(factor for _, factor in made))


def _of_axis(
    settings: FilterSettings, given: FirFilter | None, limits: AxisLimits, axis: int, period: float
) -> tuple[int, float]:
    """Half and corner factor of one axis."""
    if not settings.on or given is None:
        return 0, 1.0
    kind = given.type.number
    cut_off = given.cut_off if settings.cut_off is None else settings.cut_off
    quality = given.quality if settings.quality is None else settings.quality
    share = given.share / 100.0 if settings.share is None else settings.share
    half = filter_half(kind, _order(settings, given, period), cut_off, period)
    side = np.zeros(half + 1)
    while half > 0:
        factor = 1.0
        if kind != TIME_DELAY:
            one_side(kind, half, cut_off, quality, period, side)
            factor = max(min(settings.corner_factor, 1.0 / (share * side[0] + 1.0 - share)), 1.0)
        if settings.deviation <= 0.0:
            return half, factor
        off = greatest_deviation(
            kind, half, share, period, side, _CERTAIN * limits.velocity[axis],
            _CERTAIN * max(limits.acceleration[axis], limits.deceleration[axis]),
            _CERTAIN * factor * limits.velocity_step[axis],
        )  # fmt: skip
        if off <= settings.deviation:
            return half, factor
        half -= 1
    return 0, 1.0


def _order(settings: FilterSettings, given: FirFilter, period: float) -> int:
    """Programmed as order or as time, or described."""
    if settings.order is not None:
        return limited_order(settings.order, given.type)
    if settings.order_time is not None:
        return limited_order(int(settings.order_time / period + 1e-9), given.type)
    return given.cycles(period)
