"""The FIR filter of the set-points of an axis (P-AXIS-00573 to 00593)."""

from __future__ import annotations

from enum import StrEnum

from pydantic import Field

from runtime.config.model import Model
from runtime.config.quantity_fields import Seconds

MOST_ORDER = 200
MOST_DELAY = 100


class FilterType(StrEnum):
    """P-AXIS-00586, with its numbers."""

    MOVING_AVERAGE = "moving_average"
    GAUSSIAN = "gaussian"
    WINDOWED_SINC = "windowed_sinc"
    TIME_DELAY = "time_delay"

    @property
    def number(self) -> int:
        """Value of the parameter; 0 would be no filter."""
        return list(FilterType).index(self) + 1


class FirFilter(Model):
    """What #FILTER ON switches on; the program may set everything but the type for all axes alike."""

    type: FilterType = Field(strict=False)
    enable: bool = False  # on from the start of every program
    order: int = Field(default=0, ge=0, le=MOST_ORDER)  # cycles, 0: none; of a time delay up to 100
    order_time: Seconds | None = None  # instead of the order
    share: float = Field(default=100.0, ge=0.0, le=100.0)  # percent that goes through the filter
    cut_off: float = Field(default=30.0, ge=1.0)  # Hz, of a windowed sinc
    quality: float = Field(default=1.0, gt=0.0, le=1.0)  # of a Gaussian: width of its bell

    def cycles(self, period: float) -> int:
        """The order, cycles of `period` s."""
        return limited_order(self.order or int((self.order_time or 0.0) / period + 1e-9), self.type)


def limited_order(order: int, kind: FilterType) -> int:
    """The order that a filter of a type can have at most."""
    return min(order, MOST_DELAY if kind is FilterType.TIME_DELAY else MOST_ORDER)
