"""The machine under test inside the guest: the runtime on can0, its simulated drives on can1, each a process of its own."""

from __future__ import annotations

import copy
import signal
import subprocess
import sys
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import yaml

from runtime.config.loader import DEMO_MACHINE
from runtime.hli.alarms import alarm_lines
from runtime.hli.errors import HliError
from runtime.hli.layout import State
from runtime.hli.memory import HliMemory
from runtime.hli.operator import Operator, OrderRefusedError

LIMIT: Final = 400.0  # s for anything to happen at all
PERIOD_MS: Final = 20  # an emulated processor is slow
NAME: Final = "tandem-vm"


class NotHappenedError(Exception):
    """Something that had to happen did not."""


def description(channel: str) -> dict[str, Any]:
    """The demo machine on a CAN interface, with a cycle that the emulator keeps."""
    machine: dict[str, Any] = copy.deepcopy(yaml.safe_load(DEMO_MACHINE.read_text()))
    # Below the interrupt threads of a PREEMPT_RT kernel (50): an emulator that is late in every cycle would leave them no time.
    machine["cycle"] = {"period": f"{PERIOD_MS} ms", "priority": 40}
    machine["fieldbus"]["bus"] = {
        "interface": "socketcan", "channel": channel, "heartbeat": "200 ms", "heartbeat_timeout": "5 s",
        "boot_timeout": "30 s",
    }  # fmt: skip
    for axis in machine["axes"]:
        axis["following_error"] = 500.0  # an emulator on a busy host is late by many cycles: no lag is judged here
    machine["plc"] |= {"every": 4, "watchdog": "3 s"}
    machine["state_directory"] = "/run/tmp/state"
    return machine


def on_two_buses(channel: str, fast: str) -> dict[str, Any]:
    """The same with Y and Z on a second bus, of CAN FD, where Y has the number that X has on the first one."""
    machine = description(channel)
    machine["fieldbus"]["buses"] = {"fast": {**machine["fieldbus"]["bus"], "channel": fast, "fd": True}}
    machine["axes"][1]["drive"] |= {"bus": "fast", "node": machine["axes"][0]["drive"]["node"]}
    machine["axes"][2]["drive"] |= {"bus": "fast"}
    machine["state_directory"] += "-two-buses"  # a machine of its own: its axes have never stood elsewhere
    return machine


class GuestMachine:
    """Starts and ends the processes; what they print goes to `folder`."""

    def __init__(
        self, folder: Path, master: dict[str, Any] | None = None, drives: dict[str, Any] | None = None, name: str = NAME
    ) -> None:
        """`master`, `drives`: the machine as either side sees it, by default on the two cards; `name` of runtime and files."""
        self.folder = folder
        self.name = name
        self.described = {"master": master or description("can0"), "drives": drives or description("can1")}
        self.drives: subprocess.Popen[str] | None = None
        self.wire: subprocess.Popen[str] | None = None
        self.runtime: subprocess.Popen[str] | None = None
        self.memory: HliMemory | None = None
        self.steps: dict[str, float] = {}  # name of what happened: s since 1970
        self._seen = 0

    def start(self) -> None:
        files = {}
        for side, machine in self.described.items():
            files[side] = Path(f"/run/tmp/{self.name}-{side}.yaml")
            files[side].write_text(yaml.safe_dump(machine))
        channel = self.described["master"]["fieldbus"]["bus"]["channel"]
        log = self.folder / ("wire.bin" if self.name == NAME else f"wire-{self.name}.bin")
        self.wire = self._spawn("wire", ["-m", "tests.vm.guest.wire_log", channel, str(log)])
        self.drives = self._spawn(
            "drives", ["-m", "runtime.fieldbus.simulator", "--machine", str(files["drives"]), "--commands"]
        )
        self.runtime = self._spawn(
            "runtime",
            [
                "-m",
                "runtime.cli.main",
                "run",
                "-c",
                str(files["master"]),
                "--name",
                self.name,
                "--verbose",
                "--start-limit",
                "600",
            ],
        )

    def _spawn(self, name: str, arguments: list[str]) -> subprocess.Popen[str]:
        with (self.folder / f"{name}.txt").open("a") as log:
            return subprocess.Popen(
                [sys.executable, *arguments], stdin=subprocess.PIPE, stdout=log, stderr=log, text=True
            )

    # -- waiting -----------------------------------------------------------------------------------------------------

    def wait_for(self, what: str, condition: Callable[[], bool], limit: float = LIMIT) -> None:
        """Raises NotHappenedError."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise NotHappenedError(f"{what}: not within {limit:g} s; alarms: {self.alarms()}")
            if self.runtime is not None and self.runtime.poll() is not None:
                raise NotHappenedError(f"{what}: the runtime has ended with {self.runtime.returncode}")
            time.sleep(0.1)
        self.steps[what] = time.time()

    def pause(self, seconds: float) -> None:
        time.sleep(seconds)

    # -- looking -----------------------------------------------------------------------------------------------------

    def attached(self) -> bool:
        if self.memory is None:
            try:
                memory = HliMemory.attach(self.name)
            except HliError:
                return False
            if not memory.hli.head.running_r:
                memory.close()
                return False
            self.memory = memory
        return True

    @property
    def hli(self) -> Any:
        assert self.memory is not None
        return self.memory.hli

    def enabled(self) -> list[bool]:
        return [bool(self.hli.axes[i].status.ready_for_control_loop_on_r) for i in range(self.hli.head.axes_r)]

    def state(self) -> State:
        return State(self.hli.channels[0].control.mode_and_state.state_r)

    def positions(self) -> list[float]:
        """Actual positions, mm."""
        return [self.hli.axes[i].status.actual_position_r * 1e-4 for i in range(self.hli.head.axes_r)]

    def alarms(self) -> list[tuple[int, str]]:
        """Number and text of the alarms since the last call of `forget_alarms`, oldest first."""
        if self.memory is None:
            return []
        lines = [line for line in alarm_lines(self.hli) if line.sequence > self._seen]
        return [(line.id, line.text) for line in reversed(lines)]

    def has_alarm(self, number: int) -> bool:
        return any(found == number for found, _ in self.alarms())

    def forget_alarms(self) -> None:
        self._seen = int(self.hli.alarm_count_r)

    # -- ordering ----------------------------------------------------------------------------------------------------

    def tell_drives(self, line: str) -> None:
        assert self.drives is not None
        assert self.drives.stdin is not None
        self.drives.stdin.write(line + "\n")
        self.drives.stdin.flush()

    def order_start(self, program: Path) -> str:
        """The refusal, empty if there was none."""
        assert self.memory is not None
        try:
            Operator(self.memory, time.sleep).start(str(program))
        except (OrderRefusedError, HliError) as error:
            return str(error)
        return ""

    def reset(self) -> None:
        assert self.memory is not None
        Operator(self.memory, time.sleep).reset()

    def stop(self) -> int:
        """SIGTERM to the runtime; its exit code."""
        assert self.runtime is not None
        self.runtime.send_signal(signal.SIGTERM)
        return self.runtime.wait(LIMIT)

    def end(self) -> None:
        """Whatever still runs."""
        for process in (self.runtime, self.drives, self.wire):
            if process is not None and process.poll() is None:
                process.terminate()
                try:
                    process.wait(20.0)
                except subprocess.TimeoutExpired:
                    process.kill()
