"""`tandem blocks FILE`: what the decoder makes of a program, as JSON lines."""

from __future__ import annotations

import json
import os
import sys
from pathlib import Path
from typing import Annotated

import numpy as np
import typer

from runtime.cli.dialect_option import DialectOption
from runtime.cli.explained import explained
from runtime.cnc.block_json import rows
from runtime.cnc.decoder import ChannelMemory, DecoderSetup, ProgramError, decoder_of, load_program, located
from runtime.cnc.path_preparation import Frames, PathError
from runtime.cnc.tool_radius_comp import CompensationError, ToolRadiusCompensation
from runtime.config.loader import load_machine
from runtime.diagnostics.errors import TandemError
from runtime.scheduler.offset_tables import copied_offsets
from runtime.scheduler.tool_tables import copied_tools


def command(
    file: Annotated[Path, typer.Argument(help="NC program.", show_default=False)],
    config: Annotated[
        Path | None, typer.Option("--config", "-c", help="Machine description; default: the built-in demo machine.")
    ] = None,
    dialect: DialectOption = "",
) -> None:
    """Print the blocks of a program as JSON lines. Errors go to standard error; exit code 1 if there are any."""
    try:
        machine = load_machine(config)
        setup = DecoderSetup.from_machine(machine)
        memory = ChannelMemory(setup, copied_tools(machine, os.environ), copied_offsets(machine, os.environ))
        program = load_program(file, setup, dialect or machine.channels[0].dialect)
    except TandemError as error:
        _tell(error)
        raise typer.Exit(1) from None
    try:
        decoder = decoder_of(program, setup, start=np.zeros(len(setup.axes)), memory=memory)
        for block in Frames()(ToolRadiusCompensation()(decoder.blocks())):
            for row in rows(block, setup.axes):
                sys.stdout.write(json.dumps(row) + "\n")
        sys.stdout.flush()
    except ProgramError as error:
        sys.stdout.flush()
        _tell(error)
        raise typer.Exit(1) from None
    except (CompensationError, PathError) as error:
        sys.stdout.flush()
        typer.echo(explained(located(program, error.problem)), err=True)
        raise typer.Exit(1) from None
    except BrokenPipeError:  # the reader has seen enough, e.g. `| head`
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
    finally:
        program.close()


def _tell(error: TandemError) -> None:
    problems = error.problems if isinstance(error, ProgramError) else (error.problem,)
    for problem in problems:
        typer.echo(explained(problem), err=True)
