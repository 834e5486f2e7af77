"""The host of the PLC program that the machine description names."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import suppress
from pathlib import Path

from runtime.config.machine import Machine
from runtime.hli.describe import analogue_places, io_bits
from runtime.hli.memory import HliMemory
from runtime.plc_logic.errors import PlcFailure
from runtime.plc_logic.exchange import Loaded
from runtime.plc_logic.host import PlcHost, report_failure
from runtime.plc_logic.loader import load_program
from runtime.plc_logic.retained_variables import RetainJournal


def load_host(
    machine: Machine,
    directory: Path,
    memory: HliMemory,
    clock_ns: Callable[[], int] | None = None,
    *,
    state: Path | None = None,
    wall_ns: Callable[[], int] | None = None,
) -> PlcHost:
    """Load the program; files are looked for in `directory`, that of the machine description.

    `state`: folder of the retained variables; without it they live as long as the host. A failure is written into the
    HLI too. Raises PlcFailure.
    """
    assert machine.plc.program is not None
    try:
        program = load_program(machine.plc.program, directory)
    except PlcFailure as failure:
        report_failure(memory.hli, failure)
        raise
    inputs, outputs = io_bits(machine)
    watchdog_us = round(machine.plc.watchdog * 1e6)
    return PlcHost(
        program,
        memory,
        inputs,
        outputs,
        analogue_places(machine),
        watchdog_us=watchdog_us,
        clock_ns=clock_ns,
        journal=None if state is None else lambda: RetainJournal(state),
        wall_ns=wall_ns,
    )


def load_anew(machine: Machine, directory: Path) -> Loaded:
    """The program as its files are now, or why it cannot be loaded."""
    assert machine.plc.program is not None
    try:
        return load_program(machine.plc.program, directory, anew=True)
    except PlcFailure as failure:
        return failure


class LoadingBeside:
    """Loads the program anew in a thread of ordinary priority, while the PLC cycles go on; called, it tells the result."""

    def __init__(self, machine: Machine, directory: Path) -> None:
        self._loaded: Loaded | None = None
        self._thread = threading.Thread(target=self._work, args=(machine, directory), name="reload", daemon=True)
        self._thread.start()

    def _work(self, machine: Machine, directory: Path) -> None:
        with suppress(OSError, PermissionError):  # a thread begins with the priority of who starts it
            os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        self._loaded = load_anew(machine, directory)

    def __call__(self) -> Loaded | None:
        return self._loaded
