"""Technology functions (M, H, S, T) on their way from the CNC to the PLC and back: the two-step handshake of the units.

    CNC                                   unit                        PLC
    put: data, done_w := 0, please := 1   ─────▶  function waits
                                                  taken        ◀───── take: copies, please := 0
                                                  executed     ◀───── done: done_w := 1
    poll: unit is free again              ◀─────

A kind without acknowledgement (MOS) ends when it is taken; its `done_w` stays untouched, because the CNC may already
have filled the unit again.

Order: a function goes into the unit behind the last one in use, and the array starts again from index 0 when all
units are free. So the functions of one block lie without gaps from index 0, in the order of their output, as long as
those of the block before are done; where those are merely taken late (MOS), they follow behind instead of stopping
the path. Late functions (MVS_SLM, MVS_SLP) may stay open over many blocks: they have an array of their own, in which any
free unit is taken. `sequence_r` numbers the functions of both arrays; the PLC takes them strictly by it, so a scan that is
overtaken by a restart at index 0 loses and reorders nothing.

Reset: the CNC withdraws everything and asks the PLC to forget (`lc_reset`); until it has, no new function is put out.
Thus a late `done_w` for a withdrawn function never acknowledges another one.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from enum import IntEnum

from runtime.hli.layout import TECHNO_UNITS, Axis, Channel, TechnologyUnit

# Waiting kinds of P-CHAN-00041: MVS_SVS, MVS_SNS, MNS_SNS, MNE_SNS, MVS_SLM, MVS_SLP, MEP_SVS, MET_SVS
ACKNOWLEDGED = 0x2 | 0x4 | 0x8 | 0x20 | 0x4000 | 0x8000 | 0x1000000 | 0x2000000
LATE = 0x4000 | 0x8000  # MVS_SLM, MVS_SLP


class Kind(IntEnum):
    """`fkt_ctrl_r`."""

    M = 1
    H = 2
    S = 3
    T = 4


@dataclass(frozen=True, slots=True)
class Function:
    """What is put out; whole numbers of the interface: position 0.0001 degrees, revolutions 0.001 degrees/s, time
    µs. `spindle`: logical axis number of a spindle that the PLC moves, else 0."""

    kind: int
    number: int
    value: int = 0
    synch: int = 0
    line: int = 0
    block_number: int = -1
    position: int = 0
    revolutions: int = 0
    time: int = 0
    spindle: int = 0

    @property
    def acknowledged(self) -> bool:
        """Whether the path waits for it somewhere."""
        return bool(self.synch & ACKNOWLEDGED)

    @property
    def late(self) -> bool:
        """Whether it is demanded in a later block only."""
        return bool(self.synch & LATE)


@dataclass(slots=True)
class Sent:
    """A function on its way; `done` when it is acknowledged (or taken, for kinds without acknowledgement)."""

    function: Function
    sequence: int  # 0 and
    index: int  # -1 if it never needed a unit
    done: bool = False


class _Array:
    """One of the two arrays of an area, as the CNC uses it."""

    def __init__(self, area: Channel | Axis, kind: str, *, in_a_row: bool) -> None:
        self._area = area
        self._used = f"used_units_{kind}_sync_r"
        self.units = list(
            getattr(area, f"techno_unit_{kind}_sync")
        )  # the views, made once: each access makes a new one
        self.open: list[Sent] = []  # in order of output
        self._in_a_row = in_a_row
        self._next = 0  # index of the next unit, where they are used in a row

    def free_unit(self) -> int:
        """Index of the unit for the next function, -1 if there is none."""
        if self._in_a_row:
            return self._next if self._next < TECHNO_UNITS else -1
        if len(self.open) == TECHNO_UNITS:
            return -1
        busy = {sent.index for sent in self.open}
        return next(index for index in range(TECHNO_UNITS) if index not in busy)

    def put(self, function: Function, index: int, sequence: int, late: int) -> Sent:
        sent = Sent(function, sequence, index)
        _fill(self.units[index], function, sequence, late)
        self._next += 1
        self.open.append(sent)
        setattr(self._area, self._used, self._next if self._in_a_row else len(self.open))
        return sent

    def poll(self, present: bool, finished: list[Sent]) -> None:
        """Take out what is done."""
        still_open = []
        for sent in self.open:
            unit = self.units[sent.index]
            if not present:
                unit.please_rw = False
            if present and (unit.please_rw or (sent.function.acknowledged and not unit.done_w)):
                still_open.append(sent)
            else:
                sent.done = True
                finished.append(sent)
        if len(still_open) == len(self.open):
            return
        self.open = still_open
        if not still_open:
            self._next = 0
        if not still_open or not self._in_a_row:
            setattr(self._area, self._used, len(still_open))

    def drop(self) -> list[Sent]:
        dropped, self.open = self.open, []
        for unit in self.units:
            unit.please_rw = False
        self._next = 0
        setattr(self._area, self._used, 0)
        return dropped


class TechnologyPort:
    """The CNC's side of one channel's or axis' arrays. Bounded work, no waiting."""

    def __init__(self, area: Channel | Axis) -> None:
        self._area = area
        self._reset = area.lc_reset
        self._standard = _Array(area, "std", in_a_row=True)
        self._late = _Array(area, "late", in_a_row=False)
        self._simulated: list[Sent] = []  # no PLC: acknowledged, not yet polled
        self._sequence = 0

    @property
    def pending(self) -> int:
        """Functions that are not done."""
        return len(self._standard.open) + len(self._late.open)

    @property
    def pending_in_block(self) -> int:
        """The same without the late ones, which may stay open as long as they like."""
        return len(self._standard.open)

    def put(self, function: Function) -> Sent | None:
        """Hand a function to the PLC; None if no unit is free now (ask again in the next cycle, nothing may pass it).

        Without `plc_present_w` of the area it is acknowledged at once; `poll` reports it.
        """
        if not self._area.plc_present_w and not self.pending:
            sent = Sent(function, 0, -1, done=True)
            self._simulated.append(sent)
            return sent
        array = self._late if function.late else self._standard
        index = array.free_unit()
        if self._reset.please_rw or index < 0:
            return None
        self._sequence += 1
        return array.put(function, index, self._sequence, len(self._late.open) + function.late)

    def poll(self) -> list[Sent]:
        """The functions that have been done since the last call, in order of output; frees their units."""
        finished, self._simulated = self._simulated, []
        if self._reset.please_rw and not self._area.plc_present_w:
            self._reset.please_rw = False  # the answer of an absent PLC
        if not self._standard.open and not self._late.open:
            return finished
        present = bool(self._area.plc_present_w)
        self._standard.poll(present, finished)
        self._late.poll(present, finished)
        return finished

    def drop_all(self) -> list[Sent]:
        """Reset: withdraw every function; returns those that were open. New ones go out when the PLC has forgotten
        them too."""
        dropped = self._standard.drop() + self._late.drop()
        self._simulated = []
        if self._area.plc_present_w:
            self._reset.done_w = False
            self._reset.please_rw = True
        return dropped


