"""Which tool table a process works with: the machine's own, a copy of it, or the tools that the description lists.

Checks and simulations get a copy: what a program writes into the table there changes nothing of the machine.
"""

from __future__ import annotations

from collections.abc import Mapping
from importlib.resources import files
from pathlib import Path

from runtime.cnc.tools.list_file import read_tool_list
from runtime.cnc.tools.table import MemoryTools, SqliteTools, ToolTable, ToolTableError
from runtime.cnc.tools.tool import Tool
from runtime.cnc.tools.written import ToolAxes
from runtime.config.machine import AxisType, Machine
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import Place
from runtime.scheduler.retained import state_directory

FILE = "tools.db"


def database(machine: Machine, environment: Mapping[str, str]) -> Path:
    """The file of the machine's table."""
    if machine.tools.database is not None:
        return Path(machine.tools.database)
    return state_directory(machine.state_directory, environment) / FILE


def tool_axes(machine: Machine) -> ToolAxes:
    """The axes of the channel, as tools name them."""
    axes = machine.channels[0].axes
    rotary = frozenset(
        i for i, name in enumerate(axes) if machine.axes[machine.axis_index(name)].type is not AxisType.LINEAR
    )
    return ToolAxes(axes, rotary)


def initial_tools(machine: Machine) -> tuple[Tool, ...]:
    """The tools that a new table begins with. Raises ToolTableError for a list that is wrong, or too long (P-CHAN-00419)."""
    if machine.tools.initial_list is None:
        return ()
    path = _file(machine.tools.initial_list)
    read = read_tool_list(path, tool_axes(machine).rotary)
    if read.problems:
        raise ToolTableError.of(read.problems)
    expect_room(machine, len(read.tools))
    return read.tools


def expect_room(machine: Machine, count: int) -> None:
    """ToolTableError if the channel has no room for so many tools (P-CHAN-00419)."""
    limit = machine.channels[0].parameters.configuration.decoder.tools
    if count > limit:
        raise ToolTableError(catalogue.TOOLS_MANY, count=count, limit=limit)


def _file(name: str) -> Path:
    """A list by its path, or as package:file. Raises ToolTableError for a package that is not there."""
    package, colon, file = name.partition(":")
    if not colon:
        return Path(name)
    try:
        return Path(str(files(package))) / file
    except (ModuleNotFoundError, ValueError) as error:
        raise ToolTableError(catalogue.LIST_UNREADABLE, Place(file=name), reason=str(error)) from None


def open_tools(machine: Machine, environment: Mapping[str, str]) -> SqliteTools:
    """The machine's table itself; it is made if it is not there. Raises ToolTableError."""
    return SqliteTools(database(machine, environment), lambda: initial_tools(machine))


def listed_tools(machine: Machine) -> MemoryTools:
    """The tools that the description lists. Raises ToolTableError."""
    return MemoryTools(initial_tools(machine))


def copied_tools(machine: Machine, environment: Mapping[str, str]) -> MemoryTools:
    """The tools that the machine has now; those that it will begin with if it has never run. Raises ToolTableError."""
    if not database(machine, environment).exists():
        return listed_tools(machine)
    table = open_tools(machine, environment)
    try:
        return MemoryTools(table.all())
    finally:
        table.close()


def machine_tools(machine: Machine, environment: Mapping[str, str]) -> ToolTable:
    """The machine's table; if it cannot be opened, one that says so to the programs that ask for a tool."""
    try:
        return open_tools(machine, environment)
    except ToolTableError as error:
        return ToolsOutOfReach(error)


class ToolsOutOfReach:
    """A table that could not be opened: every access tells why."""

    def __init__(self, error: ToolTableError) -> None:
        self._error = error

    def get(self, number: int) -> Tool | None:
        raise self._error

    def put(self, *tools: Tool) -> None:
        raise self._error

    def remove(self, number: int) -> bool:
        raise self._error

    def all(self) -> list[Tool]:
        raise self._error
