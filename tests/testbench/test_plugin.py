"""The pytest plugin as a machine builder finds it: a machine of its own, a plant of its own, and what is told when it fails."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

import pytest

from runtime.config.loader import DEMO_MACHINE
from runtime.testbench import MachineBench

OWN = {
    "conftest.py": """
import pytest
from runtime.testbench import Follow

@pytest.fixture
def plant():
    return (Follow("clamp_valve", "clamp_closed", on=0.05, off=0.05),)
""",
    "mill.py": """
from runtime.plc_logic import Program, m_function

class Mill(Program):
    def setup(self):
        self.pressed = 0

    @m_function(20)
    def clamp(self, f):
        self.io.clamp_valve = True
        return self.io.clamp_closed

    @m_function()
    def others(self, f):
        return True

    def cycle(self):
        if self.io.door_closed:
            self.pressed += 1
""",
    "test_mill.py": """
def test_the_clamp(machine, run_program, press):
    result = run_program("N10 M20")
    assert result.good, result.alarms
    assert result.functions == ("M20",)
    assert result.time < 0.2
    before = machine.program.pressed
    press("door_closed")
    assert machine.program.pressed > before

def test_it_takes_too_long(wait_until):
    wait_until(lambda: False, 0.5, "the moon")
""",
    "pytest.ini": "[pytest]\ntandem_machine = machine.yaml\n",
}


def test_a_machine_of_ones_own(tmp_path: Path) -> None:
    for name, text in OWN.items():
        (tmp_path / name).write_text(text)
    (tmp_path / "machine.yaml").write_text(DEMO_MACHINE.read_text().replace("runtime.demo.plc:DemoMill", "mill.py"))
    command = [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "-p", "runtime.testbench.plugin"]
    environment = {"PYTHONPATH": str(Path.cwd()), "PATH": "/usr/bin:/bin", "HOME": str(Path.home())}
    done = subprocess.run([*command, str(tmp_path)], capture_output=True, text=True, cwd=tmp_path, env=environment)
    assert "1 failed, 1 passed" in done.stdout, done.stdout + done.stderr
    assert "TimeoutError: the moon: not within 0.5 s; STANDBY SELECTED" in done.stdout


def test_faults_that_the_machine_does_not_have_are_refused_by_name(machine: MachineBench) -> None:
    with pytest.raises(KeyError, match="nothing is no axis"):
        machine.inject_fault("nothing", True)
    with pytest.raises(ValueError, match="ideal drives do not fail"):
        machine.inject_fault("X", "drive")
    with pytest.raises(ValueError, match="is an input"):
        machine.inject_fault("door_closed", "open")
    with pytest.raises(ValueError, match="can hang"):
        machine.inject_fault("plc", "burn")
    with pytest.raises(KeyError, match="is no key"):
        machine.press("nothing")


@pytest.mark.tandem(plc="runtime.demo.plc:DemoMill")
def test_online_change_on_the_bench(machine: MachineBench) -> None:
    assert "DemoMill runs; state kept:" in machine.reload()
