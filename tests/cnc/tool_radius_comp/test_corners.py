"""What the tool does between two elements: cut inside, lines or an arc outside; and what cannot be done is told."""

from __future__ import annotations

import math

import pytest

from runtime.cnc.blocks import Line
from runtime.diagnostics.catalogue import radius as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import decode
from tests.cnc.tool_radius_comp.paths import Path, tool_path

R = 5.0
# From the zero point on: what comes to it along +X, and what goes on in a direction (degrees).
COMING = {"LIN": ("G00 X-40 Y0\n", "G01 X0 Y0"), "CIR": ("G00 X-40 Y40\n", "G03 X0 Y0 I40 J0")}


def corner(first: str, second: str, turn: float, settings: str) -> Path:
    """Two elements that meet at the zero point, the second one turned by `turn` degrees against +X, G41 (tool left)."""
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    if first == "LIN":
        begin = "G00 X-60 Y0\nG138 G41 G01 X-40\nG01 X0 Y0\n"
    else:
        begin = "G00 X-40 Y60\nG138 G41 G01 X-40 Y40\nG03 X0 Y0 I40 J0\n"
    if second == "LIN":
        follow = f"G01 X{40 * c:.9f} Y{40 * s:.9f}\n"
        end = f"G138 G40 X{80 * c:.9f} Y{80 * s:.9f}\n"
    else:  # a half circle that turns away from the tool, so that both sides have room
        follow = f"G02 X{80 * s:.9f} Y{-80 * c:.9f} I{40 * s:.9f} J{-40 * c:.9f}\n"
        end = "G138 G40 G01 G91 X0.1 Y0.1\nG90\n"
    return tool_path(f"{settings} G162\n{begin}{follow}{end}M30")


def inserted(path: Path, line: int = 4) -> list[str]:
    """Kinds of the motions that belong to the first element's line beyond the element itself; it stands in `line`."""
    return [type(motion).__name__ for motion in path.motions if motion.source.line == line][1:]


@pytest.mark.spec("isg.trc.transitions-g25-g26")
@pytest.mark.parametrize(
    ("first", "second", "middle", "acute"),
    [("LIN", "LIN", 0, 1), ("LIN", "CIR", 1, 2), ("CIR", "LIN", 1, 2), ("CIR", "CIR", 2, 3)],
)
def test_table_of_inserted_lines(first: str, second: str, middle: int, acute: int) -> None:
    assert inserted(corner(first, second, 30, "G25")) == []
    assert inserted(corner(first, second, 0, "G25")) == []
    for turn in (-1, -45, -90):
        assert inserted(corner(first, second, turn, "G25")) == ["Line"] * middle, turn
    for turn in (-91, -135, -179):
        assert inserted(corner(first, second, turn, "G25")) == ["Line"] * acute, turn


@pytest.mark.spec("isg.trc.transitions-g25-g26")
@pytest.mark.parametrize("first", ["LIN", "CIR"])
@pytest.mark.parametrize("second", ["LIN", "CIR"])
def test_one_arc_with_g26(first: str, second: str) -> None:
    assert inserted(corner(first, second, 30, "G26")) == []
    assert inserted(corner(first, second, 0, "G26")) == []
    for turn in (-1, -45, -90, -91, -135, -179):
        path = corner(first, second, turn, "G26")
        assert inserted(path) == ["Arc"], turn
        arc = path.of(4)[-1]
        assert arc[2:] == pytest.approx((0.0, 0.0, R, turn), abs=1e-6)


@pytest.mark.spec("isg.trc.g40-g41-g42")
@pytest.mark.parametrize("first", ["LIN", "CIR"])
@pytest.mark.parametrize("second", ["LIN", "CIR"])
@pytest.mark.parametrize("turn", [5, 45, 90, 120])
def test_inside_corners_are_cut_where_the_offsets_meet(first: str, second: str, turn: float) -> None:
    path = corner(first, second, turn, "G25")
    assert path.error is None
    x, y = next(motion for motion in path.motions if motion.source.line == 4).end[:2]
    to_first = abs(y) if first == "LIN" else 40 - math.hypot(x, y - 40)
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    to_second = abs(x * s - y * c) if second == "LIN" else math.hypot(x - 40 * s, y + 40 * c) - 40
    assert to_first == pytest.approx(R, abs=1e-9)
    assert to_second == pytest.approx(R, abs=1e-9)


@pytest.mark.spec("isg.trc.g40-g41-g42")
@pytest.mark.parametrize("settings", ["G25", "G26"])
def test_where_the_path_goes_back_the_tool_goes_around_the_end(settings: str) -> None:
    path = tool_path(f"{settings} G00 X-10 Y0\nG138 G41 G01 X0 Y0\nX40\nX0\nG40 X-10\nM30")
    assert path.error is None
    assert path.of(3)[0] == ((45.0, R) if settings == "G25" else (40.0, R))
    assert path.of(4)[-1] == (0.0, -R)


@pytest.mark.spec("isg.trc.opt-stretch-factor")
@pytest.mark.parametrize(("factor", "lines"), [(1, 2), (2, 2), (2.6, 2), (2.7, 1), (3, 1), (9, 1)])
def test_stretch_factor_decides_whether_the_corner_point_is_reached(factor: float, lines: int) -> None:
    """The corner of the manual's example turns by 138 degrees: the point lies 2.63 radii away."""
    path = tool_path(
        f"#TRC [STRETCH_FACTOR={factor}]\nG139 G25 G0 X0 Y0 Z0\nG41 F10000\nG1 X10 Y20\nG1 X35 Y30\nG1 X30 Y20\n"
        "G1 Y10\nG40\nG1 X20 Y0\nM30"
    )
    shapes = path.of(5)
    assert len(shapes) == lines
    if lines == 2:
        along = math.hypot(25, 10)
        natural = 35 - 5 * 10 / along, 30 + 5 * 25 / along
        assert math.dist(shapes[0][:2], natural) == pytest.approx(factor * R, abs=1e-6)