def _fill(unit: TechnologyUnit, function: Function, sequence: int, late: int) -> None:
    unit.number_r = function.number
    unit.value_r = function.value
    unit.synch_r = function.synch
    unit.time_r = function.time
    unit.line_r = function.line
    unit.block_number_r = function.block_number
    unit.position_r = function.position
    unit.revolutions_r = function.revolutions
    unit.sequence_r = sequence
    unit.nr_late_sync_r = late
    unit.spindle_r = function.spindle
    unit.fkt_ctrl_r = function.kind
    unit.done_w = False
    unit.please_rw = True  # last: everything above is complete when the PLC sees it


class Taken:
    """A function that the PLC has taken; `done()` when it is executed."""

    def __init__(self, unit: TechnologyUnit, function: Function, sequence: int) -> None:
        self._unit = unit
        self.function = function
        self.sequence = sequence
        self.is_done = False

    def done(self) -> None:
        """Acknowledge. Once, and only for kinds that are acknowledged: the unit of another one may be in use again."""
        if not self.is_done:
            self.is_done = True
            if self.function.acknowledged:
                self._unit.done_w = True


class TechnologyTaker:
    """The PLC's side of the arrays of an area. Every function is taken, in order; none is taken twice."""

    def __init__(self, area: Channel | Axis, on_reset: Callable[[], None] | None = None) -> None:
        self._area = area
        self._units = [*area.techno_unit_std_sync, *area.techno_unit_late_sync]
        self._reset = area.lc_reset
        self._on_reset = on_reset
        self._last: int | None = None  # sequence of the function taken last
        self._open: list[Taken] = []

    def restart(self) -> None:
        """Begin with the oldest function that waits (the PLC logs on)."""
        self._last = None
        self._open = []

    def take(self) -> list[Taken]:
        """The functions that are new. On a reset of the CNC the open ones are forgotten first, and `on_reset` is
        called."""
        if self._reset.please_rw:
            for taken in self._open:
                taken.is_done = True  # a late done() is without effect
            self._open = []
            self._last = None
            if self._on_reset is not None:
                self._on_reset()
            self._reset.done_w = True
            self._reset.please_rw = False
        waiting = self._scan()
        if not waiting:
            return []
        if self._last is None:
            waiting |= self._scan()  # a restart at index 0 may have passed the first scan: now all older ones are there
            self._last = min(waiting) - 1
        new = []
        while (unit := waiting.get(self._last + 1)) is not None:
            self._last += 1
            new.append(Taken(unit, _copy(unit), self._last))
            unit.please_rw = False
        self._open = [taken for taken in self._open if not taken.is_done] + new
        return new

    def _scan(self) -> dict[int, TechnologyUnit]:
        return {int(unit.sequence_r): unit for unit in self._units if unit.please_rw}


def _copy(unit: TechnologyUnit) -> Function:
    return Function(
        kind=int(unit.fkt_ctrl_r),
        number=int(unit.number_r),
        value=int(unit.value_r),
        synch=int(unit.synch_r),
        line=int(unit.line_r),
        block_number=int(unit.block_number_r),
        position=int(unit.position_r),
        revolutions=int(unit.revolutions_r),
        time=int(unit.time_r),
        spindle=int(unit.spindle_r),
    )
