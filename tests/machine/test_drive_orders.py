"""Axes that their drives move by velocity or torque, ordered by a PLC program, on the real protocol."""

from __future__ import annotations

from collections.abc import Callable
from itertools import pairwise
from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.diagnostics.catalogue import machine as alarms
from runtime.drives import DriveMode, DriveState
from runtime.hli.layout import Direction, MotionState
from runtime.plc_logic.motion import (
    MC_Halt,
    MC_MoveAbsolute,
    MC_MoveVelocityByDrive,
    MC_Stop,
    MC_TorqueControl,
)
from tests.machine.beside_channel import TABLE, Rig

TORQUE = "process_data: [torque, torque_limit]"
VELOCITY = TABLE.replace("drive: {", "drive: {modes: [profile_velocity], ")
CONVEYOR = VELOCITY.replace("    position_min: -720\n    position_max: 720\n", "")
PRESS = TABLE.replace("drive: {", f"drive: {{modes: [cyclic_synchronous_velocity], {TORQUE}, ")


def servo(rig: Rig):  # type: ignore[no-untyped-def]
    assert rig.simulation.nodes is not None
    return rig.simulation.nodes.drives[9]


def speed(rig: Rig) -> float:
    return float(servo(rig).servo.velocity) / 1000.0


def state(rig: Rig) -> MotionState:
    return rig.program.axes["B"].motion_state


@pytest.mark.parametrize("ideal", [False, True])
def test_a_conveyor_runs_by_its_drive_and_comes_back(tmp_path: Path, ideal: bool) -> None:
    rig = Rig(tmp_path, ideal=ideal, table=CONVEYOR)
    run, halt, move = MC_MoveVelocityByDrive(), MC_Halt(), MC_MoveAbsolute()
    rig.call("run", lambda p: run(p.axes["B"], True, Velocity=90.0, Direction=Direction.NEGATIVE))
    rig.until(lambda: run.InVelocity, 3.0)
    assert state(rig) is MotionState.CONTINUOUS_MOTION
    assert rig.image.by_drive[rig.table]
    assert rig.image.actual_velocity[rig.table] == pytest.approx(-90.0, rel=0.05)
    if not ideal:
        assert servo(rig).mode == DriveMode.PROFILE_VELOCITY
        assert speed(rig) == pytest.approx(-90.0, rel=0.02)
    rig.run(10.0)  # beyond every software limit of a table
    assert rig.place("B") < -800.0
    rig.call("halt", lambda p: halt(p.axes["B"], True))
    rig.until(lambda: halt.Done, 3.0)
    assert run.CommandAborted
    assert state(rig) is MotionState.STANDSTILL
    assert not rig.image.by_drive[rig.table]
    if not ideal:
        assert servo(rig).mode == DriveMode.CYCLIC_SYNCHRONOUS_POSITION
    stands = rig.place("B")
    rig.path.clear()
    rig.call("move", lambda p: move(p.axes["B"], True, Position=stands + 10.0, Velocity=60.0))
    rig.until(lambda: move.Done, 3.0)
    rig.assert_smooth()
    assert rig.simulation.errors == []


def test_override_and_feed_hold_act_on_it(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=CONVEYOR)
    run = MC_MoveVelocityByDrive()
    rig.call("run", lambda p: run(p.axes["B"], True, Velocity=90.0))
    rig.until(lambda: run.InVelocity, 3.0)
    rig.call("set", lambda p: setattr(p.axes["B"], "override", 50.0))
    rig.until(lambda: abs(speed(rig) - 45.0) < 1.0, 2.0)
    rig.call("set", lambda p: setattr(p.axes["B"], "feed_hold", True))
    rig.until(lambda: abs(speed(rig)) < 0.1, 2.0)
    assert run.Busy
    assert not run.InVelocity
    rig.call("set", lambda p: setattr(p.axes["B"], "feed_hold", False))
    rig.until(lambda: abs(speed(rig) - 45.0) < 1.0, 2.0)


