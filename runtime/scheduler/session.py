"""A running machine as seen by who started it: orders a program, tells the state, keeps what is needed for the summary."""

from __future__ import annotations

import time
from collections import Counter, deque
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.config.machine import AxisType, Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.errors import Problem, Severity
from runtime.diagnostics.events import Event, EventKind
from runtime.hli.errors import HliError
from runtime.hli.layout import Hli, State, StopCondition
from runtime.hli.operator import Operator, OrderRefusedError
from runtime.hli.units import LENGTH, RAPID, SPEED
from runtime.scheduler.journal import Journal
from runtime.scheduler.supervisor import RunOptions, Supervisor

_MOST_POINTS = 360_000  # two hours at 50 per second
_READY_LIMIT = 30.0  # s
_FUNCTIONS = {EventKind.M_OUT: "M", EventKind.H_OUT: "H", EventKind.T_OUT: "T", EventKind.SPINDLE: "spindle M"}


@dataclass(frozen=True, slots=True)
class RunResult:
    """What a program did on the running machine."""

    outcome: str
    good: bool
    time: float  # s
    path_length: float  # mm
    positions: Mapping[str, float]
    functions: Mapping[str, int]
    cycles: int
    overruns: int
    plc_overruns: int
    work_median_us: float
    work_p99_us: float
    alarms: list[str]


