"""What a host needs to run a machine in real time: one check per need, each with what to do if it is not met.

A check reads the files under `Host.root` and asks the few system calls that `Host` carries: a test can make any host.
"""

from __future__ import annotations

import json
import os
import platform
import re
import shutil
import socket
import subprocess
import threading
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from enum import StrEnum
from pathlib import Path

from runtime.config.machine import Bus, Machine
from runtime.kernel_cache import places
from runtime.recorder.store import FOLDER
from runtime.scheduler.realtime import RefusedError, expect_memory_lock, set_priority
from runtime.scheduler.retained import state_directory

_CAN_TYPE = "280"  # ARPHRD_CAN in /sys/class/net/*/type
_SLOW_WAKE_UP = 50  # µs of exit latency that a cycle of 1 ms can bear
_SHARED_MEMORY = 80_000_000  # bytes that the interface memory, queues and rings fit into
_OLDEST_SYSTEMD = 247


class Verdict(StrEnum):
    OK = "ok"
    WARN = "warn"  # runs, with more jitter or less comfort
    FAIL = "fail"  # this machine does not run here


@dataclass(frozen=True, slots=True)
class Finding:
    """What a check found, and what to do about it."""

    check: str
    verdict: Verdict
    found: str
    remedy: str = ""


def _try_priority(priority: int) -> str | None:
    """Why SCHED_FIFO is refused; tried in a thread of its own, whose priority ends with it."""
    reasons: list[str] = []

    def attempt() -> None:
        try:
            set_priority(priority)
        except RefusedError as refused:
            reasons.append(str(refused))

    thread = threading.Thread(target=attempt)
    thread.start()
    thread.join()
    return reasons[0] if reasons else None


def _try_memory_lock() -> str | None:
    try:
        expect_memory_lock()
    except RefusedError as refused:
        return str(refused)
    return None


def _try_can_socket() -> str | None:
    """Why there are no CAN sockets; asking for one loads the kernel's module where it can."""
    try:
        socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).close()
    except OSError as error:
        return error.strerror or str(error)
    return None


def _output(*command: str) -> str:
    """What a program prints; nothing if it is missing or fails."""
    if shutil.which(command[0]) is None:
        return ""
    return subprocess.run(command, capture_output=True, text=True, check=False, timeout=10).stdout


def _writable(path: Path) -> bool:
    return os.access(path, os.W_OK)


@dataclass(frozen=True)
class Host:
    """The computer; everything that a check asks of it."""

    root: Path = Path("/")
    environment: Mapping[str, str] = field(default_factory=dict)
    refused_priority: Callable[[int], str | None] = _try_priority
    refused_memory_lock: Callable[[], str | None] = _try_memory_lock
    refused_can: Callable[[], str | None] = _try_can_socket
    output: Callable[..., str] = _output
    writable: Callable[[Path], bool] = _writable
    free_shared_memory: Callable[[], int] = lambda: shutil.disk_usage("/dev/shm").free
    free_disk: Callable[[Path], int] = lambda place: shutil.disk_usage(place).free

    def read(self, path: str) -> str:
        """Content of a file under the root, "" if it cannot be read."""
        try:
            return (self.root / path).read_text(errors="replace").strip()
        except OSError:
            return ""


Check = Callable[[Host, Machine], Finding | list[Finding]]


def kernel(host: Host, machine: Machine) -> Finding:
    release = host.read("proc/sys/kernel/osrelease") or platform.release()
    if host.read("sys/kernel/realtime") == "1" or "PREEMPT_RT" in host.read("proc/sys/kernel/version"):
        return Finding("kernel", Verdict.OK, f"{release}, PREEMPT_RT")
    remedy = "Install a PREEMPT_RT kernel (Debian: linux-image-rt-amd64) for jitter far below the cycle time."
    return Finding("kernel", Verdict.WARN, f"{release}, not PREEMPT_RT", remedy)


