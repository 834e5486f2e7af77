"""The PLC process: `python -m runtime.scheduler.plc_process --machine FILE|demo --hli NAME --wake-fd N`.

It attaches to the HLI, loads the user's program, and runs one PLC cycle each time the cycle process raises the
eventfd N. It ends

- on SIGTERM, as soon as the machine is at rest and its cycle has ended: the PLC logs off (exit code 0);
- when the runtime has ended or died: at once, at the latest by the kernel's signal at the death of the parent (0);
- when the program cannot be loaded (3) or raises (4): the reason is in the HLI and on standard error, the PLC stays
logged on;
- when there is no HLI to attach to (5), or the machine description is wrong (6).
"""

from __future__ import annotations

import argparse
import contextlib
import os
import select
import signal
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from runtime.config.loader import DEMO_MACHINE, ConfigurationError, load_machine
from runtime.hli.errors import HliError
from runtime.hli.memory import HliMemory
from runtime.plc_logic.errors import PlcFailure
from runtime.plc_logic.exchange import ProgramExchange
from runtime.scheduler.children import die_with_parent, wait_until_raised
from runtime.scheduler.memory_pressure import PLC_SCORE, give_way, limit_growth
from runtime.scheduler.plc_program import LoadingBeside, load_host
from runtime.scheduler.realtime import RefusedError, set_priority
from runtime.scheduler.retained import state_directory

EXIT_LOAD, EXIT_RAISED, EXIT_NO_HLI, EXIT_CONFIGURATION = 3, 4, 5, 6
PLC_BELOW = 10  # priorities below the cycle
PATIENCE_MS = 200  # without a wake-up: look whether the runtime still lives


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the PLC until something ends it; returns the exit code."""
    options = _options(arguments)
    die_with_parent(signal.SIGKILL)  # user code that hangs would not see anything milder
    give_way(PLC_SCORE)
    stop = _StopRequest()
    try:
        path = DEMO_MACHINE if options.machine == "demo" else Path(options.machine)
        machine = load_machine(path)
    except ConfigurationError as error:
        return _complain(EXIT_CONFIGURATION, *(problem.explained() for problem in error.problems))
    wait_until_raised(options.begin, lambda: stop.asked)
    if stop.asked:
        return 0
    try:
        memory = HliMemory.attach(options.hli)
    except HliError as error:
        return _complain(EXIT_NO_HLI, error.problem.explained())
    with memory:
        limit_growth(machine.plc.memory)
        try:
            state = state_directory(machine.state_directory, os.environ)
            host = load_host(
                machine, path.parent, memory, time.perf_counter_ns, state=state / "plc", wall_ns=time.time_ns
            )
            host.start(int(memory.hli.head.time_ns_r))
        except PlcFailure as failure:
            return _complain(EXIT_LOAD, failure.problem.explained(), failure.trace)
        with contextlib.suppress(RefusedError):  # the cycle process has told that the host refuses it
            set_priority(max(machine.cycle.priority - PLC_BELOW, 1))
        try:
            exchange = ProgramExchange(host, memory.hli, lambda: LoadingBeside(machine, path.parent))
            _run(exchange, memory, options.wake_fd, stop)
        except PlcFailure as failure:
            return _complain(EXIT_RAISED, failure.problem.explained(), failure.trace)
        host.stop()
    return 0


class _StopRequest:
    """SIGTERM asks for an end with the runtime, which gets it too. SIGINT goes to the runtime only, which then stops the PLC."""

    def __init__(self) -> None:
        self.asked = False
        signal.signal(signal.SIGTERM, self._ask)
        signal.signal(signal.SIGINT, signal.SIG_IGN)

    def _ask(self, *_: object) -> None:
        self.asked = True


def _run(exchange: ProgramExchange, memory: HliMemory, wake_fd: int, stop: _StopRequest) -> None:
    """One PLC cycle per request of the CNC. Wake-ups that came while a cycle ran are one: the CNC counts the
    overrun."""
    head, platform = memory.hli.head, memory.hli.platform
    waiter = select.poll()
    waiter.register(wake_fd, select.POLLIN)
    has_run = False
    while not stop.asked or head.running_r:  # the machine brakes with its PLC
        if waiter.poll(PATIENCE_MS):
            os.eventfd_read(wake_fd)
            if platform.plc_cycle_request_r != platform.plc_cycle_done_w:
                exchange.cycle(int(head.time_ns_r))
        elif not memory.owner_alive:
            return
        has_run |= bool(head.running_r)
        if has_run and not head.running_r:
            return


def _options(arguments: Sequence[str] | None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(prog="plc_process", description="The PLC process of a Tandem runtime.")
    parser.add_argument("--machine", required=True, help="machine description, or demo")
    parser.add_argument("--hli", required=True, help="name of the runtime's shared memory")
    parser.add_argument("--wake-fd", required=True, type=int, help="eventfd that the runtime raises for each PLC cycle")
    parser.add_argument(
        "--begin", type=int, default=-1, help="eventfd that is raised when the shared memories are there"
    )
    return parser.parse_args(arguments)


def _complain(code: int, *texts: str) -> int:
    for text in texts:
        if text:
            print(text, file=sys.stderr, flush=True)
    return code


if __name__ == "__main__":
    sys.exit(main())
