"""A machine around the decoder that does what a test has written down: answers change from one question to the next."""

from __future__ import annotations

from collections.abc import Callable
from datetime import datetime

from runtime.cnc.blocks import Message, TimerCommand, UserError
from runtime.cnc.decoder import Offline

NOW = datetime(2026, 11, 26, 14, 8, 10, 123_456)


class Machine(Offline):
    """Somebody is there: the decoder waits. `each_hold` is what happens outside whenever the decoder has asked in vain."""

    def __init__(self, each_hold: Callable[[Machine], None] = lambda machine: None) -> None:
        super().__init__()
        self.each_hold = each_hold
        self.told: list[tuple[int, Message]] = []
        self.taken_numbers: set[int] = set()
        self.rooms = 100
        self.commands: list[tuple[TimerCommand, int]] = []
        self.counts: dict[int, int] = {}
        self.probes: dict[int, float] = {}  # by the index of the axis
        self.cycles = 4711
        self.warnings: list[UserError] = []

    def now(self) -> datetime:
        return NOW

    def tell(self, message: Message) -> int:
        self.told.append((len(self.told) + 1, message))
        self.rooms -= 1
        return len(self.told)

    def taken(self, number: int) -> bool:
        return number in self.taken_numbers

    def room(self) -> bool:
        return self.rooms > 0

    def error(self, error: UserError) -> None:
        self.warnings.append(error)

    def timer(self, command: TimerCommand, timer: int) -> int:
        self.commands.append((command, timer))
        return self.counts.get(timer, 0)

    def latched(self, timer: int) -> int:
        return self.counts.get(timer, 0) + 1000

    def probed(self, axis: int) -> float | None:
        return self.probes.get(axis)

    def cycle(self) -> int:
        """It goes on from one question to the next."""
        self.cycles += 1
        return self.cycles

    def changes_files(self) -> bool:
        return True

    def waits_in_vain(self) -> bool:
        return False

    @property
    def texts(self) -> list[str]:
        return [message.text for _, message in self.told]
