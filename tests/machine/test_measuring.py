"""Measuring runs of a program on the whole machine: the drive latches, the path brakes, the program goes on where it stands."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from runtime.config.machine import FeedHoldRamp, Machine, SimulatedServo
from runtime.config.measuring import MeasuringSetup
from runtime.diagnostics.catalogue import block_search, motion
from runtime.diagnostics.catalogue import measuring as errors
from runtime.hli.layout import SearchOrder, State
from runtime.hli.memory import HliMemory
from tests.machine.driven import Driven
from tests.machine.scripted_plc import ScriptedPlc
from tests.recorder.test_keyframes import assert_same_from_each, with_keyframes
from tests.recorder.test_replay import Recorded

EDGE = 33.3337  # mm of the encoder since power-on, which is the position of the axis here
X = 0
Make = Callable[..., Driven]


def measuring_machine(demo: Machine, probe: float | None = EDGE, *, parameters: Mapping[str, object] | None = None,
                      hold: float | None = None, count: int = 2, **setup: Any) -> Machine:  # fmt: skip
    """The demo machine whose axis X has a touch probe at its drive."""
    axes = []
    for axis in demo.axes[:count]:
        assert axis.drive is not None
        servo = SimulatedServo(probe=probe) if axis.name == "X" else axis.drive.simulated
        drive = axis.drive.model_copy(update={"process_data": ("probe_1_rising",), "simulated": servo})
        axes.append(axis.model_copy(update={"measuring": MeasuringSetup(**setup), "drive": drive}))
    if hold is not None:
        axes = [axis.model_copy(update={"feed_hold": FeedHoldRamp(deceleration=hold)}) for axis in axes]
    channel = demo.channels[0]
    if parameters:
        channel = channel.model_copy(update={"parameters": channel.parameters.model_copy(update=parameters)})
    return demo.model_copy(update={"axes": (*axes, *demo.axes[count:]), "channels": (channel,)})


@pytest.fixture
def make(demo: Machine, tmp_path: Path) -> Make:
    def build(probe: float | None = EDGE, **options: Any) -> Driven:
        machine = measuring_machine(demo, probe, **options)
        return Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))

    return build


def variables(driven: Driven) -> dict[int, float]:
    decoder = driven.simulation.preparation.decoder
    assert decoder is not None
    return decoder.parameters


@pytest.mark.spec("isg.g.measure-type1", "isg.g.measuring-framework")
@pytest.mark.parametrize("feed", [300, 3000])
def test_the_value_is_where_the_edge_was_and_not_where_the_axis_stands(make: Make, feed: int) -> None:
    driven = make()
    driven.start(
        f"%PROBE\nN10 G90 G01 X10 F3000\nN20 G100 X100 F{feed}\nP1=V.A.MERF.X P2=V.A.MESS.X P3=V.A.MEAS.ACS.VALUE.X\n"
        "P4=V.A.MOFFS.X P5=V.A.ABS.X P6=V.A.MERF.Y\nN30 Y5\nN40 M30\n"
    )
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    assert (p[1], p[6]) == (1.0, 0.0)
    assert p[2] == p[3] == pytest.approx(EDGE, abs=1e-3)
    assert p[4] == pytest.approx(EDGE - 100.0, abs=1e-3)
    x = driven.machine.axes[0]
    v = feed / 60.0
    braking = v * v / (2.0 * x.acceleration) + v * x.acceleration / (2.0 * x.jerk)
    assert EDGE < p[5] < EDGE + braking + 6 * v * 0.001
    assert float(driven.image.target_position[0]) == pytest.approx(p[5], abs=1e-6)
    assert float(driven.image.target_position[1]) == pytest.approx(5.0)
    driven.assert_brakes_within_limits([0, 1])
    driven.assert_no_jump()
    assert driven.image.probe_function[0] == 0
    assert not driven.hli.axes[0].status.measurement_active_r
    assert driven.hli.axes[0].status.measure_value_ok_r


def test_without_a_signal_the_run_goes_to_its_target(make: Make) -> None:
    driven = make(probe=None)
    driven.start("%NONE\nN10 G90 G100 X20 F3000\nP1=V.A.MERF.X P2=V.A.MESS.X\nN30 X25\nN40 M30\n")
    driven.until_done()
    assert driven.alarms == []
    assert (variables(driven)[1], variables(driven)[2]) == (0.0, 0.0)
    assert float(driven.image.target_position[0]) == pytest.approx(25.0)


@pytest.mark.spec("isg.var.a-measuring")
def test_the_programmed_value_has_no_offsets_but_the_ball(make: Make) -> None:
    """The example of the manual (21754): a zero offset of 50; measured in programmed coordinates, it is left out."""
    driven = make(probe=EDGE)
    driven.start(
        "%PCS\nN10 G90 G92 X20\nV.G.WZ[1].R=2.5\nN15 D1\nN20 G100 X60 F600\nP1=V.A.MESS.X P2=V.A.MEAS.PCS.VALUE.X\n"
        "N30 G92 X0\nP3=V.A.MESS.X P4=V.A.MEAS.PCS.VALUE.X P5=V.A.MOFFS.X\nN40 M30\n"
    )
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    assert p[1] == p[3] == pytest.approx(EDGE, abs=1e-3)
    assert (
        p[2] == p[4] == pytest.approx(EDGE - 20.0 + 2.5, abs=1e-3)
    )  # the ball of the probe lies in the direction of the run
    assert p[5] == pytest.approx(EDGE - 80.0, abs=1e-3)


@pytest.mark.spec("isg.g.measure-type3-g106")
def test_g106_measures_and_goes_on(make: Make) -> None:
    driven = make()
    driven.start("%ON\nN10 G90\n#MEAS MODE[3]\nN20 G100 G106 X50 F3000\nP1=V.A.MESS.X P2=V.A.ABS.X\nN30 M30\n")
    driven.until_done()
    assert driven.alarms == []
    assert variables(driven)[1] == pytest.approx(EDGE, abs=1e-3)
    assert variables(driven)[2] == pytest.approx(50.0, abs=1e-9)


def test_two_axes_take_the_same_edge_only_where_both_probes_signal(make: Make) -> None:
    """Y has a probe too, which nobody touches: X stops the run, and Y has no value."""
    driven = make()
    driven.start("%TWO\nN10 G90 G100 X100 Y50 F3000\nP1=V.A.MERF.X P2=V.A.MERF.Y P3=V.A.ABS.X P4=V.A.ABS.Y\nN20 M30\n")
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    assert (p[1], p[2]) == (1.0, 0.0)
    assert p[4] == pytest.approx(p[3] / 2.0, abs=1e-6)  # it has stopped on the line
    assert EDGE < p[3] < 50.0


@pytest.mark.spec("isg.g.measure-type1", "isg.g.measure-type2")
@pytest.mark.parametrize(
    ("blocks", "parameters"),
    [
        ("N20 G100 X20", {"meas_error_no_signal": True}),
        ("#MEAS [ERR_NO_SIGNAL=1]\nN20 G100 X20", {}),
        ("#MEAS MODE[2]\nN20 G100 X20", {}),
    ],
)
def test_a_missing_signal_is_an_error_where_it_is_asked_for(
    make: Make, blocks: str, parameters: dict[str, object]
) -> None:
    driven = make(probe=None, parameters=parameters, feed=50.0)
    driven.start(f"%MISS\nN10 G90 G01 X1 F3000\n{blocks}\nN30 X25\nN40 M30\n")
    driven.until_done()
    alarm = driven.alarm(errors.NO_SIGNAL)
    assert "X" in alarm.text
    assert float(driven.image.target_position[0]) == pytest.approx(20.0)
    assert driven.state() is State.ERROR


def test_err_no_signal_0_lets_the_program_go_on(make: Make) -> None:
    driven = make(probe=None, parameters={"meas_error_no_signal": True})
    driven.start("%GOES\nN10 G90\n#MEAS [ERR_NO_SIGNAL=0]\nN20 G100 X20 F3000\nN30 X25\nN40 M30\n")
    driven.until_done()
    assert driven.alarms == []
    assert float(driven.image.target_position[0]) == pytest.approx(25.0)


@pytest.mark.spec("isg.g.measure-type2")
def test_type_2_takes_the_feed_of_the_axis(make: Make) -> None:
    driven = make(feed=5.0)
    driven.start("%TWO\nN10 G90 G01 X30 F3000\n#MEAS MODE[2]\nN20 G100 X40\nN40 M30\n")
    driven.until(lambda: driven.channel.measuring.active)
    driven.until(lambda: driven.channel.interpolator.path_velocity > 0.0)
    driven.forget()
    driven.until(lambda: bool(driven.channel.measuring.done[0]))
    speeds = [(b[0] - a[0]) / 0.001 for a, b in zip(driven.targets, driven.targets[1:], strict=False)]
    assert max(speeds) == pytest.approx(5.0, rel=1e-6)
    driven.until_done()
    assert driven.alarms == []


def test_feed_hold_and_single_block_in_a_run(make: Make) -> None:
    driven = make()
    driven.start("%HELD\nN10 G90 G01 X10 F3000\nN20 G100 X100 F600\nP1=V.A.MESS.X\nN30 Y5\nN40 M30\n")
    driven.until_x(20.0)
    driven.operator.feedhold_w = True
    driven.until(lambda: driven.channel.held)
    driven.watch(100)
    assert driven.channel.measuring.active
    driven.operator.feedhold_w = False
    driven.operator.single_block_w = True
    driven.until(lambda: driven.channel.interpolator.standstill and not driven.channel.measuring.active)
    driven.watch(200)
    assert float(driven.image.target_position[1]) == 0.0
    driven.operator.single_block_w = False
    driven.operator.continue_motion_rw = True
    driven.until_done()
    assert driven.alarms == []
    assert variables(driven)[1] == pytest.approx(EDGE, abs=1e-3)
    assert float(driven.image.target_position[1]) == pytest.approx(5.0)
    driven.assert_brakes_within_limits([0, 1])


def test_a_reset_in_a_run_switches_the_probe_off(make: Make) -> None:
    driven = make()
    driven.start("%RESET\nN20 G90 G100 X100 F600\nN40 M30\n")
    driven.until_x(20.0)
    assert driven.image.probe_function[0] != 0
    driven.reset()
    driven.until_done()
    assert driven.image.probe_function[0] == 0
    assert not driven.channel.measuring.active
    assert float(driven.image.target_position[0]) < EDGE
    driven.assert_brakes_within_limits([0])
    driven.start("%AGAIN\nN20 G90 G100 X100 F600\nP1=V.A.MESS.X\nN40 M30\n")
    driven.until_done()
    assert variables(driven)[1] == pytest.approx(EDGE, abs=1e-3)


def test_backward_motion_waits_for_the_end_of_a_run(make: Make) -> None:
    driven = make()
    driven.start("%BACK\nN10 G90 G01 X10 F3000\nN20 G100 X100 F600\nN30 Y5\nN40 M30\n")
    driven.until_x(20.0)
    driven.operator.backward_motion_w = True
    driven.until(lambda: not driven.channel.measuring.active)
    driven.watch(300)
    assert float(driven.image.target_position[0]) > EDGE  # what was measured is not driven back
    driven.operator.backward_motion_w = False
    driven.until_done()
    assert driven.alarms == []


def test_a_block_search_over_a_run_is_refused(make: Make) -> None:
    driven = make()
    path = driven.program("%SEARCH\nN10 G90 G01 X10 F3000\nN20 G100 X100 F600\nN30 Y5\nN40 M30\n")
    driven.simulation.start(path, search=SearchOrder(type=4, value=30))
    driven.until(lambda: bool(driven.alarms))
    assert driven.alarms[0].id == block_search.SEARCH_STOPS_HERE.id


# ---------------------------------------------------------------------------------------------------- signals of the PLC


class ProbingPlc(ScriptedPlc):
    """Tells the probe of X by the control unit of the axis: deflected from `edge` on, seen where the axis really is."""

    def __init__(self, memory: HliMemory, edge: float, *, stamped: bool = False, claims: bool = True) -> None:
        super().__init__(memory, {})
        self.edge, self.stamped, self.claims = edge, stamped, claims
        self.before = (0.0, 0.0)  # time and place of the cycle before
        self.seen: list[bool] = []

    def wake(self, time: float) -> None:
        super().wake(time)
        axis = self.hli.axes[X]
        place = axis.status.actual_position_r * 1e-4
        control = axis.control
        control.probing_signal.enable_w = control.probing_time.enable_w = self.claims
        deflected = place >= self.edge
        if deflected and not control.probing_signal.command_w and self.stamped:
            (t0, p0), now = (
                self.before,
                self.hli.head.time_ns_r * 1e-9 - 0.001,
            )  # the status is that of the cycle before
            control.probing_time.command_w = round((t0 + (now - t0) * (self.edge - p0) / (place - p0)) * 1e9)
        control.probing_signal.command_w = deflected
        self.before = (self.hli.head.time_ns_r * 1e-9 - 0.001, place)
        self.seen.append(bool(control.probing_signal.state_r))


def with_plc(demo: Machine, folder: Path, signal: str, edge: float = EDGE, *, stamped: bool = False, claims: bool = True,
             parameters: Mapping[str, object] | None = None) -> Driven:  # fmt: skip
    machine = measuring_machine(demo, None, signal=signal, parameters=parameters)
    return Driven(
        machine,
        folder,
        partner=lambda memory: ProbingPlc(memory, edge, stamped=stamped, claims=claims),
        ideal_axes=True,
    )


@pytest.mark.spec("hli.ax.cu.probing", "isg.g.measure-type1")
@pytest.mark.parametrize(("signal", "error"), [("plc", 3.0), ("plc_first_event", 3.0), ("plc_timestamp", 0.02)])
def test_the_plc_tells_the_edge(demo: Machine, tmp_path: Path, signal: str, error: float) -> None:
    """At 50 mm/s a cycle is 0.05 mm: seen some cycles late by a level, interpolated by its time."""
    driven = with_plc(demo, tmp_path, signal, stamped=signal == "plc_timestamp")
    driven.start("%PLC\nN10 G90 G100 X100 F3000\nP1=V.A.MESS.X P2=V.A.ABS.X P3=V.A.MERF.X\nN30 M30\n")
    status = driven.hli.axes[X].status
    driven.until(lambda: bool(status.measurement_active_r))
    assert not status.measure_value_ok_r
    driven.until(lambda: bool(status.probe_actuated_r))
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    assert p[3] == 1.0
    assert 0.0 <= p[1] - EDGE < error or abs(p[1] - EDGE) < 0.02
    assert p[2] > p[1]
    assert not status.measurement_active_r
    assert status.measure_value_ok_r
    assert isinstance(driven.simulation.plc, ProbingPlc)
    assert any(driven.simulation.plc.seen)


@pytest.mark.spec("hli.ax.cu.probing")
def test_a_signal_that_nobody_tells_keeps_the_axis_where_it_is(demo: Machine, tmp_path: Path) -> None:
    driven = with_plc(demo, tmp_path, "plc", claims=False)
    driven.start("%NOBODY\nN10 G90 G100 X100 F3000\nN30 M30\n")
    driven.until(lambda: bool(driven.alarms), 3.0)
    assert driven.alarm(errors.NOT_READY).line == 2
    driven.until_done()
    assert float(driven.image.target_position[X]) == 0.0
    assert driven.state() is State.ERROR


def test_a_deflected_probe_is_an_error_and_nothing_moves(demo: Machine, tmp_path: Path) -> None:
    driven = with_plc(demo, tmp_path, "plc", edge=-1.0)
    driven.start("%DEFLECTED\nN10 G90 G100 X100 F3000\nN30 M30\n")
    driven.until_done()
    assert driven.alarm(errors.DEFLECTED).id == 50052
    assert float(driven.image.target_position[X]) == 0.0


def test_a_deflected_probe_may_end_the_run_at_once(demo: Machine, tmp_path: Path) -> None:
    allowed: dict[str, object] = {"meas_allow_actuated_probe": True, "meas_error_no_signal": True}
    driven = with_plc(demo, tmp_path, "plc", edge=-1.0, parameters=allowed)
    driven.start("%ALLOWED\nN10 G90 G100 X100 F3000\nP1=V.A.MERF.X P2=V.A.ABS.X\nN30 G01 Y5\nN40 M30\n")
    driven.until_done()
    assert driven.alarms == []
    assert variables(driven) == {1: 0.0, 2: 0.0}
    assert np.abs(np.array(driven.targets)[:, X]).max() == 0.0
    assert float(driven.image.target_position[1]) == pytest.approx(5.0)


@pytest.mark.spec("chan.meas.travel-limit")
def test_a_run_that_comes_to_a_software_limit_without_a_signal_is_an_error(make: Make) -> None:
    driven = make(probe=None, parameters={"meas_soft_limit_move_path": True})
    high = driven.machine.axes[X].position_max
    assert high is not None
    driven.start(f"%LIMIT\nN10 G90 G01 X{high - 10} F20000\nN20 G100 X{high + 50} F6000\nN30 M30\n")
    driven.until_done()
    assert driven.alarm(errors.LIMIT_WITHOUT_SIGNAL).id == 50706
    assert float(driven.image.target_position[X]) == pytest.approx(high)


@pytest.mark.spec("chan.meas.travel-limit")
def test_a_target_beyond_a_software_limit_is_refused_before_anything_moves(make: Make) -> None:
    driven = make(probe=None)
    driven.start("%BEYOND\nN20 G90 G100 X5000 F6000\nN30 M30\n")
    driven.until_done()
    assert [line.id for line in driven.alarms] == [motion.SOFTWARE_LIMIT.id]
    assert float(driven.image.target_position[X]) == 0.0


@pytest.mark.spec("chan.meas.dynamics")
@pytest.mark.parametrize(
    ("parameters", "ramp"),
    [
        ({"use_drive_curr_limit": True}, True),
        ({"use_drive_curr_limit": False}, False),
        ({"use_drive_curr_limit": True, "meas_deceleration_mode": 1}, False),
        ({"meas_use_std_dynamic": True}, True),
    ],
)
def test_what_a_signal_brakes_with(make: Make, parameters: dict[str, object], ramp: bool) -> None:
    """The ramp of feed hold, 400 mm/s², or what the axis can, 4000: the greatest deceleration behind the edge tells which."""
    driven = make(parameters=parameters, hold=400.0)
    driven.start("%BRAKE\nN20 G90 G100 X200 F12000\nP1=V.A.ABS.X\nN30 M30\n")
    driven.until(lambda: bool(driven.channel.measuring.done[X]))
    driven.forget()
    driven.until(lambda: not driven.channel.measuring.active)
    driven.until_done()
    assert driven.alarms == []
    speed = np.diff(np.array(driven.targets)[:, X]) / driven.simulation.period
    hardest = float(-np.diff(speed).min()) / driven.simulation.period
    if ramp:
        assert hardest == pytest.approx(400.0, rel=0.02)
    else:  # the jerk does not let it come to the greatest deceleration
        assert 2000.0 < hardest <= driven.machine.axes[X].acceleration


def test_a_run_is_done_again_by_a_replay(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(measuring_machine(demo), tmp_path)
    recorded.start("%REPLAY\nN10 G90 G100 X100 F3000\nP1=V.A.MESS.X\nN20 G01 X[P1-10] F3000\nN30 M30\n")
    recorded.run(4.0)
    assert not recorded.simulation.controller.channel.active
    assert float(recorded.simulation.drives.image.target_position[X]) == pytest.approx(EDGE - 10.0, abs=1e-3)
    recorded.replayed()


def test_a_replay_begins_in_the_middle_of_a_run(demo: Machine, tmp_path: Path) -> None:
    recorded = Recorded(measuring_machine(demo), tmp_path)
    recorded.start("%MIDDLE\nN10 G90 G100 X100 F3000\nP1=V.A.MESS.X\nN20 G01 X[P1-10] F3000\nN30 M30\n")
    with_keyframes(recorded, 1.6, 83)
    assert_same_from_each(recorded, tmp_path, 5)


def test_a_run_in_a_rotated_coordinate_system(demo: Machine, tmp_path: Path) -> None:
    """The system is turned by 30 degrees; along its X the face X = 30 of the box is met at 30 / cos 30."""
    driven = Driven(touched_machine(demo, third=True), tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start(
        "%TURNED\nN10 G90\n#CS ON [0,0,0,0,0,30]\nN20 G100 X60 F2000\nP1=V.A.MEAS.PCS.VALUE.X P2=V.A.MEAS.PCS.VALUE.Y\n"
        "P3=V.A.MESS.X P4=V.A.MEAS.ACS.VALUE.X P5=V.A.MEAS.ACS.VALUE.Y\nN30 G00 X5\nN40 M30\n"
    )
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    along = 30.0 / np.cos(np.radians(30.0))
    assert (p[1], p[2], p[3]) == pytest.approx((along, 0.0, along), abs=0.02)
    assert (p[4], p[5]) == pytest.approx((30.0, along / 2.0), abs=0.02)
    assert float(driven.image.target_position[X]) == pytest.approx(5.0 * np.cos(np.radians(30.0)), abs=1e-6)


@pytest.mark.spec("isg.g.measure-interrupt-g310")
@pytest.mark.parametrize("rapid", [True, False])
def test_g310_leads_to_its_label_where_the_signal_came(make: Make, rapid: bool) -> None:
    driven = make(parameters={"messtyp": 5})
    word = "G00" if rapid else "G01 F3000"
    driven.start(
        f"%JUMP\nN10 G90 G310 {word} X100 $GOTO[HIT]\nN20 G00 Y50\n$GOTO[OVER]\nN30 [HIT] P1=V.A.MESS.X\nG00 Y5\n"
        "N40 [OVER] M30\n"
    )
    driven.until_done()
    assert driven.alarms == []
    assert variables(driven) == {1: pytest.approx(EDGE, abs=1e-3)}
    assert float(driven.image.target_position[1]) == pytest.approx(5.0)
    assert (
        EDGE < float(driven.image.target_position[X]) < EDGE + 36.0
    )  # from 24 m/min with 4 m/s² and 60 m/s³, and some cycles
    driven.assert_brakes_within_limits([X])


def test_a_job_of_the_plc_and_a_run_do_not_share_a_probe(make: Make) -> None:
    driven = make()
    driven.image.probe_function[X] = 0x11  # as a job that waits
    driven.start("%BUSY\nN20 G90 G100 X200 F12000\nN30 M30\n")
    driven.until_done()
    assert driven.alarm(errors.PROBE_BUSY).line == 2
    assert driven.image.probe_function[X] == 0x11


# ---------------------------------------------------------------------------------------------------- a simulated workpiece


def touched_machine(demo: Machine, *, third: bool = False, **setup: Any) -> Machine:
    """The probe meets a box in X and Y, and with `third` in Z, wherever that is; its level is an input as well."""
    machine = measuring_machine(demo, None, count=3 if third else 2, **setup)
    drive = machine.axes[X].drive
    assert drive is not None
    axes = (
        machine.axes[X].model_copy(update={"drive": drive.model_copy(update={"inputs": {16: "touched"}})}),
        *machine.axes[1:],
    )
    box = {"X": (30.0, 80.0), "Y": (10.0, 60.0)} | ({"Z": (-500.0, 500.0)} if third else {})
    fieldbus = machine.fieldbus.model_copy(update={"workpiece": box})
    return machine.model_copy(update={"axes": axes, "fieldbus": fieldbus})


def test_both_drives_latch_where_the_box_was_met(demo: Machine, tmp_path: Path) -> None:
    """From the origin along (4, 3) the face X = 30 is met at Y = 22.5; from X55 Y0 along Y the face Y = 10."""
    driven = Driven(touched_machine(demo), tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start(
        "%BOX\nN10 G90 G100 X80 Y60 F2000\nP1=V.A.MESS.X P2=V.A.MESS.Y\nN20 G00 X20\nN30 X55 Y0\nN40 G100 Y50 F2000\n"
        "P3=V.A.MESS.Y\nN50 G00 Y0\nN60 M30\n"
    )
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    assert (p[1], p[2]) == pytest.approx((30.0, 22.5), abs=0.02)
    assert p[3] == pytest.approx(10.0, abs=0.02)


@pytest.mark.parametrize("feed", [600, 3000])
def test_an_input_is_an_edge_between_two_cycles(demo: Machine, tmp_path: Path, feed: int) -> None:
    """The level of the probe as an input of the image: it comes some cycles late, at each feed by as many."""
    machine = touched_machine(demo, signal="input", input="touched")
    driven = Driven(machine, tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start(f"%INPUT\nN10 G90 G00 Y30\nN20 G100 X60 F{feed}\nP1=V.A.MESS.X P2=V.A.MERF.X\nN60 M30\n")
    driven.until_done()
    assert driven.alarms == []
    p = variables(driven)
    cycle = feed / 60.0 * 0.001
    assert p[2] == 1.0
    assert 0.0 < p[1] - 30.0 < 4.0 * cycle


@pytest.mark.parametrize("input_name", ["touched", None])
def test_the_level_of_a_touch_probe_is_known_if_an_input_tells_it(
    demo: Machine, tmp_path: Path, input_name: str | None
) -> None:
    driven = Driven(touched_machine(demo, input=input_name), tmp_path, partner=lambda memory: ScriptedPlc(memory, {}))
    driven.start("%INSIDE\nN10 G90 G01 X40 F6000\nN20 Y20\nN30 G100 Y30 F600\nN60 M30\n")
    driven.until_done()
    if input_name is None:
        assert driven.alarms == []
        return
    assert driven.alarm(errors.DEFLECTED).line == 4
    assert float(driven.image.target_position[1]) == pytest.approx(20.0)
