"""G96 on the whole machine: the speed of the spindle follows the distance from the turning centre."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from runtime.config.machine import Machine, TurningAxis
from tests.machine.with_spindle import Followed

SPEC = "isg.turn.css-g96-g97-g196"


@pytest.fixture
def lathe(demo: Machine) -> Machine:
    """X moves across the turning axis."""
    axes = (demo.axes[0].model_copy(update={"turning": TurningAxis(kind="facing")}), *demo.axes[1:])
    return demo.model_copy(update={"axes": axes})


def cutting(run: Followed) -> float:
    """Cutting speed where the tool is, m/min."""
    return run.speed(0) * 2.0 * math.pi * run.x / 1000.0


@pytest.mark.spec(SPEC)
def test_facing_with_a_limit_near_the_centre(lathe: Machine, tmp_path: Path) -> None:
    text = "G18 G90 G01 F6000 X50\nM3 S500\nG196 S3000\nG96 S200\nG95 F0.5 X0\nM30\n"
    run = Followed(lathe, text, tmp_path)
    run.until(lambda: run.channel.cutting_speed.active and run.x < 48.0)
    while run.x > 12.0:  # 3000 rev/min are 10.6 mm from the centre
        run.cycle()
        assert cutting(run) == pytest.approx(200.0, rel=0.03)  # the spindle speeds up within its jerk
        if run.x < 45.0:  # and the feed follows the speed
            assert run.path.path_velocity * 60.0 == pytest.approx(0.5 * run.speed(0), rel=0.03)
    run.until(lambda: run.x < 9.0)
    assert run.speed(0) == pytest.approx(3000.0)
    run.until(lambda: not run.channel.active)
    assert run.speed(0) == pytest.approx(3000.0)  # it goes on


@pytest.mark.spec(SPEC)
def test_rapid_moves_leave_the_speed_and_g97_too(lathe: Machine, tmp_path: Path) -> None:
    text = "G18 G90 G01 F3000 X20\nM3 S500\nG96 S100\nX30\nG00 X60\nG00 X50\nG01 X40\nG97\nX60\nM30\n"
    run = Followed(lathe, text, tmp_path)

    def speed_at(radius: float) -> float:
        return 100_000.0 / (2.0 * math.pi * radius)

    run.until(lambda: run.x > 55.0)
    assert run.speed(0) == pytest.approx(speed_at(30.0), rel=0.01)
    run.until(lambda: run.x < 50.1)
    run.until(lambda: run.x < 45.0)
    assert run.speed(0) == pytest.approx(speed_at(run.x), rel=0.01)
    run.until(lambda: run.x < 40.1)
    run.until(lambda: run.x > 58.0)
    assert run.speed(0) == pytest.approx(speed_at(40.0), rel=0.01)


@pytest.mark.spec(SPEC)
def test_the_radius_counts_from_the_zero_offset_without_the_reference_offset(lathe: Machine, tmp_path: Path) -> None:
    text = "G18 G90 G54 G01 F6000 X20\nM3 S500\nG92 X10\nG96 S100\nX30\nG04 0.5\nM00\nM30\n"  # G54: X100
    run = Followed(lathe, text, tmp_path)
    run.until(lambda: run.x == pytest.approx(140.0) and run.path.standstill)
    run.cycle(200)
    assert run.speed(0) == pytest.approx(100_000.0 / (2.0 * math.pi * 40.0), rel=0.001)
    run.hli.operator[0].reset_rw = True
    run.until(lambda: not run.channel.active and run.speed(0) == 0.0)
    run.cycle(50)
    assert run.speed(0) == 0.0
