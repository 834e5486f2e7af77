"""A simulated CiA 402 drive: the device's state machine, cyclic synchronous position and velocity, faults."""

from __future__ import annotations

from enum import StrEnum
from typing import Final

from runtime.config.machine import SimulatedServo
from runtime.drives import DriveMode, DriveState
from runtime.fieldbus.cia402 import (
    CONTROLWORD,
    ERROR_CODE,
    MODES_OF_OPERATION,
    POSITION_ACTUAL,
    STATUSWORD,
    SUPPORTED_MODES,
    TARGET_POSITION,
    TARGET_VELOCITY,
    VELOCITY_ACTUAL,
)
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
from runtime.fieldbus.simulator.node import SimulatedNode
from runtime.fieldbus.simulator.servo import Servo

MODE_DISPLAY: Final = 0x6061
FOLLOWING_ERROR: Final = 0x60F4
ABORT_CONNECTION_OPTION: Final = 0x6007
QUICK_STOP_OPTION: Final = 0x605A
DISABLE_OPERATION_OPTION: Final = 0x605C
FAULT_REACTION_OPTION: Final = 0x605E
FOLLOWING_ERROR_WINDOW: Final = 0x6065
FOLLOWING_ERROR_TIMEOUT: Final = 0x6066  # ms
QUICK_STOP_DECELERATION: Final = 0x6085
INTERPOLATION_PERIOD: Final = 0x60C2

COMMUNICATION_FAULT: Final = 0x8130
FOLLOWING_ERROR_FAULT: Final = 0x8611
OVER_CURRENT: Final = 0x2310
NO_WINDOW: Final = 0xFFFF_FFFF

