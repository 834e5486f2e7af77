"""The interpolator of a channel: from the motion queue to one commanded position per cycle.

    interpolator.step(override=1.0, feed_hold=False, single_block=False)
    axes.target[:] = interpolator.position
    for index in interpolator.passed: ...put out functions, tell block ends...
    if interpolator.gate >= 0 and acknowledged: interpolator.open_gate()

Everything that must react at once (override, feed hold, gates, abort) is an argument of the next step; there is no
other state than where the path is and how fast it goes.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import cycle as c
from runtime.cnc.interpolator import prediction
from runtime.cnc.interpolator.lookahead import EXTERNAL_FEED, ORDERS, OVERRIDE, RAPID_OVERRIDE, TURNING
from runtime.cnc.interpolator.set_point_filter import SetPointFilter
from runtime.cnc.motion_queue import MAX_AXES, GateReason, MotionQueue, RecordKind
from runtime.config.fir_filter import FirFilter

Floats = npt.NDArray[np.float64]

GREATEST_OVERRIDE = 2.0


class Track:
    """A path of its own for an interpolator: the queue, and where it is in it."""

    def __init__(self, queue: MotionQueue) -> None:
        self.queue = queue
        self.floats = np.zeros(c.FLOAT_STATE)
        self.whole = np.zeros(c.INT_STATE, dtype=np.int64)
        self.passed = np.zeros(c.PASSED, dtype=np.int64)
        self.plans = c.scratch()[2]
        self.shown = (-1, 0, -1, -1)
        self.way = (0.0, 1.0)


class Interpolator:
    """Follows the path in `queue`, one `period` (s) per step, from machine `position` (n_axes,).

    The limits of the axes are in the records of the queue (`path_preparation`); `axes` has to be what they were made
    with. `position` and `velocity` (n_axes,) are arrays of this object that each step overwrites: copy what is to be
    kept. The axes are sent to `set_point` (n_axes,), which a filter (`filters` of the axes) keeps some cycles behind the path:
    then nothing is passed, no gate is reached and the path does not stand before the axes are there.
    """

    SCRATCH = ("_real", "_whole", "_prediction")  # written before they are read in every step: no state

    def __init__(
        self,
        queue: MotionQueue,
        axes: AxisLimits,
        period: float,
        position: Floats,
        filters: Sequence[FirFilter | None] = (),
    ) -> None:
        if axes.n != queue.n_axes or len(position) != queue.n_axes:
            raise ValueError(f"queue has {queue.n_axes} axes, limits {axes.n}, position {len(position)}")
        self.queue = queue
        self.axes = axes
        self.period = period
        self._n = queue.n_axes
        self._q = np.zeros(MAX_AXES)
        self._dq = np.zeros(MAX_AXES)
        self.position: Floats = self._q[: self._n]
        self.velocity: Floats = self._dq[: self._n]
        self._f = np.zeros(c.FLOAT_STATE)
        self._i = np.zeros(c.INT_STATE, dtype=np.int64)
        self._passed = np.zeros(c.PASSED, dtype=np.int64)
        self._real, self._whole, self._plans = c.scratch()
        self._prediction = prediction.scratch()
        self._orders = np.zeros(ORDERS)  # of the last step: OVERRIDE, RAPID_OVERRIDE, EXTERNAL_FEED, TURNING
        self._orders[:TURNING] = 1.0, 1.0, -1.0
        self._single_block = False
        self._way = (0.0, 1.0)  # where `path_position` counts from, and in which sense
        self._filter = SetPointFilter(filters or (None,) * self._n, period)
        self.restart(position)

    def restart(self, position: Floats, way: float = 0.0) -> None:
        """Begin anew at `position` with what the queue holds from its `read` on; path position `way`, mm."""
        self._f[:] = 0.0
        self._f[c.PATH] = way
        self._way = (0.0, 1.0)
        self._i[:] = 0
        self._dq[:] = 0.0
        self._q[: self._n] = position
        read = self.queue.read
        for place in (c.CUR, c.REPORTED, c.HORIZON_ALL, c.HORIZON_ZONES, c.SCANNED, c.SHOWN):
            self._i[place] = read
        self._i[c.OPENED] = self._i[c.BLOCKS_RELEASED] = read - 1
        for place in (c.SINGLE_GATE_AT, c.NEXT_GATE, c.GATE_INDEX, c.SHOWN):
            self._i[place] = -1
        self._i[c.STANDSTILL] = 1
        self._plans[:] = 0.0
        self._i[c.ROWS_KEPT] = 1
        self._shown = (-1, 0, -1, -1)
        self._settle()

    def step(
        self,
        *,
        override: float,
        feed_hold: bool,
        single_block: bool,
        rapid_override: float | None = None,
        external_feed: float = -1.0,
    ) -> None:
        """One cycle. `override` 1.0 is 100 %, taken within 0…200 %; rapid moves have their own if it is given.

        `external_feed`, mm/s, takes the place of the programmed feed; negative: there is none.
        """
        orders = self._orders
        orders[OVERRIDE] = min(max(override, 0.0), GREATEST_OVERRIDE)
        orders[RAPID_OVERRIDE] = orders[OVERRIDE] if rapid_override is None else max(rapid_override, 0.0)
        orders[EXTERNAL_FEED] = external_feed
        self._single_block = bool(single_block)
        if self._filter.on:
            self._i[c.TELL] = self._filter.record
        c.cycle(
            self.queue.records,
            self.queue.polynomials,
            self.queue.counters,
            self._n,
            self.period,
            orders,
            bool(feed_hold),
            bool(single_block),
            self._f,
            self._i,
            self._q,
            self._dq,
            self._passed,
            self._real,
            self._whole,
            self._plans,
        )
        if self._filter.on:
            self._filter.step(self._q, self._f[c.PATH], self._i[c.CUR])

    def turns(self, spindle: int, speed: float) -> None:
        """What a spindle of the channel turns with, rev/min, for feeds per revolution in the next step."""
        self._orders[TURNING + spindle] = speed

    def exchange(self, track: Track) -> None:
        """Go over to another path at standstill; `track` keeps this one, for going back. The axes stay where they are."""
        self.queue, track.queue = track.queue, self.queue
        self._f, track.floats = track.floats, self._f
        self._i, track.whole = track.whole, self._i
        self._passed, track.passed = track.passed, self._passed
        self._plans, track.plans = track.plans, self._plans
        self._shown, track.shown = track.shown, self._shown
        self._way, track.way = track.way, self._way
        self._dq[:] = 0.0
        self._settle()

    def count_from(self, way: float, sense: float) -> None:
        """What `path_position` is now, mm, and whether it grows (1) or falls (-1)."""
        self._way = (way - sense * float(self._f[c.PATH]), sense)

    def stand_inside(self, way: float) -> None:
        """The axes stand `way` mm into the record that comes next; at standstill."""
        self._f[c.PATH] += way - self._f[c.S_IN]
        self._f[c.S_IN] = way
        self._settle()

    @property
    def inside(self) -> float:
        """How far the path is in the record that is executed, mm."""
        return float(self._f[c.S_IN])

    def resume_at(self, position: Floats) -> None:
        """The axes were moved while the path stood: it goes on from `position` (n_axes,), where the next element begins."""
        self._q[: self._n] = position
        self._settle()

    # ------------------------------------------------------------------ where the axes are sent to

    @property
    def set_point(self) -> Floats:
        """Where the axes are sent to in this cycle, (n_axes,)."""
        return self._filter.position if self._filter.on else self.position

    @property
    def trail(self) -> float:
        """How far the filter keeps the axes behind the path, mm."""
        return self._filter.trail

    def begin_filter(self) -> None:
        """A program begins: the filter is what the machine description says."""
        self._filter.begin()
        self._settle()

    def change_filter(self, halves: Sequence[int], share: float, cut_off: float, quality: float) -> None:
        """At standstill: filters of these halves (n_axes,), cycles, from here on (`SetPointFilter.set`)."""
        self._filter.set(halves, share, cut_off, quality)
        self._settle()

    def _settle(self) -> None:
        """The path stands, and so do the axes."""
        self._i[c.TELL] = -1
        if self._filter.on:
            self._filter.settle(self.position, float(self._f[c.PATH]), int(self._i[c.CUR]))

    # ------------------------------------------------------------------ the path

    @property
    def path_velocity(self) -> float:
        """mm/s along the path."""
        return float(self._f[c.V])

    @property
    def path_position(self) -> float:
        """Way since `restart`, mm; falls while the path is driven backward."""
        return self._way[0] + self._way[1] * float(self._f[c.PATH])

    @property
    def remaining(self) -> float:
        """Way to the end of the present element, mm."""
        return max(float(self._f[c.LENGTH] - self._f[c.S_IN]), 0.0)

    @property
    def covered(self) -> float:
        """Share of the present element that lies behind, 0…1."""
        length = float(self._f[c.LENGTH])
        return min(float(self._f[c.S_IN]) / length, 1.0) if length > 0.0 else 1.0

    def time_until(self, way: float, before: int = -1, at_most: float = np.inf) -> float:
        """Seconds until the axes are `way` mm further than the path, with the override as it is; infinite if that cannot be
        foreseen.

        It cannot if a closed gate stands in front of record `before`, or in front of the place. Below 0 it is when the
        path was there, as far back as the beginning of the plan that is driven, at least this cycle. More than `at_most`
        may be told as infinite.
        """
        f, i = self._f, self._i
        plan, rows = self._plans[c.KEPT], int(i[c.ROWS_KEPT])
        if self._filter.on and way <= 0.0:
            return self._filter.seconds_to(way)
        if way <= 0.0:
            return float(prediction.time_on_plan(plan, rows, f[c.PLAN_TIME], way)) if way < 0.0 else 0.0
        return self._filter.delay * self.period + float(
            prediction.time_until(
                self.queue.records, self.queue.written, i[c.CUR], f[c.S_IN], f[c.V], way, before, at_most, self._orders,
                i[c.OPENED], self._single_block, i[c.BLOCKS_RELEASED], plan, rows, f[c.PLAN_TIME], f[c.PLANNED],
                self._prediction,
            )
        )  # fmt: skip

    # ------------------------------------------------------------------ the record being executed

    @property
    def index(self) -> int:
        """Absolute queue index of the record being executed, or of the last one executed; -1 before the first."""
        return int(self._i[c.SHOWN])

    def _source(self) -> tuple[int, int, int, int]:
        index = int(self._i[c.SHOWN])
        if index != self._shown[0] and index >= self.queue.read:
            record = self.queue.record(index)
            self._shown = (index, int(record["line"]), int(record["n"]), int(record["program"]))
        return self._shown

    @property
    def line(self) -> int:
        """Source line of the record being executed, 0 before the first."""
        return self._source()[1]

    @property
    def n(self) -> int:
        """Block number of the record being executed, -1 if there is none."""
        return self._source()[2]

    @property
    def program(self) -> int:
        """Program id of the record being executed (`MotionQueue.program_name`), -1 before the first."""
        return self._source()[3]

    @property
    def passed(self) -> Sequence[int]:
        """Absolute indices of the functions, element ends and block ends passed in this step, in order.

        At most 256; what was passed beyond that is told in the next steps. Their records stay valid until the next
        step.
        """
        return self._passed[: self._i[c.PASSED_COUNT]].tolist()  # type: ignore[no-any-return]

    @property
    def reported(self) -> int:
        """Absolute index of the first record that was not yet told in `passed`."""
        return int(self._i[c.REPORTED])

    @property
    def all_told(self) -> bool:
        """Everything that the path has passed was told in `passed`."""
        return bool(self._i[c.REPORTED] >= self._i[c.CUR])

    # ------------------------------------------------------------------ gates

    @property
    def gate(self) -> int:
        """Absolute index of the next closed gate in what is known, -1 if there is none.

        In single block also the next block end, or the segment of a polyline, at which the path can still stop.
        """
        return int(self._i[c.GATE_INDEX])

    @property
    def at_gate(self) -> bool:
        """The path stands at `gate`, exactly."""
        return bool(self._i[c.AT_GATE]) and self._filter.empty

    def open_gate(self) -> None:
        """Lift the present `gate`, long before it is reached or when standing at it. Takes effect in the next step.

        A block of which the end has a gate of its own, as the path may stand there already, ends once in single block.
        """
        gate = int(self._i[c.GATE_INDEX])
        if gate < 0:
            return
        if gate == self._i[c.SINGLE_GATE_AT]:
            self._i[c.BLOCKS_RELEASED] = gate
            if gate + 1 < self.queue.written and self._ends_step(gate, gate + 1):
                self._i[c.OPENED] = max(int(self._i[c.OPENED]), gate + 1)
        else:
            self._i[c.OPENED] = gate
        self._i[c.GATE_INDEX] = -1
        self._i[c.AT_GATE] = 0

    def _ends_step(self, block_end: int, index: int) -> bool:
        """Whether the record behind the end of a block is the gate at the end of the same one."""
        ended, gate = self.queue.record(block_end), self.queue.record(index)
        step = gate["kind"] == RecordKind.GATE and gate["reason"] == GateReason.STEP
        return bool(step and ended["line"] == gate["line"] and ended["program"] == gate["program"])

    def open_steps(self, gate: int) -> None:
        """Open the ends of steps behind `gate`, which was just opened, up to the next gate of another reason."""
        last = c.last_step(self.queue.records, self.queue.written, gate + 1)
        self._i[c.OPENED] = max(int(self._i[c.OPENED]), last)

    # ------------------------------------------------------------------ state

    @property
    def standstill(self) -> bool:
        """Neither the path nor the axes moved in this step."""
        return bool(self._i[c.STANDSTILL]) and self._filter.empty

    @property
    def starved(self) -> bool:
        """Standing or braking because nothing more is known, in the middle of a program."""
        return bool(self._i[c.STARVED])

    @property
    def next_index(self) -> int:
        """Absolute queue index of the record that is executed, or is the next one."""
        return int(self._i[c.CUR])

    @property
    def nothing_known(self) -> bool:
        """Everything in the queue has been executed, or there never was anything."""
        return int(self._i[c.CUR]) >= self.queue.written

    @property
    def apart(self) -> bool:
        """The next element doesn't start where the axes stand: nothing moves until `restart`."""
        return bool(self._i[c.APART]) and self._filter.empty

    @property
    def overflows(self) -> int:
        """Cycles that kept their plan as the new one needed more pieces than foreseen; for diagnosis, 0 is right."""
        return int(self._f[c.OVERFLOWS])

    @property
    def refused(self) -> int:
        """Cycles in which nothing new was proven safe and the kept plan went on; for diagnosis, a few are right."""
        return int(self._i[c.REFUSED])

    def abort(self) -> None:
        """Brake on the path to standstill and stay there until `restart`."""
        self._i[c.ABORTING] = 1

    @property
    def aborted(self) -> bool:
        """`abort` was called and the path stands, and so do the axes."""
        return bool(self._i[c.ABORTING]) and float(self._f[c.V]) == 0.0 and self._filter.empty
