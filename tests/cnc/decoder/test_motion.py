"""Axis words, planes, units, offsets, circles, feed, dwell: what moves where."""

from __future__ import annotations

import itertools
import math

import numpy as np
import pytest
from hypothesis import assume, given
from hypothesis import strategies as st

from runtime.cnc.block_json import Row
from runtime.cnc.blocks import Arc, BlockEnd, Dwell, Line, Polyline
from runtime.cnc.decoder import circles
from runtime.diagnostics.catalogue import language as catalogue
from tests.cnc.decoder.programs import Run, decode


def ends(text: str, start: tuple[float, ...] = (0, 0, 0)) -> list[list[float]]:
    run = decode(text, start=start)
    assert run.problem is None, run.problem
    return run.ends


def arcs(text: str) -> list[Arc]:
    run = decode(text)
    assert run.problem is None, run.problem
    return [block for block in run.blocks if isinstance(block, Arc)]


# -- lines ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.g.rapid-g00", "isg.g.linear-g01", "isg.mh.feed-f")
def test_rapid_and_feed() -> None:
    rows = decode("G00 X1 F200\nX2\nG01 X3\nX4 F300\nG0 X5\nG1 X[6]\nM30").rows
    motion = [(row["feed"], row["rapid"]) for row in rows if row["type"] == "line"]
    assert motion == [(None, True), (None, True), (200, False), (300, False), (None, True), (300, False)]


@pytest.mark.spec("isg.g.dimension-g90-g91")
def test_absolute_and_incremental() -> None:
    assert ends("G00 X1 Y1\nG91 X2\nX[2] Y-1\nG90 X2\nX3 G91 Y3\nM30") == [
        [1, 1, 0],
        [3, 1, 0],
        [5, 0, 0],
        [2, 0, 0],
        [5, 3, 0],
    ]


@pytest.mark.spec("isg.g.zero-offset-g53-g59")
def test_zero_offsets() -> None:
    text = "G00 X1\nG54 X1\nY[1]\nG55\nG91 X1\nG90 X1\nG56 X0\nG57 X0\nG58 X0\nG59 X0 Y0 Z0\nG53 X1\nM30"
    run = decode(text)
    assert [end[0] for end in run.ends] == [1, 101, 101, 102, 201, 300, 400, 500, 600, 1]
    assert run.ends[2] == [101, 11, 0]  # the offset acts with the next absolute word of each axis
    programmed = [list(pcs.values()) for row in run.rows if isinstance(pcs := row.get("to_pcs"), dict)]
    assert programmed[1] == [1, -10, -1]
    assert programmed[3][0] == 102 - 200


@pytest.mark.spec("isg.g.zero-offset-g53-g59")
def test_an_incremental_move_by_zero_stays_where_it_is() -> None:
    assert ends("G54\nG00 X0 G91\nM30", start=(7, 8, 9)) == [[7, 8, 9]]


@pytest.mark.spec("isg.g.units-g70-g71")
def test_inch() -> None:
    run = decode("G70 G01 X1 F10\nX[2]\nG71 X1\nG70 G02 X1.0 Y1 R0.5\nM30", start=(0.0, 0.0, 0.0))
    assert np.allclose([end[0] for end in run.ends[:3]], [25.4, 50.8, 1])
    assert [row["feed"] for row in run.rows if "feed" in row][:3] == [254, 254, 254]


@pytest.mark.spec("isg.g.units-g70-g71")
def test_inch_circle() -> None:
    (arc,) = arcs("G70 G03 X0 Y1 I0 J0.5 F10\nM30")
    assert arc.centre.tolist() == [0, 12.7]
    assert arc.radius == pytest.approx(12.7)
    assert arc.end.tolist() == [0, 25.4, 0]


@pytest.mark.spec("isg.lex.number-formats", "isg.lex.integer-double", "isg.lex.axis-names")
def test_number_and_word_forms() -> None:
    text = (
        "G00 X 10.0 Y.5 Z+1.\nX=1.5e1 Y = -2\nX'16#FF' Y'0x0E' Z'H1f'\nX'2#101' Y'02#11' Z'B1'\nX'8#17' Y'08#  7'\nM30"
    )
    assert ends(text) == [[10, 0.5, 1], [15, -2, 1], [255, 14, 31], [5, 3, 1], [15, 7, 1]]


