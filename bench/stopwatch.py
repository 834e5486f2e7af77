"""How the measurements measure, on a computer that does other things as well.

A program that is interrupted looks slow. So a short call is measured in windows of many calls, and the window with the
lowest 99th percentile tells what the code can do; the same percentile over all windows stands beside it.
"""

from __future__ import annotations

import gc
import json
import subprocess
import sys
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import numpy.typing as npt

from bench.figure import Figure
from runtime.scheduler.realtime import freeze_garbage_collector

Times = npt.NDArray[np.int64]


def distribution(name: str, windows: Sequence[Times], limit: float | None = None) -> list[Figure]:
    """Median, 99 %, 99.9 % and maximum, µs, of the best of `windows` (each (n,) ns); `limit` is of the 99 %."""
    best = min(windows, key=lambda window: float(np.percentile(window, 99)))
    median, p99, p999, highest = (np.percentile(best, (50, 99, 99.9, 100)) / 1000.0).tolist()
    everything = float(np.percentile(np.concatenate(windows), 99) / 1000.0)
    return [
        Figure(f"{name}, median", median, "µs"),
        Figure(f"{name}, 99 %", p99, "µs", limit),
        Figure(f"{name}, 99.9 %", p999, "µs"),
        Figure(f"{name}, maximum", highest, "µs"),
        Figure(f"{name}, 99 % of all windows", everything, "µs"),
    ]


def each(call: Callable[[], object], calls: int = 1000, windows: int = 5) -> list[Times]:
    """The time of every single call, ns."""
    clock = time.perf_counter_ns
    measured = []
    for _ in range(windows):
        times = np.empty(calls, dtype=np.int64)
        for k in range(calls):
            begin = clock()
            call()
            times[k] = clock() - begin
        measured.append(times)
    return measured


def seconds(call: Callable[[], object], repeat: int = 3) -> float:
    """The best of some repetitions."""
    times = []
    for _ in range(repeat):
        begin = time.perf_counter()
        call()
        times.append(time.perf_counter() - begin)
    return min(times)


@contextmanager
def as_in_the_cycle() -> Iterator[None]:
    """Without garbage collection, as the process of the cycle runs."""
    freeze_garbage_collector()
    try:
        yield
    finally:
        gc.unfreeze()
        gc.enable()


@dataclass(frozen=True, slots=True)
class CommandRun:
    """What a process needed: `seconds` by the clock, `processor` seconds of all its threads, `memory` MB at its peak."""

    seconds: float
    processor: float
    memory: float
    output: str


def tandem(*arguments: str | Path) -> CommandRun:
    """Run the `tandem` command. Raises subprocess.CalledProcessError with what it said if it fails."""
    command = [sys.executable, "-m", "runtime.cli.main", *map(str, arguments)]
    measured = subprocess.run([sys.executable, "-m", "bench.process", *command], stdout=subprocess.PIPE, check=True)
    needed = json.loads(measured.stdout)
    if needed["code"]:
        raise subprocess.CalledProcessError(needed["code"], command, needed["output"])
    return CommandRun(needed["seconds"], needed["processor"], needed["memory"], needed["output"])