def priority(host: Host, machine: Machine) -> Finding:
    wanted = machine.cycle.priority
    if (reason := host.refused_priority(wanted)) is None:
        return Finding("real-time priority", Verdict.OK, f"SCHED_FIFO {wanted} is granted")
    remedy = "Set LimitRTPRIO=98 in the service, or `@GROUP - rtprio 98` in /etc/security/limits.d, and log in again."
    return Finding("real-time priority", Verdict.WARN, reason, remedy)


def memory_lock(host: Host, machine: Machine) -> Finding:
    if (reason := host.refused_memory_lock()) is None:
        return Finding("memory lock", Verdict.OK, "all memory may be locked")
    remedy = "Set LimitMEMLOCK=infinity in the service, or `@GROUP - memlock unlimited` in /etc/security/limits.d."
    return Finding("memory lock", Verdict.WARN, reason, remedy)


def processors(host: Host, machine: Machine) -> Finding:
    name, cpu = "processors", machine.cycle.cpu
    present, isolated = host.read("sys/devices/system/cpu/online"), host.read("sys/devices/system/cpu/isolated")
    found = f"{present} online, {isolated or 'none'} isolated"
    if cpu is not None and cpu not in _cpu_list(present):
        return Finding(
            name, Verdict.FAIL, f"{found}; cycle.cpu is {cpu}", "Set cycle.cpu to a processor that is there."
        )
    if len(_cpu_list(present)) == 1:
        return Finding(name, Verdict.WARN, found, "Use a computer with two cores or more: one for the cycle alone.")
    if cpu is not None and cpu in _cpu_list(isolated):
        return Finding(name, Verdict.OK, f"{found}; the cycle runs on {cpu}")
    last = max(_cpu_list(present), default=0) if cpu is None else cpu
    remedy = f"Boot with isolcpus={last} nohz_full={last} rcu_nocbs={last} and set cycle.cpu: {last}."
    return Finding(name, Verdict.WARN, found, remedy)


def governor(host: Host, machine: Machine) -> Finding:
    files = sorted((host.root / "sys/devices/system/cpu").glob("cpu[0-9]*/cpufreq/scaling_governor"))
    governors = {file.read_text().strip() for file in files}
    if not governors:
        return Finding("processor frequency", Verdict.OK, "not scaled")
    found = ", ".join(sorted(governors))
    if governors == {"performance"}:
        return Finding("processor frequency", Verdict.OK, found)
    return Finding("processor frequency", Verdict.WARN, found, "cpupower frequency-set -g performance")


def sleep_states(host: Host, machine: Machine) -> Finding:
    name = "sleep states"
    latencies = [
        int((state / "latency").read_text())
        for state in (host.root / "sys/devices/system/cpu").glob("cpu[0-9]*/cpuidle/state*")
        if host.read(str((state / "disable").relative_to(host.root))) != "1"
    ]
    deepest = max(latencies, default=0)
    if deepest <= _SLOW_WAKE_UP:
        return Finding(name, Verdict.OK, f"wake-up within {deepest} µs")
    if host.writable(host.root / "dev/cpu_dma_latency"):
        return Finding(name, Verdict.OK, f"wake-up within {deepest} µs, kept awake through /dev/cpu_dma_latency")
    remedy = (
        "Give the user write access to /dev/cpu_dma_latency (systemd/udev/80-tandem.rules), "
        "or boot with processor.max_cstate=1 intel_idle.max_cstate=1."
    )
    return Finding(name, Verdict.WARN, f"wake-up takes up to {deepest} µs", remedy)


def clock_source(host: Host, machine: Machine) -> Finding:
    source = host.read("sys/devices/system/clocksource/clocksource0/current_clocksource")
    if source in ("tsc", "arch_sys_counter", "kvm-clock", "timebase", "riscv_clocksource"):
        return Finding("clock source", Verdict.OK, source)
    remedy = (
        "The processor's own counter was found unstable; look into the kernel log for the reason (dmesg | grep -i tsc)."
    )
    return Finding("clock source", Verdict.WARN, source or "unknown", remedy)


def can(host: Host, machine: Machine) -> list[Finding]:
    """A finding per bus."""
    return [_can_bus(host, name, bus) for name, bus in machine.fieldbus.all_buses().items()]


