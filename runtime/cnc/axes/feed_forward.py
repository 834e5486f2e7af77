"""Feed-forward of the path axes (G135…G137): shares of what the drives are described to get, of velocity and torque.

A share changes over some cycles: all at once it would be a step in what the drive is told, and the axis would be pushed.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

Floats = npt.NDArray[np.float64]

FULL_CHANGE = 0.1  # s from nothing to everything


class FeedForwardShares:
    """Of the n axes of a channel; `step` once per cycle while they are `changing`."""

    def __init__(self, n: int, period: float) -> None:
        self.shares: Floats = np.ones(n)  # as the drives are described, until a program starts
        self._wanted: Floats = np.ones(n)
        self._most = period / FULL_CHANGE
        self.changing = False

    def order(self, shares: Floats) -> None:
        """These shares (n,), 0…1, from here on."""
        self._wanted[:] = shares
        self.changing = bool((self._wanted != self.shares).any())

    def step(self) -> None:
        """One cycle on the way to what was ordered."""
        self.shares += np.clip(self._wanted - self.shares, -self._most, self._most)
        self.changing = bool((self._wanted != self.shares).any())
