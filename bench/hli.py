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
from runtime.plc_logic import CTD, CTU, CTUD, F_TRIG, R_TRIG, RS, SR, TOF, TON, TP, Program
from runtime.plc_logic.areas import AxisPort, ChannelPort
from runtime.plc_logic.bench import Bench
from runtime.plc_logic.cycle_time import cycle_at_ns
from runtime.plc_logic.image import io_of

ACCESSES = 5_000


def measure() -> list[Figure]:
    """Access to a field, the CNC's side of the units, cycles of the demo's PLC program, a snapshot."""
    with as_in_the_cycle():
        return [*_access(), *_ports(), *_blocks(), *_plc(), *_cnc()]


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


def _ports() -> list[Figure]:
    """Fields as a PLC program reads and sets them."""
    hli = HliMemory.private().hli
    hli.channels[0].control.mode_and_state.state_r = hli.channels[0].control.mode_and_state.mode_r = 2
    hli.axes[0].status.axis_state_r = 1
    channel, axis = ChannelPort(hli.channels[0]), AxisPort(hli.axes[0])
    io = io_of(Program, hli.image, {"closed": 3}, {"valve": 4})

    def position() -> None:
        for _ in range(ACCESSES):
            axis.position  # noqa: B018

    def in_position() -> None:
        for _ in range(ACCESSES):
            axis.in_position  # noqa: B018

    def state() -> None:
        for _ in range(ACCESSES):
            channel.state  # noqa: B018

    def hold() -> None:
        for _ in range(ACCESSES):
            channel.feed_hold = True

    def override() -> None:
        for _ in range(ACCESSES):
            channel.override = 87.5

    def read() -> None:
        for _ in range(ACCESSES):
            io.closed  # noqa: B018

    def write() -> None:
        for _ in range(ACCESSES):
            io.valve = True

    return [
        Figure(f"PLC program: {name}", seconds(call, 200) / ACCESSES * 1e9, "ns", limit)
        for name, call, limit in (
            ("axis.position", position, 150),
            ("axis.in_position", in_position, 150),
            ("channel.state", state, 150),
            ("channel.feed_hold = True", hold, 150),
            ("channel.override = 87.5", override, None),
            ("io input", read, 150),
            ("io output = True", write, 150),
        )
    ]


def _blocks() -> list[Figure]:
    """2000 calls of function blocks, mixed as in a program: each block is called with its inputs, some with all."""
    blocks = [(TON(), TOF(), TP(), R_TRIG(), F_TRIG(), SR(), RS(), CTU(5), CTD(5), CTUD(5)) for _ in range(200)]
    time_ns = 0

    def cycle() -> None:
        nonlocal time_ns
        time_ns += 4_000_000
        on = time_ns // 100_000_000 % 2 == 0
        with cycle_at_ns(time_ns):
            for ton, tof, tp, rise, fall, sr, rs, up, down, both in blocks:
                ton(IN=on, PT=0.05)
                tof(IN=on, PT=0.05)
                tp(IN=on, PT=0.05)
                rise(CLK=on)
                fall(CLK=on)
                sr(S1=on, R=False)
                rs(S=on, R1=False)
                up(CU=on, R=False)
                down(CD=on, LD=False)
                both(CU=on, CD=False)

    windows = each(cycle, 100)
    best = min(windows, key=lambda window: float(np.percentile(window, 99)))
    median, p99 = (np.percentile(best, (50, 99)) / 1e6).tolist()
    return [
        Figure("2000 calls of function blocks, median", median, "ms", 2.0),
        Figure("2000 calls of function blocks, 99 %", p99, "ms", 2.0),
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
