"""Backlash and pitch errors: what the drive gets, what the axis reads back, and that neither ever jumps."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st
from pydantic import ValidationError

from runtime.cnc.axes.compensation import AxisCompensation
from runtime.config.compensation import Compensation
from runtime.config.loader import ConfigurationError, load_machine, parse_machine
from runtime.config.machine import Machine
from runtime.drives import DriveImage, DriveState

pytestmark = pytest.mark.uncompiled

X = 0
ENABLED = DriveState.OPERATION_ENABLED
PERIOD = 0.001
TABLE = ((0.0, 0.0), (100.0, 0.010), (200.0, -0.005), (600.0, 0.0))


def machine(**compensation: Any) -> Machine:
    demo = load_machine(None)
    axis = demo.axes[X].model_copy(update={"compensation": Compensation(**compensation)})
    return demo.model_copy(update={"axes": (axis, *demo.axes[1:])})


class Axis:
    """X with its compensation; `go` moves the set-point."""

    def __init__(self, **compensation: Any) -> None:
        self.image = DriveImage(4)
        self.compensation = AxisCompensation(machine(**compensation), self.image)
        self.image.state[:] = ENABLED
        self.corrections: list[float] = []

    def go(self, place: float, cycles: int = 200) -> float:
        """The correction at the end of the way."""
        for target in np.linspace(self.image.target_position[X], place, cycles + 1)[1:]:
            self.image.target_position[X] = target
            self.compensation.step()
            self.corrections.append(float(self.image.correction[X]))
        return self.corrections[-1]


def test_the_error_of_the_screw_is_taken_back() -> None:
    axis = Axis(pitch_errors=TABLE)
    assert axis.go(50.0) == pytest.approx(-0.005)
    assert axis.go(100.0) == pytest.approx(-0.010)
    assert axis.go(150.0) == pytest.approx(-0.0025)
    assert axis.go(400.0, 1000) == pytest.approx(0.0025)
    assert axis.go(700.0, 2000) == pytest.approx(0.0)
    assert axis.go(-5.0, 2000) == pytest.approx(0.0)


def test_a_reversal_takes_the_backlash_up() -> None:
    axis = Axis(backlash=0.02)
    assert axis.go(10.0) == 0.0
    assert axis.go(5.0) == pytest.approx(-0.02)
    assert axis.go(5.0) == pytest.approx(-0.02)  # standing is no reversal
    assert axis.go(6.0) == 0.0


def test_the_correction_changes_no_faster_than_it_may() -> None:
    axis = Axis(backlash=0.02, velocity=2.0)
    axis.go(10.0)
    axis.corrections.clear()
    axis.go(9.0)
    steps = np.abs(np.diff(axis.corrections))
    assert steps.max() == pytest.approx(2.0 * PERIOD)
    assert axis.corrections[9] == pytest.approx(-0.02)


def test_a_shift_of_the_coordinates_is_no_reversal() -> None:
    axis = Axis(backlash=0.02)
    axis.go(10.0)
    axis.image.target_position[X] -= 40.0  # homing
    axis.compensation.step()
    assert axis.image.correction[X] == 0.0


def test_an_axis_that_is_not_enabled_keeps_its_direction() -> None:
    axis = Axis(backlash=0.02)
    axis.go(10.0)
    axis.image.state[X] = DriveState.SWITCH_ON_DISABLED
    assert axis.go(9.0) == 0.0


def test_a_machine_without_compensation_pays_nothing() -> None:
    image = DriveImage(4)
    assert not AxisCompensation(load_machine(None), image).used


moves = st.lists(st.tuples(st.booleans(), st.floats(-50.0, 650.0), st.integers(1, 60)), min_size=1, max_size=12)


@settings(max_examples=60, deadline=None)
@given(moves)
def test_taking_over_never_makes_the_drive_jump(ways: list[tuple[bool, float, int]]) -> None:
    """Whatever is moved by the axis or, while it is disabled, by hand: the place of the drive never makes a step of its own."""
    axis = Axis(pitch_errors=TABLE, backlash=0.03, velocity=4.0)
    image = axis.image
    drive = 0.0  # where the motor stands
    for enabled, way, cycles in ways:
        image.state[X] = ENABLED if enabled else DriveState.SWITCH_ON_DISABLED
        begin = float(image.target_position[X])
        hand = drive
        for k in range(cycles if enabled else cycles + 4):
            before = drive
            if enabled:
                step = max(-0.4, min(0.4, (way - begin) / cycles))
                image.target_position[X] += step
                axis.compensation.step()
                drive = float(image.target_position[X] + image.correction[X])
                assert abs(drive - before) <= abs(step) + 4.0 * PERIOD + 1e-9
            else:  # at last it stands: enabling takes some cycles
                drive = hand + 0.01 * way * min(1.0, (k + 1) / cycles)
                image.target_position[X] = drive - image.correction[X]  # the supervision tracks what the drive tells
                axis.compensation.step()
    assert math.isfinite(drive)


# -- tables ----------------------------------------------------------------------------------------------------------

MACHINE = """\
name: test
axes:
  - name: X
    log_axis: 1
    velocity: 24 m/min
    acceleration: 4 m/s^2
    jerk: 60 m/s^3
    compensation: {{pitch_errors: {table}}}
channels:
  - name: mill
    axes: [X]
"""


def test_a_table_in_a_file(tmp_path: Path) -> None:
    (tmp_path / "x.csv").write_text(
        "position;error\n# measured at 20 °C\n0; 0\n100; 0.01\n\n200, -0.005\n600 0\n", encoding="utf-8"
    )
    (tmp_path / "machine.yaml").write_text(MACHINE.format(table="x.csv"))
    compensation = load_machine(tmp_path / "machine.yaml").axes[X].compensation
    assert compensation is not None
    assert compensation.rows() == TABLE


@pytest.mark.parametrize(
    ("table", "reason"),
    [
        ("[[0, 0]]", "one row is no table"),
        ("[[0, 0], [0, 0.1]]", "positions have to increase: 0 stands behind 0"),
        ("[[0, 0], [1, 0.1]]", "the error changes by more than 2% of the way"),
        ("nowhere.csv", "No such file"),
    ],
)
def test_tables_that_cannot_be_used(table: str, reason: str) -> None:
    with pytest.raises(ConfigurationError) as caught:
        parse_machine(MACHINE.format(table=table), file="m.yaml")
    (problem,) = caught.value.problems
    assert problem.entry.id == 302051
    assert reason in problem.text
    assert problem.place.line == 8


@pytest.mark.parametrize("text", ["0, 0\n1, x\n", "0, 0\n1, 2, 3\n", "0 0\nnan 0\n"])
def test_files_that_are_no_tables(tmp_path: Path, text: str) -> None:
    file = tmp_path / "x.csv"
    file.write_text(text)
    with pytest.raises((ValidationError, ValueError)):
        Compensation(pitch_errors=str(file))