@pytest.mark.spec("isg.lex.address-letters")
def test_fixed_letters_may_be_small() -> None:
    assert ends("n1 g01 X1 f100\np1=2\nXp1 g91\ng02 i1\nm30") == [[1, 0, 0], [3, 0, 0], [3, 0, 0]]


def test_a_block_end_stands_behind_every_full_block_with_motion() -> None:
    kinds = [type(block) for block in decode("G00 X[1] M14\nP1 = 1\nG04 1\nG17\nM30").blocks]
    assert kinds[:4] == [Line, BlockEnd, Dwell, BlockEnd]
    assert len(kinds) == 5


# -- plain runs ----------------------------------------------------------------------------------------------------


def motions(run: Run) -> list[Row]:
    return [row for row in run.rows if "to" in row]


def test_plain_blocks_become_one_polyline() -> None:
    run = decode("G01 F100\nN10 X1\nN20 Y2 (c)\n\nF200\nG0 Z3\nG1 X0 Y0\nM30")
    (line,) = (block for block in run.blocks if isinstance(block, Polyline))
    assert line.points.tolist() == [[0, 0, 0], [1, 0, 0], [1, 2, 0], [1, 2, 3], [0, 0, 3]]
    assert line.feeds.tolist() == [100, 100, math.inf, 200]
    assert line.lines.tolist() == [2, 3, 6, 7]
    assert line.numbers.tolist() == [10, 20, -1, -1]


@pytest.mark.parametrize("prefix", ["", "G91", "G70", "G54", "G70 G91 G55", "G02"])
def test_plain_runs_decode_like_full_blocks(prefix: str) -> None:
    """The same words once for the kernel and once, with an empty expression part, for the full parser."""
    plain = ["G01 X1 Y2 F100", "N7 X3", "Z-1.5", "G0 X1.25 Z2", "F300", "X4", "G1 Y5"]
    full = [line + " M14" for line in plain]  # a function that is not put out
    first = decode("\n".join([f"P9 = 0 {prefix}", *plain, "M30"]))
    second = decode("\n".join([f"P9 = 0 {prefix}", *full, "M30"]))
    assert any(isinstance(block, Polyline) for block in first.blocks)
    assert not any(isinstance(block, Polyline) for block in second.blocks)
    assert motions(first) == motions(second)


def test_modal_state_acts_when_a_run_is_executed() -> None:
    text = "%L A\nX1\nX2\nM17\n%M\nG00 Y0\nLL A\nG91 G01 F50\nLL A\nG90 G54\nLL A\nM30"
    run = decode(text)
    assert [end[0] for end in run.ends] == [0, 1, 2, 3, 5, 101, 102]
    assert [row["feed"] for row in motions(run)] == [None, None, None, 50, 50, 50, 50]


def test_a_run_that_begins_in_a_modal_circle_is_decoded_fully() -> None:
    run = decode("G03 R5 F100\nX10\nX0\nG01 X5\nX6\nG02\nX6 Y2\nM30")
    assert [type(block).__name__ for block in run.blocks if not isinstance(block, BlockEnd)] == [
        "Arc",
        "Arc",
        "Polyline",
        "Arc",
        "Stop",
    ]
    assert run.ends == [[10, 0, 0], [0, 0, 0], [5, 0, 0], [6, 0, 0], [6, 2, 0]]


def test_a_fault_in_a_run_is_told_with_its_line() -> None:
    run = decode("G00 X1\nX2\nG01 X3\nX4\nM30")
    assert [end[0] for end in run.ends] == [1, 2]
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (catalogue.FEED_MISSING, 3)


def test_a_line_behind_a_run_leaves_its_values_alone() -> None:
    """The scan of a line that is not plain begins while the run before it is still to be executed."""
    run = decode("G00 X1 M14\nX2 Y7\nX3 Y4 G91\nM30")
    assert run.ends == [[1, 0, 0], [2, 7, 0], [5, 11, 0]]


