"""The cycle process: fieldbus, interpolator, axes, owner of the HLI; `python -m runtime.scheduler.cycle_process`.

Order of its life: kernels warm ─ shared memories made, the others told ─ bus booted ─ real-time privileges ─ cycles ─ on SIGTERM
the axes brake on the path, the drives are switched off, the process ends.
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import os
import signal
import sys
import time
import traceback
from dataclasses import asdict
from pathlib import Path
from types import FrameType

from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.preparation_link import PreparationLink
from runtime.config import load_machine
from runtime.config.machine import AxisType, Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.errors import ErrorEntry, Problem, TandemError
from runtime.diagnostics.events import EventRing
from runtime.drives import DriveSystem
from runtime.fieldbus.bus import open_buses
from runtime.fieldbus.several import drive_system
from runtime.hli.memory import HliMemory
from runtime.kernels import warm_up
from runtime.recorder.border import Border
from runtime.recorder.ring import RecorderRing
from runtime.scheduler import names
from runtime.scheduler.children import die_with_parent, parent_gone
from runtime.scheduler.clock import RealTimeClock
from runtime.scheduler.controller import Controller
from runtime.scheduler.keeping import interruption_in, retained_of
from runtime.scheduler.plc_link import PlcProcess
from runtime.scheduler.realtime import prepare_realtime
from runtime.scheduler.recorded import Seam, put_border, told_alarm, watch
from runtime.scheduler.retained import Retained, RetainedError, RetainedStore, state_directory
from runtime.scheduler.statistics import CycleStatistics

_OTHERS_LIMIT = 30.0  # s until the other processes must be up; longer where the start may take longer
_STOP_LIMIT = 10.0  # s that axes and spindles get to come to rest
_COMPARE_AFTER = 20  # cycles until every drive has told where it is
_MOVED = 1.0  # mm or degrees
_BOOT_PAUSE = 0.0002  # s between two looks at the bus while it boots


class CycleProcess:
    """Everything of the machine that lives in the real-time process."""

    def __init__(self, machine: Machine, name: str, wake_descriptor: int, others_limit: float = _OTHERS_LIMIT) -> None:
        self.machine = machine
        self._others_limit = others_limit
        n_axes = len(machine.channels[0].axes)
        self._buses = open_buses(machine)  # first: what refuses to start leaves no memory behind
        self.memory = HliMemory.create(name, permissions=machine.hli.permissions)
        self.events = EventRing(names.events(name))
        self.queue = MotionQueue(n_axes, names.queue(name, 0))
        self.link = PreparationLink(n_axes, names.link(name, 0))
        self.statistics = CycleStatistics(names.statistics(name))
        self.drives: DriveSystem = drive_system(
            machine, self._buses, now=time.monotonic, idle=lambda: time.sleep(_BOOT_PAUSE)
        )

        def partner(memory: HliMemory) -> PlcProcess:
            return PlcProcess(wake_descriptor, memory.hli)

        with_plc = bool(machine.plc.program)
        plc = partner(self.memory) if with_plc else None
        seam = Seam(self.drives, self.memory, self.queue, self.link, plc, time.time_ns)
        self._ring: RecorderRing | None = None
        self._border: Border | None = None
        if machine.recorder.enabled:
            self._ring = RecorderRing(names.recorder(name))
            seam, self._border = put_border(machine, seam, self._ring, partner if with_plc else None)
        self.controller = Controller(
            machine, seam.drives, seam.memory, self.events, seam.queue, seam.link, seam.plc, wall_clock=seam.wall_clock
        )
        if self._border is not None:
            watch(self._border, self.controller, machine.recorder.keyframes)
        self._stop_reason = ""
        self._told_reason: ErrorEntry | None = None
        self._parent = os.getppid()
        self._kept = Retained()
        self._store = RetainedStore(state_directory(machine.state_directory, os.environ))
        self._positions_before: dict[str, float] = {}

    def ask_to_stop(self, number: int, _frame: FrameType | None) -> None:
        """Signal handler: the cycles go on until everything is at rest."""
        self._stop_reason = signal.Signals(number).name

    def _alarm(self, problem: Problem, axis: int = -1) -> None:
        """An alarm that this process raises between two cycles."""
        if self._border is not None:
            self._border.call("alarm", **told_alarm(problem, axis))
        self.controller.alarm(problem, axis)

    def restore(self) -> None:
        """The alarm history of earlier runs, and where the axes stood."""
        retained, problems = self._store.load()
        if self._border is not None:
            self._border.call("restore", alarms=[asdict(alarm) for alarm in retained.alarms])
        self.controller.alarms.restore(retained.alarms)
        self._kept = retained
        if self._border is not None:
            self._border.call("references", references=dict(retained.references))
        self.controller.references.restore(retained.references)
        self.controller.channel.search.point = interruption_in(retained, len(self.machine.channels[0].axes))
        self._positions_before = dict(retained.positions)
        for problem in problems:
            self._alarm(problem)

    def _compare_positions(self) -> None:
        """An axis that stands elsewhere than at the end of the last run was moved, or its encoder has lost its place."""
        for i, axis in enumerate(self.machine.axes):
            before = self._positions_before.get(axis.name)
            actual = float(self.drives.image.actual_position[i])
            if axis.type is not AxisType.SPINDLE and before is not None and abs(actual - before) > _MOVED:
                values = {"axis": axis.name, "before": before, "now": actual}
                self._alarm(Problem(alarms.AXIS_MOVED, values), i)

    def run(self) -> int:
        """Boot the bus, then cycle until asked to stop; the exit code."""
        self._wait_for_the_others()
        self.drives.start()
        machine = self.machine
        for problem in prepare_realtime(machine.cycle.priority, machine.cycle.cpu):
            self._alarm(problem)
        clock = RealTimeClock(machine.cycle.period)
        self.memory.hli.head.running_r = True
        platform = self.memory.hli.platform
        controller, statistics, border = self.controller, self.statistics, self._border
        give_up_at = 0.0
        while not controller.stopped:
            lateness = clock.wait()
            begin = clock.now_ns()
            now = begin * 1e-9
            try:
                if border is not None:
                    border.begin(now)
                controller.cycle(now)
            except Exception:
                return self._fail(clock)
            work = clock.now_ns() - begin
            statistics.work.add(work)
            statistics.lateness.add(lateness)
            platform.work_time_ns_r = work
            platform.lateness_ns_r = lateness
            platform.overruns_r = clock.overruns
            if clock.cycle == _COMPARE_AFTER:
                self._compare_positions()
            if self._stop_reason and not give_up_at:
                give_up_at = now + _STOP_LIMIT
                self._tell_why_stopped()
                if border is not None:
                    border.call("stop")
                controller.stop()
            if give_up_at and now > give_up_at:
                break
        self.drives.stop()
        if self._orphaned:
            self._tell_why_stopped()
            self._keep_the_cause()
        return int(self._orphaned)

    @property
    def _orphaned(self) -> bool:
        return parent_gone(self._parent)

    def _tell_why_stopped(self) -> None:
        """SIGTERM comes from the service process, or from the kernel because that process has died.

        The kernel's comes with the first thread of the service that dies, which need not be the main one; so this is called
        once more when the machine stands.
        """
        entry = alarms.SERVICE_LOST if self._orphaned else alarms.STOP_ORDERED
        if entry is not self._told_reason:
            self._told_reason = entry
            self._alarm(Problem(entry, {"reason": self._stop_reason}))

    def _keep_the_cause(self) -> None:
        """Nobody is left to write the journal and to keep positions and alarms; called when the cycle is over."""
        print(Problem(alarms.SERVICE_LOST).explained(), file=sys.stderr)
        with contextlib.suppress(RetainedError):
            self._store.save(retained_of(self.machine, self.memory.hli, self._kept))

    def _wait_for_the_others(self) -> None:
        """Processes that start take the processor for some time: not while nodes watch our heartbeat."""
        end = time.monotonic() + self._others_limit
        while not self.memory.hli.platform.service_ready_w and not self._stop_reason and time.monotonic() < end:
            time.sleep(0.01)

    def _fail(self, clock: RealTimeClock) -> int:
        """An error of the runtime itself: drives brake by their own ramp; then end, so that the service starts anew."""
        text = traceback.format_exc()
        print(text, file=sys.stderr)
        controller = self.controller
        with contextlib.suppress(Exception):
            controller.alarm(Problem(alarms.CYCLE_FAILED, {"reason": text.strip().splitlines()[-1]}))
        image = self.drives.image
        image.quick_stop[:] = True
        for _ in range(round(2.0 / self.machine.cycle.period)):
            clock.wait()
            self.drives.read()
            image.target_position[:] = image.actual_position
            self.drives.write()
        self.drives.stop()
        return 1

    def close(self, *, clean: bool) -> None:
        """Leave bus and shared memories; after a failure HLI and events stay for whoever looks for the cause."""
        self.memory.hli.head.running_r = False
        for bus in self._buses.values():
            bus.shutdown()
        self.events.close(unlink=clean)
        self.queue.close(unlink=True)
        self.link.close(unlink=True)
        self.statistics.close(unlink=clean)
        if self._ring is not None:
            self._ring.close()  # the service empties it, and removes it
        self.memory.close(keep=not clean)


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machine", type=Path)
    parser.add_argument("--name", required=True)
    parser.add_argument(
        "--others-limit", type=float, default=_OTHERS_LIMIT, help="s that the other processes get to start"
    )
    parser.add_argument("--wake", type=int, default=-1, help="eventfd that wakes the PLC")
    parser.add_argument("--made", type=int, default=-1, help="eventfd to raise when the shared memories are there")
    arguments = parser.parse_args()
    die_with_parent()
    try:
        machine = load_machine(arguments.machine)
        warm_up()
        process = CycleProcess(machine, arguments.name, arguments.wake, arguments.others_limit)
    except TandemError as error:
        for problem in error.problems:
            print(problem.explained(), file=sys.stderr)
        return 1
    signal.signal(signal.SIGTERM, process.ask_to_stop)
    try:
        process.restore()
        if arguments.made >= 0:
            os.eventfd_write(arguments.made, 1)
        code = process.run()
    except TandemError as error:
        for problem in error.problems:
            process._alarm(problem)
        process.drives.stop()
        code = 1
    process.close(clean=code == 0)
    del process
    gc.unfreeze()  # objects of extension modules that are alive at the end would be told as leaks
    gc.collect()
    return code


if __name__ == "__main__":
    sys.exit(main())
