"""The fieldbus' share of a cycle: read and write of the master with the demo machine's five nodes on the virtual bus.

The simulated nodes answer between the two, outside of what is measured. All axes move, the spindle turns, an output
changes now and then.
"""

from __future__ import annotations

import math
import time

import can
import numpy as np

from bench.figure import Figure
from bench.stopwatch import as_in_the_cycle, distribution
from runtime.config.loader import load_machine
from runtime.drives import DriveState
from runtime.fieldbus.master import CanopenMaster
from runtime.fieldbus.simulator import SimulatedNodes

CHANNEL = "bench-fieldbus"
LEAD = 200  # cycles until the drives are enabled
WINDOW = 2000  # cycles
WINDOWS = 10


def measure() -> list[Figure]:
    """Read and write together; frames per cycle; what the simulated nodes take meanwhile."""
    machine = load_machine(None)
    period = machine.cycle.period
    clock = time.perf_counter_ns
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
        cycles = WINDOW * WINDOWS
        work, of_the_nodes = np.empty(cycles, dtype=np.int64), np.empty(cycles, dtype=np.int64)
        frames_before = 0
        with as_in_the_cycle():
            for k in range(-LEAD, cycles):
                if k == 0:
                    assert (image.state == DriveState.OPERATION_ENABLED).all(), "the drives did not get enabled"
                    frames_before = image.frames_sent + image.frames_received
                image.target_position[:3] = 50.0 * math.sin(2.0 * math.pi * max(k, 0) * period)
                image.target_velocity[3] = 6000.0
                image.digital_out[0] = (k // 250) & 0x0F
                begin = clock()
                master.read()
                master.write()
                end = clock()
                virtual_time += period
                nodes.step(virtual_time)
                if k >= 0:
                    work[k] = end - begin
                    of_the_nodes[k] = clock() - end
        frames = image.frames_sent + image.frames_received - frames_before
        master.stop()
    return [
        *distribution("read and write", np.split(work, WINDOWS)),
        Figure("frames per cycle", frames / cycles, ""),
        Figure("simulated nodes, median", float(np.median(of_the_nodes)) / 1000.0, "µs"),
    ]
