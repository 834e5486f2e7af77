"""Coordinate systems on the machine: the path of the axes, feed, limits, search, backward motion, reset, manual mode."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.geometry.frames import Floats, Frame, rotation_of
from runtime.cnc.search_target import SearchKind
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue.motion import SOFTWARE_LIMIT
from runtime.hli.layout import ManualMode, StopCondition
from runtime.scheduler.simulation import Simulation
from tests.machine.test_backward_motion import at_begin, backward
from tests.machine.test_backward_motion import make as backward_machine
from tests.machine.test_block_search import make, place, search
from tests.machine.test_modes import Hand

Write = Callable[[str], Path]
VALUES = "60,40,-20,10,-15,35"
FRAME = Frame(rotation_of((10, -15, 35)), np.array([60.0, 40.0, -20.0]))
CONTOUR = """N20 G01 F6000 X0 Y0 Z0
N30 X30
N40 G03 X40 Y10 R10
N50 G02 X60 Y30 I20 J0 Z3
N60 #CONTOUR MODE ON [DEV, PATH_DEV 0.5]
N70 G01 X20 Y30
N80 X20 Y5
N90 X0 Y0 Z0
N95 #CONTOUR MODE OFF
"""
PART = f"%PART\nN10 G90 G17 G00 X0 Y0 Z0\nN15 #CS ON [{VALUES}]\n{CONTOUR}N100 #CS OFF\nN110 G00 X10 Y10 Z5\nN120 M30\n"


def samples(machine: Machine, path: Path) -> tuple[Simulation, Floats]:
    simulation = Simulation(machine, ideal_axes=True, samples=True)
    result = simulation.run_program(path)
    assert result.good, result.problems
    assert simulation.samples is not None
    arrays = simulation.samples.arrays()
    return simulation, np.column_stack([arrays[name] for name in "XYZ"])


def along(points: Floats) -> Floats:
    """Different places only."""
    moved = np.abs(np.diff(points, axis=0)).max(axis=1) > 0.0
    kept: Floats = points[np.concatenate([[True], moved])]
    return kept


@pytest.mark.spec("isg.cs.cs-def-on-off", "isg.cs.offsets-layer")
def test_the_path_of_the_machine_is_the_programmed_one_in_the_system(demo: Machine, program: Write) -> None:
    """The same contour without a system is cut out of another run, and compared place by place with what is driven here."""
    _, plain = samples(demo, program(f"%P\nG90 G17\n{CONTOUR}M30\n"))
    _, tilted = samples(demo, program(PART))
    wanted = FRAME.outer(along(plain))
    for point in along(tilted)[::25]:
        here = FRAME.inner(point)
        if abs(here[2]) > 3.1 or not (-0.1 < here[0] < 60.1):
            continue  # on the way there and back
        gap = np.linalg.norm(wanted - point, axis=1).min()
        assert gap < 0.2, (point, here)  # two samples lie 0.1 mm apart at F6000
    for target in ((0, 0, 0), (30, 0, 0), (40, 10, 0), (60, 30, 3)):
        assert np.linalg.norm(tilted - FRAME.outer(target), axis=1).min() < 0.06


def test_feed_and_limits_of_the_axes_hold_in_a_tilted_system(demo: Machine, program: Write) -> None:
    simulation, points = samples(demo, program(PART))
    velocity = np.diff(points, axis=0) / simulation.period
    acceleration = np.diff(velocity, axis=0) / simulation.period
    for axis in range(3):
        assert np.abs(velocity[:, axis]).max() <= demo.axes[axis].velocity * 1.001
        step = demo.axes[axis].velocity_step / simulation.period  # at corners
        assert np.abs(acceleration[:, axis]).max() <= demo.axes[axis].acceleration * 1.005 + step
    line = [FRAME.inner(point) for point in points]
    speeds = [np.linalg.norm(v) for v, at in zip(velocity, line, strict=False) if 12 < at[0] < 18 and abs(at[1]) < 1e-6]
    assert speeds
    assert max(speeds) == pytest.approx(100.0, rel=1e-4)


def test_software_limits_are_those_of_the_axes_and_tell_the_line(demo: Machine, program: Write) -> None:
    top = demo.axes[0].position_max
    assert top is not None
    far = top * 1.2  # along the diagonal X stays within its limit: 0.71 of it
    good = f"%G\nG90 G00 X0 Y0\n#CS ON [0,0,0,0,0,60]\nG00 X{far / 3}\nM30\n"
    assert Simulation(demo, ideal_axes=True).run_program(program(good)).good
    bad = f"%B\nG90 G00 X0 Y0\n#CS ON [0,0,0,0,0,10]\nG00 X{far}\nM30\n"
    result = Simulation(demo, ideal_axes=True).run_program(program(bad))
    (problem,) = result.problems
    assert f":4:5: {SOFTWARE_LIMIT.id}:" in problem
    assert "axis X, 768.1500" in problem


def test_block_search_enters_a_program_within_a_system(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    search(driven, PART, SearchKind.BLOCK_NUMBER, 70)
    seen = []

    def done() -> bool:
        seen.append(place(driven)[:3])
        return not driven.channel.active

    driven.until(done, 60.0)
    assert driven.alarms == []
    begin = FRAME.outer((60, 30, 3))
    assert min(float(np.linalg.norm(np.array(point) - begin)) for point in seen) < 0.06
    far = FRAME.outer((30, 0, 0))  # the part that is left out
    assert min(float(np.linalg.norm(np.array(point) - far)) for point in seen) > 1.0
    assert place(driven)[:3] == [10, 10, 5]


def test_backward_over_the_begin_of_a_system_and_forward_again(demo: Machine, tmp_path: Path) -> None:
    driven = backward_machine(demo, tmp_path, storage=5000)
    driven.start(PART)
    interpolator = driven.channel.interpolator
    middle = FRAME.outer((20, 30, 3))
    driven.until(lambda: float(np.linalg.norm(interpolator.position[:3] - middle)) < 20.0, 60.0)
    backward(driven, True)
    driven.until(lambda: at_begin(driven), 60.0)
    np.testing.assert_allclose(interpolator.position[:3], [0, 0, 0], atol=1e-6)
    backward(driven, False)
    driven.until_done()
    assert driven.alarms == []
    assert place(driven)[:3] == [10, 10, 5]
    driven.assert_no_jump()


def test_after_a_reset_in_a_system_the_next_program_begins_on_the_machine(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.start(PART)
    driven.until(lambda: driven.channel.interpolator.position[0] > 70.0)
    driven.reset()
    driven.until_done()
    driven.reset()
    here = place(driven)
    driven.start("%NEXT\nG90 G01 F3000 X100\nM30\n")
    driven.until_done()
    assert place(driven)[:3] == [100, *here[1:3]]
    driven.assert_no_jump()


def test_single_block_stops_at_every_block_of_a_system(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    driven.operator.single_block_w = True
    text = f"%S\nG90 G17\n#CS ON [{VALUES}]\nG01 F6000 X0 Y0 Z0\nX10\nG03 X20 Y10 R10\nG01 X0\nM30\n"
    driven.start(text)
    stops = []
    for _ in range(5):
        driven.until(
            lambda: not driven.channel.active or bool(driven.channel.stop_condition & StopCondition.SINGLE_BLOCK)
        )
        stops.append(FRAME.inner(place(driven)[:3]).round(4).tolist())
        driven.operator.continue_motion_rw = True
        driven.watch(3)
    assert stops[:4] == [[0, 0, 0], [10, 0, 0], [20, 10, 0], [0, 10, 0]]


def test_positions_asked_for_in_a_system(demo: Machine, program: Write) -> None:
    """The decoder takes over where the path stands, with or without the servos' error, and nothing jumps."""
    text = f"%T\nG90 G01 F6000 X5\n#CS ON [{VALUES}]\nX10 Y5 Z0\n#CHANNEL INIT [CMDPOS]\nP1=V.A.ABS.X P2=V.A.ABS.Y\n"
    text += "#CHANNEL INIT [ACTPOS]\nP3=V.A.ABS.X\nX20\n#CS OFF\nG00 X0 Y0 Z0\nM30\n"
    simulation = Simulation(demo, samples=True)
    result = simulation.run_program(program(text))
    assert result.good, result.problems
    assert result.parameters[1] == pytest.approx(10, abs=1e-6)
    assert result.parameters[2] == pytest.approx(5, abs=1e-6)
    assert result.parameters[3] == pytest.approx(10, abs=2 * demo.axes[0].in_position)
    assert simulation.samples is not None
    arrays = simulation.samples.arrays()
    speeds = [np.abs(np.diff(arrays[name])).max() / simulation.period for name in "XYZ"]
    assert all(speed <= axis.velocity * 1.001 for speed, axis in zip(speeds, demo.axes, strict=False))


