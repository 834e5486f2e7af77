"""Lines, arcs, spirals, helices, dwells; absolute, incremental and polar coordinates; units; feeds. Values from the manual's
examples, or by plain geometry."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Block, Dwell, ExactStop, Line, Polyline, Suppression
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.tools.offset_table import MemoryOffsets
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct as C  # noqa: N812
from tests.cnc.decoder.nct.programs import SETUP, Run, decode

INCH = 25.4


def with_nct(**values: Any) -> DecoderSetup:
    return replace(SETUP, nct=NctParameters(**values))


def arcs(run: Run) -> list[Arc]:
    assert run.problem is None, run.problem
    return [block for block in run.blocks if isinstance(block, Arc)]


def feeds(run: Run) -> list[float]:
    found: list[float] = []
    for block in run.blocks:
        if isinstance(block, Polyline):
            found += [float(feed) for feed in block.feeds]
        elif isinstance(block, Line | Arc):
            found.append(block.feed)
    return found


@pytest.mark.spec("nct.motion.linear-g01", "nct.lexis.modal-and-one-shot")
def test_lines_are_modal_and_may_have_any_axes() -> None:
    run = decode("N15 G90 G1 X20 Y30 F180\nN16 X30\nN17 Y100\nG0 Z5\nX0 Y0 Z0\n")
    assert run.ends == [[20, 30, 0], [30, 30, 0], [30, 100, 0], [30, 100, 5], [0, 0, 0]]
    assert feeds(run) == [180, 180, 180, math.inf, math.inf]
    assert [row["n"] for row in run.of_type("line")] == [15, 16, 17, None, None]


@pytest.mark.spec("nct.coord.absolute-incremental-g90-g91")
def test_absolute_incremental_and_the_operator_i() -> None:
    expected = [[60, 20, 0], [20, 50, 0]]
    for second in ("G90 X20 Y50", "G91 X-40 Y30", "G90 XI-40 YI30", "X20 YI30", "XI-40 Y50"):
        assert decode(f"G0 X60 Y20\nG1 F100 {second}\n").ends == expected
    assert decode("G91 G0 X1\nX1 Y1\nG90 X5\n").ends == [[1, 0, 0], [2, 1, 0], [5, 1, 0]]


@pytest.mark.spec("nct.lexis.number-format")
def test_numbers() -> None:
    assert decode("G0 X325 Y.032 Z0.320\nX-0.5 Y+2. Z00.5\n").ends == [[325, 0.032, 0.32], [-0.5, 2, 0.5]]
    assert decode("G0 X1.23456\n").ends[0][0] == 1.235  # rounded to the increment, not cut
    assert decode("G20 G0 X1.23456\n").ends[0][0] == pytest.approx(1.2346 * INCH, abs=1e-12)
    assert decode("G0 X1.23456\n", with_nct(increment="IS-A")).ends[0][0] == 1.23
    assert decode("G0 X1.23456\n", with_nct(increment="IS-C")).ends[0][0] == 1.2346
    beyond = decode("G0 X99999.9996\n").problem
    assert beyond is not None
    assert beyond.entry is C.VALUE_EXCESS


def test_words_need_no_blanks() -> None:
    run = decode("N12345G1X0Y1F100\ng01x2 y 3\nG01XI-1YI-1\n")
    assert run.ends == [[0, 1, 0], [2, 3, 0], [1, 2, 0]]
    assert run.rows[0]["n"] == 12345


# -- arcs ----------------------------------------------------------------------------------------------------------


@pytest.mark.spec("nct.motion.circular-g02-g03")
@pytest.mark.parametrize(
    ("code", "radius", "angle"), [("G02", "R40", -1), ("G02", "R-40", -2), ("G03", "R40", 1), ("G03", "R-40", 2)]
)
def test_arcs_by_radius(code: str, radius: str, angle: int) -> None:
    (arc,) = arcs(decode(f"G0 X0 Y0\n{code} X50 Y40 {radius} F100\n"))
    short = 2 * math.degrees(math.asin(math.hypot(50, 40) / 2 / 40))
    expected = short if abs(angle) == 1 else 360 - short
    assert arc.angle == pytest.approx(math.copysign(expected, angle))
    assert arc.radius == pytest.approx(40)
    for point in (arc.start, arc.end):
        assert math.dist(point[:2], arc.centre) == pytest.approx(40)
    assert arc.feed == 100


@pytest.mark.parametrize(
    ("plane", "start", "end", "plane_axes"),
    [
        ("G17", "X80 Y40", "X10 Y70 I-50 J-20", (0, 1)),
        ("G18", "X40 Z80", "X70 Z10 I-20 K-50", (2, 0)),
        ("G19", "Y80 Z40", "Y10 Z70 J-50 K-20", (1, 2)),
    ],
)
def test_centres_count_from_the_start(plane: str, start: str, end: str, plane_axes: tuple[int, int]) -> None:
    """The example of the manual, started where its centre fits: the centre is the start and I, J, K."""
    (arc,) = arcs(decode(f"{plane} G0 {start}\nG03 {end} F100\n"))
    assert arc.plane == plane_axes
    assert arc.centre == pytest.approx([30, 20])
    assert arc.angle == pytest.approx(90)


@pytest.mark.spec("nct.motion.circular-g02-g03")
def test_without_a_target_it_is_a_full_circle() -> None:
    (arc,) = arcs(decode("G0 X50 Y0\nG03 I-100 F100\n"))
    assert arc.angle == 360
    assert arc.centre == pytest.approx([-50, 0])
    (arc,) = arcs(decode("G0 X50 Y0\nG02 X50 Y0 I-100 F100\n"))
    assert arc.angle == -360


@pytest.mark.spec("nct.motion.spiral")
def test_spiral_by_centre() -> None:
    """G3 X-20 I-50 from X50: 50 mm at the start, 20 mm at the end, linear over the angle."""
    pieces = arcs(decode("G17 G90 G0 X50 Y0\nG3 X-20 I-50 F100\n", with_nct(raddif=30.0)))
    assert sum(piece.angle for piece in pieces) == pytest.approx(180)
    passed = 0.0
    for piece in pieces:
        assert piece.centre == pytest.approx([0, 0])
        assert math.dist(piece.start[:2], (0, 0)) == pytest.approx(50 - 30 * passed / 180, abs=1e-9)
        passed += piece.angle
    assert pieces[-1].end[:2] == pytest.approx([-20, 0])


@pytest.mark.spec("nct.motion.spiral")
def test_spiral_by_a_small_radius() -> None:
    """G2 X40 Y30 R10 from the origin: the chord is 50, the centre lies on it 10 from the start, the end is 40 away."""
    pieces = arcs(decode("G17 G0 G90 X0 Y0\nG2 X40 Y30 R10 F100\n"))
    assert pieces[0].centre == pytest.approx([8, 6])
    assert sum(piece.angle for piece in pieces) == pytest.approx(-180)
    assert math.dist(pieces[0].start[:2], (8, 6)) == pytest.approx(10)
    assert math.dist(pieces[-1].end[:2], (8, 6)) == pytest.approx(40)
    assert pieces[-1].end[:2] == pytest.approx([40, 30])


@pytest.mark.spec("nct.motion.helical")
def test_helix_and_what_its_feed_means() -> None:
    text = "G17 G0 X100 Y0\nG03 X0 Y100 Z20 R100 F150\n"
    (arc,) = arcs(decode(text))
    along = math.pi / 2 * 100
    # F on the circle: the path is longer by the way of Z and driven in the same time
    assert arc.feed == pytest.approx(150 * math.hypot(along, 20) / along)
    assert arc.end[2] == 20
    (arc,) = arcs(decode(text, with_nct(helicalf=True)))
    assert arc.feed == pytest.approx(150)


def test_a_helix_with_another_axis_beside_it() -> None:
    setup = replace(SETUP, axes=("X", "Y", "Z", "V"), linear=(True,) * 4)
    (arc,) = arcs(decode("G17 G90 G0 X100 Y0\nG3 X0 Y-100 Z50 V20 I-100 F150\n", setup))
    assert arc.angle == pytest.approx(270)
    assert list(arc.end) == pytest.approx([0, -100, 50, 20])


# -- feed ----------------------------------------------------------------------------------------------------------


@pytest.mark.spec("nct.motion.linear-g01")
def test_degrees_count_as_lengths() -> None:
    """G91 G1 Z100 B45 F120: Z goes at 120 · 100 / L, B at 120 · 45 / L, with L = √(100² + 45²)."""
    setup = replace(SETUP, axes=("X", "Y", "Z", "B"), linear=(True, True, True, False))
    run = decode("G91 G1 Z100 B45 F120\nB270\n", setup)
    minutes = math.hypot(100, 45) / 120
    first, second = (block for block in run.blocks if isinstance(block, Line))
    assert first.feed == pytest.approx(100 / minutes)  # the queue measures the main axes
    assert second.feed == pytest.approx(120)  # degrees/min
    run = decode("G20 G91 G1 B270 F12\n", setup)
    assert feeds(run) == pytest.approx([12])  # degrees are never inches


@pytest.mark.spec("nct.feed.cutting-g94-g95", "nct.config.inch-metric-g20-g21")
def test_feed_per_minute_and_per_revolution_and_in_inch() -> None:
    assert feeds(decode("G1 X1 F100\nX2\nG95 X3 F0.5 S600\nX4\nG94 X5 F100\n")) == [100, 100, 300, 300, 100]
    assert feeds(decode("G20 G1 X1 F10\nG21 X1 F10\n")) == pytest.approx([254, 10])
    assert decode("G20 G1 X1 Y-2 F10\n").ends == [[INCH, -2 * INCH, 0]]
    assert feeds(decode("G1 X1\n", with_nct(feed=2.0))) == [120]
    for text in ("G1 X1 F25000.1\n", "G1 X1 F0.00004\n", "G95 S1 G1 X1 F500.1\n", "G20 G1 X1 F985\n"):
        problem = decode(text).problem
        assert problem is not None
        assert problem.entry is C.VALUE_EXCESS, text


def test_an_arc_in_inch() -> None:
    (arc,) = arcs(decode("G20 G0 X1 Y0\nG3 X0 Y1 I-1 F10\n"))
    assert arc.radius == pytest.approx(INCH)
    assert arc.feed == pytest.approx(254)
    assert arc.angle == pytest.approx(90)


@pytest.mark.spec("nct.config.inch-metric-g20-g21")
def test_the_unit_outlives_the_program() -> None:
    memory = ChannelMemory(SETUP)
    decode("G20 G0 X1\nM30\n", memory=memory)
    assert decode("G0 X1\nM30\n", memory=memory).ends == [[INCH, 0, 0]]
    assert decode("G21 G0 X1\nM30\n", memory=memory).ends == [[1, 0, 0]]
    assert decode("G0 X1\nM30\n", memory=memory).ends == [[1, 0, 0]]


@pytest.mark.spec("nct.config.inch-metric-g20-g21")
def test_the_unit_outlives_the_machine() -> None:
    offsets = MemoryOffsets()
    decode("G20 G0 X1\nM30\n", memory=ChannelMemory(SETUP, offsets=offsets))
    assert decode("G0 X1\nM30\n", memory=ChannelMemory(SETUP, offsets=offsets)).ends == [[INCH, 0, 0]]


@pytest.mark.spec("nct.feed.clamp")
def test_the_feed_of_an_axis_is_limited_quietly() -> None:
    setup = with_nct(feedmax={"X": 100 / 60, "Z": 10 / 60})
    run = decode("G1 X10 F1000\nY10\nZ10\nX20 Y20\nG3 X30 Y10 R10\n", setup)
    assert run.problem is None
    assert feeds(run) == pytest.approx([100, 1000, 10, 100 * math.sqrt(2), 100])
    run = decode("S100 G95 G1 X10 F5\n", setup)  # the limit is per minute here too
    assert feeds(run) == pytest.approx([100])


# -- dwell, exact stop ---------------------------------------------------------------------------------------------


@pytest.mark.spec("nct.motion.dwell-g04")
def test_dwell() -> None:
    def seconds(text: str, **nct: object) -> list[float]:
        return [b.seconds for b in decode(text, with_nct(**nct)).blocks if isinstance(b, Dwell)]

    assert seconds("G4 P0.5\nG04 P10\nX5\n") == [0.5, 10]
    assert seconds("S600 G95\nG4 P5\n") == [0.5]
    assert seconds("S600 G95\nG4 P5\n", second=True) == [5]
    assert decode("G4 P1\nG1 X5 F100\n").ends == [[5, 0, 0]]


def stops(text: str, **nct: object) -> list[str]:
    """M for a motion, | for an exact stop."""
    names: list[str] = []
    for block in decode(text, with_nct(**nct)).blocks:
        if isinstance(block, Polyline):
            names += "M" * len(block.feeds)
        elif isinstance(block, Line | Arc):
            names.append("M")
        elif isinstance(block, ExactStop):
            names.append("|")
    return names


def test_exact_stop() -> None:
    assert "".join(stops("G1 X1 F100\nG9 X2\nX3\n")) == "MM|M"
    assert "".join(stops("G61 G1 X1 F100\nX2\nM7\nG64 X3\nX4\n")) == "M|M|MM"
    assert "".join(stops("G9\nG1 X1 F100\nG4 P1\n")) == "M"
    assert "".join(stops("G0 X1\nX2\nG1 X3 F100\n", poscheck=True)) == "M|M|M"
    assert "".join(stops("G0 X1\nX2\n")) == "MM"


@pytest.mark.spec("nct.feed.override-inhibit-g63")
def test_stop_and_override_have_no_effect_in_g63() -> None:
    def of(text: str) -> list[object]:
        run = decode(text)
        assert run.problem is None
        found: list[object] = []
        for block in run.blocks:
            if isinstance(block, Suppression):
                found.append((block.feed_stop, block.override))
            elif isinstance(block, Line | Polyline | ExactStop):
                found.append(type(block).__name__)
        return found

    move, both, none = "Line", (True, True), (False, False)
    assert of("G1 X1 Z1 F100\nG63 X2\nG63 G91 X1\nG64 X1\n") == [move, both, move, move, none, move]
    assert of("G63\nG61 G1 X1 F100\n") == [both, none, move, "ExactStop"]
    # what #3004 has taken away stays so behind G63
    assert of("#3004=2\nG63\n#3004=0\nG64\n") == [(False, True), both, both, none]


# -- polar ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("nct.coord.polar-data-g15-g16")
def test_the_hexagon_of_the_manual() -> None:
    run = decode(
        "N1 G90 G17 G0 X60 Y0 F120\nN2 G16 G1 Y60\nN3 Y120\nN4 Y180\nN5 Y240\nN6 Y300\nN7 Y360\nN8 G15 G0 X100\n"
    )
    assert run.problem is None
    expected = [[60 * math.cos(math.radians(a)), 60 * math.sin(math.radians(a))] for a in range(0, 361, 60)]
    assert [end[:2] for end in run.ends[:7]] == [pytest.approx(point, abs=1e-9) for point in expected]
    assert run.ends[7] == pytest.approx([100, 0, 0])


@pytest.mark.spec("nct.coord.polar-data-g15-g16")
def test_polar_words_may_be_incremental_each_by_itself() -> None:
    def at(radius: float, angle: float) -> object:
        return pytest.approx(
            [radius * math.cos(math.radians(angle)), radius * math.sin(math.radians(angle)), 0], abs=1e-9
        )

    run = decode("G90 G16 G1 X100 Y60 F180\nYI40\nX50 Z3\n")
    assert run.ends[:2] == [at(100, 60), at(100, 100)]
    assert run.ends[2][2] == 3
    assert math.hypot(*run.ends[2][:2]) == pytest.approx(50)
    # an incremental radius counts from where the axes are
    assert decode("G0 X10 Y20\nG16 G1 XI5 Y90 F100\n").ends[1] == pytest.approx([10, 25, 0])
    assert decode("G18 G16 G0 Z10 X90\n").ends == [pytest.approx([10, 0, 0], abs=1e-9)]  # Z is the radius, X the angle


@pytest.mark.spec("nct.coord.polar-data-g15-g16")
def test_a_helix_of_several_turns() -> None:
    """G02 X100 Y-990 from an angle of 0: two turns and three quarters."""
    (arc,) = arcs(decode("G0 X100 Y0\nG17 G16 G90 G02 X100 Y-990 Z50 R-100 F100\n"))
    assert arc.angle == pytest.approx(-990)
    assert arc.centre == pytest.approx([0, 0], abs=1e-9)
    assert list(arc.end) == pytest.approx([0, 100, 50], abs=1e-9)
    (arc,) = arcs(decode("G0 X100 Y0\nG16 G03 Y450 I-100 F100\n"))
    assert arc.angle == pytest.approx(450)
    (arc,) = arcs(decode("G0 X100 Y0\nG16 G03 Y720 I-100 F100\n"))
    assert arc.angle == pytest.approx(720)
    problem = decode("G0 X100 Y0\nG16 G02 Y450 I-100 F100\n").problem
    assert problem is not None
    assert problem.entry is C.POLAR_TURNS


def test_a_plane_that_the_channel_does_not_have() -> None:
    setup = replace(SETUP, axes=("X", "Y"), linear=(True, True))
    problem = decode("G18 G16 G0 X5\n", setup).problem
    assert problem is not None
    assert problem.entry is C.PLANE_MISSING


# -- lines by their angle, corners ---------------------------------------------------------------------------------


@pytest.mark.spec("nct.geo.line-with-angle")
def test_lines_by_their_angle() -> None:
    """The square of the manual: tan 30° and tan 120° give the other coordinate."""
    run = decode("G17 G90 G0 X57.735 Y0\nG1 G91 F100\nX100 ,A30\nY100 ,A120\nX-100 ,A210\nY-100 ,A300\n")
    assert run.problem is None
    steps = [[b - a for a, b in zip(p, q, strict=True)] for p, q in zip(run.ends, run.ends[1:], strict=False)]
    expected = [[100, 57.735], [-57.735, 100], [-100, -57.735], [57.735, -100]]
    assert [step[:2] for step in steps] == [pytest.approx(point, abs=1e-3) for point in expected]
    assert decode("G0 X10 ,A-315\n").ends == [pytest.approx([10, 10, 0])]
    assert decode("G18 G0 Z10 ,A45 Y7\n").ends == [pytest.approx([10, 7, 10])]
    for text in ("G0 X10 Y5 ,A30\n", "G0 Z5 ,A30\n", "G0 X5 ,A90\n"):
        problem = decode(text).problem
        assert problem is not None
        assert problem.entry is C.ANGLE_COORDINATE


@pytest.mark.spec("nct.geo.chamfer-rounding")
def test_chamfer_and_rounding() -> None:
    run = decode("G1 F100 X30 ,C10\nX30 Y40 ,R5\nX0\n")
    assert run.ends[:2] == [pytest.approx([20, 0, 0]), pytest.approx([30, 10, 0])]
    assert run.ends[2:4] == [pytest.approx([30, 35, 0]), pytest.approx([25, 40, 0])]
    (arc,) = arcs(run)
    assert arc.radius == pytest.approx(5)
    assert run.ends[4] == pytest.approx([0, 40, 0])


@pytest.mark.spec("nct.geo.chamfer-rounding")
@pytest.mark.parametrize(
    ("text", "entry", "line"),
    [
        ("G1 X10 ,C1 ,R1 F100\nY10\n", C.CORNER_BOTH, 1),
        ("G0 X10 ,C1\nG1 Y10 F100\n", C.CORNER_DEFINITION, 1),
        ("G1 X10 ,C1 F100\nG0 Y10\n", C.CORNER_DEFINITION, 1),
        ("G1 X10 Z1 ,C1 F100\nY10\n", C.CORNER_DEFINITION, 1),
        ("G1 X10 ,C1 F100\nZ10\n", C.CORNER_DEFINITION, 1),
        ("G1 X10 ,C0 F100\nY10\n", C.CORNER_DEFINITION, 1),
        ("G1 X10 ,C1 F100\nM30\n", C.CORNER_DEFINITION, 1),
        ("G1 X10 ,R11 F100\nY10\n", C.CORNER_HIGH, 1),
    ],
)
def test_corners_that_cannot_be(text: str, entry: object, line: int) -> None:
    problem = decode(text).problem
    assert problem is not None
    assert (problem.entry, problem.place.line) == (entry, line)


# -- laws ----------------------------------------------------------------------------------------------------------

_LENGTHS = st.integers(-9_999_999, 9_999_999).map(lambda n: n / 1000)


@given(st.lists(st.tuples(_LENGTHS, _LENGTHS), min_size=1, max_size=8))
def test_absolute_and_incremental_words_lead_to_the_same_places(points: list[tuple[float, float]]) -> None:
    absolute = "".join(f"G0 X{x:.3f} Y{y:.3f}\n" for x, y in points)
    steps, before = "G91\n", (0.0, 0.0)
    for x, y in points:
        steps += f"G0 X{x - before[0]:.3f} Y{y - before[1]:.3f}\n"
        before = (x, y)
    one, two = decode(absolute).ends, decode(steps).ends
    assert [end[:2] for end in two] == [pytest.approx(end[:2], abs=1e-6) for end in one]


@given(st.sampled_from(["G1 X1 Y2.5 F100", "N7 G0 XI-3 Z.5", "G90 G3 X10 Y0 R5", "M8", "S500 M3 X-1.25"]), st.data())
def test_formulas_of_plain_numbers_are_numbers(text: str, data: st.DataObject) -> None:
    """The road of the regular expression and that of the grammar give the same blocks."""
    start = "G0 X0 Y0\nG1 F100\n"
    bracketed = "".join(
        f"{word[:2] if word[1:2] == 'I' else word[0]}[{word[2:] if word[1:2] == 'I' else word[1:]}]"
        if word[0] in "XYZRSF" and data.draw(st.booleans())
        else word
        for word in text.split()
    )
    plain, formula = (decode(f"{start}{block}\n") for block in (text, bracketed))
    assert plain.rows == formula.rows


def test_blocks_of_the_fast_road_are_those_of_the_long_one() -> None:
    def moves(blocks: list[Block]) -> list[tuple[list[float], float, int]]:
        found = []
        for block in blocks:
            if isinstance(block, Polyline):
                found += [
                    (list(block.points[i + 1]), float(block.feeds[i]), int(block.lines[i]))
                    for i in range(len(block.feeds))
                ]
            elif isinstance(block, Line):
                found.append((list(block.end), block.feed, block.source.line))
        return found

    text = "G1 X1 F100\nX2 Y1\nG0 Z5\nG91 X1\nG1 X1 Y-1\nG20\nX1\n"
    fast = moves(decode(text).blocks)
    slow = moves(decode(text, with_nct(feedmax={"X": 1e6})).blocks)
    assert [move[0] for move in fast] == [pytest.approx(move[0]) for move in slow]
    assert [move[1:] for move in fast] == [move[1:] for move in slow]
    assert len(fast) == 6
