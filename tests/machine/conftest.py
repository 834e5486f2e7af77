"""Tests on the whole machine in virtual time: NC text in, path and events out."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from runtime.config import load_machine
from runtime.config.machine import Machine
from runtime.scheduler.simulation import Result, Simulation

Run = Callable[..., Result]


@pytest.fixture(scope="session")
def demo() -> Machine:
    """The demo machine, with the watchdog of a PLC that has real-time privileges."""
    machine = load_machine(None)
    return machine.model_copy(update={"plc": machine.plc.model_copy(update={"watchdog": 0.05})})


@pytest.fixture
def program(tmp_path: Path) -> Callable[[str], Path]:
    """Write NC text into a file."""

    def write(text: str) -> Path:
        path = tmp_path / "test.nc"
        path.write_text(text)
        return path

    return write


@pytest.fixture
def ideal(demo: Machine) -> Simulation:
    """The demo machine with ideal axes and its PLC program."""
    return Simulation(demo, ideal_axes=True, samples=True)
