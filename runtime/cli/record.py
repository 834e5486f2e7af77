"""`tandem record`: what the flight recorder has kept of a machine, running or not."""

from __future__ import annotations

import os
import time
from datetime import UTC, datetime
from pathlib import Path
from typing import Annotated

import typer

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False, no_args_is_help=True)
_Config = Annotated[
    Path | None, typer.Option("--config", "-c", help="Machine description; default: the built-in demo machine.")
]
_WRITTEN = 0.6  # s after which what happens now is on the disk


@app.callback()
def _group() -> None:
    """Save what the flight recorder of a machine has kept."""


def _folder(config: Path | None) -> Path:
    from runtime.config import load_machine
    from runtime.recorder.store import FOLDER
    from runtime.scheduler.retained import state_directory

    return state_directory(load_machine(config).state_directory, os.environ) / FOLDER


@app.command()
def save(
    file: Annotated[
        Path | None, typer.Argument(help="Recording to be written; default: recording-TIME.tandem.")
    ] = None,
    config: _Config = None,
    run: Annotated[int | None, typer.Option(help="Of another run than the last one: its number in `list`.")] = None,
) -> None:
    """Write what is kept of a run, up to now, into one file for `tandem replay`."""
    from runtime.diagnostics.catalogue import recorder as errors
    from runtime.diagnostics.errors import Place
    from runtime.recorder import store
    from runtime.recorder.file import RecordingError

    folder = _folder(config)
    time.sleep(_WRITTEN)
    found = store.runs(folder)
    chosen = run if run is not None else max(found, default=0)
    if chosen not in found:
        raise RecordingError(errors.NOT_RECORDED, Place(str(folder)), folder=folder)
    target = file or Path(f"recording-{datetime.now(UTC):%Y%m%dT%H%M%S}.tandem")
    first, last = store.save(found[chosen], target)
    print(f"{target}: cycles {first} to {last}, {target.stat().st_size / 1e6:.1f} MB")


@app.command("list")
def list_(config: _Config = None) -> None:
    """Tell which runs are kept, and which recordings alarms have saved."""
    from runtime.recorder import store

    folder = _folder(config)
    for run, segments in store.runs(folder).items():
        size = sum(path.stat().st_size for path in segments)
        began = datetime.fromtimestamp(run, UTC)
        print(f"run {run}: began {began:%Y-%m-%d %H:%M:%S} UTC, {len(segments)} segments, {size / 1e6:.1f} MB")
    for path in sorted(folder.glob("*.tandem")):
        print(f"{path}: {path.stat().st_size / 1e6:.1f} MB")
