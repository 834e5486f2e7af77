"""`tandem drive`: one drive of a machine, while no machine runs: its state, its objects, motion by hand, tuning."""

from __future__ import annotations

import contextlib
import os
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Annotated

import canopen
import typer
from rich.console import Console
from rich.table import Table

from runtime.cli.keys import Keys, StatusLine
from runtime.config.loader import load_machine
from runtime.config.machine import Axis, AxisType, Machine
from runtime.diagnostics.catalogue import commissioning as errors
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.cia402 import drive_state
from runtime.fieldbus.commissioning import Commissioning
from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.dictionaries import load_dictionary
from runtime.fieldbus.error_codes import emergency_text
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.jog import (
    DeadMan,
    DriveSession,
    Hand,
    JogLaw,
    Sample,
    Swing,
    TuneFigures,
    bus_of,
    drive_of,
    figures,
    jog_velocity,
    window,
)
from runtime.fieldbus.network import PumpedSdoClient
from runtime.fieldbus.objects import Value, find_object, read_object, title, variables, write_object
from runtime.fieldbus.pdo import object_name

_PAUSE = 0.0002  # s between two looks at the bus
_TOLD = 0.2  # s between two status lines
_PRIORITY = 60  # SCHED_FIFO, where it may be had: set-points in time are smooth set-points
_SHOWN = (
    (0x6041, 0),
    (0x6061, 0),
    (0x603F, 0),
    (0x6064, 0),
    (0x606C, 0),
    (0x6077, 0),
    (0x6079, 0),
    (0x60F4, 0),
    (0x60FD, 0),
)

