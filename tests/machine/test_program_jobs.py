"""Jobs that a program gives to an axis beside its path, on the whole machine in virtual time."""

from __future__ import annotations

from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import axis_jobs
from runtime.hli.layout import MotionState, StopCondition
from tests.machine.beside_channel import TABLE, Rig

FAST = "Velocity=90000"  # degrees/s · 1000


@pytest.fixture
def rig(tmp_path: Path) -> Rig:
    return Rig(tmp_path)


def active(rig: Rig) -> bool:
    return rig.simulation.controller.channel.active


def waits(rig: Rig) -> bool:
    return bool(rig.simulation.controller.channel.stop_condition & StopCondition.AXIS_JOB)


def state(rig: Rig) -> MotionState:
    return rig.simulation.controller.jobs.state(rig.table)


def finish(rig: Rig) -> None:
    rig.until(lambda: not active(rig))
    assert not rig.simulation.problems, [str(problem) for problem in rig.simulation.problems]


def velocity(rig: Rig) -> float:
    return (rig.path[-1] - rig.path[-2]) / rig.simulation.period


@pytest.mark.spec("isg.plcopen.sync", "chan.plcopen")
@pytest.mark.parametrize("ideal", [True, False])
def test_wait_syn_holds_the_path_at_the_end_of_its_block(tmp_path: Path, ideal: bool) -> None:
    rig = Rig(tmp_path, ideal=ideal)
    rig.start(
        f"%T\nN10 G01 X10 F6000\nN20 B[MC_MoveAbsolute WAIT_SYN Position=900000 {FAST} Direction=2] X20\nN30 X30\nM30\n"
    )
    rig.until(lambda: waits(rig))
    assert rig.place("X") == pytest.approx(20.0), "the motion of the block is driven beside the job"
    assert 0.0 < rig.place("B") < 90.0
    rig.until(lambda: rig.place("X") > 20.001)
    assert rig.place("B") == 90.0
    finish(rig)
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.sync", "isg.plcopen.mc-movevelocity")
def test_late_synchronisation_by_id(rig: Rig) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveAbsolute Id100 Position=900000 {FAST} Direction=1]\nN20 G01 X10 F6000\n"
        "N30 #WAIT MC_STATUS SYN [ID=100]\nN40 X20\nN50 B[MC_MoveVelocity Id100 Velocity=30000 Direction=3]\n"
        "N60 #WAIT MC_STATUS SYN [ID100]\nN70 X40\nN80 B[MC_Stop WaitSyn]\nM30\n"
    )
    rig.until(lambda: rig.place("X") > 9.9)
    assert rig.place("B") < 90.0, "the program went on beside the job"
    rig.until(lambda: rig.place("X") > 10.001)
    assert rig.place("B") == 90.0
    rig.until(lambda: rig.place("X") > 20.001)
    assert velocity(rig) == pytest.approx(-30.0)
    assert state(rig) is MotionState.CONTINUOUS_MOTION
    finish(rig)
    assert velocity(rig) == 0.0
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.sync")
def test_a_number_that_is_used_again_means_the_last_job(rig: Rig) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveVelocity Id=1 Velocity=10000 Direction=1]\nN20 G04 0.1\n"
        f"N30 B[MC_MoveRelative Id=1 Distance=100000 {FAST}]\nN40 #WAIT MC_STATUS SYN [ID=1]\nN50 G01 X1 F600\nM30\n"
    )
    rig.until(lambda: rig.place("X") > 0.001)
    assert velocity(rig) == 0.0
    finish(rig)