def _can_bus(host: Host, name: str, bus: Bus) -> Finding:
    check = f"CAN {name}".strip()
    needed = bus.interface == "socketcan"
    missing = Verdict.FAIL if needed else Verdict.OK
    unused = "" if needed else f"; this machine uses {bus.interface}"
    if reason := host.refused_can():
        remedy = "Use a kernel with CAN (CONFIG_CAN, CONFIG_CAN_RAW): every kernel of Debian has it." if needed else ""
        return Finding(check, missing, f"no CAN sockets: {reason}{unused}", remedy)
    folder = host.root / "sys/class/net"
    names = sorted(
        entry.name for entry in folder.glob("*") if host.read(f"sys/class/net/{entry.name}/type") == _CAN_TYPE
    )
    if not needed:
        return Finding(check, Verdict.OK, f"interfaces: {', '.join(names) or 'none'}{unused}")
    if bus.channel not in names:
        key = f"fieldbus.buses.{name}.channel" if name else "fieldbus.bus.channel"
        remedy = (
            f"Load the driver of the CAN card and name its interface {bus.channel} (systemd/network/80-can0.link), "
            f"or set {key}."
        )
        return Finding(
            check, Verdict.FAIL, f"{bus.channel} is missing; there are: {', '.join(names) or 'none'}", remedy
        )
    return _can_interface(host, check, bus)


def _can_interface(host: Host, check: str, bus: Bus) -> Finding:
    details = host.output("ip", "-details", "-json", "link", "show", bus.channel)
    link = (json.loads(details) or [{}])[0] if details.strip() else {}
    info = link.get("linkinfo", {})
    data = info.get("info_data", {})
    state, bitrate = str(data.get("state", "unknown")), data.get("bittiming", {}).get("bitrate")
    up = host.read(f"sys/class/net/{bus.channel}/operstate") == "up" or info.get("info_kind") == "vcan"
    found = f"{bus.channel}: {'up' if up else 'down'}, {state}" + (f", {bitrate} bit/s" if bitrate else "")
    start = f"ip link set {bus.channel} up type can bitrate {bus.bitrate} restart-ms 100"
    if not up:
        return Finding(check, Verdict.FAIL, found, f"{start}; or systemd/network/80-can0.network for every boot")
    if bitrate and bitrate != bus.bitrate:
        remedy = f"The description says {bus.bitrate} bit/s: ip link set {bus.channel} down; {start}"
        return Finding(check, Verdict.FAIL, found, remedy)
    if state in ("BUS-OFF", "ERROR-PASSIVE", "ERROR-WARNING"):
        verdict = Verdict.FAIL if state == "BUS-OFF" else Verdict.WARN
        remedy = "Look at termination (60 Ω between CAN-H and CAN-L), wiring, and the bit rate of all nodes."
        return Finding(check, verdict, found, remedy)
    return Finding(check, Verdict.OK, found)


def interrupts(host: Host, machine: Machine) -> Finding:
    """On PREEMPT_RT interrupts are threads: SCHED_FIFO 50, below the cycle. That of the CAN card has to be above it."""
    name = "interrupt threads"
    if host.read("sys/kernel/realtime") != "1" or machine.fieldbus.bus.interface != "socketcan":
        return Finding(name, Verdict.OK, "no matter on this kernel or bus")
    wanted, channel = machine.cycle.priority, machine.fieldbus.bus.channel
    found = []
    for number, priority, thread in _interrupt_threads(host, channel):
        found.append(f"{thread} {priority}")
        if priority <= wanted:
            remedy = (
                f"chrt --fifo -p {wanted + 5} {number} (and in a udev rule or at boot): frames that wait behind a cycle that "
                f"polls come late; or set cycle.priority below {priority}."
            )
            return Finding(name, Verdict.WARN, f"{thread} has SCHED_FIFO {priority}, the cycle {wanted}", remedy)
    return Finding(name, Verdict.OK, ", ".join(found) or f"none is named after {channel}")


