"""G22 and G23: the box is watched before anything moves, and outlives programs and the runtime."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from runtime.cnc.blocks import Block
from runtime.cnc.decoder import ChannelMemory, DecoderSetup
from runtime.cnc.path_preparation import ControlAreas
from runtime.cnc.path_preparation.errors import PathError
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.cnc.tools.offset_table import MemoryOffsets, Register, SqliteOffsets
from runtime.config import load_machine
from runtime.diagnostics.catalogue import nct, nct_offsets
from runtime.diagnostics.errors import ErrorEntry
from runtime.scheduler.simulation import Simulation
from tests.cnc.decoder.nct.programs import SETUP, decode, found
from tests.cnc.tool_radius_comp.paths import motions_of

INSIDE = "G22 X60 Y60 Z50 I40 J40 K-50 P0\n"
OUTSIDE = "G22 X60 Y60 Z50 I-40 J-40 K-50 P1\n"


def driven(
    text: str, memory: ChannelMemory | None = None, setup: DecoderSetup = SETUP
) -> tuple[list[tuple[float, ...]], ErrorEntry | None, int]:
    """The ends of what is driven; the error and its line, if there is one."""
    run = decode(text, setup, memory=memory)
    out: list[Block] = []
    told = run.problem
    try:
        for block in ControlAreas()(ToolRadiusCompensation()(run.blocks)):
            out.append(block)  # noqa: PERF402 - what came before an error counts
    except PathError as error:
        told = error.problem
    ends = [tuple(round(float(place), 6) + 0.0 for place in motion.end) for motion in motions_of(out)]
    return (ends, None, 0) if told is None else (ends, told.entry, told.place.line)


@pytest.mark.parametrize(
    ("move", "good"),
    [
        ("G0 X40 Y50", True),  # to the border
        ("G0 X41 Y50", False),
        ("G0 X100 Y100", False),  # the end is free, the way is not
        ("G0 X100 Y0\nX100 Y100", True),
        ("G0 X50 Y50 Z60", False),
        ("G0 Z51\nX50 Y50", True),
        ("G2 X60 Y0 I30 J0 F1000\n", True),
        ("G3 X100 Y0 I50 J0 F1000\n", True),
        ("G2 X100 Y0 I50 J0 F1000\n", False),  # over 50, 50
    ],
)
def test_the_inside_is_forbidden(move: str, good: bool) -> None:
    _, error, line = driven(INSIDE + move)
    assert (error is None) is good
    if not good:
        assert (error, line) == (nct_offsets.STROKE_ENTERED, 2)


def test_the_outside_is_forbidden() -> None:
    ends, error, line = driven(OUTSIDE + "G0 X60 Y-40\nX61\nX0")
    assert ends == [(60, -40, 0)]
    assert (error, line) == (nct_offsets.STROKE_LEFT, 3)


def test_g23_permits_it() -> None:
    assert driven(INSIDE + "G23\nG0 X50 Y50")[1] is None


def test_numbers_count_in_the_work_system_and_for_the_tip() -> None:
    shifted = replace(SETUP, zero_offsets={54: np.array([10.0, 0.0, 0.0])})
    assert driven(INSIDE + "G0 X39 Y50", setup=shifted)[1] is None
    assert driven(INSIDE + "G0 X41 Y50", setup=shifted)[1] is nct_offsets.STROKE_ENTERED
    offsets = MemoryOffsets({("H", 1): Register(30.0)})
    text = "G43 G0 Z100 H1\n" + INSIDE + "X50 Y50\n"
    assert driven(text + "Z50", ChannelMemory(SETUP, offsets=offsets))[1] is None  # the tip, at 80 of the machine
    assert driven(text + "Z49", ChannelMemory(SETUP, offsets=offsets))[1] is nct_offsets.STROKE_ENTERED


def test_equal_limits_permit_or_forbid_everything() -> None:
    assert driven("G22 X0 Y0 Z0 I0 J0 K0 P0\nG0 X10\nX0")[1] is None
    assert driven("G0 X5\nG22 X0 Y0 Z0 I0 J0 K0 P1\nG0 X10")[1] is nct_offsets.STROKE_OUTSIDE


def test_in_a_forbidden_place_nothing_goes_on() -> None:
    assert driven("G0 X50 Y50\n" + INSIDE + "X0")[1:] == (nct_offsets.STROKE_INSIDE, 2)
    run = decode("G0 X-50\n" + OUTSIDE + "X0")
    assert run.problem is not None
    assert "FORBIDDEN AREA X-" in run.problem.text


def test_it_outlives_programs_and_the_runtime(tmp_path: Path) -> None:
    file = tmp_path / "offsets.db"
    assert driven(INSIDE + "M30", ChannelMemory(SETUP, offsets=SqliteOffsets(file)))[1] is None
    again = ChannelMemory(SETUP, offsets=SqliteOffsets(file))
    assert driven("G0 X50 Y50", again)[1] is nct_offsets.STROKE_ENTERED
    assert driven("G23\nG0 X50 Y50\nM30", again)[1] is None
    assert driven("G0 X50 Y50", ChannelMemory(SETUP, offsets=SqliteOffsets(file)))[1] is None


@pytest.mark.parametrize(
    ("text", "entry", "column"),
    [
        ("G22 X1 Y1 Z1 I0 J0 P0", nct_offsets.REFERENCE_FORMAT, 1),
        ("G22 X1 Y1 Z1 I0 J0 K0", nct_offsets.REFERENCE_FORMAT, 1),
        ("G22 X1 Y1 Z1 I0 J0 K0 P2", nct_offsets.REFERENCE_FORMAT, 23),
        ("G22 X1 Y-1 Z1 I0 J0 K0 P0", nct_offsets.REFERENCE_FORMAT, 8),
    ],
)
def test_errors(text: str, entry: object, column: int) -> None:
    assert found(text) == (entry, 1, column)


@pytest.mark.spec("nct.trc.suspension")
@pytest.mark.parametrize("change", [INSIDE.replace("60", "960").replace("40", "940").strip(), "G23"])
def test_it_takes_the_vector_away_for_a_moment(change: str) -> None:
    text = f"G10 R5 L12 P1\nG0 X-20\nG41 G1 X0 D1 F100\nX40\n{change}\nX80\nX120"
    assert driven(text)[0] == [(-20, 0, 0), (0, 5, 0), (40, 0, 0), (80, 5, 0), (120, 5, 0)]


def test_it_stands_alone() -> None:
    assert found("G0 X1\nG22 X9 Y9 Z9 I5 J5 K5 P0 F100")[0] is nct.WORD_WITHOUT_MEANING


# ---------------------------------------------------------------------------------------------------- overtravel


@pytest.mark.spec("nct.mon.overtravel-and-precheck")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G53 X0 Y0 Z0\nG0 X9999", nct_offsets.LIMIT, 2),
        ("G53 X0 Y0 Z0\nG1 X1 F1000\nX1 Z-9999", nct_offsets.LIMIT, 3),
        ("G53 X0 Y300 Z0\nG91 G2 X0 Y-100 J-50 F1000\nG0 Y1", nct_offsets.LIMIT, 0),  # its ends are free: permitted
        ("G53 X0 Y0 Z0\nG22 X9 Y9 Z9 I5 J5 K5 P0\nG0 X7 Y7 Z7", nct_offsets.STROKE_ENTERED, 3),
    ],
)
def test_a_block_that_leads_too_far_does_not_begin(text: str, entry: ErrorEntry, line: int, tmp_path: Path) -> None:
    """Limits and the box are looked at before a block moves; both may hold at once."""
    machine = load_machine(None)
    channel = machine.channels[0].model_copy(update={"zero_offsets": {}})
    machine = machine.model_copy(update={"channels": (channel,)})
    program = tmp_path / "O0001.nc"
    program.write_text(text + "\nM30\n")
    simulation = Simulation(machine, ideal_axes=True, dialect="nct", plc=False)
    result = simulation.run_program(program)
    told = " ".join(result.problems)
    if not line:
        assert result.good, told
        return
    assert f":{line}:" in told
    assert str(entry.id) in told
    start = {"X": 1.0 if "X1 F" in text else 0.0, "Y": 0.0, "Z": 0.0}
    assert {name: round(result.positions[name], 3) for name in "XYZ"} == start