@pytest.mark.spec("isg.plcopen.mc-moveabsolute")
def test_a_new_motion_takes_over_from_the_one_under_way(rig: Rig) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveAbsolute Position=3600000 {FAST} Direction=1]\nN20 G04 0.5\n"
        f"N30 B[MC_MoveAbsolute Position=-100000 {FAST} Direction=3 WaitSyn]\nM30\n"
    )
    finish(rig)
    assert rig.place("B") == pytest.approx(-10.0)
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-moveabsolute")
@pytest.mark.parametrize(("direction", "end"), [(1, 350.0), (2, -10.0), (3, -10.0), (4, 350.0)])
def test_the_direction_decides_the_way_of_an_axis_that_turns_without_end(
    tmp_path: Path, direction: int, end: float
) -> None:
    endless = "".join(line for line in TABLE.splitlines(keepends=True) if "position_m" not in line)
    rig = Rig(tmp_path, table=endless)
    rig.start(f"%T\nN10 B[MC_MoveAbsolute Position=3500000 {FAST} Direction={direction} WaitSyn]\nM30\n")
    finish(rig)
    assert rig.place("B") == pytest.approx(end)
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-moveadditive", "isg.plcopen.mc-moverelative")
@pytest.mark.parametrize(("function", "discrete"), [("MC_MoveAdditive", True), ("MC_MoveRelative", False)])
def test_additive_counts_from_the_target_and_relative_from_the_place(rig: Rig, function: str, discrete: bool) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveAbsolute Position=600000 {FAST} Direction=1]\nN20 G04 0.3\n"
        f"N30 B[{function} Distance=100000 {FAST} WaitSyn]\nM30\n"
    )
    begun = 0.0
    jobs = rig.simulation.controller.jobs.axes[rig.table]
    assert jobs is not None
    while not waits(rig):
        begun = rig.place("B")
        rig.cycle()
    finish(rig)
    assert 0.0 < begun < 60.0
    if discrete:
        assert rig.place("B") == pytest.approx(70.0)
    else:
        assert begun + 9.0 < rig.place("B") < begun + 10.5
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-moveadditive")
def test_additive_behind_an_endless_motion_counts_from_the_place(rig: Rig) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveVelocity Velocity=20000 Direction=1 WaitSyn]\n"
        f"N20 B[MC_MoveAdditive Distance=300000 {FAST} WaitSyn]\nM30\n"
    )
    begun = 0.0
    rig.until(lambda: state(rig) is MotionState.CONTINUOUS_MOTION)
    while state(rig) is MotionState.CONTINUOUS_MOTION:
        begun = rig.place("B")
        rig.cycle()
    finish(rig)
    assert rig.place("B") == pytest.approx(begun + 30.0, abs=0.1)


@pytest.mark.spec("isg.plcopen.mc-movevelocity")
def test_an_endless_motion_goes_on_behind_the_program(rig: Rig) -> None:
    rig.start("%T\nN10 B[MC_MoveVelocity Velocity=20000 Direction=3 WaitSyn]\nM30\n")
    finish(rig)
    rig.run(0.2)
    assert velocity(rig) == pytest.approx(-20.0)
    rig.start(
        "%T\nN10 B[MC_MoveVelocity Velocity=10000 Direction=4 WaitSyn]\nN20 B[MC_Stop Deceleration=100 WaitSyn]\nM30\n"
    )
    finish(rig)
    assert velocity(rig) == 0.0
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-stop")
def test_stop_ends_what_moves_the_axis(rig: Rig) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveAbsolute Position=3600000 {FAST} Direction=1]\nN20 G04 0.5\n"
        "N30 B[MC_Stop Deceleration=200 Jerk=5000 WaitSyn]\nN40 G01 X1 F600\nM30\n"
    )
    rig.until(lambda: state(rig) is MotionState.STOPPING)
    rig.until(lambda: rig.place("X") > 0.0)
    assert velocity(rig) == 0.0
    assert 20.0 < rig.place("B") < 200.0
    finish(rig)
    assert state(rig) is MotionState.STANDSTILL
    rig.assert_smooth()


def test_an_axis_with_an_absolute_encoder_is_homed_at_once(rig: Rig) -> None:
    rig.start("%T\nN10 B[MC_Home WaitSyn]\nN20 G01 X1 F600\nM30\n")
    finish(rig)
    assert rig.place("B") == 0.0
    assert rig.place("X") == pytest.approx(1.0)


