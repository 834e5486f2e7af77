"""HSC B-splines, B-splines, Akima splines and transition polynomials of #HSC: programs in, smoothed paths out."""

from __future__ import annotations

import math
import random
from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, JoinedBy, Line, Polyline, Polynomials, TechnologyFunction
from runtime.cnc.decoder import DecoderSetup
from runtime.cnc.decoder.smoothing import HSC_DEFAULT
from runtime.cnc.path_preparation import PathError
from runtime.diagnostics.catalogue import smoothing as catalogue
from tests.cnc.decoder.programs import SETUP, decode
from tests.cnc.interpolator.driving import check_path_laws, drive, limits
from tests.cnc.path_preparation.smoothed_paths import Smoothed, deviation, ends_meet, joints, places, smoothed

FIVE = replace(SETUP, axes=("X", "Y", "Z", "A", "C"), linear=(True, True, True, False, False), zero_offsets={})
HARD = limits(250.0, 2000.0, 50_000.0, 0.0)
TRIM = """X3 Y25
X15 Y15
X23 Y12
X25 Y25
X30 Y35
X50 Y37.5
X55 Y32.5
X58 Y12
X70 Y12
X77.5 Y10
X90 Y35
X100 Y37.5"""


def met(program: Smoothed, *place: float) -> float:
    """Distance of the smoothed path from a place."""
    path = np.vstack([places(block, 400) for block in program.motions])
    return float(np.linalg.norm(path[:, : len(place)] - np.array(place), axis=1).min())


def program(selection: str, moves: str, deselection: str, before: str = "G01 X0 Y0 F6000") -> str:
    return f"{before}\n{selection}\n{moves}\n{deselection}\nM30"


# ---------------------------------------------------------------------------------------------------- HSC B-spline


@pytest.mark.spec("isg.smooth.hsc-bspline")
@pytest.mark.parametrize("allowed", [0.01, 0.2, 2.0])
def test_trimming_keeps_to_the_tolerance_and_turns_smoothly(allowed: float) -> None:
    path = smoothed(program(f"#HSC ON [BSPLINE PATH_DEV={allowed}]", TRIM, "#HSC OFF"))
    assert deviation(path) <= allowed + 1e-9
    assert met(path, 100.0, 37.5) < 1e-9
    assert met(path, 0.0, 0.0) < 1e-9
    assert met(path, 25.0, 25.0) > 0.2 * allowed
    assert ends_meet(path.blocks) < 1e-9
    inside = [joint for joint in joints(path.blocks) if np.abs(joint.place[:2]).max() > 0.0]
    assert max(joint.turn for joint in inside) < 1e-6
    assert max(joint.bend for joint in inside) < 1e-5
    run = drive(path.blocks, HARD, np.zeros(3))
    assert run.finished
    check_path_laws(run)


@pytest.mark.spec("isg.smooth.hsc-bspline")
def test_settings_come_before_or_with_the_selection_and_stay() -> None:
    once = smoothed(program("#HSC ON [BSPLINE PATH_DEV=0.05]", TRIM, "#HSC OFF"))
    before = smoothed(program("#HSC [BSPLINE PATH_DEV=0.05]\n#HSC ON\nG01 X0\n#HSC OFF\n#HSC ON", TRIM, "#HSC OFF"))
    assert all((a == b).all() for a, b in zip(once.curves, before.curves, strict=True))
    unwatched = smoothed(program("#HSC ON [BSPLINE PATH_DEV=0 TRACK_DEV=0]", TRIM, "#HSC OFF"))
    assert deviation(unwatched) > 1.0
    assert deviation(smoothed(program("#HSC ON [BSPLINE]", TRIM, "#HSC OFF"))) <= 0.2 + 1e-9


