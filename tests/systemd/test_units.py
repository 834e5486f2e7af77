"""The files for systemd: accepted by its own tools, little exposed, and in step with the rest of the product."""

from __future__ import annotations

import os
import re
import shutil
import subprocess
from pathlib import Path

import pytest

from runtime.config.loader import load_machine

UNIT = Path("systemd/tandem.service")
COMMAND = "/opt/tandem/bin/tandem"


def needs(tool: str) -> pytest.MarkDecorator:
    return pytest.mark.skipif(shutil.which(tool) is None, reason=f"{tool} of the package systemd is not installed")


def run(*command: str, stdin: str = "") -> subprocess.CompletedProcess[str]:
    return subprocess.run(command, input=stdin, capture_output=True, text=True, check=False)


def settings(file: Path) -> dict[str, list[str]]:
    """Key → values, sections aside."""
    found: dict[str, list[str]] = {}
    for key, value in re.findall(r"^(\w+)=(.*)$", file.read_text(encoding="utf-8"), re.MULTILINE):
        found.setdefault(key, []).append(value)
    return found


def verify(text: str, folder: Path) -> str:
    """What systemd-analyze has to say about the unit, its command replaced by one that is there."""
    unit = folder / "tandem.service"
    unit.write_text(text.replace(COMMAND, shutil.which("true") or "/bin/true"))
    done = run("systemd-analyze", "verify", "--man=no", str(unit))
    return done.stdout + done.stderr + ("" if done.returncode == 0 else f"exit code {done.returncode}")


@needs("systemd-analyze")
def test_the_unit_is_verified_without_a_word(tmp_path: Path) -> None:
    text = UNIT.read_text(encoding="utf-8")
    assert COMMAND in text
    assert verify(text, tmp_path) == ""
    assert "WatchdogSek" in verify(text.replace("WatchdogSec", "WatchdogSek"), tmp_path)


@needs("systemd-analyze")
def test_the_exposure_is_at_or_below_3(tmp_path: Path) -> None:
    def exposure(unit: Path) -> subprocess.CompletedProcess[str]:
        return run("systemd-analyze", "security", "--offline=yes", "--threshold=30", "--no-pager", str(unit))

    assert exposure(UNIT).returncode == 0
    bare = tmp_path / "bare.service"
    bare.write_text(f"[Service]\nExecStart={COMMAND} run\n")
    assert exposure(bare).returncode != 0


def test_the_service_may_do_what_the_runtime_does() -> None:
    unit = settings(UNIT)
    assert (unit["Type"], unit["NotifyAccess"]) == (["notify"], ["main"])
    assert set(unit["RestrictAddressFamilies"][0].split()) == {"AF_CAN", "AF_UNIX", "AF_INET", "AF_INET6"}
    for forbidden in ("MemoryDenyWriteExecute", "PrivateDevices", "PrivateNetwork", "RestrictRealtime", "PrivateUsers"):
        assert unit.get(forbidden, ["no"]) == ["no"]
    assert int(unit["LimitRTPRIO"][0]) >= load_machine(Path("config/machine.yaml")).cycle.priority
    assert unit["LimitMEMLOCK"] == ["infinity"]
    assert "CPUSchedulingPolicy" not in unit
    assert unit["KillMode"] == ["control-group"], "mixed would kill a braking cycle whose main process has died"
    assert unit["WatchdogSignal"] == ["SIGTERM"], "SIGABRT would end the cycle in motion"
    assert unit["OOMPolicy"] == ["continue"], "a PLC process that the kernel has ended must not end the service"
    assert int(unit["OOMScoreAdjust"][0]) < 0
    assert unit["DeviceAllow"] == ["/dev/cpu_dma_latency w"]
    assert f"Environment=NUMBA_CACHE_DIR=/var/cache/{unit['CacheDirectory'][0]}/" in UNIT.read_text(encoding="utf-8")


@needs("systemd-analyze")
@pytest.mark.parametrize(
    "call",
    [
        "sched_setscheduler",
        "sched_setaffinity",
        "mlockall",
        "prctl",
        "clock_nanosleep",
        "memfd_create",
        "socket",
        "kill",
    ],
)
def test_the_calls_of_the_runtime_pass_the_filter(call: str) -> None:
    def members(group: str) -> set[str]:
        lines = run("systemd-analyze", "syscall-filter", "--no-pager", group).stdout.splitlines()[1:]
        found: set[str] = set()
        for word in (line.strip() for line in lines):
            if word.startswith("@"):
                found |= members(word)
            elif word and not word.startswith("#"):
                found.add(word)
        return found

    allow, deny = settings(UNIT)["SystemCallFilter"]
    assert deny.startswith("~")
    assert call in set().union(*(members(group) for group in allow.split()))
    assert call not in set().union(*(members(group) for group in deny[1:].split()))


@needs("systemd-sysusers")
@needs("systemd-tmpfiles")
@pytest.mark.skipif(os.geteuid() != 0, reason="making users and folders under another root needs root")
def test_user_and_folders_are_made(tmp_path: Path) -> None:
    (tmp_path / "etc").mkdir()
    users = run("systemd-sysusers", f"--root={tmp_path}", "-", stdin=Path("systemd/sysusers.d/tandem.conf").read_text())
    assert users.returncode == 0, users.stderr
    (account,) = (tmp_path / "etc/passwd").read_text().splitlines()
    name, _, uid, gid, _, home, shell = account.split(":")
    assert (name, home) == (settings(UNIT)["User"][0], "/var/lib/tandem")
    assert shell.endswith("nologin")
    description = Path("systemd/tmpfiles.d/tandem.conf").read_text()
    folders = run("systemd-tmpfiles", f"--root={tmp_path}", "--create", "-", stdin=description)
    assert folders.returncode == 0, folders.stderr
    programs = (tmp_path / "var/lib/tandem/programs").stat()
    assert (programs.st_uid, programs.st_gid, programs.st_mode & 0o777) == (int(uid), int(gid), 0o770)
    (channel,) = load_machine(Path("config/machine.yaml")).channels
    assert channel.program_paths == ("/var/lib/tandem/programs",)


def test_the_bus_of_the_network_file_is_that_of_the_example() -> None:
    bus = load_machine(Path("config/machine.yaml")).fieldbus.bus
    network = settings(Path("systemd/network/80-can0.network"))
    assert network["Name"] == [bus.channel]
    assert int(network["BitRate"][0].replace("M", "000000").replace("K", "000")) == bus.bitrate
    assert "RestartSec" in network
    assert settings(Path("systemd/network/80-can0.link"))["Type"] == ["can"]
