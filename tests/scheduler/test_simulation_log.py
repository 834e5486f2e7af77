"""What a simulation keeps in memory does not grow with the length of the program."""

from __future__ import annotations

from pathlib import Path

from runtime.config import load_machine
from runtime.diagnostics.events import EventKind
from runtime.scheduler.simulation import Simulation


def test_events_of_single_blocks_go_into_the_trace_only(tmp_path: Path) -> None:
    program = tmp_path / "short.nc"
    program.write_text("G90 G01 F1000 X0.1\nM20\nX0.2\nM30\n")
    simulation = Simulation(load_machine(None), ideal_axes=True, trace=tmp_path / "trace")
    result = simulation.run_program(program)
    simulation.close(result)
    kept = {event.kind for event in result.events}
    assert EventKind.M_OUT in kept
    assert not kept & {EventKind.BLOCK_START, EventKind.BLOCK_END}
    traced = (tmp_path / "trace" / "events.jsonl").read_text()
    assert traced.count('"block_start"') >= 2
