"""An axis that its drive moves by velocity, with a torque limit or without: MC_TorqueControl and MC_MoveVelocityByDrive.

    RUNNING   the drive is in a velocity mode and gets the ramped velocity; the axis tracks it
    BRAKING   to rest on the ramp, with all the torque that the machine allows
    LEAVING   the drive goes back into its own mode; then the axis follows set-points again

A torque is given as the limit of a velocity loop. So the velocity never passes the one that is ordered, in every drive and
whatever gives way: a drive in a torque mode runs away there until its own limit, which makers put into different objects.

Before a software limit the velocity falls so that the axis comes to rest there. Units: mm or degrees, and seconds; torques as
shares of the rated torque.
"""

from __future__ import annotations

import math
from enum import Enum, auto
from typing import Final

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.drives import DriveImage, DriveMode
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction, Direction

REACTION: Final = 0.03  # s from an order to what the drive does of it
SMOOTHING: Final = 0.1  # share of a new value: an encoder tells velocities in steps
NEAR: Final = 0.05  # share of what is ordered, and of the rated torque
CREEP: Final = 5e-3  # share of the velocity, below which the axis stops in front of a limit
RESTING: Final = 20  # cycles at rest until the drive leaves its mode
MODE_TIME: Final = 1.5  # s that a drive gets to change its mode; the bus tells it before
VELOCITY_MODES: Final = (DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY, DriveMode.PROFILE_VELOCITY)


class DrivePhase(Enum):
    NONE = auto()
    RUNNING = auto()
    BRAKING = auto()
    LEAVING = auto()


