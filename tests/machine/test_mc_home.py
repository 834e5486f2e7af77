"""MC_Home: an axis beside the path looks for its reference, at a cam or by its drive."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import axis_jobs as errors
from runtime.hli.layout import MotionState
from runtime.plc_logic.motion import MC_Home, MC_MoveAbsolute, MC_Reset, MC_Stop
from tests.machine.beside_channel import TABLE, Rig

HOMING = "    homing: {fast: 60, slow: 6, position: 10, %s}\n    drive: {"
BY_DRIVE = TABLE.replace("    drive: {", HOMING % "method: 21").replace(
    "{node: 9,", "{node: 9, simulated: {home_switch: [-60, -20]},"
)
AT_CAM = TABLE.replace("    drive: {", HOMING % "direction: negative")


def by_drive(folder: Path) -> Rig:
    return Rig(folder, ideal=False, table=BY_DRIVE)


def servo(rig: Rig) -> float:
    assert rig.simulation.nodes is not None
    return rig.simulation.nodes.drives[9].servo.position / 1000.0


def referenced(rig: Rig) -> bool:
    return bool(rig.hli.axes[rig.table].status.referenced_r)


def state(rig: Rig) -> MotionState:
    return rig.program.axes["B"].motion_state


@pytest.mark.spec("isg.plcopen.mc-home")
def test_a_program_homes_an_axis_beside_its_path(tmp_path: Path) -> None:
    rig = by_drive(tmp_path)
    rig.start("%T\nN10 B[MC_Home WaitSyn]\nN20 G01 X1 F600\nM30\n")
    rig.until(lambda: not rig.simulation.controller.channel.active)
    assert referenced(rig)
    assert rig.place("B") == pytest.approx(10.0, abs=0.01)
    assert rig.place("X") == pytest.approx(1.0)


def test_the_drive_finds_it_and_the_axis_moves_in_its_coordinates(tmp_path: Path) -> None:
    rig = by_drive(tmp_path)
    assert not referenced(rig)
    home, move = MC_Home(), MC_MoveAbsolute()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.run(0.1)
    assert state(rig) is MotionState.HOMING
    assert home.Busy
    rig.until(lambda: home.Done)
    assert referenced(rig)
    assert rig.place("B") == pytest.approx(10.0, abs=0.01)
    assert servo(rig) == pytest.approx(-20.0, abs=0.2)
    rig.call("move", lambda p: move(p.axes["B"], True, Position=40.0, Velocity=90.0))
    rig.until(lambda: move.Done)
    assert servo(rig) == pytest.approx(10.0, abs=0.2)
    assert state(rig) is MotionState.STANDSTILL


def test_nothing_else_moves_it_meanwhile_and_stop_stops_it(tmp_path: Path) -> None:
    rig = by_drive(tmp_path)
    home, move, stop = MC_Home(), MC_MoveAbsolute(), MC_Stop()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.run(0.2)
    rig.call("move", lambda p: move(p.axes["B"], True, Position=40.0, Velocity=90.0))
    rig.until(lambda: move.Error, 1.0)
    assert move.ErrorID == errors.JOB_HOMES.id
    assert home.Busy
    rig.call("stop", lambda p: stop(p.axes["B"], True))
    rig.until(lambda: stop.Done, 2.0)
    assert home.CommandAborted
    stands = servo(rig)
    rig.run(0.2)
    assert servo(rig) == pytest.approx(stands, abs=0.01)
    assert not rig.image.by_drive[rig.table]
    assert not referenced(rig)
    rig.call("stop", lambda p: stop(p.axes["B"], False))
    rig.call("home", lambda p: home(p.axes["B"], False))
    rig.run(0.05)
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.until(lambda: home.Done)
    assert referenced(rig)


def test_a_homing_error_of_the_drive_is_an_error_of_the_job(tmp_path: Path) -> None:
    rig = Rig(tmp_path, ideal=False, table=BY_DRIVE.replace("method: 21", "method: -9"))
    home, reset = MC_Home(), MC_Reset()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.until(lambda: home.Error, 2.0)
    assert home.ErrorID == errors.JOB_HOME_FAILED.id
    assert state(rig) is MotionState.ERROR_STOP
    rig.call("reset", lambda p: reset(p.axes["B"], True))
    rig.until(lambda: reset.Done, 1.0)
    assert state(rig) is MotionState.STANDSTILL


def test_at_a_cam(tmp_path: Path) -> None:
    rig = Rig(tmp_path, table=AT_CAM)
    home = MC_Home()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.until(lambda: home.Error, 1.0)
    assert home.ErrorID == errors.JOB_HOME.id  # nobody tells the cam
    rig.call("home", lambda p: home(p.axes["B"], False))

    def cam(program: object) -> None:
        raw = float(rig.image.actual_position[rig.table] - rig.image.origin[rig.table])
        rig.program.axes["B"].reference_cam = raw < -15.0

    rig.call("cam", cam)
    rig.run(0.05)
    rig.path.clear()
    rig.call("home", lambda p: home(p.axes["B"], True))
    rig.until(lambda: home.Done)
    assert referenced(rig)
    assert rig.place("B") == pytest.approx(10.0)
    assert rig.image.origin[rig.table] == pytest.approx(25.0, abs=0.1)
