"""A spindle: turns as M3, M4, M5 and S ask for, and stands at an angle after M19, within its own acceleration and jerk.

Speeds are degrees/s, positive for M3 (clockwise seen along the tool); angles are degrees.

The drive gets speeds. Turning, the planned speed is the set-point. Positioning, the plan leads to the angle, and what the
measured angle is off it is added:

    set-point = weight · planned speed + K · (planned angle - measured angle)        bounded, and ramped

The measured angle comes from the bus more seldom than every cycle; in between the measured speed carries it on.

Together with the path (threads, tapping) its angle is kept in the same way: `lock` binds the measured angle to the plan while
it turns, and while it `follows` the path tells the plan.

From standstill an angle is gone to the shorter way unless M3 or M4 stands beside M19; a turning spindle keeps its sense and
stops at the first time the angle comes round that it can brake to.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import IntEnum

from runtime.cnc.axes.axis_plan import Dynamics, Plan, State, plan_speed
from runtime.cnc.axes.single_axis import Goal, SingleAxis
from runtime.config.machine import Axis

DEGREES_PER_SECOND = 6.0  # per rev/min
SPEED_REACHED = 0.02  # share of the commanded speed
ZERO_SPEED = 60.0  # degrees/s, 10 rev/min
TURN = 360.0
LEAST_WINDOW = 0.1  # degrees around the angle of M19
_GAIN = 20.0  # 1/s, K above
_SHARE = 0.7  # of acceleration and jerk that a plan to an angle uses; the rest is for what is added to it
_HAIR = 1e-6  # degrees


class SpindleMode(IntEnum):
    """`mode_r` of the spindle status."""

    M5 = 1
    M3 = 2
    M4 = 4
    M19 = 8


@dataclass(frozen=True, slots=True)
class SpindleOrder:
    """M3, M4, M5 or M19 (`number`), or 0 for a new speed only; `speed` in rev/min, not negative.

    Of M19 `angle` is where to stand, `sense` 3 or 4 the sense of the approach, 0 is the shorter way or the present sense. With a
    speed alone `sense` is the sense that is modal, 0 to leave it as it is.
    `override_off`: the external override counts as 100 % until the next order (G167).
    """

    number: int
    speed: float
    angle: float = 0.0
    sense: int = 0
    override_off: bool = False


_MODES = {3: SpindleMode.M3, 4: SpindleMode.M4, 5: SpindleMode.M5, 19: SpindleMode.M19}


class Spindle:
    """State in, state out: orders set the wish, `step` moves the set-point one cycle on. `index`: in the machine's axes."""

    def __init__(self, axis: Axis, index: int, period: float) -> None:
        self.axis = axis
        self.index = index
        self.mode = SpindleMode.M5
        self.programmed_speed = 0.0  # degrees/s, without sign
        self.target_angle = 0.0  # of M19, 0…360
        self.set_point = 0.0  # degrees/s, signed
        self.angle = 0.0  # measured, degrees since the start
        self.override_off = False
        self.speed_factor = 1.0  # OVERRIDE SPEED_FACT
        self.feed_forward = 1.0  # weight of the planned speed while positioning, G135…G137
        self.acceleration_weight = 1.0  # G130
        self._most = Dynamics(axis.velocity, axis.acceleration, axis.jerk)  # of the gear stage
        self._stages = [Dynamics(stage.velocity, stage.acceleration, stage.jerk) for stage in axis.gear_stages]
        self._next_stage = -1  # ordered, waits for standstill
        self._period = period
        self._mover = SingleAxis(self._most, period)
        self._offset = 0.0  # measured angle - angle of the mover
        self._measured = math.nan  # as it came from the bus
        self._extra = 0.0  # degrees/s added to the planned speed
        self._running = False
        self._override = 1.0
        self.velocity = 0.0  # measured, degrees/s
        self.follows = False  # the path says where it is to be
        self.locked = False  # the measured angle is kept to the plan
        self._steady = False  # the override stays as it is
        self._led = 0.0  # where the path wants it, degrees of `angle`
        self._led_speed = 0.0
        self._off = 0.0  # degrees that the angle was behind the plan

    # ------------------------------------------------------------------ orders

    def command(self, order: SpindleOrder) -> None:
        """Take an order; it acts from the next step on. While it follows the path there is none for it."""
        if self.follows:
            return
        self.programmed_speed = order.speed * DEGREES_PER_SECOND
        self.override_off = order.override_off
        # behind M19 a new speed alone turns the spindle again if M3 or M4 is still modal
        self.mode = _MODES.get(order.number or order.sense, self.mode)
        if order.number == 19:
            self.target_angle = order.angle % TURN
            self._go_to_angle(order.sense)
        elif self.mode is not SpindleMode.M19 or self._mover.goal is not Goal.POSITION:
            self._turn()
        else:
            self._mover.move_to(self._mover.target, self._positioning())  # another speed on the way

    @property
    def greatest_speed(self) -> float:
        """Of the present gear stage, degrees/s."""
        return self._most.velocity

    def change_speed(self, speed: float, share: float) -> None:
        """Another speed, degrees/s, and nothing else; a change of less than `share` is none. Not on the way to M19."""
        before = self.programmed_speed
        if self.mode is SpindleMode.M19 or abs(speed - before) <= share * before:
            return
        self.programmed_speed = speed
        if not self.follows:
            self._turn()

    def stop(self) -> None:
        """As M5: used by every reaction that stops the machine. One that follows the path comes to rest with it."""
        self.mode = SpindleMode.M5
        if not self.follows:
            self._turn()

    def reset(self) -> None:
        """Stops, and forgets what was ordered beside motion: weights, the override that is switched off."""
        self.speed_factor = self.feed_forward = self.acceleration_weight = 1.0
        self.override_off = False
        self.stop()

    @property
    def stages(self) -> int:
        """Gear stages that it has data of."""
        return len(self._stages)

    def weigh(self, *, acceleration: float | None = None, speed: float | None = None) -> None:
        """New weights of acceleration (G130) and speed (OVERRIDE SPEED_FACT), 1.0 is 100 %."""
        self.acceleration_weight = self.acceleration_weight if acceleration is None else acceleration
        self.speed_factor = self.speed_factor if speed is None else speed
        self._again()

    def select_stage(self, stage: int) -> None:
        """Dynamic data of another gear stage (G112, M40…M45), from 0; they count as soon as the spindle stands."""
        self._next_stage = stage

    def home(self) -> None:
        """G74: the encoder is absolute, so the spindle only comes to rest."""
        self.stop()

    def _change_stage(self) -> None:
        if self._next_stage < len(self._stages):
            self._most = self._stages[self._next_stage]
            self._mover = SingleAxis(self._most, self._period, position=self._mover.position)
            self._again()
        self._next_stage = -1

    def _again(self) -> None:
        if self.follows:
            return
        if self.mode is not SpindleMode.M19:
            self._turn()
        elif self._mover.goal is Goal.POSITION:
            self._mover.move_to(self._mover.target, self._positioning())

    def _turn(self) -> None:
        speed = min(self.programmed_speed * self.speed_factor, self._most.velocity)
        if self.mode in (SpindleMode.M5, SpindleMode.M19) or speed == 0.0:
            self._mover.stop(self._turning())
        else:
            self._mover.move_at(-speed if self.mode is SpindleMode.M4 else speed, self._turning())

    def _go_to_angle(self, sense: int) -> None:
        """Choose the turn in which the angle is gone to; angles of the mover."""
        mover = self._mover
        self._offset = self.angle - mover.position
        dynamics = self._positioning()
        wanted = self.target_angle - self._offset
        if mover.standstill and sense == 0:
            way = (wanted - mover.position + TURN / 2) % TURN - TURN / 2
            mover.move_to(mover.position + way, dynamics)
            return
        if sense == 0:
            sense = 3 if mover.velocity > 0.0 else 4
        # first to the speed of positioning, from there to rest: that takes more way than braking at once
        slower, stopping = Plan(), Plan()
        speed = min(abs(mover.velocity), dynamics.velocity * max(self._override, 0.01))
        speed = math.copysign(speed, mover.velocity)
        plan_speed(slower, State(mover.position, mover.velocity, mover.acceleration), speed, dynamics)
        plan_speed(stopping, slower.end, 0.0, dynamics)
        stop = stopping.end.p
        if sense == 3:
            way = (wanted - stop + _HAIR) % TURN - _HAIR
        else:
            way = -((stop - wanted + _HAIR) % TURN - _HAIR)
        mover.move_to(stop + way, dynamics)

    def _turning(self) -> Dynamics:
        weight = self.acceleration_weight
        return Dynamics(self._most.velocity, self._most.acceleration * weight, self._most.jerk * weight)

    def _positioning(self) -> Dynamics:
        weight = self.acceleration_weight * _SHARE
        speed = min(max(self.programmed_speed * self.speed_factor, 1.0), self._most.velocity)
        return Dynamics(speed, self._most.acceleration * weight, self._most.jerk * weight)

    # ------------------------------------------------------------------ together with the path

    @property
    def speed_told(self) -> float:
        """The planned speed, degrees/s, signed."""
        return self._mover.velocity

    @property
    def planned_next(self) -> float:
        """Where the plan will be behind the next step, if nothing is ordered, degrees of `angle`."""
        mover, period = self._mover, self._period
        return self.planned_angle + (mover.velocity + mover.acceleration * period / 2.0) * period

    @property
    def at_speed(self) -> bool:
        """It turns as M3 or M4 asks for."""
        turns = self.mode in (SpindleMode.M3, SpindleMode.M4) and self._mover.velocity != 0.0
        return turns and self.reached(self.velocity)

    @property
    def at_rest(self) -> bool:
        """Plan and spindle stand."""
        return self._mover.standstill and abs(self.velocity) <= ZERO_SPEED

    def lock(self, *, steady: bool) -> None:
        """The measured angle is kept to the plan from here on, as both are now; `steady`: and the override stays as it is."""
        if not self.locked:
            self._offset = self.angle + self._mover.velocity * self._period - self._mover.position
        self.locked, self._steady = True, steady

    def unlock(self) -> None:
        """Only the speed counts again."""
        self.locked = self._steady = False

    def follow(self) -> float:
        """Standing: it turns with the path from here on, from the angle that this returns (degrees of `angle`)."""
        self.mode = SpindleMode.M5
        self.follows = True
        self._mover.restart(self._mover.position)
        self._led, self._led_speed = self.angle, 0.0
        return self._led

    def lead(self, angle: float) -> None:
        """Where it has to be behind the next step, degrees of `angle`."""
        self._led_speed = (angle - self._led) / self._period
        self._led = angle

    @property
    def off_plan(self) -> float:
        """How far the measured angle was behind the plan in the cycle before, degrees."""
        return self._off

    @property
    def at_rest_led(self) -> bool:
        """Following the path, which stands: it stands as well, and is where the path has it."""
        window = max(self.axis.in_position, LEAST_WINDOW)
        return self._led_speed == 0.0 and abs(self._off) <= window and abs(self.velocity) <= ZERO_SPEED

    def release(self) -> None:
        """It no longer follows, and comes to rest if it does not stand."""
        if not self.follows:
            return
        self.follows = False
        self._offset = self._led - self._mover.position
        self._mover.continue_from(State(self._mover.position, self._led_speed, 0.0))
        self._turn()

    # ------------------------------------------------------------------ the cycle

    def observe(self, position: float, velocity: float) -> None:
        """Start of the cycle: what the drive says, degrees and degrees/s; the position may be that of an earlier cycle."""
        self.velocity = velocity
        if position != self._measured:
            self._measured = self.angle = position
        else:
            self.angle += velocity * self._period

    def step(self, override: float, running: bool) -> None:
        """One cycle. `running`: the drive takes set-points; if not, the set-point is zero at once, without a ramp."""
        mover = self._mover
        if not running:
            self.follows = self.locked = False
            if self._running or mover.goal is Goal.POSITION:
                mover.restart(mover.position)
                self._turn()
            self._running = False
            self.set_point = self._extra = 0.0
            if not mover.standstill:
                mover.restart(mover.position)
                self._turn()
            return
        self._running = True
        if self.follows:
            self.set_point = self._led_speed
            self.set_point += self._correction()
            return
        if self._next_stage >= 0 and mover.standstill:
            self._change_stage()
            mover = self._mover
        if not self._steady:
            self._override = 1.0 if self.override_off else override
        mover.step(self._override)
        self.set_point = mover.velocity
        if mover.goal is Goal.POSITION:
            self.set_point = self.feed_forward * mover.velocity + self._correction()
        elif self.locked:
            self.set_point += self._correction()
        elif self._extra != 0.0:
            most = self._most.acceleration * (1.0 - _SHARE) * self._period
            self._extra -= max(-most, min(self._extra, most))
            self.set_point += self._extra

    def _correction(self) -> float:
        """What is added to the planned speed for the angle to come true; it changes no faster than the spindle may."""
        off = self._off = self.planned_angle - self.angle - self.set_point * self._period
        most = self._most.acceleration * (1.0 - _SHARE) * self._period
        wanted = max(-self._most.velocity, min(_GAIN * off, self._most.velocity))
        self._extra += max(-most, min(wanted - self._extra, most))
        if abs(self._extra) < _HAIR and abs(off) < _HAIR:
            self._extra = 0.0
        return self._extra

    @property
    def planned_angle(self) -> float:
        """Where the plan is, in the degrees of `angle`; turning without a lock, it is no measure."""
        return self._led if self.follows else self._mover.position + self._offset

    # ------------------------------------------------------------------ state

    def reached(self, actual: float) -> bool:
        """What was ordered is there: the actual speed (degrees/s) within its window, or the angle within its."""
        if self.mode is SpindleMode.M19:
            off = (self.angle - self.target_angle + TURN / 2) % TURN - TURN / 2
            return (
                self._mover.arrived
                and abs(off) <= max(self.axis.in_position, LEAST_WINDOW)
                and abs(actual) <= ZERO_SPEED
            )
        wanted = 0.0 if self.mode is SpindleMode.M5 else self.set_point
        window = max(SPEED_REACHED * abs(self.set_point), ZERO_SPEED)
        return self._mover.arrived and abs(actual - wanted) <= window

    def standing(self, actual: float) -> bool:
        """Below zero speed."""
        return abs(actual) <= ZERO_SPEED
