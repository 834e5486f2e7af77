"""What a program has read from compensation registers, and for whom."""

from __future__ import annotations

from dataclasses import dataclass


@dataclass(slots=True)
class UsedRegisters:
    """What was read. `length_axes`: those of the last G43 or G44."""

    h_number: int = 0
    d_number: int = 0
    length: float = 0.0  # of the last H, mm
    length_sign: float = 0.0  # 1 G43, -1 G44, 0 G49
    length_axes: tuple[int, ...] = ()
    offset_number: int = 0  # D that G45 to G48 have used, 0: none