@pytest.mark.spec("isg.plcopen.mc-movesuperimposed")
def test_a_superimposed_motion_is_added_to_the_one_under_way(rig: Rig) -> None:
    rig.start(
        "%T\nN10 B[MC_MoveVelocity Velocity=40000 Direction=1 Id=1 WaitSyn]\n"
        "N20 B[MC_MoveSuperImposed Distance=100000 VelocityDiff=20000 WaitSyn]\nN30 #WAIT MC_STATUS SYN [ID=1]\nM30\n"
    )
    greatest = 0.0
    while active(rig):
        rig.cycle()
        greatest = max(greatest, velocity(rig))
    assert not rig.simulation.problems
    assert greatest == pytest.approx(60.0)
    assert velocity(rig) == pytest.approx(40.0)
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-gearout", "isg.plcopen.mc-phasing")
def test_the_table_follows_an_axis_of_the_path(rig: Rig) -> None:
    rig.start(
        "%T\nN10 B[MC_GearIn Master=X RN=1 RD=4 Mode=0]\nN20 G01 X100 F1200\n"
        "N30 B[MC_Phasing Master=X PhaseShift=50000 Velocity=10000]\nN40 X150\nN50 B[MC_GearOut]\nN60 G04 0.5\nM30\n"
    )
    rig.until(lambda: 49.0 < rig.place("X") < 99.0)
    assert state(rig) is MotionState.SYNCHRONIZED_MOTION
    assert velocity(rig) == pytest.approx(5.0)
    lag = 0.25 * rig.place("X") - rig.place("B")
    rig.until(lambda: rig.place("X") > 140.0)
    assert 0.25 * rig.place("X") - rig.place("B") == pytest.approx(lag - 5.0, abs=0.1)
    finish(rig)
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-gearin")
def test_a_program_brings_the_table_into_phase_with_an_axis_of_the_path(rig: Rig) -> None:
    rig.start(
        "%T\nN10 G01 X10 F1200\nN20 B[MC_GearIn Master=X RN=1 RD=4 PhaseShift=300000 Mode=256 WaitSyn]\nN30 X60\nM30\n"
    )
    rig.until(lambda: waits(rig))
    assert rig.place("X") == pytest.approx(10.0)
    rig.until(lambda: rig.place("X") > 10.001)
    assert rig.place("B") == pytest.approx(32.5, abs=0.01), "a quarter of 10, and 30 beside it"
    finish(rig)
    assert rig.place("B") == pytest.approx(45.0, abs=1e-4)
    rig.assert_smooth()


@pytest.mark.spec("isg.plcopen.mc-touchprobe")
@pytest.mark.parametrize(("mode", "rises"), [("", True), ("Mode=2", True), ("Mode=1", False)])
def test_a_program_probes_and_reads_the_position(rig: Rig, mode: str, rises: bool) -> None:
    valve = {"on": not rises}  # input 1 of the demo machine is its clamp: it follows its valve by 0.3 s
    rig.call("valve", lambda p: setattr(p.io, "clamp_valve", valve["on"]))
    rig.run(0.5)
    rig.start(
        f"%T\nN10 P1=V.A.MERF.B\nN20 B[MC_TouchProbe Channel=1 {mode} Id=1]\nN30 P2=V.A.MERF.B\n"
        "N40 B[MC_MoveVelocity Velocity=20000 Direction=1]\nN50 #WAIT MC_STATUS SYN [ID=1]\nN60 B[MC_Stop WaitSyn]\n"
        "N70 P3=V.A.MERF.B P4=V.A.MEAS.ACS.VALUE.B\n"
        "N80 G01 X=P1*8+P2*4+P3 Y=P4 F6000\nM30\n"
    )
    rig.until(lambda: rig.place("B") > 12.0)
    assert active(rig)
    unit = rig.hli.axes[rig.table].job
    assert not unit.probe_recorded_r
    valve["on"] = rises
    rig.until(lambda: unit.probe_recorded_r)
    place = rig.place("B")
    finish(rig)
    assert rig.place("X") == pytest.approx(1.0), "before the edge nothing was recorded"
    assert rig.place("Y") == pytest.approx(unit.probe_position_r * 1e-4, abs=1e-4)
    assert rig.place("Y") == pytest.approx(place, abs=0.1)


