"""Chamfers, roundings and contour lines as they are programmed."""

from __future__ import annotations

import itertools
import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, BlockEnd, Line, Stop, TechnologyFunction
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.paths import motions, path, programmed
from tests.cnc.decoder.programs import SETUP, Run, decode, found


def run_of(text: str) -> Run:
    run = decode(text + "\nM30")
    assert run.problem is None, run.problem
    return run


def plane(text: str, axes: tuple[int, int] = (0, 1)) -> list[list[float]]:
    """Ends of all motions in a plane."""
    return np.round(np.array(run_of(text).ends)[:, axes], 4).tolist()  # type: ignore[no-any-return]


def feeds(text: str) -> list[object]:
    return [row["feed"] for row in run_of(text).rows if "feed" in row]


def entries(text: str) -> list[tuple[ErrorEntry, int]]:
    return [(entry, line) for entry, line, _ in found(text + "\nM30")]


# -- chamfers and roundings


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302")
def test_a_chamfer_block() -> None:
    text = "G00 G91 X100 Y0\nG01 Y100 F200\nG301 I20\nX-60\nG00 G90 X0 Y0"
    assert plane(text) == [[100, 0], [100, 80], [80, 100], [40, 100], [0, 0]]


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302", "isg.g.chamfer-feed-frc")
@pytest.mark.parametrize("own", [False, True])
def test_a_rounded_pocket_with_feeds(own: bool) -> None:
    """The size is kept; F in the block of the corner goes on, #FRC does not."""
    feed, back = ("#FRC=150", "") if own else ("F150", "F200")
    blocks = [
        f"X200 F200\nG302 I20 {feed}\n",
        f"Y100 {back}\nG302 {feed}\n",
        f"X0 {back}\nG302 {feed}\n",
        f"Y50 {back}",
    ]
    run = run_of("G00 X0 Y0\nG01 " + "".join(blocks))
    arcs = [block for block in run.blocks if isinstance(block, Arc)]
    assert [(arc.radius, round(arc.angle, 9)) for arc in arcs] == [(20, 90)] * 3
    assert [row["feed"] for row in run.rows if "feed" in row][1:] == [200, 150, 200, 150, 200, 150, 200]


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302")
def test_the_feed_of_a_corner_block_goes_on() -> None:
    assert feeds("G01 X10 F200\nG302 I1 F150\nY10\nG301\nX0") == [200, 150, 150, 150, 150]
    assert feeds("G00 X10\nG302 I1\nG01 Y10 F100") == [None, None, 100]
    assert feeds("G95 S1000\nG01 X10 F0.2\nG302 I1 F0.1\nY10") == [200, 100, 100]
    assert feeds("G95 S1000\nG01 X10 F0.2 #RND=1 #FRC=0.05\nY10") == [200, 50, 200]
    assert feeds("G70 G01 X10 F20 #RND=1 #FRC=10\nY10") == [508, 254, 508]


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302")
@pytest.mark.parametrize("order", ["G19\nG301 I5", "G301 I5\nG19"])
def test_the_plane_of_the_second_motion_counts(order: str) -> None:
    run = run_of(f"F100 G18 G01 Y20 X5\n{order}\nY20 Z20")
    np.testing.assert_allclose(np.array(run.ends), np.array([[3.75, 15, 0], [5, 20, 5], [5, 20, 20]]))
    assert [block.plane for block in run.blocks if isinstance(block, Line)][1] == (1, 2)


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302")
@pytest.mark.parametrize("between", ["G19", "\n(comment)", "M10\nP1 = 5\n\nH20", "$IF 1\nG17\n$ENDIF"])
def test_blocks_without_motion_may_stand_before_the_corner(between: str) -> None:
    for motion in ("G01 X10 F100", "G01 X10 F100 M14", "G01 X=2*5 F100"):
        kinds = [type(block) for block in motions(run_of(f"{motion}\n{between}\nG17\nG302 I2\nY10"))]
        assert kinds[:2] == [Line, Arc]
    many = "".join(f"X{i} M14\nG17\n" for i in range(100))
    for count in range(1, 70):
        run = run_of(f"G01 F100\n{'P1 = 1' + chr(10) * count}\n{many}G17\nY5 X=9\nG17\nG302 I1\nX0")
        assert sum(isinstance(block, Arc) for block in run.blocks) == 1


