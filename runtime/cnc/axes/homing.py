"""Homing by the drive (mode 6), or by a reference cam: fast to it, slowly off it, and where it is left there is the reference.

    SEARCH  fast to the cam, brake         (left out if the axis stands on it)
    LEAVE   slowly off the cam; the place where it is left is the reference
    RETURN  to the position of the reference

    DRIVE     the drive homes by itself, the axis tracks it; then RETURN. STOPPING: it was told to stop, and brakes

The motion counts in the coordinates of before; with the reference they are shifted as a whole, actual and commanded position by
the same way, so that no axis jumps.
"""

from __future__ import annotations

from enum import Enum, auto

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.single_axis import SingleAxis
from runtime.config.machine import Axis, HomingSetup
from runtime.drives import DriveImage, HomingState

DEFAULT_WAY = 2000.0  # mm, degrees: greatest way, where neither the homing nor the software limits tell


class HomingPhase(Enum):
    """What an axis does for its reference."""

    NONE = auto()
    DRIVE = auto()
    STOPPING = auto()
    SEARCH = auto()
    BRAKE = auto()
    LEAVE = auto()
    REST = auto()
    RETURN = auto()
    DONE = auto()
    FAILED = auto()  # no cam, or no end of it, on the greatest way; the drive has told an error
    LATE = auto()  # the drive has not found it in its time


class HomingDrive:
    """What homing has to do with the drive of one axis, index `i` of the image."""

    def __init__(self, image: DriveImage, i: int) -> None:
        self._image, self._i = image, i

    def request(self, wanted: bool, *, hold: bool = False) -> None:
        """Home, or stop it; `hold`: stand still meanwhile."""
        self._image.homing_request[self._i] = wanted
        self._image.halt[self._i] = wanted and hold

    @property
    def state(self) -> HomingState:
        return HomingState(int(self._image.homing_state[self._i]))

    @property
    def moves_by_itself(self) -> bool:
        return bool(self._image.by_drive[self._i])


class AxisHoming:
    """`motion` is that of the manual axis: the way beside the path. `begin`, then `step` in every cycle until `over`."""

    def __init__(self, axis: Axis, motion: SingleAxis, drive: HomingDrive, period: float) -> None:
        self.phase = HomingPhase.NONE
        self._drive = drive
        self._period = period
        self._time = 0.0  # s that the drive has been homing
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
        return self.phase in (HomingPhase.NONE, HomingPhase.DONE, HomingPhase.FAILED, HomingPhase.LATE)

    @property
    def by_drive(self) -> bool:
        """The drive looks for the reference, so no cam is needed."""
        return self.setup is not None and self.setup.method is not None

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
        if self.by_drive:
            self.phase, self._time = HomingPhase.DRIVE, 0.0
            self._drive.request(True)
            return
        self.phase = HomingPhase.BRAKE if cam else HomingPhase.SEARCH
        self._start = self._motion.position
        if not cam:
            self._run(self._sign * self.setup.fast)

    def cancel(self) -> None:
        """Brake and forget it. A drive that homes brakes by itself, and the axis tracks it until it stands."""
        if self.phase is HomingPhase.DRIVE:
            self._drive.request(False)
            self.phase = HomingPhase.STOPPING
            return
        if self.phase is HomingPhase.STOPPING:
            return
        self._motion.stop()
        self.phase = HomingPhase.NONE

    def forget(self) -> None:
        """Somebody else says where the axis goes; a drive that homes brakes by itself."""
        self._drive.request(False)
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
        if self.phase in (HomingPhase.DRIVE, HomingPhase.STOPPING):
            self._track(setup, actual, path, hold)
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

    def _track(self, setup: HomingSetup, actual: float, path: float, hold: bool) -> None:
        """One cycle of a drive that moves by itself: the axis is where the drive is."""
        motion, drive = self._motion, self._drive
        motion.restart(actual - path)
        state = drive.state
        if self.phase is HomingPhase.STOPPING:
            if not drive.moves_by_itself and state is not HomingState.STOPPING:
                self.phase = HomingPhase.NONE
            return
        drive.request(True, hold=hold)
        self._time += 0.0 if hold else self._period
        if state is HomingState.DONE and not drive.moves_by_itself:
            drive.request(False)
            motion.move_to(setup.position - path, Dynamics(setup.fast, self._axis.acceleration, self._axis.jerk))
            self.phase = HomingPhase.RETURN
        elif state is HomingState.FAILED:
            drive.request(False)
            self.phase = HomingPhase.FAILED
        elif self._time > setup.timeout:
            self.cancel()
            self.phase = HomingPhase.LATE
