"""`tandem run`: the machine in real time, until it is stopped or the demo program has ended."""

from __future__ import annotations

import contextlib
import os
import signal
import sys
import time
from pathlib import Path
from types import FrameType
from typing import TYPE_CHECKING, Annotated

import typer

from runtime.cli import INTERRUPTED
from runtime.cli.dialect_option import DialectOption

if TYPE_CHECKING:
    from runtime.config.machine import Machine
    from runtime.scheduler.session import Session

_POLL = 0.1  # s between two looks at the machine
_PICTURE = 0.02  # s between the points of a picture
_TELL_EVERY = 1.0  # s between two lines of state
DEMO_PROGRAM = Path(__file__).parents[1] / "demo" / "plate.nc"


def command(
    config: Annotated[
        Path | None, typer.Option("--config", "-c", help="Machine description; default: the built-in demo machine.")
    ] = None,
    dialect: DialectOption = "",
    name: Annotated[str, typer.Option(help="Name of the runtime: that of its shared memory.")] = "tandem",
    program: Annotated[
        Path | None, typer.Option(help="Start this program as soon as the machine is ready, and end with it.")
    ] = None,
    demo: Annotated[bool, typer.Option("--demo", help="Mill the built-in program on the built-in machine.")] = False,
    simulated_drives: Annotated[
        bool,
        typer.Option("--simulated-drives", help="Put simulated drives on the machine's bus, as the demo machine has."),
    ] = False,
    start_limit: Annotated[
        float, typer.Option(help="Seconds that each step of the start may take; longer on a slow computer.", min=1.0)
    ] = 60.0,
    plot: Annotated[
        Path | None, typer.Option(help="At the end of the program draw the path of the axes into this PNG file.")
    ] = None,
    verbose: Annotated[bool, typer.Option("--verbose", help="Tell every event, not only what is wrong.")] = False,
) -> None:
    """Run the machine in real time until stopped (SIGTERM, Ctrl-C); the axes are brought to rest first."""
    from runtime.cli.preparing import compile_kernels
    from runtime.cnc.decoder import ProgramError, expect_dialect
    from runtime.config import load_machine
    from runtime.diagnostics.catalogue.language import FILE_MISSING
    from runtime.diagnostics.errors import Place
    from runtime.scheduler.journal import NativeJournal, open_journal
    from runtime.scheduler.session import Session
    from runtime.scheduler.supervisor import RunOptions, SupervisorError

    if demo and config is not None:
        raise typer.BadParameter("--demo brings its own machine; leave -c out, or start a program with --program")
    if demo:
        program = program or DEMO_PROGRAM
        plot = plot or Path("tandem-demo.png")
    if dialect:
        expect_dialect(dialect)
    if program is not None and not program.is_file():
        raise ProgramError(FILE_MISSING, Place(file=str(program)), file=program)
    if plot is not None:
        plot.open("ab").close()  # fails now, not after the program
    machine = load_machine(config)
    compile_kernels()
    options = RunOptions(config, name, dialect, simulated_drives or config is None, start_limit)
    journal = open_journal(os.environ, sys.stderr, verbose=verbose)
    session = Session(machine, options, journal)
    to_a_reader = not isinstance(journal, NativeJournal)  # the journal has events, it needs no line per second
    stop = False

    def ask_to_stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal stop
        stop = True

    for number in (signal.SIGTERM, signal.SIGINT, signal.SIGHUP):  # service manager, Ctrl-C, terminal closed
        signal.signal(number, ask_to_stop)
    _say(f"starting {machine.name}: {len(machine.axes)} axes, bus {machine.fieldbus.bus.interface}")
    started = False
    try:
        session.start()
        started = True
        if session.supervisor.metrics_port:
            _say(f"metrics on http://{machine.metrics.host}:{session.supervisor.metrics_port}/metrics")
        if program is not None:
            session.start_program(program.resolve())
        tell_at = 0.0
        while not stop and session.poll():
            if program is not None and session.program_done:
                break
            now = time.monotonic()
            if to_a_reader and now >= tell_at:
                tell_at = now + _TELL_EVERY
                _say(session.state_line())
            time.sleep(_POLL if plot is None else _PICTURE)
    except SupervisorError:
        if not stop:  # else the cycle was told to end as well, before it had begun
            raise
    finally:
        code = session.stop()
    if stop and not started:
        code = 0
    if program is not None:
        code = _summary(session, machine, program, plot) or code
        if stop and not session.program_done:
            code = INTERRUPTED
    raise typer.Exit(code)


def _summary(session: Session, machine: Machine, program: Path, plot: Path | None) -> int:
    result = session.result()
    _say("")
    _say(f"{program.name}: {result.outcome}, {result.time:.2f} s, {result.path_length / 1000.0:.3f} m of path")
    _say("end position " + "  ".join(f"{name} {value:.3f}" for name, value in result.positions.items()))
    for function, count in sorted(result.functions.items()):
        _say(f"  {function} × {count}")
    _say(
        f"cycles {result.cycles}, overruns {result.overruns}, work time median {result.work_median_us:.0f} µs, "
        f"99 % below {result.work_p99_us:.0f} µs; PLC overruns {result.plc_overruns}"
    )
    for text in result.alarms:
        _say(f"alarm {text}")
    if plot is not None and len(session.rapid) > 1:
        from runtime.cli.plot import plot_path

        title = f"{program.name} on {machine.name}"
        plot_path(plot, session.samples, session.rapid, machine.channels[0].axes, title)
        _say(f"picture of the path: {plot}")
    return 0 if result.good else 1


def _say(text: str) -> None:
    with contextlib.suppress(OSError):  # nobody listens any more: no reason to stop a machine
        print(text, file=sys.stderr, flush=True)
