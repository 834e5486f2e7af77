"""The CiA 402 state machine as the master sees it: status words to states, wishes to control words, all as tables.

The device-side machine, with its numbered transitions, is in runtime.fieldbus.simulator.device_states. Source: IEC
61800-7-201 (CiA 402-2), "Finite state automaton of the PDS".
"""

from __future__ import annotations

from dataclasses import dataclass
from enum import IntEnum
from typing import Final

from runtime.drives import DriveState

# Object dictionary
ABORT_CONNECTION_OPTION: Final = 0x6007
ERROR_CODE: Final = 0x603F
CONTROLWORD: Final = 0x6040
STATUSWORD: Final = 0x6041
QUICK_STOP_OPTION: Final = 0x605A
SHUTDOWN_OPTION: Final = 0x605B
DISABLE_OPERATION_OPTION: Final = 0x605C
HALT_OPTION: Final = 0x605D
FAULT_REACTION_OPTION: Final = 0x605E
MODES_OF_OPERATION: Final = 0x6060
MODE_DISPLAY: Final = 0x6061
POSITION_ACTUAL: Final = 0x6064
FOLLOWING_ERROR_WINDOW: Final = 0x6065
FOLLOWING_ERROR_TIMEOUT: Final = 0x6066  # ms
VELOCITY_ACTUAL: Final = 0x606C
TARGET_TORQUE: Final = 0x6071  # torques are in 0.1 % of the rated torque
MAX_TORQUE: Final = 0x6072
TORQUE_ACTUAL: Final = 0x6077
TARGET_POSITION: Final = 0x607A
HOME_OFFSET: Final = 0x607C
MAX_PROFILE_VELOCITY: Final = 0x607F
PROFILE_VELOCITY: Final = 0x6081
PROFILE_ACCELERATION: Final = 0x6083
PROFILE_DECELERATION: Final = 0x6084
QUICK_STOP_DECELERATION: Final = 0x6085
TORQUE_SLOPE: Final = 0x6087  # 0.1 % of the rated torque per second
ENCODER_RESOLUTION: Final = 0x608F
GEAR_RATIO: Final = 0x6091
FEED_CONSTANT: Final = 0x6092
HOMING_METHOD: Final = 0x6098
HOMING_SPEEDS: Final = 0x6099  # 1: search for the switch, 2: search for the zero
HOMING_ACCELERATION: Final = 0x609A
VELOCITY_OFFSET: Final = 0x60B1
TORQUE_OFFSET: Final = 0x60B2
PROBE_FUNCTION: Final = 0x60B8
PROBE_STATUS: Final = 0x60B9
PROBE_1_RISING: Final = 0x60BA
PROBE_1_FALLING: Final = 0x60BB
PROBE_2_RISING: Final = 0x60BC
PROBE_2_FALLING: Final = 0x60BD
INTERPOLATION_DATA: Final = 0x60C1  # 1: set-point
INTERPOLATION_PERIOD: Final = 0x60C2  # 1: value, 2: power of ten
POSITIVE_TORQUE_LIMIT: Final = 0x60E0
NEGATIVE_TORQUE_LIMIT: Final = 0x60E1
FOLLOWING_ERROR: Final = 0x60F4
DIGITAL_INPUTS: Final = 0x60FD
TARGET_VELOCITY: Final = 0x60FF
SUPPORTED_MODES: Final = 0x6502

DEVICE_PROFILE: Final = 402

# Bits of the control word that depend on the mode
NEW_SET_POINT: Final = 0x0010  # profile position; homing: start; interpolated position: interpolate
CHANGE_AT_ONCE: Final = 0x0020  # profile position
HALT: Final = 0x0100

# Bits of the status word
TARGET_REACHED: Final = 0x0400
LIMIT_ACTIVE: Final = 0x0800
MODE_BIT_12: Final = 0x1000  # follows the command, set-point acknowledged, homing attained, speed is 0
MODE_BIT_13: Final = 0x2000  # following error, homing error

# Bits of 0x60FD
NEGATIVE_LIMIT_BIT: Final = 0x1
POSITIVE_LIMIT_BIT: Final = 0x2
HOME_SWITCH_BIT: Final = 0x4


