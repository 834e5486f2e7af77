"""A node that was lost comes back while the machine runs: reset, checked, configured and started as at boot, but by steps.

Each cycle takes one look at one outstanding SDO answer per node, so a node that comes back costs a frame per cycle at most and
the other nodes notice nothing. The drive comes back disabled; its axis tracks until somebody acknowledges.

    LISTENING ─ any sign of life ─▶ RESETTING ─ boot-up message ─▶ TALKING ─ dialogue over ─▶ STARTING ─ operational ─▶ joined
        ▲────────────────────────── no answer, refused, booted again ───────────┴────────────────┘
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from enum import Enum
from typing import Final

from runtime.diagnostics.errors import TandemError
from runtime.drives import DriveEvent
from runtime.fieldbus.boot import OPERATIONAL
from runtime.fieldbus.dialogue import Access, Dialogue, NodeDialogues, aborted, decoded, encoded, silent
from runtime.fieldbus.links import DriveLink, IoLink

ANSWER_LIMIT: Final = 0.5  # s for an SDO answer
QUESTIONS: Final = 3  # times that the same is asked
BOOT_LIMIT: Final = 3.0  # s for the boot-up message, and for the first heartbeat in operation
PAUSE: Final = 2.0  # s after a refusal until it is tried again

START: Final = 1
RESET_COMMUNICATION: Final = 130
BOOT_UP: Final = 0
UPLOAD: Final = 0x40  # command specifiers of an expedited SDO transfer (CiA 301)
UPLOADED: Final = 0x43
DOWNLOAD: Final = 0x23
DOWNLOADED: Final = 0x60
ABORT: Final = 0x80
_SPECIFIER: Final = 0xE3  # without the bits that tell the number of unused bytes


class Stage(Enum):
    LISTENING = 0
    RESETTING = 1
    TALKING = 2
    STARTING = 3


class Rejoin:
    """The way back of one lost node. `send(cob_id, data)` puts a frame on the bus; what it raises comes through."""

    def __init__(
        self, link: DriveLink | IoLink, dialogues: NodeDialogues, send: Callable[[int, bytes], None], now: float
    ) -> None:
        self.link = link
        self.stage = Stage.LISTENING
        self.refusal: TandemError | None = None  # the last one, until it is taken
        self.told: DriveEvent | None = None  # for whoever tells it
        self._dialogues = dialogues
        self._send = send
        self._limit = now  # end of the patience of this stage; while listening: not before
        self._alive = False
        self._booted = False
        self._dialogue: Dialogue | None = None
        self._access: Access | None = None
        self._answer: bytes | None = None
        self._frame = b""  # the question that is outstanding
        self._questions = 0  # how often it was asked

    def on_heartbeat(self, state: int) -> None:
        """A sign of life of the node: its NMT state."""
        self._alive = True
        if state == BOOT_UP:
            self._booted = True

    def on_answer(self, data: bytes | bytearray) -> None:
        """A frame of the node's SDO server."""
        if len(data) == 8 and self._access is not None:
            index, subindex = struct.unpack_from("<HB", data, 1)
            if (index, subindex) == (
                self._access.index,
                self._access.subindex,
            ):  # else it answers what was asked before
                self._answer = bytes(data)

    def step(self, now: float) -> bool:
        """One cycle at the time `now` (s); True when the node is in operation again."""
        match self.stage:
            case Stage.LISTENING:
                if self._alive and now >= self._limit:
                    self._booted = False
                    self._send(0, bytes((RESET_COMMUNICATION, self.link.node)))
                    self._enter(Stage.RESETTING, now + BOOT_LIMIT)
            case Stage.RESETTING:
                if self._booted:
                    self._booted = False
                    self._dialogue = self._talk()
                    self._enter(Stage.TALKING, now)
                    self._go_on(None, now)
                elif now > self._limit:
                    self._listen(now)
            case Stage.TALKING:
                self._hear(now)
            case Stage.STARTING:
                if self._booted or now > self._limit:
                    self._listen(now)
                return self.link.nmt_state == OPERATIONAL and self.stage is Stage.STARTING
        return False

    def _enter(self, stage: Stage, limit: float) -> None:
        self.stage, self._limit = stage, limit

    def _listen(self, now: float) -> None:
        self._alive, self._access, self._answer = False, None, None
        self._enter(Stage.LISTENING, now + PAUSE)

    def _refuse(self, error: TandemError, now: float) -> None:
        self.refusal = error
        self._listen(now)
        self._alive = True  # a node that is not configured may have no heartbeat: it is asked again unheard

    def _talk(self) -> Dialogue:
        yield from self._dialogues.identify(self.link)
        yield from self._dialogues.configure(self.link)
        yield from self._dialogues.first_values(self.link)

    def _hear(self, now: float) -> None:
        """One look at the answer that is outstanding."""
        assert self._access is not None  # in this stage something has always been asked
        if self._booted:  # again: what was said so far is forgotten
            self._listen(now)
        elif self._answer is not None:
            try:
                number = self._understood(self._access, self._answer)
            except TandemError as error:
                self._refuse(error, now)
            else:
                self._go_on(number, now)
        elif now > self._limit:
            if self._questions < QUESTIONS:
                self._question(now)
            else:
                self._refuse(silent(self.link, self._access, "no answer"), now)

    def _question(self, now: float) -> None:
        """Ask, or ask again: question or answer may have been lost, and all of them may be carried out twice."""
        self._questions += 1
        self._limit = now + ANSWER_LIMIT
        self._send(0x600 + self.link.node, self._frame)

    def _understood(self, access: Access, answer: bytes) -> int:
        """The number in an answer, 0 for a write. Raises FieldbusError."""
        if answer[0] == ABORT:
            raise aborted(self.link, access, int.from_bytes(answer[4:], "little"))
        if access.value is not None:
            if answer[0] != DOWNLOADED:
                raise silent(self.link, access, f"an answer that is none (0x{answer[0]:02X})")
            return 0
        if answer[0] & _SPECIFIER != UPLOADED & _SPECIFIER:
            raise silent(self.link, access, f"an answer that is no number (0x{answer[0]:02X})")
        unused = answer[0] >> 2 & 3 if answer[0] & 1 else 0
        try:
            return decoded(self.link, access, answer[4 : 8 - unused])
        except (struct.error, ValueError) as error:
            raise silent(self.link, access, str(error)) from error

    def _go_on(self, answer: int | None, now: float) -> None:
        """Ask for the next object, or start the node when all is said."""
        assert self._dialogue is not None
        self._answer = None
        try:
            access = next(self._dialogue) if answer is None else self._dialogue.send(answer)
            head = struct.pack("<HB", access.index, access.subindex)
            if access.value is None:
                frame = bytes((UPLOAD,)) + head + bytes(4)
            else:
                data = encoded(self.link, access)
                frame = bytes((DOWNLOAD | 4 - len(data) << 2,)) + head + data.ljust(4, b"\0")
        except StopIteration:
            self._access = None
            self.link.nmt_state = BOOT_UP
            self._send(0, bytes((START, self.link.node)))
            self._enter(Stage.STARTING, now + BOOT_LIMIT)
        except TandemError as error:
            self._refuse(error, now)
        else:
            self._access, self._frame, self._questions = access, frame, 0
            self._question(now)
