"""Programs in the NCT dialect on the whole machine: the path, MDI, single block, block search, errors, reset."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.search_target import SearchKind
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import nct as nct_errors
from runtime.hli.layout import Mode, State
from runtime.scheduler.simulation import Simulation
from tests.machine.driven import Driven
from tests.machine.test_block_search import search
from tests.machine.test_single_step import stops

DEMO = Path("runtime/demo/O0100.nc")

STEPS = """%O0001
N10 G90 G1 F6000 X10
N20 M98 P2 L2
N30 M20
N40 G4 P0.01
N50 X0
N60 M30
%O0002
G91 X5
G90
M99
"""


@pytest.fixture
def nct(demo: Machine) -> Machine:
    """The demo machine whose programs are written in the NCT dialect."""
    channel = demo.channels[0].model_copy(update={"dialect": "nct"})
    return demo.model_copy(update={"channels": (channel,)})


def test_the_demo_program_is_milled(demo: Machine) -> None:
    simulation = Simulation(demo, ideal_axes=True, dialect="nct", samples=True)
    result = simulation.run_program(DEMO)
    assert result.good, [str(problem) for problem in simulation.errors]
    assert simulation.samples is not None
    samples = simulation.samples.arrays()
    x, y, z = (np.asarray(samples[name]) for name in ("X", "Y", "Z"))
    begin = int(np.argmax(z > 119.9))
    x, y, z = x[begin:], y[begin:], z[begin:]  # without the way from zero to the plate
    down = z < 100 - 0.9
    ring = down & (np.hypot(x - 160, y - 120) < 40)  # the notches are 25 mm from the middle, 60° apart
    angles = np.unique(np.round(np.degrees(np.arctan2(y[ring] - 120, x[ring] - 160))) % 360)
    assert np.hypot(x[ring] - 160, y[ring] - 120) == pytest.approx(25, abs=1e-6)
    assert list(angles) == [0, 60, 120, 180, 240, 300]
    frame = down & ~ring
    assert z[frame].min() == pytest.approx(100 - 5)
    assert x[frame].max() == pytest.approx(100 + 124)


def test_the_dialect_of_the_machine_holds_for_programs_and_mdi(nct: Machine, tmp_path: Path) -> None:
    driven = Driven(nct, tmp_path, ideal_axes=True)
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G1 F6000 X10\r\nXI5 Y2.")
    driven.watch(2)
    driven.until_done()
    assert driven.alarms == []
    assert list(driven.image.target_position[:2]) == pytest.approx([115, 82])  # G54 holds
    driven.start(STEPS)
    driven.until_done()
    assert driven.alarms == []
    assert driven.image.target_position[0] == pytest.approx(100)


def test_single_block_stops_behind_motions_functions_and_dwells(nct: Machine, tmp_path: Path) -> None:
    driven = Driven(nct, tmp_path, ideal_axes=True)
    driven.operator.single_block_w = True
    driven.start(STEPS)
    assert stops(driven) == [2, 9, 9, 4, 5, 6]  # the call and the return are no steps


def test_a_program_is_entered_in_a_pass_of_its_subprogram(nct: Machine, tmp_path: Path) -> None:
    driven = Driven(nct, tmp_path, ideal_axes=True)
    search(driven, STEPS, SearchKind.LINE, 9, passes=2)
    driven.until_done()
    assert driven.alarms == []
    reached = np.array(driven.targets)[:, 0]
    assert reached.max() == pytest.approx(120)
    assert reached[-1] == pytest.approx(100)


def test_an_error_in_a_program_moves_nothing_and_tells_its_place(nct: Machine, tmp_path: Path) -> None:
    driven = Driven(nct, tmp_path, ideal_axes=True)
    before = driven.image.target_position.copy()
    driven.start("%O0001\nG0 X5\nG1 Y? F100\nM30\n")
    driven.watch(50)
    assert not driven.channel.active
    assert list(driven.image.target_position) == list(before)
    (alarm,) = driven.alarms
    assert (alarm.id, alarm.line) == (nct_errors.VALUE_MISSING.id, 3)


def test_reset_drops_what_the_program_had_selected(nct: Machine, tmp_path: Path) -> None:
    driven = Driven(nct, tmp_path, ideal_axes=True)
    driven.start("%O0001\nG91 G16 G61 G1 F3000 X50 Y0\nM30\n")
    driven.watch(200)
    driven.reset()
    driven.until(lambda: not driven.channel.active)
    driven.start("%O0002\nG1 X30 Y20 F6000\nM30\n")
    driven.until_done()
    assert list(driven.image.target_position[:2]) == pytest.approx([130, 100])
    assert math.isfinite(float(driven.image.target_position[2]))
