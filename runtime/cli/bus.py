"""`tandem bus`: commissioning of a CANopen bus, without a machine running on it."""

from __future__ import annotations

import time
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console
from rich.table import Table

from runtime.config.loader import load_machine
from runtime.config.machine import Bus
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.commissioning import Commissioning, FoundNode
from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.lss import Identity

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


def _bus_of(config: Path | None, channel: str) -> Bus:
    return load_machine(config).fieldbus.bus if config is not None else Bus(channel=channel)


@app.command()
def scan(
    config: Config = None,
    channel: Channel = "can0",
    describe: Annotated[
        bool, typer.Option("--describe", help="Print the nodes as the beginning of a machine description (YAML).")
    ] = False,
) -> None:
    """Every node: identity, device type, name, firmware. Only reads."""
    with open_bus(_bus_of(config, channel)) as bus:
        found = Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE)).scan()
    if describe:
        print(description(found), end="")
        return
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
    Console().print(table)


@app.command()
def eds(
    file: Annotated[Path, typer.Argument(help="EDS or DCF file.", exists=True, dir_okay=False)],
    node: Annotated[int, typer.Argument(help="Node id.", min=1, max=127)],
    config: Config = None,
    channel: Channel = "can0",
) -> None:
    """Compare a node with its EDS file: identity, objects it does not have, constants. Exit code 1 if they differ."""
    od = read_dictionary(str(file), node)
    with open_bus(_bus_of(config, channel)) as bus:
        differences = list(Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE)).compare(node, od))
    for difference in differences:
        print(
            f"{difference.object} {difference.name}: {difference.expected} in the file, {difference.found} in the node"
        )
    print(f"{len(differences)} differences" if differences else f"node {node} is what {file.name} describes")
    raise typer.Exit(1 if differences else 0)


def _identity_of(text: str) -> Identity:
    try:
        numbers = [int(part, 0) for part in text.split(":")]
        if len(numbers) != 4 or not all(0 <= number <= 0xFFFF_FFFF for number in numbers):
            raise ValueError
    except ValueError:
        raise typer.BadParameter("four numbers are expected, VENDOR:PRODUCT:REVISION:SERIAL") from None
    return Identity(*numbers)


@lss.command("find")
def lss_find(config: Config = None, channel: Channel = "can0") -> None:
    """The nodes that have no node id yet (fast scan), as the identities that `set` takes."""
    with open_bus(_bus_of(config, channel)) as bus:
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
) -> None:
    """Give a node its node id and bit rate."""
    if node is None and bitrate is None:
        raise typer.BadParameter("nothing to set: give --node, --bitrate, or both")
    chosen = None if identity is None else _identity_of(identity)
    with open_bus(_bus_of(config, channel)) as bus:
        commissioning = Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE))
        found, number = commissioning.set_node(chosen, node, bitrate, store=store)
    rate = "" if bitrate is None else f", {bitrate} bit/s from its next start on"
    print(f"{_written(found)}: {'no node id' if number is None else f'node {number}'}{rate}")


def _written(identity: Identity) -> str:
    return ":".join(f"0x{number:X}" for number in identity)


def description(found: list[FoundNode]) -> str:
    """Drives and I/O nodes as they stand in a machine description; what the bus cannot know is left to fill in."""
    lines = ["# from a scan of the bus: fill in what stands in angle brackets", "axes:"]
    drives = [node for node in found if node.device_type & 0xFFFF == 402]
    for number, node in enumerate(drives):
        name = "XYZABCUVW"[number] if number < 9 else f"Q{number}"
        lines += [
            f"  - name: {name} # {node.name} {node.firmware}".rstrip(),
            f"    log_axis: {number + 1}",
            "    velocity: <m/min>",
            "    acceleration: <m/s^2>",
            "    jerk: <m/s^3>",
            f"    drive: {{node: {node.node}, increments_per_unit: <increments per mm>{_identity(node, product=True)}}}",
        ]
    lines += ["fieldbus:", "  io:"]
    for node in found:
        if node.device_type & 0xFFFF == 401:
            lines.append(f"    - {{node: {node.node}, inputs: [<names>], outputs: [<names>]{_identity(node)}}}")
    return "\n".join(lines) + "\n"


def _identity(node: FoundNode, *, product: bool = False) -> str:
    text = "" if node.vendor is None else f", vendor_id: 0x{node.vendor:X}"
    return text + (f", product_code: 0x{node.product:X}" if product and node.product is not None else "")
