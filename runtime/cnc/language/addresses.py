"""What the names in a program may refer to: axes, spindles, M and H functions of the channel."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Addresses:
    """Names and numbers that the channel knows, for the check of a program before anything of it is executed.

    `axes` in channel order; `spindles` the main spindle first; `m` and `h` the numbers of usable functions.
    """

    axes: tuple[str, ...]
    spindles: tuple[str, ...] = ()
    m: frozenset[int] = field(default_factory=frozenset)
    h: frozenset[int] = field(default_factory=frozenset)

    def axis(self, name: str) -> int:
        """Index of an axis, -1 if the channel has none of this name."""
        return self.axes.index(name) if name in self.axes else -1
