"""The CiA 402 state machine inside a drive: commands and numbered transitions, as a table.

Source: IEC 61800-7-201 (CiA 402-2), "Finite state automaton of the PDS"; the numbers are those of its figure.
Transitions 0, 1, 13 and 14 happen by themselves.
"""

from __future__ import annotations

from enum import IntEnum
from typing import Final, NamedTuple

from runtime.drives import DriveState


class Command(IntEnum):
    """What a control word orders."""

    NONE = 0
    SHUTDOWN = 1
    SWITCH_ON = 2  # for an enabled drive: disable operation
    ENABLE_OPERATION = 3
    DISABLE_VOLTAGE = 4
    QUICK_STOP = 5
    FAULT_RESET = 6


# mask, value, command; bit 7 (fault reset) acts by its rising edge and is looked at first
COMMAND_PATTERNS: Final = (
    (0b1000_0010, 0b0000_0000, Command.DISABLE_VOLTAGE),
    (0b1000_0110, 0b0000_0010, Command.QUICK_STOP),
    (0b1000_0111, 0b0000_0110, Command.SHUTDOWN),
    (0b1000_1111, 0b0000_0111, Command.SWITCH_ON),
    (0b1000_1111, 0b0000_1111, Command.ENABLE_OPERATION),
)
FAULT_RESET_BIT: Final = 0x80


def command_of(controlword: int, before: int) -> Command:
    """The command of a control word, given the one before it (for the edge of the fault reset)."""
    if controlword & ~before & FAULT_RESET_BIT:
        return Command.FAULT_RESET
    for mask, value, command in COMMAND_PATTERNS:
        if controlword & mask == value:
            return command
    return Command.NONE


class Transition(NamedTuple):
    number: int
    target: DriveState


_NOT_READY, _DISABLED = DriveState.NOT_READY_TO_SWITCH_ON, DriveState.SWITCH_ON_DISABLED
_READY, _ON = DriveState.READY_TO_SWITCH_ON, DriveState.SWITCHED_ON
_ENABLED, _QUICK_STOP = DriveState.OPERATION_ENABLED, DriveState.QUICK_STOP_ACTIVE
_REACTION, _FAULT = DriveState.FAULT_REACTION_ACTIVE, DriveState.FAULT

AUTOMATIC: Final = {
    _NOT_READY: Transition(1, _DISABLED),  # self test done
    _REACTION: Transition(14, _FAULT),  # at standstill
}
FAULT_TRANSITION: Final = Transition(13, _REACTION)

COMMANDED: Final[dict[tuple[DriveState, Command], Transition]] = {
    (_DISABLED, Command.SHUTDOWN): Transition(2, _READY),
    (_READY, Command.SWITCH_ON): Transition(3, _ON),
    (_READY, Command.ENABLE_OPERATION): Transition(3, _ON),  # and at once 4
    (_ON, Command.ENABLE_OPERATION): Transition(4, _ENABLED),
    (_ENABLED, Command.SWITCH_ON): Transition(5, _ON),
    (_ON, Command.SHUTDOWN): Transition(6, _READY),
    (_READY, Command.QUICK_STOP): Transition(7, _DISABLED),
    (_READY, Command.DISABLE_VOLTAGE): Transition(7, _DISABLED),
    (_ENABLED, Command.SHUTDOWN): Transition(8, _READY),
    (_ENABLED, Command.DISABLE_VOLTAGE): Transition(9, _DISABLED),
    (_ON, Command.DISABLE_VOLTAGE): Transition(10, _DISABLED),
    (_ON, Command.QUICK_STOP): Transition(10, _DISABLED),
    (_ENABLED, Command.QUICK_STOP): Transition(11, _QUICK_STOP),
    (_QUICK_STOP, Command.DISABLE_VOLTAGE): Transition(12, _DISABLED),
    (_FAULT, Command.FAULT_RESET): Transition(15, _DISABLED),
    (_QUICK_STOP, Command.ENABLE_OPERATION): Transition(16, _ENABLED),  # only if it stays there (0x605A = 5...8)
}

# Status words without the bits of mode and motion. Bit 4: voltage enabled, bit 5: no quick stop, bit 9: remote.
STATUSWORDS: Final[dict[DriveState, int]] = {
    _NOT_READY: 0x0000,
    _DISABLED: 0x0250,
    _READY: 0x0231,
    _ON: 0x0233,
    _ENABLED: 0x0237,
    _QUICK_STOP: 0x0217,
    _REACTION: 0x021F,
    _FAULT: 0x0218,
}