@st.composite
def polygons(draw: st.DrawFn) -> str:
    """Moves of any length and direction, some without length, some back."""
    lines, x, y = [], 0.0, 0.0
    for _ in range(draw(st.integers(1, 14))):
        scale = draw(st.sampled_from([0.005, 0.3, 8.0]))
        dx, dy = (draw(st.integers(-20, 20)) * scale for _ in range(2))
        z = draw(st.sampled_from(["", f" Z{draw(st.integers(-3, 3))}"]))
        x, y = x + dx, y + dy
        lines.append(f"X{x:.4f} Y{y:.4f}{z}")
        if draw(st.integers(0, 9)) == 0:
            lines.append(f"X{x - dx:.4f} Y{y - dy:.4f}")
            x, y = x - dx, y - dy
    return "\n".join(lines)


@pytest.mark.spec("isg.smooth.hsc-bspline")
@given(polygons(), st.sampled_from([0.002, 0.05, 1.0]), st.sampled_from(["", " MERGE=1", " AUTO_OFF_PATH=1"]))
@settings(max_examples=60, deadline=None)
def test_the_tolerance_holds_for_any_polygon(moves: str, allowed: float, option: str) -> None:
    path = smoothed(program(f"#HSC ON [BSPLINE PATH_DEV={allowed}{option} MAX_ANGLE=180]", moves, "#HSC OFF"))
    assert deviation(path) <= allowed + 1e-9
    assert ends_meet(path.blocks) < 1e-9
    straight = smoothed(program("", moves, ""))
    assert places(path.motions[-1], 1)[-1] == pytest.approx(places(straight.motions[-1], 1)[-1], abs=1e-9)


@pytest.mark.spec("isg.smooth.hsc-bspline")
def test_many_short_moves_in_windows() -> None:
    rng = random.Random(5)
    moves, count = [], 3000
    for k in range(1, count + 1):
        x = 0.2 * k + rng.uniform(-0.05, 0.05)
        moves.append(f"X{x:.4f} Y{3 * math.sin(x / 4):.4f} Z{math.cos(x / 7):.4f}")
    path = smoothed(program("#HSC ON [BSPLINE PATH_DEV=0.01]", "\n".join(moves), "#HSC OFF", "G01 X0 Y0 Z1 F6000"))
    runs = [block for block in path.blocks if isinstance(block, Polynomials)]
    assert len(runs) < 20
    lines = np.concatenate([run.lines for run in runs])
    assert (np.diff(lines) >= 0).all()
    assert sum(int(run.block_ends.sum()) for run in runs) == count
    inside = [joint for joint in joints(path.blocks) if joint.place[0] > 0.0]
    assert max(joint.turn for joint in inside) < 1e-6
    assert max(joint.bend for joint in inside) < 1e-5
    assert ends_meet(path.blocks) < 1e-9


@pytest.mark.spec("isg.smooth.hsc-bspline-auto-off")
@pytest.mark.parametrize(
    ("setting", "moves", "corner", "exact"),
    [
        ("MAX_PATH_LENGTH=30", "X5 Y5\nX60 Y10\nX65 Y5\nX70 Y9", (60, 10), True),
        ("MAX_PATH_LENGTH=0", "X5 Y5\nX60 Y10\nX65 Y5\nX70 Y9", (60, 10), False),
        ("MAX_ANGLE=60", "X10\nX10 Y10\nX20 Y12", (10, 0), True),
        ("MAX_ANGLE=100", "X10\nX10 Y10\nX20 Y12", (10, 0), False),
        ("AUTO_OFF_G00=1", "X10\nG00 X10 Y10\nG01 X20 Y12", (10, 0), True),
        ("AUTO_OFF_G00=0", "X10\nG00 X10 Y10\nG01 X20 Y12", (10, 0), False),
        ("AUTO_OFF_PATH=1", "X10\nX10 Y10\nX20 Y12", (10, 0), True),
        ("AUTO_OFF_PATH=0", "X10\nX10 Y10\nX20 Y12", (10, 0), False),
        ("AUTO_OFF_G60=1", "X10 G60\nX10 Y10\nX20 Y12", (10, 0), True),
    ],
)
def test_what_interrupts_the_curve_is_passed_exactly(
    setting: str, moves: str, corner: tuple[float, float], exact: bool
) -> None:
    path = smoothed(program(f"#HSC ON [BSPLINE PATH_DEV=0.3 {setting}]", moves, "#HSC OFF"))
    assert (met(path, *corner) < 1e-6) == exact
    assert deviation(path) <= 0.3 + 1e-9
    assert exact or path.curves