@pytest.mark.parametrize("ideal", [False, True])
def test_it_never_leaves_the_software_limits(tmp_path: Path, ideal: bool) -> None:
    rig = Rig(tmp_path, ideal=ideal, table=VELOCITY)
    run = MC_MoveVelocityByDrive()
    rig.call("run", lambda p: run(p.axes["B"], True, Velocity=180.0))
    rig.until(lambda: run.Error, 10.0)
    assert run.ErrorID == errors.JOB_AT_LIMIT.id
    rig.run(0.5)
    assert 715.0 < rig.place("B") <= 720.0
    assert not rig.image.by_drive[rig.table]
    assert state(rig) is MotionState.STANDSTILL
    again, back = MC_MoveVelocityByDrive(), MC_MoveVelocityByDrive()
    rig.call("run", lambda p: again(p.axes["B"], True, Velocity=180.0))
    rig.until(lambda: again.Error, 2.0)  # there is no way left in this direction
    rig.run(0.5)
    rig.call("run", lambda p: back(p.axes["B"], True, Velocity=90.0, Direction=Direction.NEGATIVE))
    rig.until(lambda: back.InVelocity, 2.0)


def test_a_torque_presses_against_a_stop_and_keeps_its_velocity_without_one(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=PRESS)
    press, stop = MC_TorqueControl(), MC_Stop()
    rig.call("press", lambda p: press(p.axes["B"], True, Torque=0.3, TorqueRamp=1.0, Velocity=20.0))
    rig.until(lambda: abs(speed(rig) - 20.0) < 0.5, 2.0)
    fastest = 0.0
    for _ in range(500):
        rig.cycle()
        fastest = max(fastest, abs(speed(rig)))
    assert fastest < 21.0
    assert not press.InTorque
    servo(rig).blocked = True  # the stop
    rig.until(lambda: press.InTorque, 2.0)
    assert servo(rig).servo.torque == pytest.approx(0.3, abs=0.02)
    assert rig.program.axes["B"].torque == pytest.approx(30.0, abs=2.0)
    more = MC_TorqueControl()
    rig.call("press", lambda p: more(p.axes["B"], True, Torque=0.6, TorqueRamp=0.5, Velocity=20.0))
    begin = rig.simulation.time
    rig.until(lambda: more.InTorque, 3.0)
    assert rig.simulation.time - begin > 0.5  # its ramp
    assert servo(rig).servo.torque == pytest.approx(0.6, abs=0.03)
    servo(rig).blocked = False  # what it presses against gives way
    fastest = 0.0
    for _ in range(300):
        rig.cycle()
        fastest = max(fastest, abs(speed(rig)))
    assert fastest < 25.0
    rig.call("press", lambda p: stop(p.axes["B"], True))
    rig.until(lambda: stop.Done, 2.0)
    assert state(rig) is MotionState.STOPPING
    rig.call("press", lambda p: stop(p.axes["B"], False))
    rig.run(0.1)
    assert state(rig) is MotionState.STANDSTILL
    assert rig.simulation.errors == []


def test_what_is_refused(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=VELOCITY)
    run, torque, move = MC_MoveVelocityByDrive(), MC_TorqueControl(), MC_MoveAbsolute()
    rig.call("torque", lambda p: torque(p.axes["B"], True, Torque=0.3, Velocity=20.0))
    rig.until(lambda: torque.Error, 1.0)
    assert torque.ErrorID == errors.JOB_NO_DRIVE_MODE.id
    wrong = MC_MoveVelocityByDrive()
    rig.call("torque", lambda p: wrong(p.axes["B"], True, Velocity=20.0, Direction=Direction.CURRENT))
    rig.until(lambda: wrong.Error, 1.0)
    assert wrong.ErrorID == errors.JOB_VALUE.id
    rig.call("torque", lambda p: move(p.axes["B"], True, Position=50.0, Velocity=20.0))
    rig.run(0.2)
    rig.call("run", lambda p: run(p.axes["B"], True, Velocity=20.0))
    rig.until(lambda: run.Error, 1.0)
    assert run.ErrorID == errors.JOB_DRIVE_MOVES.id
    rig.until(lambda: move.Done, 5.0)
    again, other = MC_MoveVelocityByDrive(), MC_MoveAbsolute()
    rig.call("run", lambda p: again(p.axes["B"], True, Velocity=20.0))
    rig.until(lambda: again.InVelocity, 2.0)
    rig.call("torque", lambda p: other(p.axes["B"], True, Position=0.0, Velocity=20.0))
    rig.until(lambda: other.Error, 1.0)
    assert other.ErrorID == errors.JOB_BY_DRIVE.id
    assert again.Busy
    plain = MC_MoveVelocityByDrive()
    rig.call("run", lambda p: plain(p.axes["X"], True, Velocity=20.0))
    rig.until(lambda: plain.Error, 1.0)
    assert plain.ErrorID == errors.JOB_NO_DRIVE_MODE.id


