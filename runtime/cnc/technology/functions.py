"""The technology functions of a channel in the cycle: put out, acknowledged, and the gates that wait for them.

    path passes a function ─▶ take ──┬─▶ port of the channel or of an axis ─▶ PLC
    path is near enough to one that  │                                         │
    is put out ahead of its place ───┘   ┌─▶ spindle ─▶ speed reached ─┐       │ done
                                         │                             ▼       ▼
    gate of the path ◀── passable ◀──────┴────────────────────────── waiting list

A port takes one block's functions at a time and has only so many units. What finds no room waits here in its order, and the
channel keeps the path still until there is room: a slow PLC loses nothing.

A gate waits for the types it names. It may be opened long before the path is there: as soon as every function of these types
in front of it has been put out and done.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.spindle import DEGREES_PER_SECOND, Spindle, SpindleOrder
from runtime.cnc.blocks import AT_BLOCK_END, BY_PATH, LATE, SpindleValue, Synch, Technology
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.queue_record import QueueRecord, read_record
from runtime.cnc.technology.ahead import FunctionsAhead, Planned, last_function
from runtime.cnc.technology.travel import Travel, reaches_spindle, synch_in
from runtime.config.channel.parameters import INTERNAL, ChannelParameters
from runtime.diagnostics.catalogue import machine
from runtime.diagnostics.errors import Place, Problem
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import ChannelStatus
from runtime.hli.technology import Function, Sent, TechnologyPort
from runtime.hli.units import INT32, LENGTH, MICROSECOND, SPEED

Floats = npt.NDArray[np.float64]

_OUT = {
    Technology.M: EventKind.M_OUT,
    Technology.H: EventKind.H_OUT,
    Technology.S: EventKind.S_OUT,
    Technology.T: EventKind.T_OUT,
}
_ACK = {
    Technology.M: EventKind.M_ACK,
    Technology.H: EventKind.H_ACK,
    Technology.S: EventKind.S_ACK,
    Technology.T: EventKind.T_ACK,
}
# plain numbers: flags of the enum class are slow to combine in every cycle
_LATE, _BY_PATH = int(LATE), int(BY_PATH)
_WAITING = int(AT_BLOCK_END | LATE)
_TIME_STAMP = int(Synch.MOS_TS)
_SVS_AHEAD = int(Synch.MEP_SVS | Synch.MET_SVS)
_SEARCH = 1024  # records looked at for a gate in one cycle
_UNFORESEEN = 2**32 - 1
_MOST_WAY, _MOST_TIME = 2**32 - 1, 4294.0


@dataclass(frozen=True, slots=True)
class TechnologySettings:
    """What the channel parameters say: blocks searched for functions that are put out ahead (P-CHAN-00274), whether way and
    time to their place are told (P-CHAN-00212), how far from the planned place they may be put out, mm, 0 however far
    (P-CHAN-00760), whether the program end waits for late functions (P-CHAN-00033)."""

    blocks_ahead: int = 50
    tell_to_go: bool = False
    tolerance: float = 0.0
    end_waits_for_late: bool = False

    @classmethod
    def of(cls, parameters: ChannelParameters) -> TechnologySettings:
        """What a channel is configured for."""
        return cls(
            parameters.m_h_pre_outp_nbr_block,
            parameters.m_h_pre_outp_calc_value_to_go,
            parameters.pre_output_tolerance * INTERNAL,
            parameters.prog_start.late_sync_ready,
        )


class Tell(Protocol):
    """Puts an event into the ring of the channel."""

    def __call__(
        self, kind: EventKind, line: int, n: int | None, number: int = 0, value: float = 0.0, axis: int = -1
    ) -> None: ...


@dataclass(slots=True)
class _Waiting:
    """A function that was put out and not yet acknowledged."""

    kind: Technology
    number: int
    line: int
    n: int | None
    spindle: Spindle | None  # waits for its speed
    sent: Sent | None  # waits for the PLC
    synch: int


class TechnologyFunctions:
    """Bounded work in every cycle: the queue holds at most as many functions as records.

    `ports`: of the axes, by their index in the machine. `tell` puts an event into the ring, `alarm` raises a problem.
    `travel` is how the path is driven: set by whoever drives it backward.
    """

    def __init__(
        self,
        queue: MotionQueue,
        path: Interpolator,
        port: TechnologyPort,
        ports: Mapping[int, TechnologyPort],
        spindles: Sequence[Spindle],
        status: ChannelStatus,
        settings: TechnologySettings,
        tell: Tell,
        alarm: Callable[[Problem], None],
    ) -> None:
        self._queue = queue
        self._path = path
        self._port = port
        self._axis_ports = ports
        self._ports = (port, *ports.values())
        self._spindles = spindles
        self._status = status
        self._settings = settings
        self._tell = tell
        self._alarm = alarm
        self._ahead = FunctionsAhead(queue, path, settings.blocks_ahead)
        self.travel = Travel.FORWARD
        self._waiting: list[_Waiting] = []
        self._overflow: deque[QueueRecord] = deque()  # functions for which the port had no room
        self._gate, self._searched, self._concerned = -1, 0, -1
        self._position = 0.0  # of the path in the cycle before

    # ------------------------------------------------------------------ the cycle

    def acknowledge(self, speeds: Floats) -> None:
        """Take from the waiting list what the PLC has done and what the spindles have reached (`speeds`, degrees/s)."""
        for port in self._ports:
            port.poll()
        if not self._waiting:
            return
        left: list[_Waiting] = []
        for waiting in self._waiting:
            spindle = waiting.spindle
            told = waiting.sent is None or waiting.sent.done
            if told and (spindle is None or spindle.reached(speeds[spindle.index])):
                self._tell(_ACK[waiting.kind], waiting.line, waiting.n, waiting.number)
            else:
                left.append(waiting)
        self._waiting = left

    def take(self, index: int) -> None:
        """The path has come to a function, the record `index` of the queue."""
        record = read_record(self._queue, index)
        self._put(record, self._offset(index) if int(record.synch) & _TIME_STAMP else 0)

    def take_ahead(self, index: int) -> None:
        """The path has come to a function that was to be put out before: now at the latest."""
        planned = self._ahead.passed(index)
        if planned is None:
            planned = Planned(index, read_record(self._queue, index), 0.0, 0)
        if not planned.out:
            self._release(planned, 0.0)

    def take_again(self, record: QueueRecord) -> None:
        """The path has come to a function that it had passed before."""
        self._put(record, 0)

    def settled(self, kinds: int) -> bool:
        """Nothing of these types that was put out waits for its acknowledgement."""
        return not self._overflow and next(self._missing(kinds), None) is None

    def look_again(self) -> None:
        """Records ahead have changed."""
        self._ahead.restart()
        self._gate = -1

    def look_ahead(self, *, held: bool) -> None:
        """Once per cycle, when everything that was passed has been taken. `held`: the path is kept from going on."""
        self._ahead.look()
        if self._ahead.any:
            self._ahead.due(moving=not held, one_block=self._settings.tell_to_go, release=self._release)
        if self._settings.tell_to_go:
            self._tell_to_go()
        self._position = self._path.path_position

    def put_out_late(self) -> None:
        """Put out what found no room before, in its order."""
        while self._overflow and self._put_out(self._overflow[0], 0):
            self._overflow.popleft()

    def drop(self) -> None:
        """Forget everything; the PLC is asked to do so too."""
        self._waiting.clear()
        self._overflow.clear()
        for port in self._ports:
            port.drop_all()

    def restart(self) -> None:
        """The queue is empty, the path begins anew. What is out stays out: the PLC still has to take or to do it."""
        self._ahead.restart()
        self._gate = -1
        self._position = 0.0

    def set_spindle(self, record: QueueRecord) -> None:
        """The path has come to a setting of a spindle."""
        spindle, value = self._spindles[record.spindle], record.value
        if record.number == SpindleValue.ACCELERATION:
            spindle.weigh(acceleration=value)
        elif record.number == SpindleValue.SPEED:
            spindle.weigh(speed=value)
        elif record.number == SpindleValue.FEED_FORWARD:
            spindle.feed_forward = value
        elif record.number == SpindleValue.GEAR:
            spindle.select_stage(int(value))
        else:
            spindle.home()

    # ------------------------------------------------------------------ what the path waits for

    @property
    def full(self) -> bool:
        """Functions found no room: nothing may pass them."""
        return bool(self._overflow)

    @property
    def waiting(self) -> int:
        """Functions that are out, or due, and not yet acknowledged."""
        return len(self._waiting) + len(self._overflow)

    @property
    def pending(self) -> bool:
        """Something is not acknowledged, or not even taken; late functions do not count, nobody asks for them yet."""
        return (
            bool(self._overflow)
            or any(not waiting.synch & _LATE for waiting in self._waiting)
            or any(port.pending_in_block for port in self._ports)
        )

    @property
    def end_waits(self) -> bool:
        """The end of the program has to wait."""
        if self._settings.end_waits_for_late:
            return self.waiting > 0
        return bool(self._overflow) or any(not waiting.synch & _LATE for waiting in self._waiting)

    def passable(self, index: int, gate: QueueRecord) -> bool:
        """Nothing that the gate, the record `index`, waits for is missing."""
        kinds = int(gate.synch)
        if self._overflow or next(self._missing(kinds), None) is not None:
            return False
        if kinds & _SVS_AHEAD and self._ahead.owed(index):
            return False
        return self._all_passed(index, kinds)

    def plc_owes(self, gate: QueueRecord) -> bool:
        """The PLC has not done something that the gate waits for; else it is only a spindle that is not there yet."""
        return bool(self._overflow) or any(
            waiting.sent is not None and not waiting.sent.done for waiting in self._missing(int(gate.synch))
        )

    def _missing(self, kinds: int) -> Iterator[_Waiting]:
        return (waiting for waiting in self._waiting if waiting.synch & kinds)

    def _all_passed(self, index: int, kinds: int) -> bool:
        """The path has passed every function in front of the gate that the gate asks for, and told them."""
        path = self._path
        if index != self._gate:
            self._gate, self._searched, self._concerned = index, index, -1
        here = path.next_index
        kinds &= ~_SVS_AHEAD
        if self._concerned < 0 and self._searched > here:
            start = max(here, self._searched - _SEARCH)
            self._concerned = last_function(self._queue.records, start, self._searched, kinds)
            self._searched = start
        if self._concerned >= 0:
            return self._concerned < here and path.all_told
        return self._searched <= here and path.all_told

    def _tell_to_go(self) -> None:
        """Way and time to the place of the functions that are out ahead, for the PLC (P-CHAN-00212)."""
        point = self._ahead.point()
        if point is None:
            self._status.techno_path_to_go_r = self._status.techno_time_to_go_r = 0
            return
        seconds = self._ahead.foreseen(point)
        self._status.techno_path_to_go_r = min(max(round(self._ahead.to_go(point) / LENGTH), 0), _MOST_WAY)
        self._status.techno_time_to_go_r = round(seconds / MICROSECOND) if seconds < _MOST_TIME else _UNFORESEEN

    # ------------------------------------------------------------------ putting out

    def _offset(self, index: int) -> int:
        """When in this cycle the path was at a record that it has passed in it, µs from the start of the cycle (MOS_TS)."""
        path = self._path
        if path.standstill:
            return 0
        here = path.next_index
        way = sum(float(self._queue.record(k)["length"]) for k in range(index + 1, here))
        if here < self._queue.written:
            way += float(self._queue.record(here)["length"]) - path.remaining
        period = path.period
        return round(min(max(period + path.time_until(-way), 0.0), period) / MICROSECOND)

    def _release(self, planned: Planned, way: float) -> None:
        """Put a function out ahead of its place, `way` mm before it."""
        record = planned.record
        tolerance = self._settings.tolerance
        if tolerance > 0.0 and int(record.synch) & _BY_PATH:
            # where the planned place lay within this cycle, it could not have been put out any nearer to it
            late = record.lead - way - (self._path.path_position - self._position)
            if late > tolerance:
                place = Place(self._queue.program_name(record.program), record.line)
                values = {"letter": record.technology.name, "number": record.number, "late": late, "limit": tolerance}
                self._alarm(Problem(machine.PRE_OUTPUT_LATE, values, place))
                return
        self._put(record, 0)

    def _put(self, record: QueueRecord, time: int) -> None:
        if self._overflow or not self._put_out(record, time):
            self._overflow.append(record)

    def _put_out(self, record: QueueRecord, time: int) -> bool:
        """Hand a function to the PLC and to the spindle it concerns; FALSE if there is no free unit. `time` in µs."""
        synch = synch_in(record.synch, self.travel)
        if synch.kind == Synch.NO_SYNCH:
            return True
        kind = record.technology
        if kind is Technology.S and not reaches_spindle(record.synch, self.travel):
            return True
        spindle = self._spindles[record.spindle] if record.spindle >= 0 else None
        sent: Sent | None = None
        if spindle is None or synch & Synch.PLC_INFO:
            port = self._port if record.area < 0 else self._axis_ports[record.area]
            sent = port.put(_to_interface(record, int(synch), spindle, time))
            if sent is None:
                return False
        if spindle is not None:
            spindle.command(SpindleOrder(record.number, record.value, record.angle, record.sense, record.override_off))
            self._tell(EventKind.SPINDLE, record.line, record.n, record.number, record.value, axis=spindle.index)
        self._tell(_OUT[kind], record.line, record.n, record.number, record.value)
        if int(synch) & _WAITING:
            self._waiting.append(_Waiting(kind, record.number, record.line, record.n, spindle, sent, int(synch)))
        return True


def _to_interface(record: QueueRecord, synch: int, spindle: Spindle | None, time: int) -> Function:
    """A function in the interface's whole numbers; the value of S is a speed, that of M and H goes over as it is."""
    if record.technology is Technology.S:
        value, revolutions = 0, min(round(record.value * DEGREES_PER_SECOND / SPEED), INT32)
    else:
        value, revolutions = round(record.value), 0
    duration = min(round(record.seconds / MICROSECOND), INT32)
    return Function(
        kind=int(record.technology),
        number=record.number,
        value=max(-INT32, min(value, INT32)),
        synch=synch,
        line=record.line,
        block_number=-1 if record.n is None else record.n,
        revolutions=revolutions,
        sister=record.offset,
        variant=record.size,
        position=round(record.angle / LENGTH),
        spindle=record.plc_spindle,
        time=duration if record.area >= 0 or not synch & _TIME_STAMP else time,  # axes get no offset
    )