def test_a_probe_that_the_drive_does_not_have_stops_the_program(rig: Rig) -> None:
    rig.start("%T\nN10 B[MC_TouchProbe Channel=513 WaitSyn]\nN20 G01 X10 F600\nM30\n")
    rig.until(lambda: not active(rig))
    told = [problem.entry for problem in rig.simulation.problems]
    assert told == [axis_jobs.JOB_NO_PROBE, axis_jobs.JOB_OF_PROGRAM]
    assert rig.place("X") == 0.0


@pytest.mark.spec("isg.plcopen.mc-touchprobe")
@pytest.mark.parametrize("abort", ["reset", "abort"])
def test_an_aborted_program_waits_for_no_edge_any_more(rig: Rig, abort: str) -> None:
    rig.start("%T\nN10 B[MC_TouchProbe Channel=3 WaitSyn]\nM30\n")
    rig.run(0.05)
    jobs = rig.simulation.controller.jobs.axes[rig.table]
    assert jobs is not None
    assert jobs.probe.input == 3
    if abort == "reset":
        rig.simulation.controller.reset()
    else:
        rig.simulation.controller.channel.abort()
    rig.until(lambda: not active(rig))
    rig.run(0.05)
    assert jobs.probe.input == 0
    assert state(rig) is MotionState.STANDSTILL


@pytest.mark.spec("isg.plcopen.mc-gearout")
def test_behind_the_gear_the_axis_goes_on_and_an_abort_stops_it(rig: Rig) -> None:
    rig.start(
        "%T\nN10 B[MC_GearIn Master=X RN=1 RD=1 Mode=0]\nN20 G01 X20 F1200\nN25 B[MC_GearOut]\nN30 X40\nM00\nM30\n"
    )
    rig.until(lambda: rig.simulation.controller.channel.interpolator.standstill and rig.place("X") > 39.9)
    velocity_before = velocity(rig)
    assert velocity_before == pytest.approx(0.0, abs=25.0)
    rig.simulation.controller.channel.abort()
    rig.until(lambda: not active(rig))
    rig.run(0.5)
    assert velocity(rig) == 0.0
    assert not rig.simulation.problems
    rig.assert_smooth()


@pytest.mark.parametrize(
    ("text", "cause"),
    [
        (f"B[MC_MoveAbsolute Position=9000000 {FAST} Direction=1]", axis_jobs.JOB_LIMIT),
        ("B[MC_GearOut]", axis_jobs.JOB_NO_GEAR),
        ("B[MC_Phasing Master=X PhaseShift=1 Velocity=1]", axis_jobs.JOB_NO_GEAR),
        (f"B[MC_MoveAbsolute Position=-10000 {FAST} Direction=1]", axis_jobs.JOB_VALUE),
    ],
)
def test_a_job_that_fails_stops_the_program(rig: Rig, text: str, cause: object) -> None:
    rig.start(f"%T\nN10 {text}\nN20 G01 X200 F600\nM30\n")
    rig.until(lambda: not active(rig))
    told = rig.simulation.problems
    assert [problem.entry for problem in told] == [cause, axis_jobs.JOB_OF_PROGRAM]
    assert told[1].place.line == 2
    assert rig.place("B") == 0.0
    assert rig.place("X") < 5.0
    assert state(rig) is MotionState.STANDSTILL


@pytest.mark.spec("isg.plcopen.sync")
def test_waiting_for_a_job_that_another_one_has_ended_stops_the_program(rig: Rig) -> None:
    rig.start(
        f"%T\nN10 B[MC_MoveAbsolute Id=1 Position=3600000 {FAST} Direction=1]\nN20 B[MC_Stop WaitSyn]\n"
        "N30 #WAIT MC_STATUS SYN [ID=1]\nN40 G01 X10 F600\nM30\n"
    )
    rig.until(lambda: not active(rig))
    assert [problem.entry for problem in rig.simulation.problems] == [axis_jobs.JOB_OF_PROGRAM]
    assert rig.place("X") == 0.0