def test_by_hand_in_a_system(demo: Machine, tmp_path: Path) -> None:
    """G200 moves machine axes; then the program goes on from there, with its words along the axes of the system."""
    driven = make(demo, tmp_path)
    hand = Hand(driven)
    driven.start("%H\n#CS ON [100,0,0,0,0,90]\nG90 G01 F6000 X10 Y0\nG200\nX20\nM30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
    driven.watch(2)
    assert place(driven)[:3] == [100, 10, 0]
    hand.parameter("continuous_parameter", 1, velocity=50.0)
    hand.link(1, 1, ManualMode.CONTINUOUS)
    hand.press(1, 0)
    hand.press(1, 1)
    driven.watch(300)
    hand.press(1, 0)
    hand.rest()
    moved = float(driven.image.target_position[0])
    assert moved > 105
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert driven.alarms == []
    assert place(driven)[:3] == [pytest.approx(moved), 20, 0]
    driven.assert_no_jump()


def test_homing_in_a_system(demo: Machine, program: Write) -> None:
    """Where the axes stand is told anew on the machine, and the words go on along the axes of the system."""
    text = "%H\n#CS ON [100,50,0,0,0,90]\nG90 G01 F6000 X10 Y20\nG74 X1 Y2\nX5 Y5\n"
    text += "P2=V.A.ACS.ABS.X P3=V.A.ACS.ABS.Y\nM30\n"
    result = Simulation(demo).run_program(program(text))
    assert result.good, result.problems
    assert (result.parameters[2], result.parameters[3]) == pytest.approx((95, 55), abs=1e-6)
