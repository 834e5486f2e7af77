"""Homing by a reference cam: fast to the cam, slowly off it, and where it is left the axis has its reference.

    SEARCH  fast to the cam, brake         (left out if the axis stands on it)
    LEAVE   slowly off the cam; the place where it is left is the reference
    RETURN  to the position of the reference

The motion counts in the coordinates of before; with the reference they are shifted as a whole, actual and commanded position by
the same way, so that no axis jumps.
"""

from __future__ import annotations

from enum import Enum, auto

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.single_axis import SingleAxis
from runtime.config.machine import Axis, HomingSetup

DEFAULT_WAY = 2000.0  # mm, degrees: greatest way, where neither the homing nor the software limits tell


class HomingPhase(Enum):
    """What an axis does for its reference."""

    NONE = auto()
    SEARCH = auto()
    BRAKE = auto()
    LEAVE = auto()
    REST = auto()
    RETURN = auto()
    DONE = auto()
    FAILED = auto()  # no cam, or no end of it, on the greatest way


class AxisHoming:
    """`motion` is that of the manual axis: the way beside the path. `begin`, then `step` in every cycle until `over`."""

    def __init__(self, axis: Axis, motion: SingleAxis) -> None:
        self.phase = HomingPhase.NONE
        self._axis = axis
        self._motion = motion
        self._start = 0.0
        self._found = 0.0

    @property
    def setup(self) -> HomingSetup | None:
        """How the axis is homed; None: it has an absolute encoder and its reference always."""
        return self._axis.homing

    @property
    def over(self) -> bool:
        """Nothing is done any more."""
        return self.phase in (HomingPhase.NONE, HomingPhase.DONE, HomingPhase.FAILED)

    @property
    def way(self) -> float:
        """The greatest way in one direction."""
        axis, setup = self._axis, self.setup
        assert setup is not None
        if setup.way is not None:
            return setup.way
        if axis.position_min is None or axis.position_max is None:
            return DEFAULT_WAY
        return 1.1 * (axis.position_max - axis.position_min)

    def begin(self, cam: bool) -> None:
        """Start; `cam`: the axis stands on it."""
        if self.setup is None:
            self.phase = HomingPhase.DONE
            return
        self._motion.set_limits(-float("inf"), float("inf"))
        self.phase = HomingPhase.BRAKE if cam else HomingPhase.SEARCH
        self._start = self._motion.position
        if not cam:
            self._run(self._sign * self.setup.fast)

    def cancel(self) -> None:
        """Brake and forget it."""
        self._motion.stop()
        self.phase = HomingPhase.NONE

    @property
    def _sign(self) -> float:
        assert self.setup is not None
        return 1.0 if self.setup.direction == "positive" else -1.0

    def _run(self, velocity: float) -> None:
        self._motion.move_at(velocity)

    def step(self, cam: bool, actual: float, path: float, override: float, hold: bool) -> float:
        """One cycle; `actual`: measured position, `path`: where the path has put the axis, both mm or degrees.

        The way by which the coordinates of the axis shift in this cycle, 0 in every cycle but one.
        """
        motion, setup = self._motion, self.setup
        if self.over or setup is None:
            return 0.0
        motion.step(override, hold)
        shift = 0.0
        if self.phase in (HomingPhase.SEARCH, HomingPhase.LEAVE) and abs(motion.position - self._start) > self.way:
            motion.stop()
            self.phase = HomingPhase.FAILED
        elif self.phase is HomingPhase.SEARCH and cam:
            motion.stop()
            self.phase = HomingPhase.BRAKE
        elif self.phase is HomingPhase.BRAKE and motion.standstill:
            self._start = motion.position
            self._run(-self._sign * setup.slow)
            self.phase = HomingPhase.LEAVE
        elif self.phase is HomingPhase.LEAVE and not cam:
            self._found = actual
            motion.stop()
            self.phase = HomingPhase.REST
        elif self.phase is HomingPhase.REST and motion.standstill:
            shift = setup.position - self._found
            motion.restart(motion.position + shift)
            motion.move_to(setup.position - path, Dynamics(setup.fast, self._axis.acceleration, self._axis.jerk))
            self.phase = HomingPhase.RETURN
        elif self.phase is HomingPhase.RETURN and motion.arrived:
            self.phase = HomingPhase.DONE
        return shift
