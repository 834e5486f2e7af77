"""G33 on the whole machine: the path follows the angle of the spindle, and every pass meets the same groove."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest
from hypothesis import HealthCheck, Phase, given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import SpindleRole
from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import spindle as errors
from runtime.hli.layout import StopCondition
from tests.machine.with_spindle import Floats, Followed, Told, assert_within_limits

SPEC = "isg.turn.thread-g33"
FROM, TO = 40.0, 15.0  # mm
DEGREES = 360.0


def into_the_thread(run: Followed) -> None:
    """To where the path follows the spindle, 8 mm behind the begin."""
    run.until(lambda: run.channel.together.cutting and run.z < FROM - 8.0)


def off_the_groove(told: Told, part: slice, pitch: float, offset: float, sense: float = 1.0) -> Floats:
    """How far (mm) the tool is off the helix with this pitch that begins at FROM where the spindle is at `offset`."""
    turned = sense * (told.angle[part] - offset) / DEGREES * pitch
    way = FROM - told.axes[part, 2]
    return (way - turned + pitch / 2.0) % pitch - pitch / 2.0


def in_the_middle(told: Told, part: slice, clear: float) -> slice:
    """The cycles of a section in which the path is further than `clear` mm from both ends."""
    way = FROM - told.axes[part, 2]
    inside = np.flatnonzero((way > clear) & (way < FROM - TO - clear))
    return slice(part.start + int(inside[0]), part.start + int(inside[-1]))


@pytest.mark.spec(SPEC)
@settings(
    max_examples=4, deadline=None, derandomize=True, phases=[Phase.generate],
    suppress_health_check=[HealthCheck.function_scoped_fixture],
)  # fmt: skip
@given(
    pitch=st.floats(1.0, 4.0),
    speed=st.floats(300.0, 900.0),
    offset=st.floats(0.0, 359.0),
    command=st.sampled_from([3, 4]),
)
def test_the_axis_has_moved_by_the_pitch_per_revolution_from_the_angle_on(
    demo: Machine, tmp_path: Path, pitch: float, speed: float, offset: float, command: int
) -> None:
    text = f"G90 G00 Z{FROM}\nM{command} S{speed}\nG33 Z{TO} K{pitch} S.OFFSET={offset}\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.until(lambda: not run.channel.active, 120.0)
    told = run.told
    (section,) = told.sections
    middle = in_the_middle(told, section, 4.0)
    off = off_the_groove(told, middle, pitch, offset, 1.0 if command == 3 else -1.0)
    assert np.abs(off).max() <= 0.002
    assert_within_limits(run.machine, told, run.simulation.period)
    assert run.z == TO


@pytest.mark.spec(SPEC)
def test_passes_with_other_speeds_meet_the_same_groove_and_a_second_start_lies_between(
    demo: Machine, tmp_path: Path
) -> None:
    pitch = 1.5
    passes = [(400.0, ""), (700.0, ""), (400.0, "S.OFFSET180"), (500.0, "S.OFFSET=0")]
    text = f"G90 G00 Z{FROM}\nM3 S400\nG33 Z{TO} K{pitch}\nG00 X2\nZ{FROM}\nX0\n"
    text += f"S700\nG33 Z{TO}\nG00 Z{FROM}\nS400\nG33 Z{TO} S.OFFSET180\nG00 Z{FROM}\nS500 G33 Z{TO} S.OFFSET=0\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.until(lambda: not run.channel.active, 120.0)
    told = run.told
    assert len(told.sections) == len(passes)
    for (_, offset), section in zip(passes, told.sections, strict=True):
        middle = in_the_middle(told, section, 5.0)
        assert np.abs(off_the_groove(told, middle, pitch, 180.0 if "180" in offset else 0.0)).max() <= 0.001


@pytest.mark.spec(SPEC)
def test_a_taper_has_its_pitch_along_the_axis_of_the_letter(demo: Machine, tmp_path: Path) -> None:
    text = f"G90 G18 G00 Z{FROM} X10\nM3 S300\nG33 Z{TO} X20 K2\nG00 Z{FROM} X10\nG33 Z{TO} X20 I0.8\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.until(lambda: not run.channel.active, 60.0)
    told = run.told
    for section in told.sections:  # I0.8 over 10 mm of X is K2 over 25 mm of Z
        middle = in_the_middle(told, section, 5.0)
        assert np.abs(off_the_groove(told, middle, 2.0, 0.0)).max() <= 0.002


@pytest.mark.spec(SPEC)
def test_feed_hold_override_and_single_block_wait_for_the_end_of_the_thread(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S600\nG33 Z{TO} K1\nG00 X5\nM30\n", tmp_path)
    into_the_thread(run)
    operator = run.hli.operator[0]
    operator.override_w, operator.feedhold_w = 200, True
    run.cycle(500)
    assert run.path.path_velocity == pytest.approx(10.0, abs=0.01)  # mm/s, of 600 rev/min and 1 mm
    assert run.channel.stop_condition & StopCondition.FEED_HOLD
    run.until(lambda: run.z == TO)
    run.cycle(500)
    assert run.x == 0.0  # the retract waits
    assert run.channel.together.role is SpindleRole.FREE
    told = run.told
    assert np.abs(off_the_groove(told, in_the_middle(told, told.sections[0], 5.0), 1.0, 0.0)).max() <= 0.001
    operator.feedhold_w = False
    run.until(lambda: not run.channel.active)
    assert run.x == 5.0


@pytest.mark.spec(SPEC)
def test_nothing_begins_while_the_path_is_held(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S600\nG33 Z{TO} K1\nM30\n", tmp_path)
    run.until(lambda: run.z == FROM)
    run.hli.operator[0].feedhold_w = True
    run.cycle(1000)
    assert run.z == FROM
    run.hli.operator[0].feedhold_w = False
    run.until(lambda: run.z == TO)


@pytest.mark.spec(SPEC)
def test_the_path_follows_an_override_of_the_spindle(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S600\nG33 Z{TO} K1.5\nM30\n", tmp_path)
    into_the_thread(run)
    unit = run.hli.axes[3].control.override
    unit.enable_w, unit.command_w = True, 500
    run.cycle(600)
    assert run.path.path_velocity == pytest.approx(7.5, abs=0.01)
    unit.command_w = 1000
    run.until(lambda: not run.channel.active)
    told = run.told
    middle = in_the_middle(told, told.sections[0], 5.0)
    assert np.abs(off_the_groove(told, middle, 1.5, 0.0)).max() <= 0.02  # while the spindle brakes, too
    assert_within_limits(run.machine, told, run.simulation.period)
    assert run.ids() == []


@pytest.mark.spec(SPEC)
def test_without_it_if_the_program_says_so(demo: Machine, tmp_path: Path) -> None:
    text = f"G90 G00 Z{FROM}\nM3 S600\n#TURN [THREAD_CUT_IGNORE_OV=1]\nG33 Z{TO} K1.5\nG04 0.5\nM30\n"
    run = Followed(demo, text, tmp_path)
    into_the_thread(run)
    unit = run.hli.axes[3].control.override
    unit.enable_w, unit.command_w = True, 500
    run.cycle(300)
    assert run.path.path_velocity == pytest.approx(15.0, abs=0.001)
    run.until(lambda: not run.channel.active)
    assert run.speed(0) == pytest.approx(300.0)  # behind the thread it counts


@pytest.mark.spec(SPEC)
def test_a_chain_goes_from_pitch_to_pitch_without_a_stop(demo: Machine, tmp_path: Path) -> None:
    text = f"G90 G00 Z{FROM}\nM3 S300\n#TURN [THREAD_CHAIN=1]\nG33 Z28 K2\nZ{TO} K1\nG00 Z{FROM}\nM30\n"
    run = Followed(demo, text, tmp_path)
    run.hli.operator[0].single_block_w = True
    run.hli.operator[0].continue_motion_rw = True
    run.until(lambda: run.z == FROM or bool(run.channel.stop_condition & StopCondition.WAIT_CONTINUE))
    run.hli.operator[0].single_block_w = False
    run.hli.operator[0].continue_motion_rw = True
    run.until(lambda: run.channel.together.cutting)
    run.hli.operator[0].single_block_w = True
    run.until(lambda: run.z == TO)
    told = run.told
    (section,) = told.sections
    way = FROM - told.axes[section, 2]
    turned = told.angle[section] / DEGREES
    first, second = (way > 3.0) & (way < 10.0), (way > 15.0) & (way < 22.0)
    at_begin = np.round(turned[first] - way[first] / 2.0)
    assert np.abs(turned[first] - at_begin - way[first] / 2.0).max() <= 0.001
    # 12 mm with 2 mm are 6 revolutions, and then it is 1 mm for each
    assert np.abs(turned[second] - at_begin[0] - 6.0 - (way[second] - 12.0)).max() <= 0.002
    velocity = np.diff(way) / run.simulation.period
    assert velocity[(way[1:] > 3.0) & (way[1:] < 22.0)].min() >= 2.0  # it brakes behind the border


@pytest.mark.spec("isg.turn.thread-actual-speed")
def test_the_path_follows_what_is_measured_of_the_spindle(demo: Machine, tmp_path: Path) -> None:
    text = f"G90 G00 Z{FROM}\nM3 S300\n#TURN [THREAD_CUT_ACT_SPEED=1 THREAD_CUT_N_CYCLES=5]\nG33 Z{TO} K2\nM30\n"
    run = Followed(demo, text, tmp_path)
    into_the_thread(run)
    way, angle = [], []
    for _ in range(1000):
        # the spindle is measured a little faster than it is told to be, as if it were no good one
        run.image.actual_position[3] += 0.05
        run.cycle()
        way.append(FROM - run.z)
        angle.append(run.spindles[0].angle + 300.0 * 6.0 * run.simulation.period)
    turns = np.array(angle) / DEGREES
    off = np.array(way) - 2.0 * turns
    assert np.ptp(off[300:]) <= 0.02
    assert run.spindles[0].locked is False


def test_what_cannot_be_followed_is_told_before_anything_moves(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S5000\nG33 Z{TO} K3\nM30\n", tmp_path)  # 15 m/min is what Z can
    unit = run.hli.axes[3].control.override
    unit.enable_w, unit.command_w = True, 1200
    run.until(lambda: not run.channel.active)
    assert run.ids() == [errors.THREAD_NOT_FOLLOWED.id]
    assert run.z == FROM
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S4000\nG33 Z38 K3\nM30\n", tmp_path)
    run.until(lambda: not run.channel.active)
    assert run.ids() == [errors.THREAD_TOO_SHORT.id]
    assert run.z == FROM
    assert run.spindles[0].locked is False


def test_a_reset_in_a_thread_stops_path_and_spindle(demo: Machine, tmp_path: Path) -> None:
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S600\nG33 Z{TO} K1\nM30\n", tmp_path)
    into_the_thread(run)
    run.hli.operator[0].reset_rw = True
    run.until(lambda: not run.channel.active and run.speed(0) == 0.0, 3.0)
    assert TO < run.z < FROM - 8.0
    assert_within_limits(run.machine, run.told, run.simulation.period)
    assert run.channel.together.role is SpindleRole.FREE
    assert not run.spindles[0].locked


def test_a_spindle_that_stops_takes_the_path_with_it(demo: Machine, tmp_path: Path) -> None:
    """The PLC stops it; the tool stays in the groove."""
    run = Followed(demo, f"G90 G00 Z{FROM}\nM3 S600\nG33 Z{TO} K1.5\nM30\n", tmp_path)
    into_the_thread(run)
    run.spindles[0].stop()
    run.cycle(1000)
    assert run.path.standstill
    told = run.told
    stood = slice(told.sections[0].start + 400, len(told.together))
    assert np.abs(off_the_groove(told, stood, 1.5, 0.0)).max() <= 0.02


def test_nobody_drives_backward_in_a_thread_or_over_it(demo: Machine, tmp_path: Path) -> None:
    channel = demo.channels[0].model_copy(update={"backward_storage": 100})
    machine = demo.model_copy(update={"channels": (channel,)})
    run = Followed(machine, f"G90 G01 F6000 Z{FROM}\nM3 S600\nG33 Z{TO} K1\nG01 X50\nM30\n", tmp_path)
    into_the_thread(run)
    run.hli.operator[0].backward_motion_w = True
    run.until(lambda: run.z == TO)
    run.cycle(500)
    assert run.z == TO
    assert run.x == 0.0
    run.hli.operator[0].backward_motion_w = False
    run.until(lambda: run.x > 3.0)
    run.hli.operator[0].backward_motion_w = True
    run.cycle(1500)
    assert (run.x, run.z) == (0.0, TO)  # back to the thread, and no further
    run.hli.operator[0].backward_motion_w = False
    run.until(lambda: not run.channel.active)


def test_with_drives_on_the_bus(demo: Machine, tmp_path: Path) -> None:
    """The spindle is speed-controlled: its angle is kept to the plan."""
    run = Followed(
        demo, f"G90 G00 Z{FROM}\nM3 S400\nG33 Z{TO} K1.5\nG00 Z{FROM}\nG33 Z{TO}\nM30\n", tmp_path, ideal=False
    )
    lags = []
    while run.channel.active:
        run.cycle()
        if run.channel.together.cutting and 5.0 < FROM - run.z < 20.0:
            lags.append(run.spindles[0].off_plan)
    assert np.abs(lags).max() <= 5.0  # degrees, at 2400 degrees/s: what a cycle or two of delay are
    assert np.ptp(lags) <= 2.0
    told = run.told
    for section in told.sections:
        assert np.abs(off_the_groove(told, in_the_middle(told, section, 5.0), 1.5, 0.0)).max() <= 0.005
