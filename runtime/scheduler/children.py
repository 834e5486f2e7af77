"""The processes of a running machine: started as modules, tied to their parent, ended in order.

A child gets SIGTERM from the kernel when its parent dies (PR_SET_PDEATHSIG), so that killing the service process ends the
machine under control. It has a session of its own: Ctrl-C, a closed terminal and signals to the group reach the parent only,
which decides.
"""

from __future__ import annotations

import ctypes
import os
import select
import signal
import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path

_PR_SET_PDEATHSIG = 1
_LOOK_EVERY_MS = 100  # whether one is to stop, while one waits


def die_with_parent(by: signal.Signals = signal.SIGTERM) -> None:
    """Called by a child at its start: signal `by` when the parent dies, Ctrl-C ignored."""
    libc = ctypes.CDLL(None, use_errno=True)
    libc.prctl(_PR_SET_PDEATHSIG, by, 0, 0, 0)
    signal.signal(signal.SIGINT, signal.SIG_IGN)


def parent_gone(parent: int) -> bool:
    """Whether the process that was our parent is dead, or on its way: the kernel gives its children to another one only when its
    last thread has ended, which takes a large process some tenths of a second."""
    if os.getppid() != parent:
        return True
    try:
        stat = Path(f"/proc/{parent}/stat").read_text()
    except OSError:
        return True
    return stat.rpartition(")")[2].split()[0] in ("Z", "X")


def wait_until_raised(descriptor: int, stopping: Callable[[], bool]) -> None:
    """Until somebody has raised the eventfd, which stays raised, or `stopping` says so. A negative descriptor: not at all."""
    waiter = select.poll()
    if descriptor >= 0:
        waiter.register(descriptor, select.POLLIN)
        while not waiter.poll(_LOOK_EVERY_MS) and not stopping():
            pass


@dataclass(slots=True)
class Child:
    """A process of the machine: its name for messages, the module it runs, its arguments, inherited descriptors."""

    name: str
    module: str
    arguments: Sequence[str]
    descriptors: Sequence[int] = ()
    process: subprocess.Popen[bytes] | None = None

    def start(self) -> None:
        self.process = subprocess.Popen(
            [sys.executable, "-m", self.module, *self.arguments],
            pass_fds=tuple(self.descriptors),
            stdin=subprocess.DEVNULL,
            stdout=sys.stderr.fileno(),
            env={**os.environ, "PYTHONUNBUFFERED": "1"},
            start_new_session=True,
        )

    @property
    def pid(self) -> int:
        return self.process.pid if self.process else 0

    @property
    def running(self) -> bool:
        return self.process is not None and self.process.poll() is None

    def end(self) -> str:
        """How it ended, in words."""
        code = self.process.poll() if self.process else None
        if code is None:
            return "still running"
        if code < 0:
            try:
                return f"killed by {signal.Signals(-code).name}"
            except ValueError:
                return f"killed by signal {-code}"
        return f"exit code {code}"

    def terminate(self, timeout: float) -> None:
        """SIGTERM, then SIGKILL after `timeout` seconds."""
        if self.process is None or self.process.poll() is not None:
            return
        self.process.terminate()
        try:
            self.process.wait(timeout)
        except subprocess.TimeoutExpired:
            self.process.kill()
            self.process.wait()
