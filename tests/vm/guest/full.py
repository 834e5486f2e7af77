"""All that happens in the full form: the package as a systemd service, over several boots of one disk.

FOLDER/environment says which part is played (PART), and of the first one perhaps ONLY some scenes; what is seen goes to
FOLDER/PART.json.

    first       installed as README says, started, milled, watched, in motion restarted, killed, frozen, stopped
    power       moves and writes as fast as it can, tells the host that it may cut the power, and waits for that
    after       looks what has survived; then as `power`, while the service is still starting
    last        looks what has survived, and is stopped in motion

python -m tests.vm.guest.full FOLDER
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
import traceback
import urllib.error
import urllib.request
from collections.abc import Callable
from dataclasses import asdict
from pathlib import Path
from typing import Any, Final

from runtime.hli.layout import State
from runtime.plc_logic.retained_variables import read_journal
from tests.system.sockets import network_sockets
from tests.vm.guest import writers
from tests.vm.guest.quick import LONG_PROGRAM, PROGRAM
from tests.vm.guest.service import (
    COMMAND,
    METRICS,
    PYTHON,
    STATE,
    Service,
    install,
    journal,
    properties,
    retained_on_disk,
    run,
    signal_to,
    status_of,
    write,
)

PROGRAMS: Final = STATE / "programs"
PROBE: Final = STATE / "probe"
OTHER_ADDRESS: Final = "10.77.77.77"  # of this machine, as the network would see it
OPERATORS: Final = ("watcher", "stranger")  # one in the group tandem, one not


def first(service: Service, seen: dict[str, Any], folder: Path) -> None:
    """The service from its installation to the loss of its parts."""
    seen["kernel"] = os.uname().version
    variables = {key: os.environ[key] for key in ("NUMBA_CPU_NAME", "NUMBA_CPU_FEATURES")}
    seen["installed"] = install(variables)
    Path("/etc/sysusers.d/operators.conf").write_text("".join(f"u {user} -\n" for user in OPERATORS))
    run("systemd-sysusers")
    (PROGRAMS / "part.nc").write_text(PROGRAM)
    (PROGRAMS / "long.nc").write_text(LONG_PROGRAM)
    service.surround("wire-first.bin")
    seen["start_s"] = service.systemctl("start")
    service.ready("started")
    for scene in (_processes, _access, _metrics, _milling, _restart, _killed, _frozen, _stop):
        if scene.__name__ in os.environ.get("ONLY", scene.__name__).split(","):
            seen[scene.__name__.strip("_")] = found = _played(scene, service)
            if "failure" in found:
                seen["failure"] = seen.get("failure", "") + found["failure"]
            write(folder, "first", seen)
    run("systemctl", "enable", "tandem")
    journal(folder)
    run("sync")


def _played(scene: Callable[[Service, dict[str, Any]], None], service: Service) -> dict[str, Any]:
    """What was seen in a scene; if it failed, why, and the service is started anew for the next one."""
    print(f"-- {scene.__name__}", flush=True)
    found: dict[str, Any] = {}
    try:
        scene(service, found)
    except Exception:
        found["failure"] = traceback.format_exc()
        print(found["failure"], flush=True)
        service.systemctl("restart")
        service.ready(f"started again behind {scene.__name__}")
    return found


# -- scenes of the first boot ----------------------------------------------------------------------------------------


def _processes(service: Service, found: dict[str, Any]) -> None:
    """Who they are, what they may do, what they listen on."""
    pids = service.pids()
    found["who"] = {name: status_of(pid) for name, pid in pids.items()}
    found["sockets"] = [asdict(socket) for socket in network_sockets(pids.values())]
    found["uid"] = int(run("id", "-u", "tandem").stdout)
    found["unit"] = properties("Type", "User", "WatchdogUSec", "NRestarts", "StatusText")
    found["exposure"] = run("systemd-analyze", "security", "--no-pager", "tandem.service", check=False).stdout[-200:]
    found["memory"] = {
        path.name: [oct(path.stat().st_mode & 0o777), path.stat().st_uid, path.stat().st_gid]
        for path in Path("/dev/shm").iterdir()
    }
    found["state"] = {
        path.name: [oct(path.stat().st_mode & 0o777), path.stat().st_uid] for path in (STATE, *STATE.iterdir())
    }


def _access(_service: Service, found: dict[str, Any]) -> None:
    """The group looks on, nobody else does, and only the owner commands."""
    watch = (COMMAND, "hli", "watch", "--once")
    hold = (COMMAND, "hli", "command", "override", "100")
    for user, group in (("tandem", "tandem"), ("watcher", "tandem"), ("stranger", "stranger")):
        found[user] = {
            "watch": _answer(run(*watch, check=False, user=user, group=group)),
            "command": _answer(run(*hold, check=False, user=user, group=group)),
        }


def _answer(done: subprocess.CompletedProcess[str]) -> list[Any]:
    return [done.returncode, (done.stdout + done.stderr)[-300:]]


def _metrics(_service: Service, found: dict[str, Any]) -> None:
    """From this computer they are read; its address on the network has nobody listening; nothing is changed by asking."""
    run("ip", "addr", "add", f"{OTHER_ADDRESS}/32", "dev", "lo")
    with urllib.request.urlopen(METRICS, timeout=60) as answer:
        found["text"] = answer.read().decode()
    found["elsewhere"] = _refusal(METRICS.replace("127.0.0.1", OTHER_ADDRESS), "GET")
    found["refused"] = {method: _refusal(METRICS, method) for method in ("POST", "PUT", "DELETE", "PATCH")}


def _refusal(url: str, method: str) -> str:
    request = urllib.request.Request(url, method=method, data=b"x" if method != "GET" else None)
    try:
        with urllib.request.urlopen(request, timeout=60) as answer:
            return f"answered {answer.status} with {len(answer.read())} bytes"
    except urllib.error.HTTPError as error:
        return f"HTTP {error.code}"
    except OSError as error:
        return str(error)


def _milling(service: Service, found: dict[str, Any]) -> None:
    """A program as the README starts it."""
    run(COMMAND, "hli", "command", "start", str(PROGRAMS / "part.nc"), user="tandem")
    service.wait_for("milling", lambda: service.state() is State.ACTIVE)
    service.wait_for("milled", lambda: service.state() is not State.ACTIVE)
    found |= service.look()


def _stop(service: Service, found: dict[str, Any]) -> None:
    """`systemctl stop` in motion."""
    found["refused"] = service.move(PROGRAMS / "long.nc", "moving before stop")
    found["stop_s"] = service.systemctl("stop")
    found["unit"] = properties("ActiveState", "Result", "ExecMainStatus")
    found["left"] = [path.name for path in Path("/dev/shm").glob("tandem*")]
    found["retained"] = retained_on_disk()


def _restart(service: Service, found: dict[str, Any]) -> None:
    """`systemctl restart` in motion: the axes stay where they came to rest, nothing goes on by itself."""
    found["refused"] = service.move(PROGRAMS / "long.nc", "moving before restart")
    found["restart_s"] = service.systemctl("restart")
    service.ready("started again")
    found["after"] = service.look()
    found["unit"] = properties("Result", "NRestarts")


def _killed(service: Service, found: dict[str, Any]) -> None:
    """The main process dies in motion: the cycle brakes on its own, then systemd starts everything anew."""
    _lost(service, found, "killed", service.main_pid, signal.SIGKILL)


def _frozen(service: Service, found: dict[str, Any]) -> None:
    """The cycle process stands still in motion: the watchdog notices, and everything is started anew."""
    _lost(service, found, "frozen", service.pids()["cycle"], signal.SIGSTOP)


def _lost(service: Service, found: dict[str, Any], what: str, pid: int, number: signal.Signals) -> None:
    found["refused"] = service.move(PROGRAMS / "long.nc", f"moving before {what}")
    before = int(properties("NRestarts")["NRestarts"])
    begin = time.monotonic()
    service.steps[f"{what} now"] = time.time()
    signal_to(pid, number)
    service.wait_for(f"{what}: restarted by systemd", lambda: int(properties("NRestarts")["NRestarts"]) > before)
    found["noticed_s"] = time.monotonic() - begin
    service.ready(f"back after {what}")
    found["after"] = service.look()
    found["retained"] = retained_on_disk()


# -- power loss ------------------------------------------------------------------------------------------------------


def power(service: Service, seen: dict[str, Any], folder: Path) -> None:
    """Everything writes, the axes move, and the power goes."""
    service.surround("wire-power.bin")
    service.ready("started at boot")
    seen["refused"] = service.move(PROGRAMS / "long.nc", "moving before the power goes")
    _until_the_power_goes(service, seen, folder)


def after(service: Service, seen: dict[str, Any], folder: Path) -> None:
    """What the loss of power has left, before anything writes; then the power goes while the service starts."""
    _survived(seen)
    service.surround("wire-after.bin")
    _until_the_power_goes(service, seen, folder)


def last(service: Service, seen: dict[str, Any], folder: Path) -> None:
    """The last boot ends in order, in motion."""
    _survived(seen)
    service.surround("wire-last.bin")
    service.ready("started at boot")
    seen["boot"] = {
        unit: properties("ActiveEnterTimestampMonotonic", "ExecMainStartTimestampMonotonic", "ActiveState", unit=unit)
        for unit in ("tandem.service", "systemd-networkd.service", "sys-subsystem-net-devices-can0.device")
    }
    seen["after"] = service.look()
    journal(folder)
    seen["refused"] = service.move(PROGRAMS / "long.nc", "moving before shutdown")
    seen["stop_s"] = service.systemctl("stop")


def _survived(seen: dict[str, Any]) -> None:
    """Looked at before the drives and with them the service are up: nothing is written."""
    seen["probe"] = writers.read(PROBE)
    seen["torn"] = writers.whole(PROBE)
    seen["retained"] = retained_on_disk()
    seen["counted"] = read_journal(STATE / "plc")[1].get("counted", -1) if (STATE / "plc").exists() else -1
    seen["unclean"] = run("journalctl", "--no-pager", "--boot=0", "--grep=recover", check=False).stdout[-500:]


def _until_the_power_goes(service: Service, seen: dict[str, Any], folder: Path) -> None:
    PROBE.mkdir(exist_ok=True)
    run("chown", "-R", "tandem:tandem", str(PROBE))
    command = ["setpriv", "--reuid=tandem", "--regid=tandem", "--clear-groups", PYTHON, "-m", "tests.vm.guest.writers"]
    before = _promised(folder)
    with (folder / "writers.txt").open("ab") as log:
        writer = subprocess.Popen([*command, str(PROBE), str(folder)], stdout=log, stderr=log)
    service.wait_for("writing", lambda: all(new > old for new, old in zip(_promised(folder), before, strict=True)))
    write(folder, os.environ["PART"], seen)
    (folder / "cut-the-power").touch()
    code = writer.wait()  # it ends with the machine
    raise RuntimeError(f"the writers have ended with {code}")


def _promised(folder: Path) -> list[int]:
    return [int((folder / f"promised-{store}").read_bytes() or b"0") for store in writers.STORES]


PARTS: dict[str, Callable[[Service, dict[str, Any], Path], None]] = {
    "first": first,
    "power": power,
    "after": after,
    "last": last,
}


def main() -> int:
    folder, part = Path(sys.argv[1]), os.environ["PART"]
    service = Service(folder)
    seen: dict[str, Any] = {"steps": service.steps}
    try:
        PARTS[part](service, seen, folder)
    except Exception:  # whatever it was, what was seen so far is worth having
        seen["failure"] = traceback.format_exc()
        print(seen["failure"], flush=True)
        journal(folder)
    finally:
        service.end()
    write(folder, part, seen)
    run("sync")
    return 1 if "failure" in seen else 0


if __name__ == "__main__":
    sys.exit(main())
