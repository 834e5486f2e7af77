"""A program of ten million lines: its check takes no more memory than one of a million, and the machine starts at once.

The files stand in the page cache when they are read: how fast a disk is, is not asked here.
"""

from __future__ import annotations

import shutil
import tempfile
import time
from datetime import datetime
from pathlib import Path

import numpy as np

from bench import programs
from bench.figure import Figure
from bench.stopwatch import tandem
from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.cnc.path_preparation import PumpState
from runtime.cnc.preparation_link import PreparationLink, StartOrder
from runtime.config.loader import load_machine
from runtime.config.machine import Machine
from runtime.hli.memory import HliMemory
from runtime.kernels import warm_up
from runtime.scheduler.outside import RunningMachine
from runtime.scheduler.preparation import Preparation

SHORT, LONG = 1_000_000, 10_000_000  # lines
BYTES_PER_LINE = 32  # at most, of these programs
GROWTH_LIMIT = 8.0  # MB
FIRST_MOTION_LIMIT = 0.2  # s
RATE_LIMIT = 1_000_000.0  # lines/s
STARTS = 3


def measure() -> list[Figure]:
    """Check and start of the two programs; nothing if the temporary folder has no room for them."""
    warm_up()
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        room, needed = shutil.disk_usage(folder).free, 2 * (SHORT + LONG) * BYTES_PER_LINE
        if room < needed:
            print(f"left out: {folder} has room for {room / 1e6:.0f} MB, {needed / 1e6:.0f} MB are needed")
            return []
        short = programs.write_long_surface(folder, "short.nc", SHORT)
        long = programs.write_long_surface(folder, "long.nc", LONG)
        machine = load_machine(None)
        tandem("check", short)
        before, after = tandem("check", short), tandem("check", long)
        _first_motion(short, machine)
        first = min(_first_motion(long, machine) for _ in range(STARTS))
        return [
            Figure(f"size of {LONG} lines", long.stat().st_size / 1e6, "MB"),
            Figure(f"check, memory for {SHORT} lines", before.memory, "MB"),
            Figure(f"check, memory for {LONG} lines", after.memory, "MB", before.memory + GROWTH_LIMIT),
            Figure(f"check of {SHORT} lines", before.seconds, "s"),
            Figure(f"check of {LONG} lines", after.seconds, "s"),
            Figure("check, whole process", LONG / after.seconds, "lines/s", RATE_LIMIT, better="higher"),
            Figure(f"first motion of {LONG} lines", first, "s", FIRST_MOTION_LIMIT),
        ]


def _first_motion(program: Path, machine: Machine) -> float:
    """From the order to start until the first element of the path stands in the queue, s."""
    queue = MotionQueue(len(machine.channels[0].axes))
    link = PreparationLink(queue.n_axes)
    outside = RunningMachine(machine, HliMemory.private().hli, link, datetime.now)
    preparation = Preparation(machine, 0, queue, link, outside)
    begin = time.perf_counter()
    link.start(StartOrder(str(program), np.zeros(queue.n_axes), 0))
    seen = 0
    while True:
        state = preparation.poll()
        while seen < queue.written:
            if queue.kind(seen) <= RecordKind.POLYNOMIAL:
                seconds = time.perf_counter() - begin
                link.abort()
                preparation.poll()
                return seconds
            seen += 1
        if state is PumpState.FINISHED:
            raise RuntimeError(link.problem.text or f"{program} has no motion")