@pytest.mark.spec("isg.smooth.hsc-bspline")
def test_merging_makes_fewer_elements_within_the_tolerance() -> None:
    moves = "\n".join(f"X{0.1 * k:.2f} Y{0.004 * (k % 2):.3f}" for k in range(1, 400))
    whole, few = (smoothed(program(f"#HSC ON [BSPLINE PATH_DEV=0.05 MERGE={m}]", moves, "#HSC OFF")) for m in (0, 1))
    count = [sum(len(b.feeds) for b in path.blocks if isinstance(b, Polynomials)) for path in (whole, few)]
    assert count[1] < count[0] / 10
    assert deviation(few) <= 0.05 + 1e-9


@pytest.mark.spec("isg.smooth.hsc-bspline")
def test_tracking_axes_have_their_own_tolerance() -> None:
    moves = "X20 C0\nX40 C30\nX60 Y5 C0\nX80 C0"
    tight = smoothed(program("#HSC ON [BSPLINE PATH_DEV=1 TRACK_DEV=0.5]", moves, "#HSC OFF"), FIVE)
    loose = smoothed(program("#HSC ON [BSPLINE PATH_DEV=1 TRACK_DEV=20]", moves, "#HSC OFF"), FIVE)

    def most(path: Smoothed) -> float:
        return max(float(places(block)[:, 4].max()) for block in path.motions)

    assert most(tight) >= 29.5 > most(loose)


def test_functions_stay_at_their_corners() -> None:
    path = smoothed(program("#HSC ON [BSPLINE]", "X10 Y1\nM10\nX20\nX30 Y1\nX40", "#HSC OFF"))
    at = next(i for i, block in enumerate(path.blocks) if isinstance(block, TechnologyFunction) and block.number == 10)
    before = [block for block in path.blocks[:at] if isinstance(block, Polynomials)]
    assert np.linalg.norm(before[-1].ends[-1] - [10.0, 1.0, 0.0]) < 1.0
    assert ends_meet(path.blocks) < 1e-9


# ---------------------------------------------------------------------------------------------------- B-spline


@pytest.mark.spec("isg.smooth.bspline")
@pytest.mark.parametrize(
    ("on", "off"),
    [("#SPLINE ON", "#SPLINE OFF"), ("G151", "G150"), ("#SET SPLINE ON", "#SET SPLINE OFF")],
)
def test_a_b_spline_meets_its_ends_along_its_first_and_last_leg(on: str, off: str) -> None:
    path = smoothed(program(f"#SPLINE TYPE BSPLINE\n{on}", TRIM, off))
    (run,) = [block for block in path.blocks if isinstance(block, Polynomials)]
    assert len(run.feeds) == 12
    first, last = run.coefficients[0], run.coefficients[-1]
    assert first[0] == pytest.approx([0.0, 0.0, 0.0])
    assert last.sum(axis=0) == pytest.approx([100.0, 37.5, 0.0])
    assert np.cross(first[1], [3.0, 25.0, 0.0]) == pytest.approx(np.zeros(3), abs=1e-9)
    assert np.cross(np.arange(6) @ last, [10.0, 2.5, 0.0]) == pytest.approx(np.zeros(3), abs=1e-9)
    assert met(path, 25.0, 25.0) > 0.5
    inside = joints([run])
    assert max(joint.turn for joint in inside) < 1e-9
    assert max(joint.bend for joint in inside) < 1e-9


@pytest.mark.spec("isg.smooth.bspline")
def test_a_position_beside_the_deselection_is_no_point_of_the_curve() -> None:
    path = smoothed("#SPLINE TYPE BSPLINE\nG01 X0 Y0 F1000\nG151 X3 Y25\nX15 Y15\nX23 Y12\nX25 Y25\nG150 X40 Y25\nM30")
    (run,) = [block for block in path.blocks if isinstance(block, Polynomials)]
    assert run.ends[-1] == pytest.approx([25.0, 25.0, 0.0])
    assert len(run.feeds) == 4