@pytest.mark.spec("isg.g.chamfer-rounding-inline")
@pytest.mark.parametrize(("first", "second"), [("G301=20", "G302=20"), ("#CHR=20", "#RND=20")])
def test_corners_in_the_block_of_the_first_motion(first: str, second: str) -> None:
    one, two = f"{first} #FRC=500", f"{second} #FRC=1000"
    text = f"G17 G00 G90 X0 Y0\nG01 F2000 X100 {one}\nY100 {two}\nX0 {one}\nY0 {two}\nX40"
    assert plane(text)[1:] == [[80, 0], [100, 20], [100, 80], [80, 100], [20, 100], [0, 80], [0, 20], [20, 0], [40, 0]]
    assert feeds(text)[1:] == [2000, 500, 2000, 1000, 2000, 500, 2000, 1000, 2000]


@pytest.mark.spec("isg.g.chamfer-rounding-inline")
def test_the_length_of_a_chamfer() -> None:
    ends = plane("G01 X100 F100 #CHF=14.1421356\nY100")
    assert ends == [[90, 0], [100, 10], [100, 100]]


@pytest.mark.spec("isg.g.chamfer-rounding-geometry")
def test_corners_between_lines_and_arcs() -> None:
    """Chamfer widths are chords on arcs; roundings touch both elements."""
    first, insert, second = motions(run_of("G91 G03 I50 X95 Y-15 F100\nG301 I30\nG03 X80 Y-5 I40 J15"))
    corner = np.array([95, -15, 0])
    assert isinstance(insert, Line)
    assert isinstance(first, Arc)
    assert isinstance(second, Arc)
    assert [math.dist(first.end, corner), math.dist(insert.end, corner)] == [pytest.approx(30), pytest.approx(30)]
    for radius, target in ((40, "X50 I25 J-15"), (5, "X60 Y35 I20 J35")):
        _, arc, _ = motions(run_of(f"G91 G02 X80 I40 F100\nG302 I{radius}\nG02 {target}"))
        assert isinstance(arc, Arc)
        assert arc.radius == radius
    _, arc, _ = motions(run_of("G91 G01 X60 F100\nG302 I10\nX-40 Y-55"))
    assert isinstance(arc, Arc)
    assert arc.angle == pytest.approx(-(180 - math.degrees(math.atan2(55, 40))))
    assert entries("G01 X20 Y-10 F100\nX20 Y0\nG301 I30\nX60 Y50") == [(catalogue.CORNER_TOO_LARGE, 2)]


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302", "isg.add.scale")
def test_sizes_grow_with_the_contour() -> None:
    """A contour that fits stays one that fits (the sizes of line 17440 would not fit a contour of 0.3)."""
    text = "G01 X90 Y0 F2000\nG301 I20\nY120\nX50 G302=20\nY100"
    np.testing.assert_allclose(path(run_of(f"#SCALE ON X0.3 Y0.3\n{text}")), path(run_of(text)) * (0.3, 0.3, 1))


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302", "isg.g.mirror-axis-g351")
def test_programmed_coordinates_of_shortened_motions() -> None:
    text = "G01 X10 F100 #RND=2\nY10\nG301 I1\nG03 X5 Y15 I-5"
    np.testing.assert_allclose(programmed(run_of(f"G54\nG351 X-1\n#SCALE ON X2 Y2\nG00 X0 Y0\n{text}")),
                               programmed(run_of(f"G00 X0 Y0 Z-1\n{text}")), atol=1e-9)  # fmt: skip


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302")
def test_a_corner_behind_a_run_that_needs_the_full_decoder() -> None:
    (first, second, insert, third) = motions(run_of("G03 R5 F100 X10 M14\nX20\nG301 I1\nG01 X29"))
    assert [type(block) for block in (first, second, insert, third)] == [Arc, Arc, Line, Line]


