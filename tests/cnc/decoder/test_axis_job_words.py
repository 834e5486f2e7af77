"""Jobs of axes outside of the channel in programs: how they are written, their units, and what is refused."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import AxisJob, AxisJobWait, Line
from runtime.cnc.decoder.setup import OtherAxis
from runtime.diagnostics.catalogue import axis_jobs as J  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import language as C  # noqa: N812
from runtime.diagnostics.catalogue import technology as T  # noqa: N812
from runtime.diagnostics.errors import ErrorEntry
from runtime.hli.axis_jobs import Job
from runtime.hli.layout import AxisFunction as F
from runtime.hli.layout import Direction
from tests.cnc.decoder.programs import SETUP as PLAIN
from tests.cnc.decoder.programs import decode, problems

SETUP = replace(PLAIN, log_axes=(1, 2, 3), other_axes=(OtherAxis("B", 4, 9), OtherAxis("S2", 6, 11)))
UNITS = replace(SETUP, job_units=True)
IMPLICIT = replace(SETUP, jobs_wait=True)


def jobs(text: str, setup: object = SETUP) -> list[AxisJob]:
    run = decode(f"%T\n{text}\nM30\n", setup)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return [block for block in run.blocks if isinstance(block, AxisJob)]


def job(text: str, setup: object = SETUP) -> Job:
    (only,) = jobs(text, setup)
    return only.job


@pytest.mark.spec("chan.plcopen", "isg.plcopen.command-syntax")
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("MC_Home", Job(F.HOME)),
        (
            "MC_MoveAbsolute Position=133 Velocity=1000 Acceleration=500 Deceleration=600 Jerk=20000 Direction=2",
            Job(F.MOVE_ABSOLUTE, 0.0133, 1.0, 500.0, 600.0, 20_000.0, Direction.SHORTEST),
        ),
        (
            "MC_MOVEABSOLUTE POSITION=-1e4 VELOCITY=1 DIRECTION=3",
            Job(F.MOVE_ABSOLUTE, -1.0, 0.001, direction=Direction.NEGATIVE),
        ),
        ("MC_MoveAdditive Distance=277 Velocity=1100 Acceleration=0 Jerk=-1", Job(F.MOVE_ADDITIVE, 0.0277, 1.1)),
        ("MC_MoveRelative Distance=[100+P1] Velocity=2*P1", Job(F.MOVE_RELATIVE, 0.015, 0.1)),
        (
            "MC_MoveSuperImposed Distance=321 VelocityDiff=783 Deceleration=922",
            Job(F.MOVE_SUPERIMPOSED, 0.0321, 0.783, deceleration=922.0),
        ),
        ("MC_MoveVelocity Velocity=1333 Direction=4", Job(F.MOVE_VELOCITY, velocity=1.333, direction=Direction.CURRENT)),
        ("MC_Stop Deceleration=999 Jerk=25000", Job(F.STOP, deceleration=999.0, jerk=25_000.0)),
        (
            "MC_GearIn Master=11 RatioNumerator=2 RatioDenominator=3 Mode=0",
            Job(F.GEAR_IN, numerator=2.0, denominator=3.0, master=11),
        ),
        ("MC_GearIn Master=S2 RN=-1 RD=3 Mode=128", Job(F.GEAR_IN, numerator=-1.0, denominator=3.0, master=11, mode=128)),
        ("MC_GearIn Master=X RN=1 RD=1 Mode=0", Job(F.GEAR_IN, master=1)),
        (
            "MC_GearIn Master=S2 RN=1 RD=3 PhaseShift=1800000 Mode=256",
            Job(F.GEAR_IN, 180.0, numerator=1.0, denominator=3.0, master=11, mode=256),
        ),
        ("MC_GearIn Master=S2 RN=1 RD=1 Mode=384", Job(F.GEAR_IN, master=11, mode=384)),
        ("MC_TouchProbe Channel=7", Job(F.TOUCH_PROBE, master=7, mode=2)),
        ("MC_TouchProbe Channel513 Mode1", Job(F.TOUCH_PROBE, master=513, mode=1)),
        ("MC_GearOut", Job(F.GEAR_OUT)),
        ("MC_Phasing Master=X PhaseShift=25 Velocity=1000", Job(F.PHASING, 0.0025, 1.0, master=1)),
    ],
)  # fmt: skip
def test_a_job_in_internal_units(text: str, expected: Job) -> None:
    found = job(f"P1=50\nG70\nB[{text}]")  # metric also where inch is selected
    assert found.position == pytest.approx(expected.position)
    assert found.velocity == pytest.approx(expected.velocity)
    assert replace(found, position=0.0, velocity=0.0) == replace(expected, position=0.0, velocity=0.0)


@pytest.mark.spec("chan.plcopen")
def test_p_chan_00182_takes_mm_and_degrees_per_second() -> None:
    text = "B[MC_MoveAbsolute Position=90 Velocity=45.5 Acceleration=500 Jerk=20000 Direction=1]"
    assert job(text, UNITS) == Job(F.MOVE_ABSOLUTE, 90.0, 45.5, 500.0, None, 20_000.0, Direction.POSITIVE)


@pytest.mark.spec("isg.plcopen.sync", "chan.plcopen")
def test_the_path_waits_at_the_end_of_the_block_and_by_id() -> None:
    text = (
        "N10 S2[MC_MoveVelocity Id200 Velocity=10 Direction=1] X10 F100 G01 B [ MC_Stop WAIT_SYN ]\n"
        "N20 B[MC_Home Id=5]\nN30 #WAIT MC_STATUS SYN [ID200 ID=5]"
    )
    run = decode(f"%T\n{text}\nM30\n", SETUP)
    assert run.problem is None
    shown = [
        (block.axis, block.id, block.waits) if isinstance(block, AxisJob) else getattr(block, "id", "line")
        for block in run.blocks
        if isinstance(block, AxisJob | AxisJobWait | Line)
    ]
    assert shown == [(6, 200, False), (4, -1, True), "line", -1, (4, 5, False), 200, 5]


@pytest.mark.spec("isg.plcopen.sync", "chan.plcopen")
def test_p_chan_00359_waits_behind_every_block_with_jobs() -> None:
    run = decode("%T\nB[MC_Stop]\nG01 X1 F100\nM30\n", IMPLICIT)
    kinds = [type(block) for block in run.blocks if isinstance(block, AxisJob | AxisJobWait)]
    assert kinds == [AxisJob, AxisJobWait]


@pytest.mark.spec("isg.plcopen.command-syntax")
def test_a_job_goes_on_in_the_next_line_and_is_written_in_any_case() -> None:
    assert job("b[mc_moverelative distance10000 velocity=2000]") == Job(F.MOVE_RELATIVE, 1.0, 2.0)
    assert job("B[MC_MoveRelative Distance=10000 \\\n Velocity=2000]") == Job(F.MOVE_RELATIVE, 1.0, 2.0)


def test_quoted_texts_hold_no_jobs() -> None:
    assert not jobs('#MSG ["B[MC_Stop]"]')


@pytest.mark.spec("isg.plcopen.command-syntax")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("X[MC_Stop]", J.JOB_PATH_AXIS),
        ("S[MC_Stop]", J.JOB_OF_SPINDLE),
        ("C[MC_Stop]", J.JOB_NO_AXIS),
        ("B[MC_Halt]", J.JOB_FUNCTION),
        ("B[MC_Stop", T.BRACKET_OPEN),
        ("B[MC_Stop Position=1]", C.KEY_UNKNOWN),
        ("B[MC_MoveAbsolute Position=1 Velocity=1]", C.KEY_MISSING),
        ("B[MC_MoveAbsolute Position=1 Position=2 Velocity=1 Direction=1]", C.KEY_TWICE),
        ("B[MC_MoveAbsolute Position=1 Velocity=1 Direction=5]", J.JOB_INPUT),
        ("B[MC_MoveAbsolute Position=1 Velocity=1 Direction=1.5]", J.JOB_INPUT),
        ("B[MC_MoveAbsolute Position=2147483647*2 Velocity=1 Direction=1]", J.JOB_INPUT),
        ("B[MC_MoveVelocity Velocity=1 Direction=2]", J.JOB_INPUT),
        ("B[MC_MoveRelative Distance=1 Velocity=0]", J.JOB_INPUT),
        ("B[MC_MoveRelative Distance=1 Velocity=-1]", J.JOB_INPUT),
        ("B[MC_Stop Id=-1]", J.JOB_INPUT),
        ("B[MC_Stop Id=1.5]", J.JOB_INPUT),
        ("B[MC_GearIn Master=12 RN=1 RD=1 Mode=0]", J.JOB_INPUT),
        ("B[MC_GearIn Master=B RN=1 RD=1 Mode=0]", J.JOB_INPUT),
        ("B[MC_GearIn Master=X RN=1 RD=0 Mode=0]", J.JOB_INPUT),
        ("B[MC_GearIn Master=X RN=1 RatioNumerator=1 RD=1 Mode=0]", J.JOB_RATIO),
        ("B[MC_GearIn Master=X RN=1 Mode=0]", J.JOB_RATIO),
        ("B[MC_GearIn Master=X RN=1 RD=1 Mode=64]", J.JOB_INPUT),
        ("B[MC_GearIn Master=X RN=1 RD=1 Mode=0 PhaseShift=1]", J.JOB_INPUT),
        ("B[MC_TouchProbe Channel=0]", J.JOB_INPUT),
        ("B[MC_TouchProbe Channel=515]", J.JOB_INPUT),
        ("B[MC_TouchProbe Channel=1 Mode=3]", J.JOB_INPUT),
        ("B[MC_TouchProbe Mode=1]", C.KEY_MISSING),
        ("#WAIT MC_STATUS SYN [ID=3]", J.JOB_ID),
        ("B[MC_Stop Id=3]\n#WAIT MC_STATUS [ID=3]", C.KEY_MISSING),
        ("#WAIT MC_STATUS SYN", C.KEY_MISSING),
    ],
)
def test_what_is_refused(text: str, entry: ErrorEntry) -> None:
    found = problems(f"%T\n{text}\nM30\n", SETUP)
    assert [problem.entry for problem in found] == [entry]
    assert found[0].place.line >= 2
