"""The fieldbus' share of a cycle: read and write of the master with the demo machine's five nodes on the virtual bus.

The simulated nodes answer between the two, outside of what is measured.
"""

from __future__ import annotations

import math
import time
from importlib import resources

import can
import numpy as np
import yaml

from runtime.config.machine import Machine
from runtime.drives import DriveState
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import SimulatedNodes


def fieldbus_cycle(cycles: int = 20_000) -> dict[str, float]:
    """The master's read + write in µs (median, percentiles, maximum), frames per cycle, the time of the nodes."""
    text = resources.files("runtime.demo").joinpath("machine.yaml").read_text(encoding="utf-8")
    description = yaml.safe_load(text)
    description["fieldbus"]["bus"] = {"interface": "virtual", "channel": "bench-fieldbus"}
    machine = Machine.model_validate(description)
    period = machine.cycle.period
    virtual_time = 0.0
    with (
        can.Bus(interface="virtual", channel="bench-fieldbus") as bus,
        can.Bus(interface="virtual", channel="bench-fieldbus") as node_bus,
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
        work, node_work = np.empty(cycles), np.empty(cycles)
        warm_up = 200
        frames_before = 0
        for k in range(-warm_up, cycles):
            if k == 0:
                assert (image.state == DriveState.OPERATION_ENABLED).all(), "the drives did not get enabled"
                frames_before = image.frames_sent + image.frames_received
            # all axes move, the spindle turns, an output changes now and then
            image.target_position[:3] = 50.0 * math.sin(2.0 * math.pi * max(k, 0) * period)
            image.target_velocity[3] = 6000.0
            image.digital_out[0] = (k // 250) & 0x0F
            t0 = time.perf_counter()
            master.read()
            t1 = time.perf_counter()
            # the rest of the cycle would be here
            t2 = time.perf_counter()
            master.write()
            t3 = time.perf_counter()
            virtual_time += period
            nodes.step(virtual_time)
            t4 = time.perf_counter()
            if k >= 0:
                work[k] = (t1 - t0) + (t3 - t2)
                node_work[k] = t4 - t3
        frames = image.frames_sent + image.frames_received - frames_before
        master.stop()
    median, p99, p999 = np.percentile(work * 1e6, (50, 99, 99.9)).tolist()
    return {
        "median_us": median,
        "p99_us": p99,
        "p99_9_us": p999,
        "max_us": float(work.max() * 1e6),
        "frames_per_cycle": frames / cycles,
        "simulated_nodes_median_us": float(np.median(node_work) * 1e6),
    }


if __name__ == "__main__":
    for name, value in fieldbus_cycle().items():
        print(f"{name:30} {value:10.1f}")
