"""An axis with a drive at each end: both get the same set-point, and stop together.

joint state      enabled only if both are; in fault or lost if one is
set-point        of the second end: that of the axis + offset, and what is left of the difference at enabling, which is
                 taken away slowly, so that enabling moves neither end
difference       beyond its limit the axis stops and is not enabled again; at twice the limit the drives brake by themselves
homing           each end by its own drive (runtime.fieldbus.squaring); the first one that is there waits for the other
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Final

from runtime.drives import DriveState, HomingState
from runtime.fieldbus.squaring import FASTEST, Squaring

ALIGNING_TIME: Final = 2.0  # s in which a difference as large as its limit is taken away
FAR: Final = 2.0  # times the limit
_WORST: Final = (
    DriveState.OFFLINE,
    DriveState.FAULT_REACTION_ACTIVE,
    DriveState.FAULT,
    DriveState.QUICK_STOP_ACTIVE,
    DriveState.NOT_READY_TO_SWITCH_ON,
    DriveState.SWITCH_ON_DISABLED,
    DriveState.READY_TO_SWITCH_ON,
    DriveState.SWITCHED_ON,
    DriveState.OPERATION_ENABLED,
)
_RANK: Final = {state: k for k, state in enumerate(_WORST)}
_UNFIT: Final = frozenset(
    (DriveState.OFFLINE, DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT, DriveState.QUICK_STOP_ACTIVE)
)


@dataclass(slots=True, eq=False)
class GantryEnd:
    """One end. `limit`: of the difference, units; `offset`: of the second end, None: as both stand at the start.

    `squaring`: of an axis whose drives home; its offset counts from then on, and until then both are taken as they stand.
    """

    second: bool
    limit: float
    period: float
    offset: float | None = None
    squaring: Squaring | None = None
    other: GantryEnd = field(init=False)
    state: DriveState = DriveState.OFFLINE
    place: float = 0.0  # units, as the drive counts
    by_drive: bool = False  # its drive moves it by itself
    homing: HomingState = HomingState.IDLE  # of its drive
    homing_error: bool = False
    ready: bool = False  # to begin with homing
    _begun: bool = False
    _told: bool = False
    _left: float = 0.0  # of the difference at enabling

    @staticmethod
    def pair(
        limit: float, period: float, offset: float | None, homing_speed: float | None = None
    ) -> tuple[GantryEnd, GantryEnd]:
        """Both ends. `homing_speed`: the faster one, units/s, of an axis whose drives home; None: they do not."""
        squaring = None
        if homing_speed is not None:
            squaring = Squaring(limit, offset or 0.0, homing_speed)
            offset = None
        first, second = (GantryEnd(number, limit, period, offset, squaring) for number in (False, True))
        first.other, second.other = second, first
        return first, second

    def begin(self, place: float) -> None:
        """The drive stands here; the first drive is asked first."""
        # One that comes back where it was still counts as before; else both are taken as they stand, until they are homed.
        anew = self.squaring is not None and (not self._begun or abs(place - self.place) > self.limit)
        self.place = place
        self._begun = True
        self.state = DriveState.SWITCH_ON_DISABLED
        second, first = (self, self.other) if self.second else (self.other, self)
        if first._begun and second._begun and (second.offset is None or anew):
            second.offset = second.place - first.place

    @property
    def difference(self) -> float:
        """Second end minus first, units; 0 as long as the offset is not known."""
        second, first = (self, self.other) if self.second else (self.other, self)
        if self.squaring is not None and self.squaring.watches:
            return self.squaring.skew
        return 0.0 if second.offset is None else second.place - first.place - second.offset

    def goes_to(self, place: float, cycles: int, increments_per_unit: float) -> None:
        """What came after so many cycles, units."""
        if self.squaring is not None:
            farthest = FASTEST * self.squaring.speed * self.period * cycles + 2.0 / increments_per_unit
            self.squaring.went(self.second, place - self.place, farthest)
        self.place = place

    def homes(self, requested: bool) -> bool:
        """Whether this end shall home, if the axis shall; the first end is asked first."""
        squaring = self.squaring
        if squaring is None:
            return requested
        second = self.other
        if not self.second and second.offset is not None:
            second.offset = squaring.step(requested, self, second, second.offset)
        return squaring.wanted

    @property
    def waits(self) -> bool:
        """The drives home, and this one is not under way, so it holds its place."""
        return self.squaring is not None and self.squaring.watches and not self.by_drive

    @property
    def joint_state(self) -> DriveState:
        return min(self.state, self.other.state, key=_RANK.__getitem__)

    @property
    def both_enabled(self) -> bool:
        return self.state is self.other.state is DriveState.OPERATION_ENABLED

    def found_skewed(self) -> bool:
        """The difference is beyond its limit, and was not before."""
        skewed = abs(self.difference) > self.limit
        found = skewed and not self._told and self.both_enabled
        self._told = skewed and (self._told or found)
        return found

    def orders(self, enable: bool, quick_stop: bool, state: DriveState) -> tuple[bool, bool]:
        """Enable and quick stop of this end, given those of the axis."""
        apart = abs(self.difference)
        if state is DriveState.OPERATION_ENABLED:
            return enable, quick_stop or self.other.state in _UNFIT or apart > FAR * self.limit
        return enable and self.other.state not in _UNFIT and apart <= self.limit, quick_stop

    def own(self, target: float, *, stand_still: bool, here: float) -> float:
        """The set-point of the second end for that of the axis; `stand_still`: it begins to follow, from `here`."""
        goal = target + (self.offset or 0.0)
        if stand_still:
            self._left = here - goal
        step = self.limit * self.period / ALIGNING_TIME
        self._left = max(self._left - step, 0.0) if self._left > 0.0 else min(self._left + step, 0.0)
        return goal + self._left
