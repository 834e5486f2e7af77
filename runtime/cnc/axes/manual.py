"""An axis moved by hand: a key pair or a handwheel, and the way it goes beside the path.

The position of this motion is an offset: what the axis is away from where the path has put it. With G200 the path stands and the
axis has all its dynamics; with G201 the path goes on and the hand has its share of them (`MANUAL_SHARE`), so that both together
never ask too much.

A key that was pressed before the axis was released moves nothing: it has to be let go first.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

from runtime.cnc.axes.axis_plan import Dynamics
from runtime.cnc.axes.single_axis import SingleAxis
from runtime.cnc.blocks import MANUAL_SHARE
from runtime.config.machine import Axis
from runtime.hli.layout import Blocked, ManualMode, ManualState

STAGES = 4  # parameter sets: 0 of the control units, 1 to 3 of the program
WHEEL_AHEAD = 0.2  # s of full speed that the axis may be behind its handwheel; what is turned beyond is dropped
JOG_SHARE = 0.1  # of the axis' velocity, where the machine description names none
WIDTH = 1.0  # mm, degrees: increment at start
RESOLUTION = 0.01  # mm, degrees per pulse of a handwheel at start


@dataclass(slots=True)
class Stage:
    """A parameter set: mm or degrees, and seconds."""

    resolution: float
    velocity: float  # continuous
    width: float
    step_velocity: float  # incremental


@dataclass(slots=True)
class HandInputs:
    """What is asked of one axis in this cycle. `direction`: of its key pair; `pulses`: of its handwheel."""

    direction: int = 0
    pulses: int = 0
    override: float = 1.0
    hold: bool = False
    blocked: int = 0  # Blocked


class ManualAxis:
    """State in, state out: `release`, `link`, `step` in every cycle, `close`."""

    def __init__(self, axis: Axis, period: float, number: int) -> None:
        """`number`: of the key pair that is linked at first."""
        limits = Dynamics(axis.velocity, axis.acceleration, axis.jerk)
        self.motion = SingleAxis(limits, period)
        jog = axis.velocity * JOG_SHARE if axis.jog_velocity is None else axis.jog_velocity
        self.stages = [Stage(RESOLUTION, jog, WIDTH, jog) for _ in range(STAGES)]
        self.mode = ManualMode.CONTINUOUS
        self.element = number
        self.stage = self.stages[0]
        self.exclusive = False
        self.released = False
        self.relative = (-math.inf, math.inf)  # limits of the offset, counted from where it was released
        self._limits = limits
        self._hand = limits
        self._armed = False
        self._direction = 0
        self._wheel = 0.0
        self._wheel_override = False

    # ------------------------------------------------------------------ orders

    def release(self, *, exclusive: bool) -> None:
        """From now on the hand moves the axis."""
        self.released, self.exclusive = True, exclusive
        share = 1.0 if exclusive else MANUAL_SHARE
        limits = self._limits
        self._hand = Dynamics(limits.velocity * share, limits.acceleration * share, limits.jerk * share)
        self._disarm()

    def close(self, *, at_once: bool) -> None:
        """The hand moves it no longer; a way that was begun is finished unless `at_once`."""
        self.released = False
        if at_once or self.mode is ManualMode.CONTINUOUS:
            self.motion.stop(self._hand)
        self._disarm()

    def link(self, mode: ManualMode, element: int, stage: int) -> None:
        """Another element, mode or parameter set; 0 takes the element away. What moves, stops."""
        self.mode, self.element, self.stage = mode, element, self.stages[stage]
        if not self.motion.standstill:
            self.motion.stop(self._hand)
        self._disarm()

    def restart(self, offset: float = 0.0) -> None:
        """At rest with this offset: the path has taken the rest over, or the axis stands somewhere else."""
        self.motion.restart(offset)
        self._disarm()

    def _disarm(self) -> None:
        self._armed = False
        self._direction = 0
        self._wheel = self.motion.position

    # ------------------------------------------------------------------ the cycle

    def step(self, inputs: HandInputs, least: float, greatest: float) -> None:
        """One cycle; `least`, `greatest` bound the offset."""
        motion = self.motion
        if (least, greatest) != motion.bounds:
            motion.set_limits(least, greatest)
        wish = 0
        if self.released and self.element:
            wish = self._turned(inputs.pulses) if self.mode is ManualMode.HANDWHEEL else self._pressed(inputs.direction)
        away = math.copysign(1.0, motion.target - motion.position) if motion.moves_to_target else wish
        blocked = (away > 0 and inputs.blocked & Blocked.PLUS) or (away < 0 and inputs.blocked & Blocked.MINUS)
        motion.step(inputs.override, inputs.hold or bool(blocked))

    def _pressed(self, direction: int) -> int:
        if not self._armed:
            self._armed = direction == 0
            return 0
        before, self._direction = self._direction, direction
        motion, stage = self.motion, self.stage
        if self.mode is ManualMode.CONTINUOUS:
            if direction != before:
                if direction:
                    motion.move_at(direction * min(stage.velocity, self._hand.velocity), self._hand)
                else:
                    motion.stop(self._hand)
        elif direction and not before and motion.standstill:
            way = Dynamics(stage.step_velocity, self._limits.acceleration, self._limits.jerk).within(self._hand)
            motion.move_to(motion.position + direction * stage.width, way)
        elif self.mode is ManualMode.INTERRUPTIBLE and before and not direction:
            motion.stop(self._hand)
        return direction

    def _turned(self, pulses: int) -> int:
        if not pulses:
            return 0
        motion = self.motion
        if not motion.moves_to_target:
            self._wheel = motion.position
        ahead = self._hand.velocity * WHEEL_AHEAD
        wanted = self._wheel + pulses * self.stage.resolution
        self._wheel = min(max(wanted, motion.position - ahead), motion.position + ahead)
        motion.move_to(self._wheel, self._hand)
        self._wheel = motion.target
        return 1 if pulses > 0 else -1

    # ------------------------------------------------------------------ state

    @property
    def offset(self) -> float:
        """mm or degrees beside the path."""
        return self.motion.position

    @property
    def state(self) -> ManualState:
        if not self.released:
            return ManualState.OFF
        return ManualState.LINKED if self.element else ManualState.RELEASED
