"""One NC channel in the cycle: path, technology functions, gates, spindles, and the mode it is in.

    preparation ─▶ motion queue ─▶ interpolator ──▶ axis set-points
                                     │  passed: functions, block ends        ▲
                                     ▼                                       │ gate opened
                                  technology port ──▶ PLC ──▶ acknowledged ──┘

The interpolator knows the path, its speed, and gates: places where it stops unless they are opened. `cnc/gates.py` decides
when that is. A gate may be opened long before the path gets there; then the path runs through it without slowing down.
"""

from __future__ import annotations

from collections import deque
from collections.abc import Mapping, Sequence
from dataclasses import replace
from enum import Enum, auto

import numpy as np
import numpy.typing as npt

from runtime.cnc.actions import Actions, Told, Warned
from runtime.cnc.actual_limits import ActualLimits
from runtime.cnc.axes.feed_forward import FeedForwardShares
from runtime.cnc.axes.program_jobs import ProgramJobs
from runtime.cnc.axes.spindle import DEGREES_PER_SECOND, Spindle
from runtime.cnc.backward_motion import BackwardMotion, RepeatedStops, Way
from runtime.cnc.beside_path import ACTIONS, BesidePath
from runtime.cnc.block_search import BlockSearching
from runtime.cnc.channel_inputs import ChannelInputs
from runtime.cnc.cutting_speed import CuttingSpeeds
from runtime.cnc.delete_distance import DeleteDistance
from runtime.cnc.distance_display import DistanceDisplay
from runtime.cnc.gates import Gates, OperatorInfluence, Surroundings
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.job_records import read_job
from runtime.cnc.measuring import Measuring
from runtime.cnc.motion_queue import ActionKind, MotionQueue, RecordKind
from runtime.cnc.preparation_link import PreparationLink, PreparationState, StartOrder
from runtime.cnc.queue_record import QueueRecord, read_record
from runtime.cnc.stop_before import StopBefore
from runtime.cnc.suppression import Suppression
from runtime.cnc.synchronous_spindle import SynchronousSpindle
from runtime.cnc.technology import TechnologyFunctions, TechnologySettings, Travel
from runtime.diagnostics.catalogue import CATALOGUE, machine
from runtime.diagnostics.errors import ErrorEntry, Place, Problem, Reaction, Severity
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.drives import DriveImage
from runtime.hli.block_search import SearchPartner
from runtime.hli.layout import Channel as ChannelArea
from runtime.hli.layout import Hli, PathWay, StopCondition
from runtime.hli.technology import TechnologyPort

Floats = npt.NDArray[np.float64]

# plain numbers: flags of the enum class are slow to combine in every cycle
_LAST_MOTION, _FUNCTION = int(RecordKind.POLYNOMIAL), int(RecordKind.FUNCTION)
_BLOCK_END, _ACTION = int(RecordKind.BLOCK_END), int(RecordKind.ACTION)
_FUNCTION_AHEAD = int(RecordKind.FUNCTION_AHEAD)
_NONE = int(StopCondition.NONE)
_FEED_HOLD = int(StopCondition.FEED_HOLD)
_AXIS_FEED_HOLD = int(StopCondition.AXIS_FEED_HOLD)
_OVERRIDE_ZERO = int(StopCondition.OVERRIDE_ZERO)
_NO_BLOCKS = int(StopCondition.NO_BLOCKS)
_AXIS_NOT_READY = int(StopCondition.AXIS_NOT_READY)
_ERROR = int(StopCondition.ERROR)
_TECHNOLOGY_FULL = int(StopCondition.TECHNOLOGY_FULL)
_MESSAGE = int(StopCondition.MESSAGE)
_PROGRAM_WAITS = int(StopCondition.PROGRAM_WAITS)
_DELETE_DISTANCE = int(StopCondition.DELETE_DISTANCE)
_TURNING = int(StopCondition.TURNING)
_BACKWARD_END = int(StopCondition.BACKWARD_END)
_WAIT_SPINDLE = int(StopCondition.WAIT_SPINDLE)
_WAYS = {
    Way.ONWARD: int(PathWay.ONWARD),
    Way.TURNING: int(PathWay.TURNING),
    Way.BACKWARD: int(PathWay.BACKWARD),
    Way.REPEATING: int(PathWay.REPEATING),
}
_WITHOUT_EFFECT = frozenset(
    {ActionKind.OPTIONAL_ON, ActionKind.OPTIONAL_OFF, ActionKind.CLEAR_STORAGE, ActionKind.NOTHING}
)


