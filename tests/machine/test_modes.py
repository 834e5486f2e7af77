"""Operating modes: NC blocks by hand, axes moved by keys and handwheels, homing."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from runtime.config.machine import HomingSetup, Machine
from runtime.diagnostics.catalogue import machine as alarms
from runtime.diagnostics.catalogue import plc
from runtime.hli.layout import Activation, JogParameter, KeyPress, ManualMode, ManualState, Mode, State, StopCondition
from runtime.plc_logic.areas import ChannelPort
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc

X, Y, Z = 0, 1, 2


class Hand:
    """The operator at keys and handwheels."""

    def __init__(self, driven: Driven) -> None:
        self.driven = driven
        self.operator = driven.operator

    def press(self, key: int, direction: int, hold: float = 0.0) -> None:
        self.operator.key.data_w = KeyPress(key, direction, round(hold * 1e6))
        self.operator.key.semaphor_rw = True
        self.driven.watch(2)

    def link(self, axis: int, element: int, mode: ManualMode, stage: int = 0) -> None:
        self.operator.activation.data_w = Activation(axis, element, int(mode), stage)
        self.operator.activation.semaphor_rw = True
        self.driven.watch(2)

    def parameter(self, unit: str, axis: int, width: float = 0.0, velocity: float = 0.0) -> None:
        job = getattr(self.operator, unit)
        job.data_w = JogParameter(axis, round(width * 1e4), round(velocity * 1e3))
        job.semaphor_rw = True
        self.driven.watch(2)

    def turn(self, wheel: int, pulses: int) -> None:
        self.operator.handwheel_w[wheel - 1] += pulses
        self.driven.watch(1)

    def rest(self) -> None:
        """Until the axes stand."""
        self.driven.until(lambda: self.driven.channel.beside.at_rest)
        self.driven.watch(2)


def make(machine: Machine, folder: Path) -> Driven:
    return Driven(machine, folder, ideal_axes=True, partner=lambda memory: ScriptedPlc(memory, {}))


@pytest.fixture
def driven(demo: Machine, tmp_path: Path) -> Driven:
    return make(demo, tmp_path)


@pytest.fixture
def hand(driven: Driven) -> Hand:
    return Hand(driven)


def by_hand(driven: Driven, blocks: str = "") -> None:
    """MANUAL, until the keys act."""
    driven.simulation.order(Mode.MANUAL, State.ACTIVE, blocks)
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
    driven.watch(1)


def place(driven: Driven, axis: int = X) -> float:
    return float(driven.image.target_position[axis])


def velocity(driven: Driven, axis: int = X) -> float:
    return float(driven.targets[-1][axis] - driven.targets[-2][axis]) / driven.simulation.period


def with_channel(machine: Machine, **parameters: object) -> Machine:
    """The machine with other channel parameters."""
    channel = machine.channels[0]
    changed = channel.model_copy(update={"parameters": channel.parameters.model_copy(update=parameters)})
    return machine.model_copy(update={"channels": (changed,)})


# ---------------------------------------------------------------------------------------------------- MDI


@pytest.mark.spec("hli.mode.mdi")
@pytest.mark.parametrize("separator", ["\r\n", "\n"])
def test_mdi_executes_the_blocks_of_its_order(driven: Driven, separator: str) -> None:
    driven.simulation.order(Mode.MDI, State.ACTIVE, separator.join(["G90 G01 F6000 X10", "Y5"]))
    driven.watch(3)
    assert (driven.mode, driven.state()) == (Mode.MDI, State.ACTIVE)
    driven.until_done()
    driven.watch(2)
    assert driven.state() is State.SELECTED
    assert (place(driven, X), place(driven, Y)) == (10.0, 5.0)
    assert driven.alarms == []


@pytest.mark.spec("chan.sub.start", "chan.sub.end", "hli.mode.mdi")
@pytest.mark.parametrize(("end", "modes"), [("", "MDI"), ("\nM30", "AUTOMATIC | MDI"), ("", "AUTOMATIC")])
def test_the_programs_at_start_and_end_of_mdi(demo: Machine, tmp_path: Path, end: str, modes: str) -> None:
    (tmp_path / "start.nc").write_text('$IF V.G.MAIN_FILE_NAME == "-"\nG01 F6000 Y5\n$ENDIF\nM17')
    (tmp_path / "final.nc").write_text("G01 F6000 Z-7\nM17")
    machine = with_channel(
        demo,
        start_init_prog_file=str(tmp_path / "start.nc"),
        start_init_prog_file_mode=modes,
        final_prog_file=str(tmp_path / "final.nc"),
        final_prog_file_mode=modes,
    )
    driven = make(machine, tmp_path)
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G01 F6000 X10" + end)
    driven.watch(3)
    driven.until_done()
    driven.watch(2)
    both = "MDI" in modes
    assert [place(driven, axis) for axis in (X, Y, 2)] == [10.0, 5.0 if both else 0.0, -7.0 if both else 0.0]
    assert driven.alarms == []


@pytest.mark.spec("hli.mode.mdi")
def test_mdi_is_loaded_held_resumed_and_aborted(driven: Driven) -> None:
    simulation = driven.simulation
    simulation.order(Mode.MDI, State.READY, "G01 F6000 X300")
    driven.watch(3)
    assert driven.state() is State.READY
    simulation.order(Mode.MDI, State.ACTIVE)
    driven.until_x(20.0)
    simulation.order(Mode.MDI, State.HOLD)
    driven.watch(500)
    assert (driven.state(), velocity(driven)) == (State.HOLD, 0.0)
    simulation.order(Mode.MDI, State.ACTIVE)
    driven.until_x(100.0)
    simulation.order(Mode.MDI, State.SELECTED)
    driven.until_done()
    driven.watch(2)
    assert driven.state() is State.SELECTED
    assert 100.0 < place(driven) < 300.0
    driven.assert_no_jump()


@pytest.mark.spec("hli.mech.lc-control-unit")
def test_the_plc_agrees_to_a_change_of_the_mode(driven: Driven) -> None:
    area = driven.hli.channels[0]
    port = ChannelPort(area)
    port.claims_modes = True
    port.update()
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G01 F6000 X60")
    driven.watch(50)
    assert not driven.operator.order_semaphor_rw, "taken; it is the PLC's turn"
    assert port.wanted_mode is Mode.MDI
    assert (driven.mode, driven.channel.active) == (Mode.STANDBY, False)
    port.agree_mode()
    assert port.wanted_mode is None
    driven.watch(2)
    assert (driven.mode, driven.channel.active) == (Mode.MDI, True)
    driven.until_done()
    assert place(driven) == 60.0
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G01 F6000 X50")  # the mode stays: nobody is asked
    driven.watch(2)
    assert driven.channel.active
    driven.until_done()
    assert driven.errors == []


@pytest.mark.spec("hli.mech.lc-control-unit")
def test_a_reset_takes_the_question_back_and_a_plc_that_goes_answers_itself(driven: Driven) -> None:
    area = driven.hli.channels[0]
    port = ChannelPort(area)
    port.claims_modes = True
    port.update()
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G01 F6000 X60")
    driven.watch(5)
    driven.reset()
    assert port.wanted_mode is None
    assert driven.alarm(plc.MODE_NOT_AGREED)
    port.agree_mode()  # too late
    driven.watch(5)
    assert (driven.mode, driven.channel.active) == (Mode.STANDBY, False)
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G01 F6000 X60")
    driven.watch(5)
    assert port.wanted_mode is Mode.MDI
    port.claims_modes = False
    port.update()  # it gives the unit back: the driver answers itself
    driven.watch(2)
    assert (driven.mode, driven.channel.active) == (Mode.MDI, True)
    assert not area.lc_mode.please_rw
    driven.until_done()


@pytest.mark.spec("hli.mech.lc-control-unit")
def test_the_plc_takes_part_in_a_reset(driven: Driven) -> None:
    """Functions are forgotten on both sides before a new one goes out."""
    area = driven.hli.channels[0]
    partner = driven.simulation.plc
    assert isinstance(partner, ScriptedPlc)
    partner.delays = {(1, 20): None}
    driven.start("%F\nN10 G90 G01 F6000 X10\nN20 M20\nN30 M30\n")
    driven.until(lambda: (1, 20) in partner.taken)
    driven.reset()
    assert area.lc_reset.please_rw
    driven.until(lambda: not area.lc_reset.please_rw, 0.1)
    assert area.lc_reset.done_w
    partner.delays = {}
    driven.until_done()
    driven.start("%F\nN10 G90 G01 F6000 X20\nN20 M20\nN30 M30\n")
    driven.until_done()
    assert driven.errors == []
    assert partner.taken.count((1, 20)) == 2


def test_a_hold_is_taken_back_while_the_path_still_brakes(driven: Driven) -> None:
    """The state is ACTIVE until the path stands; the order to go on must not count as done because of that."""
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G90 G01 F6000 X60")
    driven.watch(100)
    driven.simulation.order(Mode.MDI, State.HOLD)
    driven.watch(5)
    assert driven.state() is State.ACTIVE
    driven.simulation.order(Mode.MDI, State.ACTIVE)
    driven.until_done()
    assert place(driven) == 60.0
    assert driven.errors == []


def test_what_is_wrong_in_mdi_is_told_and_moves_nothing(driven: Driven) -> None:
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G01 F6000 X10 Y[")
    driven.watch(20)
    assert driven.state() is State.ERROR
    assert place(driven) == 0.0
    assert driven.alarms[-1].text.startswith("mdi.nc:1:")
    driven.reset()
    driven.simulation.order(Mode.MDI, State.ACTIVE, "G01 F6000 X10")
    driven.watch(2)
    driven.until_done()
    assert place(driven) == 10.0


def test_the_program_knows_its_mode(driven: Driven) -> None:
    driven.simulation.order(Mode.MDI, State.ACTIVE, "P1 = V.G.ACTIVE_MODE\nG01 F6000 XP1")
    driven.watch(3)
    driven.until_done()
    assert place(driven) == float(Mode.MDI)


# ---------------------------------------------------------------------------------------------------- keys


@pytest.mark.spec("hli.mode.manual", "hli.hb.cu.key", "hli.hb.status", "isg.g.manual-overview")
def test_an_axis_moves_as_long_as_its_key_is_pressed(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    shown = driven.hli.channels[0].status.hb_display_r[X]
    assert (driven.mode, driven.state()) == (Mode.MANUAL, State.ACTIVE)
    assert (shown.state_r, shown.operation_mode_r) == (ManualState.LINKED, ManualMode.CONTINUOUS)
    hand.press(1, 1)
    driven.watch(500)
    assert velocity(driven) == pytest.approx(shown.tipp_geschw_r * 1e-3)
    hand.press(1, 0)
    hand.rest()
    stood = place(driven)
    assert stood > 10.0
    assert shown.offset_r == round(stood * 1e4)
    hand.press(1, -1)
    driven.watch(300)
    assert velocity(driven) < 0.0
    hand.press(1, 0)
    hand.rest()
    driven.assert_no_jump()
    driven.assert_brakes_within_limits([X, Y, Z])


@pytest.mark.spec("hli.mode.manual")
def test_leaving_manual_brakes_and_the_next_program_starts_where_the_axis_stands(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    hand.press(2, 1)
    driven.watch(400)
    driven.simulation.order(Mode.MANUAL, State.SELECTED)
    driven.until_done()
    driven.watch(2)
    assert driven.state() is State.SELECTED
    assert velocity(driven, Y) == 0.0
    stood = place(driven, Y)
    hand.press(2, 0)
    driven.start("%P\nN10 G90 G01 F6000 X10\nN20 M30\n")
    driven.until_done()
    assert place(driven, X) == 10.0
    assert place(driven, Y) == pytest.approx(stood)
    driven.assert_no_jump()
    driven.assert_brakes_within_limits([X, Y, Z])


@pytest.mark.spec("isg.g.manual-exclusive-g200", "chan.manual.limits")
def test_an_axis_stops_exactly_at_its_software_limit(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    hand.parameter("continuous_parameter", 1, velocity=400.0)
    hand.press(1, -1)
    hand.rest()
    assert place(driven) == pytest.approx(-50.0, abs=1e-9)
    driven.assert_brakes_within_limits([X])


def test_a_key_that_is_pressed_already_moves_nothing(driven: Driven, hand: Hand) -> None:
    hand.press(1, 1)
    by_hand(driven)
    driven.watch(300)
    assert place(driven) == 0.0
    hand.press(1, 0)
    hand.press(1, 1)
    driven.watch(100)
    assert place(driven) > 0.0


def test_a_press_that_is_not_renewed_ends_by_itself(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    hand.press(1, 1, hold=0.2)
    driven.watch(600)
    assert velocity(driven) == 0.0
    assert 1.0 < place(driven) < 15.0


@pytest.mark.spec("hli.hb.cu.parameters", "hli.hb.cu.activation")
def test_an_increment_is_exact_and_one_per_press(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    hand.parameter("jog_parameter", 1, width=2.5, velocity=20.0)
    hand.link(1, 1, ManualMode.INCREMENTAL)
    hand.press(1, 1)
    hand.rest()
    driven.watch(200)
    assert place(driven) == pytest.approx(2.5)
    hand.press(1, 0)
    hand.press(1, -1)
    hand.press(1, 0)
    hand.rest()
    assert place(driven) == pytest.approx(0.0, abs=1e-9)


@pytest.mark.spec("isg.g.manual-overview")
def test_an_interruptible_increment_ends_with_its_key(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    hand.parameter("jog_parameter", 1, width=100.0, velocity=20.0)
    hand.link(1, 1, ManualMode.INTERRUPTIBLE)
    hand.press(1, 1)
    driven.watch(500)
    hand.press(1, 0)
    hand.rest()
    assert 5.0 < place(driven) < 15.0


@pytest.mark.spec("hli.hb.cu.activation", "isg.g.manual-overview", "chan.manual.override")
@pytest.mark.parametrize(("scaled", "share"), [(False, 1.0), (True, 0.1)])
def test_a_handwheel_moves_its_axis_by_the_pulses(demo: Machine, tmp_path: Path, scaled: bool, share: float) -> None:
    driven = make(with_channel(demo, override_v_handwheel=scaled), tmp_path)
    hand = Hand(driven)
    driven.operator.override_w = 100
    by_hand(driven)
    hand.parameter("handwheel_parameter", 1, width=0.1)
    hand.link(1, 2, ManualMode.HANDWHEEL)
    fastest = 0.0
    for _ in range(200):
        hand.turn(2, 4)
        fastest = max(fastest, abs(velocity(driven)))
    hand.rest()
    assert place(driven) == pytest.approx(80.0)
    assert fastest <= 400.0 * share * 1.001
    hand.turn(2, -100)
    hand.rest()
    assert place(driven) == pytest.approx(70.0)
    driven.assert_brakes_within_limits([X])


def test_override_and_feed_hold_act_on_keys(driven: Driven, hand: Hand) -> None:
    by_hand(driven)
    driven.operator.override_w = 500
    hand.press(1, 1)
    driven.watch(400)
    assert velocity(driven) == pytest.approx(20.0)
    driven.operator.feedhold_w = True
    driven.watch(400)
    assert velocity(driven) == 0.0
    driven.operator.feedhold_w = False
    driven.watch(400)
    assert velocity(driven) == pytest.approx(20.0)
    unit = driven.hli.axes[X].control.feedhold
    driven.hli.axes[X].plc_present_w = unit.enable_w = unit.command_w = True
    driven.watch(400)
    assert velocity(driven) == 0.0


@pytest.mark.spec("hli.hb.cu.activation")
def test_elements_are_linked_only_while_the_axis_is_released(driven: Driven, hand: Hand) -> None:
    hand.link(1, 1, ManualMode.CONTINUOUS)
    assert driven.alarm(plc.MANUAL_NOT_NOW)
    by_hand(driven, "G200 Y1")
    hand.link(2, 5, ManualMode.INCREMENTAL)
    shown = driven.hli.channels[0].status.hb_display_r
    assert (shown[X].state_r, shown[Y].state_r) == (ManualState.OFF, ManualState.LINKED)
    assert (shown[Y].operation_mode_r, shown[Y].control_element_r) == (ManualMode.INCREMENTAL, 5)
    hand.press(1, 1)
    driven.watch(300)
    assert place(driven, X) == 0.0
    hand.link(2, 0, ManualMode.NONE)
    assert shown[Y].state_r == ManualState.RELEASED
    hand.link(2, 33, ManualMode.CONTINUOUS)
    assert driven.alarm(plc.MANUAL_VALUE)


def test_a_lost_plc_stops_an_axis_that_is_moved_by_hand(demo: Machine, tmp_path: Path) -> None:
    driven = make(demo, tmp_path)
    hand = Hand(driven)
    by_hand(driven)
    hand.press(1, 1)
    driven.watch(300)
    plc_partner = driven.simulation.controller.plc
    assert plc_partner is not None
    driven.hli.channels[0].plc_present_w = False
    driven.until_done()
    driven.watch(2)
    assert velocity(driven) == 0.0
    assert driven.state() is State.ERROR
    driven.assert_brakes_within_limits([X])


# ---------------------------------------------------------------------------------------------------- G200 in a program


@pytest.mark.spec("isg.g.manual-exclusive-g200")
def test_g200_lets_the_axes_be_moved_and_the_program_goes_on_exactly(driven: Driven, hand: Hand) -> None:
    driven.start(
        "%P\nN10 G90 G01 F6000 X20 Y10\nN20 G200\nN30 P1=V.A.MANUAL_OFFSETS.X\nN40 G91 Y1\nN50 G90 X[30+P1]\nN60 M30\n"
    )
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
    driven.watch(2)
    hand.press(1, 1)
    driven.watch(300)
    hand.press(1, 0)
    hand.rest()
    moved = place(driven) - 20.0
    assert moved > 5.0
    driven.operator.continue_motion_rw = True
    driven.until(lambda: place(driven, Y) > 10.5)
    assert place(driven, X) == pytest.approx(20.0 + moved, abs=1e-9)
    driven.until_done()
    assert place(driven, X) == pytest.approx(30.0 + moved)
    assert driven.alarms == []
    driven.assert_no_jump()


@pytest.mark.spec("chan.manual.deselect")
@pytest.mark.parametrize(("rejected", "way"), [(False, 50.0), (True, 20.0)])
def test_what_is_left_of_an_increment_at_deselection(demo: Machine, tmp_path: Path, rejected: bool, way: float) -> None:
    driven = make(with_channel(demo, path_reject_std_manual_mode=rejected), tmp_path)
    hand = Hand(driven)
    driven.start("%P\nN10 G200\nN20 M30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
    hand.parameter("jog_parameter", 1, width=50.0, velocity=40.0)
    hand.link(1, 1, ManualMode.INCREMENTAL)
    hand.press(1, 1)
    driven.watch(300)
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert (place(driven) == pytest.approx(50.0)) is not rejected
    assert place(driven) <= way + 1e-9
    driven.assert_brakes_within_limits([X])


@pytest.mark.spec("chan.manual.deselect")
def test_an_axis_that_moves_at_deselection_is_an_error_if_configured_so(demo: Machine, tmp_path: Path) -> None:
    driven = make(with_channel(demo, err_outp_manual_mode_move=True), tmp_path)
    hand = Hand(driven)
    driven.start("%P\nN10 G200\nN20 M30\n")
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
    driven.watch(2)
    hand.press(1, 1)
    driven.watch(300)
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert driven.alarm(alarms.MANUAL_MOVING)
    assert velocity(driven) == 0.0


# ---------------------------------------------------------------------------------------------------- G201, G202

BESIDE = (
    "%B\n#MANUAL LIMITS [AX=Y NEGATIVE=-5 POSITIVE=8]\nN10 G90 G01 F3000 X1\nN20 G201 Y1\nN30 X200\nN40 G202\n"
    "N50 #GET MANUAL OFFSETS\nP1=V.A.MANUAL_OFFSETS.Y\nN60 X210\nN70 #CHANNEL INIT [CMDPOS]\nP2=V.A.ABS.Y\n"
    "N80 X220 Y[P1+2]\nN90 M30\n"
)


@pytest.mark.spec("isg.g.manual-parallel-g201-g202", "isg.g.manual-limits", "isg.g.request-manual-offsets")
def test_an_axis_is_moved_by_hand_beside_the_path(driven: Driven, hand: Hand) -> None:
    driven.start(BESIDE)
    driven.until_x(20.0)
    hand.parameter("continuous_parameter", 2, velocity=10.0)
    hand.link(2, 2, ManualMode.CONTINUOUS)
    hand.press(2, 0)
    hand.press(2, 1)
    driven.until_x(40.0)
    assert velocity(driven, X) == pytest.approx(50.0), "the path goes on as programmed"
    assert velocity(driven, Y) == pytest.approx(10.0)
    driven.until_x(150.0)
    assert place(driven, Y) == pytest.approx(8.0), "the relative limit"
    hand.press(2, 0)
    driven.until_done()
    assert driven.alarms == []
    assert place(driven, X) == pytest.approx(220.0)
    assert place(driven, Y) == pytest.approx(10.0), "absolute again behind #CHANNEL INIT"
    decoder = driven.simulation.preparation.decoder
    assert decoder is not None
    assert decoder.parameters[1] == pytest.approx(8.0)
    assert decoder.parameters[2] == pytest.approx(8.0)
    driven.assert_no_jump()
    driven.assert_brakes_within_limits([X, Y, Z])


@pytest.mark.spec("isg.g.manual-parallel-g201-g202", "isg.g.manual-program-end")
def test_path_and_hand_together_keep_the_limits_of_the_axis(demo: Machine, tmp_path: Path) -> None:
    axes = tuple(axis.model_copy(update={"velocity_step": 0.0}) for axis in demo.axes)
    driven = make(demo.model_copy(update={"axes": axes}), tmp_path)
    hand = Hand(driven)
    driven.start("%F\nN10 G201 X1\nN20 G00 X300\nN30 X0\nN40 X300\nN50 M30\n")
    driven.watch(5)
    hand.parameter("continuous_parameter", 1, velocity=400.0)
    hand.link(1, 1, ManualMode.CONTINUOUS)
    for direction in (1, -1, 1, -1):
        hand.press(1, 0)
        hand.press(1, direction)
        driven.watch(300)
    hand.press(1, 0)
    driven.until_done()
    assert driven.alarms == []
    driven.assert_no_jump()
    driven.assert_brakes_within_limits([X])


@pytest.mark.spec("chan.manual.limits")
def test_a_program_never_takes_an_offset_over_the_software_limit(driven: Driven, hand: Hand) -> None:
    driven.start("%L\nN10 G90 G01 F6000 X500\nN20 G201 X1\nN30 G04 X2\nN40 G01 F12000 X640\nN50 M30\n")
    driven.until_x(500.0)
    driven.watch(100)
    hand.parameter("continuous_parameter", 1, velocity=50.0)
    hand.link(1, 1, ManualMode.CONTINUOUS)
    hand.press(1, 0)
    hand.press(1, 1)
    driven.watch(1000)
    hand.press(1, 0)
    driven.until_done()
    assert driven.alarm(alarms.OFFSET_LEAVES)
    assert max(targets[X] for targets in driven.targets) <= 650.0
    driven.assert_brakes_within_limits([X])


@pytest.mark.spec("isg.g.manual-parameters")
def test_stages_of_the_program_are_chosen_by_their_number(driven: Driven, hand: Hand) -> None:
    driven.start(
        "%S\n#HANDWHEEL [AX=X RES1=1 RES2=2 RES3=5]\n#JOG CONT [AXNR=1 FEED1=600 FEED2=1200]\n"
        "#JOG INCR [AX=X DIST1=1 FEED1=600 DIST2=3 FEED2=1200]\nN10 G200\nN20 M30\n"
    )
    driven.until(lambda: bool(driven.channel.stop_condition & StopCondition.MANUAL))
    hand.link(1, 1, ManualMode.CONTINUOUS, 2)
    hand.press(1, 1)
    driven.watch(300)
    assert velocity(driven) == pytest.approx(20.0)
    hand.press(1, 0)
    hand.rest()
    stood = place(driven)
    hand.link(1, 1, ManualMode.INCREMENTAL, 2)
    hand.press(1, 0)
    hand.press(1, 1)
    hand.rest()
    assert place(driven) == pytest.approx(stood + 3.0)
    hand.link(1, 1, ManualMode.HANDWHEEL, 3)
    hand.turn(1, 100)
    hand.rest()
    assert place(driven) == pytest.approx(stood + 8.0)


# ---------------------------------------------------------------------------------------------------- homing


def homing_machine(machine: Machine) -> Machine:
    """X and Y look for a cam that the PLC tells, Z has an absolute encoder."""
    setup = HomingSetup(fast=50.0, slow=5.0, position=-40.0)
    axes = [axis.model_copy(update={"homing": setup}) if axis.name in "XY" else axis for axis in machine.axes]
    return machine.model_copy(update={"axes": tuple(axes)})


class Cams:
    """Each axis stands on its cam below `cam`, in the coordinates of before."""

    def __init__(self, driven: Driven, cams: dict[int, float]) -> None:
        self.driven, self.cams = driven, cams
        self.ends = dict(cams)
        for axis in cams:
            area = driven.hli.axes[axis]
            area.plc_present_w = area.control.reference_cam.enable_w = True

    def watch(self, cycles: int) -> None:
        for _ in range(cycles):
            for axis, cam in self.cams.items():
                raw = float(self.driven.image.actual_position[axis] - self.driven.image.origin[axis])
                self.driven.hli.axes[axis].control.reference_cam.command_w = raw < cam
            self.driven.watch(1)

    def until_done(self) -> None:
        self.watch(3)
        for _ in range(30000):
            if not self.driven.channel.active:
                self.watch(3)
                return
            self.watch(1)
        raise AssertionError("homing does not end")


@pytest.mark.spec("isg.g.homing-g74", "hli.mode.homing", "hli.ax.cu.homing")
def test_homing_gives_the_axes_their_reference_rank_by_rank(demo: Machine, tmp_path: Path) -> None:
    driven = make(homing_machine(demo), tmp_path)
    cams = Cams(driven, {X: -20.0, Y: -30.0})
    status = [driven.hli.axes[i].status for i in range(3)]
    driven.watch(2)
    assert [bool(s.referenced_r) for s in status] == [False, False, True]
    driven.start("%P\nN10 G90 G01 F6000 X10\nN20 M30\n")
    assert driven.alarm(alarms.NOT_REFERENCED)
    assert driven.state() is State.SELECTED
    driven.simulation.order(Mode.HOMING, State.ACTIVE, "G74 X2 Y1 Z1")
    begin = len(driven.targets)
    cams.until_done()
    assert all(s.referenced_r for s in status)
    assert place(driven, X) == pytest.approx(-40.0)
    assert place(driven, Y) == pytest.approx(-40.0)
    # the place where the cam was left slowly has become -40: off by what the axis moves in two cycles at most
    assert driven.image.origin[X] == pytest.approx(-20.0, abs=2 * 5.0 * 0.001 + 1e-9)
    assert driven.image.origin[Y] == pytest.approx(-10.0, abs=2 * 5.0 * 0.001 + 1e-9)
    moves = np.abs(np.diff(np.array(driven.targets[begin:]), axis=0)) > 0.0
    last_of_y, first_of_x = np.flatnonzero(moves[:, Y])[-1], np.flatnonzero(moves[:, X])[0]
    assert first_of_x > last_of_y
    driven.start("%P\nN10 G90 G01 F6000 X10 Y0\nN20 M30\n")
    driven.until_done()
    assert (place(driven, X), place(driven, Y)) == (10.0, 0.0)
    assert [line.id for line in driven.alarms] == [alarms.NOT_REFERENCED.id]


def test_an_axis_on_its_cam_leaves_it_at_once(demo: Machine, tmp_path: Path) -> None:
    driven = make(homing_machine(demo), tmp_path)
    cams = Cams(driven, {X: 5.0, Y: 0.0})
    cams.watch(1)
    driven.simulation.order(Mode.HOMING, State.ACTIVE, "G74 X1")
    cams.until_done()
    assert place(driven) == pytest.approx(-40.0)
    assert driven.image.origin[X] == pytest.approx(-45.0, abs=0.011)
    assert not driven.hli.axes[Y].status.referenced_r


@pytest.mark.spec("isg.g.homing-g74")
def test_a_program_homes_and_goes_on_from_there(demo: Machine, tmp_path: Path) -> None:
    driven = make(homing_machine(demo), tmp_path)
    cams = Cams(driven, {X: -20.0, Y: -30.0})
    driven.simulation.order(Mode.HOMING, State.ACTIVE, "G74 X1 Y1\nG90 G01 F6000 X-10 Y-20")
    cams.until_done()
    assert driven.errors == []
    assert (place(driven, X), place(driven, Y)) == pytest.approx((-10.0, -20.0))


def test_a_cam_that_never_comes_ends_the_search(demo: Machine, tmp_path: Path) -> None:
    driven = make(homing_machine(demo), tmp_path)
    Cams(driven, {X: 0.0, Y: 0.0})
    driven.simulation.order(Mode.HOMING, State.ACTIVE, "G74 X1")
    driven.watch(3)
    driven.until(lambda: not driven.channel.active, 30.0)
    assert driven.alarm(alarms.HOMING_NO_CAM)
    assert place(driven) == pytest.approx(-1.1 * 700.0, abs=2.0)
    assert not driven.hli.axes[X].status.referenced_r


def test_homing_without_a_signal_is_refused_before_anything_moves(demo: Machine, tmp_path: Path) -> None:
    driven = make(homing_machine(demo), tmp_path)
    driven.simulation.order(Mode.HOMING, State.ACTIVE, "G74 X1")
    driven.watch(3)
    driven.until_done()
    assert driven.alarm(alarms.HOMING_NO_SIGNAL)
    assert abs(place(driven)) < 1e-3


def test_homing_is_held_and_aborted(demo: Machine, tmp_path: Path) -> None:
    driven = make(homing_machine(demo), tmp_path)
    cams = Cams(driven, {X: -40.0, Y: 0.0})
    driven.simulation.order(Mode.HOMING, State.ACTIVE, "G74 X1")
    cams.watch(300)
    driven.operator.feedhold_w = True
    cams.watch(300)
    assert velocity(driven) == 0.0
    driven.operator.feedhold_w = False
    cams.watch(200)
    assert velocity(driven) == pytest.approx(-50.0)
    driven.simulation.order(Mode.HOMING, State.SELECTED)
    cams.until_done()
    assert velocity(driven) == 0.0
    driven.assert_brakes_within_limits([X])