@pytest.mark.spec("isg.smooth.bspline", "isg.smooth.akima-select")
@pytest.mark.parametrize(
    ("before", "moves", "least"),
    [
        ("#SPLINE TYPE BSPLINE", "X10\nX20 Y5", 4),
        ("#SPLINE TYPE BSPLINE", "X10", 4),
        ("#SPLINE TYPE AKIMA", "X10", 3),
    ],
)
def test_a_spline_with_too_few_points_is_an_error(before: str, moves: str, least: int) -> None:
    with pytest.raises(PathError) as error:
        smoothed(program(f"{before}\n#SPLINE ON", moves, "#SPLINE OFF"))
    assert error.value.problem.entry is catalogue.SPLINE_POINTS
    assert error.value.problem.values["least"] == least


# ---------------------------------------------------------------------------------------------------- Akima


@pytest.mark.spec("isg.smooth.akima-select")
def test_an_akima_spline_goes_through_its_points_in_one_direction() -> None:
    path = smoothed(program("#SPLINE TYPE AKIMA\nG151", TRIM, "G150"))
    for line in TRIM.splitlines():
        x, y = (float(word[1:]) for word in line.split())
        assert met(path, x, y) < 1e-9
    (run,) = [block for block in path.blocks if isinstance(block, Polynomials)]
    assert max(joint.turn for joint in joints([run])) < 1e-9
    check = drive(path.blocks, HARD, np.zeros(3))
    assert check.finished


@pytest.mark.spec("isg.smooth.akima-select")
def test_straight_stretches_of_an_akima_spline_stay_straight() -> None:
    moves = "\n".join(
        f"X{x} Y{y}" for x, y in [(5, 0), (10, 0), (15, 0), (20, 0), (25, 5), (30, 10), (35, 15), (40, 20)]
    )
    path = smoothed(program("G151", moves, "G150"))
    points = np.vstack([places(block) for block in path.motions])
    early = points[points[:, 0] < 14.9]
    assert np.abs(early[:, 1]).max() < 1e-9


@pytest.mark.spec("isg.smooth.akima-tangents", "isg.smooth.akima-transition")
def test_tangents_as_the_program_gives_them() -> None:
    text = (
        "N10 G01 X20 Y0 F1000\nN20 #AKIMA TRANS[START=USER END=AUTO]\nN30 #AKIMA STARTVECTOR X1 Y1 Z0\n"
        "N40 G151\nN50 G01 X40 Y20\nN60 X60\nN70 Y0\nN80 X80\nN90 Y10\nN100 G150\nN110 X70\nN120 M30"
    )
    (run,) = [block for block in smoothed(text).blocks if isinstance(block, Polynomials)]
    start = run.coefficients[0, 1]
    assert start / np.linalg.norm(start) == pytest.approx([math.sqrt(0.5), math.sqrt(0.5), 0.0])
    assert run.ends[-1] == pytest.approx([80.0, 10.0, 0.0])
    other = text.replace("START=USER END=AUTO", "START=USER END=USER").replace(
        "N40 G151", "#SET ASPLINE ZIELTANG X0 Y-1 Z0\nN40 G151"
    )
    (run,) = [block for block in smoothed(other).blocks if isinstance(block, Polynomials)]
    end = np.arange(6) @ run.coefficients[-1]
    assert end / np.linalg.norm(end) == pytest.approx([0.0, -1.0, 0.0])
    two = "#AKIMA TRANS[START=USER END=USER]\n#AKIMA STARTVECTOR X1 Y1 Z0\n#AKIMA ENDVECTOR X1 Y-1 Z0\n"
    assert smoothed(f"G01 F1000\n{two}G151\nX20\nG150\nM30").curves


