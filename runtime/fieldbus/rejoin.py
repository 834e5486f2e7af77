"""A node that was lost comes back while the machine runs: reset, checked, configured and started as at boot, but by steps.

Each cycle takes one look at one outstanding SDO answer per node, so a node that comes back costs a frame per cycle at most and
the other nodes notice nothing. The drive comes back disabled; its axis tracks until somebody acknowledges.

    LISTENING ─ sign of life, or 5 s ─▶ RESETTING ─ boot-up message ─▶ TALKING ─ dialogue over ─▶ STARTING ─ operational ─▶ joined
        ▲────────────────────────── no answer, refused, booted again ───────────┴────────────────┘
"""

from __future__ import annotations

from collections.abc import Callable
from enum import Enum
from typing import Final

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import TandemError
from runtime.drives import DriveEvent
from runtime.fieldbus.boot import OPERATIONAL, SECOND_BOOT_UP
from runtime.fieldbus.dialogue import Dialogue, NodeDialogues, refused
from runtime.fieldbus.links import DriveLink, IoLink
from runtime.fieldbus.questions import Questions

BOOT_LIMIT: Final = 3.0  # s for the boot-up message, and for the first heartbeat in operation
PAUSE: Final = 2.0  # s after a refusal until it is tried again
UNHEARD: Final = (
    5.0  # s after which a node is reset unheard: one whose reset went well, and its answer not, has no heartbeat
)

START: Final = 1
RESET_COMMUNICATION: Final = 130
BOOT_UP: Final = 0


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
        self._doubled = False  # two boot-up messages came at once
        self._reset_at = now  # s, when it booted
        self._dialogue: Dialogue | None = None
        self._questions = Questions(link, send)

    def on_heartbeat(self, state: int) -> None:
        """A sign of life of the node: its NMT state."""
        self._alive = True
        if state == BOOT_UP:
            self._doubled = self._booted
            self._booted = True

    def on_answer(self, data: bytes | bytearray) -> None:
        """A frame of the node's SDO server."""
        self._questions.on_answer(data)

    def step(self, now: float) -> bool:
        """One cycle at the time `now` (s); True when the node is in operation again."""
        match self.stage:
            case Stage.LISTENING:
                if now >= self._limit and (self._alive or now >= self._limit + UNHEARD):
                    self._booted = self._doubled = False
                    self._send(0, bytes((RESET_COMMUNICATION, self.link.node)))
                    self._enter(Stage.RESETTING, now + BOOT_LIMIT)
            case Stage.RESETTING:
                if self._doubled:
                    self._refuse(refused(catalogue.NODE_DOUBLE, self.link), now)
                elif self._booted:
                    self._booted = False
                    self._reset_at = now
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
        self._alive = False
        self._questions.forget()
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
        if self._booted:  # again: what was said so far is forgotten
            if now - self._reset_at < SECOND_BOOT_UP:
                self._refuse(refused(catalogue.NODE_DOUBLE, self.link), now)
            else:
                self._listen(now)
            return
        try:
            number = self._questions.poll(now)
        except TandemError as error:
            self._refuse(error, now)
            return
        if number is not None:
            self._go_on(number, now)

    def _go_on(self, answer: int | None, now: float) -> None:
        """Ask for the next object, or start the node when all is said."""
        assert self._dialogue is not None
        try:
            self._questions.ask(next(self._dialogue) if answer is None else self._dialogue.send(answer), now)
        except StopIteration:
            self.link.nmt_state = BOOT_UP
            self._send(0, bytes((START, self.link.node)))
            self._enter(Stage.STARTING, now + BOOT_LIMIT)
        except TandemError as error:
            self._refuse(error, now)