def test_an_aborted_program_brings_its_axes_to_rest(rig: Rig) -> None:
    rig.start(f"%T\nN10 B[MC_MoveAbsolute Position=3600000 {FAST} Direction=1 WaitSyn]\nM30\n")
    rig.run(0.5)
    assert velocity(rig) > 80.0
    rig.simulation.controller.channel.abort()
    rig.until(lambda: not active(rig) and state(rig) is MotionState.STANDSTILL)
    assert velocity(rig) == 0.0
    assert rig.place("B") < 200.0
    assert not rig.simulation.problems
    rig.assert_smooth()


def test_a_reset_ends_the_job_and_the_next_program_runs(rig: Rig) -> None:
    rig.start(f"%T\nN10 B[MC_MoveAbsolute Position=3600000 {FAST} Direction=1 WaitSyn]\nM30\n")
    rig.run(0.5)
    rig.simulation.controller.reset()
    rig.until(lambda: not active(rig) and state(rig) is MotionState.STANDSTILL)
    assert rig.place("B") < 200.0
    rig.simulation.problems.clear()
    rig.start(f"%T\nN10 B[MC_MoveAbsolute Position=0 {FAST} Direction=2 WaitSyn]\nM30\n")
    finish(rig)
    assert rig.place("B") == 0.0


def test_with_machine_lock_no_job_moves_an_axis(rig: Rig) -> None:
    program = rig.folder / "part.nc"
    program.write_text(
        f"%T\nN10 B[MC_MoveAbsolute Position=100000 {FAST} Direction=1 WaitSyn Id=1]\n#WAIT MC_STATUS SYN [ID=1]\nM30\n"
    )
    rig.hli.operator[0].machine_lock_w = True
    rig.simulation.start(program)
    rig.run(0.01)
    rig.until(lambda: not active(rig))
    assert rig.place("B") == 0.0


@pytest.mark.spec("isg.plcopen.mc-stop")
def test_behind_a_stop_that_was_waited_for_the_axis_takes_jobs_again(rig: Rig) -> None:
    rig.start(
        "%T\nN10 B[MC_MoveVelocity Velocity=50000 Direction=1 WaitSyn]\nN20 B[MC_Stop WaitSyn]\n"
        f"N30 B[MC_MoveAbsolute Position=0 {FAST} Direction=3 WaitSyn]\nM30\n"
    )
    finish(rig)
    assert rig.place("B") == 0.0
    rig.assert_smooth()


@pytest.mark.parametrize("modal", ["V.G.WZ_AKT.R=3\nG41", "G261", "#HSC ON\n", "G41 V.G.WZ_AKT.R=3 G261"])
def test_a_job_inside_of_a_modal_path_interrupts_it_where_it_stands(rig: Rig, modal: str) -> None:
    rig.start(
        f"%T\nN10 {modal} G01 X10 F6000\nN20 X20\nN30 B[MC_MoveRelative Distance=100000 {FAST} WaitSyn]\n"
        "N40 X30\nN50 Y20\nN60 G40 X40\nM30\n"
    )
    rig.until(lambda: waits(rig))
    assert rig.place("X") == pytest.approx(20.0)
    rig.until(lambda: rig.place("X") > 20.001)
    assert rig.place("B") == pytest.approx(10.0)
    finish(rig)


@pytest.mark.spec("isg.plcopen.mc-phasing")
def test_phasing_names_the_master_of_the_gear(rig: Rig) -> None:
    rig.start(
        "%T\nN10 B[MC_GearIn Master=X RN=1 RD=1 Mode=0]\nN20 B[MC_Phasing Master=Y PhaseShift=1 Velocity=1]\n"
        "N30 G01 X100 F600\nM30\n"
    )
    rig.until(lambda: not active(rig))
    told = rig.simulation.problems
    assert [problem.entry for problem in told][:2] == [axis_jobs.JOB_OTHER_MASTER, axis_jobs.JOB_OF_PROGRAM]
    assert told[1].place.line == 3
    assert rig.place("X") < 5.0
