"""Online change in the whole machine: the program is replaced while the axes move, and the path does not notice."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from runtime.config.machine import Machine
from runtime.demo import plc as demo_plc
from runtime.hli.memory import get_text
from runtime.scheduler.simulation import Simulation

LINE = "%LINE\nN10 G90 G01 X50 F3000\nN20 M20\nN30 H12\nN40 G01 X0\nN50 M30\n"


def run(machine: Machine, folder: Path, versions: list[str]) -> tuple[list[float], list[str], Simulation]:
    """X of every cycle of a program during which the versions come one after the other, and what each was answered."""
    (folder / "mill.py").write_text(Path(demo_plc.__file__).read_text())
    described = machine.model_copy(update={"plc": machine.plc.model_copy(update={"program": "mill.py"})})
    simulation = Simulation(described, ideal_axes=True, base=folder)
    (folder / "line.nc").write_text(LINE)
    assert simulation.run_until(simulation.ready, 10.0)
    platform = simulation.memory.hli.platform
    simulation.start(folder / "line.nc")
    places: list[float] = []
    answers: list[str] = []
    for count in range(20_000):
        simulation.cycle()
        places.append(float(simulation.drives.image.target_position[0]))
        if count and count % 100 == 0 and versions:
            (folder / "mill.py").write_text(versions.pop(0))
            platform.reload_request_w += 1
        if len(answers) < platform.reload_done_w:
            answers.append(f"{platform.reload_error_w} {get_text(platform, 'reload_text_w')}")
        if count > 10 and not simulation.controller.channel.active:
            break
    return places, answers, simulation


def test_the_path_does_not_notice_good_and_broken_versions(demo: Machine, tmp_path: Path) -> None:
    text = Path(demo_plc.__file__).read_text()
    undisturbed, _, _ = run(demo, tmp_path, [])
    versions = [
        text.replace("self.holes += 1", "self.holes += 10"),
        text.replace("class DemoMill", "class DemoMill("),
        text.replace("self.next_tool = 0", "self.next_tool = 1 / 0"),
    ]
    places, answers, simulation = run(demo, tmp_path, versions)
    assert [answer.split()[0] for answer in answers] == ["0", "304021", "304025"]
    assert "ZeroDivisionError" in answers[2]
    assert np.array_equal(places, undisturbed)
    assert not simulation.errors
    simulation.run_until(lambda: False, 0.1)  # the last function is taken
    host = simulation.plc.host  # type: ignore[union-attr]
    assert vars(host.program)["holes"] == 10, "the new version counts"