class Session:
    """`start`, then `poll` in a loop, then `stop`."""

    def __init__(self, machine: Machine, options: RunOptions, journal: Journal) -> None:
        self.machine = machine
        self.supervisor = Supervisor(machine, options, journal)
        self.supervisor.on_event = self._on_event
        self._program: Path | None = None
        self._ordered = False
        self._was_active = False
        self.program_done = False
        self._started_at = 0.0
        self._ended_at = 0.0
        self._deadline = 0.0
        self._path_length = 0.0
        self._positions: dict[str, float] = {}
        self._problems: list[str] = []
        self._functions: Counter[str] = Counter()
        self._points: deque[tuple[float, ...]] = deque(maxlen=_MOST_POINTS)  # the newest, for the picture
        self._figures = (0, 0, 0)
        self._quantiles = (0.0, 0.0)

    def start(self) -> None:
        """Start the processes. Raises SupervisorError."""
        self.supervisor.start()

    def start_program(self, program: Path) -> None:
        """Start it as soon as drives and PLC are ready."""
        self._program = program
        self._deadline = time.monotonic() + _READY_LIMIT

    @property
    def _hli(self) -> Hli:
        assert self.supervisor.memory is not None
        return self.supervisor.memory.hli

    # ------------------------------------------------------------------ watching

    def poll(self) -> bool:
        """Look after the machine once; FALSE when it is down."""
        if not self.supervisor.poll():
            return False
        hli = self._hli
        self._figures = (hli.head.cycle_r, hli.platform.overruns_r, hli.platform.plc_overruns_r)
        state = hli.channels[0].control.mode_and_state.state_r
        if self._program is not None and not self._ordered:
            self._order_when_ready(hli)
        elif self._ordered:
            self._follow(hli, state)
        return True

    def _order_when_ready(self, hli: Hli) -> None:
        enabled = all(hli.axes[i].status.ready_for_control_loop_on_r for i in range(hli.head.axes_r))
        plc = hli.platform.plc_running_r or not self.machine.plc.program
        if enabled and plc:
            assert self.supervisor.memory is not None
            self._ordered = True
            self._started_at = time.monotonic()
            try:
                Operator(self.supervisor.memory, time.sleep).start(str(self._program))
            except (OrderRefusedError, HliError) as error:
                self._end(hli, str(error.problem))
        elif time.monotonic() > self._deadline:
            self._end(hli, str(Problem(alarms.NOT_READY, {"seconds": _READY_LIMIT})))

    def _follow(self, hli: Hli, state: int) -> None:
        active = state in (State.ACTIVE, State.HOLD)
        if active:
            self._was_active = True
            # at the end the path begins anew at 0, perhaps before the state has changed
            self._path_length = max(self._path_length, hli.channels[0].status.path_position_r * LENGTH)
            self._sample(hli)
        if (self._was_active and not active) or state == State.ERROR:
            self._end(hli)

    def _end(self, hli: Hli, problem: str = "") -> None:
        """The program has ended, or cannot begin because of a `problem`."""
        if problem:
            self._problems.append(problem)
        self._ended_at = time.monotonic()
        self._positions = self._axis_positions(hli)
        if self.supervisor.statistics is not None:
            work = self.supervisor.statistics.work
            self._quantiles = (work.quantile(0.5) * 1e6, work.quantile(0.99) * 1e6)
        self.program_done = True

    def _axis_positions(self, hli: Hli) -> dict[str, float]:
        return {
            axis.name: hli.axes[i].status.actual_position_r * LENGTH
            for i, axis in enumerate(self.machine.axes)
            if axis.type is not AxisType.SPINDLE
        }

    def _sample(self, hli: Hli) -> None:
        channel = hli.channels[0]
        axes = [
            hli.axes[channel.axis_index_r[k]].status.actual_position_r * LENGTH for k in range(channel.axis_count_r)
        ]
        status = channel.status
        rapid = status.command_feed_r in (0, RAPID)
        self._points.append((hli.head.time_ns_r * 1e-9, *axes, status.active_feed_r * SPEED, rapid))

    def _on_event(self, event: Event) -> None:
        if event.kind in _FUNCTIONS:
            self._functions[f"{_FUNCTIONS[event.kind]}{event.number}"] += 1
        elif event.kind is EventKind.ERROR and event.value >= Severity.ERROR:
            self._problems.append(f"{event.number}: {event.text}")

    # ------------------------------------------------------------------ telling

    def state_line(self) -> str:
        """One line: time, state, place, positions, spindle."""
        hli = self._hli
        channel = hli.channels[0]
        state = State(channel.control.mode_and_state.state_r).name
        parts = [f"{hli.head.time_ns_r * 1e-9:7.1f} s", f"{state:<8}", f"line {channel.status.line_r:<5}"]
        parts += [f"{name} {value:9.3f}" for name, value in self._axis_positions(hli).items()]
        for i, axis in enumerate(self.machine.axes):
            if axis.type is AxisType.SPINDLE:
                parts.append(f"{axis.name} {hli.axes[i].spindle.actual_speed_r * SPEED / 6.0:7.0f} rev/min")
        parts.append(f"F {channel.status.active_feed_r * SPEED * 60.0:6.0f}")
        stop = StopCondition(channel.status.stop_condition_r)
        if stop:
            parts.append(str(stop.name).replace("|", " ").lower())
        return "  ".join(parts)

    @property
    def samples(self) -> dict[str, npt.NDArray[np.generic]]:
        """The path that the axes took: `t` s, one array per axis, `v_path` mm/s."""
        names = self.machine.channels[0].axes
        rows = self._rows()
        columns: dict[str, npt.NDArray[np.generic]] = {"t": rows[:, 0]}
        for k, name in enumerate(names):
            columns[name] = rows[:, 1 + k]
        columns["v_path"] = rows[:, -2]
        return columns

    @property
    def rapid(self) -> npt.NDArray[np.bool_]:
        """Which samples are of rapid moves, or of no move at all."""
        flags: npt.NDArray[np.bool_] = self._rows()[:, -1] != 0.0
        return flags

    def _rows(self) -> npt.NDArray[np.float64]:
        width = len(self.machine.channels[0].axes) + 3
        return np.array(self._points, dtype=float).reshape(len(self._points), width)

    def stop(self) -> int:
        """End everything; the exit code."""
        if self._ordered and not self.program_done:
            self.supervisor.rest()
            self._end(self._hli)
            self.program_done = False  # it was stopped on its way
        return self.supervisor.stop()

    def result(self) -> RunResult:
        """What the program did; after `stop`."""
        done = self._was_active and self.program_done and not self._problems
        outcome = "done" if done else ("ended with an error" if self._problems else "stopped")
        return RunResult(
            outcome=outcome,
            good=done,
            time=max(self._ended_at - self._started_at, 0.0),
            path_length=self._path_length,
            positions=self._positions,
            functions=dict(self._functions),
            cycles=self._figures[0],
            overruns=self._figures[1],
            plc_overruns=self._figures[2],
            work_median_us=self._quantiles[0],
            work_p99_us=self._quantiles[1],
            alarms=self._problems,
        )