app = typer.Typer(
    help="Look at and move one drive of a machine that does not run.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
AxisName = Annotated[str, typer.Argument(help="Axis of the machine description.", metavar="AXIS")]
Config = Annotated[Path | None, typer.Option("-c", "--config", help="Machine description; default: the demo machine.")]
Velocity = Annotated[
    float | None, typer.Option(help="mm/s or degrees/s; default: jog_velocity of the axis.", show_default=False)
]
Hold = Annotated[
    float, typer.Option("--dead-man", help="s without a key after which the axis brakes.", min=0.1, max=2.0)
]


@contextlib.contextmanager
def _objects(config: Path | None, name: str) -> Iterator[tuple[Axis, canopen.ObjectDictionary, PumpedSdoClient]]:
    """The drive of an axis, on a bus that no master uses."""
    machine = load_machine(config)
    axis = drive_of(machine, name)
    assert axis.drive is not None
    od = load_dictionary(eds_path(axis.drive.eds, DRIVE_EDS), axis.drive.node, f"axis {axis.name}")
    with open_bus(bus_of(machine, axis)) as bus:
        commissioning = Commissioning(bus, time.monotonic, lambda: time.sleep(_PAUSE))
        commissioning.refuse_a_master()
        yield axis, od, commissioning.client(axis.drive.node, od)


@app.command()
def state(axis: AxisName, config: Config = None) -> None:
    """State, mode, error, position and what else the drive tells of itself."""
    with _objects(config, axis) as (described, od, client):
        assert described.drive is not None
        for index, subindex in _SHOWN:
            try:
                variable = find_object(od, object_name(index, subindex))
                value = read_object(client, described.drive.node, variable)
            except FieldbusError as error:
                if error.problem.entry is catalogue.SDO_NO_ANSWER:
                    raise
                continue  # not every drive has every object
            print(f"{title(variable)} ({object_name(index, subindex)}): {_with_meaning(index, value, described)}")


def _with_meaning(index: int, value: Value, axis: Axis) -> str:
    if not isinstance(value, int):
        return _written(value)
    unit = "mm" if axis.type is AxisType.LINEAR else "degrees"
    assert axis.drive is not None
    match index:
        case 0x6041:
            return f"0x{value:04X}, {drive_state(value).name.lower().replace('_', ' ')}"
        case 0x603F:
            return f"0x{value:04X}, {emergency_text(value)}"
        case 0x6064 | 0x60F4:
            return f"{value}, {value / axis.drive.increments_per_unit:g} {unit}"
        case 0x606C:
            return f"{value}, {value / axis.drive.increments_per_unit:g} {unit}/s"
        case 0x6077:
            return f"{value / 10:g} % of the rated torque"
        case 0x6079:
            return f"{value / 1000:g} V"
        case 0x60FD:
            return f"0x{value:08X}"
    return str(value)


def _written(value: Value) -> str:
    return value.hex(" ") if isinstance(value, bytes) else f"{value:g}" if isinstance(value, float) else str(value)


@app.command()
def objects(
    axis: AxisName,
    search: Annotated[str, typer.Argument(help="Only names that contain this.")] = "",
    config: Config = None,
) -> None:
    """The objects of the drive's EDS file: index, name, type, access. Needs no bus."""
    described = drive_of(load_machine(config), axis)
    assert described.drive is not None
    od = load_dictionary(eds_path(described.drive.eds, DRIVE_EDS), described.drive.node, f"axis {described.name}")
    table = Table("object", "name", "bits", "access", "low", "high")
    for variable in variables(od):
        if search.lower() in title(variable).lower():
            limits = ("" if limit is None else str(limit) for limit in (variable.min, variable.max))
            bits = str(len(variable))
            table.add_row(
                object_name(variable.index, variable.subindex), title(variable), bits, variable.access_type, *limits
            )
    Console(width=None if sys.stdout.isatty() else 140).print(table)


@app.command()
def read(
    axis: AxisName,
    names: Annotated[list[str], typer.Argument(help="Objects: 0x6064, 0x60C2:1, or their names in the EDS file.")],
    config: Config = None,
) -> None:
    """Read objects of the drive, in the types of its EDS file."""
    with _objects(config, axis) as (described, od, client):
        assert described.drive is not None
        for name in names:
            variable = find_object(od, name)
            value = read_object(client, described.drive.node, variable)
            number = f" (0x{value & (1 << len(variable)) - 1:X})" if isinstance(value, int) else ""
            print(f"{object_name(variable.index, variable.subindex)} {title(variable)} = {_written(value)}{number}")


@app.command()
def write(
    axis: AxisName,
    name: Annotated[str, typer.Argument(help="Object: 0x6085, 0x60C2:1, or its name in the EDS file.")],
    value: Annotated[str, typer.Argument(help="A number (0x10 too), text, or hexadecimal bytes.")],
    config: Config = None,
) -> None:
    """Write an object of the drive and read it back. `--` before a negative value."""
    with _objects(config, axis) as (described, od, client):
        assert described.drive is not None
        variable = find_object(od, name)
        write_object(client, described.drive.node, variable, value)
        text = "written"
        if variable.readable:
            text = _written(read_object(client, described.drive.node, variable))
        print(f"{object_name(variable.index, variable.subindex)} {title(variable)} = {text}")


class KeyHand:
    """+ and right: forwards, - and left: backwards, as long as they are held; q: the end; any other key: stop."""

    def __init__(self, keys: Keys, dead_man: DeadMan, *, any_key: bool = False) -> None:
        self._keys = keys
        self._dead_man = dead_man
        self._any_key = any_key

    def order(self, now: float, position: float) -> int | None:
        """As `Hand`."""
        pressed = self._keys.read()
        if pressed is None or b"q" in pressed:
            return None
        if pressed:
            key = pressed[-1:]
            direction = 1 if self._any_key else {b"+": 1, b"-": -1}.get(key, 0)
            self._dead_man.give(direction, now)
        return self._dead_man.direction(now)


@contextlib.contextmanager
def _session(machine: Machine, axis: Axis) -> Iterator[DriveSession]:
    with contextlib.suppress(OSError):
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(_PRIORITY))
    with (
        open_bus(bus_of(machine, axis)) as bus,
        DriveSession(machine, axis, bus, now=time.monotonic, idle=lambda: time.sleep(_PAUSE)) as session,
    ):
        yield session


def _unit(axis: Axis) -> str:
    return "mm" if axis.type is AxisType.LINEAR else "degrees"


