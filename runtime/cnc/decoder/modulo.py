"""Axes that turn without end: which way a programmed position is approached, and what the program sees of the turns.

    machine:  … ─ 340 ─ 0|360 ─ 380 ─ …      counts on without end
    program:  … ─ 340 ─ 0 ──── 20 ─ …        within the range of the axis

The path keeps the endless count, so that no element of it ever jumps. A program may change the range, or switch it off
(<axis>[MODULO ..]): then `Coordinates.turns` keeps by how much the machine counts further than the program.
"""

from __future__ import annotations

import math
from collections.abc import Iterable
from dataclasses import dataclass, field

from runtime.kernels import kernel, warms

TURN = 360.0
SAME = 1e-6  # degrees: a target that is no further away is where the axis stands


@kernel
def modulo_end(now: float, place: float, size: float, direction: int) -> float:
    """Where the motion from `now` to `place` ends, on a range of `size` degrees.

    `direction` 1 or -1 turns that way, less than a whole range; 0 takes the shorter way.
    """
    way = place - now
    way = way - size * math.floor(way / size)  # 0 to size
    if way < SAME or size - way < SAME:
        return now + (way if way < SAME else way - size)
    if direction < 0 or (direction == 0 and way > 0.5 * size):
        way = way - size
    return now + way


def wrapped(value: float, low: float, high: float) -> float:
    """The same place within `low` to before `high`."""
    size = high - low
    inside = value - size * math.floor((value - low) / size)
    return low if inside >= high else max(inside, low)  # rounding


@dataclass(slots=True)
class ModuloAxes:
    """Of a running program. `configured`: channel indices of the axes that turn without end by their description.

    `ranges` are those in which programs count now, `limits` the last ones of every axis; degrees.
    """

    configured: frozenset[int]
    always_shortest: bool = False  # P-CHAN-00346
    ranges: dict[int, tuple[float, float]] = field(default_factory=dict)
    limits: dict[int, tuple[float, float]] = field(default_factory=dict)

    @classmethod
    def of(cls, configured: Iterable[int], *, always_shortest: bool) -> ModuloAxes:
        axes = frozenset(configured)
        return cls(axes, always_shortest, dict.fromkeys(axes, (0.0, TURN)))

    def last_limits(self, axis: int) -> tuple[float, float]:
        """The limits that hold where a command names none."""
        return self.limits.get(axis, (0.0, TURN))

    def shown(self, axis: int, value: float) -> float:
        """A position of an axis as the program counts it, both without turns that it does not count."""
        known = self.ranges.get(axis)
        return value if known is None else wrapped(value, *known)

    def size(self, axis: int) -> float:
        """Degrees until the axis counts the same again, 0 for one that never does."""
        low, high = self.ranges.get(axis, (0.0, 0.0))
        return high - low


@warms("axes that turn without end")
def _warm() -> None:
    modulo_end(0.0, 1.0, TURN, 0)
