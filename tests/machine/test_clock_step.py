"""The wall clock is set by hours while the machine cuts: nothing moves by it, and the step is told."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import numpy.typing as npt

from runtime.config.machine import Machine
from runtime.hli.alarms import alarm_lines
from runtime.recorder.file import RecordingFile
from runtime.scheduler.clock import WallClockWatch
from runtime.scheduler.replay import Replay
from runtime.scheduler.simulation import Simulation

PROGRAM = "%P\nN10 G90 G01 X30 F6000 M8\nN20 G04 0.1\nN30 #ERROR [ID 455 RC 0 MID 1]\nN40 X0\nN50 M30\n"
Floats = npt.NDArray[np.float64]
HOURS = 7 * 3600 * 10**9


class Stepping(Simulation):
    """Its wall clock goes back in every other tenth of a second."""

    def _wall_ns(self) -> int:
        return super()._wall_ns() - (HOURS if int(self.time * 10) % 2 else 0)


def driven(kind: type[Simulation], machine: Machine, program: Path, record: Path) -> tuple[Simulation, Floats]:
    simulation = kind(machine, ideal_axes=True, record=record)
    assert simulation.run_until(simulation.ready, 10.0)
    simulation.start(program)
    places = []
    for _ in range(900):
        simulation.cycle()
        places.append(simulation.drives.image.target_position.copy())
    simulation.close()
    return simulation, np.array(places)


def test_nothing_moves_by_the_wall_clock(demo: Machine, tmp_path: Path) -> None:
    program = tmp_path / "p.nc"
    program.write_text(PROGRAM)
    plain, way = driven(Simulation, demo, program, tmp_path / "plain")
    stepping, other = driven(Stepping, demo, program, tmp_path / "stepping")
    assert np.array_equal(way, other)
    assert way[:, 0].max() == 30.0
    assert [event.t for event in plain.log] == [event.t for event in stepping.log]
    assert plain.problems
    with RecordingFile(tmp_path / "stepping") as file:
        replay = Replay(file, demo)
        assert replay.run().same
    assert [line.time_ns for line in alarm_lines(replay.memory.hli)]


def test_a_step_is_told_once_and_slewing_is_none() -> None:
    now = [1000.0, 50.0]  # wall, monotonic
    watch = WallClockWatch(lambda: now[0], lambda: now[1])
    steps = []
    for wall, monotonic in ((0.1, 0.1), (3600.1, 0.1), (0.1, 0.1), (0.6, 0.1), (-7199.9, 0.1), (0.0, 0.0)):
        now[0] += wall
        now[1] += monotonic
        steps.append(round(watch.step(), 3))
    assert steps == [0.0, 3600.0, 0.0, 0.0, -7200.0, 0.0]
