"""`tandem replay FILE`: the same cycle code on what was recorded, compared bit by bit."""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated

import typer


def command(
    file: Annotated[
        Path, typer.Argument(help="Recording, of `tandem record save` or of an alarm.", show_default=False)
    ],
    config: Annotated[
        Path | None,
        typer.Option("--config", "-c", help="Another machine description than the recorded one: what would it change?"),
    ] = None,
    trace: Annotated[Path | None, typer.Option(help="Write events, samples and summary into this folder.")] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw path, speeds and axes into this PNG file.")] = None,
) -> None:
    """Run a recording again and compare; exit code 0: the same, 1: they part, and where, or it cannot be replayed."""
    from runtime.cli.explained import explained
    from runtime.cli.preparing import prepare_kernels
    from runtime.config import load_machine
    from runtime.recorder.file import RecordingFile
    from runtime.scheduler.replay import Replay

    if plot is not None:
        plot.open("ab").close()  # fails now, not after the work
    prepare_kernels()
    with RecordingFile(file) as recording:
        replay = Replay(
            recording,
            load_machine(config) if config else None,
            trace=trace,
            samples=trace is not None or plot is not None,
        )
        for warning in replay.warnings:
            print(explained(warning), file=sys.stderr)
        begin = time.monotonic()
        result = replay.run()
        took = time.monotonic() - begin
    if plot is not None and len(replay.samples.rapid) > 1:
        from runtime.cli.plot_motion import pictures_of, plot_motion

        machine = replay.machine
        title = f"{file.name} on {machine.name}"
        plot_motion(
            plot, replay.samples.arrays(), replay.samples.rapid, pictures_of(machine), machine.cycle.period, title
        )
        print(f"picture {plot}")
    gaps = f", {result.gaps} gaps" if result.gaps else ""
    print(
        f"{result.cycles} cycles ({result.seconds:.3f} s) are the same{gaps}; {result.seconds / took:.1f} times real time"
    )
    if result.difference is not None:
        print(result.difference)
        raise typer.Exit(1)
