"""G63, G331, G332 on the whole machine: the spindle follows the path into the hole and out of it, whatever stops the path."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from runtime.cnc.axes.spindle import DEGREES_PER_SECOND
from runtime.cnc.blocks import SpindleRole
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import spindle as errors
from runtime.hli.layout import SpindleCommandKind, StopCondition
from runtime.hli.spindle_commands import SpindleCall, SpindleCaller
from tests.machine.with_spindle import Followed, Told, assert_within_limits

SPEC_63, SPEC_331 = "isg.spdl.tapping-g63", "isg.spdl.tapping-g331-g332"
TOP, DEPTH = 2.0, -6.0  # mm
DEGREES = 360.0


def off_the_thread(told: Told, part: slice, pitch: float) -> float:
    """How far (degrees) the spindle is off the angle that the depth asks for in a section; right-hand above 0."""
    wanted = (told.axes[part.start, 2] - told.axes[part, 2]) / pitch * DEGREES
    return float(np.abs(told.angle[part] - told.angle[part.start] - wanted).max())


def assert_spindle_within_limits(machine: Machine, told: Told, part: slice, period: float) -> None:
    """What the path plans for the spindle keeps its velocity, acceleration and jerk."""
    axis = machine.axes[3]
    velocity = np.diff(told.angle[part]) / period
    acceleration = np.diff(velocity) / period
    assert np.abs(velocity).max() <= axis.velocity * 1.0001
    assert np.abs(acceleration).max() <= axis.acceleration * 1.001
    assert np.abs(np.diff(acceleration) / period).max() <= axis.jerk * 1.01


@pytest.mark.spec(SPEC_63)
@settings(
    max_examples=4, deadline=None, derandomize=True, phases=[Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(
    pitch=st.floats(0.8, 3.0),
    speed=st.floats(500.0, 4000.0),
    override=st.lists(st.integers(20, 200), min_size=3, max_size=3),
    hold=st.integers(1, 200),
)
def test_angle_and_depth_belong_together_through_override_feed_hold_and_reversal(
    demo: Machine, tmp_path: Path, pitch: float, speed: float, override: list[int], hold: int
) -> None:
    text = f"G90 G00 Z{TOP}\nM19 S.POS=30 M3 S100\nG63 Z{DEPTH} F{pitch * speed} S{speed}\nZ{TOP} S-{speed}\nG01 F1000 X1\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.until(lambda: run.channel.together.tapping)
    for share in override:
        run.hli.operator[0].override_w = share * 10
        run.cycle(hold)
        run.hli.operator[0].feedhold_w = True
        run.cycle(hold // 2)
        run.hli.operator[0].feedhold_w = False
    run.hli.operator[0].override_w = 1000
    run.until(lambda: not run.channel.active, 60.0)
    told = run.told
    (section,) = told.sections
    assert off_the_thread(told, section, pitch) <= 1e-6
    assert told.axes[section, 2].min() == DEPTH
    assert_within_limits(run.machine, told, run.simulation.period)
    assert_spindle_within_limits(run.machine, told, section, run.simulation.period)
    assert run.ids() == []
    assert run.x == 1.0


@pytest.mark.spec(SPEC_331)
@pytest.mark.parametrize("pitch", [1.5, -1.5])
def test_by_pitch_in_and_out_again_with_another_speed(demo: Machine, tmp_path: Path, pitch: float) -> None:
    first = f"G331 Z{DEPTH} K{pitch} S300\nG332 Z{TOP} S600\nG01 X1\n"
    text = f"G90 G00 Z{TOP}\nS600\n{first}G331 Z{DEPTH} K{pitch}\nG332 Z{TOP}\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.until(lambda: not run.channel.active, 60.0)
    told = run.told
    assert len(told.sections) == 2
    for section, fastest in zip(told.sections, (600.0, 300.0), strict=True):
        assert off_the_thread(told, section, pitch) <= 1e-6
        speeds = np.diff(told.angle[section]) / run.simulation.period / DEGREES_PER_SECOND
        sense = 1.0 if pitch > 0.0 else -1.0
        assert (sense * speeds).max() == pytest.approx(300.0, rel=1e-6)  # in
        assert (sense * speeds).min() == pytest.approx(-fastest, rel=1e-6)  # out
    # the feed of tapping stays: 1.5 mm by 300 per minute for X
    between = slice(told.sections[0].stop, told.sections[1].start)
    assert np.diff(told.axes[between, 0]).max() / run.simulation.period * 60.0 == pytest.approx(900.0, rel=1e-6)


@pytest.mark.spec(SPEC_63)
def test_the_spindle_has_to_stand_and_is_waited_for(demo: Machine, tmp_path: Path) -> None:
    text = f"G90 G00 Z{TOP}\nM3 S9000\nM5\nG63 Z{DEPTH} F250 S200\nG01 F500 Z{TOP}\nM30\n"
    run = Followed(
        demo,
        text,
        tmp_path,
    )
    waited = 0
    while not run.channel.together.tapping:
        run.cycle()
        waited += run.z == TOP and bool(run.channel.stop_condition & StopCondition.WAIT_SPINDLE)
    assert waited > 50
    assert abs(run.speed(0)) < 10.0


@pytest.mark.spec(SPEC_63, SPEC_331)
def test_a_reset_stops_in_the_hole_and_the_tap_is_turned_out_by_a_program(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{TOP}\nG331 Z{DEPTH} K1 S1200\nG332 Z{TOP}\nM30\n", tmp_path)
    run.until(lambda: run.z < -2.0)
    run.hli.operator[0].reset_rw = True
    run.until(lambda: not run.channel.active)
    run.cycle(100)
    told = run.told
    (section,) = told.sections
    assert off_the_thread(told, section, 1.0) <= 1e-6
    assert DEPTH < run.z < -2.0
    stood, angle = run.z, run.angle(0)
    assert run.speed(0) == 0.0
    assert angle == pytest.approx((TOP - stood) * DEGREES % DEGREES, abs=0.05)
    assert run.channel.together.role is SpindleRole.FREE

    out = tmp_path / "out.nc"
    out.write_text(f"%OUT\nG91 G63 Z{TOP - stood} F500 S-500\nM30\n")
    run.simulation.start(out)
    run.cycle(3)
    run.until(lambda: not run.channel.active)
    assert run.z == pytest.approx(TOP)
    assert min(run.angle(0), DEGREES - run.angle(0)) <= 0.1


@pytest.mark.spec(SPEC_63)
def test_single_block_stops_in_the_hole_and_a_dwell_ends_nothing(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{TOP}\nG63 Z{DEPTH} F500 S500\nG04 0.2\nZ{TOP} S-500\nM30\n", tmp_path)
    run.until(lambda: run.channel.together.tapping)
    run.hli.operator[0].single_block_w = True
    run.until(lambda: run.z == DEPTH and bool(run.channel.stop_condition & StopCondition.WAIT_CONTINUE))
    run.cycle(300)
    assert run.channel.together.tapping
    assert abs(run.speed(0)) < 0.1
    run.hli.operator[0].single_block_w = False
    run.hli.operator[0].continue_motion_rw = True
    run.until(lambda: not run.channel.active)
    told = run.told
    (section,) = told.sections
    assert off_the_thread(told, section, 1.0) <= 1e-6
    assert run.z == TOP


@pytest.mark.spec(SPEC_63)
def test_the_plc_cannot_order_a_spindle_that_follows(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{TOP}\nG63 Z{DEPTH} F500 S500\nM30\n", tmp_path)
    run.until(lambda: run.z < 0.0)
    caller = SpindleCaller(run.hli.axes[3])
    assert caller.give(SpindleCall(SpindleCommandKind.M3, speed=6000.0))
    override = run.hli.axes[3].control.override
    override.enable_w, override.command_w = True, 100
    run.until(lambda: not run.channel.active)
    assert caller.error != 0
    assert off_the_thread(run.told, run.told.sections[0], 1.0) <= 1e-6


def test_a_drive_that_does_not_follow_stops_the_path_in_the_hole(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{TOP}\nG63 Z{DEPTH} F500 S500\nM30\n", tmp_path)
    run.until(lambda: run.z < 0.0)
    limit = run.machine.axes[3].following_error
    while run.channel.active:
        run.image.target_position[3] -= 0.9 * run.spindles[0].set_point * run.simulation.period  # it slips
        run.cycle()
    assert errors.TAPPING_LOST.id in run.ids()
    assert run.z > DEPTH
    assert limit / DEGREES < TOP - run.z


def test_with_drives_on_the_bus(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{TOP}\nG331 Z{DEPTH} K1.25 S200\nG332 Z{TOP}\nM30\n", tmp_path, ideal=False)
    lags = []
    while run.channel.active:
        run.cycle()
        if run.channel.together.tapping:
            lags.append(run.spindles[0].off_plan)
    assert np.abs(lags).max() <= 10.0  # degrees: 0.03 mm of thread while the drive speeds up or brakes
    assert np.median(np.abs(lags)) <= 2.0
    assert off_the_thread(run.told, run.told.sections[0], 1.25) <= 1e-6
    assert run.ids() == []
