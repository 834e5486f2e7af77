"""What may happen along a compensated contour: the side and the radius change, planes, mirrors, other axes, runs, feeds."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from runtime.cnc.blocks import Arc, Line, Polyline
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import radius as catalogue
from tests.cnc.decoder.programs import decode, problems
from tests.cnc.tool_radius_comp.paths import compensate, motions_of, tool_path

R = 5.0


@pytest.mark.spec("isg.trc.g40-g41-g42")
@pytest.mark.parametrize(("command", "y"), [("G41", R), ("G42", -R)])
@pytest.mark.parametrize("apart", [True, False])
def test_the_tool_runs_one_radius_beside_the_contour(command: str, y: float, apart: bool) -> None:
    path = tool_path(f"G00 X-20 Y0\n{command}{chr(10) if apart else ' '}G01 X0 Y0\nX40\nG40 X60\nM30")
    assert [shape[1:] for shape in path.shape] == [(-20, 0), (0, y), (40, y), (60, 0)]


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_a_negative_radius_swaps_the_side() -> None:
    text = "G00 X-20 Y0\nG41 G01 X0 Y0\nX40\nX50 Y20\nG40 X60\nM30"
    assert tool_path(text, radius=-R).shape == tool_path(text.replace("G41", "G42")).shape


@pytest.mark.spec("isg.trc.g40-g41-g42")
@pytest.mark.parametrize(("plane", "axes", "letters"), [("G17", "XY", "IJ"), ("G18", "ZX", "KI"), ("G19", "YZ", "JK")])
def test_it_acts_in_the_selected_plane(plane: str, axes: str, letters: str) -> None:
    text = "{p} G00 A-20 B0 G162\nG41 G01 A0 B0\nA40\nG03 A60 B20 {j}20\nG01 B40\nG40 B60\nM30"
    text = text.replace("{p}", plane).replace("{j}", letters[1])
    turned = tool_path(text.replace("A", axes[0]).replace("B", axes[1]))
    flat = text.replace(plane, "G17").replace(f"{letters[1]}20", "J20")
    plain = tool_path(flat.replace("A", "X").replace("B", "Y"))
    assert turned.shape == plain.shape


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_mirroring_swaps_the_side() -> None:
    text = "G00 X-20 Y0 G162\nG41 G01 X0 Y0\nX40\nG03 X60 Y20 J20\nG01 Y40\nX20 Y60\nG40 X0\nM30"
    plain, mirrored = tool_path(text), tool_path("G22 " + text)
    assert plain.error is None
    assert mirrored.error is None
    for one, other in zip(plain.motions, mirrored.motions, strict=True):
        assert one.end[:2] == pytest.approx(other.end[:2] * [1, -1], abs=1e-9)
        if isinstance(one, Arc):
            assert isinstance(other, Arc)
            assert one.angle == pytest.approx(-other.angle)


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_rotation_turns_contour_and_tool_path() -> None:
    text = "G00 X-20 Y0\nG41 G01 X0 Y0\nX40\nY40\nG40 Y60\nM30"
    plain, turned = tool_path(text), tool_path("G68 R30\n" + text)
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    for one, other in zip(plain.motions, turned.motions, strict=True):
        x, y = one.end[:2]
        assert other.end[:2] == pytest.approx([x * c - y * s, x * s + y * c], abs=1e-9)


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_other_axes_run_along_with_the_block() -> None:
    path = tool_path(
        "G00 X-20 Y0 Z1 G162\nG41 G01 X0 Y0 Z0\nX40 Z-1\nG03 X40 Y40 J20 Z-2\nG01 X0 Z-3\nG40 X-20 Z1\nM30"
    )
    assert [motion.end[2] for motion in path.motions] == [1, 0, -1, -2, -3, 1]
    assert path.of(4) == [(40, 35, 40, 20, 15, 180)]


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_a_move_normal_to_the_plane_runs_where_the_tool_is() -> None:
    path = tool_path("G00 X-20 Y0\nG41 G01 X0 Y0\nZ-1\nX40\nZ-2\nM10\nZ-3\nY40\nG40 Y60\nM30")
    assert [tuple(motion.end) for motion in path.motions] == [
        (-20, 0, 0), (0, 5, 0), (0, 5, -1), (35, 5, -1), (35, 5, -2), (35, 5, -3), (35, 40, -3), (40, 60, -3),
    ]  # fmt: skip


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_functions_and_dwell_keep_their_place() -> None:
    path = tool_path("G00 X-20 Y0\nG41 G01 X0 Y0\nM10\nX40 M12\nG04 X1\nY-40\nM13\nG40 X0\nM30")
    order = [getattr(block, "number", None) or type(block).__name__ for block in path.blocks]
    order = [what for what in order if what not in ("BlockEnd", "Wait")]
    assert order == ["Polyline", "Line", 10, 12, "Line", "Dwell", "Polyline", 13, "Line", "Stop"]


@pytest.mark.spec("isg.trc.side-change")
def test_the_block_of_the_side_change_leads_from_side_to_side() -> None:
    path = tool_path("G01 Y10 G138 G41\nX20 Y25\nX40 G42\nX60 Y10\nX0 Y0 G40\nM30", radius=2.0)
    assert path.error is None
    left = 2 * np.array([-15.0, 20.0]) / 25
    right = 2 * np.array([-15.0, -20.0]) / 25
    points = {motion.source.line: motion.end[:2] for motion in path.motions}
    assert points[1] == pytest.approx(np.array([0, 10]) + left)
    assert points[2] == pytest.approx(np.array([20, 25]) + left)
    assert points[3] == pytest.approx(np.array([40, 25]) + right)


@pytest.mark.spec("isg.trc.side-change")
def test_the_side_changes_between_elements() -> None:
    path = tool_path("G00 X-20 Y0\nG41 G01 X0 Y0\nX40\nG42 X60\nX100\nG40 X120\nM30")
    assert [shape[1:] for shape in path.shape[2:]] == [(40, R), (60, -R), (100, -R), (120, 0)]


@pytest.mark.spec("isg.trc.side-change")
def test_arcs_may_stand_beside_a_side_change_but_not_be_it() -> None:
    begin = "G00 X-20 Y0 G162\nG41 G01 X0 Y0\nG03 X20 Y20 J20\n"
    good = tool_path(begin + "G42 G01 Y40\nG02 X40 Y60 I20\nG40 G01 X60\nM30")
    assert good.error is None
    assert good.of(4) == [(25, 40)]
    wrong = tool_path(begin + "G42 G02 X40 Y40 I20\nG01 X60\nG40 X80\nM30")
    assert wrong.error is not None
    assert wrong.error.problem.entry is catalogue.SIDE_CHANGE_ARC
    assert wrong.error.problem.place.line == 4


@pytest.mark.spec("isg.trc.opt-reverse")
def test_where_the_path_reverses_the_side_changes_without_motion() -> None:
    text = (
        "#TRC[REVERSE=1]\nG00 X0 Y0\nG01 X100 Y100\nG41 G01 X150\nX250\nY200\nG42\nX100\nX100 Y150\nG40 G01 X0\nY0\nM30"
    )
    turned = "#TRC[REVERSE=1]\nG00 X0 Y0\nG01 X100 Y100\nG41 G01 X150\nX250\nG42\nX100\nX100 Y150\nG40 G01 X0\nM30"
    assert tool_path(text).error is None
    path = tool_path(turned)
    assert [shape for shape in path.shape if shape[0] in (5, 7)] == [(5, 250, 105), (7, 105, 105)]


@pytest.mark.spec("isg.trc.opt-reverse")
def test_arcs_reverse_with_a_common_tangent() -> None:
    path = tool_path(
        "#TRC[REVERSE=1]\nG00 X-20 Y0 G162\nG41 G01 X0 Y0\nG03 X20 Y20 J20\nG42\nG02 X0 Y0 I-20\nG40 G01 X-20\nM30"
    )
    assert path.error is None
    assert [shape for shape in path.shape if shape[0] in (4, 6)] == [
        (4, 15, 20, 0, 20, 15, 90), (6, 0, 5, 0, 20, 15, -90),
    ]  # fmt: skip


@pytest.mark.spec("isg.trc.radius-change", "isg.trc.tool-data-change")
def test_a_new_radius_is_reached_over_the_next_line() -> None:
    path = tool_path("G00 X0 Y0\nG41 G1 X20 Y20\nX100\nV.G.WZ_AKT.R = 20\nX200\nX240 Y100\nG40 X500\nM30", radius=10)
    assert path.of(3) == [(100, 30)]
    slope = path.motions[3]
    along = (slope.end - slope.start)[:2]
    assert along[1] / along[0] == pytest.approx(0.1)  # obliquely from 10 to 20 mm
    x, y = path.motions[4].start[:2] - np.array([200.0, 20.0])
    direction = np.array([40.0, 80.0]) / math.hypot(40, 80)
    assert direction[0] * y - direction[1] * x == pytest.approx(20)  # the corner behind it counts with the new one


@pytest.mark.spec("isg.trc.radius-change")
@pytest.mark.parametrize("radius", [12.0, 8.0])
def test_a_new_radius_is_reached_within_an_arc(radius: float) -> None:
    path = tool_path(
        f"G00 X0 Y0\nG41 G1 X20 Y20\nX100\nV.G.WZ_AKT.R = {radius}\nG02 X180 Y100 R80\nG01 X180 Y50\nG40 X300\nM30",
        radius=10,
    )
    assert path.error is None
    arc = next(motion for motion in path.motions if isinstance(motion, Arc))
    assert math.dist(arc.end[:2], (180, 100)) == pytest.approx(radius)
    assert path.of(3) != []


@pytest.mark.spec("isg.trc.radius-change")
def test_an_arc_of_more_than_180_degrees_is_split() -> None:
    path = tool_path(
        "G162 G00 X0 Y0\nG41 G1 X20 Y100\nX100\nV.G.WZ_AKT.R = 20\nG02 X150 Y50 J50\nG01 X150 Y10\nG40 X0 Y0\nM30".replace(
            "G02 X150 Y50 J50", "G02 X50 Y50 J-50"
        ),
        radius=10,
    )
    assert path.error is None
    first, second = [motion for motion in path.motions if isinstance(motion, Arc)][:2]
    assert math.dist(first.start[:2], (100, 50)) == pytest.approx(60)
    assert math.dist(first.end[:2], (100, 50)) == pytest.approx(70)
    assert first.end[:2] == pytest.approx([100, -20])
    assert second.centre == pytest.approx([100, 50])
    assert second.radius == pytest.approx(70)


@pytest.mark.spec("isg.trc.tool-data-change")
def test_a_radius_that_changes_in_a_loop_acts_in_the_next_block() -> None:
    path = tool_path(
        "G00 X0 Y0\nG41 G01 X20\n$FOR P1 = 1, 3, 1\nX[20 + P1 * 20]\nV.G.WZ_AKT.R = V.G.WZ_AKT.R - 1\n$ENDFOR\nG40 X100\nM30"
    )
    assert path.error is None
    assert [tuple(motion.end[:2]) for motion in path.motions[1:]] == [(20, 5), (40, 5), (60, 4), (80, 3), (100, 0)]


@pytest.mark.spec("isg.trc.opt-perpendicular-radius-change")
@pytest.mark.parametrize("new", [6.0, 4.0])
@pytest.mark.parametrize("settings", ["G25", "G26"])
@pytest.mark.parametrize("command", ["G41", "G42"])
@pytest.mark.parametrize(
    "corner", ["G01 X50 Y50\nG01 X100", "G03 X50 Y25 R30\nG03 X90 Y18 R40", "G02 X50 Y25 R30\nG01 X80 Y40"]
)
def test_perpendicular_change_steps_along_the_normal(new: float, settings: str, command: str, corner: str) -> None:
    first, second = corner.split("\n")
    path = tool_path(
        f"#TRC [PERPENDICULAR_RADIUS_CHANGE=1]\nG0 X0 Y0\n{settings} {command} G01 X10 Y20\nX20\n{first}\n"
        f"V.G.WZ_AKT.R = {new}\n{second}\nG138 G40 G01 G91 X20\nG90 M30"
    )
    assert path.error is None
    after = next(motion for motion in path.motions if motion.source.line == 7)
    step = [motion for motion in path.motions if motion.source.line == 5][-1]
    assert isinstance(step, Line)
    assert math.dist(step.start[:2], step.end[:2]) == pytest.approx(1.0, abs=1e-9)
    if isinstance(after, Line):
        along = (after.end - after.start)[:2]
    else:
        u = after.start[:2] - after.centre
        along = np.array([-u[1], u[0]])
    assert abs(float(along @ (step.end - step.start)[:2])) / np.linalg.norm(along) < 1e-9


@pytest.mark.spec("isg.trc.feed-g10-g11")
def test_g11_keeps_the_feed_at_the_cutting_edge() -> None:
    text = "{} G26 G162 G00 X-20 Y0\nG41 G01 X0 Y0\nX40\nG03 X60 Y20 J20\nG01 Y40\nX100\nG02 X140 Y0 J-40\nG40 G01 Y-20\nM30"
    constant, adapted = tool_path(text.format("G10")), tool_path(text.format("G11"))
    assert [motion.feed for motion in constant.motions[1:]] == [1000.0] * len(constant.motions[1:])
    feeds = [(motion.source.line, type(motion).__name__, motion.feed) for motion in adapted.motions[1:]]
    assert feeds == [
        (2, "Line", 1000), (3, "Line", 1000), (4, "Arc", 750), (5, "Line", 1000), (5, "Arc", 2000), (6, "Line", 1000),
        (7, "Arc", 1125), (8, "Line", 1000),
    ]  # fmt: skip


@pytest.mark.spec("isg.add.tangfeed")
@pytest.mark.parametrize(
    ("command", "feeds"),
    [
        ("#TANGFEED [RMIN=0]", [750, 1125]),
        ("#TANGFEED [RMIN=20]", [750, 1125]),
        ("#TANGFEED [RMIN=21]", [1000, 1125]),
        ("#SET TANGFEED RMIN [41]", [1000, 1000]),
    ],
)
def test_g11_adapts_arcs_from_a_radius_on(command: str, feeds: list[float]) -> None:
    contour = "G41 G01 X0 Y0\nX40\nG03 X60 Y20 J20\nG01 Y40\nX100\nG02 X140 Y0 J-40\nG40 G01 Y-20"
    text = f"G11 G26 G162 G00 X-20 Y0\n{command}\n{contour}\nM30"
    path = tool_path(text)
    assert path.error is None
    assert [m.feed for m in path.motions if isinstance(m, Arc) and m.source.line in (5, 8)] == feeds


@pytest.mark.spec("isg.trc.g40-g41-g42")
@pytest.mark.parametrize("settings", ["G25", "G26"])
def test_runs_of_short_lines_give_the_path_of_the_single_blocks(settings: str) -> None:
    angles = np.linspace(0, 5, 700)
    points = [(60 * math.cos(a) + 4 * math.sin(7 * a), 60 * math.sin(a)) for a in angles]
    rows = "\n".join(f"X{x:.6f} Y{y:.6f}" for x, y in points)
    text = f"{settings} G00 X80 Y-10\nG42 G01 X{points[0][0]:.6f} Y{points[0][1]:.6f}\n{rows}\nG40 X0 Y0\nM30"
    run = tool_path(text)
    assert run.error is None
    blocks = decode("V.G.WZ_AKT.R=5 F1000 " + text).blocks
    assert sum(isinstance(block, Polyline) for block in run.blocks) > 0
    single = compensate(
        part for block in blocks for part in (motions_of([block]) if isinstance(block, Polyline) else [block])
    )
    assert len(single.motions) == len(run.motions)
    for one, other in zip(single.motions, run.motions, strict=True):
        assert one.end == pytest.approx(other.end, abs=1e-9)
        assert one.source.line == other.source.line
        assert one.feed == other.feed
        assert one.end_pcs == pytest.approx(other.end_pcs, abs=1e-9)


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_full_circles_inside_and_outside() -> None:
    path = tool_path("G162 G00 X-30 Y-10\nG41 G01 X-20 Y0\nG03 I20\nG40 G01 X-30 Y10\nM30")
    assert path.of(3) == [(-15, 0, 0, 0, 15, 360)]
    path = tool_path("G162 G00 X-30 Y-10\nG42 G01 X-20 Y0\nG03 I20\nG40 G01 X-30 Y10\nM30")
    assert path.of(3) == [(-25, 0, 0, 0, 25, 360)]


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_helix_of_several_turns() -> None:
    path = tool_path("G162 G00 X-30 Y-10\nG41 G01 X-20 Y0\nG03 X-20 Y0 Z-3 I20 K1\nG40 G01 X-30 Y10\nM30")
    assert path.of(3) == [(-15, 0, 0, 0, 15, 1080)]
    assert next(motion for motion in path.motions if isinstance(motion, Arc)).end[2] == -3


def test_suppressed_compensation_drives_the_programmed_path() -> None:
    path = tool_path("#TRC [SUPPRESS_TRC=1]\nG00 X-20 Y0\nG41 G01 X0 Y0\nX40\nY40\nG40 Y60\nM30")
    assert [shape[1:] for shape in path.shape] == [(-20, 0), (0, 0), (40, 0), (40, 40), (40, 60)]


@pytest.mark.spec("isg.trc.forbidden-commands")
@pytest.mark.parametrize(
    "command",
    [
        *(
            "#FLUSH",
            "#FLUSH WAIT",
            "#CHANNEL INIT [CMDPOS]",
            "#GET CMDPOS [P1=X]",
            "G303 X1",
            "P1=V.A.AXIS_DEACTIVATED.X",
        ),
        *("G200", "G200 X1", "G201 X1"),
    ],
)
def test_commands_that_empty_the_preparation_are_refused(command: str) -> None:
    run = decode(f"F1000 G41 G01 X10\nX20\n{command}\nG40 X30\nM30")
    assert run.problem is not None
    assert (run.problem.entry.id, run.problem.place.line) == (20651, 3)


@pytest.mark.spec("isg.trc.forbidden-commands")
@pytest.mark.parametrize("mode", ["G138", "G139", "G236", "G05"])
def test_they_need_the_exit_block_behind_g40(mode: str) -> None:
    run = decode(f"F1000 G41 G01 X10\nX20\n{mode} G40\n#FLUSH\nM30")
    assert run.problem is not None
    assert (run.problem.entry.id, run.problem.place.line) == (90050, 4)
    assert decode(f"F1000 G41 G01 X10\nX20\n{mode} G40\nX30\n#FLUSH\nM30").problem is None


@pytest.mark.spec("isg.trc.forbidden-commands")
@pytest.mark.parametrize("mode", ["G237", "G239"])
def test_without_an_exit_block_they_may_follow_at_once(mode: str) -> None:
    assert decode(f"F1000 {mode} G41 G01 X10\nX20\nG40\n#FLUSH\nM30").problem is None


@pytest.mark.spec("isg.trc.forbidden-commands", "isg.g.manual-exclusive-g200", "isg.g.manual-parallel-g201-g202")
@pytest.mark.parametrize("command", ["G200", "G201 X1"])
def test_hand_motion_waits_for_the_exit_block(command: str) -> None:
    begin = "F1000 G00 X-20 Y0\nG41 G01 X0\nX20\n"
    run = decode(f"{begin}G40\n{command}\nX40\nM30")
    assert run.problem is not None
    assert (run.problem.entry.id, run.problem.place.line) == (90050, 5)
    assert decode(f"G201 X1\n{begin}G202 X1\nG40 X40\nM30").problem is None  # to take the hand away is permitted


@pytest.mark.spec("isg.trc.forbidden-commands")
def test_flush_continue_is_permitted() -> None:
    path = tool_path("G00 X-20 Y0\nG41 G01 X0 Y0\nX40\n#FLUSH CONTINUE\nX60\nG40 X80\nM30")
    assert path.error is None


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_the_plane_stays() -> None:
    run = decode("F1000 G41 G01 X10\nX20\nG18\nG40 X30\nM30")
    assert run.problem is not None
    assert run.problem.entry.id == 20651
    assert run.problem.place.line == 3


@pytest.mark.spec("isg.trc.options-command")
def test_several_options_in_one_command_and_defaults_at_the_next_start() -> None:
    run = decode("#TRC [REVERSE=1 IGNORE_CONT_DAMAGE=1 \\\nSTRETCH_FACTOR=4]\nM30")
    assert run.problem is None
    settings = run.decoder.modal.compensation
    assert settings.reverse
    assert settings.ignore_damage
    assert settings.stretch == 4.0
    fresh = decode("#TRC [SUPPRESS_TRC=0]\nM30").decoder.modal.compensation
    assert not fresh.reverse
    assert fresh.stretch == 1.0


@pytest.mark.spec("isg.trc.options-command")
@pytest.mark.parametrize(
    "option",
    [
        "INVERSE=1 ONLINE=1",
        "TAPERLINK=1",
        "MULTI_PATH_RADIUS=REFERENCE",
        "GEN_CIR_BLOCK_IN_CORNER=1",
        "CONV_CIR_TO_LIN=1",
        "KERF_MASKING=1",
        "REMOVE_MASKED_BLOCKS=1",
    ],
)
def test_options_that_do_not_exist_here_are_refused_by_name(option: str) -> None:
    run = decode(f"#TRC [{option}]\nM30")
    assert run.problem is not None
    assert run.problem.entry is catalogue.OPTION_UNSUPPORTED
    assert option.replace("=", " ").split()[0] in run.problem.text


@pytest.mark.parametrize("number", [141])
def test_g_functions_that_do_not_exist_here_are_refused_by_name(number: int) -> None:
    (problem,) = problems(f"G{number}\nM30")
    assert problem.entry is language.G_UNSUPPORTED
    assert str(number) in problem.text


def test_online_needs_inverse() -> None:
    run = decode("#TRC [ONLINE=1]\nM30")
    assert run.problem is not None
    assert run.problem.entry.id == 22125


def test_window_is_bounded() -> None:
    path = tool_path("G00 X-20 Y0\nG41 G01 X0 Y0\nX40\n$FOR P1 = 1, 5000, 1\nM10\n$ENDFOR\nX60\nG40 X80\nM30")
    assert path.error is not None
    assert path.error.problem.entry is catalogue.TOO_MANY_BETWEEN


def test_steps_are_continuous_in_programmed_coordinates() -> None:
    path = tool_path("G54 G00 X-20 Y0\nG41 G01 X0 Y0\nX40\nY-40\nX0\nG40 X-20\nM30")
    for before, after in pairwise(path.motions):
        assert after.programmed(after.start) == pytest.approx(before.end_pcs, abs=1e-9)
