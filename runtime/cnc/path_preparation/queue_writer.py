"""The last station of preparation: blocks become records of the motion queue, with all numbers that the cycle needs.

Path length is measured along the first three (main) axes if one of them moves; the other axes go along. If none of
them moves, it is the Euclidean length over the remaining axes (rotary axes alone: degrees, and a feed in
degrees/min). At the change between both measures the path stops. Moves without length vanish; their block end stays.

The writer never waits and reads no clock: when the queue is full it says so and goes on where it was at the next call.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator, Sequence
from enum import Enum

import numpy as np
import numpy.typing as npt

from runtime.cnc.blocks import (
    AHEAD,
    ActualLimit,
    Arc,
    AxisJob,
    AxisJobWait,
    AxisLimitChange,
    Block,
    BlockEnd,
    ClearStorage,
    CouplingChange,
    CuttingSpeed,
    DistanceMark,
    Dwell,
    DynamicsChange,
    ExactStop,
    ExternalWrite,
    FeedForward,
    FilterChange,
    Flush,
    FlushKind,
    Hold,
    Homing,
    IndependentMotion,
    IndependentWait,
    LifeCommand,
    Line,
    ManualMotion,
    ManualParameter,
    Measurement,
    MeasurementEnd,
    Message,
    OptionalSection,
    PathRestart,
    Polyline,
    Polynomials,
    PositionSetting,
    Receiver,
    RevolutionFeed,
    SearchArea,
    SearchGate,
    SearchMark,
    SearchPlace,
    SearchStep,
    Source,
    SpindleRole,
    SpindleSection,
    SpindleSetting,
    SpindleTurn,
    StepEnd,
    Stop,
    StopKind,
    StopMark,
    Suppression,
    TakeOver,
    TechnologyFunction,
    TimerAction,
    TimerCommand,
    ToolLifeAction,
    ToolRadius,
    UserError,
    Wait,
)
from runtime.cnc.dynamic_settings import USUAL, DynamicSettings
from runtime.cnc.filter_settings import FilterSettings
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.geometry.polynomial_table import MAP
from runtime.cnc.job_records import write_job, write_wait
from runtime.cnc.measuring_records import measurement
from runtime.cnc.motion_queue import RECORD, ActionKind, GateReason, MotionQueue, RecordKind, Records
from runtime.cnc.path_preparation.axis_travel import axis_travel
from runtime.cnc.path_preparation.beside_path import PathShare, beside_path, coupling, independent
from runtime.cnc.path_preparation.channel_dynamics import ChannelDynamics
from runtime.cnc.path_preparation.dynamic_limits import ANY, ArcGeometry, DynamicLimits, Limited
from runtime.cnc.path_preparation.dynamics import Border
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.path_preparation.filter_orders import filter_orders
from runtime.cnc.path_preparation.polynomial_dynamics import fit
from runtime.cnc.suppression import FEED_STOP, OVERRIDE
from runtime.config.fir_filter import FirFilter
from runtime.diagnostics.catalogue.motion import ARC_GEOMETRY, NO_FEED, NOT_FINITE, PATH_GAP, POLYNOMIAL_GEOMETRY
from runtime.diagnostics.errors import Place
from runtime.hli.external import KINDS

Floats = npt.NDArray[np.float64]
Flags = npt.NDArray[np.bool_]

MAIN_AXES = 3
NO_LENGTH = 1e-9  # mm: below it a move has no length
GAP = 1e-5  # mm: what may lie between the end of a block and the start of the next

_STOPS = {
    StopKind.PROGRAMMED: GateReason.PROGRAMMED_STOP,
    StopKind.OPTIONAL: GateReason.OPTIONAL_STOP,
    StopKind.PROGRAM_END: GateReason.PROGRAM_END,
}


_SEARCH = {
    SearchStep.BEGIN: GateReason.SEARCH_BEGIN,
    SearchStep.END: GateReason.SEARCH_END,
    SearchStep.RETURN: GateReason.SEARCH_RETURN,
    SearchStep.GO_ON: GateReason.SEARCH_GO_ON,
}


_SPINDLE_GATES = {
    SpindleRole.THREAD: GateReason.THREAD,
    SpindleRole.TAPPING: GateReason.TAPPING,
    SpindleRole.FREE: GateReason.SPINDLE_FREE,
}


_RECEIVERS = tuple(Receiver)
_TIMER_COMMANDS = tuple(TimerCommand)
_LIFE_COMMANDS = tuple(LifeCommand)


def stop_mark_ways(mark: StopMark) -> int:
    """Bits: 1 it stops the first time, 2 forward again, 4 backward."""
    return mark.forward + 2 * mark.again + 4 * mark.backward


def _section(record: Records, block: OptionalSection) -> Records:
    """The begin of a section, with the gate behind it that opens if the section is driven; or its end."""
    record["kind"] = RecordKind.ACTION
    record["action"] = ActionKind.OPTIONAL_ON if block.begins else ActionKind.OPTIONAL_OFF
    if not block.begins:
        return record
    record["number"] = 0 if not block.simulate else 1 if block.mask is None else 2
    record["spindle"] = block.mask or 0
    gate = record.copy()
    gate["kind"], gate["reason"] = RecordKind.GATE, GateReason.OPTIONAL_SECTION
    return np.concatenate([record, gate])


class PumpState(Enum):
    """Why `QueueWriter.pump` came back."""

    FULL = "the queue is full"
    MORE = "the budget is used up"
    FINISHED = "the blocks have come to their end"
    FLUSH = "the path has to come to a #FLUSH WAIT first"
    HELD = "the decoder waits for something outside"


def described(error: UserError) -> str:
    """The text of a #ERROR where no texts are known."""
    return error.text or f"user error {error.number}"


