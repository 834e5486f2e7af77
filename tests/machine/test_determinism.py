"""Two runs of the same program write the same bytes: with and without drives in the loop, and with a fault in between."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.cli import main as cli
from runtime.config.machine import Machine
from runtime.fieldbus.simulator.drive import Fault
from runtime.scheduler.simulation import Simulation
from tests.machine.driven import LONG_LINE

FILES = ("blocks.jsonl", "events.jsonl", "samples.npz", "summary.json")
PART = (
    "%PART\nN10 G90 G17 G162 G54 M20\nN20 T2 M6\nN30 S2000 M3\nN40 G00 X5 Y5 Z2 M8\n"
    "N50 $FOR P1 = 1, 3, 1\nN60 G01 X[10 * P1] F4000\nN70 G03 X[10 * P1] Y5 I0 J5 F3000\nN80 G00 Z[P1] H12=P1\n"
    "N90 $ENDFOR\nN100 M9 M5\nN110 M21\nN120 M30\n"
)


def assert_same(first: Path, second: Path) -> None:
    for name in FILES:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name
        assert (first / name).stat().st_size > 100


@pytest.mark.parametrize("options", [[], ["--ideal-axes"], ["--ideal-axes", "--no-plc"]])
def test_two_simulations_write_the_same_bytes(tmp_path: Path, options: list[str]) -> None:
    program = tmp_path / "part.nc"
    program.write_text(PART)
    for run in ("first", "second"):
        (tmp_path / run).mkdir()
        assert cli.main(["simulate", str(program), *options, "--trace", str(tmp_path / run)]) == 0
    assert_same(tmp_path / "first", tmp_path / "second")


def test_the_place_of_program_and_trace_does_not_matter(tmp_path: Path) -> None:
    for run in ("first", "second"):
        folder = tmp_path / run / "programs"
        folder.mkdir(parents=True)
        (folder / "part.nc").write_text(PART)
        cli.main(["simulate", str(folder / "part.nc"), "--ideal-axes", "--trace", str(tmp_path / run / "trace")])
    assert_same(tmp_path / "first" / "trace", tmp_path / "second" / "trace")


def test_a_fault_happens_the_same_way_twice(demo: Machine, tmp_path: Path) -> None:
    program = tmp_path / "long.nc"
    program.write_text(LONG_LINE)

    def run(folder: Path) -> None:
        simulation = Simulation(demo, trace=folder)
        simulation.run_until(simulation.ready, 10.0)
        simulation.start(program)
        simulation.run_until(lambda: simulation.time > 1.0, 10.0)
        simulation.nodes.inject(1, Fault.DRIVE)
        simulation.run_until(lambda: simulation.time > 2.0, 10.0)
        simulation.close()

    for name in ("first", "second"):
        run(tmp_path / name)
    assert_same(tmp_path / "first", tmp_path / "second")
    assert b"over-current" in (tmp_path / "first" / "events.jsonl").read_bytes()
