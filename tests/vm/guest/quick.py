"""All that happens in the quick form, in one boot: figures on vcan, a program, then one thing after the other goes wrong.

python -m tests.vm.guest.quick FOLDER            writes FOLDER/observations.json and FOLDER/wire.bin
"""

from __future__ import annotations

import json
import os
import socket
import struct
import subprocess
import sys
import time
import traceback
from collections.abc import Callable
from pathlib import Path
from typing import Any, Final

import can

from runtime.diagnostics.catalogue import fieldbus
from runtime.hli.layout import State
from tests.vm.guest import figures
from tests.vm.guest.machine import GuestMachine, on_two_buses

Scene = Callable[[GuestMachine, dict[str, Any], Path], None]

NODES: Final = 5
FLOOD_TIME: Final = 3.0  # s

PROGRAM = """N10 G53 G90 G17 G94
N20 M20
N30 S6000 M3
N40 G00 X20 Y20 Z20
N50 G01 Z10 F3000
N60 G01 X60 F6000
N70 G03 X80 Y40 I0 J20
N80 G01 Y60
N90 G01 X20 Y20
N100 M5
N110 M21
N120 M30
"""
LONG_PROGRAM = """N10 G53 G90 G17 G94
N20 $FOR P1 = 1, 100, 1
N30 G01 X60 Y20 F6000
N40 G01 X20 Y60
N50 $ENDFOR
N60 M30
"""


def links_up() -> None:
    """The cards as systemd-networkd would set them up, and virtual interfaces, one of them with CAN FD."""
    for command in (
        "ip link set can0 type can bitrate 1000000 restart-ms 100",
        "ip link set can0 txqueuelen 100",
        "ip link set can0 up",
        "ip link set can1 type can bitrate 1000000 restart-ms 100",
        "ip link set can1 txqueuelen 1000",
        "ip link set can1 up",
        "ip link add vcan0 type vcan",
        "ip link set vcan0 txqueuelen 1000",
        "ip link set vcan0 up",
        "ip link add vcan1 type vcan",
        "ip link set vcan1 txqueuelen 1000",
        "ip link set vcan1 up",
        "ip link add vcan2 type vcan",
        "ip link set vcan2 mtu 72",
        "ip link set vcan2 txqueuelen 1000",
        "ip link set vcan2 up",
    ):
        subprocess.run(command.split(), check=True)


def observe(folder: Path, seen: dict[str, Any]) -> None:
    """Fills `seen`, a group per scene; raises whatever goes wrong."""
    links_up()
    seen["kernel"] = os.uname().version
    seen["figures"] = figures.measure()
    print("figures", seen["figures"], flush=True)
    machine = GuestMachine(folder)
    seen["steps"] = machine.steps
    try:
        _scenes(machine, folder, seen)
    finally:
        machine.end()
    seen["two_buses"] = {}
    two_buses(folder, seen["two_buses"])


def two_buses(folder: Path, scene: dict[str, Any]) -> None:
    """Another machine, on two virtual interfaces, the second one with frames of CAN FD; it mills the same program."""
    described = on_two_buses("vcan1", "vcan2")
    machine = GuestMachine(folder, described, described, "two-buses")
    try:
        machine.start()
        machine.wait_for("running", machine.attached, 900.0)
        machine.wait_for("enabled", lambda: all(machine.enabled()) and bool(machine.hli.platform.plc_running_r))
        machine.forget_alarms()
        scene["refused"] = machine.order_start(Path("/run/tmp/part.nc"))
        machine.wait_for("milling", lambda: machine.state() is State.ACTIVE)
        scene["fast"] = _frames("vcan2", fd=True)
        scene["classical"] = _frames("vcan1", fd=False)
        machine.wait_for("milled", lambda: machine.state() is not State.ACTIVE)
        scene |= _look(machine)
        scene["exit_code"] = machine.stop()
    finally:
        machine.end()


def _frames(channel: str, *, fd: bool) -> dict[str, list[bool]]:
    """For a second: which identifiers came, each with the kinds of its frames (TRUE: CAN FD)."""
    kinds: dict[str, set[bool]] = {}
    with can.Bus(interface="socketcan", channel=channel, fd=fd) as listener:
        end = time.monotonic() + 1.0
        while time.monotonic() < end:
            if message := listener.recv(0.1):
                kinds.setdefault(hex(message.arbitration_id), set()).add(message.is_fd)
    return {identifier: sorted(found) for identifier, found in kinds.items()}


def _scenes(machine: GuestMachine, folder: Path, seen: dict[str, Any]) -> None:
    program, long_program = Path("/run/tmp/part.nc"), Path("/run/tmp/long.nc")
    program.write_text(PROGRAM)
    long_program.write_text(LONG_PROGRAM)
    machine.start()
    machine.wait_for("running", machine.attached, 900.0)
    if machine.state() is State.ERROR:  # a computer so busy that heartbeats were late while the processes started
        machine.pause(10.0)
        machine.reset()
    machine.wait_for("enabled", lambda: all(machine.enabled()) and bool(machine.hli.platform.plc_running_r))
    machine.forget_alarms()

    seen["milling"] = scene = {"refused": machine.order_start(program)}
    machine.wait_for("milling", lambda: machine.state() is State.ACTIVE)
    machine.wait_for("milled", lambda: machine.state() is not State.ACTIVE)
    scene |= _look(machine)

    for name, play in SCENES.items():
        machine.forget_alarms()
        seen[name] = scene = {}
        play(machine, scene, long_program)

    seen["exit_code"] = machine.stop()


