"""The runtime as a systemd service: installed as README.md says, started, frozen, stopped, killed with its computer.

python -m tests.vm.guest.service FOLDER first            until somebody kills the machine
python -m tests.vm.guest.service FOLDER second           after that
"""

from __future__ import annotations

import json
import os
import shutil
import signal
import subprocess
import sys
import time
import traceback
import urllib.request
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import yaml

from runtime.hli.alarms import alarm_lines
from runtime.hli.errors import HliError
from runtime.hli.layout import State
from runtime.hli.memory import HliMemory
from runtime.hli.operator import Operator
from tests.vm.guest.machine import NotHappenedError, description

LIMIT: Final = 150.0  # s
KERNELS: Final = Path("/srv/vm/kernels")
PROGRAM: Final = Path("/var/lib/tandem/programs/part.nc")
SOURCE: Final = Path(__file__).parents[3]
PROGRAM_TEXT: Final = """N10 G53 G90 G17 G94
N20 $FOR P1 = 1, 100, 1
N30 G01 X60 Y20 F6000
N40 G01 X20 Y60
N50 $ENDFOR
N60 M30
"""
SETTINGS: Final = "ActiveState", "SubState", "Result", "NRestarts", "MainPID", "User", "StatusText"


def run(*command: str) -> str:
    """Output of a command, its errors included."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout + done.stderr


def install() -> None:
    """The steps of README.md, "On a machine with can0", but for the package, which is there already."""
    for target, source in (
        ("/etc/sysusers.d", "systemd/sysusers.d/tandem.conf"),
        ("/etc/tmpfiles.d", "systemd/tmpfiles.d/tandem.conf"),
        ("/etc/systemd/system", "systemd/tandem.service"),
    ):
        Path(target).mkdir(parents=True, exist_ok=True)
        shutil.copy(SOURCE / source, target)
    run("systemd-sysusers")
    run("systemd-tmpfiles", "--create", "tandem.conf")
    shutil.copytree(KERNELS, "/var/cache/tandem/numba", dirs_exist_ok=True)
    run("chown", "-R", "tandem:tandem", "/var/cache/tandem")
    machine = description("can0")
    machine["fieldbus"]["bus"]["heartbeat_timeout"] = "4 s"
    machine["state_directory"] = "/var/lib/tandem"
    Path("/etc/tandem/machine.yaml").write_text(yaml.safe_dump(machine))
    machine["fieldbus"]["bus"]["channel"] = "can1"
    Path("/run/drives.yaml").write_text(yaml.safe_dump(machine))
    PROGRAM.write_text(PROGRAM_TEXT)
    PROGRAM.chmod(0o644)
    run("systemctl", "daemon-reload")


def links_up() -> None:
    for channel in ("can0", "can1"):
        for options in ("type can bitrate 1000000 restart-ms 100", "txqueuelen 1000", "up"):
            subprocess.run(["ip", "link", "set", channel, *options.split()], check=True)


class Probe:
    """Looks at the service from outside, as an operator does."""

    def __init__(self, folder: Path) -> None:
        self.folder = folder
        self.seen: dict[str, Any] = {}
        self.memory: HliMemory | None = None

    def tell(self, name: str, value: Any) -> None:
        self.seen[name] = value
        print(name, value, flush=True)

    def state(self) -> dict[str, str]:
        lines = run("systemctl", "show", "tandem", *(f"--property={name}" for name in SETTINGS)).splitlines()
        return dict(line.split("=", 1) for line in lines if "=" in line)

    def wait_for(self, what: str, condition: Callable[[], bool]) -> None:
        end = time.monotonic() + LIMIT
        while not condition():
            if time.monotonic() > end:
                raise NotHappenedError(f"{what}: {self.state()}\n{run('journalctl', '-u', 'tandem', '-n', '40')}")
            time.sleep(0.2)

    def attach(self) -> bool:
        """To the HLI of the service that runs now."""
        if self.memory is not None:
            self.memory.close()
            self.memory = None
        try:
            memory = HliMemory.attach("tandem")
        except HliError:
            return False
        if not (memory.hli.head.running_r and memory.owner_alive):
            memory.close()
            return False
        self.memory = memory
        return True

    @property
    def hli(self) -> Any:
        assert self.memory is not None
        return self.memory.hli

    def enabled(self) -> bool:
        hli = self.hli
        return all(hli.axes[i].status.ready_for_control_loop_on_r for i in range(hli.head.axes_r))

    def alarms(self) -> list[tuple[int, str]]:
        return [(line.id, line.text) for line in reversed(alarm_lines(self.hli))]

    def start(self) -> None:
        begin = time.monotonic()
        run("systemctl", "start", "tandem")
        self.wait_for("the HLI", self.attach)
        self.wait_for("drives enabled", lambda: self.enabled() and bool(self.hli.platform.plc_running_r))
        self.tell("start_seconds", time.monotonic() - begin)

    def move(self) -> None:
        assert self.memory is not None
        Operator(self.memory, time.sleep).start(str(PROGRAM))
        self.wait_for("motion", lambda: self.hli.axes[0].status.actual_position_r > 200_000)


def cycle_process() -> int:
    for entry in Path("/proc").iterdir():
        if entry.name.isdigit() and b"runtime.scheduler.cycle_process" in (entry / "cmdline").read_bytes():
            return int(entry.name)
    raise NotHappenedError("no cycle process")


def first(probe: Probe) -> None:
    probe.start()
    probe.tell("started", probe.state())
    process = Path(f"/proc/{probe.state()['MainPID']}/status").read_text()
    probe.tell("capabilities", next(line.split()[1] for line in process.splitlines() if line.startswith("CapEff")))
    probe.tell("exposure", run("systemd-analyze", "security", "tandem", "--no-pager").strip().splitlines()[-1])
    with urllib.request.urlopen("http://127.0.0.1:9402/metrics", timeout=20) as answer:
        text = answer.read().decode()
    probe.tell("metrics", [line for line in text.splitlines() if line.startswith(("tandem_can_", "tandem_cycle"))][:12])
    journal = [
        json.loads(line) for line in run("journalctl", "-u", "tandem", "-o", "json").splitlines() if line[:1] == "{"
    ]
    probe.tell("journal", [{k: str(v) for k, v in line.items() if k.startswith("TANDEM")} for line in journal][-40:])

    # a cycle that hangs: the watchdog ends it, the service comes back, nothing moves
    os.kill(cycle_process(), signal.SIGSTOP)
    probe.wait_for("the watchdog", lambda: probe.state().get("NRestarts") == "1")
    probe.wait_for("the restart", lambda: probe.state()["ActiveState"] == "active" and probe.attach())
    probe.tell("after_watchdog", probe.state())
    probe.tell("watchdog_journal", "watchdog" in run("journalctl", "-u", "tandem").lower())
    probe.wait_for("drives acknowledged", lambda: acknowledged(probe))

    # stop in motion: to rest on the path, drives off in order
    probe.move()
    begin = time.monotonic()
    run("systemctl", "stop", "tandem")
    probe.tell("stop_seconds", time.monotonic() - begin)
    probe.tell("stopped", probe.state())
    probe.tell("retained_at_stop", json.loads(next(Path("/var/lib/tandem").glob("*.json")).read_text()))

    # started again and moving, when somebody pulls the plug
    run("systemctl", "reset-failed", "tandem")
    probe.start()
    probe.move()
    time.sleep(3.0)
    probe.tell("alarms", probe.alarms())
    (probe.folder / "first.json").write_text(json.dumps(probe.seen, indent=1))
    (probe.folder / "kill-me").touch()
    time.sleep(LIMIT)


def acknowledged(probe: Probe) -> bool:
    """The drives missed their master while it was frozen: their faults have to be acknowledged."""
    if probe.enabled():
        return True
    assert probe.memory is not None
    Operator(probe.memory, time.sleep).reset()
    time.sleep(2.0)
    return probe.enabled()


def second(probe: Probe) -> None:
    probe.start()
    probe.tell("alarms", probe.alarms())
    probe.tell("state", State(probe.hli.channels[0].control.mode_and_state.state_r).name)
    run("systemctl", "stop", "tandem")
    (probe.folder / "second.json").write_text(json.dumps(probe.seen, indent=1))


def main() -> int:
    folder = Path(sys.argv[1])
    probe = Probe(folder)
    code = 0
    try:
        links_up()
        install()
        drives = subprocess.Popen(
            [sys.executable, "-m", "runtime.fieldbus.simulator", "--machine", "/run/drives.yaml"],
            stdin=subprocess.DEVNULL,
        )
        try:
            {"first": first, "second": second}[sys.argv[2]](probe)
        finally:
            drives.terminate()
    except Exception:  # what was seen so far is worth having
        traceback.print_exc()
        print(run("journalctl", "-u", "tandem", "-n", "60", "--no-pager"), flush=True)
        (folder / f"{sys.argv[2]}.json").write_text(
            json.dumps(probe.seen | {"failure": traceback.format_exc()}, indent=1)
        )
        code = 1
    return code


if __name__ == "__main__":
    sys.exit(main())
