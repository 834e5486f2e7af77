"""`tandem doctor`: every finding on a host made for it, and the command on this one."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

from runtime.cli import main as cli
from runtime.cli.host_checks import Finding, Host, Verdict, examine
from runtime.config.loader import load_machine
from runtime.config.machine import Machine

FILES = {
    "proc/sys/kernel/osrelease": "6.1.0-rt",
    "proc/sys/kernel/version": "#1 SMP PREEMPT_RT Debian",
    "sys/kernel/realtime": "1",
    "sys/devices/system/cpu/online": "0-3",
    "sys/devices/system/cpu/isolated": "3",
    "sys/devices/system/cpu/cpu0/cpufreq/scaling_governor": "performance",
    "sys/devices/system/cpu/cpu3/cpufreq/scaling_governor": "performance",
    "sys/devices/system/cpu/cpu3/cpuidle/state0/latency": "2",
    "sys/devices/system/clocksource/clocksource0/current_clocksource": "tsc",
    "sys/class/net/eth0/type": "1",
    "sys/class/net/can0/type": "280",
    "sys/class/net/can0/operstate": "up",
    "dev/cpu_dma_latency": "",
}


def link(state: str = "ERROR-ACTIVE", bitrate: int = 1_000_000) -> str:
    data = {"state": state, "bittiming": {"bitrate": bitrate}, "restart_ms": 100}
    return json.dumps([{"ifname": "can0", "linkinfo": {"info_kind": "can", "info_data": data}}])


class Computer:
    """A host that is fit; a test spoils one thing."""

    def __init__(self, root: Path) -> None:
        self.root = root
        self.outputs = {"ip": link(), "systemctl": "systemd 252 (252.1)\n+PAM"}
        for path, text in FILES.items():
            self.write(path, text)
        self.host = Host(
            root=root,
            environment={"NUMBA_CACHE_DIR": str(root / "cache")},
            refused_priority=lambda priority: None,
            refused_memory_lock=lambda: None,
            refused_can=lambda: None,
            output=lambda *command: self.outputs.get(command[0], ""),
            writable=lambda path: True,
            free_shared_memory=lambda: 10**9,
            free_disk=lambda place: 10**10,
        )

    def write(self, path: str, text: str | None) -> None:
        file = self.root / path
        file.parent.mkdir(parents=True, exist_ok=True)
        if text is None:
            file.unlink()
        else:
            file.write_text(text + "\n")

    def spoil(self, **calls: Any) -> None:
        self.host = replace(self.host, **calls)


@pytest.fixture
def computer(tmp_path: Path) -> Computer:
    return Computer(tmp_path)


@pytest.fixture
def machine() -> Machine:
    return load_machine(Path("config/machine.yaml"))  # on can0, cycle on processor 3


def finding(computer: Computer, machine: Machine, check: str) -> Finding:
    (found,) = [found for found in examine(computer.host, machine) if found.check == check]
    return found


def test_a_fit_host_has_nothing_to_do(computer: Computer, machine: Machine) -> None:
    findings = examine(computer.host, machine)
    assert {found.verdict for found in findings} == {Verdict.OK}
    assert {found.remedy for found in findings} == {""}
    assert finding(computer, machine, "CAN").found == "can0: up, ERROR-ACTIVE, 1000000 bit/s"


SPOILT_FILES = {
    "no PREEMPT_RT": (
        {"sys/kernel/realtime": None, "proc/sys/kernel/version": "#1 SMP PREEMPT_DYNAMIC"},
        "kernel",
        Verdict.WARN,
        "linux-image-rt",
    ),
    "nothing isolated": ({"sys/devices/system/cpu/isolated": ""}, "processors", Verdict.WARN, "isolcpus=3"),
    "one processor": ({"sys/devices/system/cpu/online": "3"}, "processors", Verdict.WARN, "two cores"),
    "processor not there": ({"sys/devices/system/cpu/online": "0-2"}, "processors", Verdict.FAIL, "cycle.cpu"),
    "frequency scaled": (
        {"sys/devices/system/cpu/cpu3/cpufreq/scaling_governor": "powersave"},
        "processor frequency",
        Verdict.WARN,
        "performance",
    ),
    "slow clock": (
        {"sys/devices/system/clocksource/clocksource0/current_clocksource": "hpet"},
        "clock source",
        Verdict.WARN,
        "tsc",
    ),
    "no interface": ({"sys/class/net/can0/type": "1"}, "CAN", Verdict.FAIL, "fieldbus.bus.channel"),
    "interface down": ({"sys/class/net/can0/operstate": "down"}, "CAN", Verdict.FAIL, "ip link set can0 up"),
}


@pytest.mark.parametrize(("files", "check", "verdict", "remedy"), SPOILT_FILES.values(), ids=SPOILT_FILES.keys())
def test_what_the_kernel_tells(
    computer: Computer, machine: Machine, files: dict[str, str | None], check: str, verdict: Verdict, remedy: str
) -> None:
    for path, text in files.items():
        computer.write(path, text)
    spoilt = [found for found in examine(computer.host, machine) if found.verdict is not Verdict.OK]
    assert [(found.check, found.verdict) for found in spoilt] == [(check, verdict)]
    assert remedy in spoilt[0].remedy


SPOILT_CALLS = {
    "priority": ({"refused_priority": lambda n: f"no {n}"}, "real-time priority", Verdict.WARN, "LimitRTPRIO"),
    "memory": ({"refused_memory_lock": lambda: "limit"}, "memory lock", Verdict.WARN, "LimitMEMLOCK"),
    "CAN": ({"refused_can": lambda: "not supported"}, "CAN", Verdict.FAIL, "CONFIG_CAN"),
    "cache": ({"writable": lambda path: False}, "compiled kernels", Verdict.WARN, "NUMBA_CACHE_DIR"),
    "shared memory": ({"free_shared_memory": lambda: 1000}, "shared memory", Verdict.FAIL, "remount"),
}


@pytest.mark.parametrize(("calls", "check", "verdict", "remedy"), SPOILT_CALLS.values(), ids=SPOILT_CALLS.keys())
def test_what_the_host_refuses(
    computer: Computer, machine: Machine, calls: dict[str, object], check: str, verdict: Verdict, remedy: str
) -> None:
    computer.spoil(**calls)
    spoilt = [found for found in examine(computer.host, machine) if found.verdict is not Verdict.OK]
    assert [(found.check, found.verdict) for found in spoilt] == [(check, verdict)]
    assert remedy in spoilt[0].remedy


@pytest.mark.parametrize(
    ("output", "verdict", "remedy"),
    [
        (link(bitrate=500_000), Verdict.FAIL, "bitrate 1000000"),
        (link("BUS-OFF"), Verdict.FAIL, "termination"),
        (link("ERROR-PASSIVE"), Verdict.WARN, "termination"),
        ("", Verdict.OK, ""),  # no `ip` on this host: the state stays unknown
    ],
)
def test_the_state_of_the_can_interface(
    computer: Computer, machine: Machine, output: str, verdict: Verdict, remedy: str
) -> None:
    computer.outputs["ip"] = output
    found = finding(computer, machine, "CAN")
    assert found.verdict is verdict
    assert remedy in found.remedy


def test_a_virtual_can_interface_has_neither_state_nor_bit_rate(computer: Computer, machine: Machine) -> None:
    computer.write("sys/class/net/can0/operstate", "unknown")
    computer.outputs["ip"] = json.dumps([{"ifname": "can0", "linkinfo": {"info_kind": "vcan"}}])
    assert finding(computer, machine, "CAN").verdict is Verdict.OK


def test_every_bus_has_a_finding_of_its_own(computer: Computer, machine: Machine) -> None:
    second = machine.fieldbus.bus.model_copy(update={"channel": "can1"})
    machine = machine.model_copy(update={"fieldbus": machine.fieldbus.model_copy(update={"buses": {"second": second}})})
    found = finding(computer, machine, "CAN second")
    assert (found.verdict, "fieldbus.buses.second.channel" in found.remedy) == (Verdict.FAIL, True)
    assert finding(computer, machine, "CAN").verdict is Verdict.OK
    computer.write("sys/class/net/can1/type", "280")
    computer.write("sys/class/net/can1/operstate", "up")
    assert finding(computer, machine, "CAN second").found.startswith("can1: up")


def test_deep_sleep_is_no_harm_if_it_can_be_forbidden(computer: Computer, machine: Machine) -> None:
    computer.write("sys/devices/system/cpu/cpu3/cpuidle/state3/latency", "890")
    assert finding(computer, machine, "sleep states").verdict is Verdict.OK
    computer.spoil(writable=lambda path: path.name != "cpu_dma_latency")
    assert finding(computer, machine, "sleep states").verdict is Verdict.WARN
    computer.write("sys/devices/system/cpu/cpu3/cpuidle/state3/disable", "1")
    assert finding(computer, machine, "sleep states").verdict is Verdict.OK


def test_a_machine_without_socketcan_needs_no_can(computer: Computer) -> None:
    computer.spoil(refused_can=lambda: "not supported")
    assert finding(computer, load_machine(), "CAN").verdict is Verdict.OK


def test_systemd_too_old_or_missing(computer: Computer, machine: Machine) -> None:
    computer.outputs["systemctl"] = "systemd 241 (241)"
    assert finding(computer, machine, "systemd").verdict is Verdict.WARN
    computer.outputs["systemctl"] = ""
    assert finding(computer, machine, "systemd").verdict is Verdict.WARN


def test_the_command_on_this_host(capsys: pytest.CaptureFixture[str]) -> None:
    code = cli.main(["doctor", "--json"])
    findings = json.loads(capsys.readouterr().out)
    assert code == int(any(found["verdict"] == "fail" for found in findings))
    assert {"check", "verdict", "found", "remedy"} == set(findings[0])
    for found in findings:
        assert found["found"]
        assert (found["verdict"] == "ok") == (found["remedy"] == "")
    assert cli.main(["doctor"]) == code
    assert "memory lock" in capsys.readouterr().out


def test_a_wrong_description_is_told_as_everywhere(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    assert cli.main(["doctor", "-c", str(tmp_path / "missing.yaml")]) == 1
    assert "302001" in capsys.readouterr().err


def test_too_little_room_for_the_recorder_is_told(computer: Computer, machine: Machine) -> None:
    assert finding(computer, machine, "flight recorder").verdict is Verdict.OK
    computer.spoil(free_disk=lambda place: 300_000_000)
    found = finding(computer, machine, "flight recorder")
    assert found.verdict is Verdict.WARN
    assert found.found.startswith("300 MB free for /var/lib/tandem/recorder, 1024 MB are recorded")
    assert "2048 MB" in found.remedy
    off = machine.model_copy(update={"recorder": machine.recorder.model_copy(update={"enabled": False})})
    assert finding(computer, off, "flight recorder").verdict is Verdict.OK


def test_the_interrupt_thread_of_the_can_card_has_to_be_above_the_cycle(computer: Computer, machine: Machine) -> None:
    computer.outputs["ps"] = "  812     50 irq/45-can0\n  813     50 irq/46-eth0\n    1      - systemd\n"
    found = finding(computer, machine, "interrupt threads")
    assert found.verdict is Verdict.WARN
    assert found.found == "irq/45-can0 has SCHED_FIFO 50, the cycle 80"
    assert "chrt --fifo -p 85 812" in found.remedy
    computer.outputs["ps"] = "  812     85 irq/45-can0\n"
    assert finding(computer, machine, "interrupt threads").verdict is Verdict.OK
    computer.outputs["ps"] = "  812     50 irq/45-can0\n"
    computer.write("sys/kernel/realtime", "0")
    assert finding(computer, machine, "interrupt threads").verdict is Verdict.OK, "interrupts are no threads there"
