"""A simulated CiA 402 drive: the device's state machine with its option codes, monitoring, faults.

How it moves in its modes of operation is in runtime.fieldbus.simulator.drive_motion.
"""

from __future__ import annotations

from enum import StrEnum
from typing import Final

from canopen.sdo.exceptions import SdoAbortedError

from runtime.config.machine import SimulatedServo
from runtime.drives import DriveState
from runtime.fieldbus import cia402 as objects
from runtime.fieldbus.cia402 import STAYS, Stop
from runtime.fieldbus.exchange import CODES, IO_OBJECTS
from runtime.fieldbus.links import wrap32
from runtime.fieldbus.network import PolledNetwork
from runtime.fieldbus.simulator.device_states import (
    AUTOMATIC,
    COMMANDED,
    FAULT_TRANSITION,
    STATUSWORDS,
    Command,
    Transition,
    command_of,
)
from runtime.fieldbus.simulator.drive_motion import MODES, DriveMotion
from runtime.fieldbus.simulator.node import SimulatedNode
from runtime.fieldbus.simulator.servo import Motor, Servo
from runtime.fieldbus.simulator.switches import PROBE_BITS, Switches

COMMUNICATION_FAULT: Final = 0x8130
FOLLOWING_ERROR_FAULT: Final = 0x8611
SET_POINTS_MISSING: Final = 0x8250
OVER_CURRENT: Final = 0x2310
EARLY: Final = 0.5  # share of the period, before which a SYNC is none
LATE: Final = 1.5  # share of the period, after which the drive does not wait for it any more
NO_WINDOW: Final = 0xFFFF_FFFF
STRONGEST_BRAKE: Final = 10.0  # times the quick-stop ramp: brake at the limit of current or voltage
UNKNOWN_MODE: Final = 0x06090030  # SDO abort: value out of range

EXCHANGED: Final = (
    *((index, 0) for index in CODES if index not in IO_OBJECTS and index != objects.INTERPOLATION_DATA),
    (objects.ERROR_CODE, 0),
    (0x1001, 0),
)
"""Objects that are 0 at power-on."""
LIMITS: Final = (
    objects.MAX_TORQUE,
    objects.POSITIVE_TORQUE_LIMIT,
    objects.NEGATIVE_TORQUE_LIMIT,
    objects.PROFILE_VELOCITY,
)
"""Objects that the dictionary gives a value, and that may be mapped."""
PARAMETERS: Final = (
    objects.ABORT_CONNECTION_OPTION,
    objects.QUICK_STOP_OPTION,
    objects.SHUTDOWN_OPTION,
    objects.DISABLE_OPERATION_OPTION,
    objects.HALT_OPTION,
    objects.FAULT_REACTION_OPTION,
    objects.FOLLOWING_ERROR_WINDOW,
    objects.FOLLOWING_ERROR_TIMEOUT,
    objects.MAX_PROFILE_VELOCITY,
    objects.PROFILE_ACCELERATION,
    objects.PROFILE_DECELERATION,
    objects.QUICK_STOP_DECELERATION,
    objects.TORQUE_SLOPE,
    objects.HOME_OFFSET,
    objects.HOMING_METHOD,
    objects.HOMING_ACCELERATION,
)
"""Objects that are read once and then kept at hand."""


class Fault(StrEnum):
    """What can be done to a simulated node."""

    DRIVE = "drive"  # the drive goes into fault, with an error code
    SILENT = "silent"  # it neither sends nor hears: cable cut
    REBOOT = "reboot"  # its supply failed for a moment
    WRONG_VENDOR = "wrong_vendor"  # another device with the same node id
    FOLLOWING_ERROR = "following_error"  # the axis is blocked
    ENCODER_FREEZE = "encoder_freeze"  # the position it reports stands still


