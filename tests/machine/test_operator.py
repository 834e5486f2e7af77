"""What the operator and the PLC order while a program runs or none does: through the operator area and the control units."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import language, machine, plc
from runtime.diagnostics.errors import ErrorEntry
from runtime.diagnostics.events import EventKind
from runtime.hli.layout import BoolUnit, Mode, State, StopCondition
from tests.machine.driven import SECOND, Driven, Floats
from tests.machine.scripted_plc import ScriptedPlc

X, Y = 0, 1
# straight, an arc, straight: everything that can be left
BEND = "%BEND\nN10 G90 G17 G162 G01 F6000 X60\nN20 G03 X100 Y40 I0 J40\nN30 G01 Y90\nN40 X70 M01\nN50 X50\nN60 M30\n"
BLOCK_ENDS = [(60.0, 0.0), (100.0, 40.0), (100.0, 90.0), (70.0, 90.0), (50.0, 90.0)]


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    """Ideal axes: what is looked at is what the drives are told. The PLC acknowledges everything and claims nothing."""
    return Driven(demo, tmp_path, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, {}))


def distance_from_bend(x: Floats, y: Floats) -> Floats:
    """From the path of BEND, its N10 to N50, (n,)."""
    along_x = np.hypot(np.clip(x, 0.0, 60.0) - x, y)
    arc = np.abs(np.hypot(x - 60.0, y - 40.0) - 40.0) + np.where((x < 60.0) | (y > 40.0), 1e3, 0.0)
    along_y = np.hypot(x - 100.0, np.clip(y, 40.0, 90.0) - y)
    back = np.hypot(np.clip(x, 50.0, 100.0) - x, y - 90.0)
    return np.asarray(np.minimum.reduce([along_x, arc, along_y, back]))


def assert_on_bend(driven: Driven) -> None:
    places = np.array(driven.targets)
    assert distance_from_bend(places[:, X], places[:, Y]).max() < 1e-9
    driven.assert_no_jump()


def speeds(driven: Driven) -> Floats:
    """Path velocity from cycle to cycle, mm/s."""
    return np.asarray(np.linalg.norm(np.diff(np.array(driven.targets)[:, :3], axis=0), axis=1) / 0.001)


def operator_hold(driven: Driven, on: bool) -> None:
    driven.operator.feedhold_w = on


def plc_hold(driven: Driven, on: bool) -> None:
    claim(driven.hli.channels[0].control.feedhold, on)


def axis_hold(driven: Driven, on: bool) -> None:
    claim(driven.hli.axes[Y].control.feedhold, on)


def mode_hold(driven: Driven, on: bool) -> None:
    driven.simulation.order(Mode.AUTOMATIC, State.HOLD if on else State.ACTIVE)


def claim(unit: BoolUnit, value: bool) -> None:
    unit.enable_w, unit.command_w = True, value


# ---------------------------------------------------------------------------------------------------- feed hold, override


@pytest.mark.parametrize("hold", [operator_hold, plc_hold, axis_hold, mode_hold])
@pytest.mark.parametrize("x", [30.0, 85.0])
def test_feed_hold_stops_on_the_path_and_resume_goes_on_along_it(
    driven: Driven, hold: Callable[[Driven, bool], None], x: float
) -> None:
    driven.start(BEND)
    driven.forget()
    driven.until_x(x)
    hold(driven, True)
    driven.watch(400)
    assert speeds(driven)[-1] == 0.0
    assert driven.state() is State.HOLD
    assert driven.channel.active
    held_at = driven.targets[-1]
    hold(driven, False)
    driven.until_done()
    assert_on_bend(driven)
    assert driven.targets[-1][:2] == pytest.approx([50.0, 90.0])
    assert held_at[X] < 100.0
    assert driven.errors == []


@pytest.mark.parametrize("by_plc", [False, True])
def test_override_changes_the_speed_in_motion_and_never_the_path(demo: Machine, tmp_path: Path, by_plc: bool) -> None:
    parameters = demo.channels[0].parameters.model_copy(update={"max_vb_override": 2000})
    channel = demo.channels[0].model_copy(update={"parameters": parameters})
    fast = demo.model_copy(update={"channels": (channel,)})
    driven = Driven(fast, tmp_path, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, {}))

    def override(tenths: int) -> None:
        if by_plc:
            unit = driven.hli.channels[0].control.override
            unit.enable_w, unit.command_w = True, tenths
        else:
            driven.operator.override_w = tenths

    override(500)
    driven.start("%LINE\nN10 G90 G01 F6000 X400\nN20 M30\n")
    driven.forget()
    for tenths, speed in (
        (500, 50.0),
        (1000, 100.0),
        (2000, 200.0),
        (0, 0.0),
        (100, 10.0),
        (5000, 200.0),
        (1000, 100.0),
    ):
        override(tenths)
        driven.watch(250)
        assert speeds(driven)[-1] == pytest.approx(speed, abs=1e-6), tenths
    driven.until_done()
    driven.assert_brakes_within_limits([X])
    assert driven.targets[-1][X] == pytest.approx(400.0)
    assert driven.errors == []


def test_the_channel_limits_the_override(driven: Driven) -> None:
    driven.operator.override_w = 2000
    driven.start("%LINE\nN10 G90 G01 F6000 X100\nN20 M30\n")
    driven.forget()
    driven.watch(300)
    assert speeds(driven)[-1] == pytest.approx(100.0), "P-CHAN-00056 of the demo: 100 %"


# ---------------------------------------------------------------------------------------------------- stops in the program


@pytest.mark.parametrize("by_plc", [False, True])
def test_single_block_stops_after_every_block(driven: Driven, by_plc: bool) -> None:
    control = driven.hli.channels[0].control
    if by_plc:
        claim(control.single_block, True)
    else:
        driven.operator.single_block_w = True
    driven.start(BEND)
    driven.forget()
    status = driven.hli.channels[0].status
    for place in BLOCK_ENDS:
        driven.until(lambda: bool(status.wait_continue_r))
        assert driven.targets[-1][:2] == pytest.approx(list(place), abs=1e-9)
        assert status.stop_condition_r & StopCondition.SINGLE_BLOCK
        driven.watch(20)
        assert speeds(driven)[-1] == 0.0
        if by_plc:
            claim(control.continue_motion, True)
            driven.until(lambda: not status.wait_continue_r, 0.1)
            claim(control.continue_motion, False)
        else:
            driven.operator.continue_motion_rw = True
            driven.until(lambda: not status.wait_continue_r, 0.1)
    driven.until_done()
    assert_on_bend(driven)


def test_single_block_can_be_taken_back(driven: Driven) -> None:
    driven.operator.single_block_w = True
    driven.start(BEND)
    status = driven.hli.channels[0].status
    driven.until(lambda: bool(status.wait_continue_r))
    driven.operator.single_block_w = False
    driven.watch(5)
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert driven.targets[-1][:2] == pytest.approx([50.0, 90.0])


@pytest.mark.parametrize("wanted", [True, False])
def test_optional_stop(driven: Driven, wanted: bool) -> None:
    driven.operator.optional_stop_w = wanted
    driven.start(BEND)
    status = driven.hli.channels[0].status
    driven.until(lambda: bool(status.wait_continue_r) or not driven.channel.active)
    assert driven.channel.active is wanted
    if wanted:
        assert driven.targets[-1][:2] == pytest.approx([70.0, 90.0], abs=1e-9)
        driven.operator.continue_motion_rw = True
        driven.until_done()
    assert driven.targets[-1][:2] == pytest.approx([50.0, 90.0])


@pytest.mark.parametrize(
    ("levels", "end"), [(0, (30.0, 20.0)), (0b1, (30.0, 0.0)), (0b10, (10.0, 20.0)), (0b11, (10.0, 0.0))]
)
def test_skip_levels_hold_from_the_start_of_a_program(driven: Driven, levels: int, end: tuple[float, float]) -> None:
    driven.operator.program_block_ignore_w = levels
    driven.start("%SKIP\nN10 G90 G01 F6000 X10\n/N20 Y20\n/2 N30 X30\nN40 M30\n")
    driven.until_done()
    assert driven.targets[-1][:2] == pytest.approx(list(end))


# ---------------------------------------------------------------------------------------------------- ending a program


def reset_by_operator(driven: Driven) -> None:
    driven.operator.reset_rw = True


def reset_by_plc(driven: Driven) -> None:
    claim(driven.hli.channels[0].control.reset, True)


def reset_by_axis(driven: Driven) -> None:
    claim(driven.hli.axes[X].control.reset, True)


def abort(driven: Driven) -> None:
    driven.simulation.order(Mode.AUTOMATIC, State.SELECTED)


@pytest.mark.parametrize("end", [reset_by_operator, reset_by_plc, reset_by_axis, abort])
@pytest.mark.parametrize("x", [30.0, 85.0])
def test_reset_and_abort_in_motion_brake_on_the_path_and_another_program_starts(
    driven: Driven, end: Callable[[Driven], None], x: float
) -> None:
    driven.start(BEND)
    driven.forget()
    driven.until_x(x)
    end(driven)
    driven.watch(400)
    assert not driven.channel.active
    assert (driven.mode, driven.state()) == (Mode.AUTOMATIC, State.SELECTED)
    assert_on_bend(driven)
    assert driven.targets[-1][X] < 100.0, "not to the end of the path"
    driven.start(SECOND)
    driven.until_done()
    assert driven.targets[-1][:3] == pytest.approx([30.0, 15.0, 5.0])
    driven.assert_no_jump()
    assert driven.errors == []


def test_a_reset_drops_functions_that_wait_and_the_spindle_stops(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, {(1, 20): None}))
    driven.start("%WAITS\nN10 S3000 M3\nN20 M20\nN30 G90 G01 F6000 X10\nN40 M30\n")
    driven.watch(1000)
    status = driven.hli.channels[0].status
    assert status.wait_techno_acknowledge_r
    assert driven.image.target_velocity[3] == pytest.approx(18000.0)
    driven.reset()
    driven.watch(1000)
    assert not driven.channel.active
    assert status.waiting_functions_r == 0
    assert driven.image.target_velocity[3] == 0.0
    driven.start(SECOND)
    driven.until_done()
    assert driven.targets[-1][X] == pytest.approx(30.0)


# ---------------------------------------------------------------------------------------------------- orders that are refused


def test_a_start_while_a_program_runs_is_refused_and_disturbs_nothing(driven: Driven) -> None:
    driven.start(BEND)
    driven.forget()
    driven.until_x(30.0)
    driven.start(SECOND)
    assert driven.operator.answer_r == plc.MODE_PROGRAM_RUNS.id
    assert b"second.nc" in driven.operator.answer_text_r
    assert driven.alarm(plc.MODE_PROGRAM_RUNS).text
    assert driven.state() is State.ACTIVE
    driven.until_done()
    assert_on_bend(driven)
    assert driven.targets[-1][:2] == pytest.approx([50.0, 90.0])


def test_a_mode_that_does_not_exist_is_refused(driven: Driven) -> None:
    driven.operator.order_w.to_mode, driven.operator.order_w.to_state = 9, State.ACTIVE
    driven.operator.order_semaphor_rw = True
    driven.watch(5)
    assert driven.operator.answer_r == plc.MODE_NOT_AVAILABLE.id
    assert not driven.channel.active
    assert driven.mode is Mode.STANDBY


@pytest.mark.parametrize(
    ("mode", "state", "program", "entry"),
    [
        (Mode.AUTOMATIC, State.ACTIVE, "", plc.MODE_NO_PROGRAM),
        (Mode.AUTOMATIC, State.HOLD, "", plc.MODE_TRANSITION),
        (Mode.AUTOMATIC, State.ERROR, "", plc.MODE_TRANSITION),
        (77, 99, "", plc.MODE_NOT_AVAILABLE),
    ],
)
def test_orders_without_sense(driven: Driven, mode: int, state: int, program: str, entry: ErrorEntry) -> None:
    driven.simulation.order(mode, state, program)  # type: ignore[arg-type]
    driven.watch(5)
    assert driven.operator.answer_r == entry.id
    assert driven.operator.answer_text_r
    assert not driven.operator.order_semaphor_rw
    assert not driven.channel.active


def test_a_missing_program_is_an_error_until_a_reset(driven: Driven) -> None:
    driven.simulation.start(driven.folder / "none.nc")
    driven.watch(10)
    assert driven.alarm(language.FILE_MISSING).active
    assert driven.state() is State.ERROR
    driven.start(SECOND)
    assert driven.operator.answer_r == plc.MODE_RESET_FIRST.id
    driven.reset()
    driven.watch(5)
    assert driven.state() is State.SELECTED
    assert not driven.alarm(language.FILE_MISSING).active
    driven.start(SECOND)
    driven.until_done()
    assert driven.targets[-1][X] == pytest.approx(30.0)


def test_no_start_without_the_plc_that_the_machine_has(demo: Machine, tmp_path: Path) -> None:
    driven = Driven(demo, tmp_path, ideal_axes=True)
    driven.simulation.plc.frozen = True  # type: ignore[union-attr]
    driven.watch(100)
    driven.reset()
    driven.watch(2)
    driven.start(SECOND)
    assert driven.alarm(machine.PLC_NOT_RUNNING)
    assert not driven.channel.active


def test_one_program_after_the_other_and_the_modes_in_between(driven: Driven) -> None:
    from_anywhere = BEND.replace("%BEND\n", "%BEND\nN5 G90 G00 X0 Y0\n")
    for _ in range(3):
        driven.start(from_anywhere)
        assert (driven.mode, driven.state()) == (Mode.AUTOMATIC, State.ACTIVE)
        driven.until_done()
        driven.watch(1)
        assert (driven.mode, driven.state()) == (Mode.AUTOMATIC, State.SELECTED)
        driven.start(SECOND)
        driven.until_done()
        driven.watch(1)
    assert driven.errors == []
    driven.assert_no_jump()
    states = [event.value for event in driven.simulation.log if event.kind is EventKind.MODE]
    assert states.count(float(State.ACTIVE)) >= 6
