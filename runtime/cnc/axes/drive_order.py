"""An axis that its drive moves by velocity or torque: MC_TorqueControl and MC_MoveVelocityByDrive.

    RUNNING   the drive is in a velocity or a torque mode; the axis tracks it
    BRAKING   to rest on the ramp, with all the torque that the machine allows
    LEAVING   the drive goes back into its own mode; then the axis follows set-points again

A drive that has a torque mode (cyclic synchronous or profile torque) gets a torque, which the velocity limits
(`torque_governor`). For any other one the torque is the limit of a velocity loop in the drive. Either way the velocity passes the
one that is ordered for no longer than it takes to see it, whatever gives way; an axis that something drives on stops the machine.

Before a software limit the velocity falls so that the axis comes to rest there. Units: mm or degrees, and seconds; torques as
shares of the rated torque.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum, auto
from typing import Final

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.torque_governor import TorqueGovernor
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
TORQUE_MODES: Final = (DriveMode.CYCLIC_SYNCHRONOUS_TORQUE, DriveMode.PROFILE_TORQUE)
RUNAWAY: Final = 2.0  # times the velocity that is ordered, of an axis in a torque mode
RUNAWAY_TIME: Final = 0.1  # s
REST_TIME: Final = 1.0  # s beyond its ramp that an axis in a torque mode gets to come to rest


class DrivePhase(Enum):
    NONE = auto()
    RUNNING = auto()
    BRAKING = auto()
    LEAVING = auto()


@dataclass(frozen=True, slots=True)
class DriveAbilities:
    """What a drive does by itself, as the machine description says."""

    velocity_mode: DriveMode | None  # beside its own; None: none
    torque_mode: DriveMode | None  # the same; it tells its torque
    limits_torque: bool  # it takes a torque limit, and tells its torque
    most_torque: float = 1.0  # share of the rated torque, with which it may brake in a torque mode
    gain: float = 0.0  # of the velocity in a torque mode, share per mm/s or degree/s


class DriveOrder:
    """Of one axis, index `i` of the image. `begin`, then `step` in every cycle until `over`.

    `least`, `greatest`: software limits; `machine_limits` (n,): of the torque, by whoever else limits it.
    """

    def __init__(
        self,
        image: DriveImage,
        i: int,
        period: float,
        least: float,
        greatest: float,
        abilities: DriveAbilities,
        machine_limits: npt.NDArray[np.float64],
    ) -> None:
        self._image, self._i, self._period = image, i, period
        self._least, self._greatest = least, greatest
        self.abilities = abilities
        self._machine_limits = machine_limits
        self._governor = TorqueGovernor(abilities.gain, period)
        self.mode = DriveMode.CONFIGURED  # that is ordered while it runs and brakes
        self.phase = DrivePhase.NONE
        self.reached = False
        self.at_limit = False  # it stands at a software limit
        self.late = False  # the drive has not changed its mode in time
        self.runs_away = False  # its torque does not hold the axis
        self._direction = 1.0
        self._too_fast = 0.0  # s
        self._braking = 0.0  # s
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

    @property
    def speed(self) -> float:
        """As the encoder tells it, smoothed."""
        return abs(self._seen)

    @property
    def allowed(self) -> float:
        """The velocity that was ordered last; 0 while it brakes."""
        return 0.0 if self.phase is DrivePhase.BRAKING else abs(self._wanted)

    def mode_for(self, function: AxisFunction) -> DriveMode | None:
        """The mode in which the drive does it, None: it cannot."""
        abilities = self.abilities
        if function is not AxisFunction.TORQUE_CONTROL:
            return abilities.velocity_mode
        if abilities.torque_mode is not None:
            return abilities.torque_mode
        return abilities.velocity_mode if abilities.limits_torque else None

    def begin(self, job: Job, dynamics: Dynamics) -> None:
        """From rest, or on from what was ordered before."""
        image, i, before = self._image, self._i, self.mode
        mode = self.mode_for(job.function)
        assert mode is not None  # else it was refused
        self.mode = mode
        if self.phase is DrivePhase.NONE:
            self._velocity = self._seen = self._seen_torque = self._time = 0.0
            self._torque_now = 0.0
        elif mode is not before:
            self._velocity, self._time = self._seen, 0.0
            self._torque_now = self._seen_torque
        if self.phase is DrivePhase.NONE or mode is not before:
            self._governor.begin(float(image.actual_torque[i]))
        self.phase = DrivePhase.RUNNING
        self.reached = self.at_limit = self.late = self.runs_away = False
        self._resting = 0
        self._too_fast = self._braking = 0.0
        self._dynamics = dynamics
        negative = job.direction is Direction.NEGATIVE
        self._torque = None
        if job.function is AxisFunction.TORQUE_CONTROL:
            negative = negative is not (job.torque < 0.0)
            self._torque = abs(job.torque)
            self._ramp = job.torque_ramp or math.inf
        self._direction = -1.0 if negative else 1.0
        self._wanted = self._direction * job.velocity

    def brake(self, dynamics: Dynamics | None = None) -> None:
        """To rest, and back to the mode of the drive."""
        if self.phase is DrivePhase.RUNNING:
            self.phase = DrivePhase.BRAKING
            self._resting = 0
            self._braking = 0.0
        self._dynamics = dynamics or self._dynamics

    def forget(self) -> None:
        """The drive brakes by itself, or is off."""
        self.phase = DrivePhase.NONE
        self._order(DriveMode.CONFIGURED, 0.0, math.inf)

    def _order(self, mode: DriveMode, velocity: float, limit: float, torque: float = 0.0) -> None:
        image, i = self._image, self._i
        image.mode[i] = mode
        image.target_velocity[i] = velocity
        image.target_torque[i] = torque
        image.torque_limit[i] = min(limit, float(self._machine_limits[i]))

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
        runs = self.phase is DrivePhase.RUNNING and not hold
        wanted = self._wanted * override if runs else 0.0
        allowed = self._before_limit(wanted)
        self.at_limit = wanted != 0.0 and allowed == 0.0
        brakes = abs(allowed) < abs(wanted) or not runs
        if brakes and self._torque is not None:
            # What presses does not move: on the ramp from the velocity that it may have it would press on, and harder.
            most = max(abs(actual), abs(self._seen))
            self._velocity = max(-most, min(most, self._velocity))
        before = self._velocity
        self._ramp_velocity(allowed, hard=abs(allowed) < abs(wanted))
        self._ramp_torque()
        settled = image.mode_shown[i] == self.mode or not image.mode_shown[i]  # ideal drives show none
        if self.mode in TORQUE_MODES:
            slope = (self._velocity - before) / self._period if brakes else 0.0
            torque = self._governed(actual, slope, brakes=brakes) if settled else 0.0
            self._order(self.mode, self._velocity, math.inf, torque)
            self._watch_speed()
        else:
            self._order(self.mode, self._velocity, math.inf if brakes or self._torque is None else self._torque_now)
        self._time = 0.0 if settled else self._time + self._period
        self.late = self._time > MODE_TIME
        self._judge(wanted)
        if self.phase is DrivePhase.BRAKING and self._velocity == 0.0:
            self._resting = self._resting + 1 if abs(self._seen) * REACTION < self._smallest else 0
            if self._resting >= RESTING:
                self.phase, self._time = DrivePhase.LEAVING, 0.0

    def _governed(self, actual: float, slope: float, *, brakes: bool) -> float:
        """The torque that is ordered, or as much of it as the velocity allows."""
        most = min(self.abilities.most_torque, float(self._machine_limits[self._i]))
        ordered = most if brakes or self._torque is None else min(self._torque_now, most)
        return self._governor.step(self._velocity, actual, self._direction, ordered, most, slope)

    def _watch_speed(self) -> None:
        """In a torque mode something else may drive the axis on."""
        if self.phase is DrivePhase.BRAKING and self._velocity == 0.0:
            self._braking += self._period
        fast = abs(self._seen) > RUNAWAY * max(abs(self._velocity), abs(self._wanted))
        self._too_fast = self._too_fast + self._period if fast else 0.0
        self.runs_away = self._too_fast > RUNAWAY_TIME or self._braking > REST_TIME

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
