"""Control units of the channel and its axes: what stops the path, before what, and what becomes of the axes."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.drives import DriveState
from runtime.hli.layout import AxisControl, Blocked, Mode, State, StopCondition
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.machine.test_modes import Hand, by_hand, make, place, velocity, with_channel

X, Y, Z = 0, 1, 2
# X, then Y, then both, then back in X
LEGS = "%LEGS\nN10 G90 G01 F6000 X60\nN20 Y50\nN30 X100 Y80\nN40 X20\nN50 M30\n"


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    return make(demo, tmp_path)


def axis_unit(driven: Driven, axis: int) -> AxisControl:
    """The units of an axis whose area has a PLC."""
    area = driven.hli.axes[axis]
    area.plc_present_w = True
    control: AxisControl = area.control
    return control


def claim(unit: object, value: object) -> None:
    unit.enable_w, unit.command_w = True, value  # type: ignore[attr-defined]


def stops(driven: Driven, condition: StopCondition) -> None:
    """Until the path stands for this reason."""
    driven.until(lambda: bool(driven.channel.stop_condition & condition) and driven.channel.interpolator.standstill)
    driven.watch(50)
    assert velocity(driven, X) == velocity(driven, Y) == 0.0


# ---------------------------------------------------------------------------------------------------- axis feed hold


@pytest.mark.spec("hli.ax.cu.feedhold")
def test_the_others_go_on_until_a_held_axis_would_have_to_move(driven: Driven) -> None:
    driven.start(LEGS)
    driven.until_x(20.0)
    claim(axis_unit(driven, Y).feedhold, True)
    driven.watch(20)
    assert velocity(driven, X) > 50.0, "X does not care"
    stops(driven, StopCondition.AXIS_FEED_HOLD)
    assert (place(driven, X), place(driven, Y)) == (60.0, 0.0)
    assert driven.state() is State.HOLD
    claim(axis_unit(driven, Y).feedhold, False)
    driven.until(lambda: place(driven, Y) > 20.0)
    claim(axis_unit(driven, Y).feedhold, True)
    stops(driven, StopCondition.AXIS_FEED_HOLD)
    assert 20.0 < place(driven, Y) < 50.0, "an axis that moves stops at once"
    claim(axis_unit(driven, Y).feedhold, False)
    driven.until_done()
    assert (place(driven, X), place(driven, Y)) == (20.0, 80.0)
    assert driven.errors == []


@pytest.mark.spec("hli.ax.cu.feedhold")
def test_an_axis_that_never_has_to_move_holds_nobody(driven: Driven) -> None:
    claim(axis_unit(driven, Z).feedhold, True)
    driven.start(LEGS)
    begin = driven.simulation.time
    driven.until_done()
    held = driven.simulation.time - begin
    claim(axis_unit(driven, Z).feedhold, False)
    driven.start("%BACK\nN10 G90 G01 F6000 X0 Y0\nN20 M30\n")
    driven.until_done()
    driven.start(LEGS)
    begin = driven.simulation.time
    driven.until_done()
    assert held == pytest.approx(driven.simulation.time - begin, abs=0.01), "no stop, no slower corner"


@pytest.mark.spec("hli.ax.cu.release-feedhold")
def test_a_missing_release_keeps_a_moving_axis_still(driven: Driven) -> None:
    unit = axis_unit(driven, X).release_feedhold
    claim(unit, False)
    driven.start(LEGS)
    driven.watch(300)
    assert place(driven) == 0.0
    claim(unit, True)
    driven.until_done()
    assert driven.errors == []


@pytest.mark.spec("hli.ax.cu.directional-feedhold")
def test_a_blocked_direction_holds_the_path_and_leaves_the_other_way_free(driven: Driven) -> None:
    unit = axis_unit(driven, X).directional_feedhold
    claim(unit, int(Blocked.MINUS))
    driven.start(LEGS)
    stops(driven, StopCondition.AXIS_LIMIT)
    assert place(driven) == pytest.approx(100.0, abs=1e-9), "X went up, and shall now go back"
    assert unit.state_r == Blocked.MINUS
    claim(unit, 0)
    driven.until_done()
    assert place(driven) == 20.0


# ---------------------------------------------------------------------------------------------------- read disable


@pytest.mark.spec("hli.ch.cu.read-disable", "chan.plc.input-disable")
def test_read_disable_stops_at_once_and_motion_goes_on_when_it_is_taken_back(driven: Driven) -> None:
    unit = driven.hli.channels[0].control.read_disable
    driven.start(LEGS)
    driven.until_x(20.0)
    claim(unit, True)
    stops(driven, StopCondition.READ_DISABLE)
    assert 20.0 < place(driven) < 60.0
    claim(unit, False)
    driven.until_x(50.0)
    claim(unit, True)
    driven.watch(10)
    slow = velocity(driven)
    claim(unit, False)
    driven.watch(30)
    assert 0.0 < slow < velocity(driven), "it went on without standing"
    driven.until_done()
    assert driven.errors == []


@pytest.mark.spec("hli.ch.cu.read-disable", "chan.plc.input-disable")
@pytest.mark.parametrize(
    ("condition", "stop"), [("NEXT_RAPID_BLOCK", (60.0, 0.0)), ("NEXT_NON_RAPID_BLOCK", (60.0, 50.0))]
)
def test_read_disable_waits_for_the_kind_of_block_that_is_configured(
    demo: Machine, tmp_path: Path, condition: str, stop: tuple[float, float]
) -> None:
    driven = make(with_channel(demo, hli_input_disable_condition=condition), tmp_path)
    unit = driven.hli.channels[0].control.read_disable
    driven.start("%R\nN10 G90 G01 F6000 X60\nN20 G00 Y50 M8 S500 M3\nN30 G01 X80\nN40 M30\n")
    driven.until_x(20.0)
    claim(unit, True)
    stops(driven, StopCondition.READ_DISABLE)
    assert (place(driven, X), place(driven, Y)) == stop
    plc = driven.simulation.plc
    assert isinstance(plc, ScriptedPlc)
    assert (1, 8) in plc.taken, "functions of the block are put out"
    if condition == "NEXT_RAPID_BLOCK":
        assert driven.channel.spindles[0].set_point > 0.0, "those of its spindle too"
    claim(unit, False)
    driven.until_done()
    assert place(driven) == 80.0


# ---------------------------------------------------------------------------------------------------- delete distance to go


def delete_distance(driven: Driven) -> None:
    unit = driven.hli.channels[0].control.delete_distance_to_go
    claim(unit, True)
    driven.watch(1)
    claim(unit, False)


@pytest.mark.spec("hli.ch.cu.delete-distance-to-go")
@pytest.mark.parametrize(
    "then",
    [
        "N20 Y50\nN30 X100 Y80\n",
        "N20 G03 X100 Y40 I0 J40\nN30 G01 Y90\n",
        "N15 #FLUSH WAIT\nN20 G01 Y50\nN30 X100 Y80\n",
    ],
)
def test_the_rest_of_a_block_is_dropped_and_the_path_goes_straight_to_the_next_target(
    driven: Driven, then: str
) -> None:
    driven.start(f"%D\nN10 G90 G162 G01 F6000 X60\n{then}N90 M30\n")
    driven.until_x(20.0)
    delete_distance(driven)
    driven.until(lambda: place(driven, Y) > 0.0)
    turned = float(driven.targets[-2][X])
    assert 20.0 < turned < 25.0
    driven.until_done()
    assert driven.errors == []
    straight = np.array([t[:2] for t in driven.targets if t[X] <= 60.0 and 0.0 < t[Y] < 50.0])
    goal = (60.0, 50.0) if "G03" not in then else (100.0, 40.0)
    way = np.array(goal) - (turned, 0.0)
    off = (straight - (turned, 0.0)) @ np.array([-way[1], way[0]]) / np.hypot(*way)
    assert np.abs(off).max() < 1e-6
    driven.assert_no_jump()


@pytest.mark.spec("hli.ch.cu.delete-distance-to-go")
def test_where_no_motion_is_there_is_nothing_to_delete(driven: Driven) -> None:
    driven.start("%D\nN10 G90 G01 F6000 X10\nN20 M0\nN30 X30\nN40 M30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.WAIT_CONTINUE))
    driven.watch(5)
    delete_distance(driven)
    driven.watch(5)
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert place(driven) == 30.0
    assert driven.errors == []


@pytest.mark.spec("hli.ch.cu.delete-distance-to-go")
def test_deleting_the_last_motion_ends_the_program_there(driven: Driven) -> None:
    driven.start("%D\nN10 G90 G01 F6000 X100\nN20 M30\n")
    driven.until_x(20.0)
    delete_distance(driven)
    driven.until_done()
    assert 20.0 < place(driven) < 25.0
    assert driven.errors == []
    assert driven.state() is not State.ERROR


# ---------------------------------------------------------------------------------------------------- limits


@pytest.mark.spec("hli.ax.cu.position-limits")
def test_dynamic_limits_are_kept_by_the_path(driven: Driven) -> None:
    control = axis_unit(driven, X)
    claim(control.dyn_pos_limit_high, 800_000)
    driven.start("%D\nN10 G90 G00 X300\nN20 M30\n")
    driven.watch(20)
    assert control.dyn_pos_limit_high.state_r == 1
    stops(driven, StopCondition.AXIS_LIMIT)
    assert 60.0 < place(driven) <= 80.0
    assert control.dyn_pos_limit_high.state_r == 2
    driven.assert_brakes_within_limits([X])
    claim(control.dyn_pos_limit_high, 3_000_000)
    control.dyn_pos_limit_high.enable_w = False
    driven.until_done()
    assert place(driven) == 300.0
    assert control.dyn_pos_limit_high.state_r == 0


@pytest.mark.spec("hli.ax.cu.position-limits")
def test_dynamic_limits_and_blocked_directions_are_kept_by_hand(driven: Driven) -> None:
    hand = Hand(driven)
    control = axis_unit(driven, X)
    claim(control.dyn_pos_limit_high, 50_000)
    by_hand(driven)
    hand.press(1, 1)
    hand.rest()
    assert place(driven) == pytest.approx(5.0)
    hand.press(1, 0)
    claim(control.directional_feedhold, int(Blocked.MINUS))
    hand.press(1, -1)
    driven.watch(300)
    assert place(driven) == pytest.approx(5.0)
    claim(control.directional_feedhold, 0)
    driven.watch(300)
    assert place(driven) < 4.0


# ---------------------------------------------------------------------------------------------------- axes out of use


@pytest.mark.spec("hli.ax.cu.drive-enables")
def test_a_drive_needs_both_enables(driven: Driven) -> None:
    control = axis_unit(driven, X)
    for unit in (control.drive_on, control.torque_permission):
        claim(unit, False)
        driven.watch(5)
        assert driven.image.state[X] != DriveState.OPERATION_ENABLED
        claim(unit, True)
        driven.watch(5)
        assert driven.image.state[X] == DriveState.OPERATION_ENABLED


@pytest.mark.spec("hli.ax.cu.follow-up")
def test_an_axis_in_tracking_takes_its_actual_position_over(driven: Driven) -> None:
    control = axis_unit(driven, X)
    claim(control.follow_up, True)
    driven.watch(5)
    assert driven.hli.axes[X].status.axis_state_r == 5
    driven.image.actual_position[X] = 12.5  # pushed
    driven.watch(3)
    assert place(driven) == 12.5
    driven.start(LEGS)
    assert driven.alarm(alarms.AXES_NOT_READY)
    claim(control.follow_up, False)
    driven.watch(5)
    driven.start(LEGS)
    driven.watch(20)
    claim(control.follow_up, True)
    driven.until_done()
    assert driven.alarm(alarms.AXIS_TRACKING)
    driven.assert_no_jump()


@pytest.mark.spec("hli.ax.cu.parking")
def test_a_program_runs_without_a_parked_axis_and_stops_before_it_moves_it(driven: Driven) -> None:
    control = axis_unit(driven, Y)
    claim(control.parked, True)
    driven.watch(5)
    assert control.parked.state_r
    assert driven.image.state[Y] != DriveState.OPERATION_ENABLED
    driven.start("%P\nN10 G90 G01 F6000 X[30+10*V.A.AXIS_DEACTIVATED.Y]\nN20 M30\n")
    claim(control.parked, False)
    driven.watch(10)
    assert control.parked.state_r, "taken over when the program is over"
    driven.until_done()
    assert place(driven) == 40.0
    driven.watch(5)
    assert not control.parked.state_r
    claim(control.parked, True)
    driven.watch(5)
    driven.start(LEGS)
    driven.until_done()
    assert driven.alarm(alarms.PARKED_MOVED)
    assert place(driven, Y) == 0.0
    driven.assert_no_jump()


@pytest.mark.spec("hli.ax.cu.lag-monitoring")
def test_the_following_error_is_monitored_unless_the_plc_switches_it_off(driven: Driven) -> None:
    control = axis_unit(driven, X)
    for off in (True, False):
        claim(control.lag_monitoring_off, off)
        driven.watch(2)
        driven.simulation.controller.supervision._lag_limit[X] = -1.0
        driven.watch(3)
        assert bool(driven.simulation.controller.supervision.faults[X]) is not off
    assert driven.alarm(alarms.FOLLOWING_ERROR)


# ---------------------------------------------------------------------------------------------------- skip levels


@pytest.mark.spec("hli.ch.cu.skip-levels")
def test_numbered_levels_follow_the_mask_and_the_plain_slash_stays_as_it_was(driven: Driven) -> None:
    driven.start("%K\nN10 G90 G01 F6000 X20\nN20 #FLUSH WAIT\n/N30 Y20\n/2 N40 X40\n/3 N50 Y[V.A.ABS.Y+5]\nN60 M30\n")
    driven.until_x(5.0)
    driven.operator.program_block_ignore_w = 0b11
    driven.until_done()
    assert (place(driven, X), place(driven, Y)) == (20.0, 25.0)


# ---------------------------------------------------------------------------------------------------- machine lock


def test_with_machine_lock_everything_runs_but_the_axes(driven: Driven) -> None:
    driven.operator.machine_lock_w = True
    driven.start("%L\nN10 G90 G01 F6000 X60 M8\nN20 Y50 G60\nN30 M30\n")
    driven.watch(20)
    assert driven.hli.channels[0].status.machine_locked_r
    driven.operator.machine_lock_w = False
    driven.until_done()
    assert np.abs(np.array(driven.targets)[:, :3]).max() == 0.0
    plc = driven.simulation.plc
    assert isinstance(plc, ScriptedPlc)
    assert (1, 8) in plc.taken
    assert driven.channel.path_length == pytest.approx(110.0)
    driven.start(LEGS)
    driven.until_done()
    assert place(driven) == 20.0
    assert driven.errors == []
    assert driven.mode is Mode.AUTOMATIC
