"""The real processes of a machine, in real time. Limits are wide: the host may be busy with other things."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import urllib.request
from collections.abc import Callable
from pathlib import Path

import yaml

from runtime.config.loader import DEMO_MACHINE
from runtime.hli.alarms import AlarmLine, alarm_lines
from runtime.hli.errors import HliError
from runtime.hli.layout import Mode, State
from runtime.hli.memory import HliMemory

LIMIT = 60.0  # s for anything to happen at all

MODULES = {
    "cycle": "runtime.scheduler.cycle_process",
    "preparation": "runtime.scheduler.preparation_process",
    "PLC": "runtime.scheduler.plc_process",
    "drives": "runtime.fieldbus.simulator",
    "service": "runtime.cli.main",
}


class RunningMachine:
    """`tandem run` on a copy of the demo machine, under a name, a bus and a state directory of its own."""

    def __init__(self, folder: Path, port: int) -> None:
        self.name = f"tandem-test-{os.getpid()}-{port}"
        self.state = folder / "state"
        description = yaml.safe_load(DEMO_MACHINE.read_text())
        description["fieldbus"]["bus"]["options"]["port"] = port
        description["fieldbus"]["bus"]["heartbeat_timeout"] = "2 s"
        description["plc"]["watchdog"] = "300 ms"
        description["metrics"] = {"port": 0}
        description["state_directory"] = str(self.state)
        self.machine = folder / "machine.yaml"
        self.machine.write_text(yaml.safe_dump(description))
        self.log = folder / "log.txt"
        self.process: subprocess.Popen[bytes] | None = None
        self._memory: HliMemory | None = None

    def start(self, *arguments: str, drives: bool = True) -> None:
        """`drives`: simulated ones, else nobody is on the bus."""
        chosen = ["--simulated-drives"] if drives else []
        with self.log.open("ab") as log:
            self.process = subprocess.Popen(
                [sys.executable, "-m", "runtime.cli.main", "run", "-c", str(self.machine), "--name", self.name,
                 *chosen, *arguments],
                stdout=log, stderr=log, stdin=subprocess.DEVNULL,
            )  # fmt: skip

    def wait_for(self, condition: Callable[[], bool], what: str) -> None:
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                raise AssertionError(
                    f"{what} did not happen within {LIMIT} s; the log says:\n{self.log.read_text()[-4000:]}"
                )
            time.sleep(0.02)

    @property
    def memory(self) -> HliMemory:
        """The HLI of the machine, as soon as its cycle runs."""
        if self._memory is None:
            self.wait_for(self._attach, "the start of the cycle")
        assert self._memory is not None
        return self._memory

    def _attach(self) -> bool:
        try:
            memory = HliMemory.attach(self.name)
        except HliError:
            return False
        if not memory.hli.head.running_r:
            memory.close()
            return False
        self._memory = memory
        return True

    @property
    def alarms(self) -> list[AlarmLine]:
        return alarm_lines(self.memory.hli)

    def has_alarm(self, number: int) -> bool:
        return any(alarm.id == number for alarm in self.alarms)

    def channel_state(self) -> State:
        return State(self.memory.hli.channels[0].control.mode_and_state.state_r)

    def x(self) -> int:
        return int(self.memory.hli.axes[0].status.actual_position_r)

    def order(self, program: Path) -> None:
        hli = self.memory.hli
        self.wait_for(
            lambda: (
                hli.platform.plc_running_r and all(hli.axes[i].status.ready_for_control_loop_on_r for i in range(4))
            ),
            "drives and PLC ready",
        )
        order = hli.operator[0].order_w
        order.to_mode, order.to_state, order.parameter = Mode.AUTOMATIC, State.ACTIVE, str(program).encode()
        hli.operator[0].order_semaphor_rw = True

    def reset(self) -> None:
        self.memory.hli.operator[0].reset_rw = True

    def pid_of(self, process: str) -> int:
        """Process id of a part of the machine, by its command line."""
        if process == "service":
            assert self.process is not None
            return self.process.pid
        for entry in Path("/proc").iterdir():
            if not entry.name.isdigit():
                continue
            try:
                line = (entry / "cmdline").read_bytes().decode().split("\0")
            except OSError:
                continue
            if MODULES[process] in line and (self.name in line or str(self.machine) in line):
                return int(entry.name)
        raise AssertionError(f"no {process} process")

    def scrape(self) -> str:
        self.wait_for(lambda: "metrics on " in self.log.read_text(), "the metrics endpoint")
        url = self.log.read_text().split("metrics on ")[1].split()[0]
        with urllib.request.urlopen(url, timeout=10) as answer:
            return str(answer.read().decode())

    def stop(self) -> int:
        """SIGTERM, as systemd does; the exit code."""
        assert self.process is not None
        if self.process.poll() is None:
            self.process.send_signal(signal.SIGTERM)
        code = self.process.wait(LIMIT)
        if self._memory is not None:
            self._memory.close()
            self._memory = None
        return code
