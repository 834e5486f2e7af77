"""What a simulated drive makes of cyclic position set-points: one target per SYNC, interpolated over the period 0x60C2.

    SYNC with a set-point      straight to it, in one period
    SYNC without one           it was lost: on with the velocity of before, three times in a row at most; then a fault
    no SYNC where one was due  the same once; then the drive stands still, because the master may have stopped its cycle

So a set-point that comes after a lost one finds the drive where it would have sent it, and asks for the motion of one period.
Whatever comes, the set-point never moves faster than 0x607F: what is missing then is made up for in the periods that follow.
"""

from __future__ import annotations

from typing import Final

LOST_IN_A_ROW: Final = 3  # set-points that are extrapolated while SYNCs come


class SetPoints:
    """In increments, unwrapped."""

    def __init__(self) -> None:
        self.limited = False  # the last step was as long as the velocity limit lets it be
        self._velocity = 0.0
        self._goal = 0.0
        self._fresh = False
        self._lost = 0
        self._free_runs = 0

    def take_over(self, position: float) -> None:
        """Begin to follow from where the motor stands."""
        self._goal, self._velocity, self._lost, self._free_runs = position, 0.0, 0, 0
        self._fresh = self.limited = False

    def receive(self) -> None:
        """A set-point has come."""
        self._fresh = True

    @property
    def starved(self) -> bool:
        """More set-points were lost in a row than can be made up for."""
        return self._lost > LOST_IN_A_ROW

    def next(self, command: float, target: float, dt: float, limit: float, *, synchronised: bool) -> float:
        """Where the command stands after `dt` s; `target`: the set-point received last, `limit`: increments/s.

        `synchronised`: a SYNC ends this period.
        """
        if self._fresh:
            self._fresh = False
            self._lost = self._free_runs = 0
            self._goal, self._velocity = target, (target - command) / dt
        elif synchronised:
            self._lost += 1
            self._goal += self._velocity * dt
        elif self._free_runs == 0 and not self._lost:
            self._free_runs = 1
            self._goal += self._velocity * dt
        else:
            self._velocity = 0.0
        longest = limit * dt
        step = self._goal - command
        self.limited = abs(step) > longest + 1.0
        if self.limited:
            step = max(-longest, min(longest, step))
            self._velocity = step / dt
        return command + step
