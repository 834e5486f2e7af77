"""Who gives way when memory runs short: the PLC's process first, for it is user code, then the preparation; the cycle never.

    PLC program      takes no more than the machine description says: a MemoryError in its line, as any other error of the program
    whole host       the kernel ends the process with the highest score; the unit keeps service and cycle far below the others

Both ends are known faults: the cycle stops the path, and the process can be started again.
"""

from __future__ import annotations

import contextlib
import resource
from pathlib import Path
from typing import Final

PLC_SCORE: Final = 800  # of -1000 … 1000, proc_pid_oom_score_adj(5)
PREPARATION_SCORE: Final = 300


def give_way(score: int, process: Path = Path("/proc/self")) -> None:
    """Let the kernel end this process before those with a lower score. Everybody may raise his own."""
    with contextlib.suppress(OSError):  # a host without it ends the largest process, which this one then is
        (process / "oom_score_adj").write_text(str(score))


def limit_growth(megabytes: int) -> None:
    """This process may take so many MB of data more than it has now; Python raises MemoryError beyond."""
    lines = Path("/proc/self/status").read_text().splitlines()
    taken = next(int(line.split()[1]) for line in lines if line.startswith("VmData:")) * 1024
    limit = taken + megabytes * 1_000_000
    _, hard = resource.getrlimit(resource.RLIMIT_DATA)
    if hard == resource.RLIM_INFINITY or limit < hard:
        resource.setrlimit(resource.RLIMIT_DATA, (limit, hard))