def _watch(line: StatusLine, axis: Axis, samples: list[Sample] | None = None) -> Callable[[Sample], None]:
    """Tells the status line every now and then, and keeps the samples."""
    told, worst = 0.0, 0.0

    def watch(sample: Sample) -> None:
        nonlocal told, worst
        worst = max(worst, abs(sample.following_error))
        if samples is not None:
            samples.append(sample)
        if sample.time >= told + _TOLD:
            told = sample.time
            torque = "" if sample.torque != sample.torque else f"  torque {sample.torque / 10:6.1f} %"
            line.tell(
                f"{axis.name} {sample.actual:12.4f} {_unit(axis)}  {sample.velocity:10.3f} {_unit(axis)}/s"
                f"  following error {sample.following_error:8.4f}, at most {worst:.4f}{torque}"
            )

    return watch


@app.command()
def jog(
    axis: AxisName,
    velocity: Velocity = None,
    travel: Annotated[float, typer.Option(help="mm or degrees to both sides of where it stands.", min=0.0)] = 10.0,
    dead_man: Hold = 0.6,
    config: Config = None,
) -> None:
    """Move an axis by keys: + or right arrow, - or left arrow, as long as they are held; q ends.

    It stays within the travel (and the software limits, if its encoder is absolute) and brakes when no key comes, on Ctrl-C and
    when the terminal is lost.
    """
    machine = load_machine(config)
    described = drive_of(machine, axis)
    speed = jog_velocity(described, velocity)
    with Keys() as keys, _session(machine, described) as session:
        low, high = window(described, session.position, travel)
        law = JogLaw(session.position, speed, described.acceleration, low, high)
        if described.type is AxisType.SPINDLE:
            law.low, law.high = float("-inf"), float("inf")
        way = speed * dead_man + speed**2 / (2.0 * described.acceleration)
        print(
            f"{axis} from {low:g} to {high:g} {_unit(described)} with {speed:g} {_unit(described)}/s; + - move, q ends; "
            f"it goes on for at most {way:.3g} {_unit(described)} when the key is let go",
            flush=True,
        )
        keys.read()  # pressed before it was ready: moves nothing
        line = StatusLine()
        session.move(law, KeyHand(keys, DeadMan(dead_man)), _watch(line, described))
        line.close()
        print(f"{axis} stands at {session.position:.4f} {_unit(described)}")


@app.command()
def tune(
    axis: AxisName,
    by: Annotated[float, typer.Option(help="mm or degrees forwards from where it stands; then back, and so on.")],
    velocity: Velocity = None,
    dead_man: Hold = 0.6,
    plot: Annotated[
        Path | None, typer.Option(help="Draw following error, velocity and torque into a PNG file.")
    ] = None,
    config: Config = None,
) -> None:
    """Move to and fro as long as any key is held, and tell how the drive follows; q ends."""
    machine = load_machine(config)
    described = drive_of(machine, axis)
    speed = jog_velocity(described, velocity)
    samples: list[Sample] = []
    with Keys() as keys, _session(machine, described) as session:
        start = session.position
        low, high = window(described, start, abs(by))
        ends = (start, min(high, start + by)) if by > 0 else (max(low, start + by), start)
        if described.type is AxisType.SPINDLE or ends[0] == ends[1]:
            raise FieldbusError(
                errors.JOG_LIMIT, what="a way", value=by, limit=high - start, axis=axis, unit=_unit(described)
            )
        print(f"{axis} from {ends[0]:g} to {ends[1]:g} {_unit(described)}; hold a key, q ends", flush=True)
        law = JogLaw(start, speed, described.acceleration, *ends)
        keys.read()  # pressed before it was ready: moves nothing
        line = StatusLine()
        hand: Hand = Swing(KeyHand(keys, DeadMan(dead_man), any_key=True), *ends)
        session.move(law, hand, _watch(line, described, samples))
        line.close()
    _tell_figures(figures(samples), _unit(described))
    if plot is not None:
        from runtime.cli.plot_drive import plot as draw

        draw(samples, plot, axis, _unit(described))


def _tell_figures(found: TuneFigures, unit: str) -> None:
    print(f"following error: at most {found.following_error:.4f} {unit}, RMS {found.following_error_rms:.4f} {unit}")
    if found.delay == found.delay:
        print(f"delay of the drive: {found.delay * 1000:.2f} ms")
        print(f"velocity: at most {found.velocity:.3f} {unit}/s, {found.overshoot:.1%} above the set-point")
    print(
        "torque: not told"
        if found.torque != found.torque
        else f"torque: at most {found.torque / 10:.1f} % of the rated one"
    )
