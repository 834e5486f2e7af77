"""The fieldbus' share of a cycle: read and write of the master on the virtual bus, for the demo machine and for eight drives.

The simulated nodes answer between the two, outside of what is measured. All axes move, the spindle turns, an output
changes now and then. Where other programs want the processors too, the processor time tells more than the clock.
The least frames are a SYNC, a set-point and a feedback per drive, heartbeats and the refresh of the I/O.
"""

from __future__ import annotations

import copy
import math
import time
from typing import Any

import can
import numpy as np
import yaml

from bench.figure import Figure
from bench.stopwatch import as_in_the_cycle, distribution
from runtime.config.loader import DEMO_MACHINE, load_machine
from runtime.config.machine import AxisType, Machine
from runtime.drives import DriveState
from runtime.fieldbus.described import make_links
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import SimulatedNodes
from runtime.fieldbus.wire import planned_traffic

CHANNEL = "bench-fieldbus"
LEAD = 200  # cycles until the drives are enabled
WINDOW = 2000  # cycles
WINDOWS = 10
DRIVES = 8
LIMIT = 250.0  # µs, 99 % of the cycles, for eight drives and an I/O node


def eight_drives() -> Machine:
    """Eight linear axes in cyclic synchronous position mode, and the demo machine's I/O node."""
    described: dict[str, Any] = copy.deepcopy(yaml.safe_load(DEMO_MACHINE.read_text(encoding="utf-8")))
    first = described["axes"][0]
    described["axes"] = [
        first | {"name": name, "log_axis": k + 1, "drive": first["drive"] | {"node": k + 1}}
        for k, name in zip(range(DRIVES), "XYZABCUV", strict=True)
    ]
    described["channels"][0]["parameters"]["spindel"] = []
    return Machine.model_validate(described)


def measure() -> list[Figure]:
    """Read and write together; frames per cycle beside the least; the load beside the calculated one."""
    return [
        *_measure(load_machine(None), "5 nodes", None),
        *_measure(eight_drives(), f"{DRIVES} drives, 1 I/O", LIMIT),
    ]


def _measure(machine: Machine, name: str, limit: float | None) -> list[Figure]:
    period = machine.cycle.period
    clock, processor = time.perf_counter_ns, time.thread_time_ns
    virtual_time = 0.0
    with (
        can.Bus(interface="virtual", channel=CHANNEL) as bus,
        can.Bus(interface="virtual", channel=CHANNEL) as node_bus,
    ):
        nodes = SimulatedNodes(machine, node_bus)

        def idle() -> None:
            nonlocal virtual_time
            virtual_time += 1e-4
            nodes.step(virtual_time)

        master = CanopenMaster(machine, bus, now=lambda: virtual_time, idle=idle)
        image = master.image
        master.start()
        image.enable[:] = True
        linear = np.array([axis.type is not AxisType.SPINDLE for axis in machine.axes])
        cycles = WINDOW * WINDOWS
        work, processor_time, of_the_nodes = (np.empty(cycles, dtype=np.int64) for _ in range(3))
        frames_before = 0
        loads = []
        with as_in_the_cycle():
            for k in range(-LEAD, cycles):
                if k == 0:
                    assert (image.state == DriveState.OPERATION_ENABLED).all(), "the drives did not get enabled"
                    frames_before = image.frames_sent + image.frames_received
                image.target_position[linear] = 50.0 * math.sin(2.0 * math.pi * max(k, 0) * period)
                image.target_velocity[~linear] = 6000.0
                image.digital_out[0] = (k // 250) & 0x0F
                begin = clock()
                spent = processor()
                master.read()
                master.write()
                spent = processor() - spent
                end = clock()
                virtual_time += period
                nodes.step(virtual_time)
                if k >= 0:
                    work[k] = end - begin
                    processor_time[k] = spent
                    of_the_nodes[k] = clock() - end
                    loads.append(image.bus_load)
        frames = image.frames_sent + image.frames_received - frames_before
        master.stop()
    planned = planned_traffic(make_links(machine), machine.fieldbus.bus, period)
    calculated = planned.bits / machine.fieldbus.bus.bitrate
    return [
        *distribution(f"{name}: read and write", np.split(work, WINDOWS), limit),
        Figure(f"{name}: processor time, 99 %", float(np.percentile(processor_time, 99)) / 1000.0, "µs", limit),
        Figure(f"{name}: frames per cycle", frames / cycles, ""),
        Figure(f"{name}: least frames per cycle", planned.frames * period, ""),
        Figure(f"{name}: bus load", float(np.mean(loads)) * 100.0, "%"),
        Figure(f"{name}: bus load, calculated", calculated * 100.0, "%"),
        Figure(f"{name}: simulated nodes, median", float(np.median(of_the_nodes)) / 1000.0, "µs"),
    ]
