"""Drilling cycles in programs (manual lines 4977–5831): what the data mean, what holds how long, what is refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import (
    Block,
    BlockEnd,
    Dwell,
    DynamicsChange,
    ExactStop,
    Flush,
    Line,
    SpindleRole,
    SpindleSection,
    SpindleTurn,
    Stop,
    Suppression,
    Technology,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.decoder.nct import decoder as nct_decoder
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.start import begin_program
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.nct.macro_programs import SETUP, Run, decode, with_parameters

spec = pytest.mark.spec
ORIENT = with_parameters(orient1=True)


def told(block: Block) -> str:
    """A block in short: r rapid, f feed, with what has moved; M functions; p dwell; | step; X exact stop; ! suppression."""
    match block:
        case Line():
            moved = [
                f"{name}{end:g}"
                for name, start, end in zip("XYZ", block.start, block.end, strict=True)
                if abs(end - start) > 1e-9
            ]
            return ("r" if block.rapid else f"f{block.feed:g}:") + ",".join(moved)
        case TechnologyFunction():
            letter = "M" if block.kind in (Technology.M, Technology.S) and block.number else block.kind.name
            return f"{letter}{block.number or block.value:g}"
        case Dwell():
            return f"p{block.seconds:g}"
        case BlockEnd():
            return "|"
        case ExactStop():
            return "X"
        case Suppression():
            return "!on" if block.feed_stop and block.override else "!off"
        case Stop():
            return block.kind.value
    return "?"


def drilled(text: str, setup: DecoderSetup = SETUP) -> str:
    run = decode(f"{text}\nM30", setup)
    assert run.problem is None, run.problem
    return short(run)


def short(run: Run) -> str:
    unseen = (Wait, SpindleSection, SpindleTurn, DynamicsChange, Flush)
    return " ".join(told(block) for block in run.blocks if not isinstance(block, unseen)).removesuffix(" M30")


BEGIN = "G90 G17 G0 Z100\nM3 S500\n"
HEAD = "rZ100 | M3 "


def after(text: str, setup: DecoderSetup = SETUP) -> str:
    whole = drilled(BEGIN + text, setup)
    assert whole.startswith(HEAD)
    return whole.removeprefix(HEAD)


# ---------------------------------------------------------------------------------------------------- the frame


@spec("nct.cycle.framework", "nct.cycle.drill-g81", "nct.cycle.return-level-g98-g99")
def test_the_operations_of_a_hole() -> None:
    assert after("G81 X10 Y20 Z-5 R3 F100") == "rX10,Y20 | rZ3 | f100:Z-5 rZ100 |"
    assert after("G99 G81 X10 Y20 Z-5 R3 F100\nX30\nG98 X40") == (
        "rX10,Y20 | rZ3 | f100:Z-5 rZ3 | rX30 | | f100:Z-5 rZ3 | rX40 | | f100:Z-5 rZ100 |"
    )


@spec("nct.cycle.framework")
@pytest.mark.parametrize(
    ("plane", "words", "result"),
    [
        ("G18", "Z10 X20 Y-5 R3", "rX20,Z10 | rY3 | f100:Y-5 rY0 |"),
        ("G19", "Y10 Z20 X-5 R3", "rY10,Z20 | rX3 | f100:X-5 rX0 |"),
    ],
)
def test_the_plane_chooses_the_drilling_axis(plane: str, words: str, result: str) -> None:
    assert drilled(f"{plane} G90 G81 {words} F100") == result


@spec("nct.cycle.framework")
def test_the_initial_point_is_that_of_the_first_block() -> None:
    """Lines 5045–5052: the initial point stays Z 200."""
    assert drilled("G17 G90 G0 Z200\nG81 X0 Y0 Z50 R150 F100\nX100 Y30 Z80") == (
        "rZ200 | | rZ150 | f100:Z50 rZ200 | rX100,Y30 | rZ150 | f100:Z80 rZ200 |"
    )


@spec("nct.cycle.framework")
def test_another_drilling_axis_needs_r() -> None:
    setup = DecoderSetup(axes=("X", "Y", "Z", "W"), linear=(True,) * 4)
    begin = "G17 G90 G0 Z200 W50\nG81 X1 Y0 Z50 R150 F100\n"
    run = decode(f"{begin}X100 W20 R25\nM30", setup, start=(0.0,) * 4)
    assert run.problem is None
    assert [end[2:] for end in run.ends[5:]] == [(200.0, 50.0), (200.0, 25.0), (200.0, 20.0), (200.0, 50.0)]
    run = decode(f"{begin}X100 W20\nM30", setup, start=(0.0,) * 4)
    assert run.place == (catalogue.NO_BOTTOM_OR_R, 3, 1)


# ---------------------------------------------------------------------------------------------------- data


@spec("nct.cycle.modal-data")
def test_r_counts_from_the_initial_point_and_z_from_r() -> None:
    assert after("G91 G81 X10 Z-40 R-97 F50") == "rX10 | rZ3 | f50:Z-37 rZ100 |"
    assert after("G81 X10 ZI-40 RI-97 F50") == "rX10 | rZ3 | f50:Z-37 rZ100 |"


@spec("nct.cycle.modal-data")
def test_data_stay_from_cycle_to_cycle() -> None:
    assert after("G82 X1 Z-5 R3 P0.5 F100\nX2\nG81 X3\nG82 X4 Z-6") == (
        "rX1 | rZ3 | f100:Z-5 p0.5 rZ100 | rX2 | rZ3 | f100:Z-5 p0.5 rZ100 | "
        "rX3 | rZ3 | f100:Z-5 rZ100 | rX4 | rZ3 | f100:Z-6 p0.5 rZ100 |"
    )


@spec("nct.cycle.modal-data", "nct.cycle.cancel-g80")
@pytest.mark.parametrize("end", ["G80", "G0 X0", "G1 X0", "G80 M8"])
def test_the_end_deletes_the_data_but_not_feed_and_speed(end: str) -> None:
    run = decode(f"{BEGIN}G81 X1 Z-5 R3 F100\n{end}\nG85 X2 Z-7\nM30")
    assert run.place == (catalogue.NO_BOTTOM_OR_R, 5, 1)
    assert after(f"G81 X1 Z-5 R3 F100\n{end}\nG85 X2 Z-7 R4").endswith("rX2 | rZ4 | f100:Z-7 f100:Z4 rZ100 |")


@spec("nct.cycle.return-level-g98-g99")
def test_the_end_brings_back_the_initial_point() -> None:
    assert after("G99 G81 X1 Z-5 R3 F100\nG80\nG0 Z90\nG81 X2 Z-6 R4").endswith("rX2 | rZ4 | f100:Z-6 rZ90 |")


@spec("nct.cycle.cancel-g80")
def test_axis_words_beside_g80_move_by_the_path_condition() -> None:
    assert after("G1 X1 F200\nG81 X1 Z-5 R3\nG80 X7").endswith("f200:Z-5 rZ100 | f200:X7 |")


@spec("nct.cycle.repetition-l")
def test_repetition() -> None:
    """Lines 5152–5165: five holes 100 mm apart; with absolute words all at one place."""
    run = decode("G90 G17 G0 X0 Y0 Z100 M3 S100\nG91 G81 X100 Z-40 R-97 F50 L5\nM30")
    assert [end[0] for end in run.ends[1:] if end[2] == -37.0] == [100.0, 200.0, 300.0, 400.0, 500.0]
    run = decode(f"{BEGIN}G81 X10 Z-5 R3 F100 L2\nM30")
    assert short(run).removeprefix(HEAD) == "rX10 | rZ3 | f100:Z-5 rZ100 | | rZ3 | f100:Z-5 rZ100 |"


@spec("nct.cycle.repetition-l")
def test_l_counts_in_its_block_only_and_0_stores() -> None:
    assert after("G81 X10 Z-5 R3 F100 L0\nX20") == "rX20 | rZ3 | f100:Z-5 rZ100 |"
    assert after("G91 G81 X10 Z-5 R-97 F100 L2\nX1").count("f100") == 3


# ---------------------------------------------------------------------------------------------------- each cycle

CYCLES = {
    "G82 X1 Z-5 R3 P2 F100": "rX1 | rZ3 | f100:Z-5 p2 rZ100 |",
    "G73 X1 Z-5 R3 Q3 E1 F100": "rX1 | rZ3 | f100:Z0 rZ1 f100:Z-3 rZ-2 f100:Z-5 rZ100 |",
    "G83 X1 Z-5 R3 Q3 E1 F100": "rX1 | rZ3 | f100:Z0 rZ3 rZ1 f100:Z-3 rZ3 rZ-2 f100:Z-5 rZ100 |",
    "G84 X1 Z-5 R3 F100": "rX1 | rZ3 | X !on f100:Z-5 M4 f100:Z3 !off M3 rZ100 |",
    "G85 X1 Z-5 R3 F100": "rX1 | rZ3 | f100:Z-5 f100:Z3 rZ100 |",
    "G86 X1 Z-5 R3 F100": "rX1 | rZ3 | f100:Z-5 M5 rZ100 M3 |",
    "G89 X1 Z-5 R3 P2 F100": "rX1 | rZ3 | f100:Z-5 p2 f100:Z3 rZ100 |",
}
SPECS = {
    82: "counter-bore-g82", 73: "high-speed-peck-g73", 83: "peck-g83", 84: "tapping-g84", 85: "boring-g85", 86: "boring-g86",
    89: "boring-g89",
}  # fmt: skip


@pytest.mark.parametrize(
    "block", [pytest.param(b, marks=spec(f"nct.cycle.{SPECS[int(b[1:3])]}"), id=b[:3]) for b in CYCLES]
)
def test_a_cycle_to_the_initial_point_and_to_r(block: str) -> None:
    assert after(block) == CYCLES[block]
    if block.startswith(("G84", "G85", "G89")):  # they come to R with feed
        assert after(f"G99 {block}") == CYCLES[block].replace(" rZ100", "")
    else:
        assert after(f"G99 {block}") == CYCLES[block].replace("rZ100", "rZ3")


@spec("nct.cycle.peck-g83", "nct.cycle.high-speed-peck-g73")
def test_retraction_and_clearance_of_the_channel() -> None:
    setup = with_parameters(retg73=0.5, cleg83=2.0)
    assert "f100:Z0 rZ0.5 f100:Z-3 rZ-2.5" in after("G73 X1 Z-5 R3 Q3 F100", setup)
    assert "f100:Z0 rZ3 rZ2 f100:Z-3 rZ3 rZ-1" in after("G83 X1 Z-5 R3 Q3 F100", setup)


@spec("nct.cycle.tapping-g84")
def test_tapping_dwells_only_if_the_machine_says_so() -> None:
    assert "p" not in after("G84 X1 Z-5 R3 P1 F100")
    setup = with_parameters(tapdwell=True)
    assert after("G84 X1 Z-5 R3 P1 F100", setup) == "rX1 | rZ3 | X !on f100:Z-5 p1 M4 f100:Z3 !off M3 rZ100 |"


@spec("nct.cycle.tapping-g84")
def test_the_feed_of_a_thread_is_pitch_times_speed_or_the_pitch() -> None:
    assert "f750:Z-5" in after("G84 X1 Z-5 R3 F750")  # 1.5 mm at 500 rev/min
    assert "f750:Z-5" in after("G95 G84 X1 Z-5 R3 F1.5")


@spec("nct.cycle.counter-tapping-g74")
def test_counter_tapping() -> None:
    assert drilled("G90 G0 Z100\nM4 S500\nG74 X1 Z-5 R3 F100") == (
        "rZ100 | M4 rX1 | rZ3 | X !on f100:Z-5 M3 f100:Z3 !off M4 rZ100 |"
    )


RIGID = with_parameters(index1=True)


@spec("nct.cycle.rigid-tapping-g84-2-g84-3")
@pytest.mark.parametrize(
    ("cycle", "feed", "turn"), [("G84.2", "F750", 240.0), ("G84.3", "F750", -240.0), ("G95 G84.2", "F1.5", 240.0)]
)
def test_rigid_tapping(cycle: str, feed: str, turn: float) -> None:
    """1.5 mm at 500 rev/min: 240 degrees per mm into the hole, and as much back out of it; then the spindle stands."""
    run = decode(f"G90 G0 Z100\nS500\n{cycle} X1 Z-5 R3 {feed}\nM30", RIGID)
    assert run.problem is None
    assert short(run) == "rZ100 | S500 rX1 | rZ3 | M19 f750:Z-5 f750:Z3 M5 rZ100 |"
    assert [block.per_mm for block in run.blocks if isinstance(block, SpindleTurn)] == [turn, -turn]
    roles = [block.role for block in run.blocks if isinstance(block, SpindleSection)]
    assert roles == [SpindleRole.TAPPING, SpindleRole.FREE]


@spec("nct.cycle.fine-boring-g76")
def test_fine_boring() -> None:
    assert after("G76 X1 I0.5 J-1 Z-5 R3 P1 F100\nX2", ORIENT).startswith(
        "rX1 | rZ3 | f100:Z-5 p1 M19 rX1.5,Y-1 rZ100 rX1,Y0 M3 | rX2 |"
    )


@spec("nct.cycle.back-boring-g87b")
def test_back_boring() -> None:
    assert after("G87 X1 I0.5 Z-5 R-30 F100", ORIENT) == (
        "rX1 | M19 rX1.5 rZ-30 | rX1 M3 f100:Z-5 M19 rX1.5 rZ100 rX1 M3 |"
    )


ERRORS: list[tuple[str, DecoderSetup, ErrorEntry, int]] = [
    ("G81 X1 R3 F100", SETUP, catalogue.NO_BOTTOM_OR_R, 1),
    ("G81 X1 Z-5 F100", SETUP, catalogue.NO_BOTTOM_OR_R, 1),
    ("G81 X1 Z-5 R3", SETUP, language.FEED_MISSING, 5),
    ("G83 X1 Z-5 R3 F100", SETUP, catalogue.CUT_MISSING, 1),
    ("G83 X1 Z-5 R3 Q-1 F100", SETUP, catalogue.CUT_NEGATIVE, 15),
    ("G73 X1 Z-5 R3 Q0 F100", SETUP, catalogue.CUT_NEGATIVE, 15),
    ("G73 X1 Z-5 R3 Q1 E-1 F100", SETUP, catalogue.CUT_NEGATIVE, 18),
    ("G83 X1 Z-5000 R3 Q0.001 F100", SETUP, catalogue.TOO_MANY_CUTS, 1),
    ("G74 X1 Z-5 R3 F100", SETUP, catalogue.SPINDLE_STANDS, 1),
    ("M5 G84 X1 Z-5 R3 F100", SETUP, catalogue.SPINDLE_STANDS, 1),
    ("G84.2 X1 Z-5 R3 F100", SETUP, catalogue.NOT_RIGID, 1),
    ("G84.3 X1 Z-5 R3 F100 S0", with_parameters(index1=True), catalogue.SPEED_MISSING, 1),
    ("G76 X1 Z-5 R3 F100", SETUP, catalogue.NO_ORIENTATION, 1),
    ("G76 X1 K1 Z-5 R3 F100", ORIENT, catalogue.SHIFT_LETTER, 8),
    ("G87 X1 Z-5 R-30 F100", ORIENT, catalogue.SHIFT_MISSING, 1),
    ("G87 X1 I1 Z-5 R3 F100", ORIENT, catalogue.BACK_BORING_LEVELS, 1),
]


@spec("nct.cycle.framework", "nct.cycle.drill-g81", "nct.cycle.modal-data", "nct.cycle.fine-boring-g76")
@pytest.mark.parametrize(("block", "setup", "entry", "column"), ERRORS, ids=[block for block, *_ in ERRORS])
def test_what_is_refused_moves_nothing(block: str, setup: DecoderSetup, entry: ErrorEntry, column: int) -> None:
    run = decode(f"{BEGIN}{block}\nM30", setup)
    assert run.place == (entry, 3, column)
    assert len(run.ends) == 1


def test_two_drilling_axes_and_none() -> None:
    four = DecoderSetup(axes=("X", "Y", "Z", "W"), linear=(True,) * 4)
    run = decode("G81 X1 Z-5 W3 R3 F100\nM30", four, start=(0.0,) * 4)
    assert run.place == (catalogue.TWO_DRILLING_AXES, 1, 12)
    two = DecoderSetup(axes=("X", "Y"), linear=(True,) * 2)
    run = decode("G81 X1 R3 F100\nM30", two, start=(0.0,) * 2)
    assert run.place == (catalogue.NO_DRILLING_AXIS, 1, 1)


def test_no_cycle_with_cutter_compensation(monkeypatch: pytest.MonkeyPatch) -> None:
    def compensated(x: NctExecution) -> None:
        begin_program(x)
        x.modal.compensation_side = 1

    monkeypatch.setattr(nct_decoder, "begin_program", compensated)
    assert decode("G81 X1 Z-5 R3 F100\nM30").place == (catalogue.CYCLE_COMPENSATED, 1, 1)


# ---------------------------------------------------------------------------------------------------- beside other words


@spec("nct.cycle.interaction-rules")
def test_which_blocks_drill() -> None:
    """The example in lines 5805–5820."""
    text = "G82 X1 Z-5 R3 P2 F100\nX2\nF200\nM8\nG4 P7\nI1 Q2 P9\nX3"
    assert after(text) == (
        "rX1 | rZ3 | f100:Z-5 p2 rZ100 | rX2 | rZ3 | f100:Z-5 p2 rZ100 | M8 p7 | rX3 | rZ3 | f200:Z-5 p2 rZ100 |"
    )


@spec("nct.cycle.interaction-rules")
@pytest.mark.parametrize("word", ["X1", "Y1", "Z-5", "R3"])
def test_an_axis_word_or_r_drills(word: str) -> None:
    assert after(f"G81 X9 Z-5 R3 F100\n{word}").count("f100:Z-5") == 2


@spec("nct.cycle.interaction-rules")
@pytest.mark.parametrize("block", ["G10 L10 P1 R50", "M98 P2 L1", "G65 P2 X7", "G4 P1", "#1=5"])
def test_words_of_other_codes_drill_nothing_and_are_not_stored(block: str) -> None:
    text = f"{BEGIN}G82 X1 Z-5 R3 P2 F100\n{block}\nX3\nM30\nO0002\nM99"
    run = decode(f"O0001\n{text}", SETUP)
    assert run.problem is None
    hole = "| rZ3 | f100:Z-5 p2 rZ100 |"
    dwell = " p1 |" if block == "G4 P1" else ""
    assert short(run).removeprefix(HEAD) == f"rX1 {hole}{dwell} rX3 {hole}"


@spec("nct.cycle.interaction-rules")
def test_a_hole_in_the_block_of_a_call() -> None:
    run = decode(f"O0001\n{BEGIN}G82 X1 Z-5 R3 P0.5 F100\nX3 M98 P2 L2\nM30\nO0002\nX4\nM99", SETUP)
    assert run.problem is None
    holes = [f"rX{x} | rZ3 | f100:Z-5 p0.5 rZ100 |" for x in (1, 3, 4)]
    assert short(run).removeprefix(HEAD) == " ".join((*holes, "| rZ3 | f100:Z-5 p0.5 rZ100 |"))


@spec("nct.cycle.interaction-rules")
def test_functions_come_behind_the_positioning_of_the_first_hole() -> None:
    assert after("G91 G81 X1 Z-5 R-97 F100 M8 T7 L2") == (
        "rX1 T7 M8 | rZ3 | f100:Z-2 rZ100 | rX2 | rZ3 | f100:Z-2 rZ100 |"
    )


@spec("nct.cycle.interaction-rules", "nct.cycle.tapping-g84")
def test_the_spindle_may_be_started_in_the_block_of_the_cycle() -> None:
    assert drilled("G90 G0 Z100\nG84 X1 Z-5 R3 F100 M3 S500").startswith("rZ100 | rX1 M3 | rZ3 |")


@spec("nct.cycle.interaction-rules")
def test_a_tool_length_acts_on_the_drilling_axis_in_the_move_to_r() -> None:
    """H1 is 50 mm: X and Y know nothing of it; the tool tip comes back to the height that it had."""
    length = "G10 L10 P1 R50\nG10 L10 P2 R70\n"
    assert drilled(f"{length}{BEGIN}G43 H1 G81 X10 Z-5 R3 F100").removeprefix(HEAD) == (
        "rX10 | rZ53 | f100:Z45 rZ150 |"
    )
    assert drilled(f"{length}{BEGIN}G81 X10 Z-5 R3 F100\nG43 H2 X20\nG49 X30").removeprefix(HEAD) == (
        "rX10 | rZ3 | f100:Z-5 rZ100 | rX20 | rZ73 | f100:Z65 rZ170 | rX30 | rZ3 | f100:Z-5 rZ100 |"
    )


@spec("nct.cycle.interaction-rules")
def test_tool_offset_is_not_carried_out_in_cycles() -> None:
    assert drilled(f"G10 L12 P1 R5\nD1\n{BEGIN}G81 X10 Z-5 R3 F100\nG45 X20").endswith("rX20 | rZ3 | f100:Z-5 rZ100 |")


@spec("nct.cycle.modal-data")
def test_mirror_and_scale_act_on_r_and_z_but_not_on_q() -> None:
    assert drilled("G90 G0 Z10\nG51 X0 Y0 Z0 P2\nG73 X5 Z-5 R1 Q6 E1 F100") == (
        "rZ10 | rX10 | rZ2 | f100:Z-4 rZ-3 f100:Z-10 rZ10 |"
    )
    assert drilled("G90 G0 Z-10\nG51.1 Z0\nG73 X5 Z-8 R1 Q6 E1 F100") == (
        "rZ-10 | rX5 | rZ-1 | f100:Z5 rZ4 f100:Z8 rZ-10 |"
    )


@spec("nct.cycle.modal-data")
def test_holes_are_placed_in_the_turned_system() -> None:
    run = decode("G90 G0 Z10\nG68 X0 Y0 R90\nG81 X5 Y0 Z-5 R1 F100\nM30")
    assert run.problem is None
    assert run.ends[1] == (0.0, 5.0, 10.0)


@spec("nct.cycle.modal-data")
def test_another_work_system_moves_r_and_z_and_leaves_the_initial_point() -> None:
    setup = replace(SETUP, zero_offsets={55: np.array([0.0, 0.0, 7.0])})
    assert drilled(f"{BEGIN}G81 X1 Z-5 R3 F100\nG55 X2", setup).endswith("rX2 | rZ10 | f100:Z2 rZ100 |")
