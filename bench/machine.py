"""The work time of a whole cycle of the demo machine: fieldbus read and write, PLC, channel, axes, HLI.

Three axes, spindle and I/O node as CANopen nodes on python-can's virtual bus, the PLC program in the same process every
fourth cycle. The simulated nodes work between the cycles, outside of what is measured.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from bench import programs
from bench.figure import Figure
from bench.stopwatch import Times, as_in_the_cycle, distribution
from runtime.config.loader import load_machine
from runtime.kernels import warm_up
from runtime.scheduler.simulation import START_LIMIT, Simulation

LIMIT = 500.0  # µs
WINDOW = 2000  # cycles
WINDOWS = 10
LEAD = 3000  # cycles until the cutting is under way


def measure() -> list[Figure]:
    """A program of arcs and functions, one of short moves, and the same without a bus."""
    warm_up()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plate = programs.write(folder, "plate.nc", programs.plate())
        surface = programs.write(folder, "surface.nc", programs.surface(2 * (LEAD + WINDOWS * WINDOW)))
        return [
            *distribution("plate, CANopen", _work(plate, ideal=False), LIMIT),
            *distribution("short moves, CANopen", _work(surface, ideal=False), LIMIT),
            *distribution("short moves, ideal axes", _work(surface, ideal=True)),
        ]


def _work(program: Path, *, ideal: bool) -> list[Times]:
    """The time of `Controller.cycle`, ns, cycle by cycle while `program` runs."""
    clock = time.perf_counter_ns
    windows = []
    with Simulation(load_machine(None), ideal_axes=ideal) as simulation, as_in_the_cycle():
        simulation.run_until(simulation.ready, START_LIMIT)
        simulation.start(program)
        for _ in range(LEAD):
            simulation.cycle()
        for _ in range(WINDOWS):
            times = np.empty(WINDOW, dtype=np.int64)
            for k in range(WINDOW):
                simulation.before_cycle()
                begin = clock()
                simulation.controller.cycle(simulation.time)
                times[k] = clock() - begin
                simulation.after_cycle()
            windows.append(times)
        assert simulation.controller.channel.active, "the program was too short"
    return windows
