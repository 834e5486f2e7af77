"""`tandem hli`: look into the HLI of a running machine, and give orders as its operator."""

from __future__ import annotations

import json
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Annotated

import typer
from rich.console import Console, Group
from rich.live import Live
from rich.markup import escape
from rich.table import Table
from rich.text import Text

from runtime.cli.search_place import HELP, search_order
from runtime.config.loader import load_machine
from runtime.diagnostics.errors import Severity
from runtime.drives import DriveMode, DriveState
from runtime.hli.alarms import alarm_lines
from runtime.hli.client import HliClient, mode_name, state_name, stop_conditions
from runtime.hli.header import c_header
from runtime.hli.layout import Axis, Channel, Hli, ManualMode, ManualState, SearchState, State
from runtime.hli.memory import HliMemory, get_text
from runtime.hli.operator import Operator
from runtime.hli.units import LENGTH, PERCENT, RAPID, REV_PER_MIN, SPEED

SPINDLE = 4  # axis_type_r
KEY_PAUSE = 0.1  # s between two presses of a key that is held
BEGIN_PATIENCE = 1.0  # s in which a program that cannot begin says so
BEGIN_LOOK = 0.02

app = typer.Typer(
    help="Look into the interface memory of a running machine, and command it.",
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_enable=False,
)
command = typer.Typer(help="Order something as the operator.", no_args_is_help=True, pretty_exceptions_enable=False)
app.add_typer(command, name="command")

Name = Annotated[str, typer.Option("--name", help="Name of the runtime (its shared memory).")]
Switch = Annotated[str, typer.Argument(metavar="on|off")]


@app.callback()
def _common(
    config: Annotated[
        Path | None,
        typer.Option("-c", "--config", help="Machine description; checked, nothing else: the HLI tells itself."),
    ] = None,
    dialect: Annotated[str, typer.Option(help="As for the other commands; without effect here.")] = "isg",
) -> None:
    """Look into the interface memory of a running machine, and command it."""
    if config is not None:
        load_machine(config)


# --------------------------------------------------------------------------------------------- look


@app.command()
def watch(
    name: Name = "tandem",
    once: Annotated[bool, typer.Option("--once", help="Print one picture and end.")] = False,
    as_json: Annotated[bool, typer.Option("--json", help="Print everything as JSON (one object per picture).")] = False,
    interval: Annotated[float, typer.Option(help="Seconds between two pictures.", min=0.02)] = 0.2,
) -> None:
    """Show state, positions and alarms, live; ends with Ctrl+C or with the runtime."""
    with HliClient(name) as client:
        if as_json:
            while True:
                snapshot = client.snapshot()
                print(json.dumps(snapshot), flush=True)
                if once or not snapshot["running"]:
                    return
                time.sleep(interval)
        if once:
            Console().print(picture(client.hli, client.running, client.starting))
            return
        with Live(picture(client.hli, client.running, client.starting), refresh_per_second=1 / interval) as live:
            while client.running or client.starting:
                time.sleep(interval)
                live.update(picture(client.hli, client.running, client.starting))


@app.command()
def show(
    path: Annotated[str, typer.Argument(help="Element, such as channels.0.status or axes.X; empty: everything.")] = "",
    name: Name = "tandem",
) -> None:
    """Print an element and everything below it as JSON, in mm, degrees, seconds and percent."""
    with HliClient(name) as client:
        print(json.dumps(client.element(path), indent=2, ensure_ascii=False))


@app.command()
def header(
    output: Annotated[Path | None, typer.Option("--output", "-o", help="File; default: standard output.")] = None,
) -> None:
    """Print the C header of the interface, for programs in other languages."""
    if output is None:
        print(c_header(), end="")
    else:
        output.write_text(c_header())