def _with_text(block: Block) -> bool:
    """The block needs a place for a text."""
    return isinstance(block, Message | UserError) or (isinstance(block, ExternalWrite) and isinstance(block.value, str))


def _norm(way: Floats) -> Floats:
    """Euclidean lengths (k,) of (k, n), axis by axis: a sum over a last dimension of three is slow in NumPy."""
    squares: Floats = np.zeros(len(way))
    for axis in range(way.shape[1]):
        squares += way[:, axis] * way[:, axis]
    return np.sqrt(squares)


def path_length(way: Floats) -> tuple[Floats, npt.NDArray[np.bool_]]:
    """Lengths (k,) of straight moves (k, n_axes), and whether they are measured along the main axes."""
    along_main, along_others = _norm(way[:, :MAIN_AXES]), _norm(way[:, MAIN_AXES:])
    main = along_main > NO_LENGTH
    # An axis that goes along a move of next to no length would be infinitely fast: such a move is measured by it.
    main &= along_main > 1e-6 * along_others
    return np.where(main, along_main, along_others), main


class QueueWriter:
    """Writes the blocks of one program run to `queue`; make a new one for each run.

    `names` of the axes are for error messages, `error_text` makes the text of a #ERROR. Raises PathError for blocks that
    can't be driven; nothing of such a block reaches the queue.
    """

    def __init__(
        self,
        queue: MotionQueue,
        limits: AxisLimits,
        period: float,
        names: tuple[str, ...] = (),
        error_text: Callable[[UserError], str] = described,
        weights: ChannelDynamics | None = None,
        filters: Sequence[FirFilter | None] = (),
    ) -> None:
        self.queue = queue
        self._filters = filters or (None,) * limits.n
        self._greatest = limits
        self._period = period
        self._error_text = error_text
        self._axes = limits.n
        self._limits = DynamicLimits(limits, period, weights)
        self._override_of_limited = weights is not None and weights.override_of_limited
        self._feed_factor_counts = weights is None or weights.feed_factor_counts
        self._external_on_rapid = weights is not None and weights.external_on_rapid
        self._weight_external(USUAL)
        self._left = PathShare(limits)
        self._names = names or tuple(str(i) for i in range(limits.n))
        self._before: Border | None = None
        self._rapid_before = self._late_before = False  # of the element before
        self._end_feed = math.inf  # mm/s: E of the last motion, the greatest speed over its end
        self._place: Floats | None = None  # end of the last element in the queue
        self._block_end: Floats | None = None  # end of the last block, moves without length included
        self._pending: Records = np.zeros(0, dtype=RECORD)
        self._tables: Floats | None = None  # of the pending records, if they are polynomials
        self._done = 0
        self._postponed: Block | None = None  # waits for room for its text
        self._flushing = False
        self._travelled: Floats | None = None  # by each axis since #DIST TO GO BEGIN
        self._plc_messages = 0
        self._revolutions: RevolutionFeed | None = None  # feeds are per revolution
        self._section: SpindleSection | None = None  # path and spindle move together
        self._turn, self._turned = 0.0, 0.0  # degrees per mm in it, and how far the spindle has turned

    def pump(self, blocks: Iterator[Block], budget: int = 1000) -> PumpState:
        """Write blocks until the queue is full, `budget` records are written, or there are no more blocks.

        After FLUSH the next call goes on: the caller makes it when the path has come there. After HELD too, some time later.
        """
        while True:
            if self._done < len(self._pending):
                budget -= self._flush(budget)
                if self._done < len(self._pending):
                    return PumpState.FULL if self.queue.free == 0 else PumpState.MORE
            if self._flushing:
                self._flushing = False
                return PumpState.FLUSH
            if budget <= 0:
                return PumpState.MORE
            if self.queue.free == 0:
                return PumpState.FULL
            block = self._postponed or next(blocks, None)
            if block is None:
                return PumpState.FINISHED
            if isinstance(block, Hold):
                return PumpState.HELD
            budget -= 1
            if not self._take(block):
                return PumpState.FULL

    def write(self, block: Block) -> bool:
        """Write one block; False if not all of it fitted: call again with the same block until True."""
        if self._done >= len(self._pending) and not self._take(block):
            return False
        self._flush(len(self._pending))
        return self._done >= len(self._pending)

    def _flush(self, most: int) -> int:
        now = slice(self._done, self._done + max(most, 1))
        count = self.queue.append(self._pending[now], None if self._tables is None else self._tables[now])
        self._done += count
        return count

    def _take(self, block: Block) -> bool:
        """Make the records of a block; FALSE if there is no room for its text or its limits."""
        no_room = self.queue.texts.free == 0 and _with_text(block)
        no_room = no_room or not self.queue.limits.room_for(self._limits.kinds)
        self._postponed = block if no_room else None
        if self._postponed is not None:
            return False
        self._tables = None
        self._pending, self._done = self._records(block), 0
        if self._travelled is not None:
            self._travelled += axis_travel(block)
        self._mark(self._pending, block)
        return True

    def _mark(self, records: Records, block: Block) -> None:
        """What a block says of its elements beside their geometry: override off (G166), feed at the end (E word)."""
        elements = np.flatnonzero(records["kind"] <= RecordKind.POLYNOMIAL)
        if not len(elements):
            return
        if self._end_feed < math.inf:  # of the block before: both sides of the border keep to it
            first = elements[0]
            records["v_entry"][first] = min(records["v_entry"][first], self._end_feed)
            records["v_corner"][first] = min(records["v_corner"][first], self._end_feed)
            self._end_feed = math.inf
        if self._revolutions is not None:
            fed = elements[records["rapid"][elements] == 0]
            records["external"][fed], records["spindle"][fed] = -self._revolutions.speed, self._revolutions.spindle
        if self._section is not None:
            self._together(records, elements, self._section)
        if isinstance(block, Line | Arc | Polynomials):
            if block.override_off:
                records["override_off"][elements] = 1
            if block.end_feed is not None:
                self._end_feed = block.end_feed / 60.0

    def _together(self, records: Records, elements: npt.NDArray[np.int64], section: SpindleSection) -> None:
        """Elements on which path and spindle move together. A ramp of feed hold of its own knows nothing of the spindle."""
        turned = np.cumsum(records["length"][elements] * self._turn)
        records["sense"][elements], records["spindle"][elements] = int(section.role), section.spindle
        records["value"][elements] = self._turn
        records["spindle_angle"][elements] = self._turned + turned - records["length"][elements] * self._turn
        records["external"][elements] = 1.0
        records["a_hold"][elements] = records["j_hold"][elements] = 0.0
        self._turned += float(turned[-1])

    def _weight_external(self, settings: DynamicSettings) -> None:
        """#FF: the weights of a feed that the PLC commands, for moves at feed and rapid ones; 0: it does not act."""
        self._external = settings.external_feed if self._feed_factor_counts else 1.0
        self._external_rapid = self._external if self._external_on_rapid else 0.0

    # ------------------------------------------------------------------ block → records

    def _records(self, block: Block) -> Records:
        if isinstance(block, Polyline):
            return self._polyline(block)
        if isinstance(block, DynamicsChange):
            self._limits.change(block.settings)
            self._weight_external(block.settings)
            return np.zeros(0, dtype=RECORD)
        if isinstance(block, AxisLimitChange):
            self._limits.change_axes(self._left.of(block.limits))
            return np.zeros(0, dtype=RECORD)
        if isinstance(block, Polynomials):
            return self._polynomials(block)
        record = np.zeros(1, dtype=RECORD)
        source: Source = block.source
        record["line"] = source.line
        record["n"] = -1 if source.n is None else source.n
        record["program"] = self.queue.program_id(source.program)
        record["text"] = -1
        match block:
            case Line():
                feed = math.inf if block.rapid else block.feed
                ends = np.vstack([block.start, block.end])
                return self._lines(
                    record, ends, np.array([feed]), source.program, keep_empty=False, overridden=not block.override_off
                )
            case Arc():
                return self._arc(record, block)
            case TechnologyFunction():
                record["kind"] = RecordKind.FUNCTION_AHEAD if block.synch & AHEAD else RecordKind.FUNCTION
                record["function"], record["number"] = int(block.kind), block.number
                record["synch"], record["spindle"], record["value"] = int(block.synch), block.spindle, block.value
                record["area"], record["lead"], record["seconds"] = block.area, block.lead, block.duration
                record["offset"], record["size"] = block.sister, block.variant
                record["spindle_angle"], record["sense"] = block.angle, block.sense
                record["override_off"], record["plc_spindle"] = block.override_off, block.plc_spindle
            case Wait():
                record["kind"], record["reason"] = RecordKind.GATE, GateReason.WAIT
                record["synch"] = int(block.kinds)
            case Dwell():
                record["kind"], record["reason"], record["seconds"] = RecordKind.GATE, GateReason.DWELL, block.seconds
            case ExactStop():
                record["kind"], record["reason"] = RecordKind.GATE, GateReason.EXACT_STOP
            case Stop():
                record["kind"], record["reason"] = RecordKind.GATE, _STOPS[block.kind]
            case BlockEnd():
                record["kind"] = RecordKind.BLOCK_END
            case ToolRadius() | SearchMark() | SearchArea():
                return record[:0]
            case Flush():
                return self._flush_records(record, block.kind)
            case Message():
                return self._message(record, block)
            case TimerAction():
                record["kind"], record["action"], record["number"] = RecordKind.ACTION, ActionKind.TIMER, block.timer
                record["value"] = _TIMER_COMMANDS.index(block.command)
            case FeedForward():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.FEED_FORWARD
                record["end"][0, : self._axes] = block.shares
            case Suppression():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.SUPPRESSION
                record["number"] = FEED_STOP * block.feed_stop + OVERRIDE * block.override
            case SpindleSetting():
                record["kind"], record["action"], record["spindle"] = (
                    RecordKind.ACTION,
                    ActionKind.SPINDLE,
                    block.spindle,
                )
                record["number"], record["value"] = int(block.what), block.value
            case RevolutionFeed():
                self._revolutions = block if block.speed > 0.0 else None
                return record[:0]
            case SpindleTurn():
                self._turn = block.per_mm
                return record[:0]
            case SpindleSection():
                record["kind"], record["reason"] = RecordKind.GATE, _SPINDLE_GATES[block.role]
                record["spindle"], record["value"] = block.spindle, block.angle
                record["number"], record["size"], record["offset"] = block.measured, block.cycles, block.steady
                self._section = None if block.role is SpindleRole.FREE else block
                self._turned = 0.0
            case CuttingSpeed():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.CUTTING_SPEED
                record["spindle"], record["value"], record["number"] = block.spindle, block.velocity, block.axis
                record["lead"], record["seconds"] = block.centre, block.limit
            case AxisJob():
                write_job(record, block)
            case AxisJobWait():
                write_wait(record, block)
            case ToolLifeAction():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.TOOL_LIFE
                record["number"] = _LIFE_COMMANDS.index(block.command)
                record["offset"], record["size"], record["feed"] = block.basic, block.sister, block.variant
                record["seconds"], record["value"] = block.time, block.distance
            case ExternalWrite():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.EXTERNAL
                record["number"], record["offset"], record["size"] = KINDS.index(block.kind), block.offset, block.size
                if isinstance(block.value, str):
                    record["text"] = self.queue.texts.put(block.value)
                else:
                    record["value"] = block.value
            case UserError():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.WARNING
                record["number"], record["value"] = block.number, block.remedy_class
                record["text"] = self.queue.texts.put(self._error_text(block))
                if block.remedy_class != 0:
                    record["kind"], record["reason"] = RecordKind.GATE, GateReason.USER_ERROR
            case StepEnd():
                record["kind"], record["reason"] = RecordKind.GATE, GateReason.STEP
            case StopMark():
                record["kind"], record["reason"] = RecordKind.GATE, GateReason.STOP_MARK
                record["number"], record["value"] = block.level, block.user
                record["offset"] = stop_mark_ways(block)
            case FilterChange():
                return self._filter(record, block.settings)
            case DistanceMark():
                record["kind"] = RecordKind.ACTION
                record["action"] = ActionKind.DISTANCE_BEGIN if block.begins else ActionKind.DISTANCE_END
                if self._travelled is not None:
                    record["end"][0, : self._axes] = self._travelled
                self._travelled = np.zeros(self._axes) if block.begins else None
            case ClearStorage():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.CLEAR_STORAGE
            case OptionalSection():
                return _section(record, block)
            case SearchGate():
                record["kind"], record["reason"] = RecordKind.GATE, _SEARCH[block.step]
                record["number"] = block.automatic
                self._flushing = block.step in (SearchStep.BEGIN, SearchStep.RETURN)
            case SearchPlace():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.SEARCH_PLACE
                record["value"], record["offset"] = block.way, block.blocks
            case Measurement():
                measurement(record, block)
            case MeasurementEnd():
                record["kind"], record["reason"] = RecordKind.GATE, GateReason.MEASURE_END
            case PathRestart():
                self._before = self._place = self._block_end = None
                return record[:0]
            case CouplingChange():
                coupling(record, block)
                for axis, place in block.ends:
                    self._move_place(axis, place)
                self._limits.change_axes(self._left.couple(block.coupled))
            case ActualLimit():
                record["kind"], record["action"] = RecordKind.ACTION, ActionKind.ACTUAL_LIMIT
                record["number"], record["value"], record["seconds"] = block.axis, block.low, block.high
                record["offset"] = block.stops
            case IndependentMotion() | IndependentWait():
                independent(record, block)
                if isinstance(block, IndependentMotion):
                    self._move_place(block.axis, block.target)
            case ManualMotion() | ManualParameter() | Homing() | TakeOver() | PositionSetting():
                self._flushing = beside_path(record, block)
                if self._left.changed_by(block):
                    self._limits.change_axes(self._left.now)
        return record

    def _move_place(self, axis: int, target: float) -> None:
        """An axis goes there by itself: the path counts it at its target, and goes on from that."""
        if self._place is not None:
            self._place = self._place.copy()
            self._place[axis] = target
        if self._block_end is not None:
            self._block_end = self._block_end.copy()
            self._block_end[axis] = target

    def _filter(self, record: Records, settings: FilterSettings) -> Records:
        """The gate at which the filters change; from there on corners are as fast as they allow."""
        orders = filter_orders(settings, self._filters, self._greatest, self._period)
        self._limits.change_filter(np.array(orders.corner_factors), watched=settings.on and settings.deviation > 0.0)
        record["kind"], record["reason"] = RecordKind.GATE, GateReason.FILTER
        record["end"][0, : self._axes] = orders.halves
        for field, value in (("value", settings.share), ("seconds", settings.cut_off), ("lead", settings.quality)):
            record[field] = math.nan if value is None else value
        return record

    def _flush_records(self, record: Records, kind: FlushKind) -> Records:
        """Everything before it is in the queue already: only the stop is left to be written."""
        if kind is FlushKind.CONTINUE:
            return record[:0]
        record["kind"] = RecordKind.GATE
        record["reason"] = GateReason.FLUSH_WAIT if kind is FlushKind.WAIT else GateReason.FLUSH
        self._flushing = kind is FlushKind.WAIT
        return record

    def _message(self, record: Records, block: Message) -> Records:
        """The message, and the gate behind it that opens when its receiver does not lag behind."""
        plc = block.receiver is Receiver.PLC
        record["kind"], record["action"] = RecordKind.ACTION, ActionKind.MESSAGE
        record["number"], record["value"] = plc, block.information
        record["size"] = _RECEIVERS.index(block.receiver)
        record["text"] = self.queue.texts.put(block.text)
        if not plc and not block.acknowledge:
            return record
        self._plc_messages += plc
        gate = record.copy()
        gate["kind"], gate["reason"], gate["text"] = RecordKind.GATE, GateReason.MESSAGE, -1
        gate["number"], gate["value"] = self._plc_messages, block.acknowledge
        return np.concatenate([record, gate])

    def _polyline(self, block: Polyline) -> Records:
        records = np.zeros(len(block.feeds), dtype=RECORD)
        records["line"] = block.lines
        records["n"] = block.numbers
        records["program"] = self.queue.program_id(block.program)
        records["block_end"] = 0 if block.one_block else 1
        return self._lines(records, block.points, block.feeds, block.program, keep_empty=True)

    def _lines(
        self,
        records: Records,
        points: Floats,
        feeds: Floats,
        program: str,
        *,
        keep_empty: bool,
        overridden: bool = True,
    ) -> Records:
        """Complete k records to lines between `points` (k + 1, n); `feeds` (k,) per min, `overridden` by the program."""
        first_line = int(records["line"][0]) if len(records) else 0
        start = self._join(points, program, first_line)
        lengths, _ = path_length(np.diff(points, axis=0))
        there = lengths > NO_LENGTH
        records["kind"] = np.where(there, RecordKind.LINE, RecordKind.BLOCK_END)
        if not there.all():
            records["block_end"][~there] = 0
        self._block_end = points[-1]
        if not there.any():
            return records if keep_empty else records[:0]
        slow = there & ~(feeds > 0.0)
        if slow.any():
            at = int(np.argmax(slow))
            raise PathError(NO_FEED, Place(program, int(records["line"][at])), feed=float(feeds[at]))
        ends = points[1:][there]
        starts = np.vstack([start, ends[:-1]])
        way = ends - starts
        length, main = path_length(way)
        direction = way / length[:, None]
        feed = feeds[there] / 60.0
        rapid = np.isinf(feed)
        feed, share = self._overridden(feed, rapid, way != 0.0, overridden)
        limited = self._limits.lines(direction, length, main, feed, rapid, self._before)
        self._complete(records, there, starts, ends, length, feed, rapid, limited, share)
        self._before, self._place = limited.after, ends[-1]
        return records

    def _overridden(self, feed: Floats, rapid: Flags, moving: Flags, wanted: bool) -> tuple[Floats, Floats]:
        """Feeds (k,) with the override that is programmed, and the share of rapid traverse that it leaves, (k,)."""
        if not wanted or self._limits.overrides_nothing():
            return feed, np.ones(len(feed))
        share = np.where(rapid, self._limits.override(True, moving), self._limits.override(False, moving))
        return feed * share, np.where(rapid, np.minimum(share, 1.0), 1.0)

    def _complete(
        self,
        records: Records,
        there: npt.NDArray[np.bool_],
        starts: Floats,
        ends: Floats,
        length: Floats,
        feed: Floats,
        rapid: npt.NDArray[np.bool_],
        limited: Limited,
        share: Floats,
    ) -> None:
        n, dynamics = self._axes, limited.dynamics
        records["start"][there, :n] = starts
        records["end"][there, :n] = ends
        records["length"][there] = length
        if self._override_of_limited:  # P-CHAN-00066: the override scales what is left of F
            limit = limited.dynamics.v_limit
            records["f_word"][there] = np.where(feed > limit, feed, 0.0)
            feed = np.where(rapid, feed, np.minimum(feed, limit))
        records["feed"][there] = feed
        records["rapid"][there] = rapid
        records["external"][there] = np.where(rapid, self._external_rapid, self._external)
        records["v_limit"][there] = dynamics.v_limit * share
        records["a_limit"][there] = dynamics.a_limit
        records["j_limit"][there] = dynamics.j_limit
        if limited.hold is not None:
            records["a_hold"][there], records["j_hold"][there] = limited.hold
        records["v_entry"][there] = dynamics.v_entry
        records["v_corner"][there] = dynamics.v_corner
        records["a_entry"][there] = dynamics.a_entry
        self._mark_limits(records, there, limited, share)
        late = self._brakes_late(feed, rapid)
        if late.any():
            records["brake_late"][there] = late

    def _mark_limits(self, records: Records, there: Flags, limited: Limited, share: Floats) -> None:
        """The sets of limits of the axes, and the limits of the program along the path."""
        kinds = limited.kinds
        counts = [kind.count for kind in kinds]
        numbers = [self.queue.limits.put(kind.axes, len(records)) for kind in kinds]
        records["limits"][there] = np.repeat(numbers, counts)
        if all(kind.path is ANY for kind in kinds) and not (share < 1.0).any() and not self._limits.unwatched:
            return
        names = ("velocity", "acceleration", "deceleration", "jerk")
        along = {name: np.concatenate([kind.each(name) for kind in kinds]) for name in names}
        along["velocity"] = np.where(share < 1.0, records["v_limit"][there], along["velocity"])
        for name, limit in along.items():
            records[f"path_{name[0]}"][there] = np.where(np.isfinite(limit), limit, 0.0)
        records["unwatched"][there] = self._limits.unwatched

    def _brakes_late(self, feed: Floats, rapid: Flags) -> Flags:
        """Which of k elements may be entered faster than their feed (G901): behind a rapid move none, line 3869."""
        before = np.concatenate([[self._rapid_before], rapid[:-1]])
        late = np.full(len(feed), self._limits.settings.late_braking)
        late[0] = self._late_before
        self._rapid_before, self._late_before = bool(rapid[-1]), self._limits.settings.late_braking
        flags: Flags = late & ~before
        return flags

    def _arc(self, record: Records, arc: Arc) -> Records:
        program, line = arc.source.program, arc.source.line
        start = self._join(np.vstack([arc.start, arc.end]), program, line)
        first, second = arc.plane
        x, y = arc.start[first] - arc.centre[0], arc.start[second] - arc.centre[1]
        radius, angle = math.hypot(x, y), math.radians(arc.angle)
        linear = arc.end - arc.start
        linear[first] = linear[second] = 0.0
        length = math.hypot(radius * angle, float(np.linalg.norm(linear[:MAIN_AXES])))  # as in path_lengths
        self._block_end = arc.end
        if not (math.isfinite(length) and math.isfinite(arc.radius)):
            raise PathError(ARC_GEOMETRY, Place(program, line), radius=arc.radius, angle=arc.angle)
        if radius * abs(angle) <= NO_LENGTH:
            ends = np.vstack([arc.start, arc.end])
            return self._lines(
                record, ends, np.array([arc.feed]), program, keep_empty=False, overridden=not arc.override_off
            )
        if not arc.feed > 0.0:
            raise PathError(NO_FEED, Place(program, line), feed=arc.feed)
        moving = linear != 0.0
        moving[first] = moving[second] = True
        rapid = np.array([math.isinf(arc.feed)])
        feed, share = self._overridden(np.array([arc.feed / 60.0]), rapid, moving[None, :], not arc.override_off)
        geometry = ArcGeometry(arc.plane, math.atan2(y, x), angle, radius, linear, length)
        limited = self._limits.arc(geometry, float(feed[0]), self._before)
        record["kind"] = RecordKind.ARC
        record["axis0"], record["axis1"] = first, second
        record["centre0"], record["centre1"], record["angle"] = arc.centre[0], arc.centre[1], angle
        self._complete(
            record,
            np.array([True]),
            start[None, :],
            arc.end[None, :],
            np.array([length]),
            feed,
            rapid,
            limited,
            share,
        )
        self._before, self._place = limited.after, arc.end
        return record

    def _polynomials(self, block: Polynomials) -> Records:
        """A run of polynomials: one record for each, more where the parameter has to be split."""
        program, line = block.program, int(block.lines[0])
        start = self._join(np.vstack([block.start, block.ends]), program, line)
        gaps = np.abs(block.coefficients[1:, 0] - block.ends[:-1]).max(axis=1)
        if (gaps > GAP).any():
            at = int(np.argmax(gaps > GAP))
            self._expect_no_gap(block.coefficients[at + 1, 0], block.ends[at], program, int(block.lines[at + 1]))
        fitted = fit(block, start, NO_LENGTH)
        if fitted is None:
            raise PathError(POLYNOMIAL_GEOMETRY, Place(program, line))
        parent, there = fitted.parent, fitted.length > 0.0
        records = np.zeros(len(parent), dtype=RECORD)
        records["line"], records["n"] = block.lines[parent], block.numbers[parent]
        records["program"] = self.queue.program_id(program)
        records["kind"] = np.where(there, RecordKind.POLYNOMIAL, RecordKind.BLOCK_END)
        last_part = np.append(parent[1:] != parent[:-1], True)
        records["block_end"] = (block.block_ends[parent] & last_part & there).astype(np.int64)
        kept = there | block.block_ends[parent]
        self._block_end = fitted.ends[-1]
        if there.any():
            feed = block.feeds[parent][there] / 60.0
            slow = ~(feed > 0.0)
            if slow.any():
                at = int(parent[there][np.argmax(slow)])
                raise PathError(NO_FEED, Place(program, int(block.lines[at])), feed=float(block.feeds[at]))
            ends = fitted.ends[there]
            starts = np.vstack([start, ends[:-1]])
            rapid, length = np.isinf(feed), fitted.length[there]
            moving = (fitted.tables[there][:, 1:MAP, : self._axes] != 0.0).any(axis=1)
            feed, share = self._overridden(feed, rapid, moving, True)
            limited = self._limits.polynomials(
                fitted.tables[there], length, fitted.main[there], feed, rapid, self._before,
                check_jerk=block.check_jerk, constant_velocity=block.constant_velocity,
            )  # fmt: skip
            self._complete(records, there, starts, ends, length, feed, rapid, limited, share)
            self._before, self._place = limited.after, ends[-1]
        self._tables = fitted.tables[kept]
        return records[kept]

    def _join(self, points: Floats, program: str, line: int) -> Floats:
        """Where the element really starts: at the end of the one before. Raises PathError if that is not its start."""
        if not np.isfinite(points).all():
            axis = int(np.argmin(np.isfinite(points).all(axis=0)))
            raise PathError(NOT_FINITE, Place(program, line), axis=self._names[axis])
        start: Floats = points[0]
        if self._block_end is not None:
            self._expect_no_gap(start, self._block_end, program, line)
        return start if self._place is None else self._place

    def _expect_no_gap(self, start: Floats, end: Floats, program: str, line: int) -> None:
        gap = np.abs(start - end)
        if gap.max() > GAP:
            axis = int(np.argmax(gap))
            raise PathError(
                PATH_GAP, Place(program, line), start=float(start[axis]), axis=self._names[axis], end=float(end[axis])
            )