@pytest.mark.spec("isg.g.chamfer-rounding-g301-g302", "isg.g.chamfer-rounding-inline", "isg.g.chamfer-feed-frc")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G01 X10 F100\nG301\nY10", catalogue.CORNER_SIZE, 2),
        ("G01 X10 F100\nG302 I0\nY10", catalogue.CORNER_SIZE, 2),
        ("G01 X10 F100 #CHR=0\nY10", catalogue.CORNER_SIZE, 1),
        ("G301 I5\nG01 X10 F100", catalogue.CORNER_WITHOUT_MOTION, 1),
        ("G01 X10 F100\nG301 I5 X10\nY10", catalogue.CORNER_BLOCK, 2),
        ("G01 X10 F100 #CHR=1 #RND=2\nY10", catalogue.CORNER_TWICE, 1),
        ("G01 X10 F100 #CHR=1 G302=2\nY10", catalogue.CORNER_TWICE, 1),
        ("G01 X10 F100 #CHR=1\nG301 I5\nY10", catalogue.CORNER_TWICE, 2),
        ("G01 X10 F100\nG301 I5 #RND=1\nY10", catalogue.CORNER_TWICE, 2),
        ("G01 X10 F100\nG301 I5\nG302 I5\nY10", catalogue.CORNER_TWICE, 3),
        ("G01 X10 F100 #FRC=50\nY10", catalogue.CORNER_FEED_ALONE, 1),
        ("G01 X10 F100 #CHR=1 #FRC=0\nY10", catalogue.FEED_INVALID, 1),
        ("G01 X10 F100\nG301 I1 F0\nY10", catalogue.FEED_INVALID, 2),
        ("G93 G01 X10 F100 #CHR=1 #FRC=10\nY10", catalogue.CORNER_FEED_MODE, 1),
        ("G95 S100 F1\nS0\nG01 X10 #CHR=1 #FRC=1\nY10", catalogue.FEED_SPINDLE, 3),
        ("#CHR=5", catalogue.ADDITION_WITHOUT_MOTION, 1),
        ("G301=5", catalogue.ADDITION_WITHOUT_MOTION, 1),
        ("G92 X5 #RND=5", catalogue.ADDITION_WITHOUT_MOTION, 1),
        ("G303 I1 J1 X2 F100\nG301 I1\nG01 X9", catalogue.CORNER_NEIGHBOUR, 2),
        ("G01 X1 F100\nG193 X9 F200\nG301 I1\nY9", catalogue.FEED_CHANGE_BESIDE, 3),
        ("G01 X1 F100 #CHR=1", catalogue.CORNER_OPEN, 1),
        ("G01 X10 F100 #CHR=1\nX5", catalogue.CORNER_REVERSAL, 1),
        ("G01 X10 F100 #CHR=1\nZ5", catalogue.CORNER_DIRECTION, 1),
    ],
)
def test_wrong_corners(text: str, entry: ErrorEntry, line: int) -> None:
    assert entries(text) == [(entry, line)]


# -- contour lines


@pytest.mark.spec("isg.g.contour-line-single")
@pytest.mark.parametrize(
    ("line", "end"),
    [
        ("#ANG=60 X20", [20, 27.3205]),
        ("#ANG=35 Y20", [24.2815, 20]),
        ("G91 #ANG=60 X10", [20, 27.3205]),
        ("#ANG=-135 X0", [0, 0]),
        ("#ANG=45 X20 Y20", [20, 20]),
    ],
)
def test_one_line_by_its_angle(line: str, end: list[float]) -> None:
    assert plane(f"G17 G00 X10 Y10\nG01 F2000 {line}\nM14")[1] == end


@pytest.mark.spec("isg.g.contour-line-single")
@pytest.mark.parametrize(("word", "axes", "letters"), [("G18", (2, 0), "ZX"), ("G19", (1, 2), "YZ")])
def test_contour_lines_in_other_planes(word: str, axes: tuple[int, int], letters: str) -> None:
    assert plane(f"{word} G01 F100 #ANG=30 {letters[1]}10", axes) == [[17.3205, 10]]


@pytest.mark.spec("isg.g.contour-line-double")
@pytest.mark.parametrize(
    ("lines", "ends"),
    [
        ("#ANG=25 X30\n#ANG=120 Y50", [[30, 19.3262], [12.2904, 50]]),
        ("#ANG=25 G91 X20\n#ANG=120 Y30.673847", [[30, 19.3262], [12.2904, 50]]),
        ("#ANG=0\n#ANG=90 X30 Y60", [[30, 10], [30, 60]]),
        ("#ANG=45\n#ANG=135 Y60", [[35, 35], [10, 60]]),  # the missing coordinate is that of the start
        ("#ANG=75\n#ANG=100", [[10, 10], [10, 10]]),
    ],
)
def test_two_lines(lines: str, ends: list[list[float]]) -> None:
    assert plane(f"G17 G00 X10 Y10\nG01 F2000 {lines}")[1:] == ends


