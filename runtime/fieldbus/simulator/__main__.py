"""The simulated nodes of a machine as a process of their own, in real time:

python -m runtime.fieldbus.simulator --machine FILE [--state FILE] [--exit-with-parent] [--commands]
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import os
import select
import signal
import sys
import time
from collections.abc import Callable, Mapping
from pathlib import Path
from types import FrameType

import can

from runtime.config import ConfigurationError, load_machine
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue.fieldbus import NODE_TAKEN
from runtime.fieldbus.bus import open_buses
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator.commands import CommandLines
from runtime.fieldbus.simulator.encoder import EncoderFile
from runtime.fieldbus.simulator.nodes import SimulatedBus, SimulatedNodes

LONGEST_WAIT = 0.01  # s; heartbeats, plant and signals are looked after at least this often
TAKEN_LIMIT = 2.0  # s that the nodes of a machine that is being switched off get to fall silent
ORPHAN_SILENCE = 1.0  # s without a frame, after which an orphan ends: the master may still be braking the axes
END_SILENCE = 0.2  # s, the same where SIGTERM went to all processes of the machine


def refuse_taken_nodes(machine: Machine, bus: can.BusABC, now: Callable[[], float], name: str = "") -> None:
    """Nodes of the same ids on one bus would answer for each other. Raises FieldbusError, can.CanError."""
    config = machine.fieldbus.all_buses()[name]
    nodes = [node for bus_name, node, _ in machine.drive_nodes if bus_name == name]
    nodes += [io.node for io in machine.fieldbus.io if (io.bus or "") == name]
    end, silent_since = now() + TAKEN_LIMIT, now()
    while now() < silent_since + 2.5 * config.heartbeat:
        message = bus.recv(LONGEST_WAIT)
        if message is None or message.arbitration_id - 0x700 not in nodes:
            continue
        silent_since = now()
        if silent_since > end:
            node = message.arbitration_id - 0x700
            raise FieldbusError(NODE_TAKEN, node=node, channel=config.channel)


def ready(nodes: SimulatedNodes, seconds: float) -> list[SimulatedBus]:
    """The buses from which a frame may be had, as soon as there is one, or after `seconds`."""
    buses = list(nodes.buses.values())
    waiting = select.select([bus.bus.fileno() for bus in buses], [], [], seconds)[0]
    return [bus for bus in buses if bus.bus.fileno() in waiting]


def serve(
    nodes: SimulatedNodes,
    now: Callable[[], float],
    stopped: Callable[[float], bool],
    step: float,
    commands: CommandLines | None = None,
) -> None:
    """Answer frames at once and step the time at least every `step` s, until `stopped(silence)`, where `silence` is how
    many seconds ago the last frame came. Raises can.CanError."""
    nodes.step(now())
    stepped = heard = now()
    while not stopped(stepped - heard):
        count = sum(bus.poll(now()) for bus in ready(nodes, step))
        if count:
            heard = now()
        if not count or now() - stepped >= step:
            stepped = now()
            nodes.step(stepped)
            if commands is not None:
                commands.obey(nodes)


def main(arguments: list[str] | None = None) -> int:
    """Exit status 0 after SIGTERM or SIGINT, 1 for an error told on standard error."""
    parser = argparse.ArgumentParser(
        prog="python -m runtime.fieldbus.simulator", description=(__doc__ or "").split(":")[0]
    )
    parser.add_argument("--machine", type=Path, required=True, help="machine description (YAML)")
    parser.add_argument("--state", type=Path, help="file that keeps the positions of the drives")
    parser.add_argument(
        "--exit-with-parent",
        action="store_true",
        help="end when the process that started this one has ended and the bus is silent",
    )
    parser.add_argument(
        "--commands", action="store_true", help="take faults as lines on standard input: silent 2, heal 2"
    )
    options = parser.parse_args(arguments)
    try:
        machine = load_machine(options.machine)
        encoders = EncoderFile(options.state) if options.state else None
        buses = open_buses(machine)
        try:
            for name, bus in buses.items():
                refuse_taken_nodes(machine, bus, time.monotonic, name)
        except FieldbusError:
            _close(buses)
            raise
    except (OSError, ConfigurationError, FieldbusError) as error:
        print(f"simulator: {error}", file=sys.stderr)
        return 1
    ended = False
    parent = os.getppid()

    def end(number: int, frame: FrameType | None) -> None:
        nonlocal ended
        ended = True

    signal.signal(signal.SIGTERM, end)
    signal.signal(signal.SIGINT, end)

    def stopped(silence: float) -> bool:
        if not options.exit_with_parent:
            return ended
        return silence > (END_SILENCE if ended else ORPHAN_SILENCE) and (ended or os.getppid() != parent)

    nodes = SimulatedNodes(machine, buses, encoders=encoders)
    with contextlib.suppress(OSError):  # real drives have processors of their own
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(max(machine.cycle.priority - 5, 1)))
    # the dictionaries are thousands of objects that live for ever: no need to look through them again and again
    gc.collect()
    gc.freeze()
    try:
        commands = CommandLines(sys.stdin.fileno()) if options.commands else None
        serve(nodes, time.monotonic, stopped, min(LONGEST_WAIT, 2 * machine.cycle.period), commands)
    except (can.CanError, OSError) as error:
        print(f"simulator: the bus is gone: {error}", file=sys.stderr)
        return 1
    finally:
        _close(buses)
        if encoders:
            encoders.close()
    return 0


def _close(buses: Mapping[str, can.BusABC]) -> None:
    for bus in buses.values():
        bus.shutdown()


if __name__ == "__main__":
    sys.exit(main())