def picture(hli: Hli, running: bool, starting: bool = False) -> Group:
    """The tables of `tandem hli watch`."""
    head = hli.head
    if running:
        state = "[green]running[/]"
    elif starting:
        state = "[yellow]starting[/]"
    else:
        state = "[red]not running: the runtime has ended, these are its last values[/]"
    title = f"[bold]{escape(get_text(head, 'machine_name_r') or 'tandem')}[/] {state}  cycle {head.cycle_r}"
    parts: list[Table | Text] = [Text.from_markup(title)]
    parts += [_channel_table(hli.channels[i]) for i in range(head.channels_r)]
    parts.append(_axis_table([hli.axes[i] for i in range(head.axes_r)]))
    if hli.platform.plc_error_id_w:
        parts.append(Text(f"PLC stands: {get_text(hli.platform, 'plc_error_text_w')}", style="red"))
    parts.append(_alarm_table(hli))
    return Group(*parts)


def _channel_table(channel: Channel) -> Table:
    status, modes = channel.status, channel.control.mode_and_state
    table = Table(show_header=False, box=None, pad_edge=False)
    waits = ", ".join(stop_conditions(status.stop_condition_r))
    program = f"{get_text(status, 'program_name_r') or '-'}  line {status.line_r}"
    ordered = "rapid" if status.command_feed_r == RAPID else f"{status.command_feed_r * SPEED * 60:.0f}"
    rows = {
        "channel": f"{get_text(channel, 'name_r')}  {mode_name(modes.mode_r)} {state_name(modes.state_r)}",
        "program": program + (f"  N{status.block_number_r}" if status.block_number_r >= 0 else ""),
        "feed": f"{status.active_feed_r * SPEED * 60:.0f} of {ordered} mm/min, "
        f"override {status.active_override_r * PERCENT:.0f} %",
        "path": f"{status.path_position_r * LENGTH:.3f} mm, block {status.covered_distance_r * PERCENT:.0f} %",
        "waits for": waits or "-",
        "functions": f"{status.waiting_functions_r} not acknowledged"
        + (f", error {status.error_id_r}" if status.error_id_r else ""),
    }
    by_hand = [hand for hand in status.hb_display_r if hand.state_r != ManualState.OFF]
    if by_hand:
        rows["by hand"] = ", ".join(
            f"{ManualMode(hand.operation_mode_r).name.lower()} {hand.control_element_r}: {hand.offset_r * LENGTH:.3f}"
            for hand in by_hand
        )
    if status.block_search_state_r:
        rows["block search"] = SearchState(status.block_search_state_r).name.lower().replace("_", " ")
    if status.machine_locked_r:
        rows["axes"] = "locked: nothing moves"
    for label, text in rows.items():
        table.add_row(f"[dim]{label}[/]", escape(text))
    return table


# 0: the drive does not tell it
_USUAL = (0, DriveMode.CYCLIC_SYNCHRONOUS_POSITION)


def _mode_text(mode: int) -> str:
    try:
        return DriveMode(mode).name.lower().replace("_", " ")
    except ValueError:
        return f"mode {mode}"


def _axis_table(axes: list[Axis]) -> Table:
    table = Table("axis", "actual", "commanded", "lag", "velocity", "drive")
    for axis in axes:
        status, spindle = axis.status, axis.spindle
        name = get_text(axis, "name_r")
        state = DriveState(status.drive_state_r).name.lower().replace("_", " ")
        if status.drive_mode_r not in _USUAL:  # it moves the axis by itself
            state += ", " + _mode_text(status.drive_mode_r)
        drive = f"{state}, {status.fault_code_r:#06x}" if status.fault_code_r else state
        if axis.axis_type_r == SPINDLE:
            actual, commanded = (
                f"{v * REV_PER_MIN:.0f} rev/min" for v in (spindle.actual_speed_r, spindle.command_speed_r)
            )
            reached = "at speed" if spindle.rev_erreicht_r else "standing" if spindle.rev_null_r else ""
            table.add_row(name, actual, commanded, "", reached, drive)
            continue
        positions = (status.actual_position_r, status.command_position_r, status.position_lag_r)
        values = [f"{value * LENGTH:.4f}" for value in positions]
        table.add_row(name, *values, f"{status.actual_velocity_r * SPEED:.2f}", drive)
    return table


def _alarm_table(hli: Hli) -> Table:
    table = Table("id", "line", "alarm", box=None)
    for alarm in alarm_lines(hli)[:8]:
        style = "red" if alarm.active else "dim"
        table.add_row(str(alarm.id), str(alarm.line or ""), escape(alarm.text), style=style)
    return table


