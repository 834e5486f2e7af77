"""`tandem simulate FILE`: the whole machine in virtual time."""

from __future__ import annotations

import os
import sys
from pathlib import Path
from typing import Annotated

import typer

from runtime.cli.dialect_option import DialectOption
from runtime.cli.search_place import HELP, search_order


def command(
    file: Annotated[Path, typer.Argument(help="NC program.", show_default=False)],
    config: Annotated[
        Path | None, typer.Option("--config", "-c", help="Machine description; default: the built-in demo machine.")
    ] = None,
    dialect: DialectOption = "",
    trace: Annotated[
        Path | None, typer.Option(help="Write blocks, events, samples and summary into this folder.")
    ] = None,
    plot: Annotated[Path | None, typer.Option(help="Draw path, speeds and axes into this PNG file.")] = None,
    ideal_axes: Annotated[bool, typer.Option("--ideal-axes", help="Without drives in the loop: faster.")] = False,
    no_plc: Annotated[bool, typer.Option("--no-plc", help="Every function is acknowledged at once.")] = False,
    start_at: Annotated[str, typer.Option("--start-at", help=HELP)] = "",
    passes: Annotated[int, typer.Option(help="How often that block is come to, in loops and subprograms.", min=1)] = 1,
    record: Annotated[Path | None, typer.Option(help="Write a recording for `tandem replay` into this file.")] = None,
    watch: Annotated[
        list[str] | None, typer.Option(help="A V. variable for the summary (not in this version).")
    ] = None,
) -> None:
    """Run a program in virtual time, as fast as the computer can; exit code 1 if it ends with an error."""
    from runtime.cli.explained import explained
    from runtime.cli.preparing import prepare_kernels
    from runtime.cnc.decoder import expect_dialect
    from runtime.config import load_machine
    from runtime.diagnostics.catalogue import system
    from runtime.diagnostics.errors import TandemError
    from runtime.scheduler.offset_tables import copied_offsets
    from runtime.scheduler.simulation import Simulation
    from runtime.scheduler.tool_tables import copied_tools

    if watch:
        raise TandemError(system.OPTION_NOT_AVAILABLE, option="--watch", reason="no variable is recorded yet")
    search = search_order(start_at, passes, automatic=True) if start_at else None
    if dialect:
        expect_dialect(dialect, str(file))
    if plot is not None:
        plot.open("ab").close()  # fails now, not after the program
    machine = load_machine(config)
    dialect = dialect or machine.channels[0].dialect
    prepare_kernels()
    simulation = Simulation(
        machine,
        ideal_axes=ideal_axes,
        dialect=dialect,
        trace=trace,
        samples=plot is not None,
        plc=not no_plc,
        base=config.parent if config else None,
        tools=copied_tools(machine, os.environ),
        offsets=copied_offsets(machine, os.environ),
        record=record,
        machine_file=config,
    )
    progress = _tell_progress if sys.stderr.isatty() else None
    result = simulation.run_program(file, progress=progress, search=search)
    if progress:
        print(file=sys.stderr)
    simulation.close(result)
    for problem in simulation.errors:
        print(explained(problem), file=sys.stderr)
    print(f"time {result.time:.3f} s, path {result.path_length:.3f} mm, {result.cycles} cycles")
    print("end position " + "  ".join(f"{name} {value:.4f}" for name, value in result.positions.items()))
    samples = simulation.samples
    if plot is not None and samples is not None and len(samples.rapid) > 1:
        from runtime.cli.contours import contours_of
        from runtime.cli.plot_motion import pictures_of, plot_motion

        title, contours = f"{file.name} on {machine.name}", contours_of(file, machine, dialect)
        plot_motion(plot, samples.arrays(), samples.rapid, pictures_of(machine), machine.cycle.period, title, contours)
        print(f"picture {plot}")
    if not result.good:
        raise typer.Exit(1)


def _tell_progress(seconds: float, line: int) -> None:
    print(f"\r{seconds:9.1f} s  line {line}", end="", file=sys.stderr, flush=True)
