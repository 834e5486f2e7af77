"""What a program has selected of the smoothing methods: travels as small blocks to the stages of the path preparation."""

from __future__ import annotations

from dataclasses import dataclass, field

from runtime.cnc.blocks import Contouring


@dataclass(slots=True)
class Smoothing:
    """State of a program: settings last until they are programmed anew, also while their method is off."""

    contouring: Contouring = field(default_factory=Contouring)
    contouring_on: bool = False
    own_track_distance: bool = False  # TRACK_DIST was programmed; until then it is PATH_DIST
