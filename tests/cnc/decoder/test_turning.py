"""Turning as words: diameters of the facing axis, constant cutting speed, and what the variables tell of them."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import CuttingSpeed, Line, Technology, TechnologyFunction
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.decoder.setup import AxisDynamics
from runtime.config.machine import TurningAxis
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import spindle as S  # noqa: N812
from runtime.diagnostics.catalogue import technology as T  # noqa: N812
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import decode, found
from tests.cnc.decoder.test_spindles import SETUP as SPINDLES

FACING, ALONG = TurningAxis(kind="facing"), TurningAxis(kind="longitudinal")
FIRST = replace(SPINDLES.spindles[0], dynamics=AxisDynamics(48_000.0, 60_000.0, 600_000.0))  # 8000 rev/min
SETUP = replace(SPINDLES, spindles=(FIRST, *SPINDLES.spindles[1:]), turning=(FACING, None, ALONG))
DIAMETER, CUTTING = "isg.turn.diameter-g51-g52", "isg.turn.css-g96-g97-g196"


def xs(text: str, setup: DecoderSetup = SETUP) -> list[float]:
    """Machine positions of X after each motion."""
    run = decode("G18\n" + text + "\nM30", setup)
    assert run.problem is None, run.problem
    return [end[0] for end in run.ends]


# -- G51


@pytest.mark.spec(DIAMETER)
def test_the_example_of_the_manual() -> None:
    """With P-CHAN-00091: G92 is a diameter too."""
    setup = replace(SETUP, offset_diameters=True)
    text = "G90 G01 F1000\nG51 X80\nG92 X10\nX0\nG91 X50\nG52\nX10\nG90 X10"
    assert xs(text, setup) == [40.0, 5.0, 55.0, 65.0, 15.0]


@pytest.mark.spec(DIAMETER)
def test_absolute_and_relative_values_are_diameters_as_the_axis_says() -> None:
    both = replace(SETUP, turning=(TurningAxis(kind="facing", diameter_incremental=True), None, ALONG))
    relative = TurningAxis(kind="facing", diameter_absolute=False, diameter_incremental=True)
    text = "G01 F100 G51\nX10\nG91 X4\nG90 Z6 X20\nX8 G52"
    assert xs(text) == [5.0, 9.0, 10.0, 8.0]
    assert xs(text, both) == [5.0, 7.0, 10.0, 8.0]
    assert xs(text, replace(SETUP, turning=(relative, None, ALONG))) == [10.0, 12.0, 20.0, 8.0]


@pytest.mark.spec(DIAMETER)
def test_every_road_of_the_decoder_knows_of_it() -> None:
    rows = "\n".join(f"X{k} Z{k}" for k in range(2, 40, 2))
    assert xs(f"G01 F100 G51\n{rows}") == [float(k) for k in range(1, 20)]
    assert xs("G01 F100 G51\n$FOR P1=2,38,2\nX=P1 Z1\n$ENDFOR\nG52\nX3") == [*map(float, range(1, 20)), 3.0]
    assert xs("G70 G01 F10 G51 X2") == [25.4]


@pytest.mark.spec(DIAMETER)
def test_centres_and_radii_of_circles_are_none() -> None:
    run = decode("G18 G01 F100 G51 X20\nG02 Z10 X40 I0 K10\nG03 X20 Z0 R10\nM30", SETUP)
    assert run.problem is None, run.problem
    arcs = [row for row in run.rows if row["type"] == "arc"]
    assert [row["radius"] for row in arcs] == [pytest.approx(10.0), pytest.approx(10.0)]
    assert arcs[0]["centre"] == {"Z": pytest.approx(10.0), "X": pytest.approx(10.0)}


@pytest.mark.spec(DIAMETER)
def test_zero_offsets_are_diameters_whether_g51_holds_or_not() -> None:
    offsets = {54: np.array([30.0, 0.0, 0.0])}
    assert xs("G54 G01 F100 X2\nG51 X2", replace(SETUP, zero_offsets=offsets)) == [32.0, 31.0]
    assert xs("G54 G01 F100 X2\nG51 X2", replace(SETUP, zero_offsets=offsets, offset_diameters=True)) == [17.0, 16.0]


@pytest.mark.spec("isg.var.g-active-flags", DIAMETER)
def test_what_variables_tell() -> None:
    text = (
        "G18 P1=V.G.DIAMETER_PROG_ACTIVE P2=V.A.DIAMETER_PROG.ABS.X\nG51\n"
        "P3=V.G.DIAMETER_PROG_ACTIVE P4=V.A.DIAMETER_PROG.ABS.X\n"
        "P5=V.A.DIAMETER_PROG.REL.X P6=V.A.DIAMETER_PROG.ABS.Z P7=V.G.DIAMETER_PROG.ZERO_OFFSET P8=V.A.MODE.X P9=V.A.MODE.Z\nM30"
    )
    run = decode(text, replace(SETUP, offset_diameters=True))
    assert run.parameters == {1: 0, 2: 0, 3: 1, 4: 1, 5: 0, 6: 0, 7: 1, 8: 0x41, 9: 0x81}


# -- G96


def speeds(text: str, setup: DecoderSetup = SETUP) -> list[str]:
    """Speeds of S functions (rev/min), changes of the cutting speed (m/min, centre, limit), and ends of motions in X."""
    run = decode("G18\n" + text + "\nM30", setup)
    assert run.problem is None, run.problem
    told = []
    for block in run.blocks:
        if isinstance(block, TechnologyFunction) and block.kind is Technology.S:
            told.append(f"n{block.value:.1f}")
        elif isinstance(block, CuttingSpeed):
            told.append(f"v{block.velocity / 1000:g}@{block.centre:g}<{block.limit:g}" if block.velocity else "keep")
        elif isinstance(block, Line):
            told.append(f"X{block.end[0]:g}")
    return told


def turning(velocity: float, radius: float) -> str:
    """rev/min for m/min."""
    return f"n{velocity * 1000.0 / (2.0 * math.pi * radius):.1f}"


@pytest.mark.spec(CUTTING)
def test_cutting_speed_in_a_program() -> None:
    """The example of the manual: limit, change of S, end, offset, S forgotten, rapid traverse."""
    text = (
        "M03 S1000 G01 F1500 X100\nG196 S6000\nG96 S63\nX80\nS4 X50\nG97 S8000\nG92 X-10\nG96 X60\nS25 X70\nG00 X450\nX70\n"
        "G01 X40"
    )
    assert speeds(text) == [
        "n1000.0", "X100",
        "v63@0<6000", turning(63.0, 100.0), "X80",
        "v4@0<6000", turning(4.0, 80.0), "X50",
        "keep", "n8000.0",
        "X50",  # G96 without S: as before
        "v25@0<6000", turning(25.0, 50.0), "X60",
        "keep", "X440", "X60",
        "v25@0<6000", "X30",
    ]  # fmt: skip


@pytest.mark.spec(CUTTING)
def test_the_limit_may_stand_in_the_block_of_g96_and_is_modal() -> None:
    assert speeds("M3 S100 G01 F100 X1\nG196=500 G96 S100\nX2")[2:4] == ["v100@0<500", "n500.0"]
    assert speeds("M3 S100 G01 F100 X0\nG96 S100\nX2")[3] == "n8000.0"  # at the centre: what the spindle can


@pytest.mark.spec(CUTTING)
def test_behind_g97_the_speed_stays_and_counts_in_rev_per_min() -> None:
    run = decode("G18 M3 S100 G01 F100 X20\nG96 S10\nX10\nG97\nP1=V.SPDL_PROG.SPEED.S\nG95 F1 X20\nM30", SETUP)
    n = 10_000.0 / (2.0 * math.pi * 10.0)
    assert run.parameters[1] == pytest.approx(n)
    assert [b.feed for b in run.blocks if isinstance(b, Line)][-1] == pytest.approx(n)


@pytest.mark.spec(CUTTING)
def test_feet_per_minute_with_g70_where_the_channel_says_so() -> None:
    setup = replace(SETUP, cutting_feet=True)
    assert speeds("G70 M3 S100 G01 F10 X1\nG96 S100\nX2", setup)[2] == "v30.48@0<0"
    assert speeds("G71 M3 S100 G01 F10 X1\nG96 S100\nX2", setup)[2] == "v100@0<0"
    assert speeds("G70 M3 S100 G01 F10 X1\nG96 S100\nX2")[2] == "v100@0<0"


@pytest.mark.spec(CUTTING, "isg.var.spindle-data")
def test_variables_of_the_main_spindle() -> None:
    asked = "P{}=V.SPDL_PROG.MAX_SPEED.S P{}=V.SPDL_PROG.CONST_CUT_SPEED.S"
    text = f"G18 G01 F100 X10\n{asked.format(1, 2)}\nG196 S5000\nG96 S60\n{asked.format(3, 4)}\nG97\n{asked.format(5, 6)}\nM30"
    assert decode(text, SETUP).parameters == {1: 0, 2: 0, 3: 5000, 4: pytest.approx(60.0), 5: 5000, 6: 0}
    assert next(found("P1=V.SPDL_PROG.MAX_SPEED.S2\nM30", SETUP))[0] is C.VARIABLE_UNSUPPORTED


ERRORS: list[tuple[str, ErrorEntry, int, int]] = [
    ("G19 G51\nM30", S.FACE_AXIS, 1, 5),
    ("G19 G96 S100\nM30", S.FACE_AXIS, 1, 5),
    ("G18 G51\nG19\nG01 F100 X1\nM30", S.FACE_AXIS, 3, 1),
    ("G18 G51\n#PSET X1\nM30", S.PSET_DIAMETER, 2, 1),
    ("G18\nG196\nM30", T.SPINDLE_WORD_NEEDED, 2, 1),
    ("G18\nG196=0\nM30", S.CUTTING_SPEED, 2, 1),
    ("G18\nG196 S0\nM30", S.CUTTING_SPEED, 2, 6),
    ("G18 G01 F1 X1\nG96 S0\nM30", S.CUTTING_SPEED, 2, 5),
    ("G18 #MAIN SPINDLE [S3]\nM30", C.NOT_ALONE, 1, 5),
    ("G18\n#MAIN SPINDLE [S3]\nG96\nM30", S.SPINDLE_NEEDED, 3, 1),
    ("G51 G52\nM30", C.G_GROUP_TWICE, 1, 5),
    ("G96 G97\nM30", C.G_GROUP_TWICE, 1, 5),
]


@pytest.mark.spec(DIAMETER, CUTTING)
@pytest.mark.parametrize(("text", "entry", "line", "column"), ERRORS)
def test_errors(text: str, entry: ErrorEntry, line: int, column: int) -> None:
    assert next(iter(found(text, SETUP))) == (entry, line, column)
