"""`tandem bus`: commissioning of a CANopen bus, without a machine running on it."""

from __future__ import annotations

import math
import sys
import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.config.loader import load_machine
from runtime.config.machine import Bus
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.commissioning import Commissioning
from runtime.fieldbus.dictionaries import load_dictionary
from runtime.fieldbus.lss import Identity
from runtime.fieldbus.survey import describe, eds_files, survey

IDENTIFYING = ("0x1000", "0x1018:1", "0x1018:2")  # device type, vendor, product
_PAUSE = 0.0005  # s between two looks at the bus

app = typer.Typer(
    help="Look at the nodes of a CANopen bus on which no machine runs.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
lss = typer.Typer(
    help="Set node ids and bit rates of nodes that have no switches for them (LSS, CiA 305).", no_args_is_help=True
)
app.add_typer(lss, name="lss")
Config = Annotated[
    Path | None, typer.Option("-c", "--config", help="Machine description whose bus is meant; default: SocketCAN.")
]
Channel = Annotated[str, typer.Option(help="SocketCAN interface, if there is no description yet.")]


Named = Annotated[str, typer.Option("--bus", help="Name of the bus in fieldbus.buses; default: fieldbus.bus.")]


def _bus_of(config: Path | None, channel: str, name: str) -> Bus:
    if config is None:
        return Bus(channel=channel)
    buses = load_machine(config).fieldbus.all_buses()
    if name not in buses:
        known = ", ".join(filter(None, buses)) or "none"
        raise typer.BadParameter(f"{name} is no bus of the machine; its further buses: {known}")
    return buses[name]


@app.command()
def scan(
    config: Config = None,
    channel: Channel = "can0",
    name: Named = "",
    machine: Annotated[
        Path | None,
        typer.Option("--machine", help="Write the beginning of a machine description (YAML) to a new file."),
    ] = None,
    eds_folder: Annotated[
        Path | None,
        typer.Option(
            "--eds", help="Folder in which the EDS files of the nodes are looked for.", file_okay=False, exists=True
        ),
    ] = None,
    pitch: Annotated[
        list[str] | None,
        typer.Option(help="NODE=MM: what an axis moves in a turn of its shaft, in mm or degrees.", show_default=False),
    ] = None,
) -> None:
    """Every node: identity, device type, name, firmware. Only reads."""
    pitches = dict(_pitch(text) for text in pitch or ())
    if machine is not None and machine.exists():
        raise typer.BadParameter(f"{machine} is there already, and a description is nothing to write over")
    described = _bus_of(config, channel, name)
    with open_bus(described) as bus:
        looking = Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE))
        found = looking.scan()
        if machine is not None:
            surveys = survey(looking, found, eds_files(eds_folder) if eds_folder else ())
            machine.write_text(describe(surveys, described, pitches, machine.parent), encoding="utf-8")
    table = Table("node", "profile", "vendor", "product", "revision", "serial", "name", "hardware", "firmware")
    for node in found:
        numbers = (node.vendor, node.product, node.revision, node.serial)
        table.add_row(
            str(node.node),
            node.profile,
            *("" if number is None else f"0x{number:X}" for number in numbers),
            node.name,
            node.hardware,
            node.firmware,
        )
    Console(width=None if sys.stdout.isatty() else 140).print(table)


@app.command()
def eds(
    file: Annotated[Path, typer.Argument(help="EDS or DCF file.", exists=True, dir_okay=False)],
    node: Annotated[int, typer.Argument(help="Node id.", min=1, max=127)],
    config: Config = None,
    channel: Channel = "can0",
    name: Named = "",
) -> None:
    """Compare a node with its EDS file: identity, objects it does not have, constants. Exit code 1 if they differ."""
    od = load_dictionary(str(file), node, "on the bus")
    with open_bus(_bus_of(config, channel, name)) as bus:
        differences = list(Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE)).compare(node, od))
    for difference in differences:
        print(
            f"{difference.object} {difference.name}: {difference.expected} in the file, {difference.found} in the node"
        )
    print(f"{len(differences)} differences" if differences else f"node {node} is what {file.name} describes")
    if any(difference.object in IDENTIFYING for difference in differences):
        print(f"{file.name} is the file of another device")
    raise typer.Exit(1 if differences else 0)


def _pitch(text: str) -> tuple[int, float]:
    node, equals, way = text.partition("=")
    try:
        number, length = int(node), float(way)
        if not (equals and 1 <= number <= 127 and 0.0 < length < math.inf):
            raise ValueError
    except ValueError:
        raise typer.BadParameter(f"{text}: a node id and a length are expected, as in 1=10") from None
    return number, length


def _identity_of(text: str) -> Identity:
    try:
        numbers = [int(part, 0) for part in text.split(":")]
        if len(numbers) != 4 or not all(0 <= number <= 0xFFFF_FFFF for number in numbers):
            raise ValueError
    except ValueError:
        raise typer.BadParameter("four numbers are expected, VENDOR:PRODUCT:REVISION:SERIAL") from None
    return Identity(*numbers)


@lss.command("find")
def lss_find(config: Config = None, channel: Channel = "can0", name: Named = "") -> None:
    """The nodes that have no node id yet (fast scan), as the identities that `set` takes."""
    with open_bus(_bus_of(config, channel, name)) as bus:
        found = Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE)).unconfigured()
    for identity in found:
        print(f"{_written(identity)}  ({identity})")
    print(f"{len(found)} nodes without a node id")


@lss.command("set")
def lss_set(
    identity: Annotated[
        str | None,
        typer.Argument(
            help="VENDOR:PRODUCT:REVISION:SERIAL of the node; without: the only node on the bus.", show_default=False
        ),
    ] = None,
    node: Annotated[int | None, typer.Option(help="Its new node id.", min=1, max=127)] = None,
    bitrate: Annotated[int | None, typer.Option(help="Its new bit rate in bit/s, from its next start on.")] = None,
    store: Annotated[bool, typer.Option(help="Keep it without supply.")] = True,
    config: Config = None,
    channel: Channel = "can0",
    name: Named = "",
) -> None:
    """Give a node its node id and bit rate."""
    if node is None and bitrate is None:
        raise typer.BadParameter("nothing to set: give --node, --bitrate, or both")
    chosen = None if identity is None else _identity_of(identity)
    with open_bus(_bus_of(config, channel, name)) as bus:
        commissioning = Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE))
        found, number = commissioning.set_node(chosen, node, bitrate, store=store)
    rate = "" if bitrate is None else f", {bitrate} bit/s from its next start on"
    print(f"{_written(found)}: {'no node id' if number is None else f'node {number}'}{rate}")


def _written(identity: Identity) -> str:
    return ":".join(f"0x{number:X}" for number in identity)
