"""The `tandem` command: finds the sub-command, starts it, and tells what went wrong.

A sub-command's module is imported when it is called and not before: `tandem --help` is there at once, and `tandem
doctor` runs without compiling a kernel.
"""

from __future__ import annotations

import importlib
import os
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Annotated, Any

import typer

from runtime.cli import INTERRUPTED
from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Place, TandemError
from runtime.diagnostics.version import version


@dataclass(frozen=True, slots=True)
class SubCommand:
    """A row of `tandem --help`; `module` has a function `command`, or a typer application `app` with several."""

    name: str
    module: str
    help: str


SUB_COMMANDS = (
    SubCommand("check", "runtime.cli.check", "Check programs without motion; errors as file:line:column: id: text."),
    SubCommand("blocks", "runtime.cli.blocks", "Print what the preparation makes of a program, as JSON lines."),
    SubCommand(
        "lang", "runtime.cli.lang", "Print the reference of the language: every supported function with its syntax."
    ),
    SubCommand("simulate", "runtime.cli.simulate", "Run a program in virtual time, as fast as the computer can."),
    SubCommand("compare", "runtime.cli.compare", "Overlay two traces of simulate: what did this parameter change?"),
    SubCommand("tools", "runtime.cli.tools", "Show and change the tool table of a machine."),
    SubCommand("offsets", "runtime.cli.offsets", "Show and change work offsets and compensation registers."),
    SubCommand("run", "runtime.cli.run", "Run the machine in real time until stopped."),
    SubCommand("doctor", "runtime.cli.doctor", "Tell whether this host is fit for real time, and what to do if not."),
    SubCommand("bus", "runtime.cli.bus", "Look at the nodes of a CANopen bus on which no machine runs."),
    SubCommand("drive", "runtime.cli.drive", "Look at and move one drive of a machine that does not run."),
    SubCommand("record", "runtime.cli.record", "Save what the flight recorder of a machine has kept (save, list)."),
    SubCommand("replay", "runtime.cli.replay", "Run a recording through the cycle code again, and compare bit by bit."),
    SubCommand("hli", "runtime.cli.hli", "Look into the interface memory of a running machine."),
    SubCommand("plc", "runtime.cli.plc", "Replace the PLC program of a running machine (reload)."),
)


class CommandError(TandemError):
    """A sub-command that is not there."""


class FileError(TandemError):
    """A file that the user named cannot be read or written."""


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line; the exit code is 0 done, 1 error of the catalogue, 2 wrong usage, 130 interrupted."""
    arguments = list(sys.argv[1:] if arguments is None else arguments)
    names = {command.name: command for command in SUB_COMMANDS}
    try:
        if arguments and arguments[0] in names:
            _start(_application(names[arguments[0]]), arguments[1:], f"tandem {arguments[0]}")
        else:
            _start(_overview(), arguments, "tandem")
        sys.stdout.flush()
    except SystemExit as end:  # typer ends every command so, the successful one too
        return end.code if isinstance(end.code, int) else int(end.code is not None)
    except KeyboardInterrupt:
        return INTERRUPTED
    except BrokenPipeError:  # `tandem blocks … | head`: the reader has enough
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 0
    except TandemError as error:
        return _tell(error)
    except OSError as error:
        if error.filename is None:  # not the user's file
            raise
        return _tell(FileError(system.FILE_FAILED, Place(file=str(error.filename)), reason=error.strerror))
    return 0


def _tell(error: TandemError) -> int:
    for problem in error.problems:
        print(problem.explained(), file=sys.stderr)
    return 1


def _start(application: typer.Typer, arguments: Sequence[str], name: str) -> None:
    typer.main.get_command(application).main(args=list(arguments), prog_name=name)


def _application(command: SubCommand) -> typer.Typer:
    """Import a sub-command and make it an application of its own. Raises CommandError if it is not installed."""
    try:
        module = importlib.import_module(command.module)
    except ModuleNotFoundError as error:
        raise CommandError(system.COMMAND_MISSING, command=command.name, reason=str(error)) from error
    ready: typer.Typer | None = getattr(module, "app", None)
    if ready is not None:
        return ready
    function: Callable[..., Any] = module.command
    application = typer.Typer(add_completion=False, pretty_exceptions_enable=False)
    application.command(help=function.__doc__ or command.help)(function)
    return application


def _print_version(wanted: bool) -> None:
    if wanted:
        print(f"tandem {version()}")
        raise typer.Exit


def _options(
    show_version: Annotated[
        bool, typer.Option("--version", callback=_print_version, is_eager=True, help="Print the version.")
    ] = False,
) -> None:
    """Options of `tandem` itself."""


def _overview() -> typer.Typer:
    """The application that knows the names only: for --help, --version and misspelt names."""
    application = typer.Typer(
        help="Tandem: a soft PLC and a CNC in one runtime for Linux industrial PCs.",
        no_args_is_help=True,
        add_completion=False,
        pretty_exceptions_enable=False,
    )

    application.callback()(_options)
    for command in SUB_COMMANDS:
        application.command(command.name, help=command.help)(lambda: None)
    return application


if __name__ == "__main__":
    sys.exit(main())