def _look(machine: GuestMachine) -> dict[str, Any]:
    platform = machine.hli.platform
    return {
        "state": machine.state().name,
        "positions": machine.positions(),
        "alarms": machine.alarms(),
        "enabled": machine.enabled(),
        "bus_load": platform.bus_load_r,
        "overruns": platform.overruns_r,
        "work_time_us": platform.work_time_ns_r / 1000.0,
    }


def _move(machine: GuestMachine, program: Path, scene: dict[str, Any]) -> None:
    scene["refused"] = machine.order_start(program)
    machine.wait_for("moving", lambda: machine.state() is State.ACTIVE)
    machine.pause(1.0)


def _rest(machine: GuestMachine) -> None:
    """The scene is over: everything acknowledged, all drives enabled again."""
    machine.reset()
    machine.wait_for("enabled again", lambda: all(machine.enabled()) and machine.state() is State.SELECTED)


def unplug(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """The cable of node 2 is cut in motion, and mended."""
    _move(machine, program, scene)
    machine.tell_drives("silent 2")
    machine.wait_for("unplugged", lambda: machine.state() is State.ERROR)
    machine.pause(8.0)  # longer than its heartbeat may be missing
    scene["after"] = _look(machine)
    machine.tell_drives("heal 2")
    machine.wait_for("plugged", lambda: machine.has_alarm(fieldbus.NODE_REJOINED.id))
    _rest(machine)


def reboot(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """The supply of node 3 fails for a moment, at rest."""
    machine.tell_drives("reboot 3")
    machine.wait_for("rebooted", lambda: machine.has_alarm(fieldbus.NODE_RESTARTED.id))
    machine.wait_for("back after reboot", lambda: machine.has_alarm(fieldbus.NODE_REJOINED.id))
    scene["after"] = _look(machine)
    _rest(machine)


def flood(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """A station fills the wire with frames of nobody, in motion; every frame of ours goes before its frames."""
    _fill(machine, scene, program, 0x7F0, "flood")


def babble(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """A broken station does the same with an identifier that goes before everything but NMT."""
    _fill(machine, scene, program, 0x001, "babble")


def _fill(machine: GuestMachine, scene: dict[str, Any], program: Path, identifier: int, name: str) -> None:
    _move(machine, program, scene)
    machine.steps[name] = time.time()
    frame = can.Message(arbitration_id=identifier, data=bytes(8), is_extended_id=False)
    sent = 0
    with can.Bus(interface="socketcan", channel="can1") as station:
        end = time.monotonic() + FLOOD_TIME
        while time.monotonic() < end:
            try:
                station.send(frame)
                sent += 1
            except can.CanError:  # its queue is full: that is the point
                time.sleep(0.001)
    machine.steps[f"{name} over"] = time.time()
    machine.pause(2.0)
    scene |= {"sent": sent, "after": _look(machine)}
    _rest(machine)


def bus_off(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """The controller of the master says that it has left the bus, in motion, and comes back.

    An emulated wire has no bit errors. What the driver tells in such a case is an error frame, and everybody may send one: the
    other sockets of the card get it as they would get the driver's.
    """
    _move(machine, program, scene)
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as driver:
        driver.bind(("can0",))
        driver.send(
            struct.pack("=IB3x8s", socket.CAN_ERR_FLAG | 0x40, 8, bytes(8))
        )  # CAN_ERR_BUSOFF, linux/can/error.h
    machine.wait_for("bus off", lambda: machine.state() is State.ERROR)
    machine.wait_for("bus back", lambda: sum(n == fieldbus.NODE_REJOINED.id for n, _ in machine.alarms()) == NODES)
    scene["after"] = _look(machine)
    _rest(machine)


def interface_down(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """The interface of the master is taken down in motion, and up again."""
    _move(machine, program, scene)
    subprocess.run(["ip", "link", "set", "can0", "down"], check=True)
    machine.wait_for("down", lambda: machine.state() is State.ERROR)
    machine.pause(4.0)
    scene["after"] = _look(machine)
    subprocess.run(["ip", "link", "set", "can0", "up"], check=True)
    machine.wait_for("up", lambda: sum(number == fieldbus.NODE_REJOINED.id for number, _ in machine.alarms()) == NODES)
    scene["up"] = _look(machine)
    _rest(machine)


def mill_again(machine: GuestMachine, scene: dict[str, Any], program: Path) -> None:
    """After all that the machine does what it did before."""
    scene["refused"] = machine.order_start(Path("/run/tmp/part.nc"))
    machine.wait_for("milling again", lambda: machine.state() is State.ACTIVE)
    machine.wait_for("milled again", lambda: machine.state() is not State.ACTIVE)
    scene |= _look(machine)


SCENES: dict[str, Scene] = {
    "unplug": unplug,
    "reboot": reboot,
    "flood": flood,
    "babble": babble,
    "bus_off": bus_off,
    "interface_down": interface_down,
    "mill_again": mill_again,
}


def main() -> int:
    folder = Path(sys.argv[1])
    Path("/run/tmp").mkdir(exist_ok=True)
    seen: dict[str, Any] = {}
    try:
        observe(folder, seen)
    except Exception:  # whatever it was, what was seen so far is worth having
        seen["failure"] = traceback.format_exc()
        print(seen["failure"])
    (folder / "observations.json").write_text(json.dumps(seen, indent=1))
    return 1 if "failure" in seen else 0


if __name__ == "__main__":
    sys.exit(main())
