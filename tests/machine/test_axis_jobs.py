"""PLCopen motion blocks on the whole machine: PLC program, slot, jobs, drives; beside a program and instead of one."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import axis_jobs, plc
from runtime.hli.axis_jobs import JobGiver
from runtime.hli.layout import JobState, MotionState
from runtime.plc_logic import Program
from runtime.plc_logic.bench import Bench
from runtime.plc_logic.motion import (
    MC_GearIn,
    MC_GearOut,
    MC_Halt,
    MC_Home,
    MC_MoveAbsolute,
    MC_MoveAdditive,
    MC_MoveRelative,
    MC_MoveSuperimposed,
    MC_MoveVelocity,
    MC_Phasing,
    MC_Power,
    MC_ReadActualPosition,
    MC_ReadActualVelocity,
    MC_ReadAxisError,
    MC_ReadCommandPosition,
    MC_ReadStatus,
    MC_Reset,
    MC_SetOverride,
    MC_Stop,
    MC_TouchProbe,
)
from tests.machine.beside_channel import LONG_LINE, Rig


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path)


@pytest.mark.parametrize("ideal", [True, False])
def test_a_table_beside_the_channel_turns_while_a_program_runs(tmp_path: Path, ideal: bool) -> None:
    rig = Rig(tmp_path, ideal=ideal)
    move, status = MC_MoveAbsolute(), MC_ReadStatus()
    rig.call("move", lambda p: move(Axis=p.axes["B"], Execute=True, Position=270.0, Velocity=90.0))
    rig.call("status", lambda p: status(Axis=p.axes["B"]))
    rig.start(LONG_LINE)
    assert status.DiscreteMotion
    assert rig.simulation.controller.channel.active
    rig.until(lambda: move.Done)
    assert rig.place("B") == 270.0
    assert not move.Busy
    rig.until(lambda: not rig.simulation.controller.channel.active)
    assert rig.place("X") == pytest.approx(200.0)
    assert not rig.simulation.errors
    rig.assert_smooth()


def test_an_axis_of_the_path_is_refused_while_a_program_runs_and_moves_afterwards(rig: Rig) -> None:
    move = MC_MoveAbsolute()
    rig.start(LONG_LINE)
    rig.call("move", lambda p: move(Axis=p.axes["X"], Execute=True, Position=10.0, Velocity=50.0))
    rig.until(lambda: move.Error)
    assert move.ErrorID == axis_jobs.JOB_IN_PATH.id
    rig.until(lambda: not rig.simulation.controller.channel.active)
    assert rig.place("X") == pytest.approx(200.0), "the path has not noticed"
    again = MC_MoveAbsolute()
    rig.call("again", lambda p: again(Axis=p.axes["X"], Execute=True, Position=10.0, Velocity=50.0))
    rig.run(0.2)
    rig.start(LONG_LINE)
    assert not rig.simulation.controller.channel.active, "no program starts while a job moves its axis"
    assert rig.simulation.problems[-1].entry is axis_jobs.JOB_RUNS
    rig.until(lambda: again.Done)
    assert rig.place("X") == 10.0
    rig.start(LONG_LINE)
    rig.until(lambda: not rig.simulation.controller.channel.active)
    assert rig.place("X") == pytest.approx(200.0)


def test_the_blocks_of_one_axis(tmp_path: Path) -> None:
    """What each block is for, in one go: the axis does what they say, one after the other."""
    rig = Rig(tmp_path, ideal=False)
    absolute, relative, additive, added = MC_MoveAbsolute(), MC_MoveRelative(), MC_MoveAdditive(), MC_MoveSuperimposed()
    velocity, halt, stop, home, reset = MC_MoveVelocity(), MC_Halt(), MC_Stop(), MC_Home(), MC_Reset()
    status, position, actual, speed = (
        MC_ReadStatus(),
        MC_ReadCommandPosition(),
        MC_ReadActualPosition(),
        MC_ReadActualVelocity(),
    )
    power, error, override = MC_Power(), MC_ReadAxisError(), MC_SetOverride()
    on = {"power": True}
    rig.call("power", lambda p: power(Axis=p.axes["B"], Enable=on["power"]))
    for name, block in {
        "status": status,
        "position": position,
        "actual": actual,
        "speed": speed,
        "error": error,
    }.items():
        rig.call(name, lambda p, block=block: block(Axis=p.axes["B"]))  # type: ignore[misc]
    rig.run(0.02)
    assert power.Status
    assert status.Standstill
    rig.call("home", lambda p: home(Axis=p.axes["B"], Execute=True))
    rig.until(lambda: home.Done)
    rig.call("a", lambda p: relative(Axis=p.axes["B"], Execute=True, Distance=30.0, Velocity=60.0))
    rig.run(0.1)
    assert relative.Busy
    assert relative.Active
    rig.call("b", lambda p: additive(Axis=p.axes["B"], Execute=True, Distance=15.0, Velocity=60.0))
    rig.until(lambda: additive.Done)
    assert relative.CommandAborted
    assert position.Value == pytest.approx(45.0, abs=1e-4)
    rig.call("v", lambda p: velocity(Axis=p.axes["B"], Execute=True, Velocity=40.0))
    rig.until(lambda: velocity.InVelocity)
    rig.run(0.05)
    assert status.ContinuousMotion
    assert speed.Value == pytest.approx(40.0, abs=0.5)
    rig.call("o", lambda p: override(Axis=p.axes["B"], Enable=True, VelFactor=0.5))
    rig.run(0.2)
    assert speed.Value == pytest.approx(20.0, abs=0.5)
    rig.call("o", lambda p: override(Axis=p.axes["B"], Enable=True, VelFactor=1.0))
    rig.call("s", lambda p: added(Axis=p.axes["B"], Execute=True, Distance=10.0, VelocityDiff=20.0))
    rig.until(lambda: added.Done)
    assert not velocity.CommandAborted
    rig.call("h", lambda p: halt(Axis=p.axes["B"], Execute=True))
    rig.until(lambda: halt.Done)
    assert velocity.CommandAborted
    assert not velocity.InVelocity
    hold = {"on": True}
    rig.call("abs", lambda p: absolute(Axis=p.axes["B"], Execute=True, Position=0.0, Velocity=90.0))
    rig.run(0.3)
    rig.call("stop", lambda p: stop(Axis=p.axes["B"], Execute=hold["on"]))
    rig.until(lambda: stop.Done)
    assert absolute.CommandAborted
    rig.run(0.05)
    assert status.Stopping
    refused = MC_MoveAbsolute()
    rig.call("refused", lambda p: refused(Axis=p.axes["B"], Execute=True, Position=1.0, Velocity=1.0))
    rig.until(lambda: refused.Error)
    assert refused.ErrorID == axis_jobs.JOB_STOPPING.id
    hold["on"] = False
    rig.run(0.05)
    assert status.Standstill
    assert error.AxisErrorID == 0
    rig.call("reset", lambda p: reset(Axis=p.axes["B"], Execute=True))
    rig.until(lambda: reset.Done)
    rig.assert_smooth()
    on["power"] = False
    rig.run(0.05)
    assert status.Disabled
    assert not power.Status
    assert actual.Value == pytest.approx(position.Value, abs=0.01)


@pytest.mark.spec("hli.mech.single-axis-commanding")
def test_a_second_job_of_a_cycle_waits_and_a_stop_overtakes(rig: Rig) -> None:
    giver = JobGiver(rig.hli.axes[rig.table])
    first, second, stop = MC_MoveAbsolute(), MC_MoveAbsolute(), MC_Stop()
    table = rig.program.axes["B"]
    first(Axis=table, Execute=True, Position=50.0, Velocity=50.0)
    second(Axis=table, Execute=True, Position=-50.0, Velocity=50.0)
    unit = rig.hli.axes[rig.table].job
    taken = unit.commands_taken_r
    assert unit.command_semaphor_rw
    assert unit.command_w.position == 500_000
    stop(Axis=table, Execute=True)
    assert unit.command_w.function == 1, "the stop stands in the place of the move"
    rig.cycle()
    assert unit.commands_taken_r == taken + 1
    for block in (first, second):
        block(Axis=table, Execute=True, Position=0.0, Velocity=50.0)
    assert first.CommandAborted, "it was overtaken before it began"
    assert second.Busy
    rig.run(0.02)
    assert rig.place("B") == 0.0
    assert giver.answer(1).state is JobState.ABORTED


def test_a_gear_between_axes(rig: Rig) -> None:
    gear, out, shift, drive = MC_GearIn(), MC_GearOut(), MC_Phasing(), MC_MoveVelocity()
    rig.call(
        "gear",
        lambda p: gear(Master=p.axes["Y"], Slave=p.axes["B"], Execute=True, RatioNumerator=2.0, RatioDenominator=-1.0),
    )
    rig.until(lambda: gear.InGear)
    rig.call("drive", lambda p: drive(Axis=p.axes["Y"], Execute=True, Velocity=20.0, Acceleration=100.0, Jerk=1000.0))
    rig.until(lambda: drive.InVelocity)
    rig.run(0.1)
    slave, master = rig.place("B"), rig.place("Y")
    rig.run(0.5)
    assert rig.place("B") - slave == pytest.approx(-2.0 * (rig.place("Y") - master), abs=1e-6)
    rig.call(
        "shift", lambda p: shift(Master=p.axes["Y"], Slave=p.axes["B"], Execute=True, PhaseShift=15.0, Velocity=30.0)
    )
    rig.until(lambda: shift.Done)
    assert rig.place("B") - slave == pytest.approx(15.0 - 2.0 * (rig.place("Y") - master), abs=1e-6)
    rig.call("out", lambda p: out(Slave=p.axes["B"], Execute=True))
    rig.until(lambda: out.Done)
    assert gear.CommandAborted
    assert rig.program.axes["B"].motion_state is MotionState.CONTINUOUS_MOTION


def test_a_probe_latches_the_position_of_an_edge(rig: Rig) -> None:
    """Input 1 of the demo machine is its clamp: it closes 0.3 s after the valve."""
    probe, run = MC_TouchProbe(), MC_MoveVelocity()
    rig.call("run", lambda p: run(Axis=p.axes["B"], Execute=True, Velocity=30.0))
    rig.call("probe", lambda p: probe(Axis=p.axes["B"], Execute=True, TriggerInput=1, Mode=2))
    rig.run(0.5)
    assert probe.Busy
    rig.call("valve", lambda p: setattr(p.io, "clamp_valve", True))
    rig.until(lambda: probe.Done)
    assert probe.RecordedPosition == pytest.approx(rig.place("B"), abs=0.5)
    assert probe.RecordedPosition > 10.0


def test_a_speed_controlled_spindle_refuses_by_name(rig: Rig) -> None:
    move = MC_MoveAbsolute()
    rig.call("move", lambda p: move(Axis=p.axes["S"], Execute=True, Position=90.0, Velocity=100.0))
    rig.until(lambda: move.Error)
    assert move.ErrorID == axis_jobs.JOB_SPINDLE.id
    assert "S is a speed-controlled spindle" in rig.simulation.problems[-1].text


def test_a_target_beyond_the_software_limit_is_refused(rig: Rig) -> None:
    move = MC_MoveAbsolute()
    rig.call("move", lambda p: move(Axis=p.axes["B"], Execute=True, Position=721.0, Velocity=100.0))
    rig.until(lambda: move.Error)
    assert move.ErrorID == axis_jobs.JOB_LIMIT.id
    assert rig.place("B") == 0.0


@pytest.mark.spec("hli.mech.watchdog-cnc-monitors-plc")
def test_a_plc_that_is_lost_leaves_its_axes_at_rest(rig: Rig) -> None:
    run, reset, move = MC_MoveVelocity(), MC_Reset(), MC_MoveRelative()
    rig.call("run", lambda p: run(Axis=p.axes["B"], Execute=True, Velocity=100.0))
    rig.until(lambda: run.InVelocity)
    rig.simulation.plc.frozen = True  # type: ignore[union-attr]
    rig.run(0.05 + 0.004 + 100.0 / 720.0 + 720.0 / 20000.0 + 0.01)
    here = rig.place("B")
    rig.run(0.2)
    assert rig.place("B") == here
    assert rig.simulation.problems[0].entry is plc.PLC_WATCHDOG
    assert rig.hli.axes[rig.table].job.motion_state_r == MotionState.ERROR_STOP
    rig.assert_smooth()
    rig.simulation.plc.frozen = False  # type: ignore[union-attr]
    rig.hli.operator[0].reset_rw = True
    rig.run(0.6)
    rig.call("run", lambda p: None)
    rig.call("reset", lambda p: reset(Axis=p.axes["B"], Execute=True))
    rig.until(lambda: reset.Done)
    rig.call("move", lambda p: move(Axis=p.axes["B"], Execute=True, Distance=1.0, Velocity=10.0))
    rig.until(lambda: move.Done)


def test_on_the_bench_a_job_stays_in_its_slot() -> None:
    """The bench has no CNC: the block waits, and says so."""

    class Turns(Program):
        def setup(self) -> None:
            self.move = MC_MoveAbsolute()

        def cycle(self) -> None:
            self.move(Axis=self.axes["X"], Execute=True, Position=1.0, Velocity=1.0)

    bench = Bench(Turns)
    bench.run(0.1)
    assert bench.program.move.Busy
    assert not bench.program.move.Active