# --------------------------------------------------------------------------------------------- command


def _operate(name: str, action: Callable[[Operator], None]) -> None:
    with HliMemory.attach(name) as memory:
        action(Operator(memory, time.sleep))


def _begin(name: str, action: Callable[[Operator], None]) -> None:
    """`_operate` for what begins a program: if that fails at once, say why and exit with 1."""
    with HliMemory.attach(name) as memory:
        hli = memory.hli
        channel = hli.channels[0]
        before = int(hli.alarm_count_r)
        action(Operator(memory, time.sleep))
        end = time.monotonic() + BEGIN_PATIENCE
        while time.monotonic() < end and not channel.status.line_r:
            if channel.control.mode_and_state.state_r == State.ERROR:
                new = [line for line in alarm_lines(hli) if line.sequence > before and line.severity >= Severity.ERROR]
                for line in reversed(new):
                    print(f"{line.id}: {line.text}", file=sys.stderr)
                raise typer.Exit(1)
            time.sleep(BEGIN_LOOK)


def _on(switch: str) -> bool:
    if switch not in ("on", "off"):
        raise typer.BadParameter("say on or off")
    return switch == "on"


Passes = Annotated[int, typer.Option(help="How often the block is come to, in loops and subprograms.", min=1)]
Feed = Annotated[float, typer.Option("--return-feed", help="mm/min on the way back; default: as the motion.", min=0.0)]
Automatic = Annotated[
    bool, typer.Option("--automatic", help="Go back to the contour and on without waiting for continue.")
]


@command.command()
def start(
    program: Annotated[str, typer.Argument(help="NC program.")],
    at: Annotated[str, typer.Option("--at", help=HELP)] = "",
    passes: Passes = 1,
    subprogram: Annotated[str, typer.Option("--in", help="File of the subprogram that the place is in.")] = "",
    covered: Annotated[float, typer.Option(help="Percent of the first motion to leave out.", min=0.0, max=100.0)] = 0.0,
    feed: Feed = 0.0,
    automatic: Automatic = False,
    name: Name = "tandem",
) -> None:
    """Start an NC program. A file of this folder is given with its full path, other names are the runtime's.

    With --at it is entered in the middle (block search): what comes before is computed and not moved. Move the axes by hand
    then, if need be; continue lets them go back to the contour, and the next continue lets the program go on.
    """
    file = Path(program)
    path = str(file.resolve()) if file.is_file() else program
    search = search_order(at, passes, subprogram, covered, feed, automatic=automatic) if at else None
    _begin(name, lambda operator: operator.start(path, search))


@command.command()
def restart(feed: Feed = 0.0, automatic: Automatic = False, name: Name = "tandem") -> None:
    """Go on with the program that was interrupted, where it was; also after the power was off. See `start --at`."""
    search = search_order("", feed=feed, automatic=automatic)
    _begin(name, lambda operator: print(operator.restart(search)))


@command.command()
def stop(name: Name = "tandem") -> None:
    """Stop on the path and end the program."""
    _operate(name, lambda operator: operator.stop())


@command.command()
def reset(name: Name = "tandem") -> None:
    """Reset the channel."""
    _operate(name, lambda operator: operator.reset())


@command.command()
def hold(name: Name = "tandem") -> None:
    """Feed hold: stop on the path, keep the position."""
    _operate(name, lambda operator: operator.hold())


@command.command()
def resume(name: Name = "tandem") -> None:
    """Take the feed hold back."""
    _operate(name, lambda operator: operator.resume())


@command.command()
def override(percent: Annotated[float, typer.Argument(min=0, max=200)], name: Name = "tandem") -> None:
    """Set the feed override in percent."""
    _operate(name, lambda operator: operator.override(percent))


@command.command("single-block")
def single_block(switch: Switch, name: Name = "tandem") -> None:
    """Stop after every block."""
    on = _on(switch)
    _operate(name, lambda operator: operator.single_block(on))


