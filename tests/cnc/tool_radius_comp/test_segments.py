"""#TRC SPLIT: approach and exit in segments with feeds of their own."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Line
from runtime.cnc.decoder import DecoderSetup
from runtime.diagnostics.catalogue import radius as catalogue
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.tool_radius_comp.paths import Path, tool_path

SPLIT = pytest.mark.spec("isg.trc.opt-split")
TWO = "DIST_SEG1=6 FEED_SEG1=300 DIST_SEG2=2 FEED_SEG2=200"


def driven(
    option: str, approach: str = "G00 X-30 Y0", mode: str = "G138", motion: str = "G01", setup: DecoderSetup = SETUP
) -> Path:
    """To the zero point, along X to 40, up to 30, and away."""
    text = f"#TRC [{option}]\n{approach} G162\n{mode} G41 {motion} X0 Y0\nG01 X40\nY30\nG40 Y60\nM30"
    path = tool_path(text, setup)
    assert path.error is None
    return path


def parts(path: Path, line: int) -> list[tuple[float, float]]:
    """Lengths and feeds of the motions of a line."""
    of = [motion for motion in path.motions if motion.source.line == line]
    return [(round(math.dist(motion.start[:2], motion.end[:2]), 9), motion.feed) for motion in of]


def whole(path: Path, line: int) -> float:
    return sum(length for length, _ in parts(path, line))


@SPLIT
@pytest.mark.parametrize("mode", ["G138", "G139"])
def test_the_segments_lie_at_the_contour(mode: str) -> None:
    path = driven(f"SPLIT_PATH COMBINED {TWO}", mode=mode)
    way = math.hypot(30, 5)
    assert parts(path, 3) == [(pytest.approx(way - 8), 1000), (6, 300), (2, 200)]
    assert parts(path, 6) == [(2, 200), (6, 300), (pytest.approx(math.hypot(30, 5) - 8), 1000)]
    plain = driven("SPLIT_OFF", mode=mode)
    assert path.of(3)[-1] == plain.of(3)[-1]
    assert path.of(6)[-1] == plain.of(6)[-1]


@SPLIT
@pytest.mark.parametrize(("which", "counts"), [("", (2, 1)), ("PRE", (2, 1)), ("POST", (1, 2)), ("COMBINED", (2, 2))])
def test_which_end_is_split(which: str, counts: tuple[int, int]) -> None:
    path = driven(f"SPLIT_PATH {which} DIST_SEG1=5 FEED_SEG1=300")
    assert (len(parts(path, 3)), len(parts(path, 6))) == counts


@SPLIT
@pytest.mark.parametrize("axis", ["AX=X", "AXNR=1"])
def test_lengths_along_an_axis(axis: str) -> None:
    path = driven(f"SPLIT {axis} {TWO}", "G00 X-30 Y40", setup=replace(SETUP, log_axes=(1, 2, 3)))
    assert [shape[0] for shape in path.of(3)] == [-8, -2, 0]
    assert [feed for _, feed in parts(path, 3)] == [1000, 300, 200]


@SPLIT
def test_rapid_traverse_ends_where_the_first_segment_begins() -> None:
    path = driven(f"SPLIT_PATH {TWO}", motion="G00")
    lines = [motion for motion in path.motions[1:4] if isinstance(motion, Line)]
    assert [(line.feed, line.rapid) for line in lines] == [(math.inf, True), (300, False), (200, False)]


@SPLIT
@pytest.mark.parametrize(
    ("start", "expected"),
    [(8.0, [(6, 300), (2, 200)]), (7.0, [(5, 300), (2, 200)]), (2.0, [(2, 200)]), (1.5, [(1.5, 200)])],
)
def test_short_of_two_segments_the_second_keeps_its_length(start: float, expected: list[tuple[float, float]]) -> None:
    assert parts(driven(f"SPLIT_PATH {TWO}", f"G00 X0 Y{5 + start}"), 3) == expected


@SPLIT
def test_short_of_the_only_segment_all_runs_with_its_feed() -> None:
    assert parts(driven("SPLIT_PATH DIST_SEG1=6 FEED_SEG1=300", "G00 X0 Y9"), 3) == [(4, 300)]
    assert parts(driven("SPLIT AX=X DIST_SEG1=6 FEED_SEG1=300", "G00 X0 Y29"), 3) == [(24, 300)]  # X does not move


@SPLIT
@pytest.mark.parametrize(
    ("approach", "mode", "motion"),
    [
        ("G00 X0 Y-30", "G138", "G01"),
        ("G00 X20 Y-30", "G139", "G01"),
        ("G00 X-30 Y0", "G237", "G01"),
        ("G00 X-30 Y0", "G236", "G01"),
        ("G00 X-30 Y20", "G05", "G01"),
        ("G00 X-20 Y20", "G138", "G03 I20 "),
    ],
)
def test_what_is_not_split(approach: str, mode: str, motion: str) -> None:
    path = driven(f"SPLIT_PATH {TWO}", approach, mode, motion)
    plain = driven("SPLIT_OFF", approach, mode, motion)
    assert path.shape == plain.shape
    assert all(motion.feed not in (200, 300) for motion in path.motions)


@SPLIT
def test_on_the_path_up_to_90_degrees() -> None:
    path = driven(f"SPLIT_PATH {TWO}", "G00 X40 Y20", "G236")
    assert [feed for _, feed in parts(path, 3)] == [1000, 300, 200]


@SPLIT
def test_the_third_axis_keeps_its_share() -> None:
    path = tool_path(f"#TRC [SPLIT_PATH {TWO}]\nG00 X-20 Y5 Z0\nG138 G41 G01 X0 Y0 Z-10\nX40\nG40 X60\nM30")
    assert [motion.end[2] for motion in path.motions[1:4]] == pytest.approx([-6, -9, -10])


@SPLIT
@given(st.floats(0.1, 40), st.floats(0.1, 40), st.floats(5.5, 60))
def test_the_way_is_the_same_however_it_is_split(first: float, second: float, start: float) -> None:
    option = f"SPLIT_PATH DIST_SEG1={first} FEED_SEG1=300 DIST_SEG2={second} FEED_SEG2=200"
    path, plain = driven(option, f"G00 X-7 Y{start}"), driven("SPLIT_OFF", f"G00 X-7 Y{start}")
    assert whole(path, 3) == pytest.approx(whole(plain, 3))
    assert path.of(3)[-1] == plain.of(3)[-1]
    at_contour = [length for length, feed in parts(path, 3) if feed == 200]
    assert at_contour == [pytest.approx(min(second, whole(plain, 3)))]


@SPLIT
def test_it_stays_until_it_is_switched_off() -> None:
    again = f"#TRC [SPLIT_PATH {TWO}]\n#TRC [REVERSE=1]\nG00 X-30 Y5\nG41 G01 X0 Y0\nX40\nG138 G40 X60\nM30"
    assert len(tool_path(again.replace("G41", "G138 G41")).of(4)) == 3
    assert decode(f"#TRC [SPLIT_PATH {TWO}]\n#TRC [SPLIT_OFF]\nM30").decoder.modal.compensation.split is None


@SPLIT
@pytest.mark.parametrize(
    ("option", "why"),
    [
        ("SPLIT DIST_SEG1=5 FEED_SEG1=100", "AX or AXNR"),
        ("SPLIT AX=Z DIST_SEG1=5 FEED_SEG1=100", "in the plane"),
        ("SPLIT AXNR=99 DIST_SEG1=5 FEED_SEG1=100", "number"),
        ("SPLIT_PATH AX=X DIST_SEG1=5 FEED_SEG1=100", "no axis"),
        ("SPLIT_PATH DIST_SEG1=5", "FEED_SEG1"),
        ("SPLIT_PATH DIST_SEG1=5 FEED_SEG1=100 DIST_SEG2=5", "FEED_SEG2"),
        ("SPLIT_PATH SPLIT AX=X DIST_SEG1=5 FEED_SEG1=100", "only one"),
        ("SPLIT_PATH PRE POST DIST_SEG1=5 FEED_SEG1=100", "only one"),
        ("DIST_SEG1=5", "without SPLIT"),
        ("SPLIT_OFF PRE", "without SPLIT"),
    ],
)
def test_what_is_wrong_is_told(option: str, why: str) -> None:
    run = decode(f"#TRC [{option}]\nM30")
    assert run.problem is not None
    assert run.problem.entry is catalogue.SPLIT_WRITTEN
    assert why in run.problem.text


@SPLIT
@pytest.mark.parametrize("part", ["DIST_SEG1=0 FEED_SEG1=1", "DIST_SEG1=1 FEED_SEG1=-1"])
def test_lengths_and_feeds_are_positive(part: str) -> None:
    run = decode(f"#TRC [SPLIT_PATH {part}]\nM30")
    assert run.problem is not None
    assert run.problem.entry is catalogue.OPTION_VALUE
