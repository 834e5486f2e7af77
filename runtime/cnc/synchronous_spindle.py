"""Path and spindle move together: threads (G33), where the path follows the spindle, and tapping, where it is the other way.

    tapping   path ─ look-ahead, override, feed hold, abort ─▶ way in the section ─ degrees per mm ─▶ angle of the spindle
    thread    angle of the spindle ─ degrees per mm ─▶ speed that the path is to have ─▶ look-ahead

So in tapping nothing needs to know of the spindle: whatever stops the path stops it too, in the hole as well, and its limits are
limits along the path. In a thread the look-ahead keeps the limits of the axes as always; what is asked of it changes in every
cycle with the spindle and with what the path is off:

    angle ▲            ╱ spindle, less where the thread begins      the path begins so much earlier that it would have been at the
          │         ╱╱                                              begin of the thread with the spindle at its angle, had it not
          │      ╱╱ path                                            needed the run-in. So every pass meets the same groove,
          │  ___╱                                                   whatever its speed.
          └──────────▶ t     run-in │ together │ run-out: the path brakes for the end of the section

A section is entered only when the whole of it is in the queue, so that the preparation cannot keep it from going on. Override and
feed hold do not act in a thread; they do behind it.
"""

from __future__ import annotations

import math
from collections import deque
from collections.abc import Callable, Sequence

import numpy as np
import numpy.typing as npt

from runtime.cnc.axes.spindle import DEGREES_PER_SECOND, TURN, Spindle
from runtime.cnc.blocks import SpindleRole
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.interpolator.prediction import ramp_time
from runtime.cnc.motion_queue import GateReason, MotionQueue, RecordKind
from runtime.cnc.queue_record import QueueRecord
from runtime.diagnostics.catalogue import spindle as errors
from runtime.diagnostics.errors import ErrorEntry, Place, Problem

Ints = npt.NDArray[np.int64]

MOST_RECORDS = 2048  # of a section
MOST_CYCLES = 20  # that a measured speed is the mean of
_GAIN = 40.0  # 1/s: what the path is off becomes speed
_SETTLES = 0.1  # s behind the run-in until being off is an error
_PATH_OFF = 0.1  # share of a turn that the path may be off in a thread
_ROUNDING = 1.0 + 1e-6
_MOTION, _GATE = int(RecordKind.POLYNOMIAL), int(RecordKind.GATE)
_FREE = int(GateReason.SPINDLE_FREE)
_TAPPING = int(SpindleRole.TAPPING)