@pytest.mark.spec("isg.smooth.akima-transition", "isg.smooth.akima-interrupt")
def test_tangential_transitions_to_lines_and_arcs() -> None:
    text = (
        "#AKIMA TRANS [START=TANGENTIAL END=TANGENTIAL]\nG01 X0 Y0 F1000\nX10 Y0\nG151\nX15 Y5\nX20 Y-3\nX30 Y0\n"
        "G03 X40 Y10 I0 J10\nG01 X42 Y20\nX40 Y30\nX45 Y40\nG150\nX55 Y40\nM30"
    )
    path = smoothed(text)
    assert sum(isinstance(block, Arc) for block in path.blocks) == 1
    assert len([block for block in path.blocks if isinstance(block, Polynomials)]) == 2
    moving = [joint for joint in joints(path.blocks) if joint.place[0] > 1.0]
    assert max(joint.turn for joint in moving) < 1e-5


@pytest.mark.spec("isg.smooth.akima-interrupt")
def test_tracking_axes_alone_interrupt_the_curve() -> None:
    path = smoothed(program("G151", "X10 Y5\nX20\nC90\nX30 Y5\nX40\nX50 Y3", "G150"), FIVE)
    kinds = [type(block) for block in path.motions[1:]]
    assert kinds.count(Polynomials) == 2
    assert met(path, 20.0, 5.0) < 1e-9
    assert ends_meet(path.blocks) < 1e-9


@pytest.mark.spec("isg.smooth.akima-interrupt")
def test_functions_between_the_points() -> None:
    path = smoothed(program("G151", "X10 Y5\nM10\nX20\nX30 Y5", "G150"))
    at = next(i for i, block in enumerate(path.blocks) if isinstance(block, TechnologyFunction) and block.number == 10)
    before = [block for block in path.blocks[:at] if isinstance(block, Polynomials)]
    assert before[-1].ends[-1] == pytest.approx([10.0, 5.0, 0.0])


@given(polygons(), st.sampled_from(["AKIMA", "BSPLINE"]))
@settings(max_examples=40, deadline=None)
def test_any_polygon_as_a_spline_ends_where_it_should(moves: str, kind: str) -> None:
    text = program(f"#SPLINE TYPE {kind}\nG151", f"X1\nX2 Y1\nX3\n{moves}", "M00\nG150")
    path = smoothed(text)
    straight = smoothed(program("", f"X1\nX2 Y1\nX3\n{moves}", ""))
    assert ends_meet(path.blocks) < 1e-9
    assert places(path.motions[-1], 1)[-1] == pytest.approx(places(straight.motions[-1], 1)[-1], abs=1e-9)


def test_windows_of_an_akima_spline_do_not_show() -> None:
    moves = [f"X{0.5 * k} Y{3 * math.sin(k / 9):.5f}" for k in range(1, 2500)]
    path = smoothed(program("G151", "\n".join(moves), "G150"))
    runs = [block for block in path.blocks if isinstance(block, Polynomials)]
    assert len(runs) > 1
    assert max(joint.turn for joint in joints(runs)) < 1e-9
    assert ends_meet(path.blocks) < 1e-9
    late = smoothed(program("G151", "\n".join(moves[500:]), "G150", f"G01 F6000 {moves[499]}"))
    tail = np.concatenate([b.coefficients for b in late.blocks if isinstance(b, Polynomials)])
    all_of_it = np.concatenate([b.coefficients for b in runs])
    assert tail[3:] == pytest.approx(all_of_it[503:], abs=1e-9)


# ---------------------------------------------------------------------------------------------------- PSC


