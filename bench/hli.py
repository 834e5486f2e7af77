"""What the HLI and a PLC cycle cost."""

from __future__ import annotations

from collections.abc import Callable

import numpy as np

from bench.figure import Figure
from bench.stopwatch import as_in_the_cycle, each, seconds
from runtime.config.loader import load_machine
from runtime.demo.plc import DemoMill
from runtime.hli.client import snapshot
from runtime.hli.control import AxisCommands, ChannelCommands
from runtime.hli.layout import Hli
from runtime.hli.memory import HliMemory
from runtime.hli.technology import Function, Kind, TechnologyPort
from runtime.plc_logic.bench import Bench

ACCESSES = 100_000


def measure() -> list[Figure]:
    """Access to a field, the CNC's side of the units, cycles of the demo's PLC program, a snapshot."""
    with as_in_the_cycle():
        return [*_access(), *_plc(), *_cnc()]


def _call(name: str, call: Callable[[], object], calls: int = 1000) -> list[Figure]:
    """Median and 99 % of the best window."""
    windows = each(call, calls)
    best = min(windows, key=lambda window: float(np.percentile(window, 99)))
    median, p99 = (np.percentile(best, (50, 99)) / 1000.0).tolist()
    return [Figure(f"{name}, median", median, "µs"), Figure(f"{name}, 99 %", p99, "µs")]


def _access() -> list[Figure]:
    hli: Hli = HliMemory.private().hli
    status = hli.channels[0].status

    def read() -> None:
        for _ in range(ACCESSES):
            status.line_r  # noqa: B018

    def write() -> None:
        for _ in range(ACCESSES):
            status.line_r = 1

    def read_from_the_root() -> None:
        for _ in range(ACCESSES):
            hli.channels[0].status.line_r  # noqa: B018

    return [
        Figure(name, seconds(call) / ACCESSES * 1e6, "µs")
        for name, call in (
            ("read a field of a structure at hand", read),
            ("write a field of a structure at hand", write),
            ("read a field from the root", read_from_the_root),
        )
    ]


def _plc() -> list[Figure]:
    node = load_machine(None).fieldbus.io[0]
    bench = Bench(DemoMill, inputs=node.inputs, outputs=node.outputs)
    bench.set(door_closed=True, e_stop_ok=True)
    bench.spindle("S", 0)
    bench.run(0.1)

    def cycle() -> None:
        bench.time_ns += 4_000_000
        bench.host.cycle(bench.time_ns)

    figures = _call("PLC cycle of DemoMill, nothing to do", cycle)
    bench.m(20)
    bench.m(8)
    figures += _call("PLC cycle of DemoMill, two functions under way", cycle, 200)
    return figures + _call("snapshot of the demo machine (hli watch, metrics)", lambda: snapshot(bench.hli), 200)


def _cnc() -> list[Figure]:
    hli = HliMemory.private().hli
    channel = ChannelCommands(hli.channels[0], hli.operator[0])
    axes = [AxisCommands(hli.axes[i]) for i in range(4)]

    def sample() -> None:
        channel.sample()
        channel.modes.take(False)
        for axis in axes:
            axis.sample()

    figures = _call("control units of a channel and 4 axes", sample)
    hli.channels[0].plc_present_w = True
    ports = [TechnologyPort(hli.channels[0]), *(TechnologyPort(hli.axes[i]) for i in range(4))]
    figures += _call("poll of 5 technology ports, nothing under way", lambda: [port.poll() for port in ports])
    ports[0].put(Function(Kind.M, 20, synch=2))
    return figures + _call("poll with one function under way", lambda: [port.poll() for port in ports])
