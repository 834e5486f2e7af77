"""The `tandem` command as somebody at a shell sees it: how long it takes, and how much memory at its peak.

Every figure is of a whole process, from its start to its end, with kernels that are already compiled.
"""

from __future__ import annotations

import tempfile
from pathlib import Path

from bench import programs
from bench.figure import Figure
from bench.stopwatch import tandem

START_LIMIT = 2.0  # s
CHECK_LIMIT = 20.0  # s
MACHINING_LIMIT = 60.0  # s
GROWTH_LIMIT = 8.0  # MB; five times as many lines need no more memory
TEN_MINUTES = 460_000  # short moves
SHORT, LONG = 200_000, 1_000_000  # lines
FINE = 0.02  # mm, five moves in a cycle


def measure() -> list[Figure]:
    """Start, check, ten minutes of machining, memory."""
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        return [*_start(folder), *_check(folder), *_machining(folder), *_memory(folder)]


def _start(folder: Path) -> list[Figure]:
    program = programs.write(folder, "shortest.nc", programs.shortest())
    runs = [tandem("simulate", program) for _ in range(4)][1:]
    ideal = [tandem("simulate", "--ideal-axes", program) for _ in range(3)]
    checks = [tandem("check", program) for _ in range(3)]
    return [
        Figure("simulate, one block", min(run.seconds for run in runs), "s", START_LIMIT),
        Figure("simulate, one block, processor time", min(run.processor for run in runs), "s"),
        Figure("simulate --ideal-axes, one block", min(run.seconds for run in ideal), "s", START_LIMIT),
        Figure("check, one block", min(run.seconds for run in checks), "s"),
    ]


def _check(folder: Path) -> list[Figure]:
    program = programs.write(folder, "surface.nc", programs.surface(SHORT))
    runs = [tandem("check", program) for _ in range(2)]
    return [Figure(f"check, {SHORT} short moves", min(run.seconds for run in runs), "s", CHECK_LIMIT)]


def _machining(folder: Path) -> list[Figure]:
    program = programs.write(folder, "ten_minutes.nc", programs.surface(TEN_MINUTES))
    run = tandem("simulate", "--ideal-axes", program)
    machining = float(run.output.partition("time ")[2].partition(" s")[0])
    share = 600.0 / machining
    return [
        Figure("simulate --ideal-axes, 10 minutes of short moves", run.seconds * share, "s", MACHINING_LIMIT),
        Figure("simulate --ideal-axes, 10 minutes, processor time", run.processor * share, "s"),
    ]


def _memory(folder: Path) -> list[Figure]:
    figures = []
    short = programs.write(folder, "short.nc", programs.surface(SHORT, FINE))
    long = programs.write(folder, "long.nc", programs.surface(LONG, FINE))
    for command in (["check"], ["simulate", "--ideal-axes"]):
        name = " ".join(command)
        before, after = (tandem(*command, program).memory for program in (short, long))
        figures += [
            Figure(f"{name}, memory for {SHORT} lines", before, "MB"),
            Figure(f"{name}, memory for {LONG} lines", after, "MB", before + GROWTH_LIMIT),
        ]
    return figures
