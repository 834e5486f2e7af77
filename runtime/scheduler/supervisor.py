"""The service process of `tandem run`: starts the others, watches them, writes the journal, keeps what must survive.

    service ──┬── cycle          real time: bus, interpolator, axes
              ├── plc            the user's program
              ├── preparation    one per channel
              └── drives         simulated, if asked for

Any process that ends leaves the axes at rest: the cycle stops the path when PLC or preparation are gone, the drives stop when
the cycle is gone (heartbeat), and every child stops when this process is gone. What happened stands in the journal and in the
alarm history of the HLI.
"""

from __future__ import annotations

import fcntl
import os
import time
from collections import deque
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import TextIO

from runtime.cnc.preparation_link import PreparationLink
from runtime.config.loader import DEMO_MACHINE
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Problem, Severity, TandemError
from runtime.diagnostics.events import Event, EventKind, EventRing
from runtime.diagnostics.memory import SHARED_MEMORY
from runtime.drives import DriveImage
from runtime.hli.errors import HliError
from runtime.hli.memory import HliMemory, refuse_living_owner
from runtime.monitoring.endpoint import MachineCollector, MetricsServer, start_metrics_server
from runtime.recorder.drain import Drain
from runtime.recorder.header import make_header
from runtime.recorder.ring import RecorderRing
from runtime.recorder.store import FOLDER, Segments
from runtime.scheduler import names
from runtime.scheduler.alarms import AlarmList
from runtime.scheduler.children import Child
from runtime.scheduler.clock import WallClockWatch
from runtime.scheduler.journal import Journal, write_event, write_problem
from runtime.scheduler.keeping import Keeper
from runtime.scheduler.notify import Notifier
from runtime.scheduler.retained import RetainedStore, state_directory
from runtime.scheduler.statistics import CycleStatistics

_STOP_LIMIT = 15.0  # s that the cycle gets to bring the machine to rest
_RETAIN_EVERY = 1.0  # s
_AGAIN = 1.0  # s between two attempts to start a process
_FROZEN_AFTER = 5.0  # s without a cycle; the drives have missed our heartbeat long before
_LONGEST_POLL = 0.2  # s that count between two looks: if this process stood still as well, the cycle is not to blame


@dataclass(frozen=True, slots=True)
class RunOptions:
    """How the machine is started."""

    machine_file: Path | None
    name: str = "tandem"
    dialect: str = ""  # "": as the description says
    simulated_drives: bool = False
    start_limit: float = 60.0  # s that each step of the start may take: bus booted, processes up, first cycle


class SupervisorError(TandemError):
    """The machine cannot be started."""


