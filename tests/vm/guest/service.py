"""The machine as a systemd service inside the guest: installed with the commands of README, its drives on the second card."""

from __future__ import annotations

import contextlib
import json
import os
import re
import signal
import subprocess
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import yaml

from runtime.hli.alarms import alarm_lines
from runtime.hli.errors import HliError
from runtime.hli.layout import State
from runtime.hli.memory import HliMemory
from runtime.hli.operator import Operator, OrderRefusedError
from runtime.scheduler.retained import RetainedStore
from tests.vm.guest.machine import LIMIT, NotHappenedError, description

UNIT: Final = "tandem.service"
PYTHON: Final = "/opt/tandem/bin/python"
COMMAND: Final = "/opt/tandem/bin/tandem"
START_LIMIT: Final = 900.0  # s
RESET_PAUSE: Final = 5.0  # s between two resets
STATE: Final = Path("/var/lib/tandem")
SOURCES: Final = Path("/run/sources")  # README and the units, as a clone has them
DROP_IN: Final = Path("/etc/systemd/system/tandem.service.d/emulator.conf")
METRICS: Final = "http://127.0.0.1:9402/metrics"
PLC_PROGRAM: Final = '''from runtime.plc_logic import retain
from runtime.demo.plc import DemoMill


class Mill(DemoMill):
    """The demo's program, and a variable that survives."""

    counted = retain(0)

    def cycle(self) -> None:
        super().cycle()
        self.counted += 1
'''


def run(*command: str, check: bool = True, user: str = "", group: str = "") -> subprocess.CompletedProcess[str]:
    """A command as root, or as somebody else."""
    if user:
        command = ("setpriv", f"--reuid={user}", f"--regid={group or user}", "--clear-groups", *command)
    done = subprocess.run(command, capture_output=True, text=True, check=False, cwd="/")
    if check and done.returncode:
        raise NotHappenedError(f"{' '.join(command)}: {done.returncode}: {done.stdout}{done.stderr}")
    return done


def properties(*names: str, unit: str = UNIT) -> dict[str, str]:
    """What systemd says about a unit."""
    shown = run("systemctl", "show", unit, *(f"--property={name}" for name in names)).stdout
    return dict(line.split("=", 1) for line in shown.splitlines() if "=" in line)


def on_card(channel: str) -> dict[str, Any]:
    """The machine on a card; drives may start at the same time, neither nodes nor PLC are judged by their signs of life."""
    machine = description(channel)
    machine["fieldbus"]["bus"] |= {"heartbeat_timeout": "30 s", "boot_timeout": "300 s"}
    machine["plc"] |= {"watchdog": "60 s"}
    return machine


def install(environment: dict[str, str]) -> list[str]:
    """Steps 2 and 3 of "On a machine with can0" in README, word for word; the commands that were executed."""
    readme = (SOURCES / "README.md").read_text(encoding="utf-8")
    section = readme.split("## On a machine with can0")[1].split("\n## ")[0]
    blocks = re.findall(r"```sh\n(.*?)```", section, re.DOTALL)
    commands = [line.strip() for line in blocks[1].splitlines() if line.strip()]
    for line in commands:
        done = subprocess.run(["/bin/sh", "-ec", line], cwd=SOURCES, capture_output=True, text=True, check=False)
        if done.returncode:
            raise NotHappenedError(f"{line}: {done.returncode}: {done.stdout}{done.stderr}")
    machine = on_card("can0")
    del machine["state_directory"]  # systemd's
    machine["plc"]["program"] = "mill.py"
    machine["metrics"] = {"port": 9402}
    Path("/etc/tandem/machine.yaml").write_text(yaml.safe_dump(machine))
    Path("/etc/tandem/mill.py").write_text(PLC_PROGRAM)
    DROP_IN.parent.mkdir(exist_ok=True)
    variables = "".join(f"Environment={key}={value}\n" for key, value in environment.items())
    DROP_IN.write_text(  # what an emulated processor needs: time, and machine code that both sides run
        f"[Service]\n{variables}TimeoutStartSec={START_LIMIT:g}\nWatchdogSec=30\nTimeoutStopSec=60\nExecStart=\n"
        f"ExecStart={COMMAND} run -c /etc/tandem/machine.yaml --start-limit {START_LIMIT:g}\n"
    )
    run("systemctl", "daemon-reload")
    return commands