class Phase(Enum):
    """What the channel does with its program."""

    IDLE = auto()
    STARTING = auto()  # ordered, the preparation has not yet answered
    RUNNING = auto()
    ABORTING = auto()  # braking on the path
    CLEARING = auto()  # standing; waits until the preparation has stopped writing


class Channel:
    """Built once; `step` is called in every cycle and never blocks, never allocates without bound, never raises.

    `axes` (n_axes,): indices of the path axes among all axes; `window` (n_axes,): how near each of them is to its set-point
    when it stands, mm or degrees.
    """

    def __init__(
        self,
        queue: MotionQueue,
        interpolator: Interpolator,
        link: PreparationLink,
        hli: Hli,
        area: ChannelArea,
        spindles: list[Spindle],
        axis_ports: Mapping[int, TechnologyPort],
        settings: TechnologySettings,
        events: EventRing,
        period: float,
        axes: npt.NDArray[np.int64],
        window: Floats,
        beside: BesidePath,
        stop_before: StopBefore,
        axis_names: Sequence[str],
        influence: OperatorInfluence | None = None,
        backward: BackwardMotion | None = None,
        measuring: Measuring | None = None,
    ) -> None:
        self._axes = axes
        self.backward = backward or BackwardMotion(interpolator, 0, RepeatedStops())
        self._distance = DistanceDisplay(interpolator, area.status)
        self.beside = beside
        self.stop_before = stop_before
        self._delete_distance = DeleteDistance(interpolator)
        names = [axis_names[i] for i in axes]
        self.measuring = measuring or Measuring(
            DriveImage(len(axis_names)), [hli.axes[i] for i in axes], axes.tolist(), names, period
        )
        self.jobs = ProgramJobs(axis_names)
        self.feed_forward = FeedForwardShares(len(axes), period)
        self.search = BlockSearching(SearchPartner(area.control.block_search_on, area.status))
        self.suppression = Suppression()
        self.actual_limits = ActualLimits(names)
        self.locked = False  # the axes are not moved in this program (machine lock)
        self.problems: deque[Problem] = deque(maxlen=128)  # taken by the runtime, which raises the alarms
        self.queue = queue
        self._block_ends = queue.records["block_end"]
        self._no_override = queue.records["override_off"]  # a view: making one takes its time
        self._rapid = queue.records["rapid"]
        self.together = SynchronousSpindle(interpolator, queue, spindles, period, self.problems.append)
        self.cutting_speed = CuttingSpeeds(interpolator, spindles)
        self.interpolator = interpolator
        self.link = link
        self.functions = TechnologyFunctions(
            queue,
            interpolator,
            TechnologyPort(area),
            axis_ports,
            spindles,
            area.status,
            settings,
            self._event,
            self.problems.append,
        )
        self.actions = Actions(queue, link, hli, area, self._tell_message, self._tell_warning)
        around = Surroundings(
            interpolator,
            link,
            area,
            self.functions,
            self.actions,
            beside,
            self.jobs,
            self.search,
            self.backward,
            self.measuring,
            stop_before,
            self.together,
            axes,
            window,
            period,
            self.problems.append,
        )
        self.gates = Gates(around, influence or OperatorInfluence())
        self.spindles = spindles
        self.events = events
        self.period = period
        self.phase = Phase.IDLE
        self.program = ""
        self.error: ErrorEntry | None = None  # keeps the channel from starting until it is reset
        self.stop_condition = _NONE  # StopCondition
        self.program_ended = True
        self.trace_blocks = False  # every block start and end as an event
        self.block_counter = 0
        self.path_length = 0.0  # mm, of the program that ended last
        self._drops = True
        self._continue_was = self._feeds_backward = False
        self._told_failure = False
        self._traced_index = -1
        self._traced_block: tuple[int, int | None] = (0, None)
        self._came_to_end = False  # of the program
        self._time = 0.0
        self._cycle = 0

    # ------------------------------------------------------------------ orders

    def start(self, order: StartOrder, *, locked: bool = False, keeps_path: bool = True) -> None:
        """Begin a program from its machine position (n_axes,); the caller has checked that the axes are ready."""
        order = replace(order, after_end=self._came_to_end)
        self.program = order.program
        self.locked = locked
        self.program_ended = False
        self.error = None
        self._told_failure = self._came_to_end = False
        self.gates.begin()
        self._traced_index = -1
        self.block_counter = 0
        self.actions.begin()
        self.queue.discard_all()
        self.cutting_speed.end()
        self.beside.begin()
        self.jobs.begin()
        self.actual_limits.begin()
        self.suppression.begin()
        self.search.begin(order, locked=locked)
        self._delete_distance.begin()
        self.backward.begin(off=not keeps_path)
        self.interpolator.restart(order.start)
        self.interpolator.begin_filter()
        self.feed_forward.order(np.zeros(len(self._axes)))
        self.functions.restart()
        self.link.start(order)
        self.phase = Phase.STARTING

    def abort(self) -> None:
        """Brake on the path, then drop the rest of the program."""
        if self.phase is Phase.STARTING:
            self._clear(drop=True)
        elif self.phase is Phase.RUNNING:
            self.interpolator.abort()
            self.beside.stop()
            self.jobs.stop()
            self.phase = Phase.ABORTING

    def abort_at_once(self, position: Floats) -> None:
        """The axes brake by themselves (quick stop, bus gone): drop the program, the path starts anew at `position`."""
        if self.phase in (Phase.STARTING, Phase.RUNNING, Phase.ABORTING):
            self._clear(drop=True)
        self.beside.drop()
        self.jobs.drop()
        self.backward.end()
        self.interpolator.restart(position)

    def fail(self, entry: ErrorEntry) -> None:
        """An error keeps the channel from starting until it is reset; spindles stop with the path."""
        if self.error is None:
            self.error = entry
        self._stop_spindles()
        self.jobs.drop()  # whoever reacts to the error stops every axis
        self.abort()

    def reset(self) -> None:
        """Abort, drop pending functions and messages, clear the error unless it is fatal, stop the spindles."""
        self.jobs.drop()
        self.abort()
        self._stop_spindles()
        self.functions.drop()
        self.actions.drop()
        if self.phase is Phase.IDLE:
            self.actions.life.save()
        if not self.restart_needed:
            self.error = None

    def _stop_spindles(self) -> None:
        for spindle in self.spindles:
            spindle.stop()

    def _clear(self, *, drop: bool) -> None:
        """The program is over. `drop`: what is still out is withdrawn; else the PLC goes on with it."""
        self.link.abort()
        if not self._came_to_end:
            self.jobs.stop()
        self.search.end(reached=self._came_to_end)
        self.together.drop()
        self.cutting_speed.end()
        self._distance.end()
        self.suppression.begin()
        self.gates.end()
        self.measuring.drop()
        self._drops = drop
        self.phase = Phase.CLEARING

    # ------------------------------------------------------------------ what the others want to know

    @property
    def active(self) -> bool:
        """A program is in work (also while it brakes for an abort)."""
        return self.phase is not Phase.IDLE

    @property
    def at_rest(self) -> bool:
        """Nothing moves the path any more: no program, or one that only waits until the preparation has let go of it."""
        return self.phase in (Phase.IDLE, Phase.CLEARING)

    @property
    def held(self) -> bool:
        """Feed hold is on, of the channel or of an axis, and the path stands."""
        return bool(self.stop_condition & (_FEED_HOLD | _AXIS_FEED_HOLD)) and self.interpolator.standstill

    @property
    def restart_needed(self) -> bool:
        """A program has told a fatal error: no reset clears it."""
        return self.gates.fatal

    @property
    def waiting_functions(self) -> int:
        """Functions that are out, or due, and not yet acknowledged."""
        return self.functions.waiting

    @property
    def programmed_feed(self) -> float:
        """F word of the block being executed, mm/s; infinite for rapid, 0 without a block."""
        index, queue = self.interpolator.index, self.interpolator.queue
        if not self.active or index < queue.read:
            return 0.0
        record = queue.record(index)
        return float(record["f_word"] or record["feed"])

    @property
    def shown_feed(self) -> float:
        """Path velocity, mm/s; below 0 while a feed of the PLC drives the path backward."""
        velocity = self.interpolator.path_velocity
        return -velocity if self._feeds_backward and self.backward.backward else velocity

    @property
    def path_way(self) -> int:
        """How the path is driven (runtime.hli.layout.PathWay)."""
        return _WAYS[self.backward.way]

    # ------------------------------------------------------------------ the cycle

    def step(
        self, inputs: ChannelInputs, axes_ready: bool, speeds: Floats, actual: Floats, time: float, cycle: int
    ) -> None:
        """One cycle. `axes_ready`: all path axes may move; `speeds`: actual spindle speeds, degrees/s, `actual`:
        positions, mm or degrees, both of all axes of the machine."""
        self._time, self._cycle = time, cycle
        pressed = inputs.continue_motion and not self._continue_was
        self._continue_was = inputs.continue_motion
        if self.phase is Phase.STARTING and self.link.answered:
            self.phase = Phase.RUNNING
        if self.phase is Phase.CLEARING and self.link.answered:
            self._cleared()
        self._feeds_backward = inputs.feeds_backward
        self.functions.acknowledge(speeds)
        self.actions.step()
        if self.phase not in (Phase.RUNNING, Phase.ABORTING):
            self.stop_condition = _ERROR if self.error else _NONE
            return
        self.functions.put_out_late()
        stop = _NONE
        backward, together, measuring = self.backward, self.together, self.measuring
        if self.suppression.held(inputs.feed_hold, backward.replaying):
            stop |= _FEED_HOLD
        if self.phase is Phase.RUNNING:
            free = not (together.active or measuring.active)
            backward.step(inputs.backward and free, inputs.simulate_motion, inputs.simulate_mask)
            if backward.changed:
                self.gates.look_again()
        if backward.holds:
            stop |= _TURNING
        again = backward.replaying
        self.functions.travel = self._travel() if again or inputs.simulate_motion else Travel.FORWARD
        if inputs.delete_distance and self.phase is Phase.RUNNING and not again and not together.active:
            if measuring.active:
                self._delete_distance.cut()
            else:
                self._delete_distance.order()
            if self._distance.active:
                self._warn_of_distance(machine.DISTANCE_WRONG)
        if measuring.active:
            self._measure(actual, time)
        if self._delete_distance.holds:
            stop |= _DELETE_DISTANCE
        before = self.stop_before
        before.step(inputs)
        stop |= before.hold
        if not axes_ready:
            stop |= _AXIS_NOT_READY
        if self.functions.full:
            stop |= _TECHNOLOGY_FULL
        if self.actions.full:
            stop |= _MESSAGE
        if self._on(self._no_override) or self.suppression.full_override(again):
            override = rapid_override = 1.0
        else:
            override, rapid_override = (
                inputs.override * inputs.time_override,
                inputs.rapid_override * inputs.time_override,
            )
        external_feed = inputs.external_feed
        if inputs.feeds_backward and (measuring.active or not backward.possible):
            external_feed = 0.0
        stands = override == 0.0 or external_feed == 0.0
        if stands or rapid_override == 0.0:
            stop |= _OVERRIDE_ZERO
        held = stop & ~_OVERRIDE_ZERO != 0
        path = self.interpolator
        single = inputs.single_block or before.stop_at_block_ends
        together.barred = held or stands
        if together.cutting:  # nobody but the spindle, and what keeps the axes from moving, has a say
            override = rapid_override = 1.0
            external_feed = together.wanted()
            held, stands, single = stop & _AXIS_NOT_READY != 0, False, False
        for k, spindle in enumerate(self.spindles):
            path.turns(k, abs(spindle.set_point) / DEGREES_PER_SECOND)
        path.step(
            override=override,
            rapid_override=rapid_override,
            external_feed=external_feed,
            feed_hold=held,
            single_block=single,
        )
        life = self.actions.life
        if life.wanted and not again:
            life.moves(path.path_position, self.period, self._on(self._rapid))
        problem = self.beside.step(inputs, path, actual[self._axes], ready=axes_ready)
        if problem is not None:
            self.problems.append(problem)
        if self.phase is Phase.RUNNING and (problem := self.jobs.step()) is not None:
            self.problems.append(problem)
        if (problem := self.actual_limits.step(actual, self._axes)) is not None:
            self.problems.append(problem)
        passed = path.passed
        if together.tapping:
            together.lead(passed)
        if self.cutting_speed.active:
            self.cutting_speed.step()
        if again:
            self._pass_again(passed)
        else:
            for index in passed:
                self._pass(index)
            backward.follow()
        if self._distance.step(backward=backward.backward, replaying=again):
            self._warn_of_distance(machine.DISTANCE_LATE)
        self.search.follow(path.path_position, path.line, path.n)
        if not again:
            self.functions.look_ahead(held=held or stands)
            if life.wanted:
                life.moved(path.path_position)
            if self.trace_blocks:
                self._trace_blocks(passed)
        elif backward.at_begin:
            stop |= _BACKWARD_END
        if path.standstill and self._waits_to_turn():
            stop |= _WAIT_SPINDLE
        gate = path.gate
        running = self.phase is Phase.RUNNING
        stop |= self.gates.step(inputs, pressed=pressed, running=running, locked=self.locked, actual=actual)
        if self.gates.at_end is not None:
            self._end(self.gates.at_end)
        if gate >= 0 and path.gate < 0 and not inputs.single_block:
            path.open_steps(gate)
        if self.phase is Phase.RUNNING and not again:
            if self._delete_distance.holds and not measuring.active:
                self._delete_distance.cut_is_over()
            self._delete_distance.step()
        if path.apart and self.phase is Phase.RUNNING and not self._delete_distance.explains_gap:
            self._tell_gap()
            self._clear(drop=True)
        elif self.phase is Phase.ABORTING and path.aborted and self.beside.at_rest:
            self._clear(drop=True)
        elif self.phase is Phase.RUNNING and not again and (path.starved or self._nothing_will_come()):
            stop |= self._out_of_blocks()
        if stop != self.stop_condition:
            standing = stop & ~_OVERRIDE_ZERO
            kind = EventKind.STOP if standing else EventKind.GO
            self._event(kind, path.line, self._n, number=stop)
            self.stop_condition = stop

    def _waits_to_turn(self) -> bool:
        """The path stands in front of, or on, an element with a feed per revolution of a spindle that stands."""
        path = self.interpolator
        here = path.next_index
        if here >= path.queue.written or path.queue.kind(here) > _LAST_MOTION:
            return False
        record = path.queue.record(here)
        return record["external"] < 0.0 and self.spindles[int(record["spindle"])].set_point == 0.0

    def _measure(self, actual: Floats, time: float) -> None:
        """The edge of a probe stops the path in the cycle that it is seen in."""
        problem = self.measuring.step(actual[self._axes], time)
        if problem is not None:
            place = Place(self.queue.program_name(self.interpolator.program), max(self.interpolator.line, 0))
            self.problems.append(replace(problem, place=place))
        if self.measuring.cuts:
            self.measuring.cuts = False
            self._delete_distance.cut()

    def _travel(self) -> Travel:
        """How functions count where the path is driven again, or in simulated motion."""
        if not self.backward.replaying:
            return Travel.SIMULATED
        return Travel.BACKWARD if self.backward.backward else Travel.SIMULATED_FORWARD

    def _place_of(self, index: int) -> float:
        """Where along the path (mm) a record lies that was passed in this cycle."""
        path, queue = self.interpolator, self.queue
        if path.index < max(index, queue.read):  # the path stands at the end of the element before it
            return path.path_position
        elements = [i for i in range(index + 1, path.index + 1) if queue.kind(i) <= _LAST_MOTION]
        return path.path_position + path.remaining - sum(float(queue.record(i)["length"]) for i in elements)

    def _on(self, flags: npt.NDArray[np.int64]) -> bool:
        """The path is on an element with this flag; where it is driven again no flag counts."""
        if self.backward.replaying:
            return False
        index = self.interpolator.index
        return index >= self.queue.read and bool(flags[index % self.queue.capacity])

    def _out_of_blocks(self) -> int:
        """Nothing more is known: the preparation is behind, or it has failed and this is as far as the program goes."""
        self._tell_failure()
        if self.link.state is PreparationState.FAILED and self.interpolator.standstill and not self.functions.end_waits:
            self._clear(drop=False)
        return _NO_BLOCKS | _PROGRAM_WAITS if self.link.holds else _NO_BLOCKS

    def _tell_gap(self) -> None:
        """The next block does not begin where the axes stand: an error of ours, seen before anything moved."""
        path = self.interpolator
        record = path.queue.record(path.next_index)
        gap = np.abs(record["start"][: len(path.position)] - path.position)
        axis = int(np.argmax(gap))
        values = {"axis": axis + 1, "start": float(record["start"][axis]), "position": float(path.position[axis])}
        self.problems.append(Problem(machine.PATH_APART, values, Place(self.program, int(record["line"]))))

    def _nothing_will_come(self) -> bool:
        """Nothing was handed over, and nothing will be: file missing, error found by its check, or the decoder waits."""
        return self.interpolator.nothing_known and (self.link.state is PreparationState.FAILED or self.link.holds)

    def _tell_failure(self) -> None:
        if self.link.state is PreparationState.FAILED and not self._told_failure:
            self._told_failure = True
            failure = self.link.problem
            entry = CATALOGUE.get(failure.id, machine.PREPARATION_FAILED)
            told = ErrorEntry(entry.id, "{text}", entry.severity, Reaction.NONE, entry.remedy)
            self.error = told
            place = Place(failure.file or self.program, failure.line, failure.column)
            self.problems.append(Problem(told, {"text": failure.text}, place))

    def _end(self, gate: QueueRecord) -> None:
        """The path has come to the end of the program."""
        self._event(EventKind.BLOCK_END, gate.line, gate.n)
        self._came_to_end = True
        self._clear(drop=False)

    def _cleared(self) -> None:
        self._tell_failure()
        self.path_length = self.interpolator.path_position
        self.backward.end()
        self.queue.discard_all()
        self.interpolator.restart(self.interpolator.position.copy())
        if self._drops:
            self.functions.drop()
        self.functions.restart()
        if not self._came_to_end:
            self.actions.life.save()
        self.gates.cleared()
        self.program_ended = True
        self.phase = Phase.IDLE

    # ------------------------------------------------------------------ what the path passes

    def _pass_again(self, passed: Sequence[int]) -> None:
        """What the path has passed before: functions are put out as their types tell, nothing else is done again."""
        queue = self.interpolator.queue
        for index in passed:
            if queue.kind(index) == _FUNCTION:
                self.functions.take_again(read_record(queue, index))

    def _pass(self, index: int) -> None:
        kind = self.queue.kind(index)
        if kind == _FUNCTION:
            self.functions.take(index)
        elif kind == _FUNCTION_AHEAD:
            self.functions.take_ahead(index)
        elif kind == _BLOCK_END or (kind <= _LAST_MOTION and self._block_ends[index % self.queue.capacity]):
            self.block_counter += 1
        elif kind == _ACTION:
            record = read_record(self.queue, index)
            if record.action in ACTIONS:
                self.beside.act(record)
            elif record.action is ActionKind.AXIS_JOB:
                if self.phase is Phase.RUNNING:  # what is passed while the path brakes for an abort moves nothing
                    self.jobs.order(read_job(self.queue, index), locked=self.locked)
            elif record.action is ActionKind.ACTUAL_LIMIT:
                self.actual_limits.act(record)
            elif record.action is ActionKind.SPINDLE:
                self.functions.set_spindle(record)
            elif record.action is ActionKind.CUTTING_SPEED:
                self.cutting_speed.order(record)
            elif record.action is ActionKind.FEED_FORWARD:
                self.feed_forward.order(self.queue.record(index)["end"][: len(self._axes)])
            elif record.action is ActionKind.SUPPRESSION:
                self.suppression.act(record)
            elif record.action is ActionKind.DISTANCE_BEGIN:
                self._distance.begin(index)
            elif record.action is ActionKind.DISTANCE_END:
                self._distance.end()
            elif record.action in _WITHOUT_EFFECT:
                return
            elif record.action is ActionKind.SEARCH_PLACE:
                self.search.place(record.value, self.interpolator.path_position)
                self.block_counter = record.offset
            else:
                place = self._place_of(index) if record.action is ActionKind.TOOL_LIFE else 0.0
                self.actions.carry_out(record, place)

    # ------------------------------------------------------------------ events

    def _warn_of_distance(self, entry: ErrorEntry) -> None:
        path = self.interpolator
        self.problems.append(Problem(entry, {}, Place(self.queue.program_name(path.program), max(path.line, 0))))

    def _tell_message(self, message: Told) -> None:
        self._event(
            EventKind.MESSAGE,
            message.line,
            message.n,
            message.receiver,
            float(message.information),
            text=message.text,
        )

    def _tell_warning(self, warning: Warned) -> None:
        entry = CATALOGUE.get(warning.number, machine.USER_WARNING)
        told = ErrorEntry(entry.id, "{text}", Severity.WARNING, Reaction.NONE, entry.remedy)
        self.problems.append(Problem(told, {"text": warning.text}, Place(warning.program, warning.line)))

    @property
    def _n(self) -> int | None:
        """Block number of the block being executed."""
        n = self.interpolator.n
        return None if n < 0 else n

    def _trace_blocks(self, passed: Sequence[int]) -> None:
        """Block start and end events for the elements that were entered in this cycle: several, if they are short."""
        for index in passed:
            if index > self._traced_index and self.queue.kind(index) <= _LAST_MOTION:
                self._trace_entry(index)
        if self.interpolator.index > self._traced_index:
            self._trace_entry(self.interpolator.index)

    def _trace_entry(self, index: int) -> None:
        record = self.queue.record(index)
        n = int(record["n"])
        if self._traced_index >= 0:
            self._event(EventKind.BLOCK_END, *self._traced_block)
        self._traced_index = index
        self._traced_block = (int(record["line"]), None if n < 0 else n)
        self._event(EventKind.BLOCK_START, *self._traced_block)

    def _event(
        self,
        kind: EventKind,
        line: int,
        n: int | None,
        number: int = 0,
        value: float = 0.0,
        axis: int = -1,
        text: str = "",
    ) -> None:
        self.events.put(
            Event(
                t=self._time,
                cycle=self._cycle,
                kind=kind,
                line=line,
                n=n,
                number=number,
                value=value,
                path_pos=self.interpolator.path_position,
                axis=axis,
                text=text,
            )
        )
