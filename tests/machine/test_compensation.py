"""A machine whose screw has errors: the drive goes where the axis then is, and the interface shows the axis."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.compensation import Compensation
from runtime.config.machine import Machine
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc

X, NODE = 0, 1


def test_the_drive_gets_what_the_axis_needs_and_the_axis_reads_what_was_asked_for(
    demo: Machine, tmp_path: Path
) -> None:
    compensation = Compensation(pitch_errors=((0.0, 0.0), (100.0, 0.050), (200.0, 0.0)), backlash=0.02, velocity=10.0)
    axes = (demo.axes[X].model_copy(update={"compensation": compensation}), *demo.axes[1:])
    machine = demo.model_copy(update={"axes": axes})
    driven = Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    assert driven.simulation.nodes is not None
    servo = driven.simulation.nodes.drives[NODE].servo
    places: list[float] = []

    def go(text: str) -> float:
        driven.start(f"%P\nN10 G90 G01 F6000 {text}\nN20 M30\n")
        for _ in range(5000):
            if not driven.channel.active:
                break
            driven.watch(1)
            places.append(servo.position / 10_000)
        driven.watch(200)
        return servo.position / 10_000

    assert go("X100") == pytest.approx(99.95, abs=1e-3)
    assert driven.image.actual_position[X] == pytest.approx(100.0, abs=1e-3)
    assert go("X50") == pytest.approx(50.0 - 0.025 - 0.02, abs=1e-3)
    assert driven.image.actual_position[X] == pytest.approx(50.0, abs=1e-3)
    assert go("X60") == pytest.approx(60.0 - 0.030, abs=1e-3)
    assert driven.errors == []
    assert np.abs(np.diff(places)).max() <= 0.1 * 1.3  # 100 mm/s, and what is taken up at the reversal
    stands = servo.position
    driven.image.enable[X] = False
    driven.hli.axes[X].plc_present_w = True
    driven.hli.axes[X].control.drive_on.enable_w, driven.hli.axes[X].control.drive_on.command_w = True, False
    driven.watch(200)
    driven.hli.axes[X].control.drive_on.command_w = True
    driven.watch(400)
    assert driven.simulation.controller.supervision.enabled[X]
    assert servo.position == pytest.approx(stands, abs=20.0)  # 2 µm: switched off and on again, nothing has moved
    assert driven.errors == []