@pytest.mark.spec("isg.g.contour-line-double")
def test_what_stands_between_two_lines_keeps_its_place() -> None:
    run = run_of("G01 F100\nN10 #ANG=0 Z1 M10\nM11\nP1 = 10\nN40 M13 #ANG=90 F50 X=P1 Y5 Z3\nX0")
    kinds = [
        (type(block), getattr(block, "number", None), getattr(block.source, "n", None))
        for block in run.blocks
        if isinstance(block, Line | TechnologyFunction | BlockEnd)
    ]
    order = [kind if number is None else number for kind, number, _ in kinds]
    assert order == [10, Line, BlockEnd, 11, Line, BlockEnd, 13] or order == [
        10,
        Line,
        BlockEnd,
        11,
        Line,
        13,
        BlockEnd,
    ]
    first, second = (block for block in run.blocks if isinstance(block, Line))
    assert (first.end.tolist(), first.source.n, first.feed) == ([10, 0, 1], 10, 100)
    assert (second.end.tolist(), second.source.n, second.feed) == ([10, 5, 3], 40, 50)
    moving = run_of("G91 G01 F100 #ANG=30 Z1\n#ANG=100 Z1")
    assert moving.ends == [[0, 0, 1], [0, 0, 2]]


@pytest.mark.spec("isg.g.contour-line-chain")
def test_a_corner_block_behind_a_line_that_waits() -> None:
    by_block = run_of("G01 X5 F100 M14\n#ANG=0 E50\nG302 I1\n#ANG=90 X10 Y5")
    inline = run_of("G01 X5 F100 M14\n#ANG=0 E50 #RND=1\n#ANG=90 X10 Y5")
    np.testing.assert_array_equal(path(by_block), path(inline))
    assert [type(block) for block in motions(by_block)] == [Line, Line, Arc, Line]
    assert entries("G01 F100 #ANG=0 #RND=1\nG302 I1\n#ANG=90 X10 Y5") == [(catalogue.CORNER_TWICE, 2)]


@pytest.mark.spec("isg.g.contour-line-double")
def test_words_of_the_first_line_stay_its_own() -> None:
    run = run_of("G01 F100\n#ANG=0 E50 G166\n#ANG=90 X10 Y5")
    first, second = (block for block in run.blocks if isinstance(block, Line))
    assert (first.end_feed, first.override_off, second.end_feed, second.override_off) == (50, True, None, False)


@pytest.mark.spec("isg.g.contour-line-chain")
def test_a_chain_comes_back() -> None:
    steps = [
        "0 X20", "90 Y20", "45 X30", "135 X20", "90 Y50", "180 X15", "135 Y55", "225 Y50", "180 X0", "270 Y40", "225 Y30",
        "315 Y20", "270 Y10", "0 X10",
    ]  # fmt: skip
    ends = plane("G01 F2000\nX10 Y10\n" + "\n".join(f"#ANG={step}" for step in steps))
    assert ends[-1] == [10, 10]
    assert len(ends) == 15


@pytest.mark.spec("isg.g.contour-line-chain")
def test_a_turned_part_with_corners() -> None:
    run = run_of(
        "G18 G90 G00 X0 Z150\nX5 G01 F2000\n#ANG=100 #CHR=5 #FRC=1000\n#ANG=130 X25 Z140 #RND=5 #FRC=1500\n"
        "#ANG=90 X40 #CHR=4 #FRC=1000\nZ120 #RND=5 #FRC=1500\n#ANG=140 X50 #CHR=2 #FRC=1000\nZ100"
    )
    pieces = motions(run)
    assert [type(piece).__name__ for piece in pieces[2:]] == [
        "Line", "Line", "Line", "Arc", "Line", "Line", "Line", "Arc", "Line", "Line", "Line",
    ]  # fmt: skip
    inserts = [block.feed for block in pieces[3::2] if isinstance(block, Line | Arc)]
    assert inserts == [1000, 1500, 1000, 1500, 1000]
    for before, behind in itertools.pairwise(pieces[2:]):
        np.testing.assert_array_equal(before.end, behind.start)  # type: ignore[union-attr]


@pytest.mark.spec("isg.g.contour-line-double", "isg.add.rotation", "isg.g.mirror-plane-g20-g23")
@given(
    st.sampled_from(["", "G21\n", "G54\nG22\n", "#ROTATION ON [ANGLE=37 CENTER1=3]\n", "#SCALE ON X2 Y0.5\n"]),
    st.integers(10, 80),
    st.integers(100, 170),
    st.integers(1, 50),
)
def test_contour_lines_are_those_of_their_points(system: str, first: int, second: int, length: int) -> None:
    """Under everything that changes the contour, like the lines to the points that were computed without."""
    by_angle = f"G00 X2 Y3\nG01 F100\n#ANG={first}\n#ANG={second} X{{x:.9f}} Y{{y:.9f}}"
    a, b = math.radians(first), math.radians(second)
    corner = (2 + length * math.cos(a), 3 + length * math.sin(a))
    end = (corner[0] + 5 * math.cos(b), corner[1] + 5 * math.sin(b))
    points = f"G00 X2 Y3\nG01 F100\nX{corner[0]:.9f} Y{corner[1]:.9f}\nX{end[0]:.9f} Y{end[1]:.9f}"
    text = by_angle.format(x=end[0], y=end[1])
    np.testing.assert_allclose(path(run_of(system + text)), path(run_of(system + points)), atol=1e-6)