@pytest.mark.spec("isg.trc.opt-stretch-factor")
@pytest.mark.parametrize("factor", [0.5, 0, 10])
def test_stretch_factor_out_of_range_is_told_and_becomes_one(factor: float) -> None:
    run = decode(f"#TRC [STRETCH_FACTOR={factor}]\nM30")
    assert [warning.entry.id for warning in run.decoder.warnings] == [22007]
    assert run.decoder.modal.compensation.stretch == 1.0


@pytest.mark.spec("isg.trc.opt-ext-angle")
@pytest.mark.parametrize("settings", ["G25", "G26"])
@pytest.mark.parametrize(("first", "second"), [("LIN", "LIN"), ("LIN", "CIR"), ("CIR", "LIN")])
def test_extended_limit_cuts_nearly_tangential_outside_corners(first: str, second: str, settings: str) -> None:
    for turn, lines in ((-0.9, 0), (-1.1, 1)):
        path = corner(first, second, turn, f"#TRC [EXT_ANGLE_BLOCK_INTERSECTION=1]\n{settings}")
        count = len(inserted(path, 5))
        assert count == lines or (count == 0 and settings == "G25" and first == second == "LIN")


def damage(text: str, radius: float = R) -> tuple[ErrorEntry, int]:
    path = tool_path(text, radius=radius)
    assert path.error is not None
    problem = path.error.problem
    assert f"{radius:g}" in problem.text
    assert problem.hint
    return problem.entry, problem.place.line


@pytest.mark.spec("isg.trc.violation-detection")
def test_a_slot_narrower_than_the_tool_is_told_at_its_bottom() -> None:
    entry, line = damage("G00 X-30 Y0\nG138 G41 G01 X-20 Y0\nX0\nY-20\nX8\nY0\nX40\nG138 G40 X60\nM30")
    assert (entry, line) == (catalogue.CONTOUR_DAMAGED, 5)


@pytest.mark.spec("isg.trc.violation-detection")
def test_what_lies_in_front_of_the_damage_is_handed_on() -> None:
    path = tool_path("G00 X-30 Y0\nG138 G41 G01 X-20 Y0\nX0\nY-20\nX8\nY0\nX40\nG138 G40 X60\nM30")
    assert path.error is not None
    assert path.shape[-1] == (3, R, R)  # up to the wall of the slot, not into it


@pytest.mark.spec("isg.trc.violation-detection")
@pytest.mark.parametrize("between", ["M10", "G04 X0.5", "Z-3", "Z-3\nM10\nZ-4\nG04 X1"])
def test_blocks_without_motion_in_the_plane_do_not_disturb_the_detection(between: str) -> None:
    entry, _ = damage(
        f"G00 X-30 Y0\nG138 G41 G01 X-20 Y0\nX0\nY-20\n{between}\nX8\n{between}\nY0\nX40\nG138 G40 X60\nM30"
    )
    assert entry is catalogue.CONTOUR_DAMAGED


@pytest.mark.spec("isg.trc.violation-detection")
def test_an_arc_smaller_than_the_tool_is_told() -> None:
    entry, line = damage("G00 X-30 Y0 G162\nG138 G41 G01 X-20 Y0\nX0\nG03 X4 Y4 J4\nG01 Y30\nG138 G40 Y50\nM30")
    assert (entry, line) == (catalogue.ARC_TOO_SMALL, 4)


@pytest.mark.spec("isg.trc.violation-detection")
def test_an_arc_as_large_as_the_tool_is_a_point_of_the_path() -> None:
    path = tool_path("G00 X-30 Y0 G162\nG138 G41 G01 X-20 Y0\nX0\nG03 X5 Y5 J5\nG01 Y30\nG138 G40 Y50\nM30")
    assert path.error is None
    assert [shape[1:] for shape in path.shape if shape[0] in (3, 5)] == [(0, 5), (0, 30)]


@pytest.mark.spec("isg.trc.violation-detection")
def test_offsets_that_do_not_meet_are_told() -> None:
    """Two arcs bent to the tool, of whose offsets little is left, meet at an inside corner."""
    entry, line = damage(
        "G00 X-30 Y7 G162\nG138 G41 G01 X-6 Y6\nG03 X0 Y0 I6\nG03 X-2.196 Y8.196 I-5.196 J3\nG01 X-50\nG138 G40 X-90\nM30"
    )
    assert (entry, line) == (catalogue.OFFSETS_APART, 3)


@pytest.mark.spec("isg.trc.opt-ignore-cont-damage")
def test_ignored_damage_is_driven_as_it_is_computed() -> None:
    path = tool_path(
        "#TRC [IGNORE_CONT_DAMAGE=1]\nG00 X-30 Y0\nG138 G41 G01 X-20 Y0\nX0\nY-20\nX8\nY0\nX40\nG138 G40 X60\nM30"
    )
    assert path.error is None
    assert path.of(6) == [(3.0, -15.0)]
    bottom = next(motion for motion in path.motions if motion.source.line == 6)
    assert isinstance(bottom, Line)
    assert bottom.start[0] == pytest.approx(5.0)
