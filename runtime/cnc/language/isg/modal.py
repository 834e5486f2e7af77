"""The modal state of a channel: what G functions and modal words have set, and what holds at program start."""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum


class Motion(IntEnum):
    """The path condition: what axis words mean."""

    RAPID = 0
    LINEAR = 1
    CIRCLE_CW = 2
    CIRCLE_CCW = 3


class Plane(IntEnum):
    """The plane of circles, by its G function."""

    XY = 17
    ZX = 18
    YZ = 19


@dataclass(slots=True)
class ModalState:
    """The initial state of the manual (lines 2119–2121 and the entries of the functions).

    No path condition is marked as initial there; G01 is taken, since it moves nothing as long as no feed is programmed.
    """

    motion: Motion = Motion.LINEAR
    plane: Plane = Plane.XY
    inch: bool = False
    incremental: bool = False
    zero_offset: int = 53  # G53 none, 54 to 59
    centre_absolute: bool = False
    feed: float | None = None  # mm/min, None as long as none is programmed
    radius: float | None = None  # mm, of circles by radius; negative for the longer arc
    speed: float = 0.0  # rev/min of the main spindle
