"""Programs that fail before they hand over anything: the machine says why at once, and stands."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import language, motion
from runtime.diagnostics.errors import ErrorEntry
from runtime.scheduler.simulation import Simulation

Write = Callable[[str], Path]


@pytest.mark.parametrize(
    ("text", "entry", "place"),
    [
        ("%X\nN10 G01 X1 F100 Q5\nM30\n", language.AXIS_UNKNOWN, ":2:17:"),
        ("", language.FILE_EMPTY, ": "),
        ("%X\nN10 G01 X[1/0] F100\nM30\n", language.DIVISION_BY_ZERO, ":2:"),
        ("%X\nN10 G00 Z900\nM30\n", motion.SOFTWARE_LIMIT, ":2:9:"),
    ],
)
def test_an_error_before_the_first_motion_ends_the_program_at_once(
    demo: Machine, program: Write, text: str, entry: ErrorEntry, place: str
) -> None:
    with Simulation(demo, ideal_axes=True) as simulation:
        path = program(text)
        result = simulation.run_program(path)
        assert [problem.entry.id for problem in simulation.problems] == [entry.id]
        assert result.problems[0].startswith(f"{path}{place}")
        assert result.time < 0.01
        assert result.positions == {"X": 0.0, "Y": 0.0, "Z": 0.0}
        assert result.path_length == 0.0


def test_a_missing_file_ends_the_program_at_once(demo: Machine, tmp_path: Path) -> None:
    with Simulation(demo, ideal_axes=True) as simulation:
        result = simulation.run_program(tmp_path / "none.nc")
        assert len(result.problems) == 1
        assert "300001" in result.problems[0]
        assert not simulation.controller.channel.active
