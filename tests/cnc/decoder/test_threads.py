"""Threads and tapping as words: what is handed over, what is modal, what is refused where."""

from __future__ import annotations

from dataclasses import replace

import pytest

from runtime.cnc.blocks import DynamicsChange, Flush, Line, SpindleRole, SpindleSection, SpindleTurn
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.decoder.setup import AxisDynamics, SpindleSetup
from runtime.diagnostics.catalogue import radius
from runtime.diagnostics.catalogue import spindle as S  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import technology as T  # noqa: N812
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import decode, found, without_spindle
from tests.cnc.decoder.test_spindles import SETUP as SPINDLES

FIRST = replace(SPINDLES.spindles[0], dynamics=AxisDynamics(36_000.0, 60_000.0, 600_000.0))
SETUP = replace(SPINDLES, spindles=(FIRST, *SPINDLES.spindles[1:]), axis_velocity=(200.0, 200.0, 100.0))
THREAD, G63, G331 = "isg.turn.thread-g33", "isg.spdl.tapping-g63", "isg.spdl.tapping-g331-g332"


def shown(text: str, setup: DecoderSetup = SETUP) -> list[str]:
    """Sections, turns (degrees per mm) and feeds (mm/min) of a program."""
    run = decode(text, setup)
    assert run.problem is None, run.problem
    told = []
    for block in run.blocks:
        if isinstance(block, SpindleSection):
            told.append(f"{block.role.name} {block.angle:g}" if block.role is SpindleRole.THREAD else block.role.name)
        elif isinstance(block, SpindleTurn):
            told.append(f"turn {block.per_mm:g}")
        elif isinstance(block, Line):
            told.append(f"F{block.feed:g}")
        elif isinstance(block, Flush):
            told.append("stop")
    return told


@pytest.mark.spec(THREAD)
def test_pitch_and_offset_are_modal_and_every_block_is_a_thread() -> None:
    text = "M3 S400\nG33 Z-10 K1.5\nG00 Z0\nG33 Z-10\nG33 Z0 S.OFFSET=180\nZ-20 K2\nG01 F100 Z0\nM30"
    assert shown(text) == [
        "stop", "THREAD 0", "turn 240", "F600", "FREE",
        "stop", "THREAD 0", "turn 240", "F600", "FREE",
        "stop", "THREAD 180", "turn 240", "F600", "FREE",
        "stop", "THREAD 180", "turn 180", "F800", "FREE",
    ]  # fmt: skip


@pytest.mark.spec(THREAD)
def test_the_letter_says_along_which_axis_the_pitch_counts() -> None:
    # 30 and 40 mm are 50 mm of path: 1 mm along Z are 1.25 mm of path
    assert shown("M3 S100\nG33 X30 Z-40 K1\nM30") == ["stop", "THREAD 0", "turn 288", "F125", "FREE"]
    assert shown("M3 S100\nG33 X30 Z-40 I1\nM30")[2] == "turn 216"
    assert shown("M3 S100\nG70\nG33 Z-1 K0.1\nM30")[2] == f"turn {360 / 2.54:g}"


@pytest.mark.spec(THREAD)
def test_a_chain_ends_where_something_else_comes() -> None:
    text = "M3 S100\n#TURN [THREAD_CHAIN=1]\nG33 Z-10 K1\nZ-20 K2\nM10\nZ-30\nM30"
    assert shown(text) == [
        "stop", "THREAD 0", "turn 360", "F100", "turn 180", "F200", "FREE",
        "stop", "THREAD 0", "turn 180", "F200", "FREE",
    ]  # fmt: skip


@pytest.mark.spec(G63)
def test_tapping_by_feed_and_speed() -> None:
    text = "M19 S.POS=0 M3 S100\nG63 Z-50 F250 S200\nZ0 S-200\nG04 1\nZ-10\nG01 F1000 X100\nM30"
    assert shown(text) == [
        "stop", "TAPPING", "turn 288", "F250", "stop", "turn -288", "F250", "stop", "turn -288", "F250", "stop", "FREE", "F1000",
    ]  # fmt: skip


@pytest.mark.spec(G331)
def test_tapping_by_pitch() -> None:
    text = (
        "G331 Z-50 K2 S200\nG332 Z10\nG01 X50\nG331 Z-50 K2 S200\nG332 Z10 K2 S400\nG01 F1000 X0\nG331 Z-50\nG332 Z10\n"
        "G331 X40 I-1.5 S150\nG332 X10\nM30"
    )
    tap, retract = ["turn 180", "F400", "stop"], ["turn -180", "F400", "stop"]
    assert shown(text) == [
        "stop", "TAPPING", *tap, *retract, "FREE", "F400",
        "stop", "TAPPING", *tap, "turn -180", "F800", "stop", "FREE", "F1000",
        "stop", "TAPPING", *tap, *retract, "turn -240", "F225", "stop", "turn 240", "F225", "stop", "FREE",
    ]  # fmt: skip


