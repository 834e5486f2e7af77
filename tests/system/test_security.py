"""What of a running machine others can reach: its sockets, its memory, its files."""

from __future__ import annotations

import os
import socket
import urllib.error
import urllib.request
from pathlib import Path

import pytest

from runtime.config.loader import load_machine
from tests.system.running_machine import MODULES, RunningMachine
from tests.system.sockets import network_sockets

WRITING = ("POST", "PUT", "DELETE", "PATCH", "PROPPATCH", "CONNECT")


def other_addresses() -> list[str]:
    """Addresses of this computer that are not the loopback one."""
    try:
        found = {str(entry[4][0]) for entry in socket.getaddrinfo(socket.gethostname(), None, socket.AF_INET)}
    except OSError:
        found = set()
    return sorted({*found, "127.0.0.2"} - {"127.0.0.1"})


def test_nothing_reachable_from_the_network_can_write(machine: RunningMachine) -> None:
    machine.start()
    memory = machine.memory
    text = machine.scrape()
    url = machine.log.read_text().split("metrics on ")[1].split()[0]
    port = int(url.split(":")[2].split("/")[0])
    bus = load_machine(machine.machine).fieldbus.bus

    # every socket of every process: the metrics on loopback, and of the demo machine its bus, a group on loopback
    pids = [machine.pid_of(name) for name in MODULES]
    listening = {(s.family, s.address, s.port) for s in network_sockets(pids) if s.listening}
    assert listening == {("tcp", "127.0.0.1", port), ("udp", bus.channel, bus.options["port"])}
    for address in other_addresses():
        with socket.socket() as stranger:
            stranger.settimeout(5.0)
            assert stranger.connect_ex((address, port)) != 0, address

    # asking changes nothing, whatever is asked
    before = bytes(memory.hli.operator[0])
    for method in WRITING:
        with pytest.raises((urllib.error.HTTPError, OSError)):
            urllib.request.urlopen(urllib.request.Request(url, data=b"x" * 1000, method=method), timeout=10)
    for path in ("/../../../etc/passwd", "/%2e%2e/%2e%2e/etc/passwd", "//etc/passwd", "/?name[]=/etc/passwd"):
        with urllib.request.urlopen(url.replace("/metrics", path), timeout=10) as answer:
            assert b"root:" not in answer.read()
    assert bytes(memory.hli.operator[0]) == before
    assert "tandem_" in text

    # memory and files: the group reads the HLI, others nothing
    shared = {path.name: path.stat() for path in Path("/dev/shm").glob(f"{machine.name}*")}
    assert shared[machine.name].st_mode & 0o777 == 0o640
    for name, status in shared.items():
        assert status.st_mode & 0o137 == 0, f"{name}: {status.st_mode:o}"
        assert status.st_uid == os.geteuid()
    for file in machine.state.rglob("*"):
        if file.is_file() and file.name.startswith(("retained", "plc-retain")):
            assert file.stat().st_mode & 0o137 == 0, file
    assert machine.stop() == 0


def test_memory_for_a_group_that_commands_or_for_nobody(tmp_path: Path) -> None:
    """Only what the description says."""
    for word, mode in (("read", 0o640), ("command", 0o660), ("none", 0o600)):
        text = (Path("config/machine.yaml").read_text()).replace("# hli: {group: read}", f"hli: {{group: {word}}}")
        assert f"group: {word}" in text
        file = tmp_path / "machine.yaml"
        file.write_text(text)
        assert load_machine(file).hli.permissions == mode
