"""The tool table of a machine that runs: what the command writes holds in programs, and what they write stays."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

from runtime.cnc.tools.table import SqliteTools
from runtime.cnc.tools.tool import Tool
from tests.system.running_machine import RunningMachine


def test_programs_and_the_command_share_the_table(machine: RunningMachine, tmp_path: Path) -> None:
    SqliteTools(machine.state / "tools.db").put(Tool(1, radius=5.0, length=70.0))
    program = tmp_path / "tool.nc"
    program.write_text("%TOOL\nG90 G54\nT1 D1 M6\nV.G.WZ[1].P[2] = V.G.WZ_AKT.L\nG00 X10 Y5 Z20\nM30\n")
    machine.start("--program", str(program))
    assert machine.process is not None
    assert machine.process.wait(120) == 0, machine.log.read_text()
    (z,) = re.findall(r"end position .* Z (\d+\.\d+)", machine.log.read_text())
    assert float(z) == pytest.approx(190.0, abs=0.05), "where the drive stands, within its window"
    tool = SqliteTools(machine.state / "tools.db").get(1)
    assert tool is not None
    assert tool.parameters == (0.0, 0.0, 70.0)