@pytest.mark.spec(G63, G331)
def test_what_the_spindle_can_limits_the_path() -> None:
    run = decode("G331 Z-50 K2 S200\nM30", SETUP)
    limits = [block.settings.feed.vector for block in run.blocks if isinstance(block, DynamicsChange)]
    assert limits[0].velocity == pytest.approx(36_000.0 / 180.0)
    assert limits[0].acceleration == limits[0].deceleration == pytest.approx(0.7 * 60_000.0 / 180.0)
    assert limits[0].jerk == pytest.approx(0.7 * 600_000.0 / 180.0)
    assert limits[1].unlimited


# text, entry, line, column
ERRORS: list[tuple[str, ErrorEntry, int, int]] = [
    ("M3 S100\nG33 Z-10 K0\nM30", S.THREAD_PITCH, 2, 10),
    ("M3 S100\nG33 Z-10 K-1\nM30", S.THREAD_PITCH, 2, 10),
    ("M3 S100\nG33 Z-10\nM30", S.THREAD_PITCH_MISSING, 2, 5),
    ("M3 S100\nG33 Z-10 I1\nM30", S.PITCH_AXIS, 2, 10),
    ("M3 S100\nG33 Z-10 X1 I1 K1\nM30", S.PITCH_TWICE, 2, 13),
    ("S100\nG33 Z-10 K1\nM30", S.SPINDLE_STANDS, 2, 5),
    ("M3 S100\nM19\nG33 Z-10 K1\nM30", S.SPINDLE_STANDS, 3, 5),
    ("M3 S100\nG63 Z-10 F100\nM30", S.SPINDLE_TURNS, 2, 1),
    ("M3 S3100\nG33 Z-10 K2\nM30", S.TOO_FAST, 2, 5),  # 6200 mm/min, and Z can 6000
    ("G331 Z-10 K0.1 S6001\nM30", S.TOO_FAST, 1, 16),  # 6000 rev/min is what the spindle can
    ("M3 S100\nG33 Z-10 K1 S.OFFSET=360\nM30", S.OFFSET_RANGE, 2, 13),
    ("M3 S100\nG33 Z-10 K1 S2.OFFSET=10\nM30", T.NOT_MAIN_SPINDLE, 2, 13),
    ("S100\nG63 Z-10\nM30", S.TAPPING_ZERO, 2, 1),
    ("F100\nG63 Z-10\nM30", S.TAPPING_ZERO, 2, 1),
    ("G63 Z-10 F100 S0\nM30", S.TAPPING_ZERO, 1, 15),
    ("G331 Z-10 K0 S100\nM30", S.TAPPING_ZERO, 1, 11),
    ("G63 Z-10 F100 S10 M3\nM30", S.TAPPING_SPINDLE, 1, 19),
    ("G63 Z-10 F100 S10\nM19\nM30", S.TAPPING_SPINDLE, 2, 1),
    ("G63 Z-10 F100 S10\nS[M3 REV100]\nM30", S.TAPPING_SPINDLE, 2, 3),
    ("G63 Z-10 F100 S10\nS[G130=50]\nM30", S.TAPPING_SPINDLE, 2, 3),
    ("G95 G63 Z-10 F1 S10\nM30", S.TAPPING_FEED_MODE, 1, 1),
    ("G331 Z-10 K1 S10\nG332 Z0 K2\nM30", S.RETRACT_PITCH, 2, 9),
    ("G332 Z-10 S10\nM30", S.TAPPING_PITCH_MISSING, 1, 1),
    ("G331 Z-10 S10\nM30", S.TAPPING_PITCH_MISSING, 1, 1),
    ("G331 Z-10 X1 K1 S10\nM30", S.PITCH_AXIS, 1, 14),
    ("G331 Z-10 I1 S10\nM30", S.PITCH_AXIS, 1, 11),
    ("M3 S100\nG33 Z-10 K1 #CHR=1\nM30", S.BESIDE, 2, 5),
    ("M3 S100\nG33 Z-10 K1 R2\nM30", S.BESIDE, 2, 5),
    ("G41\nM3 S100\nG33 Z-10 K1\nM30", radius.FORBIDDEN, 3, 5),
    ("#MAIN SPINDLE [S3]\nS100 M3\nG33 Z-10 K1\nM30", S.SPINDLE_NEEDED, 3, 5),
    ("#TURN [THREAD_CUT_N_CYCLES=21]\nM30", S.TURN_VALUE, 1, 28),
    ("#TURN [ROT_FEED_CPL=1]\nM30", S.TURN_VALUE, 1, 21),
    ("#TURN [THREAD_CHAIN=2]\nM30", S.TURN_VALUE, 1, 21),
]  # fmt: skip


@pytest.mark.spec(THREAD, G63, G331)
@pytest.mark.parametrize(("text", "entry", "line", "column"), ERRORS)
def test_errors(text: str, entry: ErrorEntry, line: int, column: int) -> None:
    assert next(iter(found(text, SETUP))) == (entry, line, column)


def test_without_a_spindle_there_is_no_thread() -> None:
    assert next(found("G33 Z-10 K1\nM30", without_spindle()))[0] is S.SPINDLE_NEEDED


def test_a_plain_spindle_is_described_by_its_axis() -> None:
    assert SpindleSetup("S").dynamics.velocity == float("inf")