class Stop(IntEnum):
    """How a drive comes to rest: values of the option codes 0x605A to 0x605E; 5 to 8 are 1 to 4, and it stays enabled."""

    COAST = 0
    SLOW_DOWN_RAMP = 1  # 0x6084
    QUICK_STOP_RAMP = 2  # 0x6085
    CURRENT_LIMIT = 3
    VOLTAGE_LIMIT = 4


STAYS: Final = 5  # quick-stop option codes from here on: the drive stays in QUICK_STOP_ACTIVE


# Status words: the first pattern that fits decides.
STATUS_PATTERNS: Final[tuple[tuple[int, int, DriveState], ...]] = (
    # mask, value, state
    (0b0100_1111, 0b0000_0000, DriveState.NOT_READY_TO_SWITCH_ON),
    (0b0100_1111, 0b0100_0000, DriveState.SWITCH_ON_DISABLED),
    (0b0110_1111, 0b0010_0001, DriveState.READY_TO_SWITCH_ON),
    (0b0110_1111, 0b0010_0011, DriveState.SWITCHED_ON),
    (0b0110_1111, 0b0010_0111, DriveState.OPERATION_ENABLED),
    (0b0110_1111, 0b0000_0111, DriveState.QUICK_STOP_ACTIVE),
    (0b0100_1111, 0b0000_1111, DriveState.FAULT_REACTION_ACTIVE),
    (0b0100_1111, 0b0000_1000, DriveState.FAULT),
)
_STATE_BITS: Final = 0b0110_1111


def _state_of(bits: int) -> DriveState:
    for mask, value, state in STATUS_PATTERNS:
        if bits & mask == value:
            return state
    return DriveState.NOT_READY_TO_SWITCH_ON  # a pattern of no state: nothing may be asked of such a drive


_STATES: Final = tuple(_state_of(bits) for bits in range(_STATE_BITS + 1))


def drive_state(statusword: int) -> DriveState:
    """The state that a status word (0x6041) tells. A pattern that the standard does not know is "not ready"."""
    return _STATES[statusword & _STATE_BITS]


class Wish(IntEnum):
    """What is wanted of a drive in this cycle."""

    DISABLE = 0
    ENABLE = 1
    QUICK_STOP = 2
    ACKNOWLEDGE = 3  # only ever wished in FAULT


# Control words (0x6040) and the transitions they order.
DISABLE_VOLTAGE: Final = 0x0000  # 7, 9, 10, 12
QUICK_STOP: Final = 0x0002  # 7, 10, 11
SHUTDOWN: Final = 0x0006  # 2, 6, 8
SWITCH_ON: Final = 0x0007  # 3, and "disable operation" (5) for an enabled drive
ENABLE_OPERATION: Final = 0x000F  # 4
FAULT_RESET: Final = 0x0080  # 15, at its rising edge

CONTROLWORDS: Final[dict[DriveState, tuple[int, int, int, int]]] = {
    # state: DISABLE, ENABLE, QUICK_STOP, ACKNOWLEDGE
    # A lost drive may still hear: brake.
    DriveState.OFFLINE: (QUICK_STOP, QUICK_STOP, QUICK_STOP, QUICK_STOP),
    DriveState.NOT_READY_TO_SWITCH_ON: (DISABLE_VOLTAGE,) * 4,
    DriveState.SWITCH_ON_DISABLED: (DISABLE_VOLTAGE, SHUTDOWN, DISABLE_VOLTAGE, DISABLE_VOLTAGE),
    DriveState.READY_TO_SWITCH_ON: (DISABLE_VOLTAGE, SWITCH_ON, QUICK_STOP, DISABLE_VOLTAGE),
    DriveState.SWITCHED_ON: (SHUTDOWN, ENABLE_OPERATION, QUICK_STOP, SHUTDOWN),
    # Disabling goes by "disable operation": the drive brakes on its ramp (0x605C = 1) before the power stage opens.
    DriveState.OPERATION_ENABLED: (SWITCH_ON, ENABLE_OPERATION, QUICK_STOP, SWITCH_ON),
    # Never interrupt a quick stop: "disable voltage" would let the axis coast, transition 16 would make it jump.
    # The drive leaves the state by itself at standstill (0x605A = 2).
    DriveState.QUICK_STOP_ACTIVE: (QUICK_STOP, QUICK_STOP, QUICK_STOP, QUICK_STOP),
    DriveState.FAULT_REACTION_ACTIVE: (DISABLE_VOLTAGE,) * 4,
    DriveState.FAULT: (DISABLE_VOLTAGE, DISABLE_VOLTAGE, DISABLE_VOLTAGE, FAULT_RESET),
}
# A drive that stays in QUICK_STOP_ACTIVE (0x605A = 5 to 8) leaves it by order, when it stands: 12, or 16 where it stands.
AT_REST_AFTER_QUICK_STOP: Final = (DISABLE_VOLTAGE, ENABLE_OPERATION, QUICK_STOP, DISABLE_VOLTAGE)
_CONTROLWORDS: Final = tuple(CONTROLWORDS[state] for state in DriveState)

