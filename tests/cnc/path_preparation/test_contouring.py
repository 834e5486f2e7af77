"""Contouring: G61, G261, G260, #CONTOUR MODE. Programs in, smoothed paths out, judged by dense sampling."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import (
    Arc,
    Block,
    BlockEnd,
    ContourChange,
    Dwell,
    Floats,
    Line,
    Polyline,
    Polynomials,
    Stop,
    TechnologyFunction,
    Wait,
)
from runtime.cnc.path_preparation import smooth
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.diagnostics.catalogue import motion
from runtime.diagnostics.catalogue import smoothing as catalogue
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.interpolator.driving import Order, check_path_laws, drive, limits
from tests.cnc.path_preparation.smoothed_paths import Smoothed, deviation, ends_meet, joints, places, smoothed

EXACT = 1e-6
FIVE = replace(SETUP, axes=("X", "Y", "Z", "A", "C"), linear=(True, True, True, False, False), zero_offsets={})
HARD = limits(250.0, 2000.0, 50_000.0, 0.0)


def passed(program: Smoothed, *corner: float) -> bool:
    """The smoothed path goes exactly through a corner and turns there."""
    there = np.array(corner)
    return any(
        np.abs(joint.place[: len(corner)] - there).max() < EXACT and joint.turn > 1e-3
        for joint in joints(program.blocks)
    )


def nearest(program: Smoothed, *corner: float) -> float:
    path = np.vstack([_fine(block) for block in program.motions])
    return float(np.linalg.norm(path[:, : len(corner)] - np.array(corner), axis=1).min())


def _fine(block: Block) -> Floats:
    return places(block, 400)


# ---------------------------------------------------------------------------------------------------- G61 G261 G260

_ZIGZAG = ("X20 Y100", "X40 Y100", "X60 Y20", "X80 Y20", "X100 Y100", "X120 Y100", "X140 Y20", "X160 Y20")


@pytest.mark.spec("isg.smooth.contour-select", "isg.g.polynomial-contouring")
@pytest.mark.parametrize(
    "marks",
    [
        {1: "G61", 2: "G61", 3: "G61", 4: "G61"},
        {1: "G261", 5: "G260"},
        {0.5: "G261", 5.5: "G260"},
        {0.5: "#CONTOUR MODE ON", 5.5: "#CONTOUR MODE OFF"},
    ],
)
def test_one_contour_in_several_ways(marks: dict[float, str]) -> None:
    lines = ["X0 Y0 G01 F1000"]
    for number, target in enumerate(_ZIGZAG):
        lines.append(f"{marks.get(number, '')} {target}")
        lines.append(marks.get(number + 0.5, ""))
    program = smoothed("\n".join([*lines, "M30"]))
    sharp = [(20, 100), (120, 100), (140, 20)]
    round_ = [(40, 100), (60, 20), (80, 20), (100, 100)]
    assert [passed(program, *corner) for corner in sharp] == [True] * 3
    assert [passed(program, *corner) for corner in round_] == [False] * 4
    assert [nearest(program, *corner) for corner in round_] == [pytest.approx(1.0, abs=1e-3)] * 4
    assert ends_meet(program.blocks) < 1e-9
    assert len(program.curves) == 8


@pytest.mark.spec("isg.smooth.contour-select")
def test_nothing_is_inserted_where_the_path_goes_on_or_back() -> None:
    for arc in ("G02 X15 Y10 I0 J10", "G03 X15 Y10 I0 J10"):  # on in the same direction, and back
        program = smoothed(f"G261 G01 F1000 X10\nX20\nX5\n{arc}\nM30")
        assert not program.curves
    straight = smoothed("G261 G01 F1000 X10\nX20\nX5\nM30")
    assert not straight.curves
    assert deviation(straight) < 1e-9
    tangent = smoothed("G261 G01 F1000 X10\nG03 X20 Y10 I0 J10\nG01 Y20\nM30")
    assert not tangent.curves


@pytest.mark.spec("isg.smooth.contour-select")
def test_g61_without_a_motion_behind_it_warns() -> None:
    program = smoothed("G01 F1000 X10\nG61 Y10\nM5\nM30", replace(SETUP, spindles=SETUP.spindles))
    (warning,) = program.warnings
    assert (warning.entry, warning.place.line) == (motion.CONTOUR_AT_END, 2)
    assert not program.curves
    assert not smoothed("G261 G01 F1000 X10\nY10\nM30").warnings


@pytest.mark.spec("isg.smooth.contour-select")
@pytest.mark.parametrize("between", ["G04 X1", "M10", '#MSG ["a"]', "P1 = 3", "F500"])
def test_blocks_without_motion_are_no_neighbours(between: str) -> None:
    assert len(smoothed(f"G261 G01 F1000 X10\n{between}\nY10\nM30").curves) == 2


@pytest.mark.parametrize("between", ["M00", "#FLUSH", "#FLUSH WAIT", "#FLUSH CONTINUE"])
def test_where_the_path_has_to_stand_the_corner_is_passed(between: str) -> None:
    program = smoothed(f"G261 G01 F1000 X10\n{between}\nY10\nX0\nM30")
    assert passed(program, 10.0, 0.0)
    assert not passed(program, 10.0, 10.0)
    assert passed(smoothed("G261 G01 F1000 X10 G60\nY10\nM30"), 10.0, 0.0)


# ---------------------------------------------------------------------------------------------------- DEV

_steps = st.integers(-400, 400).map(lambda n: n / 20)


@st.composite
def contours(draw: st.DrawFn) -> str:
    """Lines and arcs of any angle and length, also tiny ones, ones of no length, and reversals."""
    lines, here = [], (0.0, 0.0)
    for _ in range(draw(st.integers(2, 7))):
        kind = draw(st.sampled_from(["line", "line", "space", "arc", "helix", "same", "tiny", "back", "angle"]))
        x, y = draw(_steps), draw(_steps)
        if kind in ("arc", "helix") and math.dist(here, (x, y)) > 0.5:
            radius = math.dist(here, (x, y)) / 2 + draw(st.integers(1, 40)) / 4
            sign = draw(st.sampled_from(["", "-"]))
            z = f" Z{draw(_steps)}" if kind == "helix" else ""
            lines.append(f"G0{draw(st.sampled_from('23'))} X{x} Y{y}{z} R{sign}{radius:.6f}")
        elif kind == "same":
            x, y = here
            lines.append(f"G01 X{x} Y{y}")
        elif kind == "tiny":
            x, y = here[0] + 0.001, here[1]
            lines.append(f"G01 X{x:.4f} Y{y:.4f}")
        elif kind == "back":
            x, y = here[0] + 3.0, here[1]
            lines.append(f"G01 X{x:.4f} Y{y:.4f}\nX{here[0]:.4f}\nX{x:.4f}")
        elif kind == "angle":
            lines.append(f"G00 X{x} Y{y} Z1")
        else:
            z = f" Z{draw(_steps)}" if kind == "space" else ""
            lines.append(f"G01 X{x} Y{y}{z}")
        here = (x, y)
    return "\n".join(lines)


@pytest.mark.spec("isg.smooth.contour-dev")
@given(contours(), st.sampled_from([0.0, 0.003, 0.05, 0.4, 5.0]))
@settings(max_examples=60, deadline=None)
def test_the_deviation_is_never_exceeded_and_the_joints_are_smooth(contour: str, allowed: float) -> None:
    program = smoothed(f"#CONTOUR MODE [DEV PATH_DEV={allowed}]\nG261 F1000\n{contour}\nM30")
    assert deviation(program) <= allowed + 2e-5  # what the chords of arcs are off
    assert ends_meet(program.blocks) < 1e-9
    first, last = program.motions[0], program.motions[-1]
    before = [block for block in program.programmed if isinstance(block, Line | Arc | Polyline)]
    for new, old, at in ((first, before[0], 0), (last, before[-1], -1)):
        assert np.abs(_fine(new)[at] - _fine(old)[at]).max() < 1e-9
    corner_places = [_fine(block)[-1] for block in before] + [
        p for b in before if isinstance(b, Polyline) for p in b.points
    ]
    for joint in joints(program.blocks):
        if min(np.abs(place - joint.place).max() for place in corner_places) > 1e-6:
            assert joint.turn < 1e-6, joint
            assert joint.bend < 1e-3 + 1e-3 / max(allowed, 1e-3), joint


@pytest.mark.spec("isg.smooth.contour-dev")
def test_the_interim_point_of_a_right_angle_is_as_far_as_allowed() -> None:
    program = smoothed("#CONTOUR MODE [DEV PATH_DEV=0.5]\nG01 F1000 X100 G61\nY100\nM30")
    assert nearest(program, 100.0, 0.0) == pytest.approx(0.5, abs=1e-6)
    first, second = program.curves
    assert first.sum(axis=0) == pytest.approx(second[0])
    assert 100.0 - first[0, 0] == pytest.approx(second.sum(axis=0)[1])  # both distances equal


@pytest.mark.spec("isg.smooth.contour-dev")
def test_both_sides_are_limited_to_half_of_the_shorter_block() -> None:
    program = smoothed("#CONTOUR MODE [DEV PATH_DEV=5]\nG261 G01 F1000 X100\nY2\nX200\nM30")
    starts = [curve[0] for curve in program.curves[::2]]
    assert 100.0 - starts[0][0] == pytest.approx(1.0)
    ends = [curve.sum(axis=0) for curve in program.curves[1::2]]
    assert ends[0] == pytest.approx([100.0, 1.0, 0.0])
    assert ends[0] == pytest.approx(starts[1])  # the block has vanished between two curves


@pytest.mark.spec("isg.smooth.contour-distance-limits")
@pytest.mark.parametrize(("percent", "left"), [(0, 0.0), (10, 0.2), (50, 1.0), (100, 2.0)])
def test_what_has_to_remain_of_a_block_remains(percent: int, left: float) -> None:
    program = smoothed(f"#CONTOUR MODE [DEV PATH_DEV=5 REMAIN_PART={percent}]\nG261 G01 F1000 X100\nY2\nX200\nM30")
    if percent == 100:
        assert not program.curves
        return
    assert program.curves[2][0][1] - program.curves[1].sum(axis=0)[1] == pytest.approx(left)


@pytest.mark.spec("isg.smooth.contour-distance-limits")
def test_on_circles_the_distance_covers_a_quarter_at_most() -> None:
    program = smoothed(
        "#CONTOUR MODE [DIST PRE_DIST=90 POST_DIST=90]\nG261 G01 F1000 X200\nG03 X200 Y0 I-10 J0.01\nG01 X0\nM30"
    )
    end = program.curves[1].sum(axis=0)
    turned = math.atan2(end[1] - 0.01, end[0] - 190.0) - math.atan2(-0.01, 10.0)
    assert turned == pytest.approx(math.pi / 2, abs=1e-3)


# ---------------------------------------------------------------------------------------------------- other methods


@pytest.mark.spec("isg.smooth.contour-dist")
@pytest.mark.parametrize(
    ("text", "before", "behind"),
    [
        ("DIST PRE_DIST=10 POST_DIST=5", 10.0, 5.0),
        ("DIST PRE_DIST=10 POST_DIST=10", 10.0, 10.0),
        ("DIST", 1.0, 1.0),
        ("DIST PRE_DIST=40 POST_DIST=40", 15.0, 15.0),  # the second block has 30
        ("DIST PRE_DIST=40 POST_DIST=39", 40.0, 15.0),  # only what is too long is cut
        ("DIST, PRE_DIST 3, POST_DIST 2", 3.0, 2.0),
    ],
)
def test_the_user_says_where_the_path_is_left(text: str, before: float, behind: float) -> None:
    program = smoothed(f"#CONTOUR MODE [{text}]\nG01 F1000 X100 G61\nY30\nM30")
    assert 100.0 - program.curves[0][0, 0] == pytest.approx(before)
    assert program.curves[1].sum(axis=0)[1] == pytest.approx(behind)
    assert all(joint.turn < 1e-6 and joint.bend < 1e-6 for joint in joints(program.blocks))


def test_the_soft_curve_uses_the_share_of_the_acceleration() -> None:
    program = smoothed("#CONTOUR MODE [DIST_SOFT PATH_DIST=12]\nG00 Y80\nG261 G01 X40 Y40 F6000\nX80 Y80\nM30")
    speed = 100.0  # mm/s
    c = program.curves
    assert len(c) == 4
    distance = np.linalg.norm(c[0][0] - [40.0, 40.0, 0.0])
    time = 2.0 * distance / speed
    # the greatest second derivative, by the time that the whole curve takes, is the half of what the axes have
    turn = math.sqrt(2.0)
    ramp = 0.5 * 2000.0 / 50_000.0
    assert turn * speed / (0.5 * 2000.0) + ramp == pytest.approx(time)
    near_by = [joint for joint in joints(program.blocks) if np.linalg.norm(joint.place[:2] - 40.0) < 20.0]
    assert all(joint.turn < 1e-6 and joint.bend < 1e-6 for joint in near_by)
    assert len(near_by) == 5
    run = drive(program.blocks, HARD, np.zeros(3))
    assert run.finished
    near = smoothed("#CONTOUR MODE [DIST_SOFT PATH_DIST=2]\nG00 Y80\nG261 G01 X40 Y40 F6000\nX80 Y80\nM30")
    assert np.linalg.norm(near.curves[0][0] - [40.0, 40.0, 0.0]) == pytest.approx(2.0)
    free = smoothed("#CONTOUR MODE [DIST_SOFT PATH_DIST=-1]\nG00 Y80\nG261 G01 X40 Y40 F60000\nX80 Y80\nM30")
    assert np.linalg.norm(free.curves[0][0] - [40.0, 40.0, 0.0]) > 12.0


@pytest.mark.spec("isg.smooth.contour-ptp")
def test_the_whole_contour_is_limited_by_deviation_or_distance() -> None:
    def chosen(settings: str) -> Smoothed:
        return smoothed(
            f"#CONTOUR MODE [PTP {settings}]\nG261 G01 F1000 X100\nY100\nX90 Y200\nG02 X190 Y200 I50 J0\nG260\nM30"
        )

    far = chosen("PATH_DEV=5")
    assert deviation(far) == pytest.approx(5.0, rel=1e-3)
    assert len(far.curves) == 8  # the circle is reached exactly
    assert all(joint.turn < 1e-6 and joint.bend < 1e-6 for joint in joints(far.blocks)[:-1])
    assert np.linalg.norm(chosen("PATH_DIST=7").curves[0][0] - [100.0, 0.0, 0.0]) == pytest.approx(7.0)
    both = chosen("PATH_DIST=7 PATH_DEV=0.5")
    assert deviation(both) == pytest.approx(0.5, rel=1e-3)
    assert np.linalg.norm(both.curves[0][0] - [100.0, 0.0, 0.0]) < 7.0
    assert deviation(chosen("")) == pytest.approx(1.0, rel=1e-3)
    run = drive(far.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)


@pytest.mark.spec("isg.smooth.contour-ptp")
def test_the_limits_of_the_whole_contour_are_its_own() -> None:
    text = "#CONTOUR MODE [PTP PATH_DIST=9]\n#CONTOUR MODE [DEV]\nG261 G01 F1000 X100\nY100\nM30"
    assert deviation(smoothed(text)) == pytest.approx(1.0, rel=1e-3)


def test_the_soft_curve_falls_back_to_distances_at_circles() -> None:
    program = smoothed("#CONTOUR MODE [DIST_SOFT PATH_DIST=3]\nG61 G01 F1000 X40\nG02 X50 Y10 I10 J0\nM30")
    assert len(program.curves) == 2
    assert 40.0 - program.curves[0][0, 0] == pytest.approx(3.0)


@pytest.mark.spec("isg.smooth.contour-pos")
def test_the_curve_goes_through_the_interim_point() -> None:
    program = smoothed("#CONTOUR MODE [POS PRE_DIST=2 POST_DIST=3 X110 Y-10 Z0]\nG01 F1000 X100 G61\nY100\nM30")
    first, second = program.curves
    assert first.sum(axis=0) == pytest.approx([110.0, -10.0, 0.0])
    assert (100.0 - first[0, 0], second.sum(axis=0)[1]) == (pytest.approx(2.0), pytest.approx(3.0))
    assert all(joint.turn < 1e-6 and joint.bend < 1e-6 for joint in joints(program.blocks))


@pytest.mark.spec("isg.smooth.contour-pos")
def test_with_distances_of_zero_the_whole_contour_is_kept() -> None:
    program = smoothed("G54\n#CONTOUR MODE [POS PRE_DIST=0 POST_DIST=0 X110 Y-10]\nG01 F1000 X100 G61\nY100\nM30")
    shift = SETUP.zero_offsets[54]
    first, second = program.curves
    assert first[0] == pytest.approx([100.0 + shift[0], 0.0, 0.0])
    assert first.sum(axis=0)[:2] == pytest.approx([110.0 + shift[0], -10.0 + shift[1]])
    run = drive(program.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)
    assert second.sum(axis=0) == pytest.approx(first[0])


# ---------------------------------------------------------------------------------------------------- parameters


@pytest.mark.spec("isg.smooth.contour-max-angle")
def test_sharper_corners_stay() -> None:
    text = "#CONTOUR MODE [DEV PATH_DEV=0.1 MAX_ANGLE={}]\nG261 G01 F1000 X10\nX20 Y5\nX20 Y30\nM30"
    first = math.degrees(math.atan2(5, 10))
    assert [passed(smoothed(text.format(first - 0.1)), *c) for c in ((10, 0), (20, 5))] == [True, True]
    assert [passed(smoothed(text.format(first + 0.1)), *c) for c in ((10, 0), (20, 5))] == [False, True]
    assert [passed(smoothed(text.format(90)), *c) for c in ((10, 0), (20, 5))] == [False, False]


@pytest.mark.spec("isg.smooth.contour-max-angle", "isg.smooth.contour-mode-command")
def test_a_corner_has_the_settings_of_the_motion_before_it() -> None:
    lines = ["G261 G01 F1000", "#CONTOUR MODE [MAX_ANGLE=3]", "X10", "#CONTOUR MODE [MAX_ANGLE=100]", "X10 Y10",
             "#CONTOUR MODE [MAX_ANGLE=5]", "X0", "Y0", "M30"]  # fmt: skip
    program = smoothed("\n".join(lines))
    assert [passed(program, *c) for c in ((10, 0), (10, 10), (0, 10))] == [True, False, True]


@pytest.mark.spec("isg.smooth.contour-mode-command")
def test_settings_stay_and_can_be_given_one_after_the_other() -> None:
    one = smoothed("#CONTOUR MODE [DIST PRE_DIST=3 POST_DIST=2]\nG261 G01 F1000 X10\nY10\nM30")
    many = smoothed(
        "#CONTOUR MODE [DIST]\n#CONTOUR MODE [PRE_DIST 3]\n#CONTOUR MODE ON [POST_DIST=2]\nG01 F1000 X10\nY10\nM30"
    )
    assert all((a == b).all() for a, b in zip(one.curves, many.curves, strict=True))


@pytest.mark.spec("isg.smooth.contour-select")
def test_a_cycle_leaves_contouring_as_it_was() -> None:
    files = {"C": "G261 X10 F1000\nX10 Y10\nM17"}
    run = decode("%M\nG01 F1000 X1\nL CYCLE [NAME=C]\nX0 Y10\nX0 Y0\nM30", files=files)
    assert run.problem is None
    changes = [block.contouring is not None for block in run.blocks if isinstance(block, ContourChange)]
    assert changes == [True, False]


@pytest.mark.spec("isg.smooth.contour-mode-command")
def test_inch_holds_for_lengths_where_the_channel_says_so() -> None:
    text = "G70\n#CONTOUR MODE [DIST PRE_DIST=1 POST_DIST=1]\nG61 G01 F1000 X10\nY10\nM30"
    for inch, distance in ((False, 1.0), (True, 25.4)):
        program = smoothed(text, replace(SETUP, contouring_inch=inch))
        assert 254.0 - program.curves[0][0, 0] == pytest.approx(distance)


@pytest.mark.spec("isg.smooth.contour-mode-command")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#CONTOUR MODE [PTP MERGE=2]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [PTP CONST_VEL=1]", catalogue.OF_OTHER_METHOD),
        ("#CONTOUR MODE [DIST_MASTER SYM_DIST=1]", catalogue.METHOD_UNSUPPORTED),
        ("#CONTOUR MODE [DIST_SOFT DIST_WEIGHT=50]", catalogue.METHOD_UNSUPPORTED),
        ("#CONTOUR MODE [DEV PRE_DIST=1]", catalogue.OF_OTHER_METHOD),
        ("#CONTOUR MODE [DIST PATH_DEV=1]", catalogue.OF_OTHER_METHOD),
        ("#CONTOUR MODE [DEV DIST]", catalogue.CHOOSE_ONE),
        ("#CONTOUR MODE [PRE_ACTION POST_ACTION]", catalogue.CHOOSE_ONE),
        ("#CONTOUR MODE [DEV PATH_DEV=-1]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [DEV REMAIN_PART=101]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [DEV MAX_ANGLE=200]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [DEV CHECK_JERK=3]", catalogue.VALUE_RANGE),
        ("#CONTOUR MODE [DIST_SOFT ACC_MIN=80 ACC_MAX=40]", catalogue.ACCELERATION_ORDER),
    ],
)
def test_wrong_settings_are_errors(text: str, entry: object) -> None:
    run = decode(f"G01 F1000 X1\n{text}\nX2\nM30")
    assert run.problem is not None
    assert run.problem.entry is entry
    assert run.problem.place.line == 2


# ---------------------------------------------------------------------------------------------------- actions


@pytest.mark.spec("isg.smooth.contour-actions")
@pytest.mark.parametrize(("word", "place"), [("PRE_ACTION", 0), ("INTER_ACTION", 1), ("POST_ACTION", 2), ("", 1)])
def test_functions_stand_where_the_settings_say(word: str, place: int) -> None:
    program = smoothed(f"#CONTOUR MODE [DEV PATH_DEV=1 {word}]\nG01 F1000 X10 G61 M13\nY10\nM30")
    kinds = [type(block) for block in program.blocks]
    at = kinds.index(TechnologyFunction, kinds.index(Line))
    assert sum(len(b.coefficients) for b in program.blocks[:at] if isinstance(b, Polynomials)) == place
    assert kinds.index(BlockEnd) > at
    assert Wait in kinds
    assert sum(isinstance(block, BlockEnd) for block in program.blocks) == 1


@pytest.mark.spec("isg.smooth.contour-actions")
@pytest.mark.parametrize("word", ["PRE_ACTION", "INTER_ACTION", "POST_ACTION"])
def test_a_late_acknowledgement_stops_the_path_exactly_there(word: str) -> None:
    program = smoothed(f"#CONTOUR MODE [DEV PATH_DEV=2 {word}]\nG01 F6000 X50 G61 M12\nY50\nM30")
    first, second = program.curves
    place = {"PRE_ACTION": first[0], "INTER_ACTION": second[0], "POST_ACTION": second.sum(axis=0)}[word]
    run = drive(program.blocks, HARD, np.zeros(3), lambda cycle, _: Order(open_gates=cycle > 3000))
    stands = [p for p, gate in zip(run.positions, run.at_gate, strict=True) if gate]
    assert stands[100] == pytest.approx(place, abs=1e-9)
    assert run.finished
    at_once = drive(program.blocks, HARD, np.zeros(3))
    slow = min(v for v, p in zip(at_once.v, at_once.positions, strict=True) if np.linalg.norm(p - place) < 1.0)
    assert slow > 20.0


@pytest.mark.spec("isg.smooth.contour-actions")
def test_dwell_and_single_block_stop_within_the_curve() -> None:
    program = smoothed("#CONTOUR MODE [DEV PATH_DEV=2]\nG01 F6000 X50 G61\nG04 X0.1\nY50\nM30")
    kinds = [type(block) for block in program.blocks]
    assert kinds.index(Polynomials) < kinds.index(Dwell) < len(kinds) - 1 - kinds[::-1].index(Polynomials)
    plain = smoothed("#CONTOUR MODE [DEV PATH_DEV=2]\nG01 F6000 X50 G61\nY50\nM30")
    run = drive(plain.blocks, HARD, np.zeros(3), lambda _, i: Order(single_block=True, open_gates=i.at_gate))
    stands = {tuple(np.round(p, 6)) for p, v in zip(run.positions, run.v, strict=True) if v == 0.0}
    assert tuple(np.round(plain.curves[1][0], 6)) in stands


# ---------------------------------------------------------------------------------------------------- tracking axes


@pytest.mark.spec("isg.smooth.contour-tracking")
def test_tracking_axes_go_along_and_shorten_the_curve() -> None:
    text = "#CONTOUR MODE [DEV PATH_DEV=1 TRACK_DEV={}]\nG01 F1000 X100 C0 G61\nY100 C90\nM30"
    free, tight = smoothed(text.format(0), FIVE), smoothed(text.format(0.05), FIVE)
    assert nearest(free, 100.0, 0.0) == pytest.approx(1.0, abs=1e-3)
    assert nearest(tight, 100.0, 0.0) < 0.5
    for program, most in ((free, 10.0), (tight, 0.05)):
        first, second = program.curves
        u = np.linspace(0.0, 1.0, 201)[:, None] ** np.arange(6)
        a = second.sum(axis=0)[1]
        way = np.linspace(0.0, a, 201)
        off = max(np.abs((u @ first)[:, 4]).max(), np.abs((u @ second)[:, 4] - 0.9 * way).max())
        assert off <= most + 1e-9
        assert ends_meet(program.blocks) < 1e-9
    straight = "#CONTOUR MODE [DEV PATH_DEV=1 TRACK_DEV={}]\nG01 F1000 X100 C0 G61\nX200 C90\nM30"
    assert not smoothed(straight.format(0), FIVE).curves
    assert smoothed(straight.format(0.5), FIVE).curves


def test_a_block_without_the_main_axes_is_no_partner() -> None:
    program = smoothed("G261 G01 F1000 X100\nC90\nY100\nM30", FIVE)
    assert not program.curves
    assert deviation(program) < 1e-9


# ---------------------------------------------------------------------------------------------------- short blocks


def test_short_blocks_are_skipped() -> None:
    text = "#CONTOUR MODE [DEV PATH_DEV=5 RELEVANT_PATH={}]\nG01 F1000 X5 G261\nY1\nX10 Y3 G260\nX20\nM30"
    skipping, whole = smoothed(text.format(2), start=(-20, 0, 0)), smoothed(text.format(0.5), start=(-20, 0, 0))
    assert len(skipping.curves) == 2
    assert len(whole.curves) == 4
    assert ends_meet(skipping.blocks) < 1e-9
    assert sum(isinstance(block, BlockEnd) or bool(getattr(block, "block_ends", np.zeros(1)).any())
               for block in skipping.blocks) >= 3  # fmt: skip


def test_a_series_of_short_blocks_is_skipped_as_long_as_it_stays_near() -> None:
    steps = "\n".join(f"Y{0.8 * k:.1f}" for k in range(1, 4))
    program = smoothed(f"#CONTOUR MODE [DEV PATH_DEV=3 RELEVANT_PATH=2]\nG261 G01 F1000 X50\n{steps}\nX100\nM30")
    # Y0.8 and Y1.6 are near the corner, Y2.4 is not: it is the partner although short
    assert program.curves[1].sum(axis=0) == pytest.approx([50.0, 2.0, 0.0])


def test_what_is_skipped_comes_back_where_no_curve_is_possible() -> None:
    program = smoothed("#CONTOUR MODE [DEV PATH_DEV=1 RELEVANT_PATH=2]\nG261 G01 F1000 X50\nY1\nG260\nX100\nM30")
    assert deviation(program) < 1e-9
    with_m = smoothed("#CONTOUR MODE [DEV PATH_DEV=1 RELEVANT_PATH=2]\nG261 G01 F1000 X50\nY1 M10\nM00\nX100\nM30")
    assert deviation(with_m) < 1e-9
    assert any(isinstance(block, TechnologyFunction) and block.number == 10 for block in with_m.blocks)


def test_moves_of_no_length_are_no_neighbours() -> None:
    program = smoothed("#CONTOUR MODE [DEV PATH_DEV=0.5]\nG261 G01 F1000 X10\nX10\nX10\nY10\nM30")
    assert len(program.curves) == 2
    assert not passed(program, 10.0, 0.0)


# ---------------------------------------------------------------------------------------------------- velocity


@pytest.mark.spec("isg.smooth.contour-jerk")
def test_without_the_jerk_check_the_curve_is_faster() -> None:
    text = "#CONTOUR MODE [DEV PATH_DEV=0.2 CHECK_JERK={}]\nG01 F12000 X50 G61\nY50\nM30"
    times = [drive(smoothed(text.format(check)).blocks, HARD, np.zeros(3)).cycles for check in (0, 1, 2)]
    assert times[0] < times[1] == times[2]
    preset = [
        drive(
            smoothed(text.replace(" CHECK_JERK={}", ""), replace(SETUP, poly_jerk=p)).blocks, HARD, np.zeros(3)
        ).cycles
        for p in (0, 1)
    ]
    assert preset == times[:2]


@pytest.mark.spec("isg.smooth.contour-const-vel")
def test_constant_velocity_within_the_curve() -> None:
    axes = limits(250.0, 2000.0, 50_000.0, 0.0)
    uneven = replace(axes, acceleration=np.array([2000.0, 400.0, 2000.0]))
    text = "#CONTOUR MODE [DIST PRE_DIST=8 POST_DIST=3 CONST_VEL={}]\nG01 F6000 X50 G61\nY50\nM30"
    spread = []
    for constant in (0, 1):
        program = smoothed(text.format(constant), axes=uneven)
        first, second = program.curves
        run = drive(program.blocks, uneven, np.zeros(3))
        x0, y1 = first[0, 0], second.sum(axis=0)[1]
        inside = [v for v, p in zip(run.v, run.positions, strict=True) if p[0] > x0 and p[1] < y1]
        spread.append(max(inside) - min(inside))
    assert spread[1] < 0.02 < spread[0]


# ---------------------------------------------------------------------------------------------------- runs


def test_a_run_of_short_lines_stays_arrays() -> None:
    count = 120
    moves = "\n".join(f"X{0.5 * k:.3f} Y{2 * (k % 2):.3f}" for k in range(1, count))
    program = smoothed(f"#CONTOUR MODE [DEV PATH_DEV=0.05]\nG261 G01 F6000\n{moves}\nM30")
    assert len(program.blocks) < 30
    assert len(program.curves) == 2 * (count - 2)
    assert deviation(program) <= 0.05 + 1e-9
    assert max(joint.turn for joint in joints(program.blocks)) < 1e-6
    lines = np.concatenate([b.lines for b in program.blocks if isinstance(b, Polynomials)])
    assert (np.diff(lines) >= 0).all()
    ends = sum(int(b.block_ends.sum()) for b in program.blocks if isinstance(b, Polynomials))
    ends += sum(isinstance(b, BlockEnd) for b in program.blocks)
    ends += sum(len(b.feeds) for b in program.blocks if isinstance(b, Polyline) and not b.one_block)
    assert ends == count - 1


def test_driven_along_a_square_spiral() -> None:
    moves, x, y, side = [], 0.0, 0.0, 10.0
    for turn in range(10):
        x, y = [(x + side, y), (x, y + side), (x - side, y), (x, y - side)][turn % 4]
        moves.append(f"X{x} Y{y}")
        side += 1.0
    program = smoothed("#CONTOUR MODE [DEV PATH_DEV=0.05]\nG261 G01 F6000\n" + "\n".join(moves) + "\nM30")
    run = drive(program.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)
    assert run.path[-1] == pytest.approx([x, y, 0.0], abs=1e-12)
    assert isinstance(program.blocks[-1], Stop)
    assert min(run.v[100:-100]) > 1.0, "no corner brings the path to rest"


# ---------------------------------------------------------------------------------------------------- with radius compensation

_SQUARE = "X20\nX20 Y20\nX0 Y20\nX0 Y5"


@pytest.mark.parametrize(
    "text",
    [
        f"G261\nG41 G138 X0 Y0\n{_SQUARE}\nG40 G138 X-20 Y0\nG260",
        f"G41 G138 G261 X0 Y0\n{_SQUARE}\nG260 G40 G138 X-20 Y0",
        "G41 G138 X0 Y0\nX20\nG261\nX20 Y20\nX0 Y20\nG260\nX0 Y5\nG40 G138 X-20 Y0",
        "G261\nG41 G138 X0 Y0\nX20\nG260 X20 Y20\nG261 X0 Y20\nX0 Y5\nG40 G138 X-20 Y0\nG260",
    ],
)
def test_contouring_goes_on_the_compensated_contour(text: str) -> None:
    run = decode(f"V.G.WZ_AKT.R=2 F1000 G01 X-20 Y-20\n#CONTOUR MODE [DEV PATH_DEV=0.3]\n{text}\nM30")
    assert run.problem is None, run.problem
    compensated = list(ToolRadiusCompensation()(iter(run.blocks)))
    program = Smoothed(compensated, list(smooth(iter(compensated), HARD)), [])
    assert program.curves
    assert deviation(program) <= 0.3 + 1e-4  # chords of the judge
    assert ends_meet(program.blocks) < 1e-9
