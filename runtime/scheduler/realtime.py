"""What a cycle process needs from the host: priority, locked memory, its own processor, timers without slack.

Each step that the host refuses is one plain line (a warning with what to do), never an error: the machine runs on a
developer's laptop too, with more jitter. `tandem doctor` tells the same beforehand.
"""

from __future__ import annotations

import ctypes
import gc
import os
import resource
from collections.abc import Callable, Sequence
from pathlib import Path

from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Problem

CPU_DMA_LATENCY = Path("/dev/cpu_dma_latency")

_MCL_CURRENT, _MCL_FUTURE = 1, 2
_M_TRIM_THRESHOLD, _M_MMAP_MAX = -1, -4
_PR_SET_TIMERSLACK = 29
_CAP_IPC_LOCK = 14


class RefusedError(Exception):
    """The host does not do it; the text is the reason."""


def prepare_realtime(priority: int, cpu: int | None = None) -> list[Problem]:
    """Make the calling process a real-time process; returns a warning for each thing that the host refuses.

    `priority` for SCHED_FIFO, 1 to 98. `cpu`: the processor to be pinned to, None for none. Called once per process,
    after everything is allocated and compiled and before the first cycle; holds until the process ends.
    The priority is that of the calling thread; SCHED_RESET_ON_FORK keeps it from later threads and children.
    """
    steps: Sequence[tuple[Callable[[], None], Callable[[str], Problem]]] = (
        (
            lambda: pin(cpu),
            lambda reason: Problem(
                system.NO_AFFINITY, {"cpu": cpu, "reason": reason, "available": _ranges(os.sched_getaffinity(0))}
            ),
        ),
        (set_timer_slack, lambda reason: Problem(system.NO_TIMER_SLACK, {"reason": reason})),
        (forbid_deep_sleep, lambda reason: Problem(system.NO_CPU_LATENCY, {"reason": reason})),
        (lock_memory, lambda reason: Problem(system.NO_MEMORY_LOCK, {"reason": reason})),
        (
            lambda: set_priority(priority),
            lambda reason: Problem(system.NO_PRIORITY, {"priority": priority, "reason": reason}),
        ),
    )
    problems = []
    for step, told in steps:
        try:
            step()
        except RefusedError as refused:
            problems.append(told(str(refused)))
    freeze_garbage_collector()
    return problems


def freeze_garbage_collector() -> None:
    """No collection in the cycle: what exists is never looked at again, what comes later goes by reference count."""
    gc.collect()
    gc.freeze()
    gc.disable()


def set_priority(priority: int) -> None:
    """SCHED_FIFO. Raises RefusedError."""
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO | os.SCHED_RESET_ON_FORK, os.sched_param(priority))
    except (OSError, ValueError) as error:
        limit, _ = resource.getrlimit(resource.RLIMIT_RTPRIO)
        raise RefusedError(f"{_reason(error)}; the limit of this user is {limit}") from None


def lock_memory() -> None:
    """Keep every page in memory, those to come as well, and keep freed memory for the next use. Raises RefusedError.

    With a finite limit the lock might succeed now and let an allocation fail later, in the cycle; so it is refused.
    """
    expect_memory_lock()
    soft, hard = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if soft != hard:
        resource.setrlimit(resource.RLIMIT_MEMLOCK, (hard, hard))
    libc = ctypes.CDLL(None, use_errno=True)
    libc.mallopt(_M_TRIM_THRESHOLD, -1)  # freed memory stays with the process
    libc.mallopt(_M_MMAP_MAX, 0)  # large arrays too
    if libc.mlockall(_MCL_CURRENT | _MCL_FUTURE) != 0:
        raise RefusedError(os.strerror(ctypes.get_errno()))


def expect_memory_lock() -> None:
    """Whether this process may lock all of its memory. Raises RefusedError if not."""
    _, hard = resource.getrlimit(resource.RLIMIT_MEMLOCK)
    if hard != resource.RLIM_INFINITY and not _may_lock_any_memory():
        raise RefusedError(f"the limit of this user is {hard // 1024} KiB, unlimited is needed")


def pin(cpu: int | None) -> None:
    """Run on one processor only. Raises RefusedError."""
    if cpu is None:
        return
    try:
        os.sched_setaffinity(0, {cpu})
    except (OSError, ValueError, OverflowError) as error:
        raise RefusedError(_reason(error)) from None


def set_timer_slack(nanoseconds: int = 1) -> None:
    """Timers of a normal process may fire 50 µs late; those of real-time processes never do. Raises RefusedError."""
    libc = ctypes.CDLL(None, use_errno=True)
    if libc.prctl(_PR_SET_TIMERSLACK, ctypes.c_ulong(nanoseconds), 0, 0, 0) != 0:
        raise RefusedError(os.strerror(ctypes.get_errno()))


def forbid_deep_sleep(device: Path = CPU_DMA_LATENCY) -> None:
    """Ask for 0 µs of wake-up latency of the processors. Raises RefusedError.

    The request holds as long as the file is open, so the descriptor stays open until the process ends.
    """
    try:
        descriptor = os.open(device, os.O_WRONLY | os.O_CLOEXEC)
        os.write(descriptor, (0).to_bytes(4, "little"))
    except OSError as error:
        raise RefusedError(_reason(error)) from None


def _may_lock_any_memory() -> bool:
    """Whether the process has the capability that lifts the limit (capabilities(7))."""
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith("CapEff:"):
            return bool(int(line.split()[1], 16) >> _CAP_IPC_LOCK & 1)
    return False


def _reason(error: Exception) -> str:
    return (error.strerror or str(error)) if isinstance(error, OSError) else str(error)


def _ranges(cpus: set[int]) -> str:
    return ", ".join(map(str, sorted(cpus)))
