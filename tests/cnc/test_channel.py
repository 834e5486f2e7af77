"""What the channel does when the path cannot go on; everything else of it is tested on the whole machine (tests/machine)."""

from __future__ import annotations

from pathlib import Path

import numpy as np

from runtime.config import load_machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.scheduler.simulation import Simulation


def test_a_path_that_begins_elsewhere_moves_nothing_and_is_an_alarm(tmp_path: Path) -> None:
    program = tmp_path / "x.nc"
    program.write_text("%X\nG90 G01 F1000 X10\nM30\n")
    with Simulation(load_machine(None), ideal_axes=True, plc=False) as simulation:
        assert simulation.run_until(simulation.ready, 1.0)
        simulation.start(program)
        simulation.cycle()
        start = simulation.link.read_start().start
        simulation.controller.interpolator.restart(start + np.array([5.0, 0.0, 0.0]))
        assert simulation.run_until(lambda: not simulation.controller.channel.active, 1.0)
        assert [e.number for e in simulation.log if e.number == alarms.PATH_APART.id] == [alarms.PATH_APART.id]
        assert simulation.drives.image.target_position[0] == simulation.drives.image.actual_position[0]
