"""What the HLI and a PLC cycle cost: `python -m bench.hli` prints a table, `--json FILE` writes the figures."""

from __future__ import annotations

import argparse
import json
import time
from collections.abc import Callable
from pathlib import Path

from runtime.config.loader import load_machine
from runtime.demo.plc import DemoMill
from runtime.hli.client import snapshot
from runtime.hli.control import AxisCommands, ChannelCommands
from runtime.hli.memory import HliMemory
from runtime.hli.technology import Function, Kind, TechnologyPort
from runtime.plc_logic.bench import Bench

ROUNDS = 2000


def measure(call: Callable[[], object], rounds: int = ROUNDS) -> dict[str, float]:
    """Median, 99th percentile and maximum of one call, µs."""
    times = []
    for _ in range(rounds):
        begin = time.perf_counter_ns()
        call()
        times.append((time.perf_counter_ns() - begin) / 1000.0)
    times.sort()
    return {"median_us": times[rounds // 2], "p99_us": times[rounds * 99 // 100], "max_us": times[-1]}


def per_access(call: Callable[[int], None], accesses: int = 100_000) -> dict[str, float]:
    """Mean of one of many equal accesses, µs; `call` makes as many as it is told."""
    begin = time.perf_counter_ns()
    call(accesses)
    return {"median_us": (time.perf_counter_ns() - begin) / 1000.0 / accesses}


def run() -> dict[str, dict[str, float]]:
    """All figures by name."""
    hli = HliMemory.private().hli
    status = hli.channels[0].status

    def read(n: int) -> None:
        for _ in range(n):
            status.line_r  # noqa: B018

    def write(n: int) -> None:
        for _ in range(n):
            status.line_r = 1

    def read_deep(n: int) -> None:
        for _ in range(n):
            hli.channels[0].status.line_r  # noqa: B018

    results = {
        "read a field of a structure at hand": per_access(read),
        "write a field of a structure at hand": per_access(write),
        "read a field from the root": per_access(read_deep),
    }
    machine = load_machine()
    node = machine.fieldbus.io[0]
    bench = Bench(DemoMill, inputs=node.inputs, outputs=node.outputs)
    bench.set(door_closed=True, e_stop_ok=True)
    bench.spindle("S", 0)
    bench.run(0.1)
    host = bench.host

    def plc_cycle() -> None:
        bench.time_ns += 4_000_000
        host.cycle(bench.time_ns)

    results["PLC cycle of DemoMill, nothing to do"] = measure(plc_cycle)
    bench.m(20)
    bench.m(8)
    results["PLC cycle of DemoMill, two functions under way"] = measure(plc_cycle, 200)
    channel = ChannelCommands(hli.channels[0], hli.operator[0])
    axes = [AxisCommands(hli.axes[i]) for i in range(4)]

    def sample() -> None:
        channel.sample()
        channel.modes.take(False)
        for axis in axes:
            axis.sample()

    results["CNC: all control units of a channel and 4 axes"] = measure(sample)
    hli.channels[0].plc_present_w = True
    ports = [TechnologyPort(hli.channels[0]), *(TechnologyPort(hli.axes[i]) for i in range(4))]
    results["CNC: poll 5 technology ports, nothing under way"] = measure(lambda: [port.poll() for port in ports])
    ports[0].put(Function(Kind.M, 20, synch=2))
    results["CNC: the same with one function under way"] = measure(lambda: [port.poll() for port in ports])
    results["snapshot of the demo machine (hli watch, metrics)"] = measure(lambda: snapshot(bench.hli), 200)
    return results


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--json", type=Path)
    options = parser.parse_args()
    results = run()
    for name, figures in results.items():
        print(f"{name:52}" + "  ".join(f"{key[:-3]} {value:9.3f} µs" for key, value in figures.items()))
    if options.json:
        options.json.write_text(json.dumps(results, indent=2))


if __name__ == "__main__":
    main()