@command.command("optional-stop")
def optional_stop(switch: Switch, name: Name = "tandem") -> None:
    """Let M01 stop."""
    on = _on(switch)
    _operate(name, lambda operator: operator.optional_stop(on))


@command.command()
def backward(switch: Switch, name: Name = "tandem") -> None:
    """Drive the path backward, as far as it is kept (backward_storage of the channel); off: forward again."""
    on = _on(switch)
    _operate(name, lambda operator: operator.backward(on))


@command.command("simulate-motion")
def simulate_motion(switch: Switch, name: Name = "tandem") -> None:
    """Leave out the sections of #OPTIONAL EXECUTION."""
    on = _on(switch)
    _operate(name, lambda operator: operator.simulate_motion(on))


@command.command("continue")
def continue_motion(name: Name = "tandem") -> None:
    """Go on after M00, M01 or a single block."""
    _operate(name, lambda operator: operator.continue_motion())


@command.command()
def mdi(
    blocks: Annotated[list[str], typer.Argument(help="NC blocks, each one argument in quotes.")], name: Name = "tandem"
) -> None:
    """Execute NC blocks (MDI)."""
    _begin(name, lambda operator: operator.execute("\n".join(blocks)))


@command.command()
def manual(name: Name = "tandem") -> None:
    """Select manual mode: jog moves the axes then; `stop` ends it."""
    _operate(name, lambda operator: operator.manual())


@command.command()
def home(
    blocks: Annotated[list[str] | None, typer.Argument(help='Such as "G74 Z1 X2 Y2"; nothing: program rpf.nc.')] = None,
    name: Name = "tandem",
) -> None:
    """Home axes."""
    _operate(name, lambda operator: operator.home("\n".join(blocks or [])))


@command.command()
def jog(
    axis: Annotated[str, typer.Argument(help="Axis and direction: X+, Y-.")],
    seconds: Annotated[float, typer.Option(help="How long the key is pressed.", min=0.0)] = 1.0,
    step: Annotated[float, typer.Option(help="One increment of this width instead, mm or degrees.", min=0.0)] = 0.0,
    velocity: Annotated[float, typer.Option(help="mm/s or degrees/s; default: as it was.", min=0.0)] = 0.0,
    name: Name = "tandem",
) -> None:
    """Move an axis by its key, in manual mode. The axis stops when this command ends, however it ends."""
    with HliMemory.attach(name) as memory:
        key, number = _key_of(memory.hli, axis[:-1])
        direction = {"+": 1, "-": -1}.get(axis[-1:])
        if direction is None:
            raise typer.BadParameter(f"{axis!r}: say the axis and a direction, such as X+")
        operator = Operator(memory, time.sleep)
        unit = "jog_parameter" if step else "continuous_parameter"
        if step or velocity:
            operator.jog_parameter(unit, number, step, velocity)
        operator.link(number, key, ManualMode.INCREMENTAL if step else ManualMode.CONTINUOUS)
        operator.press(key, 0)
        time.sleep(KEY_PAUSE)
        end = time.monotonic() + seconds
        try:
            while True:
                operator.press(key, direction)
                left = end - time.monotonic()
                if step or left <= 0.0:
                    break
                time.sleep(min(left, KEY_PAUSE))
        finally:
            if step:
                time.sleep(KEY_PAUSE)
            operator.press(key, 0)


def _key_of(hli: Hli, axis: str) -> tuple[int, int]:
    """The key pair and the logical number of a path axis: pair 1 is that of the first one, and so on."""
    channel = hli.channels[0]
    names = [get_text(hli.axes[channel.axis_index_r[k]], "name_r") for k in range(channel.axis_count_r)]
    if axis not in names:
        raise typer.BadParameter(f"there is no axis {axis!r}; there are {', '.join(names)}")
    k = names.index(axis)
    return k + 1, int(hli.axes[channel.axis_index_r[k]].log_ax_n_r)


@command.command("machine-lock")
def machine_lock(switch: Switch, name: Name = "tandem") -> None:
    """From the next program start on, no axis moves; functions and spindles do."""
    on = _on(switch)
    _operate(name, lambda operator: operator.machine_lock(on))
