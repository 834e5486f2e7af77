"""G02, G03, G303, #CANG, helices, G161…G165 as they are programmed."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
import yaml
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, SpatialArc
from runtime.cnc.decoder import DecoderSetup
from runtime.config import load_machine
from runtime.config.loader import DEMO_MACHINE
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.paths import motions, path, programmed
from tests.cnc.decoder.programs import SETUP, decode, found


def arcs(text: str) -> list[Arc]:
    run = decode(text + "\nM30")
    assert run.problem is None, run.problem
    return [block for block in run.blocks if isinstance(block, Arc)]


def entries(text: str) -> list[tuple[ErrorEntry, int]]:
    return [(entry, line) for entry, line, _ in found(text + "\nM30")]


# -- #CANG


@pytest.mark.spec("isg.g.circular-angle-cang")
def test_a_circle_by_its_opening_angle() -> None:
    (arc,) = arcs("G17 G161\nG00 X10 Y10\nG02 I40 J20 #CANG=135 F1000")
    assert (arc.centre.tolist(), arc.angle) == ([40, 20], -135)
    assert math.dist(arc.end[:2], (40, 20)) == pytest.approx(math.hypot(30, 10))
    (helix,) = arcs("G18\nG00 X5 Z0\nG03 K0 I-5 Y4 #CANG=90 F100\nX1 Z2 R5")[:1]
    np.testing.assert_allclose(helix.end, [0, 4, -5], atol=1e-9)


@pytest.mark.spec("isg.g.circular-angle-cang")
@given(st.floats(1, 360), st.sampled_from(["G02", "G03"]), st.integers(1, 30), st.integers(-30, 30))
def test_an_opening_angle_gives_the_same_arc_as_its_target(angle: float, word: str, i: int, j: int) -> None:
    (first,) = arcs(f"{word} I{i} J{j} #CANG={angle:.6f} F100")
    if angle < 359:
        (second,) = arcs(f"{word} I{i} J{j} X{first.end[0]:.9f} Y{first.end[1]:.9f} F100")
        assert second.angle == pytest.approx(first.angle, abs=1e-3)
    assert abs(first.angle) == pytest.approx(angle, abs=1e-6)


@pytest.mark.spec("isg.g.circular-angle-cang")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G01 I1 #CANG=90 F100", catalogue.ANGLE_WITHOUT_CIRCLE),
        ("G01 X1 #CANG=90 F100", catalogue.ANGLE_WITHOUT_CIRCLE),
        ("G02 I1 X1 #CANG=90 F100", catalogue.ANGLE_AND_TARGET),
        ("G02 I1 #CANG=0 F100", catalogue.OPENING_ANGLE),
        ("G02 I1 #CANG=361 F100", catalogue.OPENING_ANGLE),
        ("G02 I1 K1 Z5 #CANG=90 F100", catalogue.ANGLE_AND_PITCH),
        ("G02 I1 R5 #CANG=90 F100", catalogue.CENTRE_AND_RADIUS),
        ("G02 #CANG=90 F100", catalogue.RADIUS_ZERO),
        ("G02 I1 #CANG=90", catalogue.FEED_MISSING),
        ("#CANG=90", catalogue.ANGLE_WITHOUT_CIRCLE),
        ("G92 X1 #CANG=90", catalogue.ADDITION_WITHOUT_MOTION),
    ],
)
def test_wrong_opening_angles(text: str, entry: ErrorEntry) -> None:
    assert entries(text) == [(entry, 1)]


# -- radius


@pytest.mark.spec("isg.g.circular-radius")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G02 R5 F100\nX0 Y0", catalogue.RADIUS_FULL_CIRCLE),
        ("G02 R4 X10 F100", catalogue.RADIUS_TOO_SMALL),
        ("G02 R0 X10 F100", catalogue.RADIUS_ZERO),
        ("G02 R5 I5 X10 F100", catalogue.CENTRE_AND_RADIUS),
        ("G02 R2e9 X10 F100", catalogue.RADIUS_RANGE),
    ],
)
def test_wrong_radii(text: str, entry: ErrorEntry) -> None:
    assert [found_entry for found_entry, _ in entries(text)] == [entry]


@pytest.mark.spec("isg.g.circular-radius", "isg.g.units-g70-g71")
def test_a_modal_radius_keeps_the_length_that_it_was_programmed_with() -> None:
    first, second, third = arcs("G70 G163=1\nG71 G02 X50.8 F100\nX76.2\nG01 X0\nG02 X2 R1")
    assert [first.radius, second.radius, third.radius] == pytest.approx([25.4, 25.4, 1])


# -- helix


@pytest.mark.spec("isg.g.helix-pitch")
@pytest.mark.parametrize(
    ("text", "turns"),
    [
        ("G17 G03 I5 Z-10 K2", 5),
        ("G18 G03 I5 Y10 J2", 5),
        ("G19 G03 J5 X10 I2", 5),
        ("G02 X10 R5 Z10 K4", -2.5),
        ("G70 G03 I1 Z10 K2", 5),
        ("G03 I5 K2", 1),
    ],
)
def test_turns_of_a_helix(text: str, turns: float) -> None:
    (arc,) = arcs(f"{text} F100")
    assert arc.angle == pytest.approx(turns * 360)


@pytest.mark.spec("isg.g.helix-pitch")
@pytest.mark.parametrize("pitch", ["0", "-1"])
def test_a_pitch_has_no_sign(pitch: str) -> None:
    assert entries(f"G03 I5 Z10 K{pitch} F100") == [(catalogue.PITCH_INVALID, 1)]


# -- centre


@pytest.mark.spec("isg.g.circle-centre-mode-g161-g162", "isg.g.circular-centre-g02-g03")
def test_centres_do_not_follow_the_dimension() -> None:
    for centre in ("G162 I0 J10", "G161 I5 J15"):
        for dimension, target in (("G90", "X15 Y15"), ("G91", "X10 Y10")):
            (arc,) = arcs(f"G00 X5 Y5\n{dimension} G03 {target} {centre} F100")
            assert [*arc.centre, arc.angle] == pytest.approx([5, 15, 90])


@pytest.mark.spec("isg.g.circle-centre-correction-g164-g165")
def test_a_centre_beside_the_bisector() -> None:
    (moved,) = arcs("G02 X10 I5.2 J2 F100")
    assert moved.centre.tolist() == [5, 2]
    assert entries("G02 X10 I6 J2 F100") == [(catalogue.CENTRE_DEVIATION, 1)]
    assert entries("G164 G02 X10 I5.1 F100") == [(catalogue.RADIUS_DIFFERENCE, 1)]
    (kept,) = arcs("G164\nG02 X10 I5 J2 F100")
    assert kept.centre.tolist() == [5, 2]


@pytest.mark.spec("isg.g.circle-radius-transition")
@pytest.mark.parametrize("mirror", ["", "G21\n", "#SCALE ON X2 Y2\n"])
def test_the_radius_of_a_kept_centre_changes_on_the_way(mirror: str) -> None:
    setup = replace(SETUP, radius_change=0.3)
    run = decode(f"{mirror}G164\nG00 X10\nG03 X-10.1 I-10 F100\nM30", setup)
    assert run.problem is None
    pieces = [block for block in run.blocks if isinstance(block, Arc)]
    scale = 2 if "SCALE" in mirror else 1
    turned = 0.0
    for piece in pieces:
        assert piece.centre.tolist() == [0, 0]
        turned += abs(piece.angle)
        assert math.hypot(*piece.end[:2]) == pytest.approx(scale * (10 + 0.1 * turned / 180), abs=1e-6)
        sign = -1 if mirror == "G21\n" else 1
        np.testing.assert_allclose(piece.end_pcs * (sign * scale, scale, 1), piece.end, atol=1e-9)
    assert sum(piece.angle for piece in pieces) == pytest.approx(-180 if mirror == "G21\n" else 180)
    too_far = decode("G164\nG00 X10\nG03 X-10.4 I-10 F100\nM30", setup)
    assert too_far.problem is not None
    assert too_far.problem.entry is catalogue.RADIUS_DIFFERENCE


def with_parameters(text: str) -> DecoderSetup:
    """The setup of the demo machine with these channel parameters."""
    machine = load_machine(DEMO_MACHINE)
    channel = machine.channels[0]
    parameters = channel.parameters.model_copy(update=yaml.safe_load(text) or {})
    changed = channel.model_copy(update={"parameters": parameters})
    return DecoderSetup.from_machine(machine.model_copy(update={"channels": (changed,)}))


def outcome(program: str, parameters: str) -> object:
    """The error of a program, or its arcs."""
    run = decode(f"F100\n{program}\nM30", with_parameters(parameters))
    return [block for block in run.blocks if isinstance(block, Arc)] if run.problem is None else run.problem.entry


@pytest.mark.spec("chan.circle.centre-tolerance")
@pytest.mark.parametrize(
    ("absolute", "relative", "radius", "shift", "taken"),
    [
        (20000, 50, 20.0, 0.99, True),  # 2 mm, and 5 % of the radius
        (20000, 50, 20.0, 1.01, False),
        (20000, 50, 100.0, 1.99, True),
        (20000, 50, 100.0, 2.01, False),
        (1000, 50, 20.0, 0.09, True),
        (1000, 50, 20.0, 0.11, False),
        (20000, 5, 20.0, 0.09, True),
        (20000, 5, 20.0, 0.11, False),
        (0, 50, 20.0, 0.01, False),
    ],
)
def test_a_centre_is_moved_within_both_limits(
    absolute: int, relative: int, radius: float, shift: float, taken: bool
) -> None:
    found = outcome(f"G02 X{2 * radius} I{radius + shift}", f"mittelpkt_diff: {absolute}\nmittelpkt_faktor: {relative}")
    if not taken:
        assert found is catalogue.CENTRE_DEVIATION
        return
    assert isinstance(found, list)
    assert found[0].centre.tolist() == pytest.approx([radius, 0.0])


@pytest.mark.spec("chan.circle.radius-tolerance")
@pytest.mark.parametrize(
    ("absolute", "relative", "difference", "taken"),
    [
        (0, 0, 0.001, False),  # off
        (100, 0, 0.009, True),
        (100, 0, 0.011, False),
        (9999, 10, 0.19, True),  # 1 % of 20 mm
        (9999, 10, 0.21, False),
        (1000, 10, 0.11, False),
    ],
)
def test_radii_may_differ_within_both_limits_where_the_centre_stays(
    absolute: int, relative: int, difference: float, taken: bool
) -> None:
    parameters = f"max_radius_diff_circle: {absolute}\nmax_proz_radius_diff_circle: {relative}"
    found = outcome(f"G164 G02 X{40 + difference} I20", parameters)
    if not taken:
        assert found is catalogue.RADIUS_DIFFERENCE
        return
    assert isinstance(found, list)
    assert {tuple(arc.centre.tolist()) for arc in found} == {(20.0, 0.0)}
    assert math.hypot(found[-1].end[0] - 20.0, found[-1].end[1]) == pytest.approx(20.0 + difference)


@pytest.mark.spec("chan.circle.modal-ijk")
def test_a_centre_holds_for_the_circles_behind() -> None:
    kept = "modal_i_j_k_for_circle: true"
    arcs_of = outcome("G02 X20 I10\nG01 X30\nG02 X50\nG03 X90 R20\nG02 X110 I10 J0\nG02 X130", kept)
    assert isinstance(arcs_of, list)
    assert [arc.centre[0] for arc in arcs_of] == pytest.approx([10.0, 40.0, 70.0, 100.0, 120.0])
    in_inch = outcome("G70 G02 X2 I1\nG71 G02 X101.6", kept)
    assert isinstance(in_inch, list)
    assert [arc.radius for arc in in_inch] == pytest.approx([25.4, 25.4])
    assert outcome("G02 X20 I10\nG02 X40", "") is catalogue.CENTRE_MISSING
    assert outcome("G02 X20 I10\nG03 X60 R20\nG02 X100", kept) is not catalogue.CENTRE_MISSING, "the radius holds on"


# -- arcs in space


def spatial(text: str) -> SpatialArc:
    (arc,) = (block for block in motions(decode(text + "\nM30")) if isinstance(block, SpatialArc))
    return arc


@pytest.mark.spec("isg.g.arc-in-space-g303")
def test_an_arc_in_space() -> None:
    arc = spatial("F2000 G00 X5 Y5 Z35\nG90 G303 I35 J80 K20 X65 Y5 Z5")
    relative = spatial("F2000 G00 X5 Y5 Z35\nG91 G303 I30 J75 K-15 X60 Y0 Z-30")
    for one in (arc, relative):
        assert one.end.tolist() == [65, 5, 5]
        for point in ([5, 5, 35], [35, 80, 20], [65, 5, 5]):
            assert math.dist(point, one.centre) == pytest.approx(math.dist(arc.start, arc.centre))
    np.testing.assert_allclose(arc.normal, relative.normal)


@pytest.mark.spec("isg.g.arc-in-space-g303")
def test_arcs_in_space_are_modal_and_follow_the_coordinates() -> None:
    run = decode("G54 G21\nG00 X0 Y0 Z0\nG303 I5 J5 X10 Y0 F100\nI5 J-5 X0\nG01 X5\nM30")
    assert run.problem is None, run.problem
    first, second = (block for block in run.blocks if isinstance(block, SpatialArc))
    np.testing.assert_allclose(first.end, [90, 10, 1])
    np.testing.assert_allclose(first.centre, [95, 10, 1])
    np.testing.assert_allclose(second.end, [100, 10, 1])
    assert programmed(run)[2].tolist() == [0, 0, 0]
    assert path(run)[-1].tolist() == [95, 10, 1]
    inch = spatial("G70 G303 I1 J1 X2 F100")
    np.testing.assert_allclose(inch.centre, [25.4, 0, 0], atol=1e-9)


@pytest.mark.spec("isg.g.arc-in-space-g303", "isg.g.feed-mode-g93-g94-g95-g194")
def test_the_time_of_an_arc_in_space() -> None:
    arc = spatial("G93 G303 I5 J3 K4 X10 F60")
    assert arc.feed == pytest.approx(math.radians(arc.angle) * 5)


@pytest.mark.spec("isg.g.arc-in-space-g303")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("G303 I1 X2 F100", catalogue.ARC_POINTS_IN_LINE),
        ("G303 I1 J1 X0 F100", catalogue.ARC_POINTS_EQUAL),
        ("G303 X10 F100", catalogue.ARC_POINTS_EQUAL),
        ("G303 I1 J1 X2", catalogue.FEED_MISSING),
        ("G303 I1 J1 X2 F100 E50", catalogue.ARC_BESIDE),
        ("G303 G166 I1 J1 X2 F100", catalogue.ARC_BESIDE),
        ("G303 I1 J1 X2 F100 #RND=1", catalogue.ARC_BESIDE),
        ("G303 I1 J1 X2 R5 F100", catalogue.ARC_BESIDE),
        ("G303 I1 J1 X2 F100 #ANG=1", catalogue.ANGLE_WITH_CIRCLE),
        ("G303 G02 I1 J1 X2 F100", catalogue.G_GROUP_TWICE),
    ],
)
def test_wrong_arcs_in_space(text: str, entry: ErrorEntry) -> None:
    assert entries(text) == [(entry, 1)]


@pytest.mark.spec("isg.g.arc-in-space-g303")
def test_an_arc_in_space_needs_three_axes() -> None:
    two = replace(SETUP, axes=("X", "Y"), linear=(True, True), zero_offsets={})
    run = decode("G303 I1 J1 X2 F100\nM30", two, start=(0, 0))
    assert run.problem is not None
    assert run.problem.entry is catalogue.ARC_MAIN_AXES
