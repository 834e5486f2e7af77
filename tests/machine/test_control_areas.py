"""Work and protection spaces on the machine: the axes stop in front of a border, whatever makes the path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import control_areas as errors
from runtime.hli.layout import State
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_limit_monitoring import place, run

DEFINE, SELECT = "isg.add.control-area-define", "isg.add.control-area-select"
AREA = """#CONTROL AREA BEGIN [ID=1 WORK POLY MIN_EXCUR=-20 MAX_EXCUR=20]
G01 G90 F9000 X-40 Y-40
X100
Y100
X-40
Y-40
#CONTROL AREA END
#CONTROL AREA ON [ID=1]
"""


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    return Driven(demo, tmp_path, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, {}))


@pytest.mark.spec(DEFINE, SELECT)
def test_the_program_is_aborted_in_front_of_the_border(driven: Driven) -> None:
    assert run(driven, f"%T\n{AREA}G01 X90 Y0\nX101\nX0\nM30\n") == [errors.SPACE_LEFT.id]
    assert place(driven) == [90, 0, 0]
    assert driven.state() is State.ERROR
    assert driven.alarm(errors.SPACE_LEFT).line == 11
    driven.reset()
    driven.watch(10)
    assert run(driven, "%U\nG90 G01 F9000 X80\nX120\nM30\n") == [errors.SPACE_LEFT.id], "it is active still"
    assert place(driven) == [80, 0, 0]
    driven.reset()
    driven.watch(10)
    assert run(driven, "%V\n#CONTROL AREA OFF ALL\nG90 G01 F9000 X120\nM30\n") == []
    assert place(driven) == [120, 0, 0]


@pytest.mark.spec(SELECT)
@pytest.mark.parametrize(
    ("smoothing", "good"),
    [
        ("#CONTOUR MODE ON [DEV, PATH_DEV 2]\nG01 X100 Y0\nX100 Y100\nX0 Y100\n", True),  # curves lie inside of corners
        ("#HSC ON [BSPLINE PATH_DEV 2]\nG01 X100 Y0\nX100 Y100\nX0 Y100\n", True),
        ("#SPLINE ON\nG01 X60 Y0\nX100 Y50\nX60 Y99\nX0 Y50\n#SPLINE OFF\n", False),  # its curve bulges beyond X 100
    ],
)
def test_what_is_watched_is_the_smoothed_path(driven: Driven, smoothing: str, good: bool) -> None:
    told = run(driven, f"%T\n{AREA}{smoothing}M30\n")
    assert told == ([] if good else [errors.SPACE_LEFT.id])
    furthest = float(np.array(driven.targets)[:, 0].max())
    assert 99.0 < furthest <= 100.0011 if good else furthest == 0.0, "a curve is driven as a whole or not at all"


@pytest.mark.spec(SELECT)
def test_a_tilted_system_and_a_helix_within_a_space(driven: Driven) -> None:
    inside = "#CS ON [20,20,0,20,0,0]\nG01 X0 Y0 Z0\nG03 X0 Y0 Z4 I10 J0 K2\n#CS OFF\nG01 X0 Y0 Z0\n"
    assert run(driven, f"%T\n{AREA}{inside}M30\n") == []
    steep = inside.replace("20,0,0]", "80,0,0]")
    assert run(driven, f"%T\nG90 F9000\n{steep.replace('I10', 'I30')}M30\n") == [errors.SPACE_LEFT.id]
