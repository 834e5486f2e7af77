"""`tandem tools`: the tool table of a machine. What is changed holds with the next D word, also while the machine runs."""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.cnc.tools.csv_file import format_csv, read_csv
from runtime.cnc.tools.list_file import format_tool_list, read_tool_list
from runtime.cnc.tools.table import SqliteTools, ToolTableError
from runtime.cnc.tools.tool import FIELDS, GREATEST_NUMBER, FieldError, Kind, Tool, ToolType
from runtime.cnc.tools.written import Datum, data_names, datum_of, name_of, with_written
from runtime.config.loader import load_machine
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place, TandemError
from runtime.scheduler.tool_tables import copied_tools, expect_room, open_tools, tool_axes

app = typer.Typer(
    help="Show and change the tool table of a machine.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
Config = Annotated[
    Path | None, typer.Option("-c", "--config", help="Machine description; default: the built-in demo machine.")
]
Number = Annotated[int, typer.Argument(help="Number of the tool.", min=1, max=GREATEST_NUMBER, show_default=False)]


class ToolCommandError(TandemError):
    """What was asked for cannot be done."""


@app.command("list")
def list_tools(config: Config = None) -> None:
    """All tools: number, name, type, radius, length."""
    table = Table("number", "name", "type", "radius mm", "length mm", "")
    for tool in copied_tools(load_machine(config), os.environ).all():
        table.add_row(
            str(tool.number),
            tool.name,
            ToolType(tool.type).name.lower(),
            f"{tool.radius:g}",
            f"{tool.length:g}",
            "" if tool.valid else "not valid",
        )
    Console().print(table)


@app.command()
def show(number: Number, config: Config = None) -> None:
    """Everything of one tool."""
    machine = load_machine(config)
    tool = copied_tools(machine, os.environ).get(number)
    if tool is None:
        raise _missing(number)
    axes = tool_axes(machine)
    for name, field in FIELDS.items():
        for index in range(field.count) if field.count else (0,):
            value = tool.value(name, index)
            if field.count and value == 0.0:
                continue
            shown = int(value) if field.kind is Kind.FLAG else value
            typer.echo(f"{name_of(Datum(field, index), axes):20} {shown}  {_unit(field.kind)}".rstrip())


def _unit(kind: Kind) -> str:
    return kind.value if kind in (Kind.LENGTH, Kind.OFFSET, Kind.SPEED, Kind.ACCELERATION) else ""


@app.command("set")
def set_data(
    number: Number,
    data: Annotated[
        list[str], typer.Argument(help="<datum>=<value> …, e.g. radius=5 length='50 mm' type=milling offset.X=0.2inch")
    ],
    config: Config = None,
) -> None:
    """Change a tool, or make a new one, which is valid at once."""
    machine = load_machine(config)
    axes = tool_axes(machine)
    table = open_tools(machine, os.environ)
    tool = table.get(number) or Tool(number)
    for text in data:
        name, equals, value = text.partition("=")
        if not equals:
            raise ToolCommandError(catalogue.ASSIGNMENT, text=text)
        try:
            tool = with_written(tool, datum_of(name, axes), value, axes)
        except FieldError as error:
            raise ToolCommandError(error.entry, Place(), **error.values) from None
    _enter(machine, table, [tool])


@app.command()
def remove(number: Number, config: Config = None) -> None:
    """Take a tool out of the table."""
    if not open_tools(load_machine(config), os.environ).remove(number):
        raise _missing(number)


@app.command("import")
def import_tools(
    file: Annotated[Path, typer.Argument(help="Tool list (.lis) or spreadsheet table (.csv).", show_default=False)],
    config: Config = None,
    replace: Annotated[
        bool, typer.Option("--replace", help="The table holds nothing but the tools of the file.")
    ] = False,
) -> None:
    """Enter the tools of a file; those with the same number are replaced. If anything in it is wrong, nothing is entered."""
    machine = load_machine(config)
    axes = tool_axes(machine)
    if _kind(file) == ".lis":
        read = read_tool_list(file, axes.rotary)
    else:
        read = read_csv(file, axes)
    for problem in read.warnings:
        typer.echo(problem.explained(), err=True)
    if read.problems:
        raise ToolTableError.of(read.problems)
    table = open_tools(machine, os.environ)
    _enter(machine, table, list(read.tools), replace=replace)
    typer.echo(f"{len(read.tools)} tools")


@app.command("export")
def export_tools(
    file: Annotated[Path, typer.Argument(help="Tool list (.lis) or spreadsheet table (.csv).", show_default=False)],
    config: Config = None,
) -> None:
    """Write all tools into a file."""
    machine = load_machine(config)
    tools = copied_tools(machine, os.environ).all()
    text = format_tool_list(tools) if _kind(file) == ".lis" else format_csv(tools, tool_axes(machine))
    file.write_text(text, encoding="utf-8")
    typer.echo(f"{len(tools)} tools")


@app.command()
def data(config: Config = None) -> None:
    """The names of the data of a tool."""
    typer.echo("\n".join(data_names(tool_axes(load_machine(config)))))


def _enter(machine: Machine, table: SqliteTools, tools: list[Tool], *, replace: bool = False) -> None:
    there = set() if replace else {tool.number for tool in table.all()}
    expect_room(machine, len(there | {tool.number for tool in tools}))
    if replace:
        table.replace(*tools)
    else:
        table.put(*tools)


def _kind(file: Path) -> str:
    ending = file.suffix.lower()
    if ending not in (".lis", ".csv"):
        raise ToolCommandError(catalogue.FILE_KIND, name=file.name)
    return ending


def _missing(number: int) -> ToolCommandError:
    entry: ErrorEntry = catalogue.TOOL_MISSING
    return ToolCommandError(entry, Place(), number=number)
