"""Homing of an axis by the two drives at its ends: each looks for its own reference, and then the axis is square.

    both show the homing mode ─▶ both begin in the same cycle ─▶ the one that has its reference first holds its place
    ─▶ the other one has it too ─▶ from then on the offset of the second end is `square`, and both follow the axis

Meanwhile each drive begins to count anew, in a cycle of its own. So the ends are compared by the ways that they go from the
begin on, with the difference that they had there. Too great a difference stops both, as does an error of one of them; what is
left of it then stays in the offset: an axis that was not squared is not forgotten to be skewed.

The way of the cycle in which a drive begins to count anew is not known, that of the cycle before stands for it. A count that
changes by less than a cycle's way at twice the homing speed is not noticed, and makes the difference wrong by no more.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final, Protocol

from runtime.drives import HomingState

FASTEST: Final = 2.0  # times the homing speed: further than this in a cycle no end goes


class End(Protocol):
    """What is looked at of each end."""

    homing: HomingState  # of its own drive
    homing_error: bool  # it tells one, and brakes
    by_drive: bool
    place: float


@dataclass(slots=True)
class Squaring:
    """Of one axis. `limit`: of the difference; `square`: second minus first end after homing, when the axis is square;
    `speed`: the faster one of homing; units, and seconds."""

    limit: float
    square: float
    speed: float
    state: HomingState = HomingState.IDLE  # of both together
    watches: bool = False  # the ends are compared by their ways
    skew: float = 0.0  # units, second minus first
    _before: dict[bool, float] = field(default_factory=lambda: {False: 0.0, True: 0.0})  # way in the last cycle

    def step(self, requested: bool, first: End, second: End, offset: float) -> float:
        """Once per cycle, before either end is ordered anything; the offset of the second end from now on."""
        match self.state:
            case HomingState.IDLE:
                if requested:
                    self.state, self.watches = HomingState.RUNNING, True
                    self.skew = second.place - first.place - offset
                    self._before[False] = self._before[True] = 0.0
                return offset
            case HomingState.RUNNING:
                states = first.homing, second.homing
                failed = first.homing_error or second.homing_error or HomingState.FAILED in states
                if not requested:
                    self.state = HomingState.STOPPING
                elif failed or abs(self.skew) > self.limit:
                    self.state = HomingState.FAILED
                elif states == (HomingState.DONE, HomingState.DONE) and not first.by_drive and not second.by_drive:
                    self.state, self.watches = HomingState.DONE, False
                    return self.square
                return offset
            case _:
                if self.watches and not first.by_drive and not second.by_drive:
                    self.watches = False
                    offset = second.place - first.place - self.skew
                if not requested and not self.watches:
                    self.state = HomingState.IDLE
                return offset

    @property
    def wanted(self) -> bool:
        """Each end shall home, or keep what it has found."""
        return self.state in (HomingState.RUNNING, HomingState.DONE)

    def went(self, second: bool, way: float, farthest: float) -> None:
        """An end has gone a way, as its drive counts; further than `farthest` only if it has begun to count anew."""
        if not self.watches:
            return
        if abs(way) > farthest:
            way = self._before[second]
        self._before[second] = way
        self.skew += way if second else -way