def test_long_runs_come_in_chunks() -> None:
    count = 10_000
    text = "G00\n" + "".join(f"X{i}\n" for i in range(count)) + "M30"
    run = decode(text)
    lines = [block for block in run.blocks if isinstance(block, Polyline)]
    assert len(lines) == 3
    assert np.concatenate([line.points[1:, 0] for line in lines]).tolist() == list(range(count))
    assert np.concatenate([line.lines for line in lines]).tolist() == list(range(2, count + 2))
    for before, after in itertools.pairwise(lines):
        assert before.points[-1].tolist() == after.points[0].tolist()


# -- circles -------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.g.circular-centre-g02-g03", "isg.g.circle-centre-mode-g161-g162")
@pytest.mark.parametrize(
    ("text", "centre", "angle", "end"),
    [
        ("G03 X10 Y10 I0 J10", [0, 10], 90, [10, 10]),
        ("G02 X10 Y10 I10", [10, 0], -90, [10, 10]),
        ("G02 X10 Y10 I0 J10", [0, 10], -270, [10, 10]),
        ("G03 I5", [5, 0], 360, [0, 0]),
        ("G02 X0 Y0 J-5", [0, -5], -360, [0, 0]),
        ("G161 G03 X10 Y10 I0 J10", [0, 10], 90, [10, 10]),
        ("G161 G54 G03 I-95 J-10", [5, 0], 360, [0, 0]),
        ("G91 G03 X10 Y10 J10", [0, 10], 90, [10, 10]),
    ],
)
def test_circle_by_centre(text: str, centre: list[float], angle: float, end: list[float]) -> None:
    (arc,) = arcs(f"{text} F100\nM30")
    assert arc.centre.tolist() == pytest.approx(centre)
    assert arc.angle == pytest.approx(angle)
    assert arc.end[:2].tolist() == pytest.approx(end)
    assert arc.plane == (0, 1)


@pytest.mark.spec("isg.g.plane-g17-g18-g19")
@pytest.mark.parametrize(
    ("text", "plane", "centre", "end"),
    [
        ("G17 G03 X5 Y5 J5", (0, 1), [0, 5], [5, 5, 0]),
        ("G18 G03 Z5 X5 I5", (2, 0), [0, 5], [5, 0, 5]),
        ("G19 G03 Y5 Z5 K5", (1, 2), [0, 5], [0, 5, 5]),
    ],
)
def test_planes(text: str, plane: tuple[int, int], centre: list[float], end: list[float]) -> None:
    (arc,) = arcs(f"{text} F100\nM30")
    assert (arc.plane, arc.centre.tolist(), arc.end.tolist()) == (plane, centre, end)
    assert arc.angle == pytest.approx(90)


@pytest.mark.spec("isg.g.circular-radius")
def test_circle_by_radius() -> None:
    four = arcs("G03 X10 Y10 R10 F100\nX0 Y0 R-10\nG02 X10 Y10 R=10\nX0 Y0\nM30")
    assert np.allclose([arc.centre for arc in four], [[0, 10], [0, 10], [10, 0], [0, 10]])
    assert np.allclose([arc.angle for arc in four], [90, 270, -90, -90])


@pytest.mark.spec("isg.g.circular-radius")
@pytest.mark.parametrize("words", ["R=50\nX100", "R1=50\nG02 X100", "X100 R1=50", "G163=50\nX100", "G163=50 X100"])
def test_the_radius_may_be_set_in_several_ways(words: str) -> None:
    arc = arcs(f"G02 F500 {words}\nX200\nM30")
    assert np.allclose([(a.radius, a.angle) for a in arc], [(50, -180), (50, -180)])


@pytest.mark.spec("isg.g.circular-radius")
def test_a_centre_ends_the_modal_radius() -> None:
    run = decode("G02 X10 R5 F100\nX20 I5\nX30\nM30")
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (catalogue.CENTRE_MISSING, 3)