FOLLOWS_COMMAND: Final = 0x1000  # bits of the status word in the cyclic modes
FOLLOWING_ERROR_BIT: Final = 0x2000


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
        self, node: int, eds: str, network: PolledNetwork, servo: SimulatedServo, position: float = 0.0
    ) -> None:
        self.servo = Servo(servo, position)
        self.state = DriveState.NOT_READY_TO_SWITCH_ON
        self.transitions: list[int] = []  # numbers of those taken, the last 64
        self.blocked = False
        self._frozen: float | None = None  # what a frozen encoder reports
        self._controlword = 0
        self._braking_to: Transition | None = None  # brakes on the ramp before this transition
        self._off_course = 0.0  # s, since when the following error is outside its window
        self._advanced = 0.0  # time up to which the motor was moved
        super().__init__(node, eds, network)
        self.reset_application()

    # -- life --------------------------------------------------------------------------------------------------------

    def reset_application(self) -> None:
        self.state = DriveState.NOT_READY_TO_SWITCH_ON
        self._controlword = 0
        self._braking_to = None
        self.values = {
            (CONTROLWORD, 0): 0,
            (STATUSWORD, 0): 0,
            (ERROR_CODE, 0): 0,
            (MODES_OF_OPERATION, 0): 0,
            (MODE_DISPLAY, 0): 0,
            (POSITION_ACTUAL, 0): 0,
            (VELOCITY_ACTUAL, 0): 0,
            (FOLLOWING_ERROR, 0): 0,
            (TARGET_POSITION, 0): wrap32(round(self.servo.position)),
            (TARGET_VELOCITY, 0): 0,
            (SUPPORTED_MODES, 0): 0x180,
            (0x1001, 0): 0,
        }
        self._advanced = self.now
        self._read_parameters()
        self._publish()

    def written(self, index: int, subindex: int, value: int) -> None:
        if index == CONTROLWORD:
            self._obey(value)
        elif index == MODES_OF_OPERATION:
            self.values[MODE_DISPLAY, 0] = value
        elif index == INTERPOLATION_PERIOD:
            if subindex == 1:
                self._mantissa = value
            else:
                self._exponent = value
            self._period = self._mantissa * 10.0**self._exponent
        elif index in self._parameters:
            self._parameters[index] = value

    def _read_parameters(self) -> None:
        self._mantissa = self._number(INTERPOLATION_PERIOD, 1)
        self._exponent = self._number(INTERPOLATION_PERIOD, 2)
        self._period = self._mantissa * 10.0**self._exponent
        self._parameters = {
            index: self._number(index)
            for index in (
                ABORT_CONNECTION_OPTION,
                QUICK_STOP_OPTION,
                DISABLE_OPERATION_OPTION,
                FAULT_REACTION_OPTION,
                FOLLOWING_ERROR_WINDOW,
                FOLLOWING_ERROR_TIMEOUT,
                QUICK_STOP_DECELERATION,
            )
        }

    def step(self, now: float) -> None:
        if self.state is DriveState.NOT_READY_TO_SWITCH_ON:
            self._go(AUTOMATIC[self.state])
        # A drive in cyclic operation runs on the SYNC, like one whose clock is locked to it. Without SYNC it runs on.
        elapsed = now - self._advanced
        if elapsed > 2.0 * self._period or not self.operational:
            self._move(elapsed)
            self._advanced = now
            self._publish()
        super().step(now)

    def before_sync(self) -> None:
        self._move(self._period)
        self._advanced = self.now
        self._publish()

    # -- state machine -----------------------------------------------------------------------------------------------

    def set_points_taken(self) -> None:
        self._obey(self.values[CONTROLWORD, 0])

    def _obey(self, controlword: int) -> None:
        command = command_of(controlword, self._controlword)
        self._controlword = controlword
        transition = COMMANDED.get((self.state, command))
        if transition is None:
            return
        if transition.number == 16 and self._parameters[QUICK_STOP_OPTION] < 5:
            return
        if transition.number == 5 and self._parameters[DISABLE_OPERATION_OPTION] == 1:
            self._braking_to = transition
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
            self._off_course = 0.0
        if transition.number == 15:
            self.values[ERROR_CODE, 0] = 0
            self.clear_emergency()
        if self.state is DriveState.FAULT_REACTION_ACTIVE and self._parameters[FAULT_REACTION_OPTION] == 0:
            self._go(AUTOMATIC[self.state])
        self._publish()

    def fail(self, code: int) -> None:
        """Something is wrong inside: transition 13, EMCY; brake, then fault."""
        if self.state in (DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT):
            return
        self.values[ERROR_CODE, 0] = code
        self._go(FAULT_TRANSITION)
        if code != COMMUNICATION_FAULT:  # that EMCY the node has sent itself
            self.emergency(code)
        self._publish()

    def connection_lost(self) -> None:
        if self._parameters[ABORT_CONNECTION_OPTION] == 1 and self.state in (
            DriveState.OPERATION_ENABLED,
            DriveState.QUICK_STOP_ACTIVE,
            DriveState.SWITCHED_ON,
        ):
            self.fail(COMMUNICATION_FAULT)

    # -- motion ------------------------------------------------------------------------------------------------------

    def _move(self, dt: float) -> None:
        if dt <= 0.0:
            return
        servo, deceleration = self.servo, float(max(1, self._parameters[QUICK_STOP_DECELERATION]))
        match self.state:
            case DriveState.OPERATION_ENABLED if self._braking_to is not None:
                if servo.brake(deceleration, dt):
                    self._go(self._braking_to)
            case DriveState.OPERATION_ENABLED:
                self._follow(dt)
            case DriveState.QUICK_STOP_ACTIVE:
                if servo.brake(deceleration, dt) and self._parameters[QUICK_STOP_OPTION] < 5:
                    self._go(COMMANDED[self.state, Command.DISABLE_VOLTAGE])
            case DriveState.FAULT_REACTION_ACTIVE:
                if servo.brake(deceleration, dt):
                    self._go(AUTOMATIC[self.state])
            case _:
                servo.coast(dt)

    def _follow(self, dt: float) -> None:
        servo = self.servo
        if self.blocked:
            stands = servo.position
        if self.values[MODES_OF_OPERATION, 0] == DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY:
            servo.follow_velocity(self.values[TARGET_VELOCITY, 0], dt)
        else:
            # the target is 32 bits of an endless axis: the nearest position that looks like it
            moved = wrap32(self.values[TARGET_POSITION, 0] - round(servo.command))
            servo.follow_position(round(servo.command) + moved, dt)
        if self.blocked:
            servo.position, servo.velocity = stands, 0.0
        self._watch_following_error(dt)

    def _watch_following_error(self, dt: float) -> None:
        window = self._parameters[FOLLOWING_ERROR_WINDOW]
        if window == NO_WINDOW or abs(self.servo.command - self._reported()) <= window:
            self._off_course = 0.0
            return
        self._off_course += dt
        if self._off_course * 1000.0 > self._parameters[FOLLOWING_ERROR_TIMEOUT]:
            self.fail(FOLLOWING_ERROR_FAULT)

    def freeze_encoder(self, frozen: bool) -> None:
        self._frozen = self.servo.position if frozen else None

    def _reported(self) -> float:
        return self.servo.position if self._frozen is None else self._frozen

    def _publish(self) -> None:
        values, servo = self.values, self.servo
        status = STATUSWORDS[self.state]
        if self.state is DriveState.OPERATION_ENABLED and self._braking_to is None:
            status |= FOLLOWS_COMMAND
            if self._off_course:
                status |= FOLLOWING_ERROR_BIT
        values[STATUSWORD, 0] = status
        values[POSITION_ACTUAL, 0] = wrap32(round(self._reported()))
        values[VELOCITY_ACTUAL, 0] = wrap32(round(servo.velocity)) if self._frozen is None else 0
        values[FOLLOWING_ERROR, 0] = wrap32(round(servo.command - self._reported()))

    @property
    def moving(self) -> bool:
        return self.servo.velocity != 0.0
