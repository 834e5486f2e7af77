"""What a running program keeps of measuring; `cnc/decoder/measuring.py` says what it means."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field

from runtime.cnc.decoder.measuring_setup import AxisProbe


@dataclass(frozen=True, slots=True)
class Measured:
    """Of an axis: the measured coordinate in the active system, and minus the target; mm or degrees."""

    in_system: float
    offset: float


@dataclass(frozen=True, slots=True)
class Run:
    """A measuring run whose end the decoder waits for: its axes, where it begins and leads to, as the decoder counts."""

    axes: tuple[int, ...]
    start: list[float]
    end: list[float]
    column: int
    interrupts: bool = False  # G310
    jump: Callable[[], None] | None = None  # of G310: where the program goes on behind a signal


@dataclass(slots=True)
class MeasuringState:
    """What holds for the measuring blocks of a program, and what they have found. Columns in the block in work, 0 without:
    `column` of G100 or G310, `through_column` of G106, `interrupts_column` of G310."""

    type: int
    probes: list[AxisProbe | None]
    signal_needed: bool | None = None  # ERR_NO_SIGNAL, None: as the channel is configured
    column: int = 0
    through_column: int = 0
    interrupts_column: int = 0
    pending: Run | None = None
    values: dict[int, Measured] = field(default_factory=dict)
    programmed: dict[int, float] = field(default_factory=dict)  # measured points as they would be programmed
    places: dict[int, float] = field(default_factory=dict)  # measured machine coordinates
    turned: set[int] = field(default_factory=set)  # axes whose values are those of a rotated coordinate system
    done: set[int] = field(default_factory=set)  # axes of V.A.MERF
    included: dict[int, float] = field(default_factory=dict)  # G101: what was taken into the coordinates, mm or degrees

    def begin_block(self) -> None:
        self.column = self.through_column = self.interrupts_column = 0