class SynchronousSpindle:
    """Of one channel. `lead` is called behind the interpolator in every cycle of tapping, `wanted` in front of it in one of a
    thread; the gates of a section ask `begin` and `end`. `barred`: nothing may begin to move."""

    SCRATCH = ("barred",)

    def __init__(
        self,
        path: Interpolator,
        queue: MotionQueue,
        spindles: Sequence[Spindle],
        period: float,
        report: Callable[[Problem], None],
    ) -> None:
        self._path = path
        self._queue = queue
        self._spindles = spindles
        self._period = period
        self._report = report
        self.barred = False
        self.role = SpindleRole.FREE
        self._spindle: Spindle | None = None
        self._source = (0, 0)  # program and line of the section
        self._zero = 0.0  # angle of the spindle at the begin of the section
        self._turned = 0.0  # tapping: by how far it has to have turned
        self._measured = False
        self._speeds: deque[float] = deque(maxlen=MOST_CYCLES)  # measured, degrees/s
        self._cycles = 0
        self._told = -1  # gate at which something was told
        self._run_in = self._settles = 0.0  # s
        self._sense = 1.0  # of the spindle
        self._end = 0.0  # of the section, as path position, mm
        self._acceleration = self._jerk = 1.0  # least of the section
        self._turn = 0.0  # degrees per mm where the path is
        self.off = 0.0  # mm that the path is behind the spindle in a thread

    @property
    def active(self) -> bool:
        """The path is in a section, or is about to enter it."""
        return self.role is not SpindleRole.FREE

    @property
    def cutting(self) -> bool:
        """The path follows the spindle."""
        return self.role is SpindleRole.THREAD

    @property
    def tapping(self) -> bool:
        """The spindle follows the path."""
        return self.role is SpindleRole.TAPPING

    # ------------------------------------------------------------------ gates

    def begin(self, index: int, gate: QueueRecord) -> bool:
        """The path stands at the begin of a section, record `index`: whether it may go on in the next cycle."""
        spindle = self._spindles[gate.mask]
        if self.barred or index == self._told:
            return False
        self._source = (gate.program, gate.line)
        if gate.reason is GateReason.TAPPING:
            if not spindle.at_rest:
                return False
            self._spindle, self.role = spindle, SpindleRole.TAPPING
            self._zero, self._turned = spindle.follow(), 0.0
            return True
        return self._begin_thread(index, gate, spindle)

    def _begin_thread(self, index: int, gate: QueueRecord, spindle: Spindle) -> bool:
        self._measured, self._cycles = bool(gate.number), gate.size
        self._speeds.append(spindle.velocity)
        if not spindle.at_speed:
            spindle.unlock()
            return False
        elements = self._elements(index)
        if elements is None:
            return False
        if not self._measured:
            spindle.lock(steady=bool(gate.offset))
        angle, speed = self._now(spindle)
        speed = abs(speed)
        records = self._queue.records
        velocity = speed / records["value"][elements]
        self._acceleration = float(records["a_limit"][elements].min())
        self._jerk = float(records["j_limit"][elements].min())
        if not self._possible(index, elements, speed, velocity, spindle):
            spindle.unlock()
            return False
        # the path gets its first set-point a cycle behind the one for which the spindle has been asked
        run_in = ramp_time(float(velocity[0]), self._acceleration, self._jerk)
        sense = 1.0 if spindle.speed_told >= 0.0 else -1.0
        ahead = sense * (angle - gate.value) + speed * run_in / 2.0
        passed = ahead % TURN
        if passed >= speed * self._period:
            return False
        self._zero = angle + sense * (speed * run_in / 2.0 - passed)
        self._spindle, self._sense, self.role = spindle, sense, SpindleRole.THREAD
        self._run_in, self._settles, self.off = run_in, _SETTLES, 0.0
        self._end = self._path.path_position + float(records["length"][elements].sum())
        return True

    def _elements(self, index: int) -> Ints | None:
        """The slots of the elements of a section behind its gate, None as long as its end is not known."""
        queue = self._queue
        last = min(queue.written, index + 1 + MOST_RECORDS)
        slots = np.arange(index + 1, last) % queue.capacity
        kinds = queue.records["kind"][slots]
        ends = np.flatnonzero((kinds == _GATE) & (queue.records["reason"][slots] == _FREE))
        if not len(ends):
            if last - index > MOST_RECORDS:
                self._tell(index, errors.SECTION_LONG, count=MOST_RECORDS)
            return None
        elements: Ints = slots[: ends[0]][kinds[: ends[0]] <= _MOTION]
        return elements

    def _possible(
        self, index: int, elements: Ints, speed: float, velocity: npt.NDArray[np.float64], spindle: Spindle
    ) -> bool:
        """Whether the axes can do what the spindle asks for; else it is told."""
        records, told = self._queue.records, speed / DEGREES_PER_SECOND
        turn = records["value"][elements]
        most = (records["v_limit"][elements] * turn).min()
        over = (records["v_entry"][elements][1:] * turn[1:]).min() if len(elements) > 1 else np.inf
        if speed > most * _ROUNDING or speed > over * _ROUNDING:
            what = "an axis is too slow" if most <= over else "the corner between two blocks of the chain is too sharp"
            limit = min(float(most), float(over)) / DEGREES_PER_SECOND
            self._tell(index, errors.THREAD_NOT_FOLLOWED, spindle=spindle.axis.name, speed=told, what=what, limit=limit)
            return False
        length = float(records["length"][elements].sum())
        first, last = float(velocity[0]), float(velocity[-1])
        needed = (self._brake_way(first) + self._brake_way(last)) * _ROUNDING
        if needed > length:
            values = {"length": length, "spindle": spindle.axis.name, "speed": told, "needed": needed}
            self._tell(index, errors.THREAD_TOO_SHORT, **values)
            return False
        return True

    def _brake_way(self, velocity: float) -> float:
        """mm in which the path gets so fast, or comes to rest from it."""
        return velocity * ramp_time(velocity, self._acceleration, self._jerk) / 2.0

    def end(self) -> bool:
        """The path stands at the end of a section: whether it may go on."""
        if self.tapping and self._spindle is not None and not self._spindle.at_rest_led:
            return False
        self.drop()
        return True

    def drop(self) -> None:
        """Path and spindle are no longer bound: the section, or the program, is over."""
        if self._spindle is not None:
            self._spindle.release()
        for spindle in self._spindles:
            if spindle.locked:
                spindle.unlock()
        self.role, self._spindle, self._told = SpindleRole.FREE, None, -1

    # ------------------------------------------------------------------ the cycle

    def _now(self, spindle: Spindle) -> tuple[float, float]:
        """Angle and speed of the spindle as the path sees them, behind this cycle: degrees, degrees/s."""
        if not self._measured:
            return spindle.planned_next, spindle.speed_told
        count = min(max(self._cycles, 1), len(self._speeds))
        speed = sum(list(self._speeds)[-count:]) / count if count else spindle.velocity
        return spindle.angle + speed * self._period, speed

    def wanted(self) -> float:
        """In a thread, in front of the interpolator: the speed that the path is to have, mm/s."""
        spindle, path = self._spindle, self._path
        assert spindle is not None
        self._speeds.append(spindle.velocity)
        angle, speed = self._now(spindle)
        here = path.next_index
        if here >= path.queue.written or path.queue.kind(here) > _MOTION:
            return 0.0
        record = path.queue.record(here)
        turn = float(record["value"])
        if turn <= 0.0:
            return 0.0
        if turn != self._turn:  # another pitch: the path has to come to it
            self._turn, self._settles = turn, max(self._settles, _SETTLES)
        velocity = abs(speed) / turn
        if self._run_in > 0.0:
            self._run_in -= self._period
            return velocity
        phase = float(record["spindle_angle"]) + turn * path.inside
        self.off = (self._sense * (angle - self._zero) - phase) / turn - velocity * self._period
        self._watch(spindle, TURN / turn)
        return max(velocity + _GAIN * self.off, 0.0)

    def _watch(self, spindle: Spindle, pitch: float) -> None:
        """Being off is an error where the path has had the time to come to the spindle and is not about to end the thread."""
        if self._settles > 0.0:
            self._settles -= self._period
            return
        left = self._end - self._path.path_position
        velocity = self._path.path_velocity
        running_out = left <= 1.5 * self._brake_way(velocity) + 20.0 * velocity * self._period
        if abs(self.off) > _PATH_OFF * pitch and not running_out:
            self._settles = math.inf
            self._tell(-2, errors.THREAD_LOST, off=abs(self.off), spindle=spindle.axis.name)

    def lead(self, passed: Sequence[int]) -> None:
        """In tapping, behind the interpolator: where the spindle has to be behind this cycle. `passed`: records of this cycle."""
        spindle, path = self._spindle, self._path
        assert spindle is not None
        if not spindle.follows:  # its drive was switched off: the path must not go on alone
            self._tell(-2, errors.TAPPING_LOST, spindle=spindle.axis.name, off=0.0)
            self.role, self._spindle = SpindleRole.FREE, None
            return
        queue = path.queue
        for index in passed:
            if queue.kind(index) <= _MOTION:
                record = queue.record(index)
                if record["sense"] == _TAPPING:
                    self._turned = float(record["spindle_angle"] + record["value"] * record["length"])
        here = path.next_index
        if here < queue.written and queue.kind(here) <= _MOTION:
            record = queue.record(here)
            if record["sense"] == _TAPPING:
                self._turned = float(record["spindle_angle"] + record["value"] * path.inside)
        spindle.lead(self._zero + self._turned)
        off = abs(spindle.off_plan)
        if off > spindle.axis.following_error and self._told != -2:
            self._tell(-2, errors.TAPPING_LOST, spindle=spindle.axis.name, off=off)

    def _tell(self, index: int, entry: ErrorEntry, **values: object) -> None:
        """Once: the alarm ends the program."""
        self._told = index
        program, line = self._source
        self._report(Problem(entry, values, Place(self._queue.program_name(program), line)))
