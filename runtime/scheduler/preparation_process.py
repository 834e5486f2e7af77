"""The preparation process of one channel: `python -m runtime.scheduler.preparation_process`."""

from __future__ import annotations

import argparse
import os
import signal
import time
from datetime import datetime
from pathlib import Path
from types import FrameType

from runtime.cnc.motion_queue import MotionQueue
from runtime.cnc.path_preparation import PumpState
from runtime.cnc.preparation_link import PreparationLink
from runtime.config import load_machine
from runtime.hli.memory import HliMemory
from runtime.kernels import warm_up
from runtime.scheduler import names
from runtime.scheduler.children import die_with_parent, wait_until_raised
from runtime.scheduler.memory_pressure import PREPARATION_SCORE, give_way
from runtime.scheduler.offset_tables import machine_offsets
from runtime.scheduler.outside import RunningMachine
from runtime.scheduler.preparation import Preparation
from runtime.scheduler.tool_tables import machine_tools

_PAUSES = {  # s between two looks at the link; MORE: none
    PumpState.FULL: 0.001,
    PumpState.FLUSH: 0.002,
    PumpState.HELD: 0.002,
    PumpState.FINISHED: 0.01,  # no program: a hundred looks per second cost the processor next to nothing
}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--machine", type=Path)
    parser.add_argument("--name", required=True)
    parser.add_argument("--channel", type=int, default=0)
    parser.add_argument("--dialect", default="")
    parser.add_argument(
        "--begin", type=int, default=-1, help="eventfd that is raised when the shared memories are there"
    )
    arguments = parser.parse_args()
    die_with_parent()
    give_way(PREPARATION_SCORE)
    stopping = False

    def stop(_number: int, _frame: FrameType | None) -> None:
        nonlocal stopping
        stopping = True

    signal.signal(signal.SIGTERM, stop)
    machine = load_machine(arguments.machine)
    warm_up()
    wait_until_raised(arguments.begin, lambda: stopping)
    if stopping:
        return
    n_axes = len(machine.channels[arguments.channel].axes)
    queue = MotionQueue(n_axes, names.queue(arguments.name, arguments.channel), create=False)
    link = PreparationLink(n_axes, names.link(arguments.name, arguments.channel), create=False)
    memory = HliMemory.attach(arguments.name)
    outside = RunningMachine(machine, memory.hli, link, now=datetime.now)
    preparation = Preparation(
        machine,
        arguments.channel,
        queue,
        link,
        outside,
        tools=machine_tools(machine, os.environ),
        offsets=machine_offsets(machine, os.environ),
        dialect=arguments.dialect,
    )
    link.announce()
    while not stopping or (memory.hli.head.running_r and memory.owner_alive):  # one that is missing would be an alarm
        state = preparation.poll()
        if state in _PAUSES:
            time.sleep(_PAUSES[state])
    preparation.end()
    queue.close()
    link.close()
    memory.close()


if __name__ == "__main__":
    main()
