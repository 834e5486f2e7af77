"""`tandem check FILE…`: are the programs right? They are parsed, decoded and held against the software limits; nothing moves."""

from __future__ import annotations

import os
import sys
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, DownloadColumn, Progress, TextColumn, TimeRemainingColumn

from runtime.cli.dialect_option import DialectOption
from runtime.cli.explained import explained
from runtime.cnc.decoder import (
    AnyDecoder,
    AnyProgram,
    ChannelMemory,
    DecoderSetup,
    ProgramError,
    decoder_of,
    expect_dialect,
    load_program,
    located,
    look_through,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.path_preparation import LateSynchronisation, MicroJointSettings, SoftwareLimits
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.stages import prepared
from runtime.cnc.tool_radius_comp import CompensationError
from runtime.cnc.tools.offset_table import MemoryOffsets
from runtime.cnc.tools.table import MemoryTools
from runtime.cnc.tools.tool import Tool
from runtime.config.loader import load_machine
from runtime.diagnostics.errors import Problem, Severity, TandemError
from runtime.scheduler.offset_tables import copied_offsets
from runtime.scheduler.tool_tables import copied_tools

# A loop that runs so long without any output does not end by itself in a check, where no PLC changes anything.
IDLE_LIMIT = 1_000_000
EXECUTED_LIMIT = 5_000_000  # blocks; a longer run is not followed to its end
MOST_PROBLEMS = 20  # told per program
_LARGE_FILE = 4_000_000  # bytes from which progress is shown


def command(
    files: Annotated[list[Path], typer.Argument(help="NC programs.", show_default=False)],
    config: Annotated[
        Path | None, typer.Option("--config", "-c", help="Machine description; default: the built-in demo machine.")
    ] = None,
    dialect: DialectOption = "",
) -> None:
    """Parse and decode programs without motion; exit code 1 if there are errors.

    Each is told as file:line:column: id: text, then the block with a marker under the place, then a hint where one helps.
    """
    try:
        machine = load_machine(config)
        setup, limits = DecoderSetup.from_machine(machine), SoftwareLimits.of(machine)
        axes = AxisLimits.of(machine.axes[machine.axis_index(name)] for name in machine.channels[0].axes)
        tools = copied_tools(machine, os.environ).all()
        offsets = copied_offsets(machine, os.environ)
        joints = MicroJointSettings.of(machine.channels[0].parameters)
    except TandemError as error:
        for problem in error.problems:
            typer.echo(problem.explained(), err=True)
        raise typer.Exit(1) from None
    failed = False
    for file in files:
        spoken = dialect or machine.channels[0].dialect
        problems, warnings = check(file, setup, limits, axes, spoken, tools, joints, offsets)
        for problem in (*problems, *warnings):
            typer.echo(explained(problem))
        failed |= bool(problems)
    raise typer.Exit(int(failed))


def check(
    file: Path,
    setup: DecoderSetup,
    limits: SoftwareLimits,
    axes: AxisLimits,
    dialect: str = "isg",
    tools: Iterable[Tool] = (),
    joints: MicroJointSettings | None = None,
    offsets: MemoryOffsets | None = None,
) -> tuple[tuple[Problem, ...], tuple[Problem, ...]]:
    """Errors and warnings of a program that starts with all axes at 0, or where they can stand next to it.

    First all of its text is looked through, then it is executed without a machine, with `tools` and a copy of `offsets`.
    """
    warnings: list[Problem] = []
    decoder: AnyDecoder | None = None
    program: AnyProgram | None = None
    try:
        expect_dialect(dialect, str(file))
        program = load_program(file, setup, dialect)
        errors: list[Problem] = []
        with _progress(file) as progress:
            for problem in look_through(file, setup, progress, dialect):
                (errors if problem.entry.severity >= Severity.ERROR else warnings).append(problem)
                if len(errors) + len(warnings) >= MOST_PROBLEMS:
                    break
        if errors:
            return tuple(errors), tuple(warnings)
        memory = ChannelMemory(setup, MemoryTools(tools), None if offsets is None else offsets.copy())
        start = limits.nearest(np.zeros(len(setup.axes)))
        decoder = decoder_of(program, setup, start=start, memory=memory, idle_limit=IDLE_LIMIT)
        for _ in prepared(decoder.blocks(), axes, limits, LateSynchronisation(), warnings, joints):
            if decoder.executed > EXECUTED_LIMIT:
                typer.echo(f"{file}: not followed beyond {EXECUTED_LIMIT} executed blocks", err=True)
                break
    except (PathError, CompensationError) as error:
        assert program is not None
        return (located(program, error.problem),), (*warnings, *(decoder.warnings if decoder else ()))
    except ProgramError as error:
        return error.problems, (*warnings, *(decoder.warnings if decoder else ()))
    finally:
        if program is not None:
            program.close()
    return (), (*warnings, *decoder.warnings)


@contextmanager
def _progress(file: Path) -> Iterator[Callable[[int, int], None] | None]:
    """A progress bar for large files, if somebody is looking."""
    try:
        size = file.stat().st_size
    except OSError:
        size = 0
    if size < _LARGE_FILE or not sys.stderr.isatty():
        yield None
        return
    with Progress(
        TextColumn("{task.description}"),
        BarColumn(),
        DownloadColumn(),
        TimeRemainingColumn(),
        console=Console(stderr=True),
        transient=True,
    ) as bar:
        task = bar.add_task(file.name, total=size)
        yield lambda done, total: bar.update(task, completed=done, total=total)
