"""A running machine for each test, and its kernels compiled before."""

from __future__ import annotations

import os
from collections.abc import Iterator
from pathlib import Path

import pytest

import runtime.scheduler.all_kernels  # noqa: F401 - registers the warm-ups
from runtime.kernels import warm_up
from tests.system.running_machine import RunningMachine


@pytest.fixture(scope="session", autouse=True)
def compiled_kernels() -> None:
    """What a first start does is no part of what the tests wait for."""
    warm_up(everything=True)


@pytest.fixture
def machine(tmp_path: Path) -> Iterator[RunningMachine]:
    port = 40_000 + os.getpid() % 20_000
    running = RunningMachine(tmp_path, port)
    yield running
    if running.process is not None and running.process.poll() is None:
        running.process.kill()
        running.process.wait()
    for left in Path("/dev/shm").glob(f"{running.name}*"):
        left.unlink()


@pytest.fixture
def long_program(tmp_path: Path) -> Path:
    """Moves in X for a minute."""
    path = tmp_path / "long.nc"
    path.write_text("%LONG\nG90 G01 F3000\n$FOR P1 = 1, 20, 1\nX200\nX100\n$ENDFOR\nM30\n")
    return path
