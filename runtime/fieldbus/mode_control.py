"""Modes of operation at run time, as the master orders them: which mode, which bits of the control word, homing by the drive.

The set-points of the axis are followed in the drive's own mode only; in every other one the drive moves by itself, and the axis
tracks it (`by_drive`) until the drive shows its own mode again.

Homing, by its phases:

    NONE ─ requested ─▶ ENTERING ─ mode shown ─▶ RUNNING ─ attained or error ─▶ LEAVING ─ mode shown ─▶ OVER ─ taken back ─▶ NONE
                            └──── taken back ──────┴──▶ STOPPING ─ at rest ─────────┘

A drive that is disabled meanwhile, or does not show the mode in time, has failed. Source: IEC 61800-7-201, homing mode.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from enum import Enum, auto
from typing import Final

from runtime.drives import DriveMode, HomingState
from runtime.fieldbus.cia402 import (
    CHANGE_AT_ONCE,
    HALT,
    MODE_BIT_12,
    MODE_BIT_13,
    NEW_SET_POINT,
    TARGET_REACHED,
)

MODE_TIME: Final = 1.0  # s that a drive gets to show a mode
STOP_TIME: Final = 5.0  # s that a drive gets to stop its homing
UNSEEN: Final = 0.1  # s after which "attained" counts although the homing was never seen under way
SETTLED: Final = 0.02  # s for which bits 10 and 12 say "interrupted" before it is believed
_FOLLOWS: Final = (DriveMode.CYCLIC_SYNCHRONOUS_POSITION, DriveMode.INTERPOLATED_POSITION)


class Phase(Enum):
    """Of a homing."""

    NONE = auto()
    ENTERING = auto()
    RUNNING = auto()
    STOPPING = auto()
    LEAVING = auto()
    OVER = auto()


@dataclass(slots=True)
class ModeControl:
    """One drive. `order` in every cycle, after the status word has been taken."""

    configured: DriveMode
    available: frozenset[DriveMode]
    period: float  # s
    ordered: DriveMode = DriveMode.CONFIGURED
    shown: int = 0  # what the drive says (0x6061)
    homing: HomingState = HomingState.IDLE
    attained: bool = False  # in this cycle the drive has said that it has its reference
    refused: bool = False  # in this cycle the drive has failed to show a mode
    homing_error: bool = False  # in this cycle the drive tells one
    _phase: Phase = Phase.NONE
    _result: HomingState = HomingState.IDLE
    _time: float = 0.0  # s in this phase
    _seen: bool = False  # the homing was seen under way
    _interrupted: float = 0.0  # s
    _waiting: float = 0.0  # s, for the ordered mode
    _target: int | None = None  # last one that was given in profile position mode
    _giving: bool = False
    _wanted: DriveMode = field(default=DriveMode.CONFIGURED)

    def __post_init__(self) -> None:
        self.ordered = self.configured
        self.shown = self.configured

    @property
    def settled(self) -> bool:
        """The drive shows the mode that is ordered."""
        return self.shown == self.ordered

    @property
    def ready_to_home(self) -> bool:
        """The drive shows the homing mode, as ordered."""
        return self.settled and self.ordered is DriveMode.HOMING

    @property
    def by_drive(self) -> bool:
        """The axis does not say where the drive goes."""
        return not (self.settled and self.ordered is self.configured and self._phase in (Phase.NONE, Phase.OVER))

    def order(
        self, wanted: int, home: bool, halt: bool, enabled: bool, status: int, target: int, *, together: bool = True
    ) -> int:
        """The bits of the control word beside those of the state machine, 0 for a drive that is not enabled.

        `wanted`: a `DriveMode`; `target`: of profile position mode, increments; `status`: the status word of this cycle;
        `together`: who has to home at the same time is ready for it.
        """
        self.attained = self.refused = self.homing_error = False
        self._time += self.period
        self._home(home, halt, enabled, status, together)
        if self._phase in (Phase.ENTERING, Phase.RUNNING, Phase.STOPPING):
            self._choose(DriveMode.HOMING)
        elif wanted in self.available and wanted:
            self._choose(DriveMode(wanted))
        else:
            self._choose(self.configured)
        self._watch_mode()
        if not enabled:
            self._target, self._giving = None, False
            return 0
        bits = HALT if halt and self._phase is not Phase.LEAVING else 0
        if self._phase is Phase.RUNNING:
            return bits | NEW_SET_POINT
        if self._phase is Phase.STOPPING:
            return HALT | NEW_SET_POINT if self.settled else 0
        if not self.settled:
            return 0
        if self.ordered is DriveMode.INTERPOLATED_POSITION:
            return bits | NEW_SET_POINT
        if self.ordered is DriveMode.PROFILE_POSITION:
            return bits | self._hand_over(target, status)
        return bits

    def lose(self) -> None:
        """The node is gone; it comes back in its configured mode."""
        if self._phase not in (Phase.NONE, Phase.OVER):
            self._end(HomingState.FAILED)
        self.ordered = self.configured
        self.shown = self.configured

    def _choose(self, mode: DriveMode) -> None:
        if mode is not self.ordered:
            self.ordered, self._waiting = mode, 0.0
            self._target, self._giving = None, False

    def _watch_mode(self) -> None:
        if self.settled:
            self._waiting = 0.0
            return
        before, self._waiting = self._waiting, self._waiting + self.period
        self.refused = before < MODE_TIME <= self._waiting

    def _hand_over(self, target: int, status: int) -> int:
        """Bit 4 rises with a new target and falls when bit 12 has acknowledged it."""
        acknowledged = bool(status & MODE_BIT_12)
        if self._giving:
            self._giving = not acknowledged
        elif target != self._target and not acknowledged:
            self._target, self._giving = target, True
        return NEW_SET_POINT | CHANGE_AT_ONCE if self._giving else 0

    @property
    def profile_target(self) -> int | None:
        """The target that profile position mode is being given; it must not change during the handshake."""
        return self._target

    # -- homing ------------------------------------------------------------------------------------------------------

    def _enter(self, phase: Phase) -> None:
        self._phase, self._time = phase, 0.0
        self._seen, self._interrupted = False, 0.0

    def _leave(self, result: HomingState) -> None:
        self._result = result
        self._enter(Phase.LEAVING)

    def _end(self, state: HomingState) -> None:
        self.homing = state
        self._enter(Phase.OVER)

    def _home(self, home: bool, halt: bool, enabled: bool, status: int, together: bool) -> None:
        match self._phase:
            case Phase.NONE:
                if not home:
                    return
                if enabled and DriveMode.HOMING in self.available:
                    self.homing = HomingState.RUNNING
                    self._enter(Phase.ENTERING)
                else:
                    self._end(HomingState.FAILED)
            case Phase.OVER:
                if not home:
                    self.homing = HomingState.IDLE
                    self._enter(Phase.NONE)
            case _ if not enabled:
                self._end(HomingState.FAILED)
            case Phase.ENTERING:
                if not home:
                    self._stop()
                elif self.ready_to_home and together:
                    self._enter(Phase.RUNNING)
                elif self._time > MODE_TIME:
                    self._leave(HomingState.FAILED)
            case Phase.RUNNING:
                if not home:
                    self._stop()
                elif not halt:
                    self._watch_homing(status)
            case Phase.STOPPING:
                if (status & TARGET_REACHED and self._time > 3.0 * self.period) or self._time > STOP_TIME:
                    self._leave(HomingState.IDLE)
            case Phase.LEAVING:
                if self.settled and self.ordered is self.configured:
                    self._end(self._result)
                elif self._time > MODE_TIME:
                    self._end(HomingState.FAILED)

    def _stop(self) -> None:
        self.homing = HomingState.STOPPING
        self._enter(Phase.STOPPING)

    def _watch_homing(self, status: int) -> None:
        """Bits 13, 12 and 10 of the status word: error, attained, at rest."""
        error, attained, rests = status & MODE_BIT_13, status & MODE_BIT_12, status & TARGET_REACHED
        if not (error or attained or rests):
            self._seen = True
            self._interrupted = 0.0
        elif error:
            self.homing_error = self._time > 3.0 * self.period  # one of before may still stand
            if rests and self.homing_error:
                self._leave(HomingState.FAILED)
        elif attained:
            # what was attained before may still stand until the drive has begun
            if rests and (self._seen or self._time > UNSEEN):
                self.attained = True
                self._leave(HomingState.DONE)
        elif self._seen:
            self._interrupted += self.period
            if self._interrupted > SETTLED:
                self._leave(HomingState.FAILED)
