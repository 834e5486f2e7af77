"""What the decoder asks and tells at decoding time: the machine around it, seen through one small protocol.

In the runtime the preparation process stands behind it (HLI, clock, report files); `Offline` stands in where there is no
machine (`tandem check`, `tandem blocks`, tests).
"""

from __future__ import annotations

from collections.abc import Sequence
from datetime import datetime
from typing import Protocol

from runtime.cnc.blocks import Floats, Message, TimerCommand, UserError
from runtime.hli.layout import Mode
from runtime.hli.tools import Identity, RequestKind, ToolAnswered

EXTERNAL_BYTES = 65536  # of the area of external variables


class WaitForOutside(Exception):  # noqa: N818 - it is none: the block is executed again
    """A value is not there yet. The text says what is waited for."""


class Outside(Protocol):
    """Positions hold after a `Flush` of kind WAIT was yielded and the decoder was asked to go on; (n_axes,), mm or degrees."""

    @property
    def external(self) -> memoryview:
        """The area of the external variables (V.E), EXTERNAL_BYTES bytes, shared with the PLC."""

    def command_position(self) -> Floats | None:
        """Command position in machine coordinates, None where no machine is: the decoded position is meant then."""

    def actual_position(self) -> Floats | None:
        """Actual position in machine coordinates, None where no machine is."""

    def manual_offsets(self) -> Floats | None:
        """What the axes were moved by hand beside the path, None where no machine is."""

    def referenced(self, axis: int) -> bool:
        """The axis (index in the channel) has its reference; holds as the positions do."""

    def parked(self, axis: int) -> bool:
        """The axis is out of use; holds as the positions do."""

    def now(self) -> datetime:
        """The wall clock, for time stamps."""

    def tell(self, message: Message) -> int:
        """Put out a message at decoding time; its number, for `taken`."""

    def taken(self, number: int) -> bool:
        """The receiver has taken the message with this number."""

    def room(self) -> bool:
        """One more message or warning can be told now; else the decoder holds (`Hold`) and asks again."""

    def error(self, error: UserError) -> None:
        """A warning of #ERROR (remedy class 0), told at decoding time."""

    def timer(self, command: TimerCommand, timer: int) -> int:
        """Act on a counter (0…127) at decoding time; its value in ms."""

    def latched(self, timer: int) -> int:
        """The count in ms that the last READ on the path has found; holds as the positions do."""

    def probed(self, axis: int) -> float | None:
        """What MC_TouchProbe has recorded of an axis (index in the machine), None before its edge; holds as the positions do."""

    def measured(self) -> dict[int, float] | None:
        """What the last measuring run has found: axis (index in the channel) → machine position, mm or degrees; only axes that
        have a value. None where no machine is: the run is taken to end at its target. Holds as the positions do."""

    def cycle(self) -> int:
        """Number of the interpolator's cycle, counted from the start of the control."""

    def operating_mode(self) -> int:
        """The mode that the program was started in, as the HLI numbers it."""

    def searching(self) -> bool:
        """A block search leaves out what the program does now."""

    def has_tool_management(self) -> bool:
        """Somebody is there who answers for an external tool management."""

    def ask_tool(self, kind: RequestKind, tool: Identity, parameters: Sequence[float] = ()) -> int:
        """A request to the external tool management; its number, for `tool_answered`. Not more than three at a time."""

    def tool_answered(self, request: int) -> ToolAnswered | None:
        """The answer to a request for data, None as long as there is none."""

    def changes_files(self) -> bool:
        """Report files are written, files renamed and deleted; a check leaves all files as they are."""

    def waits_in_vain(self) -> bool:
        """Nobody will ever change what the decoder waits for (no machine there): waiting ends at once."""


class Offline:
    """No machine: external variables are memory of one's own, messages are collected, nobody makes anybody wait."""

    def __init__(self) -> None:
        self._external = bytearray(EXTERNAL_BYTES)
        self.messages: list[Message] = []
        self.errors: list[UserError] = []

    @property
    def external(self) -> memoryview:
        return memoryview(self._external)

    def command_position(self) -> Floats | None:
        return None

    def actual_position(self) -> Floats | None:
        return None

    def manual_offsets(self) -> Floats | None:
        return None

    def referenced(self, axis: int) -> bool:
        return True

    def parked(self, axis: int) -> bool:
        return False

    def now(self) -> datetime:
        return datetime(2000, 1, 1)

    def tell(self, message: Message) -> int:
        self.messages.append(message)
        return len(self.messages)

    def taken(self, number: int) -> bool:
        return True

    def room(self) -> bool:
        return True

    def error(self, error: UserError) -> None:
        self.errors.append(error)

    def timer(self, command: TimerCommand, timer: int) -> int:
        return 0

    def probed(self, axis: int) -> float | None:
        return None

    def measured(self) -> dict[int, float] | None:
        return None

    def latched(self, timer: int) -> int:
        return 0

    def cycle(self) -> int:
        return 0

    def operating_mode(self) -> int:
        """A check takes the ways through the program that the machine takes in automatic mode."""
        return int(Mode.AUTOMATIC)

    def searching(self) -> bool:
        return False

    def has_tool_management(self) -> bool:
        return False

    def ask_tool(self, kind: RequestKind, tool: Identity, parameters: Sequence[float] = ()) -> int:
        return 0

    def tool_answered(self, request: int) -> ToolAnswered | None:
        return None

    def changes_files(self) -> bool:
        return False

    def waits_in_vain(self) -> bool:
        return True