@pytest.mark.spec("isg.g.contour-line-single", "isg.g.contour-line-double", "isg.g.contour-line-chain")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G02 #ANG=30 X1 F100", catalogue.ANGLE_WITH_CIRCLE, 1),
        ("G01 F100 #ANG=30 X-1", catalogue.CONTOUR_LINE_UNREACHABLE, 1),
        ("G01 F100 #ANG=90 X1", catalogue.CONTOUR_LINE_UNREACHABLE, 1),
        ("G01 F100 #ANG=45 X1 Y2", catalogue.CONTOUR_LINE_OVERDETERMINED, 1),
        ("G01 F100 #ANG=45", catalogue.CONTOUR_LINE_UNDETERMINED, 2),
        ("G01 F100 #ANG=45\nX5", catalogue.CONTOUR_LINE_UNDETERMINED, 2),
        ("G01 F100 #ANG=45\nX5\nX6", catalogue.CONTOUR_LINE_UNDETERMINED, 2),
        ("G01 F100 #ANG=45\nG02 I5", catalogue.CONTOUR_LINE_UNDETERMINED, 2),
        ("G01 F100 #ANG=45\nG04 1", catalogue.CONTOUR_LINE_UNDETERMINED, 2),
        ("G01 F100 #ANG=45\n#TIME 1", catalogue.CONTOUR_LINE_UNDETERMINED, 2),
        ("G01 F100 #ANG=45\nG91 #ANG=100 X5", catalogue.CONTOUR_LINE_INCREMENTAL, 2),
        ("G01 F100 #ANG=45\n#ANG=45 X5 Y5", catalogue.CONTOUR_LINE_PARALLEL, 2),
        ("G01 F100 #ANG=45\nG18 #ANG=100 X5 Z5", catalogue.CONTOUR_LINE_SYSTEM, 2),
        ("G01 F100 #ANG=45\nG54\n#ANG=100 X5 Y5", catalogue.CONTOUR_LINE_SYSTEM, 3),
        ("G01 F100 #ANG=45 I5 X5", catalogue.CENTRE_WITHOUT_CIRCLE, 1),
        ("G01 F100 #ANG=45 #CANG=5 X5", catalogue.ANGLE_WITHOUT_CIRCLE, 1),
        ("G01 #ANG=45 X5", catalogue.FEED_MISSING, 1),
        ("G01 #ANG=45\n#ANG=100 X5 Y5", catalogue.FEED_MISSING, 1),
        ("G92 X1 #ANG=5", catalogue.ADDITION_WITHOUT_MOTION, 1),
    ],
)
def test_wrong_contour_lines(text: str, entry: ErrorEntry, line: int) -> None:
    assert entries(text) == [(entry, line)]


@pytest.mark.spec("isg.g.contour-line-double")
def test_nothing_of_a_line_without_a_target_is_put_out() -> None:
    run = decode("G00 X1\nG01 F100 #ANG=45 M10\nM11\nX5 M14\nM30")
    assert run.problem is not None
    assert run.ends == [[1, 0, 0]]
    assert [block.number for block in run.blocks if isinstance(block, TechnologyFunction)] == [10]
    open_end = decode("G01 F100 #ANG=45")
    assert open_end.problem is not None
    assert (open_end.problem.entry, open_end.problem.place.line) == (catalogue.CONTOUR_LINE_UNDETERMINED, 1)
    assert not any(isinstance(block, Stop) for block in open_end.blocks)


def test_a_plane_that_the_channel_has_not() -> None:
    two = replace(SETUP, axes=("X", "Y"), linear=(True, True), zero_offsets={})
    for text in ("G18 G01 X1 F100 #RND=1\nX2", "G18 G01 #ANG=5 X1 F100"):
        run = decode(f"{text}\nM30", two, start=(0, 0))
        assert run.problem is not None
        assert run.problem.entry is catalogue.PLANE_UNAVAILABLE
