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
from runtime.recorder.record import KEYFRAME
from runtime.scheduler.replay import Replay
from runtime.scheduler.simulation import START_LIMIT, Simulation

WINDOW = 400  # cycles
WINDOWS = 5
LEAD = 800  # cycles until the cutting is under way
SHARE = 5.0  # % of the cycle
KEYFRAMES = 100
SLACK = 300.0  # µs that a running cycle has to spare for a keyframe
KINDS = (("median", 50, None), ("99 %", 99, SLACK))
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
            taken, others = _keyframes(recorded)
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
        *(
            Figure(f"taking a keyframe, {name}", float(np.percentile(taken, share)), "µs", limit)
            for name, share, limit in KINDS
        ),
        Figure("the cycles around it, 99 %", float(np.percentile(others, 99)), "µs"),
        Figure("bytes per cycle on the disk", size / cycles, "B"),
        Figure("replay, processor time", result.seconds / took, "× real time", SPEED, "higher"),
    ]


def _keyframes(simulation: Simulation) -> tuple[list[float], list[float]]:
    """In motion: what the cycle of a keyframe has to do for it, and what those before and behind it have, µs."""
    assert simulation.recording is not None
    border = simulation.recording.border
    begin, clock = border.begin, time.thread_time_ns
    taken: list[float] = []
    others: list[float] = []

    def timed(time: float) -> None:
        before = clock()
        begin(time)
        took = (clock() - before) / 1000.0
        (taken if border.out[4] & KEYFRAME else others).append(took)

    border.begin = timed  # type: ignore[method-assign]
    for _ in range(KEYFRAMES):
        border.keyframe_wanted = True
        while border.busy:
            simulation.cycle()
    border.begin = begin  # type: ignore[method-assign]
    return taken, others


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
