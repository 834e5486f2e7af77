"""F, E, G93…G95, G194, G193, G293, G166, #TIME as they are programmed."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, BlockEnd, Dwell, Line, Polyline
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.paths import motions, path
from tests.cnc.decoder.programs import SETUP, Run, decode, found

WITH_VELOCITY = replace(SETUP, axis_velocity=(100.0, 50.0, 20.0))


def run_of(text: str, setup: object = SETUP) -> Run:
    run = decode(text + "\nM30", setup)  # type: ignore[arg-type]
    assert run.problem is None, run.problem
    return run


def feeds(text: str, setup: object = SETUP) -> list[object]:
    return [row["feed"] for row in run_of(text, setup).rows if "feed" in row]


def entries(text: str) -> list[tuple[ErrorEntry, int]]:
    return [(entry, line) for entry, line, _ in found(text + "\nM30")]


# -- F


@pytest.mark.spec("isg.mh.feed-f")
def test_the_feed_is_modal_and_may_be_computed() -> None:
    assert feeds("P1 = 150.5\nG01 X1 F200\nG00 X2\nG01 X3\nX4 F=P1\nX5 F[P1 * 2]\nF77\nX6 M14\nG02 I1") == [
        200, None, 200, 150.5, 301, 77, 77,
    ]  # fmt: skip


@pytest.mark.spec("isg.mh.feed-f")
@pytest.mark.parametrize("block", ["X1 F2", "X=1 F2", "X1 F2 M14"])
def test_the_unit_of_f_is_configured(block: str) -> None:
    """In m/min (P-CHAN-00108), on every road."""
    assert feeds(f"G01 X5 F=1\n{block}", replace(SETUP, feed_factor=1000.0)) == [1000, 2000]
    assert feeds(f"G70 G01 X5 F=1\n{block}") == [25.4, 50.8]


@pytest.mark.spec("isg.mh.feed-f")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G01 X1", catalogue.FEED_MISSING),
        ("G01 X1 F0", catalogue.FEED_INVALID),
        ("G01 X1 F-1", catalogue.FEED_INVALID),
        ("G02 I1", catalogue.FEED_MISSING),
        ("G93 G01 X1", catalogue.FEED_MISSING),
    ],
)
def test_wrong_feeds(text: str, entry: ErrorEntry) -> None:
    assert entries(text) == [(entry, 1)]


# -- E


def test_the_feed_at_the_end_of_a_block() -> None:
    run = run_of(
        "G01 G94 G90\nX200 F1000 E500\nX250 E400\nX350 F800 E300\nX400 E900\nG70 X20 E10\nG71 G02 I5 E3\nG01 X9 M14"
    )
    assert [(block.feed, block.end_feed) for block in run.blocks if isinstance(block, Line | Arc)] == [
        (1000, 500), (1000, 400), (800, 300), (800, 900), (800, 254), (800, 3), (800, None),
    ]  # fmt: skip
    assert feeds("G01 X10 F500 E100 #RND=1\nY10") == [500, 100, 500]


def test_the_unit_of_e_is_that_of_f() -> None:
    (line,) = motions(run_of("G01 X1 F2 E1", replace(SETUP, feed_factor=1000.0)))
    assert isinstance(line, Line)
    assert (line.feed, line.end_feed) == (2000, 1000)
    for mode in ("G93", "G95", "G194"):
        assert entries(f"S100\n{mode} G01 X1 F2 E1") == [(catalogue.END_FEED_MODE, 2)]
    assert entries("G01 X1 F2 E-1") == [(catalogue.FEED_INVALID, 1)]


# -- meaning of F


@pytest.mark.spec("isg.g.feed-mode-g93-g94-g95-g194")
def test_each_mode_keeps_its_own_feed() -> None:
    text = "G01 X60 F300\nG93 X0 F30\nX30\nG94 X0\nS500\nG95 F0.1\nX1\nG94 X2\nG93 X32\nG194 F50 X0\nG94 X1"
    assert feeds(text, WITH_VELOCITY) == [300, 120, 60, 300, 50, 300, 60, 3000, 300]


@pytest.mark.spec("isg.g.feed-mode-g93-g94-g95-g194")
def test_the_time_of_a_block() -> None:
    run = run_of("G93 F6\nG01 X3 Y4\nG03 I5\nG03 I5 Z10\nG00 X0")
    line, circle, helix, _ = (row["feed"] for row in run.rows if "feed" in row)
    assert line == 50
    assert circle == pytest.approx(2 * math.pi * 5 * 10)
    assert helix == pytest.approx(math.hypot(2 * math.pi * 5, 10) * 10)


@pytest.mark.spec("isg.g.feed-mode-g93-g94-g95-g194")
@given(st.integers(-50, 50), st.integers(-50, 50), st.integers(-50, 50), st.integers(1, 99))
def test_one_axis_runs_at_the_share_of_its_velocity(x: int, y: int, z: int, percent: int) -> None:
    if not (x or y or z):
        return
    (feed,) = feeds(f"G194 F{percent}\nG01 X{x} Y{y} Z{z}", WITH_VELOCITY)
    assert isinstance(feed, float)
    velocity = np.array([x, y, z]) / math.hypot(x, y, z) * feed / 60
    assert max(abs(velocity) / (100, 50, 20)) == pytest.approx(percent / 100)


@pytest.mark.spec("isg.g.feed-mode-g93-g94-g95-g194")
def test_wrong_feed_modes() -> None:
    assert entries("G194 F100") == [(catalogue.FEED_PERCENT, 1)]
    assert entries("G95 G01 X1 F0.1") == [(catalogue.FEED_SPINDLE, 1)]
    assert entries("G93 G94 X1") == [(catalogue.G_GROUP_TWICE, 1)]


# -- linear change


@pytest.mark.spec("isg.g.feed-interpolation-g193-g293")
@pytest.mark.parametrize(("word", "middle"), [("G193", 700), ("G293", math.sqrt((1000**2 + 400**2) / 2))])
def test_the_feed_goes_from_the_one_before_to_the_one_of_the_block(word: str, middle: float) -> None:
    run = run_of(f"G01 X500 F1000\n{word} X900 F400\nX1000")
    (change,) = (block for block in run.blocks if isinstance(block, Polyline) and block.one_block)
    assert (change.points[0, 0], change.points[-1, 0]) == (500, 900)
    assert (change.feeds[0], change.feeds[-1]) == (pytest.approx(1000, rel=0.01), pytest.approx(400, rel=0.03))
    half = len(change.feeds) // 2
    assert change.feeds[half - 1 : half + 1].mean() == pytest.approx(middle, rel=1e-3)
    assert feeds(f"G01 X500 F1000\n{word} X900 F400\nX1000")[-1] == 400


@pytest.mark.spec("isg.g.feed-interpolation-g193-g293")
@pytest.mark.parametrize("system", ["", "G54\nG21\n#SCALE ON X2 Y2\n"])
def test_a_feed_change_over_an_arc(system: str) -> None:
    run = run_of(f"{system}G01 X10 Y0 F1000\nG193 G03 X0 Y10 I-10 F400")
    arcs = [block for block in run.blocks if isinstance(block, Arc)]
    (whole,) = (
        block for block in run_of(f"{system}G01 X10 Y0 F1000\nG03 X0 Y10 I-10").blocks if isinstance(block, Arc)
    )
    assert sum(arc.angle for arc in arcs) == pytest.approx(whole.angle)
    np.testing.assert_allclose(path(run)[-1], whole.end, atol=1e-9)
    np.testing.assert_allclose(arcs[-1].end_pcs, whole.end_pcs, atol=1e-9)
    assert all(first.feed > second.feed for first, second in itertools.pairwise(arcs))
    (line,) = (block for block in run_of(f"{system}G01 X10 F10\nG193 X20 F5").blocks
               if isinstance(block, Polyline) and block.one_block)  # fmt: skip
    gain = 1.0 if line.pcs_gain is None else line.pcs_gain
    assert ((line.points[-1] - line.pcs_shift) / gain)[0] == pytest.approx(20)


@pytest.mark.spec("isg.g.feed-interpolation-g193-g293")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G193 G01 X5 F100", catalogue.FEED_CHANGE_START, 1),
        ("G93 F5\nG293 G01 X5", catalogue.FEED_CHANGE_START, 2),
        ("G01 F100\nG193 G293 X5", catalogue.G_GROUP_TWICE, 2),
        ("G01 F100\nG193 X5 F200 #RND=1\nY5", catalogue.FEED_CHANGE_BESIDE, 2),
        ("G01 F100\nG193 X5 F200 E50", catalogue.FEED_CHANGE_BESIDE, 2),
        ("G01 F100\nG193 G166 X5 F200", catalogue.FEED_CHANGE_BESIDE, 2),
        ("G01 F100\nG193 G02 I5 F200 E50", catalogue.FEED_CHANGE_BESIDE, 2),
        ("G01 F100\nG193 G08 X5 F200", catalogue.FEED_CHANGE_BESIDE, 2),
        ("G01 F100\nG09 G293 X5 F200", catalogue.FEED_CHANGE_BESIDE, 2),
    ],
)
def test_wrong_feed_changes(text: str, entry: ErrorEntry, line: int) -> None:
    assert entries(text) == [(entry, line)]


# -- override


def test_the_override_is_off_for_one_block() -> None:
    run = run_of("G01 F100\nG166 X1\nX2 M14\nG166 G00 X3\nG02 G166 I4\nI4")
    assert [block.override_off for block in run.blocks if isinstance(block, Line | Arc)] == [
        True, False, True, True, False,
    ]  # fmt: skip


# -- dwell


@pytest.mark.spec("isg.add.time", "isg.g.dwell-g04-time")
def test_time_as_a_text_command() -> None:
    run = run_of("#TIME 2.5\nP1 = 2\nN30 #TIME P1\nV.L.T = 3.5\n#TIME V.L.T * 2\n#TIME [P1 + 1]\nG04 V.L.T")
    assert [(block.seconds, block.source.n) for block in run.blocks if isinstance(block, Dwell)] == [
        (2.5, None), (2, 30), (7, None), (3, None), (3.5, None),
    ]  # fmt: skip
    assert sum(isinstance(block, BlockEnd) for block in run.blocks) == 5


@pytest.mark.spec("isg.add.time", "isg.g.dwell-g04-time")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#TIME -1", catalogue.DWELL_NEGATIVE),
        ("G04 -1", catalogue.DWELL_NEGATIVE),
        ("G04 S-10", catalogue.DWELL_NEGATIVE),
        ("G04 X1 Y2", catalogue.NOT_ALONE),
        ("G04 Y1", catalogue.DWELL_AXIS),
        ("G04 1 F100", catalogue.NOT_ALONE),
    ],
)
def test_wrong_dwells(text: str, entry: ErrorEntry) -> None:
    before = "S100\n" if "S" in text else ""
    assert [found_entry for found_entry, _ in entries(before + text)] == [entry]
    assert entries("G04 S10") == [(catalogue.DWELL_SPEED, 1)]


# -- what is not there yet


def test_functions_that_are_still_to_come_say_so() -> None:
    assert entries("G66 X1") == [(catalogue.G_UNSUPPORTED, 1)]