def test_a_reset_and_a_fault_of_the_drive_end_it(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=CONVEYOR)
    run, again = MC_MoveVelocityByDrive(), MC_MoveVelocityByDrive()
    rig.call("run", lambda p: run(p.axes["B"], True, Velocity=90.0))
    rig.until(lambda: run.InVelocity, 3.0)
    rig.simulation.controller.reset()
    rig.until(lambda: run.Error, 1.0)
    rig.until(lambda: not rig.image.by_drive[rig.table], 2.0)
    assert abs(speed(rig)) < 0.1
    rig.run(0.5)
    rig.call("run", lambda p: again(p.axes["B"], True, Velocity=90.0))
    rig.until(lambda: again.InVelocity or again.Error, 3.0)
    assert again.InVelocity
    servo(rig).fail(0x2310)
    rig.until(lambda: again.Error, 1.0)
    rig.run(1.0)
    assert rig.image.mode[rig.table] == DriveMode.CONFIGURED
    assert rig.image.target_velocity[rig.table] == 0.0
    assert rig.image.state[rig.table] == DriveState.FAULT


@pytest.mark.spec("hli.ax.cu.torque-limit")
def test_the_plc_limits_the_torque(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=PRESS)
    unit = rig.hli.axes[rig.table].control.torque_limit
    assert unit.state_r == 0xFFFF_FFFF

    def limit(percent: float, counts: bool) -> None:
        def call(p: object) -> None:
            axis = rig.program.axes["B"]
            axis.torque_limit, axis.torque_limited = percent, counts

        rig.call("limit", call)
        rig.run(0.02)

    drive = servo(rig)
    limit(25.0, True)
    assert unit.state_r == 250
    assert drive.values[0x6072, 0] == 250
    press = MC_TorqueControl()
    rig.call("press", lambda p: press(p.axes["B"], True, Torque=0.8, Velocity=20.0))
    rig.run(0.3)
    assert drive.values[0x6072, 0] == 250  # the smaller one of both
    limit(90.0, True)
    assert drive.values[0x6072, 0] == 800
    limit(90.0, False)
    assert unit.state_r == 0xFFFF_FFFF
    rig.call("press", lambda p: MC_Halt()(p.axes["B"], True))
    rig.run(2.0)
    assert drive.values[0x6072, 0] > 1000
    assert rig.simulation.errors == []


def test_a_limit_that_the_drive_does_not_get_stops_the_machine(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=TABLE)

    def call(p: object) -> None:
        axis = rig.program.axes["B"]
        axis.torque_limit, axis.torque_limited = 50.0, True

    rig.call("limit", call)
    rig.run(0.05)
    assert [problem.entry for problem in rig.simulation.errors] == [alarms.TORQUE_LIMIT_UNKNOWN]


@pytest.mark.spec("hli.ax.status.drive")
@pytest.mark.parametrize("ideal", [False, True])
def test_the_status_of_the_drive(tmp_path: Path, ideal: bool) -> None:
    rig = Rig(tmp_path, ideal=ideal, table=TABLE + VIRTUAL)
    table = rig.hli.axes[rig.table].status
    assert table.drive_type_r == (4 if ideal else 8)
    assert rig.hli.axes[rig.machine.axis_index("C")].status.drive_type_r == 16
    assert table.ready_for_power_on_r
    assert table.ready_for_control_loop_on_r
    rig.call("off", lambda p: setattr(p.axes["B"], "drive_on", False))
    rig.run(0.5)
    assert table.ready_for_power_on_r  # it can be enabled again
    assert not table.ready_for_control_loop_on_r
    if ideal:
        return
    servo(rig).fail(0x2310)
    rig.run(0.2)
    assert not table.ready_for_power_on_r
    assert table.drive_state_r == DriveState.FAULT


VIRTUAL = """  - name: C
    type: rotary
    log_axis: 10
    velocity: 180
    acceleration: 720
    jerk: 20000
"""


# -- torque modes ----------------------------------------------------------------------------------------------------

RATED = 1440.0  # degrees/s² at rated torque: twice the acceleration of the axis


def torque_table(mode: str, *further: str) -> str:
    modes = ", ".join((mode, *further))
    return TABLE.replace("drive: {", f"drive: {{modes: [{modes}], process_data: [torque], ")


def fastest_of(rig: Rig, seconds: float) -> float:
    fastest = 0.0
    for _ in range(round(seconds / 0.001)):
        rig.cycle()
        fastest = max(fastest, abs(speed(rig)))
    return fastest


