"""What README and ARCHITECTURE say is there, is there; the PLC example does what it says."""

from __future__ import annotations

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
import yaml

from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.scheduler.simulation import Simulation

README = Path("README.md").read_text(encoding="utf-8")
ARCHITECTURE = Path("ARCHITECTURE.md").read_text(encoding="utf-8")
PROGRAM = "%PART\nN10 M20\nN20 G90 G01 X20 F3000\nN30 M30\n"


@pytest.fixture
def mill(tmp_path: Path) -> Simulation:
    """The demo machine with the example of the README as its PLC program."""
    (example,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
    assert len([line for line in example.splitlines() if line.strip()]) <= 15
    (tmp_path / "plc.py").write_text(example)
    (tmp_path / "part.nc").write_text(PROGRAM)
    description = yaml.safe_load(DEMO_MACHINE.read_text(encoding="utf-8"))
    description["plc"]["program"] = "plc.py"
    (tmp_path / "machine.yaml").write_text(yaml.safe_dump(description))
    machine = load_machine(tmp_path / "machine.yaml")
    return Simulation(machine, ideal_axes=True, base=tmp_path)


def test_the_plc_example_clamps_the_part(mill: Simulation, tmp_path: Path) -> None:
    result = mill.run_program(tmp_path / "part.nc")
    assert result.problems == []
    assert result.positions["X"] == pytest.approx(20.0)
    valve = mill.machine.fieldbus.io[0].outputs.index("clamp_valve")
    assert mill.drives.image.digital_out[valve // 8] >> (valve % 8) & 1


def test_the_plc_example_tells_a_clamp_that_does_not_close(mill: Simulation, tmp_path: Path) -> None:
    assert mill.run_until(mill.ready, 5.0)
    lamp = mill.machine.fieldbus.io[0].outputs.index("lamp_red")
    mill.plant.force("clamp_closed", False)
    mill.start(tmp_path / "part.nc")

    def lit() -> bool:
        return bool(mill.drives.image.digital_out[lamp // 8] >> (lamp % 8) & 1)

    begin = mill.time
    assert mill.run_until(lit, 5.0)
    assert mill.time - begin == pytest.approx(2.0, abs=0.1)
    assert mill.controller.interpolator.path_velocity == 0.0


@pytest.mark.parametrize("text", [README, ARCHITECTURE], ids=["README", "ARCHITECTURE"])
def test_every_file_that_is_named_exists(text: str) -> None:
    linked = re.findall(r"\]\(([^)#:]+)\)", text)
    installed = re.findall(r"(?<![\w/])systemd/[\w./-]+\w", text)
    for name in [*linked, *installed]:
        assert Path(name).exists(), name


def test_every_module_of_the_architecture_exists() -> None:
    for name in set(re.findall(r"`([\w/]+(?:\.py|/))`", ARCHITECTURE)):
        assert Path("runtime", name.removeprefix("runtime/")).exists(), name


def test_the_example_of_the_test_bench_is_a_test_that_passes(tmp_path: Path) -> None:
    """As it stands, in a folder of its own, with nothing but the plugin of the package."""
    (example,) = (text for text in re.findall(r"```py\n(.*?)```", README, re.DOTALL) if "def test_" in text)
    (tmp_path / "test_mill.py").write_text(example)
    done = subprocess.run(
        [sys.executable, "-m", "pytest", "-q", "-p", "no:cacheprovider", "."],
        cwd=tmp_path,
        env=os.environ | {"PYTHONPATH": str(Path.cwd())},
        capture_output=True,
        text=True,
        check=False,
    )
    assert done.returncode == 0, done.stdout
    assert "1 passed" in done.stdout