@pytest.mark.spec("isg.smooth.psc-opmode1")
def test_transition_polynomials_keep_to_the_contour_error() -> None:
    for text, allowed in (
        ("#HSC ON", 0.1),
        ("#HSC ON [OPMODE 1 CONTERROR 0.01]", 0.01),
        ("#HSC[CONTERROR=0.5]\n#HSC ON", 0.5),
    ):
        path = smoothed(program(text, TRIM, "#HSC OFF"))
        assert deviation(path) <= allowed + 1e-9
        assert met(path, 58.0, 12.0) == pytest.approx(allowed, abs=1e-3)
    changed = smoothed(program("#HSC ON", "X10\n#HSC [CONTERROR=0.02]\nX10 Y10\nX20 Y10", "#HSC OFF"))
    assert met(changed, 10.0, 0.0) == pytest.approx(0.1, abs=1e-3)
    assert met(changed, 10.0, 10.0) == pytest.approx(0.02, abs=1e-3)
    kept = smoothed(program("#HSC ON [CONTERROR=0.3]\n#HSC OFF\n#HSC ON", TRIM, "#HSC OFF"))
    assert met(kept, 58.0, 12.0) == pytest.approx(0.3, abs=1e-3)


# ---------------------------------------------------------------------------------------------------- errors


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#HSC ON [OPMODE 3]", catalogue.VALUE_RANGE),
        ("#HSC ON\n#HSC [OPMODE 2]", catalogue.WHILE_ACTIVE),
        ("#HSC [COS_PHI_MIN=1.5]", catalogue.VALUE_RANGE),
        ("#HSC [FACT_BLOCK_LEN=0]", catalogue.NOT_ABOVE),
        ("#HSC ON [BSPLINE]\n#HSC [PATH_DEV=1]", catalogue.WHILE_ACTIVE),
        ("#HSC ON\n#HSC [OPMODE 1]", catalogue.WHILE_ACTIVE),
        ("#HSC ON [BSPLINE PATH_DEV=-0.1]", catalogue.VALUE_RANGE),
        ("#HSC ON [BSPLINE MAX_ANGLE=200]", catalogue.VALUE_RANGE),
        ("#HSC ON [BSPLINE CONTERROR=1]", catalogue.OF_OTHER_METHOD),
        ("#HSC ON\n#SPLINE ON", catalogue.CHOOSE_ONE),
        ("#SPLINE ON\n#HSC ON", catalogue.CHOOSE_ONE),
        ("#SPLINE ON\n#SPLINE TYPE BSPLINE", catalogue.WHILE_ACTIVE),
        ("#SPLINE ON\n#AKIMA TRANS [START=USER]", catalogue.WHILE_ACTIVE),
        ("#AKIMA STARTVECTOR X1 Y1", catalogue.TANGENT_AXIS),
        ("#AKIMA ENDVECTOR X0 Y0 Z0", catalogue.TANGENT_ZERO),
    ],
)
def test_wrong_selections_are_errors(text: str, entry: object) -> None:
    run = decode(f"G01 F1000 X1\n{text}\nX2\nM30")
    assert run.problem is not None
    assert run.problem.entry is entry


def test_nothing_is_left_of_a_curve_that_never_began() -> None:
    assert not smoothed("#HSC ON [BSPLINE]\n#HSC OFF\nG151\nG150\nM30").motions
    assert isinstance(smoothed("G01 F1000\nG151\nX1 E100\nG150\nM30").motions[0], Line)


# ---------------------------------------------------------------------------------------------------- what interrupts it


def channel_curve(text: str, fields: dict[str, Any], setup: DecoderSetup = SETUP) -> Smoothed:
    """A program whose channel begins #HSC [BSPLINE] with other values."""
    start = replace(HSC_DEFAULT, deviation=0.3, **fields)
    return smoothed(text, replace(setup, hsc_start=start))


INTERRUPTED = [
    ("sharp corner", {"greatest_angle": 60.0}, "X10 Y1\nX20 Y0\nX20 Y15\nX22 Y25", (20, 0), False),
    ("long move", {"longest": 12.0}, "X10 Y1\nX15 Y0\nX40 Y10\nX45 Y5\nX50 Y5", (15, 0), False),
    ("rapid move", {"without_rapid": True}, "X10 Y1\nX20 Y0\nG00 X20 Y20\nG01 X25 Y30\nX30 Y30", (20, 0), False),
    ("arc", {}, "X10 Y1\nX20 Y0\nG02 X30 Y10 I10 J0\nG01 X40 Y15\nX50 Y15", (20, 0), True),
    ("arc behind an arc", {}, "X10\nG03 X20 Y10 R10\nG03 X30 Y20 R12\nG01 X40 Y15\nX50 Y15", (20, 10), True),
]


