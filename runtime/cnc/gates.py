"""When a gate of the path is opened: what it waits for, and what is done while the path stands there.

    seen ahead   functions acknowledged, message taken, stop not selected ─▶ opened, the path runs through without slowing down
    standing     dwell over, axes settled, moved by hand, operator said continue ─▶ opened, the path goes on

A gate that stays closed tells the reason as a stop condition.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from runtime.cnc.actions import Actions
from runtime.cnc.axes.program_jobs import ProgramJobs
from runtime.cnc.backward_motion import BackwardMotion
from runtime.cnc.beside_path import GATES as BESIDE_GATES
from runtime.cnc.beside_path import BesidePath
from runtime.cnc.block_search import GATES as SEARCH_GATES
from runtime.cnc.block_search import BlockSearching
from runtime.cnc.channel_inputs import ChannelInputs
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.interpolator.path_storage import skipped
from runtime.cnc.measuring import Measuring
from runtime.cnc.motion_queue import GateReason, RecordKind
from runtime.cnc.preparation_link import PreparationLink
from runtime.cnc.queue_record import QueueRecord, read_record
from runtime.cnc.skipped_section import SkippedSection
from runtime.cnc.stop_before import StopBefore
from runtime.cnc.synchronous_spindle import SynchronousSpindle
from runtime.cnc.technology import TechnologyFunctions
from runtime.diagnostics.catalogue import machine
from runtime.diagnostics.errors import ErrorEntry, Place, Problem
from runtime.hli.layout import Channel as ChannelArea
from runtime.hli.layout import StopCondition

Floats = npt.NDArray[np.float64]

# plain numbers: flags of the enum class are slow to combine in every cycle
_NONE = int(StopCondition.NONE)
_WAIT_TECHNOLOGY = int(StopCondition.WAIT_TECHNOLOGY)
_WAIT_CONTINUE = int(StopCondition.WAIT_CONTINUE)
_WAIT_SPINDLE = int(StopCondition.WAIT_SPINDLE)
_DWELL = int(StopCondition.DWELL)
_SINGLE_BLOCK = int(StopCondition.SINGLE_BLOCK)
_ERROR = int(StopCondition.ERROR)
_MESSAGE = int(StopCondition.MESSAGE)
_EXACT_STOP = int(StopCondition.EXACT_STOP)
_MANUAL = int(StopCondition.MANUAL)
_AXIS_JOB = int(StopCondition.AXIS_JOB)
_OPTIONAL_SECTION = int(StopCondition.OPTIONAL_SECTION)
_BLOCK_SEARCH = int(StopCondition.BLOCK_SEARCH)
_RETURN_TO_CONTOUR = int(StopCondition.RETURN_TO_CONTOUR)
_MEASURING = int(StopCondition.MEASURING)
_FIRST_TIME = 1  # bit of a stop mark
_SETTLED_AT_LAST = 1.0  # s that the axes get to come to rest at #FLUSH WAIT
_FATAL = 2  # remedy classes of #ERROR above it


@dataclass(frozen=True, slots=True)
class OperatorInfluence:
    """How what operator and PLC do acts: behind M00, M01 and single block the axes have to be in their windows (P-CHAN-00173);
    dwells are stretched by the feed override (P-CHAN-00353) and by the time override (P-CHAN-00111)."""

    looks_at_axes: bool = True
    feed_stretches_dwell: bool = False
    time_stretches_dwell: bool = False


@dataclass(frozen=True, slots=True)
class Surroundings:
    """Everything of a channel that gates have to do with.

    `axes` (n_axes,): indices of the path axes among all axes; `window` (n_axes,): how near each of them is to its set-point
    when it stands, mm or degrees; `period` in s; `report` takes what has gone wrong.
    """

    path: Interpolator
    link: PreparationLink
    area: ChannelArea
    functions: TechnologyFunctions
    actions: Actions
    beside: BesidePath
    jobs: ProgramJobs
    search: BlockSearching
    backward: BackwardMotion
    measuring: Measuring
    stop_before: StopBefore
    together: SynchronousSpindle
    axes: npt.NDArray[np.int64]
    window: Floats
    period: float
    report: Callable[[Problem], None]


class Gates:
    """Of one channel. `step` is called once in every cycle of a program."""

    def __init__(self, around: Surroundings, influence: OperatorInfluence) -> None:
        self._around = around
        self._path = around.path
        self._influence = influence
        self._section = SkippedSection(around.path)
        self._every_axis = (1 << len(around.axes)) - 1
        self.fatal = False  # a program has told a fatal error: no reset clears it
        self.at_end: QueueRecord | None = None  # the program's end, if it was opened in this cycle
        self._index = -1
        self._record: QueueRecord | None = None
        self._dwell_left = -1.0
        self._settling = 0.0  # s at the present #FLUSH WAIT
        self._asked_on = False  # the operator has said continue, and an axis is still on its way
        self._user_error_told = False
        # of this cycle
        self._inputs = ChannelInputs()
        self._pressed = self._running = self._locked = False
        self._actual = np.zeros(0)
        standing: dict[GateReason, Callable[[QueueRecord], int]] = {
            GateReason.OPTIONAL_SECTION: self._leave_out,
            GateReason.DWELL: self._dwell,
            GateReason.FLUSH: self._open,
            GateReason.FLUSH_WAIT: self._flush_wait,
            GateReason.EXACT_STOP: self._exact_stop,
            GateReason.FILTER: self._filter,
            GateReason.AXIS_JOBS: self._axis_jobs,
            GateReason.INDEPENDENT: self._own_motion,
            GateReason.COUPLING: self._couple,
            GateReason.INDEPENDENT_WAIT: self._own_motions_over,
            GateReason.USER_ERROR: self._user_error,
            GateReason.PROGRAM_END: self._program_end,
            GateReason.STEP: self._end_of_step,
            GateReason.STOP_MARK: self._stop_mark,
            GateReason.THREAD: self._spindle_begins,
            GateReason.TAPPING: self._spindle_begins,
            GateReason.SPINDLE_FREE: self._spindle_ends,
            GateReason.MEASURE: self._measure,
            GateReason.MEASURE_END: self._measured,
        }
        standing |= dict.fromkeys(BESIDE_GATES, self._beside_path) | dict.fromkeys(SEARCH_GATES, self._search)
        self._standing = standing

    def begin(self) -> None:
        """A program starts."""
        self._user_error_told = self._asked_on = False
        self.at_end = None

    def end(self) -> None:
        """The program is over."""
        self._show_stop_mark(None)

    def cleared(self) -> None:
        """Nothing of the program is left."""
        self._dwell_left, self._settling = -1.0, 0.0

    def look_again(self) -> None:
        """The path is driven the other way: what the next gate is has changed."""
        self._index = -1

    def step(self, inputs: ChannelInputs, *, pressed: bool, running: bool, locked: bool, actual: Floats) -> int:
        """Open the next gate if its reason is gone; tells what the path waits for.

        `pressed`: the operator says continue in this cycle; `running`: the program is not being aborted; `locked`: its axes are
        not moved; `actual`: positions of all axes of the machine.
        """
        path = self._path
        self.at_end = None
        if path.gate < 0:
            return _NONE
        if path.gate != self._index:
            self._index = path.gate
            self._record = read_record(path.queue, path.gate)
        gate = self._record
        assert gate is not None
        self._inputs, self._pressed, self._running, self._locked = inputs, pressed, running, locked
        self._actual = actual
        if gate.kind is not RecordKind.GATE:
            return self._end_of_block()
        waits = self._ahead(gate)
        if waits is not None:
            return waits
        return self._standing.get(gate.reason, self._stop)(gate)

    # ------------------------------------------------------------------ seen ahead

    def _end_of_block(self) -> int:
        """In single block mode, or only to stop before what comes then: that is held by itself."""
        path = self._path
        if not self._inputs.single_block:
            if path.at_gate or self._around.stop_before.may_follow(self._inputs, path.gate):
                path.open_gate()
            return _NONE
        return self._go_on(_SINGLE_BLOCK | _WAIT_CONTINUE) if path.at_gate else _NONE

    def _ahead(self, gate: QueueRecord) -> int | None:
        """What is decided before the path stands at the gate; None: it stands, and the gate is closed."""
        path = self._path
        if gate.reason is GateReason.WAIT:
            return self._wait(gate)
        if gate.reason is GateReason.MESSAGE:
            if self._around.actions.passable(gate, here=path.at_gate and path.all_told):
                return self._open(gate)
            return _MESSAGE if path.at_gate else _NONE
        if self._does_not_count(gate):
            return self._open(gate)
        return None if path.at_gate else _NONE

    def _does_not_count(self, gate: QueueRecord) -> bool:
        """Stops that are not selected, sections that are not left out."""
        inputs = self._inputs
        match gate.reason:
            case GateReason.OPTIONAL_SECTION:
                return not skipped(gate.number, gate.mask, False, inputs.simulate_motion, inputs.simulate_mask)
            case GateReason.STEP:
                return not inputs.single_block
            case GateReason.STOP_MARK:
                return not self._stops_at(gate)
            case GateReason.OPTIONAL_STOP:
                return not inputs.optional_stop
        return False

    def _wait(self, gate: QueueRecord) -> int:
        """Functions are acknowledged, spindles at speed; on a path that is driven again, what was put out again is."""
        path, functions = self._path, self._around.functions
        if self._around.backward.replaying:
            if path.at_gate and path.all_told and functions.settled(int(gate.synch)):
                return self._open(gate)
            return _WAIT_TECHNOLOGY if path.at_gate else _NONE
        if functions.passable(path.gate, gate):
            return self._open(gate)
        if not path.at_gate:
            return _NONE
        return _WAIT_TECHNOLOGY if functions.plc_owes(gate) else _WAIT_SPINDLE

    # ------------------------------------------------------------------ standing there

    def _open(self, gate: QueueRecord) -> int:
        self._path.open_gate()
        return _NONE

    def _stop(self, gate: QueueRecord) -> int:
        """M00, M01."""
        return self._go_on(_WAIT_CONTINUE)

    def _end_of_step(self, gate: QueueRecord) -> int:
        return self._go_on(_SINGLE_BLOCK | _WAIT_CONTINUE)

    def _stops_at(self, mark: QueueRecord) -> bool:
        """Whether a mark of #STOP REVERSIBLE stops the path; of those that are come to again only they are filled."""
        this_way = self._around.backward.replaying or bool(mark.offset & _FIRST_TIME)
        return this_way and (mark.number == 0 or bool(mark.number & self._inputs.stop_level))

    def _stop_mark(self, mark: QueueRecord) -> int:
        waits = self._go_on(_WAIT_CONTINUE)
        self._show_stop_mark(mark if self._path.gate >= 0 else None)
        return waits

    def _show_stop_mark(self, mark: QueueRecord | None) -> None:
        """The path stands at a mark, or no longer."""
        status = self._around.area.status
        status.is_stopped_r = mark is not None
        status.stop_user_value_r = 0 if mark is None else int(mark.value)

    def _program_end(self, gate: QueueRecord) -> int:
        beside = self._around.beside
        if self._around.functions.end_waits:
            return _WAIT_TECHNOLOGY
        beside.finish()
        if not beside.at_rest:
            return _MANUAL
        if beside.alone.moving:
            return _AXIS_JOB
        self.at_end = gate
        return self._open(gate)

    def _leave_out(self, gate: QueueRecord) -> int:
        """The path stands at the begin of a section that is left out: it goes on where its end is known."""
        path, around = self._path, self._around
        if not self._running or not path.standstill or not path.all_told:
            return _OPTIONAL_SECTION
        problem = self._section.leave_out(gate, self._place(gate), around.link.running)
        if problem is not None:
            around.report(problem)
        elif self._section.gone:
            around.functions.look_again()
            return self._open(gate)
        return _OPTIONAL_SECTION

    def _dwell(self, gate: QueueRecord) -> int:
        period, inputs = self._around.period, self._inputs
        if self._dwell_left < 0.0:
            self._dwell_left = gate.seconds
        share = inputs.override if self._influence.feed_stretches_dwell else 1.0
        if self._influence.time_stretches_dwell:
            share *= inputs.time_override
        self._dwell_left -= period * share
        if self._dwell_left > 0.5 * period:
            return _DWELL
        self._dwell_left = -1.0
        return self._open(gate)

    def _flush_wait(self, gate: QueueRecord) -> int:
        """The decoder goes on when functions of every kind and messages have been taken; it gets to know where the axes are."""
        path, around = self._path, self._around
        if not path.standstill or not path.all_told or self._settles():
            return _NONE
        if around.functions.pending:
            return _WAIT_TECHNOLOGY
        if not around.actions.all_taken:
            return _MESSAGE
        self._settling = 0.0
        around.link.reach(
            path.position + around.beside.offset - around.beside.by_hand,
            self._actual[around.axes],
            around.beside.by_hand,
        )
        return self._open(gate)

    def _exact_stop(self, gate: QueueRecord) -> int:
        """However long it takes: an axis that never comes there keeps the path from going on."""
        if not self._path.standstill or self._on_their_way():
            return _EXACT_STOP
        return self._open(gate)

    def _filter(self, gate: QueueRecord) -> int:
        """The filter of the set-points changes where nothing moves; not while the program is being aborted."""
        path = self._path
        if self._running and path.standstill and path.all_told:
            halves = path.queue.record(path.gate)["end"][: len(path.position)]
            path.change_filter(halves.astype(np.int64).tolist(), gate.value, gate.seconds, gate.lead)
            return self._open(gate)
        return _NONE

    def _spindle_begins(self, gate: QueueRecord) -> int:
        """Path and spindle move together from here on: it stands, or it is at its speed and comes to its angle."""
        path = self._path
        ready = self._running and path.standstill and path.all_told
        if ready and not self._on_their_way() and self._around.together.begin(path.gate, gate):
            return self._open(gate)
        return _WAIT_SPINDLE

    def _spindle_ends(self, gate: QueueRecord) -> int:
        """Path and spindle are free again; nobody drives back over what they did together."""
        path = self._path
        if self._running and path.standstill and path.all_told and self._around.together.end():
            self._around.backward.clear()
            return self._open(gate)
        return _WAIT_SPINDLE

    def _measure(self, gate: QueueRecord) -> int:
        """A measuring run begins when its probes are ready."""
        path, around = self._path, self._around
        if not (self._running and path.standstill and path.all_told):
            return _MEASURING
        ready = around.measuring.ready(path.queue.record(path.gate))
        if isinstance(ready, Problem):
            around.report(replace(ready, place=self._place(gate)))
        return self._open(gate) if ready is True else _MEASURING

    def _measured(self, gate: QueueRecord) -> int:
        """A measuring run is over: the decoder gets its values with the next place that it waits for."""
        path, around = self._path, self._around
        if not (self._running and path.standstill and path.all_told):
            return _MEASURING
        measuring = around.measuring
        final = measuring.finish()
        if isinstance(final, Problem):
            around.report(replace(final, place=self._place(gate)))
        if final is not True:
            return _MEASURING
        around.link.measure(measuring.values, measuring.done)
        return self._open(gate)

    def _axis_jobs(self, gate: QueueRecord) -> int:
        """Jobs of axes outside the path are done, or the program ends here."""
        around = self._around
        if self._running and self._path.all_told:
            problem = around.jobs.in_vain(gate.number)
            if problem is not None:
                around.report(problem)
            elif around.jobs.passable(gate.number):
                return self._open(gate)
        return _AXIS_JOB

    def _own_motion(self, gate: QueueRecord) -> int:
        """An axis begins to move by itself; the path goes on."""
        path = self._path
        if not (self._running and path.standstill and path.all_told):
            return _NONE
        self._around.beside.begin_alone(gate, path, locked=self._locked)
        return self._open(gate)

    def _couple(self, gate: QueueRecord) -> int:
        """Axes begin to follow others, or no longer do."""
        path = self._path
        if not (self._running and path.standstill and path.all_told):
            return _NONE
        record = path.queue.record(path.gate)
        masters, ahead = record["start"].tolist(), record["end"].tolist()
        axes = range(len(self._around.axes))
        self._around.beside.couple([(k, int(masters[k]) - 1, ahead[k]) for k in axes if masters[k] > 0.0], path)
        return self._open(gate)

    def _own_motions_over(self, gate: QueueRecord) -> int:
        """Own motions have come to their targets; with exact stop the axes too."""
        if not self._around.beside.alone.arrived(gate.number):
            return _AXIS_JOB
        if gate.offset and self._on_their_way():
            return _EXACT_STOP
        return self._open(gate)

    def _beside_path(self, gate: QueueRecord) -> int:
        """Axes are moved by hand or homed while the path stands; then it goes on from where they are."""
        path, around, beside = self._path, self._around, self._around.beside
        if axis := beside.moving_at_end(gate, self._pressed):
            around.report(Problem(machine.MANUAL_MOVING, {"axis": axis}, self._place(gate)))
        if not self._running:
            return _MANUAL
        if not beside.at_rest:
            self._settling = 0.0
        settled = path.standstill and path.all_told and not self._settles()
        if not (self._locked and gate.reason is GateReason.HOMING):  # axes that do not move cannot be homed
            passage = beside.gate(gate, path, self._pressed, settled)
            if not passage.open:
                return passage.stop
        self._settling = 0.0
        if gate.reason is not GateReason.MANUAL_END:
            taken = beside.take_over(path)
            if gate.reason is GateReason.SET_POSITION:
                beside.set_position(gate, path, locked=self._locked)
            around.link.reach(path.position, self._actual[around.axes], taken)
        return self._open(gate)

    def _search(self, gate: QueueRecord) -> int:
        """A block search: the PLC agrees, the axes go back to the contour, the program goes on."""
        path, around, search = self._path, self._around, self._around.search
        if not self._running or not path.all_told:
            return _BLOCK_SEARCH
        search.arrived(gate.reason)
        automatic = gate.number != 0
        waits = _BLOCK_SEARCH
        if gate.reason is GateReason.SEARCH_RETURN:
            hand = GateReason.TAKE_OVER if automatic else GateReason.MANUAL
            waits = self._beside_path(gate._replace(reason=hand, number=self._every_axis)) | _RETURN_TO_CONTOUR
        elif gate.reason is GateReason.SEARCH_GO_ON:
            if automatic:
                path.open_gate()
            else:
                waits = self._go_on(_RETURN_TO_CONTOUR | _WAIT_CONTINUE)
        elif search.agrees(bool(around.area.plc_present_w)):
            if gate.reason is GateReason.SEARCH_BEGIN:
                around.link.reach(path.position, self._actual[around.axes])
            path.open_gate()
        if path.gate >= 0:
            return waits
        search.passed(gate.reason)
        return _NONE

    def _user_error(self, gate: QueueRecord) -> int:
        """The path goes no further: the alarm aborts the program here."""
        if not self._user_error_told:
            self._user_error_told = True
            fatal = gate.value > _FATAL
            self.fatal |= fatal
            entry: ErrorEntry = machine.USER_FATAL if fatal else machine.USER_ERROR
            self._around.report(Problem(entry, {"text": self._path.queue.texts.take(gate.text)}, self._place(gate)))
        return _ERROR

    # ------------------------------------------------------------------ what they have in common

    def _go_on(self, waits: int) -> int:
        """The operator says continue: the path goes on when the axes are in their windows. What it waits for until then."""
        self._asked_on |= self._pressed
        if not self._asked_on:
            return waits
        if self._influence.looks_at_axes and self._on_their_way():
            return _EXACT_STOP
        self._asked_on = False
        self._path.open_gate()
        return _NONE

    def _settles(self) -> bool:
        """The axes are still on their way to where the path stands, and have not yet taken too long for it."""
        self._settling += self._around.period
        return self._settling < _SETTLED_AT_LAST and self._on_their_way()

    def _on_their_way(self) -> bool:
        """An axis is not yet within its window around where the path, and whatever is beside it, sends it."""
        if self._locked:
            return False
        around = self._around
        lag = np.abs(self._path.position + around.beside.offset - self._actual[around.axes])
        return bool((lag > around.window).any())

    def _place(self, gate: QueueRecord) -> Place:
        return Place(self._path.queue.program_name(gate.program), gate.line)
