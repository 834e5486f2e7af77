"""The PLC program inside the simulation: the same host as in the PLC process, called when its cycle is due."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

from runtime.config.machine import Machine
from runtime.hli.memory import HliMemory
from runtime.plc_logic.errors import PlcFailure
from runtime.plc_logic.exchange import Loaded, ProgramExchange
from runtime.plc_logic.host import PlcHost
from runtime.scheduler.plc_program import load_anew, load_host

_EPOCH_NS = 1_000_000_000_000_000_000  # the wall clock of the virtual machine starts here


class InlinePlc:
    """A PLC partner in the same process and in virtual time. A program that failed stays silent until it is restarted."""

    def __init__(self, machine: Machine, memory: HliMemory, base: Path | None) -> None:
        self._machine = machine
        self._memory = memory
        self._base = base
        self._host: PlcHost | None = None
        self._exchange: ProgramExchange | None = None
        self._failed = False
        self._now_ns = 0
        self.frozen = False  # for tests: as if the process were stopped

    @property
    def host(self) -> PlcHost:
        """The host of the running program; made at the first wake, when the HLI knows the machine's names."""
        assert self._host is not None
        return self._host

    def wake(self, time: float) -> None:
        if self._failed or self.frozen:
            return
        time_ns = self._now_ns = int(time * 1e9)
        try:
            if self._host is None:
                self._host = load_host(
                    self._machine, self._base or Path(), self._memory, wall_ns=lambda: _EPOCH_NS + self._now_ns
                )
                self._host.start(time_ns)
                self._exchange = ProgramExchange(self._host, self._memory.hli, self._load)
            assert self._exchange is not None
            self._exchange.cycle(time_ns)
        except PlcFailure:  # the host has told the HLI why
            self._failed = True

    def _load(self) -> Callable[[], Loaded | None]:
        loaded = load_anew(self._machine, self._base or Path())
        return lambda: loaded

    def restart(self) -> None:
        self._host = None
        self._failed = False