@pytest.mark.parametrize(("name", "fields", "moves", "corner", "at_arc"), INTERRUPTED)
@pytest.mark.parametrize("joined", list(JoinedBy))
def test_what_interrupts_the_curve_is_joined_by_contouring(
    name: str, fields: dict[str, Any], moves: str, corner: tuple[float, float], at_arc: bool, joined: JoinedBy
) -> None:
    path = channel_curve(program("#HSC ON [BSPLINE]", moves, "#HSC OFF"), {"joined": joined, **fields})
    smooth_there = joined is JoinedBy.CURVES or (joined is JoinedBy.CURVES_AT_ARCS and at_arc)
    assert (met(path, *corner) > 1e-3) == smooth_there
    assert deviation(path) <= 0.3 + 1e-6
    assert ends_meet(path.blocks) < 1e-9
    near = [j for j in joints(path.blocks) if np.linalg.norm(j.place[:2] - np.array(corner)) < 1.0]
    assert any(j.turn > 1e-2 for j in near) != smooth_there


@pytest.mark.parametrize("first", ["X10 Y1", "G02 X10 Y0 I5 J0\nG01", "X0 Y0\nX10 Y1"])
def test_the_first_motion_may_stay_as_it_is(first: str) -> None:
    moves = f"{first}\nX20 Y-3\nX30 Y4\nX40 Y0\nX50 Y2"
    through = channel_curve(program("#HSC ON [BSPLINE]", moves, "#HSC OFF"), {"delayed": True})
    end = (10, 0) if "G02" in first else (10, 1)
    assert met(through, *end) < 1e-9
    assert met(through, 20, -3) > 1e-3
    kept = next(block for block in through.motions if np.abs(places(block, 1)[-1] - places(block, 1)[0]).max() > 1.0)
    assert isinstance(kept, Arc if "G02" in first else Line | Polyline)
    assert deviation(through) <= 0.3 + 1e-9
    assert ends_meet(through.blocks) < 1e-9


@pytest.mark.parametrize(("ratio", "exact"), [(2.0, True), (20.0, False)])
def test_a_move_that_mostly_turns_interrupts_the_curve(ratio: float, exact: bool) -> None:
    moves = "X10 Y1\nX12 Y0 C10\nX22 Y4 C10\nX30 Y0\nX40 Y2"
    setup = replace(FIVE, hsc_start=HSC_DEFAULT)
    path = channel_curve(program("#HSC ON [BSPLINE TRACK_DEV=0]", moves, "#HSC OFF"), {"most_tracking": ratio}, setup)
    assert (met(path, 10, 1) < 1e-9) == exact
    assert (met(path, 12, 0) < 1e-9) == exact
    assert met(path, 22, 4) > 1e-3


@pytest.mark.spec("chan.hsc.bspline-off")
@pytest.mark.parametrize(
    ("tolerances", "refused", "curved"),
    [("PATH_DEV=0.1 TRACK_DEV=1", False, True), ("PATH_DEV=0 TRACK_DEV=0", False, False), ("PATH_DEV=0", True, False),
     ("TRACK_DEV=0", True, False)],
)  # fmt: skip
def test_tolerances_of_zero(tolerances: str, refused: bool, curved: bool) -> None:
    text = program(f"#HSC ON [BSPLINE {tolerances}]", "X10 Y1\nX20 Y0\nX30 Y1", "#HSC OFF")
    run = decode(text, replace(SETUP, no_hsc_at_zero=True))
    if refused:
        assert run.problem is not None
        assert run.problem.entry is catalogue.ONE_DEVIATION_ZERO
        return
    assert run.problem is None
    assert bool(smoothed(text, replace(SETUP, no_hsc_at_zero=True)).curves) == curved
    assert decode(text, SETUP).problem is None
