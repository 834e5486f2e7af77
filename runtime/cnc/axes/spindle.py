"""A spindle: brings the speed to what M3, M4, M5 and S ask for, within its own acceleration and jerk.

The ramp comes from Ruckig's velocity interface. Speeds are degrees/s, positive for M3 (clockwise seen along the tool).
"""

from __future__ import annotations

from enum import IntEnum

from ruckig import ControlInterface, InputParameter, OutputParameter, Result, Ruckig

from runtime.config.machine import Axis

DEGREES_PER_SECOND = 6.0  # per rev/min
SPEED_REACHED = 0.02  # share of the commanded speed
ZERO_SPEED = 60.0  # degrees/s, 10 rev/min


class SpindleMode(IntEnum):
    """`mode_r` of the spindle status."""

    M5 = 1
    M3 = 2
    M4 = 4


class Spindle:
    """State in, state out: `command` sets the wish, `step` moves the set-point one cycle on."""

    def __init__(self, axis: Axis, index: int, period: float) -> None:
        self.axis = axis
        self.index = index  # in the machine's axes
        self.mode = SpindleMode.M5
        self.programmed_speed = 0.0  # degrees/s, without sign
        self.set_point = 0.0  # degrees/s, signed
        self._settled = True
        self._otg = Ruckig(1, period)
        self._input = InputParameter(1)
        self._output = OutputParameter(1)
        self._input.control_interface = ControlInterface.Velocity
        self._input.max_acceleration = [axis.acceleration]
        self._input.max_jerk = [axis.jerk]
        self._target = 0.0

    def command(self, number: int, speed_rpm: float) -> None:
        """M3, M4 or M5 (`number`), or 0 for a new speed in the same direction; `speed_rpm` in rev/min, not negative."""
        self.programmed_speed = speed_rpm * DEGREES_PER_SECOND
        if number == 3:
            self.mode = SpindleMode.M3
        elif number == 4:
            self.mode = SpindleMode.M4
        elif number == 5:
            self.mode = SpindleMode.M5

    def stop(self) -> None:
        """As M5: used by every reaction that stops the machine."""
        self.mode = SpindleMode.M5

    def step(self, override: float, running: bool) -> None:
        """One cycle. `running`: the drive takes set-points; if not, the set-point is zero at once, without a ramp."""
        if not running:
            self.set_point = 0.0
            self._input.current_velocity = [0.0]
            self._input.current_acceleration = [0.0]
            self._target = 0.0
            self._settled = True
            return
        target = 0.0
        if self.mode is not SpindleMode.M5:
            target = min(self.programmed_speed * override, self.axis.velocity)
            if self.mode is SpindleMode.M4:
                target = -target
        if target != self._target:
            self._target = target
            self._input.target_velocity = [target]
            self._settled = False
        if self._settled:
            return
        result = self._otg.update(self._input, self._output)
        self._output.pass_to_input(self._input)
        self.set_point = float(self._output.new_velocity[0])
        if result == Result.Finished:
            self.set_point = target  # without the last rounding error
            self._settled = True

    def reached(self, actual: float) -> bool:
        """The set-point is where it should be, and the actual speed (degrees/s) within its window of it."""
        window = max(SPEED_REACHED * abs(self._target), ZERO_SPEED)
        wanted = self._target if self.mode is not SpindleMode.M5 else 0.0
        return self.set_point == wanted and abs(actual - wanted) <= window

    def standing(self, actual: float) -> bool:
        """Below zero speed."""
        return abs(actual) <= ZERO_SPEED
