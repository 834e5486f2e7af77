"""What a program has open between path and spindle: feed per revolution, a thread or a chain of them, tapping.

    G33 Z.. K..             begin ─ line ─ end                           each block comes to the spindle anew
    chain of G33            begin ─ line ─ line ─ ... ─ end              until a block that is no plain G33
    G63, G331, G332         begin ─ line, stop ─ line, stop ─ ... ─ end  until another kind of motion

An end belongs in front of whatever the next block puts out, so every block asks (`before`) before it begins.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import TYPE_CHECKING

from runtime.cnc.blocks import Flush, FlushKind, RevolutionFeed, Source, SpindleRole, SpindleSection
from runtime.cnc.decoder.modal import TAPPING, FeedMode, Motion
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

_PLAIN = frozenset({WordKind.AXIS, WordKind.INTERPOLATION, WordKind.G, WordKind.ASSIGNMENT})
_OF_CHAIN = frozenset({33, 90, 91})


@dataclass(slots=True)
class SpindleSections:
    """Of one program run. Pitches in mm per revolution, angles in degrees, speeds in rev/min."""

    role: SpindleRole = SpindleRole.FREE
    spindle: int = -1
    feed_of: tuple[int, float] | None = None  # G95: spindle, and the speed that feeds are made with
    # G33
    pitch: tuple[int, float] | None = None  # axis, and pitch
    offset: float = 0.0
    chain: bool = False  # THREAD_CHAIN
    measured: bool = False  # THREAD_CUT_ACT_SPEED
    cycles: int = 0  # THREAD_CUT_N_CYCLES
    steady: bool = False  # THREAD_CUT_IGNORE_OV
    # G63, G331, G332
    speed: float = 0.0  # below 0: the other way round
    tapped: tuple[int, float] | None = None  # axis and pitch of the last G331
    retract_speed: float | None = None  # of G332, None: that of G331

    @property
    def tapping(self) -> bool:
        """The main spindle follows the path."""
        return self.role is SpindleRole.TAPPING

    @property
    def watches(self) -> bool:
        """Every block has to be looked at before it is executed: none may take the fast road."""
        return self.role is not SpindleRole.FREE or self.feed_of is not None

    # ------------------------------------------------------------------ sections

    def open(self, x: Execution, role: SpindleRole, spindle: int) -> None:
        """A section begins here, if it has not begun yet; what was before it is driven to its end."""
        if self.role is not SpindleRole.FREE:
            return
        x.emit(Flush(x.source, FlushKind.STOP))
        if role is SpindleRole.THREAD:
            begin = SpindleSection(x.source, role, spindle, self.offset, self.measured, self.cycles, self.steady)
        else:
            begin = SpindleSection(x.source, role, spindle)
        x.emit(begin)
        self.role, self.spindle = role, spindle
        x.modal_changed()

    def close(self, x: Execution, source: Source | None = None) -> None:
        """The section ends here, if one is open."""
        if self.role is not SpindleRole.FREE:
            x.emit(SpindleSection(source or x.source, SpindleRole.FREE, self.spindle))
            self.role, self.spindle = SpindleRole.FREE, -1
            x.modal_changed()

    def before(self, x: Execution, block: CompiledBlock) -> None:
        """A block of words begins; its G functions are executed."""
        ends = self.tapping and x.modal.motion not in TAPPING
        if ends or (self.role is SpindleRole.THREAD and not self._goes_on(x, block)):
            self.close(x)

    def before_statement(self, x: Execution) -> None:
        """A # statement ends a chain of threads."""
        if self.role is SpindleRole.THREAD:
            self.close(x)

    def _goes_on(self, x: Execution, block: CompiledBlock) -> bool:
        """Whether a block is the next one of a chain."""
        plain = all(word.kind in _PLAIN for word in block.words)
        plain = plain and all(slots.word.index in _OF_CHAIN for slots in block.g)
        return self.chain and plain and bool(block.axes) and x.modal.motion is Motion.THREAD

    # ------------------------------------------------------------------ feed per revolution

    def tell_feed(self, x: Execution) -> None:
        """Feed mode, main spindle and speed of the block are known: with what its feed is made. A spindle of the PLC is not
        followed (line 23148): only what is programmed counts."""
        told = None
        modal, main = x.modal, x.spindles.main
        if modal.feed_mode is FeedMode.PER_REVOLUTION and modal.speed > 0.0 and not x.setup.spindles[main].plc:
            told = (main, modal.speed)
        if told != self.feed_of:
            self.feed_of = told
            x.emit(RevolutionFeed(x.source, *(told or (-1, 0.0))))
            x.modal_changed()