class SimulatedDrive(SimulatedNode):
    """A drive with its motor. Increments and increments/s inside."""

    def __init__(
        self,
        node: int,
        eds: str,
        network: PolledNetwork,
        servo: SimulatedServo,
        position: float,
        motor: Motor,
    ) -> None:
        self.servo = Servo(servo, position, motor.rated)
        self.zero = 0  # encoder position where the drive counts 0; set by homing
        probes = [None if place is None else place * motor.increments_per_unit for place in (servo.probe, None)]
        self.motion = DriveMotion(self, Switches.of(servo, motor.increments_per_unit), probes)
        self.state = DriveState.NOT_READY_TO_SWITCH_ON
        self.transitions: list[int] = []  # numbers of those taken, the last 64
        self.blocked = False
        self.controlword = 0
        self.parameters: dict[int, int] = {}
        self._frozen: float | None = None  # what a frozen encoder reports
        self._braking_to: Transition | None = None  # brakes on the ramp before this transition
        self._stop = Stop.QUICK_STOP_RAMP  # how it brakes
        self._off_course = 0.0  # s, since when the following error is outside its window
        self._advanced = 0.0  # time up to which the motor was moved
        super().__init__(node, eds, network)
        self.reset_application()

    # -- life --------------------------------------------------------------------------------------------------------

    def reset_application(self) -> None:
        self.state = DriveState.NOT_READY_TO_SWITCH_ON
        self.controlword = 0
        self._braking_to = None
        limits = {(index, 0): self._number(index) for index in LIMITS}  # before: the live values hide the dictionary
        self.values = dict.fromkeys(EXCHANGED, 0) | limits
        counted = wrap32(round(self.counted))
        self.values |= {(objects.TARGET_POSITION, 0): counted, (objects.INTERPOLATION_DATA, 1): counted}
        self.values[objects.SUPPORTED_MODES, 0] = sum(1 << mode - 1 for mode in MODES)
        self._advanced = self.now
        self._mantissa = self._number(objects.INTERPOLATION_PERIOD, 1)
        self._exponent = self._number(objects.INTERPOLATION_PERIOD, 2)
        self._period = self._mantissa * 10.0**self._exponent
        self.parameters = {index: self._number(index) for index in PARAMETERS}
        self.homing_speeds = [self._number(objects.HOMING_SPEEDS, sub) for sub in (1, 2)]
        self.motion.reset()
        self._publish()

    def written(self, index: int, subindex: int, value: int) -> None:
        if index == objects.CONTROLWORD:
            self._obey(value)
        elif index == objects.MODES_OF_OPERATION:
            if value and value not in MODES:
                raise SdoAbortedError(UNKNOWN_MODE)
            self._enter_mode()
        elif index == objects.INTERPOLATION_PERIOD:
            if subindex == 1:
                self._mantissa = value
            else:
                self._exponent = value
            self._period = self._mantissa * 10.0**self._exponent
        elif index == objects.HOMING_SPEEDS and subindex:
            self.homing_speeds[subindex - 1] = value
        elif index in self.parameters:
            self.parameters[index] = value

    def step(self, now: float) -> None:
        if self.state is DriveState.NOT_READY_TO_SWITCH_ON:
            self._go(AUTOMATIC[self.state])
        # A drive in cyclic operation runs on the SYNC, like one whose clock is locked to it. A SYNC that is missing is noticed
        # when half of the next period has gone.
        elapsed = now - self._advanced
        if not self.operational:
            self._move(elapsed, synchronised=False)
            self._advanced = now
            self._publish()
        else:
            while now - self._advanced > LATE * self._period:
                self._move(self._period, synchronised=False)
                self._advanced += self._period
                self._publish()
        super().step(now)

    def before_sync(self) -> None:
        if 0.0 <= self.now - self._advanced < EARLY * self._period:
            return  # the same SYNC once more: the clock of the drive knows better
        self._move(self._period, synchronised=True)
        self._advanced = self.now
        self._publish()

    # -- state machine -----------------------------------------------------------------------------------------------

    def set_points_taken(self) -> None:
        self.motion.points.receive()
        self._enter_mode()
        self._obey(self.values[objects.CONTROLWORD, 0])

    def _enter_mode(self) -> None:
        """0x6061 follows 0x6060, unless that asks for a mode that the drive does not have."""
        wanted, shown = self.values[objects.MODES_OF_OPERATION, 0], self.values[objects.MODE_DISPLAY, 0]
        if wanted != shown and wanted in MODES:
            self.values[objects.MODE_DISPLAY, 0] = wanted
            self.motion.begin()

    @property
    def mode(self) -> int:
        """The `DriveMode` that the drive is in, 0: none yet."""
        return self.values[objects.MODE_DISPLAY, 0]

    @property
    def counted(self) -> float:
        """The position of the motor as the drive counts it."""
        return self.servo.position - self.zero

    def _obey(self, controlword: int) -> None:
        command = command_of(controlword, self.controlword)
        self.controlword = controlword
        transition = COMMANDED.get((self.state, command))
        if transition is None:
            return
        options = self.parameters
        if transition.number == 16 and options[objects.QUICK_STOP_OPTION] < STAYS:
            return
        if transition.number == 11 and options[objects.QUICK_STOP_OPTION] == Stop.COAST:
            self._go(transition)
            self._go(COMMANDED[self.state, Command.DISABLE_VOLTAGE])
            return
        option = {5: objects.DISABLE_OPERATION_OPTION, 8: objects.SHUTDOWN_OPTION}.get(transition.number)
        if option is not None and options[option] != Stop.COAST:
            self._braking_to, self._stop = transition, Stop(options[option])
        elif self._braking_to is None or transition.target is not DriveState.OPERATION_ENABLED:
            self._go(transition)
        if transition.number == 3 and command is Command.ENABLE_OPERATION:
            self._go(COMMANDED[self.state, command])

    def _go(self, transition: Transition) -> None:
        self._braking_to = None
        self.state = transition.target
        self.transitions = [*self.transitions[-63:], transition.number]
        if self.state is DriveState.OPERATION_ENABLED:
            self.servo.take_over()
            self.motion.begin()
            self._off_course = 0.0
        elif self.state is DriveState.QUICK_STOP_ACTIVE:
            code = self.parameters[objects.QUICK_STOP_OPTION]
            self._stop = Stop(code - STAYS + 1 if code >= STAYS else code)
        elif self.state is DriveState.FAULT_REACTION_ACTIVE:
            self._stop = Stop(self.parameters[objects.FAULT_REACTION_OPTION])
        if transition.number == 15:
            self.values[objects.ERROR_CODE, 0] = 0
            self.clear_emergency()
        if self.state is DriveState.FAULT_REACTION_ACTIVE and self._stop is Stop.COAST:
            self._go(AUTOMATIC[self.state])
        self._publish()

    def fail(self, code: int) -> None:
        """Something is wrong inside: transition 13, EMCY; brake, then fault."""
        if self.state in (DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT):
            return
        self.values[objects.ERROR_CODE, 0] = code
        self._go(FAULT_TRANSITION)
        if code != COMMUNICATION_FAULT:  # that EMCY the node has sent itself
            self.emergency(code)
        self._publish()

    def connection_lost(self) -> None:
        """The reaction of object 0x6007: 1 fault, 2 disable voltage, 3 quick stop."""
        option = self.parameters[objects.ABORT_CONNECTION_OPTION]
        if self.state not in (DriveState.OPERATION_ENABLED, DriveState.QUICK_STOP_ACTIVE, DriveState.SWITCHED_ON):
            return
        if option == 1:
            self.fail(COMMUNICATION_FAULT)
        elif option in (2, 3):
            self._obey(0x0000 if option == 2 else 0x0002)

    # -- motion ------------------------------------------------------------------------------------------------------

    def ramp(self, stop: Stop) -> float:
        """The deceleration of a way to stop, increments/s²."""
        if stop is Stop.SLOW_DOWN_RAMP:
            return float(max(1, self.parameters[objects.PROFILE_DECELERATION]))
        quick = float(max(1, self.parameters[objects.QUICK_STOP_DECELERATION]))
        return quick if stop is Stop.QUICK_STOP_RAMP else STRONGEST_BRAKE * quick

    def _move(self, dt: float, *, synchronised: bool) -> None:
        if dt <= 0.0:
            return
        servo = self.servo
        before = servo.position
        match self.state:
            case DriveState.OPERATION_ENABLED if self._braking_to is not None:
                if servo.brake(self.ramp(self._stop), dt):
                    self._go(self._braking_to)
            case DriveState.OPERATION_ENABLED:
                self._operate(dt, synchronised)
            case DriveState.QUICK_STOP_ACTIVE:
                if servo.brake(self.ramp(self._stop), dt) and self.parameters[objects.QUICK_STOP_OPTION] < STAYS:
                    self._go(COMMANDED[self.state, Command.DISABLE_VOLTAGE])
            case DriveState.FAULT_REACTION_ACTIVE:
                if servo.brake(self.ramp(self._stop), dt):
                    self._go(AUTOMATIC[self.state])
            case _:
                servo.coast(dt)
        self.motion.look(before, servo.position)

    def _operate(self, dt: float, synchronised: bool) -> None:
        servo = self.servo
        stands = servo.position
        self.motion.step(dt, synchronised=synchronised)
        if self.blocked:
            servo.position, servo.velocity = stands, 0.0
        if self.motion.points.starved:
            self.fail(SET_POINTS_MISSING)
            return
        window = self.parameters[objects.FOLLOWING_ERROR_WINDOW]
        if window == NO_WINDOW or abs(servo.command - self._reported()) <= window:
            self._off_course = 0.0
            return
        self._off_course += dt
        if self._off_course * 1000.0 > self.parameters[objects.FOLLOWING_ERROR_TIMEOUT]:
            self.fail(FOLLOWING_ERROR_FAULT)

    def freeze_encoder(self, frozen: bool) -> None:
        self._frozen = self.servo.position if frozen else None

    def _reported(self) -> float:
        return self.servo.position if self._frozen is None else self._frozen

    def _publish(self) -> None:
        values, servo, zero = self.values, self.servo, self.zero
        status = STATUSWORDS[self.state]
        if self.state is DriveState.OPERATION_ENABLED and self._braking_to is None:
            status |= self.motion.status_bits(lagging=self._off_course > 0.0)
        elif self.state is DriveState.QUICK_STOP_ACTIVE and servo.velocity == 0.0:
            status |= objects.TARGET_REACHED
        values[objects.STATUSWORD, 0] = status
        reported = self._reported()
        values[objects.POSITION_ACTUAL, 0] = wrap32(round(reported - zero))
        values[objects.VELOCITY_ACTUAL, 0] = wrap32(round(servo.velocity)) if self._frozen is None else 0
        values[objects.TORQUE_ACTUAL, 0] = max(-0x8000, min(0x7FFF, round(servo.torque * 1000.0)))
        values[objects.FOLLOWING_ERROR, 0] = wrap32(round(servo.command - reported))
        motion = self.motion
        if motion.blind:
            return
        values[objects.DIGITAL_INPUTS, 0] = motion.switches.bits(servo.position) | sum(
            bit for bit, probe in zip(PROBE_BITS, motion.probes, strict=True) if probe.level(servo.position)
        )
        first, second = motion.probes
        values[objects.PROBE_STATUS, 0] = first.bits | second.bits
        values[objects.PROBE_1_RISING, 0], values[objects.PROBE_1_FALLING, 0] = self._latched(first.positions)
        values[objects.PROBE_2_RISING, 0], values[objects.PROBE_2_FALLING, 0] = self._latched(second.positions)

    def _latched(self, positions: list[float]) -> tuple[int, int]:
        rising, falling = (wrap32(round(position - self.zero)) for position in positions)
        return rising, falling

    @property
    def moving(self) -> bool:
        return self.servo.velocity != 0.0
