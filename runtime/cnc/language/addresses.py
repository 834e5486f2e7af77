"""What the names in a program may refer to: axes, spindles, M and H functions of the channel."""

from __future__ import annotations

from dataclasses import dataclass, field


@dataclass(frozen=True, slots=True)
class Addresses:
    """Names and numbers that the channel knows, for the check of a program before anything of it is executed.

    `axes` in channel order; `spindles` their own names, in the order of the configuration; `main_name` is the name of whichever
    is the main spindle; `m` and `h` the numbers of usable functions. `gears`: M40 to M45 change the gear of the main spindle.
    `other_axes`: axes of the machine outside of the channel, without spindles.
    """

    axes: tuple[str, ...]
    spindles: tuple[str, ...] = ()
    m: frozenset[int] = field(default_factory=frozenset)
    h: frozenset[int] = field(default_factory=frozenset)
    main_name: str = ""
    gears: bool = False
    other_axes: tuple[str, ...] = ()

    def axis(self, name: str) -> int:
        """Index of an axis, -1 if the channel has none of this name."""
        return self.axes.index(name) if name in self.axes else -1

    def has_spindle(self, name: str) -> bool:
        """A spindle has this name, its own or that of the main spindle; upper and lower case do not matter (line 24456)."""
        known = {"S", self.main_name.upper(), *(spindle.upper() for spindle in self.spindles)}
        return bool(self.spindles) and name.upper() in known
