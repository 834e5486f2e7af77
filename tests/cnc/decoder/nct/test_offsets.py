"""Coordinate systems and their offsets: programs in, machine positions out. The examples are those of the manual."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.decoder import ChannelMemory
from runtime.cnc.decoder.nct.coordinates import NumberedCoordinates
from runtime.cnc.tools.offset_table import MemoryOffsets, OffsetsOutOfReach, OffsetTableError, SqliteOffsets
from runtime.diagnostics.catalogue import nct, nct_offsets
from runtime.diagnostics.catalogue import offsets as table_errors
from tests.cnc.decoder.nct.programs import SETUP, Run, decode, found
from tests.cnc.decoder.programs import decode as decode_isg

OFFSETS = {
    54: np.array([300.0, 800.0, 0.0]),
    55: np.array([1300.0, 400.0, 0.0]),
    56: np.array([10.0, 20.0, 30.0]),
}
TWO = replace(SETUP, zero_offsets=OFFSETS)
POINTS = replace(SETUP, reference_points=(1.0, 2.0, 300.0), fixed_points=((500.0, 600.0), (510.0, 610.0), (520.0,)))


def numbers(run: Run) -> list[float]:
    """The position as the control shows it."""
    assert run.problem is None, run.problem
    coordinates = run.decoder.execution.coordinates
    assert isinstance(coordinates, NumberedCoordinates)
    return [round(number, 6) + 0.0 for number in coordinates.numbers]


def ends(text: str, setup: object = SETUP, **more: object) -> list[list[float]]:
    run = decode(text, setup, **more)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return [[round(value, 6) + 0.0 for value in end] for end in run.ends]


# ---------------------------------------------------------------------------------------------------- work systems


@pytest.mark.spec("nct.coord.work-g54-g59")
def test_a_program_begins_in_the_first_work_system() -> None:
    assert ends("G0 X1 Y2", TWO) == [[301, 802, 0]]


@pytest.mark.spec("nct.coord.work-g54-g59")
def test_absolute_words_count_in_the_selected_system() -> None:
    assert ends("G56 G90 G0 X60 Y40\nG54 X0", TWO) == [[70, 60, 0], [300, 60, 0]]


@pytest.mark.spec("nct.coord.work-g54-g59")
def test_the_position_is_shown_in_the_new_system_and_nothing_moves() -> None:
    """The example with 700, 500 in the first system, which is -300, 900 in the second."""
    run = decode("G0 X700 Y500\nG55", TWO)
    assert numbers(run)[:2] == [-300, 900]
    assert len(run.ends) == 1
    assert ends("G0 X700 Y500\nG55\nG91 X10", TWO)[-1] == [1010, 1300, 0]


@pytest.mark.spec("nct.coord.work-g54-g59")
@pytest.mark.parametrize("number", range(54, 60))
def test_each_system_has_its_offset(number: int) -> None:
    offsets = {n: np.array([float(n), 0, 0]) for n in range(54, 60)}
    assert ends(f"G{number} G0 X0", replace(SETUP, zero_offsets=offsets)) == [[number, 0, 0]]


@pytest.mark.spec("nct.coord.set-offset-g10-l2")
def test_offsets_are_set_absolute_whatever_g91_says() -> None:
    text = "G91 G10 X5 ZI7 L2 P2\nG90 G55 G0 X0 Y0 Z0"
    assert ends(text, TWO) == [[5, 400, 7]]


@pytest.mark.spec("nct.coord.set-offset-g10-l2", "nct.coord.work-g54-g59")
def test_the_common_offset_is_added_to_every_system() -> None:
    assert ends("G10 X100 L2 P0\nG0 X0 Y0\nG55 X0 Y0", TWO) == [[400, 800, 0], [1400, 400, 0]]


@pytest.mark.spec("nct.coord.set-offset-g10-l2")
def test_the_offset_of_the_active_system_acts_at_once_without_motion() -> None:
    run = decode("G0 X10\nG10 X7 L2 P1", TWO)
    assert numbers(run)[0] == 303
    assert len(run.ends) == 1


@pytest.mark.spec("nct.coord.set-offset-g10-l2")
def test_in_inch() -> None:
    assert ends("G20 G10 X1 L2 P1\nG0 X1")[-1] == [50.8, 0, 0]


@pytest.mark.spec("nct.coord.set-offset-g10-l2")
@pytest.mark.parametrize(
    ("text", "entry", "column"),
    [
        ("G10 X1 L2 P7", nct.FAULTY_P, 11),
        ("G10 X1 L2", nct.FAULTY_P, 1),
        ("G10 L2 P1", nct_offsets.AXIS_WANTED, 1),
        ("G10 X1 L3 P1", nct_offsets.SETTING_UNKNOWN, 8),
        ("G10 X1 P1", nct_offsets.SETTING_UNKNOWN, 1),
        ("G10 X100000 L2 P1", nct.VALUE_EXCESS, 5),
    ],
)
def test_errors_of_g10(text: str, entry: object, column: int) -> None:
    assert found(text) == (entry, 1, column)


@pytest.mark.spec("nct.coord.set-offset-g10-l2")
def test_what_was_set_is_kept_for_programs_of_both_dialects() -> None:
    memory = ChannelMemory(TWO, offsets=MemoryOffsets())
    decode("G10 X5 L2 P1\nM30", TWO, memory=memory)
    assert ends("G0 X0", TWO, memory=memory) == [[5, 0, 0]]
    isg = decode_isg("G54 G00 X0\nV.G.NP[2].V.Y = 3\nM30", TWO, memory=memory)
    assert isg.problem is None
    assert [row["to"]["X"] for row in isg.rows if "to" in row] == [5]  # type: ignore[index]
    assert ends("G55 G0 Y0", TWO, memory=memory) == [[0, 3, 0]]


@pytest.mark.spec("nct.coord.set-offset-g10-l2")
def test_what_was_set_outlives_the_runtime(tmp_path: Path) -> None:
    decode("G10 X5 L2 P1\nG10 Y6 L2 P0", TWO, memory=ChannelMemory(TWO, offsets=SqliteOffsets(tmp_path / "offsets.db")))
    again = ChannelMemory(TWO, offsets=SqliteOffsets(tmp_path / "offsets.db"))
    assert ends("G0 X0 Y0", TWO, memory=again) == [[5, 806, 0]]
    described = replace(TWO, zero_offsets={**OFFSETS, 54: np.array([77.0, 800.0, 0.0])})  # changed on purpose
    fresh = ChannelMemory(described, offsets=SqliteOffsets(tmp_path / "offsets.db"))
    assert ends("G0 X0 Y0", described, memory=fresh) == [[77, 806, 0]]


def test_without_the_table_nothing_moves() -> None:
    error = OffsetTableError(table_errors.TABLE_FAILED, reason="no disk")
    run = decode("G0 X5", memory=ChannelMemory(SETUP, offsets=OffsetsOutOfReach(error)))
    assert run.problem is not None
    assert run.problem.entry is table_errors.TABLE_FAILED
    assert run.ends == []


# ---------------------------------------------------------------------------------------------------- machine system


@pytest.mark.spec("nct.coord.machine-g53")
def test_g53_moves_in_rapid_to_machine_coordinates() -> None:
    run = decode("G1 G91 F100 X10\nG53 X50 YI60\nX1", TWO)
    assert run.ends == [[10, 0, 0], [50, 60, 0], [51, 60, 0]]
    assert [row["rapid"] for row in run.of_type("line")] == [False, True, False]
    assert numbers(run)[:2] == [51 - 300, 60 - 800]


@pytest.mark.spec("nct.coord.machine-g53")
def test_g53_takes_the_tool_length_into_account() -> None:
    memory = ChannelMemory(SETUP)
    assert ends("G10 R25 L10 P1\nG43 Z0 H1\nG53 Z100\nG53 X5", memory=memory)[1:] == [[0, 0, 125], [5, 0, 125]]


# ---------------------------------------------------------------------------------------------------- G92, G52


@pytest.mark.spec("nct.coord.shift-g92")
def test_g92_counts_the_position_anew_in_all_systems() -> None:
    """The example: at 150, 100 the position becomes 90, 60; the shift is 60, 40."""
    run = decode("G0 X150 Y100\nG92 X90 Y60\nX0 Y0\nG55 X0 Y0", TWO)
    assert run.ends == [[450, 900, 0], [360, 840, 0], [1360, 440, 0]]
    assert numbers(decode("G0 X150 Y100\nG91 G92 XI90 Y60"))[:2] == [90, 60]


@pytest.mark.spec("nct.coord.shift-g92", "nct.coord.local-g52")
def test_g92_deletes_the_local_shift_of_its_axes() -> None:
    """The example: 200, 120 in the work system is 140, 80 in the local one, and becomes 110, 40."""
    run = decode("G0 X200 Y120\nG52 X60 Y40\nG92 X110 Y40")
    assert numbers(run)[:2] == [110, 40]
    assert run.decoder.execution.coordinates.local == [0, 0, 0]
    other = decode("G0 X200 Y120\nG52 X60 Y40\nG92 X110")
    assert numbers(other)[:2] == [110, 80]


@pytest.mark.spec("nct.coord.shift-g92")
def test_g92_is_gone_with_the_program() -> None:
    memory = ChannelMemory(SETUP)
    decode("G0 X10\nG92 X0\nM30", memory=memory)
    assert ends("G0 X5", memory=memory) == [[5, 0, 0]]


@pytest.mark.spec("nct.coord.shift-g92")
def test_g92_counts_the_tip_where_a_length_holds() -> None:
    assert ends("G10 R25 L10 P1\nG43 Z0 H1\nG92 Z100\nZ110")[-1] == [0, 0, 35]


@pytest.mark.spec("nct.coord.local-g52")
def test_g52_shifts_the_origin() -> None:
    """The example: at 150, 100 the local system of 60, 40 shows 90, 60; then of 30, 60."""
    assert numbers(decode("G0 X150 Y100\nG90 G52 X60 Y40"))[:2] == [90, 60]
    absolute = decode("G0 X150 Y100\nG90 G52 X60 Y40\nG52 X30 Y60")
    relative = decode("G0 X150 Y100\nG90 G52 X60 Y40\nG91 G52 X-30 Y20")
    assert numbers(absolute)[:2] == numbers(relative)[:2] == [120, 40]
    assert ends("G52 X60 Y40\nG0 X0 Y0\nG55 X0 Y0\nG52 X0\nX0", TWO) == [[360, 840, 0], [1360, 440, 0], [1300, 440, 0]]


@pytest.mark.spec("nct.coord.local-g52")
def test_g52_is_gone_with_the_program() -> None:
    memory = ChannelMemory(SETUP)
    decode("G52 X10\nM02", memory=memory)
    assert ends("G0 X5", memory=memory) == [[5, 0, 0]]


@pytest.mark.parametrize("word", ["G92", "G52"])
def test_they_need_an_axis(word: str) -> None:
    assert found(f"N1 {word}") == (nct_offsets.AXIS_WANTED, 1, 4)


# ---------------------------------------------------------------------------------------------------- reference points


@pytest.mark.spec("nct.ref.return-g28")
def test_g28_goes_over_the_point_to_the_reference_point() -> None:
    run = decode("G1 F100 X5 Y5\nG28 X10 Z20\nX0", POINTS)
    assert run.ends == [[5, 5, 0], [10, 5, 20], [1, 5, 300], [0, 5, 300]]
    assert [row["rapid"] for row in run.of_type("line")] == [False, True, True, False]


@pytest.mark.spec("nct.ref.return-g28", "nct.ref.return-from-g29")
def test_points_are_remembered_by_axis() -> None:
    """X from the first G28, Y from the second; an axis that had none goes over 0."""
    run = decode("G28 X100\nG28 Y200\nG29 X7 Y8 Z9", POINTS)
    assert run.ends[-2:] == [[100, 200, 0], [7, 8, 9]]
    memory = ChannelMemory(POINTS)
    decode("G28 X100\nM30", POINTS, memory=memory)
    assert ends("G29 X7", POINTS, memory=memory) == [[100, 0, 0], [7, 0, 0]]


@pytest.mark.spec("nct.ref.return-from-g29")
def test_the_point_counts_in_the_system_that_holds_now() -> None:
    text = "G28 X10\nG55\nG29 X20\nG91 G29 X5"
    assert ends(text, replace(POINTS, zero_offsets=OFFSETS))[2:] == [
        [1310, 0, 0],
        [1320, 0, 0],
        [1310, 0, 0],
        [1315, 0, 0],
    ]


@pytest.mark.spec("nct.ref.return-g28")
def test_incremental_points() -> None:
    assert ends("G0 Z50\nG91 G28 Z5", POINTS)[1:] == [[0, 0, 55], [0, 0, 300]]


@pytest.mark.spec("nct.ref.return-g30", "nct.ref.return-from-g29")
def test_g30_goes_to_four_points() -> None:
    assert ends("G30 P1 X5", POINTS) == [[5, 0, 0], [1, 0, 0]]
    assert ends("G30 P2 X5 Y6", POINTS) == [[5, 6, 0], [500, 510, 0]]
    assert ends("G30 P3 X5\nG29 X9", POINTS) == [[5, 0, 0], [600, 0, 0], [5, 0, 0], [9, 0, 0]]


@pytest.mark.spec("nct.ref.return-g30")
def test_the_length_counts_on_the_way_to_the_point_only() -> None:
    text = "G10 R25 L10 P1\nG43 Z0 H1\nG30 P2 Z100\nG29 Z50"
    assert ends(text, POINTS)[1:] == [[0, 0, 125], [0, 0, 520], [0, 0, 125], [0, 0, 75]]


@pytest.mark.spec("nct.ref.return-g28", "nct.ref.return-g30", "nct.ref.return-from-g29")
@pytest.mark.parametrize(
    ("text", "entry", "column"),
    [
        ("G28", nct_offsets.REFERENCE_FORMAT, 1),
        ("N1 G29", nct_offsets.REFERENCE_FORMAT, 4),
        ("G30 P2", nct_offsets.REFERENCE_FORMAT, 1),
        ("G30 X1", nct_offsets.REFERENCE_FORMAT, 1),
        ("G30 X1 P5", nct_offsets.REFERENCE_FORMAT, 8),
        ("G30 Z1 P3", nct_offsets.FIXED_POINT_MISSING, 5),
    ],
)
def test_errors_of_reference_points(text: str, entry: object, column: int) -> None:
    assert found(text, POINTS) == (entry, 1, column)