class DriveOrder:
    """Of one axis, index `i` of the image. `begin`, then `step` in every cycle until `over`.

    `mode`: the velocity mode that the drive offers beside its own, None without one; `limits_torque`: it takes a torque limit.
    `machine_limits` (n,): of the torque, by whoever else limits it.
    """

    def __init__(
        self,
        image: DriveImage,
        i: int,
        period: float,
        least: float,
        greatest: float,
        *,
        mode: DriveMode | None,
        limits_torque: bool,
        machine_limits: npt.NDArray[np.float64],
    ) -> None:
        self._image, self._i, self._period = image, i, period
        self._least, self._greatest = least, greatest
        self.mode = mode
        self.limits_torque = limits_torque
        self._machine_limits = machine_limits
        self.phase = DrivePhase.NONE
        self.reached = False
        self.at_limit = False  # it stands at a software limit
        self.late = False  # the drive has not changed its mode in time
        self._velocity = 0.0  # ordered in this cycle
        self._wanted = 0.0
        self._torque: float | None = None  # None: as the machine allows
        self._torque_now = math.inf
        self._ramp = math.inf  # of the torque, 1/s
        self._dynamics = Dynamics(1.0, 1.0, 1.0)
        self._seen = 0.0  # velocity, smoothed
        self._seen_torque = 0.0
        self._resting = 0
        self._time = 0.0  # s that the drive is not in its mode

    @property
    def over(self) -> bool:
        """The drive follows set-points again, or never left them."""
        return self.phase is DrivePhase.NONE

    def begin(self, job: Job, dynamics: Dynamics) -> None:
        """From rest, or on from what was ordered before."""
        if self.phase is DrivePhase.NONE:
            self._velocity = self._seen = self._seen_torque = self._time = 0.0
            self._torque_now = 0.0
        self.phase = DrivePhase.RUNNING
        self.reached = self.at_limit = self.late = False
        self._resting = 0
        self._dynamics = dynamics
        negative = job.direction is Direction.NEGATIVE
        self._torque = None
        if job.function is AxisFunction.TORQUE_CONTROL:
            negative = negative is not (job.torque < 0.0)
            self._torque = abs(job.torque)
            self._ramp = job.torque_ramp or math.inf
        self._wanted = -job.velocity if negative else job.velocity

    def brake(self, dynamics: Dynamics | None = None) -> None:
        """To rest, and back to the mode of the drive."""
        if self.phase is DrivePhase.RUNNING:
            self.phase = DrivePhase.BRAKING
            self._resting = 0
        self._dynamics = dynamics or self._dynamics

    def forget(self) -> None:
        """The drive brakes by itself, or is off."""
        self.phase = DrivePhase.NONE
        self._order(DriveMode.CONFIGURED, 0.0, math.inf)

    def _order(self, mode: DriveMode, velocity: float, torque: float) -> None:
        image, i = self._image, self._i
        image.mode[i] = mode
        image.target_velocity[i] = velocity
        image.torque_limit[i] = min(torque, float(self._machine_limits[i]))

    def step(self, override: float, hold: bool) -> None:
        """One cycle."""
        image, i = self._image, self._i
        actual = float(image.actual_velocity[i])
        self._seen += SMOOTHING * (actual - self._seen)
        self._seen_torque += SMOOTHING * (abs(float(image.actual_torque[i])) - self._seen_torque)
        if self.phase is DrivePhase.LEAVING:
            self._order(DriveMode.CONFIGURED, 0.0, math.inf)
            self._time += self._period
            if not image.by_drive[i] or self._time > MODE_TIME:
                self.phase = DrivePhase.NONE
            return
        assert self.mode is not None
        runs = self.phase is DrivePhase.RUNNING and not hold
        wanted = self._wanted * override if runs else 0.0
        allowed = self._before_limit(wanted)
        self.at_limit = wanted != 0.0 and allowed == 0.0
        brakes = abs(allowed) < abs(wanted) or not runs
        self._ramp_velocity(allowed, hard=abs(allowed) < abs(wanted))
        self._ramp_torque()
        self._order(self.mode, self._velocity, math.inf if brakes or self._torque is None else self._torque_now)
        settled = image.mode_shown[i] == self.mode or not image.mode_shown[i]  # ideal drives show none
        self._time = 0.0 if settled else self._time + self._period
        self.late = self._time > MODE_TIME
        self._judge(wanted)
        if self.phase is DrivePhase.BRAKING and self._velocity == 0.0:
            self._resting = self._resting + 1 if abs(self._seen) * REACTION < self._smallest else 0
            if self._resting >= RESTING:
                self.phase, self._time = DrivePhase.LEAVING, 0.0

    @property
    def _slower(self) -> float:
        """The deceleration."""
        return self._dynamics.deceleration or self._dynamics.acceleration

    @property
    def _smallest(self) -> float:
        """A velocity that brings the axis no further than this in the time of reaction is rest."""
        return 1e-3 * self._dynamics.velocity * REACTION

    def _judge(self, wanted: float) -> None:
        if self._torque is not None:
            self.reached = (
                self._torque_now >= self._torque and abs(self._seen_torque - self._torque) <= NEAR * max(self._torque, 1.0)
            )  # fmt: skip
            return
        self.reached = (
            wanted != 0.0 and self._velocity == wanted and abs(self._seen - wanted) <= NEAR * abs(wanted)
        )  # fmt: skip

    def _before_limit(self, wanted: float) -> float:
        """The velocity from which the axis still comes to rest in front of its software limit."""
        place = float(self._image.actual_position[self._i])
        way = self._greatest - place if wanted > 0.0 else place - self._least
        if wanted == 0.0 or math.isinf(way):
            return wanted
        if way <= 0.0:
            return 0.0
        # rest on the ramp from v, after v * REACTION: v² / 2d + v * REACTION = way
        slow = self._slower
        most = slow * (math.sqrt(REACTION * REACTION + 2.0 * way / slow) - REACTION)
        if most < CREEP * self._dynamics.velocity:
            return 0.0
        return math.copysign(min(abs(wanted), most), wanted)

    def _ramp_velocity(self, wanted: float, *, hard: bool) -> None:
        """`hard`: at once, as `wanted` is on the ramp already."""
        change = wanted - self._velocity
        slower = self._velocity * change < 0.0
        if hard and slower and self._velocity * wanted >= 0.0:
            self._velocity = wanted
            return
        rate = self._slower if slower else self._dynamics.acceleration
        most = rate * self._period
        self._velocity = wanted if abs(change) <= most else self._velocity + math.copysign(most, change)

    def _ramp_torque(self) -> None:
        wanted = math.inf if self._torque is None else self._torque
        if math.isinf(self._ramp) or math.isinf(wanted):
            self._torque_now = wanted
            return
        before = 0.0 if math.isinf(self._torque_now) else self._torque_now
        most = self._ramp * self._period
        self._torque_now = wanted if abs(wanted - before) <= most else before + math.copysign(most, wanted - before)