@pytest.mark.parametrize(
    ("mode", "shown"),
    [
        ("cyclic_synchronous_torque", DriveMode.CYCLIC_SYNCHRONOUS_TORQUE),
        ("profile_torque", DriveMode.PROFILE_TORQUE),
    ],
)
def test_a_drive_with_a_torque_mode_gets_the_torque_itself(tmp_path: Path, mode: str, shown: DriveMode) -> None:
    rig = Rig(tmp_path, ideal=False, table=torque_table(mode))
    press, more, stop = MC_TorqueControl(), MC_TorqueControl(), MC_Stop()
    rig.call("press", lambda p: press(p.axes["B"], True, Torque=0.3, TorqueRamp=1.0, Velocity=20.0))
    rig.until(lambda: speed(rig) > 15.0, 2.0)
    assert rig.program.axes["B"].drive_mode == shown
    # nothing resists but friction, which the torque overcomes: the velocity limits it
    assert fastest_of(rig, 1.0) < 21.0
    assert speed(rig) == pytest.approx(20.0, abs=1.0)
    assert not press.InTorque
    servo(rig).blocked = True
    begin = rig.simulation.time
    rig.until(lambda: press.InTorque, 2.0)
    assert rig.simulation.time - begin < 0.6
    assert servo(rig).values[0x6071, 0] == 300  # ordered as it is, no limit of something else
    rig.run(0.2)
    begin = rig.simulation.time
    rig.call("press", lambda p: more(p.axes["B"], True, Torque=0.6, TorqueRamp=0.5, Velocity=20.0))
    rig.until(lambda: more.InTorque, 3.0)
    assert 0.5 < rig.simulation.time - begin < 0.8  # 0.3 more at 0.5 per second, as soon as it is within the window
    before = [servo(rig).values[0x6071, 0]]
    servo(rig).blocked = False  # what it presses against gives way: 864 degrees/s², seen after some cycles
    fastest = fastest_of(rig, 0.3)
    assert fastest < 20.0 + 0.6 * RATED * 0.012
    assert speed(rig) == pytest.approx(20.0, abs=2.0)
    assert before == [600]
    rig.call("press", lambda p: stop(p.axes["B"], True))
    rig.until(lambda: stop.Done, 2.0)
    assert servo(rig).mode == DriveMode.CYCLIC_SYNCHRONOUS_POSITION
    stands = servo(rig).servo.position
    rig.run(0.3)
    assert servo(rig).servo.position == pytest.approx(stands, abs=20.0)  # 0.02 degrees
    assert rig.simulation.errors == []


def test_the_way_back_into_the_position_mode_is_no_jump(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=torque_table("cyclic_synchronous_torque"))
    press, halt, move = MC_TorqueControl(), MC_Halt(), MC_MoveAbsolute()
    rig.call("press", lambda p: press(p.axes["B"], True, Torque=-0.5, Velocity=60.0))
    rig.until(lambda: speed(rig) < -55.0, 2.0)
    rig.call("press", lambda p: halt(p.axes["B"], True, Deceleration=300.0))
    velocities = [speed(rig)]
    while not halt.Done:
        rig.cycle()
        velocities.append(speed(rig))
        assert len(velocities) < 2000
    slowest = max(b - a for a, b in pairwise(velocities)) / 0.001
    assert slowest < 1.0 * RATED  # it brakes with rated torque at most
    assert max(velocities) < 1.0  # and does not turn back
    assert 0.2 < len(velocities) * 0.001 < 0.6  # the ramp: 60 degrees/s at 300 degrees/s²
    stands = rig.place("B")
    assert servo(rig).servo.position / 1000.0 == pytest.approx(stands, abs=0.05)
    rig.path.clear()
    rig.call("press", lambda p: move(p.axes["B"], True, Position=stands + 10.0, Velocity=60.0))
    rig.until(lambda: move.Done, 3.0)
    rig.assert_smooth()
    assert rig.simulation.errors == []


