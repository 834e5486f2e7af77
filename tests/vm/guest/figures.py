"""How long the fieldbus part of a cycle takes on vcan, beside a loop that does nothing but send and receive as many frames."""

from __future__ import annotations

import copy
import time
from typing import Any, Final

import can
import yaml

from runtime.config.loader import DEMO_MACHINE
from runtime.config.machine import Machine
from runtime.drives import DriveState
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import SimulatedNodes

CHANNEL: Final = "vcan0"
DRIVES: Final = 8
CYCLES: Final = 300
ENABLE_LIMIT: Final = 500  # cycles


def eight_drives() -> Machine:
    """Eight linear axes and an I/O node."""
    described: dict[str, Any] = copy.deepcopy(yaml.safe_load(DEMO_MACHINE.read_text()))
    first = described["axes"][0]
    described["axes"] = [
        first | {"name": name, "log_axis": k + 1, "drive": first["drive"] | {"node": k + 1}}
        for k, name in enumerate("XYZABCUV")
    ]
    described["channels"][0]["parameters"]["spindel"] = []
    described["cycle"]["period"] = "10 ms"
    described["fieldbus"]["bus"] = {"interface": "socketcan", "channel": CHANNEL, "heartbeat_timeout": "5 s"}
    return Machine.model_validate(described)


def master_times() -> dict[str, Any]:
    """Frames and µs per cycle of the master, all drives enabled and moving."""
    machine = eight_drives()
    with open_bus(machine.fieldbus.bus) as bus, open_bus(machine.fieldbus.bus) as node_bus:
        nodes = SimulatedNodes(machine, node_bus)
        started = time.monotonic()
        master = CanopenMaster(machine, bus, now=time.monotonic, idle=lambda: nodes.step(time.monotonic()))
        nodes.step(time.monotonic())
        master.start()
        booted = time.monotonic() - started
        image = master.image
        image.enable[:] = True
        times: list[float] = []
        sent = received = 0
        cycles = 0
        while len(times) < CYCLES and cycles < CYCLES + ENABLE_LIMIT:
            cycles += 1
            frames = image.frames_sent, image.frames_received
            begin = time.perf_counter_ns()
            master.read()
            half = time.perf_counter_ns()
            enabled = bool((image.state == DriveState.OPERATION_ENABLED).all())
            image.target_position[:] = image.actual_position
            middle = time.perf_counter_ns()
            master.write()
            end = time.perf_counter_ns()
            nodes.step(time.monotonic())
            if enabled:
                times.append((half - begin + end - middle) / 1000.0)
                sent += image.frames_sent - frames[0]
                received += image.frames_received - frames[1]
        master.stop()
    return _figures(times) | {
        "boot_s": booted, "sent_per_cycle": sent / len(times), "received_per_cycle": received / len(times),
    }  # fmt: skip


def bare_times(sends: int, receives: int) -> dict[str, Any]:
    """The floor: python-can alone, the same numbers of frames."""
    frame = can.Message(arbitration_id=0x201, data=bytes(6), is_extended_id=False)
    times = []
    with open_bus(eight_drives().fieldbus.bus) as bus, open_bus(eight_drives().fieldbus.bus) as other:
        for _ in range(CYCLES):
            for _ in range(receives):
                other.send(frame)
            begin = time.perf_counter_ns()
            while bus.recv(0) is not None:
                pass
            for _ in range(sends):
                bus.send(frame)
            times.append((time.perf_counter_ns() - begin) / 1000.0)
            while other.recv(0) is not None:
                pass
    return _figures(times)


def _figures(times: list[float]) -> dict[str, Any]:
    ordered = sorted(times)
    return {
        "cycles": len(ordered),
        "median_us": ordered[len(ordered) // 2],
        "p99_us": ordered[min(int(len(ordered) * 0.99), len(ordered) - 1)],
    }


def measure() -> dict[str, Any]:
    """Both, as plain data."""
    master = master_times()
    bare = bare_times(round(master["sent_per_cycle"]), round(master["received_per_cycle"]))
    return {"master": master, "bare": bare}
