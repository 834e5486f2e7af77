"""The simulated nodes as a process of their own, in real time, over UDP multicast: what `tandem run` does.

Nothing here is timed: the tests wait for states, with generous limits.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any

import can
import pytest
import yaml

from runtime.config.machine import Machine
from runtime.drives import DriveState
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import SimulatedNodes
from runtime.fieldbus.simulator.commands import CommandLines
from tests.fieldbus.rig import demo_description

PATIENCE = 20.0  # s


@pytest.fixture
def description() -> dict[str, Any]:
    """The demo machine on a port of its own, with a cycle that a busy computer can keep."""
    description = demo_description()
    options = {"hop_limit": 0, "port": 40_000 + os.getpid() % 20_000}
    bus = {"interface": "udp_multicast", "channel": "239.74.163.2", "options": options}
    description["fieldbus"]["bus"] = bus | {"heartbeat_timeout": "2 s", "boot_timeout": "15 s"}
    description["cycle"]["period"] = "5 ms"
    try:
        open_bus(Machine.model_validate(description).fieldbus.bus).shutdown()
    except FieldbusError as error:
        pytest.skip(f"no multicast here: {error}")
    return description


class Processes:
    """Starts simulators and ends them."""

    def __init__(self, file: Path) -> None:
        self.file = file
        self.running: list[subprocess.Popen[str]] = []

    def start(self, *arguments: str) -> subprocess.Popen[str]:
        command = [sys.executable, "-m", "runtime.fieldbus.simulator", "--machine", str(self.file), *arguments]
        process = subprocess.Popen(command, stderr=subprocess.PIPE, text=True)
        self.running.append(process)
        return process


@pytest.fixture
def processes(tmp_path: Path, description: dict[str, Any]) -> Iterator[Processes]:
    file = tmp_path / "machine.yaml"
    file.write_text(yaml.safe_dump(description), encoding="utf-8")
    processes = Processes(file)
    yield processes
    for process in processes.running:
        process.kill()
        process.communicate()


def cycle_until(master: CanopenMaster, period: float, condition: Callable[[], bool]) -> bool:
    end = time.monotonic() + PATIENCE
    while not condition():
        if time.monotonic() > end:
            return False
        master.read()
        master.write()
        time.sleep(period)
    return True


def test_two_processes_and_a_killed_one(processes: Processes, description: dict[str, Any], tmp_path: Path) -> None:
    machine = Machine.model_validate(description)
    state = tmp_path / "encoders"
    process = processes.start("--state", str(state), "--exit-with-parent")
    with open_bus(machine.fieldbus.bus) as bus:
        master = CanopenMaster(machine, bus, now=time.monotonic, idle=lambda: time.sleep(1e-4))
        image = master.image
        master.start()
        image.enable[:] = True
        period = machine.cycle.period
        assert cycle_until(master, period, lambda: bool((image.state == DriveState.OPERATION_ENABLED).all()))

        def arrived() -> bool:
            image.target_position[0] = min(image.target_position[0] + 0.5, 10.0)
            settled = abs(image.actual_velocity[0]) < 0.1  # not on its way through
            return bool(settled and abs(image.actual_position[0] - 10.0) < 1e-3)

        assert cycle_until(master, period, arrived)
        process.send_signal(signal.SIGKILL)
        assert cycle_until(master, period, lambda: bool((image.state == DriveState.OFFLINE).all()))
        master.stop()
        # the encoders are absolute: a new process knows where the axes stand
        second = processes.start("--state", str(state))
        master.start()
        assert image.actual_position[0] == pytest.approx(10.0, abs=2e-3)
        master.stop()
        second.send_signal(signal.SIGTERM)
        assert second.wait(PATIENCE) == 0


@pytest.mark.parametrize("content", [None, "axes: [", "name: x\nwrong_key: 1\n"])
def test_a_machine_description_that_cannot_be_read(tmp_path: Path, content: str | None) -> None:
    file = tmp_path / "machine.yaml"
    if content is not None:
        file.write_text(content, encoding="utf-8")
    command = [sys.executable, "-m", "runtime.fieldbus.simulator", "--machine", str(file)]
    result = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert result.returncode == 1
    assert result.stderr.startswith("simulator: ")
    assert "Traceback" not in result.stderr


def test_faults_are_taken_from_standard_input() -> None:
    machine = Machine.model_validate(demo_description())
    with can.Bus(interface="virtual", channel="commands") as bus:
        nodes = SimulatedNodes(machine, bus)
        nodes.step(0.0)
        reader, writer = os.pipe()
        commands = CommandLines(reader)
        commands.obey(nodes)  # nothing there: it does not wait
        os.write(writer, b"silent 2\ndrive 1 0x4310\nnonsense\nsil")
        commands.obey(nodes)
        assert nodes.drives[2].silent
        assert nodes.drives[1].values[0x603F, 0] == 0x4310
        os.write(writer, b"ent 3\nheal 2\n")
        commands.obey(nodes)
        assert nodes.drives[3].silent
        assert not nodes.drives[2].silent
        os.close(writer)
        commands.obey(nodes)  # nobody is there any more
        os.close(reader)
