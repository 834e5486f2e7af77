"""Kernels ready for use: a word about it only at the first start, when they are compiled.

The word goes to standard error and, where a service manager waits for the start, to its status line.
"""

from __future__ import annotations

import os
import sys

from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Problem
from runtime.kernel_cache import CACHE
from runtime.scheduler.notify import Notifier

_LONGEST_STEP = 120.0  # s that one group of kernels may take on a slow computer


def prepare_kernels() -> None:
    """Load the kernels of all modules that are imported; the first time compile every one, with progress on standard error."""
    compile_kernels()
    from runtime.kernels import warm_up

    warm_up()


def compile_kernels() -> None:
    """The first time compile every kernel, with progress on standard error; later only look that they are there.

    What it takes for that is imported then only: a start that finds everything compiled is there sooner.
    """
    if CACHE.warm:
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    import runtime.scheduler.all_kernels  # noqa: F401 - registers the warm-ups
    from runtime.kernels import warm_up

    if not CACHE.lasting:
        print(
            Problem(system.KERNELS_NOT_KEPT, {"places": ", ".join(map(str, CACHE.refused))}).explained(),
            file=sys.stderr,
        )
    console = Console(stderr=True)
    if not console.is_terminal:  # there the bar is seen when it is full
        console.print("compiling kernels, as at every first start of a version: about a minute")
    columns = (TextColumn("compiling kernels"), BarColumn(), TextColumn("{task.description}"), TimeElapsedColumn())
    with Progress(*columns, console=console) as bar:
        task = bar.add_task("", total=1)

        notifier = Notifier.from_environment(os.environ)

        def tell(what: str, done: int, total: int) -> None:
            bar.update(task, description=what, completed=done, total=total)
            notifier.starting(
                f"first start of this version: compiling kernels, {done} of {total} groups", _LONGEST_STEP
            )

        warm_up(tell, everything=True)
        bar.update(task, description="ready", completed=1, total=1)
        notifier.close()
