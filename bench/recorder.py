"""What the flight recorder costs the cycle, and how fast a recording is replayed.

The demo machine on its virtual bus, with and without the border, in turns; the difference of the best medians of the
thread's own processor time is the cost. The replay is of what was recorded meanwhile.
"""

from __future__ import annotations

import tempfile
import time
from pathlib import Path

import numpy as np

from bench import programs
from bench.figure import Figure
from bench.stopwatch import as_in_the_cycle
from runtime.config.loader import load_machine
from runtime.kernels import warm_up
from runtime.recorder.file import RecordingFile
from runtime.recorder.state import Capture
from runtime.scheduler.replay import Replay
from runtime.scheduler.simulation import START_LIMIT, Simulation

WINDOW = 400  # cycles
WINDOWS = 5
LEAD = 800  # cycles until the cutting is under way
SHARE = 5.0  # % of the cycle
SPEED = 5.0  # times real time


def measure() -> list[Figure]:
    """Cost per cycle in µs and in % of the period; bytes per cycle; speed of the replay."""
    warm_up()
    machine = load_machine(None)
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        plate = programs.write(folder, "plate.nc", programs.plate())
        recording = folder / "recording"
        plain, recorded = Simulation(machine), Simulation(machine, record=recording)
        with as_in_the_cycle():
            for simulation in (plain, recorded):
                simulation.run_until(simulation.ready, START_LIMIT)
                simulation.start(plate)
                _work(simulation, LEAD)
            pairs = [(_work(plain, WINDOW), _work(recorded, WINDOW)) for _ in range(WINDOWS)]
        keyframe = min(_keyframe(recorded) for _ in range(5))
        plain.close()
        recorded.close()
        cycles = recorded.controller.cycle_number
        size = recording.stat().st_size
        begin = time.process_time()
        with RecordingFile(recording) as file:
            result = Replay(file, machine).run()
        took = time.process_time() - begin
        assert result.same, str(result.difference)
        assert result.cycles == cycles
    without, with_it = (
        min(float(np.median(window)) for window in windows) / 1000.0 for windows in zip(*pairs, strict=True)
    )
    period = machine.cycle.period * 1e6
    cost = with_it - without
    return [
        Figure("cost of recording, median cycle", cost, "µs"),
        Figure("the same, share of the cycle", 100.0 * cost / period, "%", SHARE),
        Figure("taking a keyframe, at standstill", keyframe, "µs"),
        Figure("bytes per cycle on the disk", size / cycles, "B"),
        Figure("replay, processor time", result.seconds / took, "× real time", SPEED, "higher"),
    ]


def _keyframe(simulation: Simulation) -> float:
    """The time of noting the state of the cycle's objects, µs."""
    assert simulation.recording is not None
    border = simulation.recording.border
    begin = time.thread_time_ns()
    Capture(border.root, border.outside())
    return (time.thread_time_ns() - begin) / 1000.0


def _work(simulation: Simulation, count: int) -> np.ndarray[tuple[int], np.dtype[np.int64]]:
    """The time of `Controller.cycle` with all that the border does in it, ns, cycle by cycle."""
    clock = time.thread_time_ns
    times = np.empty(count, dtype=np.int64)
    for k in range(count):
        simulation.before_cycle()
        begin = clock()
        simulation.controller.cycle(simulation.time)
        times[k] = clock() - begin
        simulation.after_cycle()
    return times