class Service:
    """The unit, the HLI of what runs in it, the simulated drives and the listener on the wire."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.steps: dict[str, float] = {}  # name of what happened: s since 1970
        self._drives: subprocess.Popen[bytes] | None = None
        self._wire: subprocess.Popen[bytes] | None = None
        self._memory: HliMemory | None = None

    # -- what is not the service ------------------------------------------------------------------------------------

    def surround(self, log: str) -> None:
        """The second card up, drives on it, a listener on the first card."""
        # an emulator on a busy host is late in every cycle: the other processes get their share all the same
        Path("/proc/sys/kernel/sched_rt_runtime_us").write_text("700000")
        self.wait_for("can0 is up", lambda: "UP" in run("ip", "-br", "link", "show", "can0", check=False).stdout)
        for command in (
            "ip link set can0 txqueuelen 1000",  # an emulated card stands still for longer than any real one
            "ip link set can1 type can bitrate 1000000 restart-ms 100",
            "ip link set can1 txqueuelen 1000",
            "ip link set can1 up",
        ):
            run(*command.split())
        drives = Path("/run/drives.yaml")
        drives.write_text(yaml.safe_dump(on_card("can1")))
        encoders = STATE.parent / "drives.json"
        self._drives = self._spawn(
            "drives", "runtime.fieldbus.simulator", "--machine", str(drives), "--state", str(encoders)
        )
        self._wire = self._spawn("wire", "tests.vm.guest.wire_log", "can0", str(self.folder / log))

    def _spawn(self, name: str, module: str, *arguments: str) -> subprocess.Popen[bytes]:
        with (self.folder / f"{name}.txt").open("ab") as file:
            return subprocess.Popen(
                [PYTHON, "-m", module, *arguments], stdin=subprocess.DEVNULL, stdout=file, stderr=file
            )

    def end(self) -> None:
        """Drives and listener."""
        for process in (self._drives, self._wire):
            if process is not None:
                process.terminate()
                process.wait(60.0)

    # -- the unit ---------------------------------------------------------------------------------------------------

    def systemctl(self, verb: str) -> float:
        """Start, stop, restart: how many seconds it took."""
        begin = time.monotonic()
        self.steps[f"{verb} asked"] = time.time()
        run("systemctl", verb, UNIT)
        self.steps[f"{verb} done"] = time.time()
        return time.monotonic() - begin

    @property
    def main_pid(self) -> int:
        return int(properties("MainPID")["MainPID"])

    def pids(self) -> dict[str, int]:
        """Its processes: name → process id; one that nobody has thought of is named by its command line."""
        group = Path("/sys/fs/cgroup") / properties("ControlGroup")["ControlGroup"].lstrip("/") / "cgroup.procs"
        found = {}
        for pid in group.read_text().split() if group.exists() else []:
            line = Path(f"/proc/{pid}/cmdline").read_bytes().decode().replace("\0", " ")
            match = re.search(r"runtime\.(?:scheduler\.(\w+)_process|fieldbus\.(simulator))", line)
            name = "service" if int(pid) == self.main_pid else (match[1] or match[2]) if match else line
            found[name] = int(pid)
        return found

    # -- the machine ------------------------------------------------------------------------------------------------

    def wait_for(self, what: str, condition: Callable[[], bool], limit: float = LIMIT) -> None:
        """Raises NotHappenedError."""
        end = time.monotonic() + limit
        while not condition():
            if time.monotonic() > end:
                raise NotHappenedError(f"{what}: not within {limit:g} s; alarms: {self.alarms()}")
            time.sleep(0.1)
        self.steps[what] = time.time()
        print(f"{time.monotonic():8.1f} {what}", flush=True)

    def attached(self) -> bool:
        """A runtime that lives has a running cycle; that of an earlier one is let go."""
        if self._memory is not None and not (self._memory.owner_alive and self._memory.hli.head.running_r):
            self._memory.close()
            self._memory = None
        if self._memory is None:
            try:
                memory = HliMemory.attach("tandem")
            except HliError:
                return False
            if not (memory.owner_alive and memory.hli.head.running_r):
                memory.close()
                return False
            self._memory = memory
        return True

    def ready(self, what: str = "ready") -> None:
        """Until every axis is enabled and the PLC runs. An operator acknowledges what keeps them off: alarms, drives in fault."""
        self.wait_for(f"{what}: cycle", self.attached, START_LIMIT)
        again = time.monotonic()

        def everything() -> bool:
            nonlocal again
            if not self.attached():
                return False
            done = all(self.enabled()) and bool(self.hli.platform.plc_running_r) and self.state() is not State.ERROR
            if not done and time.monotonic() > again:
                again = time.monotonic() + RESET_PAUSE
                with contextlib.suppress(OrderRefusedError, HliError):  # it is busy with the last one
                    self.reset()
            return done

        self.wait_for(what, everything)

    @property
    def hli(self) -> Any:
        assert self._memory is not None
        return self._memory.hli

    def state(self) -> State:
        return State(self.hli.channels[0].control.mode_and_state.state_r)

    def enabled(self) -> list[bool]:
        return [bool(self.hli.axes[i].status.ready_for_control_loop_on_r) for i in range(self.hli.head.axes_r)]

    def positions(self) -> list[float]:
        """Actual positions, mm."""
        return [self.hli.axes[i].status.actual_position_r * 1e-4 for i in range(self.hli.head.axes_r)]

    def alarms(self) -> list[tuple[int, str]]:
        """Number and text, oldest first."""
        if self._memory is None:
            return []
        return [(line.id, line.text) for line in reversed(alarm_lines(self.hli))]

    def order_start(self, program: Path) -> str:
        """The refusal, empty if there was none."""
        assert self._memory is not None
        try:
            Operator(self._memory, time.sleep).start(str(program))
        except (OrderRefusedError, HliError) as error:
            return str(error)
        return ""

    def reset(self) -> None:
        assert self._memory is not None
        Operator(self._memory, time.sleep).reset()

    def move(self, program: Path, what: str) -> str:
        """Start a program and wait until X moves; the refusal."""
        refused = self.order_start(program)
        before = self.positions()[0]
        self.wait_for(what, lambda: abs(self.positions()[0] - before) > 2.0)
        return refused

    def look(self) -> dict[str, Any]:
        return {
            "state": self.state().name, "positions": self.positions(), "alarms": self.alarms(),
            "enabled": self.enabled(),
        }  # fmt: skip


def retained_on_disk() -> dict[str, Any]:
    """What the runtime would find now: positions, alarms, and what is wrong with it."""
    retained, problems = RetainedStore(STATE).load()
    return {
        "positions": dict(retained.positions),
        "alarms": [alarm.id for alarm in retained.alarms],
        "problems": [str(problem) for problem in problems],
    }


def journal(folder: Path, boot: str = "0") -> None:
    """All entries of the unit, as journalctl tells them to other programs."""
    entries = run("journalctl", "--unit", UNIT, "--output=json", "--no-pager", f"--boot={boot}").stdout
    (folder / "journal.jsonl").write_text(entries)


def status_of(pid: int) -> dict[str, Any]:
    """Who a process is and what it may do."""
    lines = Path(f"/proc/{pid}/status").read_text().splitlines()
    fields = {key: value.strip() for key, _, value in (line.partition(":") for line in lines)}
    wanted = ("Uid", "Gid", "CapPrm", "CapEff", "CapBnd", "CapAmb", "NoNewPrivs", "Seccomp", "VmLck")
    return {name: fields[name] for name in wanted} | {"policy": os.sched_getscheduler(pid)}


def signal_to(pid: int, number: signal.Signals) -> None:
    os.kill(pid, number)


def write(folder: Path, name: str, seen: dict[str, Any]) -> None:
    """What was seen so far; replaced as a whole."""
    new = folder / f"{name}.new"
    new.write_text(json.dumps(seen, indent=1))
    new.replace(folder / f"{name}.json")