FAULT_STATES: Final = (DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT)
RESET_PULSE_CYCLES: Final = 10  # so that a lost frame does not lose the edge
ACKNOWLEDGED_CYCLES: Final = 1000  # drives take their time; a fault that goes later goes by itself


@dataclass(slots=True)
class DriveControl:
    """The master's end of one drive's state machine.

    After a fault, or after the drive left OPERATION_ENABLED by itself, the drive is `locked`: it is enabled again
    only after the enable was withdrawn once, or after the fault was acknowledged. A fault that goes away by itself
    moves no axis.
    """

    state: DriveState = DriveState.OFFLINE
    locked: bool = False
    fell: bool = False  # in this cycle it left OPERATION_ENABLED, unordered and without a fault
    controlword: int = DISABLE_VOLTAGE  # the one last ordered
    stays: bool = False  # after a quick stop in QUICK_STOP_ACTIVE (option codes 5 to 8)
    standing: bool = False  # it has come to rest there
    _acknowledging: int = 0  # cycles that the reset bit still stands
    _acknowledged: int = 0  # cycles in which the fault may still go because of the reset
    _reset_before: bool = False

    def observe(self, statusword: int) -> DriveState:
        """Take the status word of this cycle."""
        before, self.state = self.state, _STATES[statusword & _STATE_BITS]
        faulted = self.state in FAULT_STATES
        self.fell = (
            before is DriveState.OPERATION_ENABLED
            and self.state is not DriveState.OPERATION_ENABLED
            and self.controlword == ENABLE_OPERATION
            and not faulted
        )
        if faulted or self.fell:
            self.locked = True
        elif before in FAULT_STATES:
            if self._acknowledged:
                self.locked = False
            self._acknowledged = self._acknowledging = 0
        if self.state is DriveState.FAULT_REACTION_ACTIVE:  # a new fault
            self._acknowledged = self._acknowledging = 0
        return self.state

    def order(self, enable: bool, quick_stop: bool, reset_fault: bool) -> int:
        """The control word of this cycle, from what the axis wants."""
        acknowledge = reset_fault and not self._reset_before
        self._reset_before = reset_fault
        if not enable and self.state not in FAULT_STATES:
            self.locked = False
        if acknowledge:
            if self.state is DriveState.FAULT:
                self._acknowledging = RESET_PULSE_CYCLES
                self._acknowledged = ACKNOWLEDGED_CYCLES
            elif self.state is not DriveState.FAULT_REACTION_ACTIVE:
                self.locked = False
        elif self._acknowledged:
            self._acknowledged -= 1
        if self._acknowledging and self.state is DriveState.FAULT:
            self._acknowledging -= 1
            wish = Wish.ACKNOWLEDGE
        elif quick_stop:
            wish = Wish.QUICK_STOP
        elif enable and not self.locked:
            wish = Wish.ENABLE
        else:
            wish = Wish.DISABLE
        self.controlword = _CONTROLWORDS[self.state][wish]
        if self.stays and self.standing and self.state is DriveState.QUICK_STOP_ACTIVE:
            self.controlword = AT_REST_AFTER_QUICK_STOP[wish]
        return self.controlword

    def lose(self) -> None:
        """The node does not answer any more."""
        self.state = DriveState.OFFLINE
        self.locked = True
