"""The simulated nodes of a machine as a process of their own, in real time:

python -m runtime.fieldbus.simulator --machine FILE [--state FILE] [--exit-with-parent]
"""

from __future__ import annotations

import argparse
import contextlib
import gc
import os
import signal
import sys
import time
from collections.abc import Callable
from pathlib import Path
from types import FrameType

import can

from runtime.config import ConfigurationError, load_machine
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator.encoder import EncoderFile
from runtime.fieldbus.simulator.nodes import SimulatedNodes

LONGEST_WAIT = 0.01  # s; heartbeats, plant and signals are looked after at least this often


def serve(
    nodes: SimulatedNodes, bus: can.BusABC, now: Callable[[], float], stopped: Callable[[], bool], step: float
) -> None:
    """Answer frames at once and step the time at least every `step` s, until `stopped()`. Raises can.CanError."""
    nodes.step(now())
    stepped = now()
    while not stopped():
        message = bus.recv(step)
        if message is not None:
            nodes.receive(message, now())
        if message is None or now() - stepped >= step:
            stepped = now()
            nodes.step(stepped)


def main(arguments: list[str] | None = None) -> int:
    """Exit status 0 after SIGTERM or SIGINT, 1 for an error told on standard error."""
    parser = argparse.ArgumentParser(
        prog="python -m runtime.fieldbus.simulator", description=(__doc__ or "").split(":")[0]
    )
    parser.add_argument("--machine", type=Path, required=True, help="machine description (YAML)")
    parser.add_argument("--state", type=Path, help="file that keeps the positions of the drives")
    parser.add_argument(
        "--exit-with-parent", action="store_true", help="end when the process that started this one ends"
    )
    options = parser.parse_args(arguments)
    try:
        machine = load_machine(options.machine)
        encoders = EncoderFile(options.state) if options.state else None
        bus = open_bus(machine.fieldbus.bus)
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

    def stopped() -> bool:
        return ended or (options.exit_with_parent and os.getppid() != parent)

    nodes = SimulatedNodes(machine, bus, encoders=encoders)
    with contextlib.suppress(OSError):  # real drives have processors of their own
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(max(machine.cycle.priority - 5, 1)))
    # the dictionaries are thousands of objects that live for ever: no need to look through them again and again
    gc.collect()
    gc.freeze()
    try:
        serve(nodes, bus, time.monotonic, stopped, min(LONGEST_WAIT, 2 * machine.cycle.period))
    except (can.CanError, OSError) as error:
        print(f"simulator: the bus is gone: {error}", file=sys.stderr)
        return 1
    finally:
        bus.shutdown()
        if encoders:
            encoders.close()
    return 0


if __name__ == "__main__":
    sys.exit(main())
