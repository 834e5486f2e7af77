"""The interpolator alone: one step in a cycle of 1 ms, the preparation always ahead of it."""

from __future__ import annotations

import tempfile
import time
from datetime import datetime
from pathlib import Path

import numpy as np

from bench import programs
from bench.figure import Figure
from bench.stopwatch import Times, as_in_the_cycle, distribution
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState
from runtime.cnc.preparation_link import PreparationLink, StartOrder
from runtime.config.loader import load_machine
from runtime.hli.layout import Hli
from runtime.kernels import warm_up
from runtime.scheduler.outside import RunningMachine
from runtime.scheduler.preparation import Preparation

LIMIT = 30.0  # µs
WINDOW = 2000  # cycles
WINDOWS = 10
LEAD = 1000


def measure() -> list[Figure]:
    """One element per cycle, five per cycle, and a program of arcs and stops."""
    warm_up()
    moves = 2 * (LEAD + WINDOWS * WINDOW)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        one = programs.write(folder, "one.nc", programs.surface(moves))
        five = programs.write(folder, "five.nc", programs.surface(5 * moves, step=0.02))
        plate = programs.write(folder, "plate.nc", programs.plate())
        return [
            *distribution("moves of 0.1 mm, F6000", _steps(one), LIMIT),
            *distribution("moves of 0.02 mm, F6000", _steps(five), LIMIT),
            *distribution("plate", _steps(plate), LIMIT),
        ]


def _steps(program: Path) -> list[Times]:
    """The time of `Interpolator.step`, ns, cycle by cycle; gates are opened as soon as the path knows them."""
    machine = load_machine(None)
    names = machine.channels[0].axes
    queue, link = MotionQueue(len(names)), PreparationLink(len(names))
    outside = RunningMachine(machine, Hli(), link, now=datetime.now)
    preparation = Preparation(machine, 0, queue, link, outside)
    limits = AxisLimits.of([machine.axes[machine.axis_index(name)] for name in names])
    path = Interpolator(queue, limits, machine.cycle.period, np.zeros(len(names)))
    link.start(StartOrder(str(program), np.zeros(len(names)), 0))
    clock = time.perf_counter_ns
    windows = []
    with as_in_the_cycle():
        for window in range(-1, WINDOWS):
            times = np.empty(WINDOW if window >= 0 else LEAD, dtype=np.int64)
            for k in range(len(times)):
                while preparation.poll() is PumpState.MORE:
                    pass
                begin = clock()
                path.step(override=1.0, feed_hold=False, single_block=False)
                times[k] = clock() - begin
                if path.gate >= 0:
                    path.open_gate()
            if window >= 0:
                windows.append(times)
    assert path.path_position > 0.0, "nothing moved"
    return windows
