"""The modal state of a channel: what G functions and modal words have set, and what holds at program start."""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import IntEnum

from runtime.cnc.blocks import Approach, CompensationSettings

INCH = 25.4  # mm


class Motion(IntEnum):
    """The path condition: what axis words mean."""

    RAPID = 0
    LINEAR = 1
    CIRCLE_CW = 2
    CIRCLE_CCW = 3
    ARC_IN_SPACE = 303
    THREAD = 33
    TAPPING = 63
    TAPPING_IN = 331  # by a pitch
    TAPPING_OUT = 332


TAPPING = (Motion.TAPPING, Motion.TAPPING_IN, Motion.TAPPING_OUT)


class Plane(IntEnum):
    """The plane of circles, by its G function."""

    XY = 17
    ZX = 18
    YZ = 19


# The axes of a plane, first and second by the right-hand rule: indices of main axes.
PLANE_AXES = {Plane.XY: (0, 1), Plane.ZX: (2, 0), Plane.YZ: (1, 2)}


class FeedMode(IntEnum):
    """What F means, by its G function."""

    TIME = 93  # s per block
    PER_MINUTE = 94
    PER_REVOLUTION = 95
    PERCENT = 194  # of the greatest axis velocity


@dataclass(slots=True)
class ModalState:
    """The initial state of the manual (lines 2119–2121 and the entries of the functions).

    No path condition is marked as initial there; G01 is taken, since it moves nothing as long as no feed is programmed.
    `feeds` keeps the last F of each mode, in mm/min, s, mm/rev or percent.
    """

    motion: Motion = Motion.LINEAR
    plane: Plane = Plane.XY
    inch: bool = False
    incremental: bool = False
    mirror: int = 20  # G20…G23
    zero_offset: int = 0  # index of the data set: 0 G53, 1 G54 …
    layer: int = 0  # number of the coordinate system that it belongs to
    centre_absolute: bool = False
    centre_correction: bool = True  # G165
    feed_mode: FeedMode = FeedMode.PER_MINUTE
    feeds: dict[FeedMode, float] = field(default_factory=dict)
    radius: float | None = None  # mm, of circles by radius; negative for the longer arc
    centre: dict[int, float] = field(default_factory=dict)  # I 0, J 1, K 2 that hold on, mm (P-CHAN-00159)
    speed: float = 0.0  # rev/min of the main spindle
    diameter: bool = False  # G51, G52
    exact_stop: bool = False  # G360, G359
    contouring: bool = False  # G261, G260
    feeds_forward: bool = False  # G135, G137
    feed_forward: tuple[float, ...] = ()  # G136: a share per axis, () is 1 for all of them
    corner_size: float | None = None  # I of G301 and G302, mm
    compensation_side: int = 0  # G40 0, G41 1, G42 -1
    approach: Approach = Approach.INDIRECT
    compensation: CompensationSettings = field(default_factory=CompensationSettings)

    @property
    def feed(self) -> float | None:
        """F of the active mode, None as long as none is programmed."""
        return self.feeds.get(self.feed_mode)

    @feed.setter
    def feed(self, value: float | None) -> None:
        if value is None:
            self.feeds.pop(self.feed_mode, None)
        else:
            self.feeds[self.feed_mode] = value

    def copy(self) -> ModalState:
        """A copy of its own."""
        names = self.__slots__
        made = ModalState(**{name: getattr(self, name) for name in names})
        made.feeds = dict(self.feeds)
        made.centre = dict(self.centre)
        return made
