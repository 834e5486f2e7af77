"""How long the real processes of the demo machine take from `tandem run` until the service says that it is ready.

What systemd waits for at a start: description read, all processes up, bus booted, first cycle; kernels are compiled. Beside
it the processor time and the memory of all processes: on a slow or busy computer these decide.
"""

from __future__ import annotations

import os
import resource
import socket
import tempfile
import time
from pathlib import Path

from bench.figure import Figure
from runtime.cli.preparing import compile_kernels
from tests.system.running_machine import MODULES, RunningMachine

REPEATS = 4
LIMIT = 60.0  # s


def measure() -> list[Figure]:
    """The best of several starts, after one that fills the caches of the host."""
    compile_kernels()
    starts = [_start(number) for number in range(REPEATS)][1:]
    seconds, processor, memory = (min(start[k] for start in starts) for k in range(3))
    return [
        Figure("start until ready, real processes", seconds, "s"),
        Figure("the same, processor time of all processes, with the end", processor, "s"),
        Figure("memory of the machine's processes together", memory, "MB"),
    ]


def _start(number: int) -> tuple[float, float, float]:
    """Seconds until ready; processor seconds of its whole life; MB (proportional set size) when it is ready."""
    with tempfile.TemporaryDirectory() as name, socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as manager:
        manager.bind(f"{name}/notify")
        manager.settimeout(LIMIT)
        running = RunningMachine(Path(name), 42_000 + os.getpid() % 1000 + number)
        before = resource.getrusage(resource.RUSAGE_CHILDREN)
        os.environ["NOTIFY_SOCKET"] = f"{name}/notify"
        begin = time.perf_counter()
        try:
            running.start()
            while b"READY=1" not in manager.recv(4096):
                pass
            seconds = time.perf_counter() - begin
            memory = sum(_memory(running.pid_of(process)) for process in MODULES)
        finally:
            del os.environ["NOTIFY_SOCKET"]
            running.stop()
        after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return seconds, after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime, memory


def _memory(pid: int) -> float:
    """MB; what several processes share counts in parts."""
    lines = Path(f"/proc/{pid}/smaps_rollup").read_text().splitlines()
    return next(int(line.split()[1]) for line in lines if line.startswith("Pss:")) / 1024.0