def test_a_velocity_order_takes_over_from_a_torque_in_motion_and_the_other_way_round(tmp_path: Path) -> None:
    table = torque_table("cyclic_synchronous_torque", "cyclic_synchronous_velocity")
    rig = Rig(tmp_path, ideal=False, table=table)
    press, run, again, halt = MC_TorqueControl(), MC_MoveVelocityByDrive(), MC_TorqueControl(), MC_Halt()
    rig.call("order", lambda p: press(p.axes["B"], True, Torque=0.5, Velocity=60.0))
    rig.until(lambda: speed(rig) > 55.0, 2.0)
    rig.call("order", lambda p: run(p.axes["B"], True, Velocity=60.0))
    slowest = min(_speeds(rig, lambda: run.InVelocity))
    assert slowest > 50.0
    assert rig.program.axes["B"].drive_mode == DriveMode.CYCLIC_SYNCHRONOUS_VELOCITY
    rig.call("order", lambda p: again(p.axes["B"], True, Torque=0.5, Velocity=60.0))
    speeds = _speeds(rig, lambda: rig.program.axes["B"].drive_mode == DriveMode.CYCLIC_SYNCHRONOUS_TORQUE)
    for _ in range(500):
        rig.cycle()
        speeds.append(speed(rig))
    assert min(speeds) > 50.0
    assert max(speeds) < 63.0
    rig.call("order", lambda p: halt(p.axes["B"], True))
    rig.until(lambda: halt.Done, 2.0)
    assert rig.simulation.errors == []


def _speeds(rig: Rig, until: Callable[[], bool]) -> list[float]:
    found = []
    while not until():
        rig.cycle()
        found.append(speed(rig))
        assert len(found) < 2000
    return found


def test_a_torque_keeps_the_software_limits_the_override_and_a_hold(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=torque_table("cyclic_synchronous_torque"))
    push = MC_TorqueControl()
    rig.call("push", lambda p: push(p.axes["B"], True, Torque=0.5, Velocity=100.0))
    rig.until(lambda: speed(rig) > 95.0, 2.0)
    rig.call("set", lambda p: setattr(p.axes["B"], "override", 50.0))
    rig.until(lambda: abs(speed(rig) - 50.0) < 2.0, 2.0)
    rig.call("set", lambda p: setattr(p.axes["B"], "feed_hold", True))
    rig.until(lambda: abs(speed(rig)) < 0.3, 2.0)
    assert push.Busy
    rig.call("set", lambda p: setattr(p.axes["B"], "feed_hold", False))
    rig.call("override", lambda p: setattr(p.axes["B"], "override", 100.0))
    rig.until(lambda: push.Error, 20.0)
    assert push.ErrorID == errors.JOB_AT_LIMIT.id
    rig.run(1.0)
    assert 715.0 < rig.place("B") <= 720.0
    assert servo(rig).servo.position / 1000.0 <= 720.0
    assert not rig.image.by_drive[rig.table]


def test_a_halt_of_what_presses_does_not_press_harder(tmp_path: Path) -> None:
    """In either way of ordering a torque."""
    for k, table in enumerate((PRESS, torque_table("cyclic_synchronous_torque"))):
        folder = tmp_path / str(k)
        folder.mkdir()
        rig = Rig(folder, ideal=False, table=table)
        press, halt = MC_TorqueControl(), MC_Halt()
        rig.call("press", lambda p, b=press: b(p.axes["B"], True, Torque=0.3, Velocity=100.0))  # type: ignore[misc]
        servo(rig).blocked = True
        rig.until(lambda b=press: b.InTorque, 2.0)  # type: ignore[misc]
        rig.call("press", lambda p, b=halt: b(p.axes["B"], True))  # type: ignore[misc]
        strongest = 0.0
        for _ in range(400):
            rig.cycle()
            strongest = max(strongest, servo(rig).servo.torque)
        assert halt.Done
        assert strongest < 0.35


def test_an_axis_that_something_drives_on_stops_the_machine(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=torque_table("cyclic_synchronous_torque"))
    hold = MC_TorqueControl()
    rig.call("hold", lambda p: hold(p.axes["B"], True, Torque=0.1, Velocity=20.0))
    rig.until(lambda: speed(rig) > 15.0, 2.0)
    real = servo(rig).servo.push
    servo(rig).servo.push = lambda torque, dt: real(torque + 1.3, dt)  # more than its torque holds
    rig.until(lambda: hold.Error, 2.0)
    assert hold.ErrorID == errors.JOB_RUNS_AWAY.id
    assert speed(rig) < 20.0 + 0.2 * 1.3 * RATED
    rig.until(lambda: speed(rig) == 0.0, 2.0)
    assert rig.simulation.errors[0].entry is errors.JOB_RUNS_AWAY
    servo(rig).servo.push = real
    rig.simulation.controller.reset()
    rig.run(1.0)
    assert state(rig) is MotionState.STANDSTILL
    assert not rig.image.by_drive[rig.table]