@pytest.mark.spec("isg.g.helix-simple")
def test_simple_helix() -> None:
    quarter, full = arcs("G03 X10 Y10 Z-3 J10 F100\nG02 Z2 I5\nM30")
    assert quarter.end.tolist() == [10, 10, -3]
    assert quarter.angle == pytest.approx(90)
    assert (full.end.tolist(), full.angle) == ([10, 10, 2], -360)


@pytest.mark.spec("isg.g.helix-pitch")
@pytest.mark.parametrize(
    ("pitch", "turns"),
    [(30, 0.75), (17.5, 0.75), (15, 1.75), (12.5, 1.75), (10, 1.75), (7.5, 2.75), (5, 3.75), (2.5, 7.75), (2, 9.75)],
)
def test_helix_with_pitch(pitch: float, turns: float) -> None:
    """The example of the manual (line 2552), without its row K16, which contradicts the rule."""
    (arc,) = arcs(f"G00 X-10 Y0 Z0\nG161 G02 X0 Y-10 Z-20 I0 J0 K{pitch} F500\nM30")
    assert arc.angle == pytest.approx(-360 * turns)


def test_an_inexact_centre_is_moved() -> None:
    (arc,) = arcs("G02 X10 Y0 I5.1 J0.05 F100\nM30")
    assert arc.centre.tolist() == pytest.approx([5, 0.05])
    assert arc.radius == pytest.approx(math.hypot(5, 0.05))


points = st.tuples(*[st.floats(-1000, 1000).map(lambda x: round(x, 4))] * 2)


@given(points, points, st.floats(0.01, 1000), st.booleans(), st.booleans())
def test_circles_by_radius_end_at_their_target(
    start: circles.Point, end: circles.Point, extra: float, clockwise: bool, longer: bool
) -> None:
    distance = math.dist(start, end)
    assume(distance > 0.001)
    radius = (distance / 2 + extra) * (-1 if longer else 1)
    circle = circles.by_radius(start, end, radius, clockwise)
    assert math.dist(reached(start, circle), end) < 1e-6 * max(1.0, abs(radius))
    assert (abs(circle.angle) > 180) == longer
    assert (circle.angle < 0) == clockwise


@given(points, points, points, st.booleans())
def test_circles_by_centre_end_at_their_target(
    start: circles.Point, end: circles.Point, centre: circles.Point, clockwise: bool
) -> None:
    assume(math.dist(start, end) > 0.001)
    try:
        circle = circles.by_centre(start, end, centre, clockwise, math.inf, math.inf)
    except circles.CircleError as error:
        assert error.entry in (catalogue.RADIUS_ZERO, catalogue.RADIUS_RANGE)  # noqa: PT017 - the only allowed ways out
        return
    assert math.dist(reached(start, circle), end) < 1e-5 * max(1.0, circle.radius)
    assert 0 < (-circle.angle if clockwise else circle.angle) <= 360


def reached(start: circles.Point, circle: circles.Circle) -> circles.Point:
    """Where the arc ends."""
    turn = math.radians(circle.angle)
    x, y = start[0] - circle.centre[0], start[1] - circle.centre[1]
    return (
        circle.centre[0] + x * math.cos(turn) - y * math.sin(turn),
        circle.centre[1] + x * math.sin(turn) + y * math.cos(turn),
    )


def test_points_within_the_resolution_give_a_full_circle() -> None:
    (arc,) = arcs("G00 X10\nG03 X10.00002 Y0 I-5 F100\nM30")
    assert arc.angle == pytest.approx(360, abs=0.01)


# -- dwell ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.g.dwell-g04-time")
@pytest.mark.parametrize(
    ("words", "seconds"),
    [("G04 X4.5", 4.5), ("G04 3.0", 3), ("G4 P1", 2), ("G04 X=P1", 2), ("G04 S10", 3), ("N5 G04 [P1 / 4]", 0.5)],
)
def test_dwell(words: str, seconds: float) -> None:
    run = decode(f"S200 P1 = 2\n{words}\nM30")
    (dwell,) = (block for block in run.blocks if isinstance(block, Dwell))
    assert dwell.seconds == seconds
    assert run.ends == []
