"""Cutter compensation in programs: text in, tool path out. Places are derived from the rules; D1 is 5 mm."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import Arc
from runtime.cnc.decoder import ChannelMemory, DecoderSetup
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.cnc.tools.offset_table import MemoryOffsets, Register
from runtime.config.nct import NctParameters
from runtime.diagnostics.catalogue import nct, nct_offsets
from tests.cnc.decoder.nct.programs import SETUP, decode, found
from tests.cnc.tool_radius_comp.paths import Path, compensate

R = 5.0
REGISTERS = {
    ("D", 1): Register(4.0, 1.0),
    ("D", 2): Register(-5.0),
    ("D", 3): Register(10.0),
    ("H", 1): Register(50.0),
}
POINTS = replace(SETUP, reference_points=(0.0, 0.0, 300.0))


def tool_path(text: str, setup: DecoderSetup = SETUP) -> Path:
    """The tool path of a program, which goes on in G0 if it says nothing else."""
    run = decode(text, setup, memory=ChannelMemory(setup, offsets=MemoryOffsets(REGISTERS)))
    assert run.problem is None, run.problem
    return compensate(run.blocks)


def places(text: str, setup: DecoderSetup = SETUP) -> list[list[float]]:
    """Where the motions of the tool end in X and Y."""
    path = tool_path(text, setup)
    assert path.error is None, path.error
    return [[round(float(value), 6) + 0.0 for value in motion.end[:2]] for motion in path.motions]


# ---------------------------------------------------------------------------------------------------- modes


@pytest.mark.spec("nct.trc.mode-g40-g41-g42", "nct.trc.start-up", "nct.trc.cancel-g40")
@pytest.mark.parametrize(
    ("code", "register", "y"), [("G41", 1, R), ("G42", 1, -R), ("G41", 2, -R), ("G42", 2, R), ("G41", 0, 0)]
)
def test_left_and_right_of_the_contour(code: str, register: int, y: float) -> None:
    path = places(f"G0 X-20\n{code} G1 X0 D{register} F100\nX40\nG40 X60")
    assert path == [[-20, 0], [0, y], [40, y], [60, 0]]


@pytest.mark.spec("nct.trc.mode-g40-g41-g42")
@pytest.mark.parametrize(("plane", "first", "second"), [("G18", "Z", "X"), ("G19", "Y", "Z")])
def test_in_the_selected_plane(plane: str, first: str, second: str) -> None:
    text = "G17 G0 X-20\nG41 G1 X0 D1 F100\nX40\nY40\nG3 X20 Y60 R20\nG40 G1 X0"
    other = text.replace("X", "a").replace("Y", second).replace("a", first).replace("G17", plane)
    run = tool_path(other)
    axes = ["XYZ".index(first), "XYZ".index(second)]
    assert np.allclose([m.end[axes] for m in run.motions], places(text))


@pytest.mark.spec("nct.trc.mode-g40-g41-g42")
def test_d0_takes_the_vector_and_leaves_the_mode() -> None:
    text = "G0 X-20\nG41 G1 X0 D1 F100\nX40\nX80 D0\nX120 D1\nX160\nG40 X200"
    assert places(text) == [[-20, 0], [0, R], [40, R], [80, 0], [120, R], [160, R], [200, 0]]


@pytest.mark.spec("nct.trc.mode-g40-g41-g42")
def test_behind_g40_a_d_has_no_effect() -> None:
    assert places("G0 X-20\nG41 G1 X0 D1 F100\nX40\nG40 X80\nX120 D3")[-1] == [120, 0]


@pytest.mark.spec("nct.trc.mode-g40-g41-g42")
def test_every_program_begins_with_g40() -> None:
    memory = ChannelMemory(SETUP, offsets=MemoryOffsets(REGISTERS))
    decode("G41 G0 X10 D1\nX20", memory=memory)
    assert compensate(decode("G0 X10 D1\nX20", memory=memory).blocks).motions[-1].end[1] == 0


@pytest.mark.spec("nct.trc.mode-g40-g41-g42")
def test_a_mirror_image_swaps_the_side_and_a_rotation_turns_the_path() -> None:
    contour = "G0 X-20 Y0\nG41 G1 X0 D1 F100\nX40\nY40\nG3 X20 Y60 R20\nG40 G1 X0"
    plain = np.array(places(contour))
    assert np.allclose(places("G51.1 Y0\n" + contour), plain * [1, -1])
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    assert np.allclose(places("G68 X0 Y0 R30\n" + contour), plain @ np.array([[c, s], [-s, c]]), atol=1e-6)


@pytest.mark.spec("nct.trc.mode-g40-g41-g42")
def test_scaling_leaves_the_tool_as_it_is() -> None:
    text = "G51 X0 Y0 P2\nG0 X-10\nG41 G1 X0 D1 F100\nX20\nY20\nG40 Y30"
    assert places(text) == [[-20, 0], [0, R], [40 - R, R], [40 - R, 40], [40, 60]]


# ---------------------------------------------------------------------------------------------------- corners


@pytest.mark.spec("nct.trc.corner-strategy", "nct.trc.offset-mode")
def test_corners_of_a_triangle() -> None:
    """Outside, acute, obtuse: 45 degrees at both ends of the long side, 90 at the top."""
    path = places("G0 X-50 Y-20\nG41 G1 X0 Y0 D1 F100\nX40 Y40\nX80 Y0\nX0\nG40 X-50 Y-20")
    s = math.sqrt(0.5)
    top = [40, 40 + R / s]
    right = [[80 + 2 * R * s, 0], [80 + R, -R]]
    assert np.allclose(path[2], top)
    assert np.allclose(path[3:5], right)


@pytest.mark.spec("nct.trc.offset-mode")
def test_without_intersection() -> None:
    x, y = 40 - 6 * math.cos(0.3), 6 * math.sin(0.3)
    path = tool_path(f"G0 X-20\nG41 G1 X0 D1 F1000\nX20\nX40\nG3 X{2 * x - 40:.5f} Y{2 * y:.5f} R6\nG1 Y60")
    assert path.error is not None
    assert path.error.problem.entry is nct_offsets.NO_INTERSECTION
    assert path.error.problem.place.line == 4


@pytest.mark.spec("nct.trc.offset-mode")
def test_a_move_of_no_length_sets_the_vector_square() -> None:
    """The example: 40, 50 and then along X."""
    path = places("G91 G17 G0 X-20\nG42 G1 X20 D1 F100\nN110 X40 Y50\nN120 X0\nN130 X90\nN140 X50 Y-20")
    u = np.array([40, 50]) / math.hypot(40, 50)
    square = np.array([40, 50]) + R * np.array([u[1], -u[0]])
    assert any(np.allclose(place, square, atol=1e-6) for place in path)


# ---------------------------------------------------------------------------------------------------- start, end


@pytest.mark.spec("nct.trc.start-up-without-motion")
@pytest.mark.parametrize("select", ["G42 D1", "G91 G42 D1 X0"])
def test_started_without_motion(select: str) -> None:
    """The example: to 80, 0 and on to 110, 60; G42 is outside there."""
    path = places(f"N10 G40 G17 G0 X0 Y0\nN15 {select}\nN20 G90 G1 X80 F100\nN25 X110 Y60\nX140 Y120")
    on = R * math.tan(math.atan2(60, 30) / 2)
    there = [place for place in path if place != [0, 0]]  # without moves of no length
    assert np.allclose(there[0], [80 + on, -R], atol=1e-6)


@pytest.mark.spec("nct.trc.start-up-without-motion")
def test_nothing_follows_the_start_in_the_plane() -> None:
    path = places("G0 X0\nN15 G91 G42 D1 X80\nN20 G1 X0 F100\nN25 X30 Y60\nN30 X60")
    assert path[:2] == [[0, 0], [80, -R]]


@pytest.mark.spec("nct.trc.start-up-ijk")
def test_started_and_ended_along_walls() -> None:
    """The example, from 80 right of a wall that runs along 50, 70: it meets the offset of the contour at Y = -5."""
    path = places("G91 G17 G40\nN110 G42 G1 X-80 Y60 I50 J70 D1 F100\nN120 X100\nN130 G40 X70 Y-60 I100 J-20")
    u = np.array([50, 70]) / math.hypot(50, 70)
    wall = np.array([-80, 60]) + R * np.array([u[1], -u[0]])  # the wall, 5 mm to the right
    there = wall + (60 - R - wall[1]) / u[1] * u
    assert np.allclose(path[0], there, atol=1e-6)
    v = np.array([100, -20]) / math.hypot(100, 20)
    second = np.array([20, 60]) + R * np.array([v[1], -v[0]])
    assert np.allclose(path[1], second + (60 - R - second[1]) / v[1] * v, atol=1e-6)
    assert path[2] == [90, 0]


@pytest.mark.spec("nct.trc.start-up-ijk")
def test_a_mirror_image_turns_the_walls() -> None:
    text = "G90 G17\nG42 G1 X-80 Y60 I50 J70 D1 F100\nX20\nG40 X90 Y0 I100 J-20"
    assert np.allclose(places("G51.1 X0\n" + text), np.array(places(text)) * [-1, 1], atol=1e-6)


@pytest.mark.spec("nct.trc.cancel-g40")
def test_cancelled_alone_or_without_length() -> None:
    """The examples: to 80, 40, then 70 back and 20 up."""
    start = "G91 G17 G0 X-20\nG42 G1 X20 D1 F100\nN110 X80 Y40\n"
    u = np.array([80, 40]) / math.hypot(80, 40)
    square = np.array([80, 40]) + R * np.array([u[1], -u[0]])
    alone = places(start + "N120 G40\nN130 X-70 Y20")
    assert np.allclose(alone[-2:], [list(square), [10, 60]], atol=1e-6)
    at_once = places(start + "N120 G40 X0\nN130 X-70 Y20")
    assert np.allclose(at_once[-3:], [list(square), [80, 40], [10, 60]], atol=1e-6)


# ---------------------------------------------------------------------------------------------------- side, radius


@pytest.mark.spec("nct.trc.change-side")
@pytest.mark.parametrize("change", ["G41", "D2"])
def test_the_side_changes_by_its_code_or_by_the_sign_of_d(change: str) -> None:
    path = places(f"G0 X-20\nG42 G1 X0 D1 F100\nX40\n{change} Y-40\nX80")
    assert path[2] == [40 + R, -R]


@pytest.mark.spec("nct.trc.change-side")
def test_a_side_change_over_an_arc() -> None:
    path = tool_path("G0 X-20\nG41 G1 X0 D1 F100\nX40\nG3 Y40 J20\nG42 G1 X0\nX-40")
    assert path.error is None
    arc = next(m for m in path.motions if isinstance(m, Arc))
    assert arc.radius == pytest.approx(20)
    assert np.allclose(arc.end[:2], [40, 45])
    far = tool_path("G0 X-20\nG41 G1 X0 D1 F100\nX40\nG3 Y40 J20\nG42 G1 X0 D3\nX-40")
    assert far.error is not None
    assert far.error.problem.entry is nct_offsets.CHANGE_IMPOSSIBLE


@pytest.mark.spec("nct.trc.varying-radius-and-full-circles")
def test_full_circles_and_spirals() -> None:
    """The example of two changes of the side; and an arc whose end is a hundredth nearer to the centre than its start."""
    path = tool_path("G17 G91\nG42 G1 X30 Y-40 D1 F100\nN120 G41 G2 J-40\nN130 G42 G1 X30 Y40\nX10")
    (arc,) = (m for m in path.motions if isinstance(m, Arc))
    assert arc.angle < -360
    cancelled = tool_path("G17 G90 G0 X0\nG41 G1 X30 D1 F100\nX60\nN100 G2 J-60\nN110 G40 G1 X120 Y180 I-60 J-60")
    circles = [m for m in cancelled.motions if isinstance(m, Arc)]
    assert sum(m.angle for m in circles) < -360
    run = decode(
        "G0 X-20\nG41 G1 X0 D1 F100\nX40\nG3 X40 Y39.99 I0 J20\nG1 X0",
        memory=ChannelMemory(SETUP, offsets=MemoryOffsets(REGISTERS)),
    )
    arcs = [block for block in ToolRadiusCompensation()(run.blocks) if isinstance(block, Arc)]
    assert math.dist(arcs[0].start[:2], (40, 20)) == pytest.approx(15)
    assert math.dist(arcs[-1].end[:2], (40, 20)) == pytest.approx(14.99)


@pytest.mark.spec("nct.trc.new-d-value")
def test_a_new_d_holds_at_the_end_of_its_block() -> None:
    path = places("G0 X-20\nG41 G1 X0 D1 F100\nX40\nX80 D3\nY60\nG40 Y80")
    assert path == [[-20, 0], [0, R], [40, R], [70, 10], [70, 60], [80, 80]]


@pytest.mark.spec("nct.trc.new-d-value")
def test_a_new_d_in_an_arc() -> None:
    text = "G0 X-20\nG41 G1 X0 D1 F100\nX40\nG3 Y40 J20 D3\nG1 X0"
    run = decode(text, memory=ChannelMemory(SETUP, offsets=MemoryOffsets(REGISTERS)))
    arcs = [block for block in ToolRadiusCompensation()(run.blocks) if isinstance(block, Arc)]
    assert math.dist(arcs[0].start[:2], (40, 20)) == pytest.approx(15)
    assert math.dist(arcs[-1].end[:2], (40, 20)) == pytest.approx(10)
    assert sum(arc.angle for arc in arcs) == pytest.approx(180)


# ---------------------------------------------------------------------------------------------------- G38, G39


@pytest.mark.spec("nct.trc.vector-hold-g38")
def test_g38_keeps_the_vector() -> None:
    """The second example: away from a straight contour and back."""
    path = places(
        "G17 G91 G0 X-20\nG42 G1 X20 D1 F100\nN110 X40\nN120 G38 X50\nN130 G38 Y70\nN140 G38 Y-70\nN150 X60\nX20"
    )
    assert path[2:6] == [[40, -R], [90, -R], [90, 70 - R], [90, -R]]


@pytest.mark.spec("nct.trc.corner-arc-g39")
def test_g39_goes_around_the_corner() -> None:
    """The example: along X, then an arc downwards that begins in the direction of -Y."""
    path = tool_path("G17 G91 G0 X-20\nG41 G1 X20 D1 F100\nN110 X100\nN120 G39\nN130 G3 X80 Y-80 I80\nG1 X40")
    assert path.error is None
    around = next(m for m in path.motions if isinstance(m, Arc))
    assert tuple(around.centre) == (100, 0)
    assert around.radius == pytest.approx(R)
    assert around.angle == pytest.approx(-90)  # G02 in G41


@pytest.mark.spec("nct.trc.corner-arc-g39")
@pytest.mark.parametrize("mirror", ["", "G51.1 Y0\n", "G68 X0 Y0 R90\n", "G51 X0 Y0 P1\n"])
def test_g39_ends_square_to_a_direction(mirror: str) -> None:
    """The direction is mirrored and turned as the contour is."""
    path = places(f"{mirror}G17 G91 G0 X-20\nG41 G1 X20 D1 F100\nN110 X100\nN120 G39 I50 J-60\nN130 G40 X110 Y30")
    u = np.array([50, -60]) / math.hypot(50, 60)
    point = np.array([100, 0]) + R * np.array([-u[1], u[0]])
    if "51.1" in mirror:
        point = point * [1, -1]
    if "68" in mirror:
        point = np.array([-point[1], point[0]])
    assert np.allclose(path[3 if len(path) == 5 else -2], point, atol=1e-6)


# ---------------------------------------------------------------------------------------------------- between


@pytest.mark.spec("nct.trc.intervening-blocks")
@pytest.mark.parametrize("between", ["G4 P2", "M8", "S400", "Z-5"])
def test_one_block_between(between: str) -> None:
    path = places(f"G17 G0 X-20\nG41 G1 X0 D1 F100\nX40\n{between}\nY40\nG40 Y60")
    assert [place for place in path if place != [40 - R, R]] == [[-20, 0], [0, R], [40 - R, 40], [40, 60]]


@pytest.mark.spec("nct.trc.intervening-blocks")
def test_two_blocks_between() -> None:
    assert places("G0 X-20\nG41 G1 X0 D1 F100\nX40\nG4 P2\nM8\nY40\nG40 Y60")[2:4] == [[40, R], [40 - R, 40]]


@pytest.mark.spec("nct.trc.intervening-blocks")
def test_down_behind_the_start() -> None:
    """The examples: one block down is right, two distort the path, a little motion between them helps."""
    one = tool_path("G17 G91\nN110 G41 G0 X50 Y70 D1\nN120 G1 Z-40 F100\nN130 Y40\nY10")
    assert [tuple(m.end) for m in one.motions[:3]] == [(50 - R, 70, 0), (50 - R, 70, -40), (50 - R, 110, -40)]
    two = tool_path("G17 G91\nN110 G41 G0 X50 Y70 D1\nN120 Z-35\nN130 G1 Z-5 F100\nN140 Y40\nY10")
    u = np.array([50, 70]) / math.hypot(50, 70)
    assert np.allclose(two.motions[0].end[:2], np.array([50, 70]) + R * np.array([-u[1], u[0]]))
    trick = tool_path("G17 G91\nN110 G41 G0 X50 Y69 D1\nN120 Z-35\nN130 Y1\nN140 G1 Z-5 F100\nN150 Y40\nY10")
    assert [m.end[0] for m in trick.motions] == pytest.approx([50 - R] * len(trick.motions))


@pytest.mark.spec("nct.trc.intervening-blocks")
def test_a_subprogram_may_begin_with_a_motion() -> None:
    main = "G0 X-20\nG41 G1 X0 D1 F100\nX40\nM98 P7\nG40 Y60"
    run = decode(
        main, files={"O0007.nc": "O0007\nG1 Y40\nM99"}, memory=ChannelMemory(SETUP, offsets=MemoryOffsets(REGISTERS))
    )
    assert [tuple(m.end[:2]) for m in compensate(run.blocks).motions] == [
        (-20, 0),
        (0, R),
        (40 - R, R),
        (40 - R, 40),
        (40, 60),
    ]


@pytest.mark.parametrize("change", ["G92 X0 Y0", "G52 X10 Y10", "G55", "G10 X0 L2 P1"])
def test_a_new_system_takes_the_vector_away_for_a_moment(change: str) -> None:
    path = places(f"G91 G17 G0 X-20\nG41 G1 X20 D1 F100\nN110 X80 Y-50\nN120 {change}\nN130 X80 Y50\nX50\nX50")
    assert path[2] == [80, -50]  # without vector
    corner = path[3]
    assert not np.allclose(corner, [160, 0])  # the vector is there again


@pytest.mark.parametrize("change", ["G92 X0", "G52 X1", "G55", "G53 Y80"])
@pytest.mark.parametrize("arc", ["before", "behind"])
def test_not_beside_arcs(change: str, arc: str) -> None:
    one, other = ("G3 X20 Y20 J20", "G1 X40") if arc == "before" else ("G1 X20 Y20", "G91 G3 X20 Y20 J20")
    path = tool_path(f"G0 X-20\nG41 G1 X0 D1 F100\n{one}\n{change}\n{other}\nG1 XI40")
    assert path.error is not None
    assert path.error.problem.entry is nct_offsets.AFTER_ARC


def test_g53_is_driven_without_vector() -> None:
    path = places("G91 G17 G0 X-20\nG41 G1 X20 D1 F100\nX80 Y-50\nG53 Y80\nG53 Y0\nX80 Y50\nX40")
    assert path[2:5] == [[80, -50], [80, 80], [80, 0]]


def test_g28_and_g29_take_it_away_and_bring_it_back() -> None:
    """The vector goes with the way to the point; it comes with the second way of G29."""
    path = places("G17 G0 X-20\nG41 G1 X0 D1 F100\nX80\nG28 Y80\nG29 Y0\nX160\nX200", POINTS)
    assert path[2:] == [[80 - R, R], [80, 80], [80, 0], [80, 80], [80 + R, R], [160, R], [200, R]]


# ---------------------------------------------------------------------------------------------------- interference


GROOVE = "G0 X-20\nG41 G1 X0 D1 F100\nX40\nY-20\nX48\nY0\nX80\nG40 X100"


@pytest.mark.spec("nct.trc.interference-check")
def test_interference_is_told_a_block_before_it() -> None:
    path = tool_path(GROOVE)
    assert path.error is not None
    assert path.error.problem.entry is nct_offsets.INTERFERENCE
    assert path.error.problem.place.line == 5
    assert path.motions[-1].source.line == 3


@pytest.mark.spec("nct.trc.interference-check")
def test_the_check_can_be_off_or_repair() -> None:
    off = replace(SETUP, nct=NctParameters(interfer=False))
    assert tool_path(GROOVE, off).error is None
    repair = replace(SETUP, nct=NctParameters(anglal=False))
    assert tool_path(GROOVE, repair).error is not None
    u = np.array([-1, 1]) / math.sqrt(2)
    corner, direction = np.array([40, 0]) + 2 * u, math.radians(135) - 2 * math.atan(1.6)
    far = corner + 100 * np.array([math.cos(direction), math.sin(direction)])
    text = f"G0 X-20\nG42 G1 X0 D1 F100\nX40\nX{corner[0]:.5f} Y{corner[1]:.5f}\nX{far[0]:.5f} Y{far[1]:.5f}"
    assert tool_path(text).error is not None
    assert np.allclose(places(text, repair)[2], [40 + R, -R], atol=1e-3)


@pytest.mark.spec("nct.trc.small-vector-gap")
def test_close_vectors_become_one() -> None:
    text = "G0 X-20\nG42 G1 X0 D1 F100\nX40\nX38 Y40\nG40 X36 Y80"
    assert len(places(text)) == len(places(text, replace(SETUP, nct=NctParameters(deltv=0.5)))) + 1


# ---------------------------------------------------------------------------------------------------- errors


@pytest.mark.spec(
    "nct.trc.mode-g40-g41-g42",
    "nct.trc.start-up",
    "nct.trc.cancel-g40",
    "nct.trc.vector-hold-g38",
    "nct.trc.corner-arc-g39",
)
@pytest.mark.parametrize(
    ("text", "entry", "line", "column"),
    [
        ("G41 X10 D1\nN2 G18 Z0", nct.PLANE_COMPENSATED, 2, 4),
        ("G2 G41 X10 I5 D1 F100", nct_offsets.START_IN_ARC, 1, 4),
        ("G41 X10 D1\nG40 G2 X20 I5 F100", nct_offsets.CANCEL_IN_ARC, 2, 1),
        ("N1 G38 X1", nct_offsets.HOLD_OUTSIDE, 1, 4),
        ("G41 X10 D1\nG38 G2 X20 I5 F100", nct_offsets.HOLD_IN_ARC, 2, 1),
        ("N1 G39", nct_offsets.ARC_OUTSIDE, 1, 4),
        ("G41 X10 D1\nG39 X5", nct.WORD_WITHOUT_MEANING, 2, 5),
        ("G41 X10 D1\nG39 I0", nct_offsets.DIRECTION_ZERO, 2, 5),
        ("G41 X10 D1 I1 J2 K3", nct.NOT_SUPPORTED, 1, 18),
        ("G41 X10 D1 K3", nct.WORD_WITHOUT_MEANING, 1, 12),
        ("G41 X10 D1000", nct.VALUE_EXCESS, 1, 9),
        ("G41 X10 D1\nG45 X20", nct_offsets.OFFSET_BESIDE, 2, 1),
    ],
)
def test_errors(text: str, entry: object, line: int, column: int) -> None:
    assert found(text) == (entry, line, column)
