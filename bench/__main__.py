"""Run the measurements, print them as a table, write them to out/bench.json.

    python -m bench                    all
    python -m bench machine command   these modules only

The exit code is 0 whatever was measured: a figure depends on the computer, so no test may depend on it. It is 1 if a
measurement fails.
"""

from __future__ import annotations

import importlib
import json
import os
import pkgutil
import platform
import sys
import traceback
from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path

from rich.console import Console
from rich.table import Table

import bench
from bench.figure import Figure

OUTPUT = Path("out/bench.json")
WIDTH = 110  # characters of the table where there is no terminal
_NOT_SUBJECTS = {"__main__", "figure", "process", "programs", "stopwatch"}


def subjects() -> list[str]:
    """Names of the modules that measure something."""
    return sorted(module.name for module in pkgutil.iter_modules(bench.__path__) if module.name not in _NOT_SUBJECTS)


def measure(names: Sequence[str], console: Console) -> tuple[dict[str, list[Figure]], list[str]]:
    """The figures of each subject, and the subjects that failed."""
    figures: dict[str, list[Figure]] = {}
    failed: list[str] = []
    for number, name in enumerate(names, 1):
        console.print(f"[{number}/{len(names)}] {name} …", markup=False)
        try:
            figures[name] = list(importlib.import_module(f"bench.{name}").measure())
        except Exception:
            failed.append(name)
            traceback.print_exc()
    return figures, failed


def table(figures: Mapping[str, Sequence[Figure]]) -> Table:
    """All figures, with their limits."""
    result = Table()
    for column in ("subject", "figure"):
        result.add_column(column)
    for column in ("value", "limit"):
        result.add_column(column, justify="right")
    result.add_column("unit")
    result.add_column("")
    for subject, rows in figures.items():
        for figure in rows:
            limit, mark = "", ""
            if figure.limit is not None:
                limit = ("≤ " if figure.better == "lower" else "≥ ") + f"{figure.limit:,.6g}"
                mark = "[green]kept[/]" if figure.good else "[red]missed[/]"
            result.add_row(subject, figure.name, f"{figure.value:,.6g}", limit, figure.unit, mark)
        result.add_section()
    return result


def report(figures: Mapping[str, Sequence[Figure]], load: Sequence[float]) -> dict[str, object]:
    """What is written: the computer (`load`: load average of a minute before and after), then the figures by subject."""
    return {
        "computer": {
            "processors": os.cpu_count(),
            "machine": platform.machine(),
            "kernel": platform.release(),
            "python": platform.python_version(),
            "load_average": load,
        },
        "figures": {
            subject: [asdict(figure) | {"good": figure.good} for figure in rows] for subject, rows in figures.items()
        },
    }


def main(arguments: Sequence[str]) -> int:
    """Measure the named subjects, all without names; returns the exit code."""
    console = Console()
    if console.width < WIDTH and not console.is_terminal:
        console = Console(width=WIDTH)
    known = subjects()
    if unknown := [name for name in arguments if name not in known]:
        console.print(f"no such measurement: {', '.join(unknown)}; there are {', '.join(known)}", markup=False)
        return 2
    load = [os.getloadavg()[0]]
    figures, failed = measure(arguments or known, console)
    load.append(os.getloadavg()[0])
    console.print(table(figures))
    console.print(f"{os.cpu_count()} processors, load average {load[0]:.1f} before, {load[1]:.1f} after")
    OUTPUT.parent.mkdir(parents=True, exist_ok=True)
    OUTPUT.write_text(json.dumps(report(figures, load), indent=2) + "\n", encoding="utf-8")
    console.print(f"written to {OUTPUT}", markup=False)
    if failed:
        console.print(f"failed: {', '.join(failed)}", markup=False)
    return int(bool(failed))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
