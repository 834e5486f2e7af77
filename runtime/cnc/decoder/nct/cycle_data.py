"""What is modal of the drilling cycles: from the first hole to G80 or a path condition (programmer's manual lines 5072–5146)."""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from runtime.cnc.decoder.nct.execution import NctExecution


@dataclass(frozen=True, slots=True)
class Level:
    """R or Z as programmed, mm or degrees; `incremental`: R counts from the initial point, Z from R."""

    value: float
    incremental: bool


@dataclass(slots=True)
class CycleData:
    """Lengths in mm. `axis`: the drilling axis (channel index), -1 before the first hole. `initial`: its place in machine
    coordinates without the tool length that was in it, so that a new length lets the tool tip come back to
    the same height. `dwell`: P as programmed. `shift`: I, J, K by letter."""

    mode: bool = False  # from the code of a cycle to its end
    axis: int = -1
    initial: float = 0.0
    r: Level | None = None
    z: Level | None = None
    cut: float | None = None
    lift: float | None = None
    dwell: float | None = None
    shift: dict[str, float] = field(default_factory=dict)
    by_hand: tuple[int, int] | None = None  # hole and step of the block in work at which the operator moves the tool

    def clear(self) -> None:
        """G80, a path condition: nothing is stored."""
        self.mode = False
        self.axis = -1
        self.initial = 0.0
        self.r = self.z = None
        self.cut = self.lift = self.dwell = None
        self.shift = {}
        self.by_hand = None


def tool_length(x: NctExecution, axis: int) -> float:
    """The length compensation of an axis, mm."""
    return x.coordinates.length[axis]
