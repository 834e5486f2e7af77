"""What the listener on the wire has written, and what can be concluded from it without asking the runtime."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from runtime.fieldbus import wire
from tests.vm.guest.wire_log import RECORD

SYNC: Final = 0x80
ENABLE_OPERATION: Final = 0x0F
ERROR_FLAG: Final = 0x2000_0000


@dataclass(frozen=True, slots=True)
class Frame:
    time: float  # s since 1970
    identifier: int
    data: bytes


def read(file: Path) -> list[Frame]:
    """All frames in the order in which they came."""
    return [
        Frame(time, identifier, data[:length])
        for time, identifier, length, data in RECORD.iter_unpack(file.read_bytes())
    ]


def between(frames: list[Frame], begin: float, end: float) -> list[Frame]:
    return [frame for frame in frames if begin <= frame.time < end]


def cycles(frames: list[Frame]) -> Iterator[list[Frame]]:
    """The frames up to and with each SYNC, after the first one."""
    current: list[Frame] | None = None
    for frame in frames:
        if current is not None:
            current.append(frame)
        if frame.identifier == SYNC:
            if current is not None:
                yield current
            current = []


def targets(frames: list[Frame], node: int) -> list[tuple[float, int]]:
    """(time, target position in increments) of each set-point that the master sent with "enable operation"."""
    return [
        (frame.time, int.from_bytes(frame.data[2:6], "little", signed=True))
        for frame in frames
        if frame.identifier == 0x200 + node and frame.data[0] | frame.data[1] << 8 == ENABLE_OPERATION
    ]


def control_words(frames: list[Frame], node: int) -> list[int]:
    """The control words that the master sent to a drive, each once where it changes."""
    words: list[int] = []
    for frame in frames:
        if frame.identifier == 0x200 + node and (word := frame.data[0] | frame.data[1] << 8) not in words[-1:]:
            words.append(word)
    return words


def largest_step(frames: list[Frame], node: int) -> int:
    """Increments: the largest difference of a set-point to the one before, or to where the drive then was.

    A drive that is enabled anew begins from its own position, so its last feedback counts as set-point before.
    """
    reference: int | None = None
    worst = 0
    for frame in frames:
        if frame.identifier == 0x180 + node and len(frame.data) == 6 and reference is None:
            reference = int.from_bytes(frame.data[2:6], "little", signed=True)
        if frame.identifier != 0x200 + node:
            continue
        word = frame.data[0] | frame.data[1] << 8
        target = int.from_bytes(frame.data[2:6], "little", signed=True)
        if word != ENABLE_OPERATION:
            reference = None
            continue
        if reference is not None:
            worst = max(worst, abs(target - reference))
        reference = target
    return worst


def load(frames: list[Frame], seconds: float, bitrate: float) -> float:
    """Share of the bus that these frames took."""
    return sum(wire.FRAME_BITS[len(frame.data)] for frame in frames) / (seconds * bitrate)