def _interrupt_threads(host: Host, channel: str) -> list[tuple[int, int, str]]:
    """Process id, real-time priority and name of the threads of a card's interrupts: `irq/NUMBER-NAME`."""
    lines = host.output("ps", "-eo", "pid=,rtprio=,comm=").splitlines()
    threads = []
    for line in lines:
        parts = line.split(None, 2)
        if len(parts) == 3 and parts[1].isdigit() and re.match(rf"irq/\d+-.*{re.escape(channel)}", parts[2]):
            threads.append((int(parts[0]), int(parts[1]), parts[2]))
    return threads


def recorder_room(host: Host, machine: Machine) -> Finding:
    """The disk has what the recorder may take, and twice that beside it for what is saved and retained."""
    name, settings = "flight recorder", machine.recorder
    if not settings.enabled:
        return Finding(name, Verdict.OK, "switched off")
    folder = state_directory(machine.state_directory, host.environment)
    existing = next(place for place in (folder, *folder.parents) if place.exists())
    free, wanted = host.free_disk(existing) // 1_000_000, 2 * settings.size
    found = f"{free} MB free for {folder / FOLDER}, {settings.size} MB are recorded"
    if free < wanted:
        remedy = f"Make room for {wanted} MB, or give recorder.size less: a full disk costs the recording."
        return Finding(name, Verdict.WARN, found, remedy)
    return Finding(name, Verdict.OK, found)


def systemd(host: Host, machine: Machine) -> Finding:
    match = re.match(r"systemd (\d+)", host.output("systemctl", "--version"))
    if match is None:
        return Finding(
            "systemd", Verdict.WARN, "not found", "Without it there is no service: start `tandem run` yourself."
        )
    if int(match[1]) < _OLDEST_SYSTEMD:
        return Finding("systemd", Verdict.WARN, match[1], f"The units are written for {_OLDEST_SYSTEMD} and newer.")
    return Finding("systemd", Verdict.OK, match[1])


def compiled_kernels(host: Host, machine: Machine) -> Finding:
    """Whether the machine code of the kernels outlives a start."""
    tried = places(host.environment)
    for place in tried:
        existing = next(folder for folder in (place, *place.parents) if folder.exists())
        if host.writable(existing):
            return Finding("compiled kernels", Verdict.OK, f"kept in {place}")
    remedy = "Set NUMBA_CACHE_DIR to a folder that this user may write to, else every start compiles for a while."
    found = f"cannot be written: {', '.join(map(str, tried))}"
    return Finding("compiled kernels", Verdict.WARN, found, remedy)


def shared_memory(host: Host, machine: Machine) -> Finding:
    try:
        free = host.free_shared_memory()
    except OSError as error:
        remedy = "mount -t tmpfs tmpfs /dev/shm"
        return Finding("shared memory", Verdict.FAIL, f"/dev/shm: {error.strerror or error}", remedy)
    found = f"{free // 1_000_000} MB free in /dev/shm"
    if free < _SHARED_MEMORY:
        remedy = f"{_SHARED_MEMORY // 1_000_000} MB are needed: mount -o remount,size=256M /dev/shm"
        return Finding("shared memory", Verdict.FAIL, found, remedy)
    return Finding("shared memory", Verdict.OK, found)


CHECKS: tuple[Check, ...] = (
    kernel,
    priority,
    memory_lock,
    processors,
    interrupts,
    governor,
    sleep_states,
    clock_source,
    can,
    shared_memory,
    compiled_kernels,
    recorder_room,
    systemd,
)


def examine(host: Host, machine: Machine) -> list[Finding]:
    """All checks, in the order of their weight."""
    findings: list[Finding] = []
    for check in CHECKS:
        found = check(host, machine)
        findings += found if isinstance(found, list) else [found]
    return findings


def _cpu_list(text: str) -> set[int]:
    """ "0-2,5" → {0, 1, 2, 5}."""
    cpus: set[int] = set()
    for part in filter(None, text.split(",")):
        first, _, last = part.partition("-")
        cpus |= set(range(int(first), int(last or first) + 1))
    return cpus
