"""How often another override is taken (P-CHAN-00065, channel parameters 3168–3188)."""

from __future__ import annotations

import math

LEAST_CYCLES = 10


class SampledOverride:
    """The first change is taken at once, the next one when `delay` s are over, ten cycles at least; 0 always at once."""

    def __init__(self, delay: float, period: float) -> None:
        self._cycles = max(LEAST_CYCLES, math.ceil(delay / period - 1e-9))
        self._left = 0
        self._value = 1.0

    def take(self, wanted: float) -> float:
        """The override that counts in this cycle; call it once per cycle."""
        self._left = max(self._left - 1, 0)
        if wanted != self._value and (self._left == 0 or wanted == 0.0):
            self._value = wanted
            self._left = self._cycles
        return self._value