class Supervisor:
    """Start with `start`, call `poll` about ten times a second, end with `stop`."""

    def __init__(self, machine: Machine, options: RunOptions, journal: Journal) -> None:
        self.machine = machine
        self.options = options
        self.journal = journal
        self.memory: HliMemory | None = None
        self.on_event: Callable[[Event], None] | None = None
        self._again_at: dict[str, float] = {}  # processes that could not be started: when it is tried again
        self._wall_clock = WallClockWatch(time.time, time.monotonic)
        self._recorder_tells: deque[Problem] = deque(maxlen=64)  # of the recorder's thread, for the journal
        self._notifier = Notifier.from_environment(os.environ)
        state = state_directory(machine.state_directory, os.environ)
        self._store = RetainedStore(state)
        self._keeper = Keeper(machine, self._store)
        self._lock: TextIO | None = None
        self._wake = os.eventfd(0, os.EFD_NONBLOCK | os.EFD_SEMAPHORE)
        self._made = os.eventfd(0)  # the cycle raises it when the shared memories are there
        self._events: EventRing | None = None
        self.statistics: CycleStatistics | None = None
        self._link: PreparationLink | None = None
        self._metrics: MetricsServer | None = None
        self._collector: MachineCollector | None = None
        self._ring: RecorderRing | None = None
        self._drain: Drain | None = None
        self._retain_at = 0.0
        self._cycle_before = -1
        self._polled_at = 0.0
        self._standstill = 0.0  # s without a cycle
        self._cycle_end = ""  # why this process has ended the cycle
        self._plc_restarts = 0
        self._failed = False
        self._axis_names = [axis.name for axis in machine.axes]
        common = ["--name", options.name]
        if options.machine_file is not None:
            common += ["--machine", str(options.machine_file)]
        patience = ["--others-limit", str(options.start_limit / 2)]
        self.cycle = Child(
            "cycle",
            "runtime.scheduler.cycle_process",
            [*common, "--wake", str(self._wake), "--made", str(self._made), *patience],
            [self._wake, self._made],
        )
        self.preparation = Child(
            "preparation",
            "runtime.scheduler.preparation_process",
            [*common, "--dialect", options.dialect, "--begin", str(self._made)],
            [self._made],
        )
        machine_file = str(options.machine_file or DEMO_MACHINE)
        self.plc = Child(
            "PLC",
            "runtime.scheduler.plc_process",
            [
                "--machine",
                machine_file,
                "--hli",
                options.name,
                "--wake-fd",
                str(self._wake),
                "--begin",
                str(self._made),
            ],
            [self._wake, self._made],
        )
        encoders = str(state / "simulated-drives.json")
        self.drives = Child(
            "drives",
            "runtime.fieldbus.simulator",
            ["--machine", machine_file, "--state", encoders, "--exit-with-parent"],
        )

    @property
    def children(self) -> list[Child]:
        """In the order in which they are started."""
        chosen = [self.drives] if self.options.simulated_drives else []
        chosen += [self.cycle, self.preparation]
        return [*chosen, self.plc] if self.machine.plc.program else chosen

    # ------------------------------------------------------------------ start

    def start(self) -> None:
        """Start every process; returns when the cycle runs. Raises SupervisorError, HliError.

        All load what they need at the same time; preparation and PLC then wait for the memories that the cycle makes.
        """
        self._be_the_only_one()
        for child in self.children:
            child.start()
        self._wait_for_cycle(self._attach)
        self._start_recorder()
        self._wait_for_cycle(self._others_up)
        assert self.memory is not None
        self.memory.hli.platform.service_ready_w = True
        self._wait_for_cycle(lambda: bool(self.memory and self.memory.hli.head.running_r))
        self._start_metrics()
        self._notifier.ready(f"{self.machine.name} runs")

    def _be_the_only_one(self) -> None:
        """Refuse to start beside a runtime of this name or on its state, before anything disturbs its bus."""
        refuse_living_owner(self.options.name)
        folder = self._store.directory
        try:
            folder.mkdir(parents=True, exist_ok=True)
            self._lock = (folder / "lock").open("w")
        except OSError:  # told as soon as something is to be retained
            return
        try:
            fcntl.flock(self._lock, fcntl.LOCK_EX | fcntl.LOCK_NB)
        except BlockingIOError:
            raise SupervisorError(alarms.STATE_IN_USE, folder=folder) from None

    def _wait_for_cycle(self, condition: Callable[[], bool]) -> None:
        end = time.monotonic() + self.options.start_limit
        while not condition():
            if not self.cycle.running:
                self._drain_events()
                raise SupervisorError(alarms.CYCLE_NOT_STARTED, reason=self.cycle.end())
            if time.monotonic() > end:
                raise SupervisorError(
                    alarms.CYCLE_NOT_STARTED, reason=f"not ready after {self.options.start_limit:.0f} s"
                )
            time.sleep(0.02)

    def _attach(self) -> bool:
        """Attach to the shared memories, once the cycle process has made them: the HLI is made first, the others follow."""
        if self.memory is None:
            try:
                memory = HliMemory.attach(self.options.name)
            except HliError:
                return False
            if memory.hli.head.owner_pid_r != self.cycle.pid:
                memory.close()
                return False
            self.memory = memory
        name = self.options.name
        try:
            self._events = self._events or EventRing(names.events(name), create=False)
            self.statistics = self.statistics or CycleStatistics(names.statistics(name), create=False)
            n_axes = len(self.machine.channels[0].axes)
            self._link = self._link or PreparationLink(n_axes, names.link(name, 0), create=False)
            if self.machine.recorder.enabled:
                self._ring = self._ring or RecorderRing(names.recorder(name), create=False)
        except (FileNotFoundError, ValueError):
            return False
        return True

    def _start_recorder(self) -> None:
        """From here on the ring goes to the disk. What has no real drives' feedback yet: the controller is built with zeros."""
        if self._ring is None:
            return
        settings, plc = self.machine.recorder, "process" if self.machine.plc.program else "none"
        header = make_header(
            self.machine, self.options.machine_file, DriveImage(len(self.machine.axes)), plc, real=True
        )
        folder = self._store.directory / FOLDER
        segments = Segments(folder, int(time.time()), header, settings.size * 1_000_000, settings.minutes * 60.0)
        self._drain = Drain(
            self._ring,
            segments,
            self._recorder_tells.append,
            period=self.machine.cycle.period,
            keyframe_every=settings.keyframe_every,
            kept=settings.saved,
        )
        self._drain.start()

    def _others_up(self) -> bool:
        """Preparation and PLC have loaded everything, or have failed to."""
        assert self.memory is not None
        assert self._link is not None
        plc = not self.machine.plc.program or not self.plc.running or bool(self.memory.hli.platform.plc_present_w)
        return plc and (self._link.ready or not self.preparation.running)

    def _start_metrics(self) -> None:
        settings = self.machine.metrics
        if not settings.enabled or self.memory is None or self.statistics is None:
            return
        figures = self._drain.figures if self._drain is not None else None
        self._collector = MachineCollector(self.memory.hli, self.statistics, figures)
        try:
            self._metrics = start_metrics_server(settings.host, settings.port, self._collector)
        except TandemError as error:  # the machine runs without being watched, and says so
            write_problem(self.journal, error.problem)

    @property
    def metrics_port(self) -> int:
        """The port in use, 0 without metrics."""
        return self._metrics.port if self._metrics else 0

    # ------------------------------------------------------------------ watching

    def poll(self) -> bool:
        """Look after everything once; FALSE when the machine is down and there is nothing left to watch."""
        self._drain_events()
        if not self.cycle.running:
            self._cycle_ended()
            return False
        self._watch_preparation()
        self._watch_plc()
        self._watch_drives()
        if by := self._wall_clock.step():
            write_problem(self.journal, Problem(system.CLOCK_STEPPED, {"seconds": by}))
        now = time.monotonic()
        assert self.memory is not None
        if now >= self._retain_at or self._keeper.urgent(self.memory.hli):
            self._retain_at = now + _RETAIN_EVERY
            self.retain()
        cycle = self.memory.hli.head.cycle_r
        if cycle != self._cycle_before:  # the watchdog is fed by the cycle, not by this process
            self._cycle_before = cycle
            self._standstill = 0.0
            self._notifier.feed_watchdog()
        else:
            self._standstill += min(now - self._polled_at, _LONGEST_POLL)
            if self._standstill > _FROZEN_AFTER:
                self._end_frozen_cycle()
        self._polled_at = now
        return True

    def _end_frozen_cycle(self) -> None:
        """It cannot brake any more, the drives have done that. Its end is told by the next look, and systemd starts anew.

        The watchdog of systemd would do it too, a little later, but nobody would say why.
        """
        self._cycle_end = f"no cycle for {_FROZEN_AFTER:g} s, killed"
        assert self.cycle.process is not None
        self.cycle.process.kill()
        self.cycle.process.wait()

    def _drain_events(self) -> None:
        while self._recorder_tells:
            write_problem(self.journal, self._recorder_tells.popleft())
        if self._events is None:
            return
        for event in self._events.take():
            error = event.kind is EventKind.ERROR
            if error and event.value >= Severity.ERROR and self._drain is not None:
                self._drain.alarm(event.number)
            write_event(self.journal, event, self._axis_names, Severity(int(event.value)) if error else Severity.ERROR)
            if self._collector is not None:
                self._collector.count(event)
            if self.on_event is not None:
                self.on_event(event)

    def _cycle_ended(self) -> None:
        """The cycle is gone: the drives stop by themselves; tell why, in the journal and in what is left of the HLI."""
        reason = self._cycle_end or self.cycle.end()
        if reason == "exit code 0":
            return
        self._failed = True
        problem = Problem(alarms.CYCLE_LOST, {"reason": reason})
        if self.memory is None or self._events is None:
            write_problem(self.journal, problem)
            return
        AlarmList(self.memory.hli, self._events, time.time_ns).add(problem)
        self.memory.hli.head.running_r = False
        self._drain_events()
        self.retain()

    def _watch_preparation(self) -> None:
        if self.preparation.running:
            return
        if self.preparation.process is not None:
            self._tell_lost(self.preparation)
            self.preparation.process = None
        self._start_again(self.preparation)

    def _watch_plc(self) -> None:
        assert self.memory is not None
        if not self.machine.plc.program:
            return
        if not self.plc.running and self.plc.process is not None:
            self._tell_lost(self.plc)
            self.plc.process = None
        wanted = self.memory.hli.platform.plc_restart_request_r
        if wanted != self._plc_restarts:
            if self.plc.process is not None:  # it hangs
                self.plc.process.kill()
                self.plc.process.wait()
                self.plc.process = None
            if self._start_again(self.plc):
                self._plc_restarts = wanted

    def _watch_drives(self) -> None:
        if self.drives.process is not None and not self.drives.running:
            self._tell_lost(self.drives)
            self.drives.process = None  # like drives without power: they come back with the next start

    def _start_again(self, child: Child) -> bool:
        """A host without memory or processes to spare refuses: told once, tried again every second, and the machine goes on."""
        now = time.monotonic()
        if now < self._again_at.get(child.name, 0.0):
            return False
        try:
            child.start()
        except OSError as error:
            if child.name not in self._again_at:
                values = {"process": child.name, "reason": error.strerror or str(error)}
                write_problem(self.journal, Problem(system.PROCESS_NOT_STARTED, values))
            self._again_at[child.name] = now + _AGAIN
            return False
        self._again_at.pop(child.name, None)
        return True

    def _tell_lost(self, child: Child) -> None:
        """Hand the loss to the cycle, which stops the path and raises the alarm."""
        assert self.memory is not None
        platform = self.memory.hli.platform
        platform.process_lost_text_w = f"{child.name}: {child.end()}".encode()
        platform.process_lost_w += 1

    def retain(self) -> None:
        """Write what must survive: positions and alarm history."""
        if self.memory is not None:
            self._keeper.keep(self.memory.hli)

    # ------------------------------------------------------------------ stop

    def rest(self) -> None:
        """Bring the machine to rest: the cycle brakes, switches the drives off, and ends."""
        self._notifier.stopping()
        if self.cycle.running:
            self.cycle.terminate(_STOP_LIMIT)
        self._drain_events()
        self.retain()

    def stop(self) -> int:
        """Bring the machine to rest and end every process; the exit code of the service."""
        self.rest()
        for child in reversed(self.children):
            child.terminate(2.0)
        if self._metrics is not None:
            self._metrics.close()
        if self._drain is not None:
            self._drain.close()
            self._drain_events()
        for resource in (self._events, self.statistics, self._link):
            if resource is not None:
                resource.close()
        if self._ring is not None:
            self._ring.close(unlink=True)
        if self.memory is not None:
            self._remove_leftovers(self.memory)
            self.memory.close()
        if self._lock is not None:
            self._lock.close()
        os.close(self._wake)
        os.close(self._made)
        code = self.cycle.process.returncode if self.cycle.process else 1
        return 1 if self._failed or code else 0

    def _remove_leftovers(self, memory: HliMemory) -> None:
        """A cycle that was killed has removed nothing. Its HLI stays: it tells the cause until the next start."""
        if memory.owner_alive:
            return
        name = self.options.name
        for left in (names.events(name), names.statistics(name), names.queue(name, 0), names.link(name, 0)):
            (SHARED_MEMORY / left).unlink(missing_ok=True)
