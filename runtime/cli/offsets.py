"""`tandem offsets`: work offsets and compensation registers of a machine.

A register holds with the next H or D, also while the machine runs; a work offset with the next program start.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.cnc.decoder import ChannelMemory, DecoderSetup
from runtime.cnc.tools.offset_table import COMMON, GREATEST_REGISTER, Register
from runtime.config.loader import load_machine
from runtime.config.machine import Machine
from runtime.config.quantities import UnitError, parse_quantity
from runtime.diagnostics.catalogue import offsets as catalogue
from runtime.diagnostics.errors import TandemError
from runtime.scheduler.offset_tables import copied_offsets, open_offsets

app = typer.Typer(
    help="Show and change work offsets and compensation registers of a machine.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
Config = Annotated[
    Path | None, typer.Option("-c", "--config", help="Machine description; default: the built-in demo machine.")
]
NAMES = {"COMMON": COMMON, **{f"G{number}": number - 53 for number in range(54, 60)}}


class OffsetCommandError(TandemError):
    """What was asked for cannot be done."""


@app.command("list")
def list_offsets(config: Config = None) -> None:
    """Work offsets of all axes, and every register that holds something."""
    machine = load_machine(config)
    memory = ChannelMemory(DecoderSetup.from_machine(machine), offsets=copied_offsets(machine, os.environ))
    memory.read_offsets()
    axes = machine.channels[0].axes
    table = Table("offset", *axes)
    for name, data_set in NAMES.items():
        values = memory.common_offset if data_set == COMMON else memory.zero_offsets[data_set]
        table.add_row(name, *(f"{value:g}" for value in values))
    Console().print(table)
    registers = Table("register", "geometry mm", "wear mm", "sum mm")
    for (kind, number), register in memory.offsets.registers().items():
        row = f"{kind}{number}", f"{register.geometry:g}", f"{register.wear:g}", f"{register.value:g}"
        registers.add_row(*row)
    Console().print(registers)


@app.command("set")
def set_offsets(
    name: Annotated[str, typer.Argument(help="COMMON, G54 … G59, or a register: H1, D12 …", show_default=False)],
    values: Annotated[
        list[str], typer.Argument(help="<axis>=<value> …, of a register geometry=<value> wear=<value>, e.g. 'X=10 mm'")
    ],
    config: Config = None,
) -> None:
    """Set a work offset of some axes, or a register. What is not named stays as it is."""
    machine = load_machine(config)
    name = name.upper()
    if name in NAMES:
        _set_work(machine, NAMES[name], dict(_assignment(text) for text in values))
    elif name[:1] in ("H", "D") and name[1:].isdecimal() and 1 <= int(name[1:]) <= GREATEST_REGISTER:
        _set_register(machine, name[0], int(name[1:]), dict(_assignment(text) for text in values))
    else:
        raise OffsetCommandError(catalogue.OFFSET_UNKNOWN, name=name, last=GREATEST_REGISTER)


def _assignment(text: str) -> tuple[str, str]:
    what, equals, value = text.partition("=")
    if not equals:
        raise OffsetCommandError(catalogue.ASSIGNMENT, text=text)
    return what.strip(), value.strip()


def _quantity(text: str, angular: bool = False) -> float:
    """mm, or degrees of an axis that turns."""
    try:
        return parse_quantity(text, "length", angular=angular)
    except (UnitError, ValueError) as error:
        raise OffsetCommandError(catalogue.VALUE_UNKNOWN, text=text, reason=str(error)) from None


def _set_work(machine: Machine, data_set: int, values: dict[str, str]) -> None:
    setup = DecoderSetup.from_machine(machine)
    parsed = {}
    for axis, text in values.items():
        if axis not in setup.axes:
            raise OffsetCommandError(catalogue.AXIS_UNKNOWN, axis=axis, axes=", ".join(setup.axes))
        index = setup.axes.index(axis)
        parsed[index] = _quantity(text, angular=not setup.linear[index])
    memory = ChannelMemory(setup, offsets=open_offsets(machine, os.environ))
    for index, value in parsed.items():
        memory.set_work_offset(data_set, index, value)


def _set_register(machine: Machine, kind: str, number: int, values: dict[str, str]) -> None:
    unknown = set(values) - {"geometry", "wear"}
    if unknown:
        raise OffsetCommandError(catalogue.ASSIGNMENT, text=min(unknown))
    table = open_offsets(machine, os.environ)
    register = table.register(kind, number)
    register = register._replace(**{what: _quantity(text) for what, text in values.items()})
    if not register.within_limits:
        raise OffsetCommandError(catalogue.REGISTER_LIMITS, name=f"{kind}{number}", value=_worse(register))
    table.set_register(kind, number, register)


def _worse(register: Register) -> str:
    return f"geometry {register.geometry:g} mm, wear {register.wear:g} mm"
