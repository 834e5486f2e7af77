"""How the tool comes to the contour and leaves it: every strategy at inside, outside and acute corners."""

from __future__ import annotations

import math

import pytest

from runtime.cnc.blocks import Line, TechnologyFunction
from runtime.diagnostics.catalogue import radius as catalogue
from tests.cnc.decoder.programs import decode
from tests.cnc.tool_radius_comp.paths import tool_path

R = 5.0
ROOT = math.sqrt(0.5)


def enter(mode: str, start: str, second: str = "X40 Y0") -> list[list[tuple[float, ...]]]:
    """Approach from `start` to the zero point, then the line to `second`: shapes of both."""
    path = tool_path(
        f"G00 {start}\n{mode} G41 G01 X0 Y0\nX{second.split()[0][1:]} {second.split()[1]}\nX50 Y30\nG40 X60 Y60\nM30"
    )
    assert path.error is None
    return [path.of(2), path.of(3)]


@pytest.mark.spec("isg.trc.direct-g138")
@pytest.mark.parametrize("start", ["X-20 Y20", "X-20 Y0", "X-20 Y-20", "X0 Y-20", "X20 Y-20"])
def test_direct_goes_to_the_normal_of_the_first_element_whatever_the_angle(start: str) -> None:
    assert enter("G138", start)[0] == [(0.0, R)]


@pytest.mark.spec("isg.trc.indirect-g139", "isg.trc.selection-modes")
@pytest.mark.parametrize("mode", ["G139", ""])
def test_indirect_is_direct_at_an_inside_corner(mode: str) -> None:
    assert enter(mode, "X-20 Y20")[0] == [(0.0, R)]
    assert enter(mode, "X-20 Y0")[0] == [(0.0, R)]


@pytest.mark.spec("isg.trc.indirect-g139")
def test_indirect_goes_around_an_outside_corner_with_g25() -> None:
    approach, first = enter("G139 G25", "X0 Y-20")
    # from below, turning right: over its own normal (-5, 0) straight on to the offset line y = 5
    assert approach[0] == pytest.approx((-6.25, R))
    assert len(approach) == 1
    assert first == [pytest.approx((40 - 5 * math.tan(math.atan2(30, 10) / 2), R), abs=1e-6)]


@pytest.mark.spec("isg.trc.indirect-g139")
def test_indirect_goes_around_an_acute_corner_with_an_inserted_line() -> None:
    approach, _ = enter("G139 G25", "X20 Y-20")
    assert len(approach) == 2
    assert approach[1] == (-R, R)  # as far as one radius beyond the normal of the first element


@pytest.mark.spec("isg.trc.indirect-g139")
@pytest.mark.parametrize(("start", "angle"), [("X0 Y-20", -90.0), ("X20 Y-20", -135.0)])
def test_indirect_goes_around_with_an_arc_with_g26(start: str, angle: float) -> None:
    approach, _ = enter("G139 G26", start)
    assert len(approach) == 2
    assert approach[1] == (0.0, R, 0.0, 0.0, R, angle)


@pytest.mark.spec("isg.trc.direct-g138", "isg.trc.indirect-g139")
@pytest.mark.parametrize("mode", ["G138", "G139 G25", "G139 G26", "G05", "G236"])
@pytest.mark.parametrize("place", ["X-20 Y20", "X-20 Y0", "X0 Y-20", "X20 Y-20"])
def test_leaving_is_entering_seen_backwards(mode: str, place: str) -> None:
    """The same contour driven the other way on the other side gives the same path backwards."""
    forth = tool_path(f"G00 {place}\n{mode} G41 G01 X0 Y0\nX40\nG138 G40 X60\nM30")
    back = tool_path(f"G00 X60\nG138 G42 G01 X40 Y0\n{mode.replace('G05', '')} X0\n{mode} G40 {place}\nM30")
    assert forth.error is None
    assert back.error is None
    points = [tuple(motion.end[:2]) for motion in forth.motions]
    backwards = [tuple(motion.end[:2]) for motion in back.motions]
    assert len(points) == len(backwards)
    for one, other in zip(points, reversed(backwards), strict=True):
        assert one == pytest.approx(other, abs=1e-9)


@pytest.mark.spec("isg.trc.perpendicular-g237")
@pytest.mark.parametrize("side", [1, -1])
def test_perpendicular_inserts_a_line_at_both_ends(side: int) -> None:
    command = {1: "G41", -1: "G42"}[side]
    path = tool_path(f"G00 X10 Y10\nG237 {command}\nG03 X60 Y60 J50\nG01 Y100\nG03 X10 Y150 I-50\nG40\nM30")
    assert path.error is None
    begin = path.motions[1]
    assert begin.start[:2] == pytest.approx([10, 10])
    assert math.dist(begin.start[:2], begin.end[:2]) == pytest.approx(R)
    last = path.motions[-1]
    assert last.source.line == 6
    assert last.end[:2] == pytest.approx([10, 150])
    assert math.dist(last.start[:2], last.end[:2]) == pytest.approx(R)


@pytest.mark.spec("isg.trc.perpendicular-g237")
def test_perpendicular_compensates_a_single_block() -> None:
    path = tool_path("G00 X10 Y10\nG237\nG41\nG01 X70\nG40\nX100 Y0\nM30")
    assert path.shape[1:] == [(3, 10, 15), (4, 70, 15), (5, 70, 10), (6, 100, 0)]


@pytest.mark.spec("isg.trc.g237-technology-order")
def test_functions_behind_g41_come_behind_the_inserted_line() -> None:
    path = tool_path("G00 X10 Y10\nG237\nG41 M13\nM10\nM11 G01 X70\nM12\nG40\nX100 Y0\nM30")
    order = [
        getattr(block, "number", None) or f"line {block.source.line}"
        for block in path.blocks
        if isinstance(block, TechnologyFunction | Line)
    ]
    assert order == [13, "line 3", 10, 11, "line 5", 12, "line 7"]


@pytest.mark.spec("isg.trc.no-block-g239")
def test_without_block_goes_on_from_where_the_tool_is() -> None:
    begin = "G00 X0 Y0\nG239 G41 G01 X30 Y20\nX60\nX120\nG40\n"
    assert tool_path(begin + "G00 X150 Y0\nM30").shape[-2:] == [(4, 120, 25), (6, 150, 0)]
    assert tool_path(begin + "G00 X150\nX200\nM30").shape[-2:] == [(6, 150, 25), (7, 200, 25)]
    again = tool_path(begin + "G41 G01 X150\nX200\nG40\nM30")
    assert again.shape[-2:] == [(6, 150, 30), (7, 200, 30)]


@pytest.mark.spec("isg.trc.no-block-g239")
def test_an_arc_directly_behind_g239_does_not_fit() -> None:
    run = decode(
        "N1 V.G.WZ_AKT.R=30 F1000 G162 G0 X0 Y0\nG239\nG41 G01 X30 Y20\nX60\nX90\nG40\nG02 X140 Y-30 J-50\nM30"
    )
    assert run.problem is not None
    assert run.problem.entry.id == 20035


@pytest.mark.spec("isg.trc.tangential-g05")
@pytest.mark.parametrize("start", [(-20, 20), (-20, 5), (-20, -15), (3, -15), (-2, 30)])
def test_tangential_entry_ends_in_the_direction_of_the_first_element(start: tuple[float, float]) -> None:
    path = tool_path(f"G00 X{start[0]} Y{start[1]}\nG05 G41 G01 X0 Y0\nX40\nG40 Y30\nM30")
    entry = path.of(2)[0]
    assert entry[:2] == (0.0, R)
    if start[1] == 5:
        assert len(entry) == 2  # it lies on the tangent: a line
    else:
        assert entry[2] == 0.0  # the centre lies on the normal of the first element
        assert math.copysign(1, entry[5]) == math.copysign(1, entry[3] - R)  # it ends along +X


@pytest.mark.spec("isg.trc.tangential-g05")
def test_g05_needs_g40_g41_or_g42_in_its_block() -> None:
    run = decode("G05 X10\nM30")
    assert run.problem is not None
    assert run.problem.entry is catalogue.TANGENTIAL_ALONE


@pytest.mark.spec("isg.trc.on-path-g236")
def test_on_path_at_an_acute_inside_corner_ends_where_the_path_meets_the_offset() -> None:
    approach, first = enter("G236", "X30 Y20")
    assert approach[0] == pytest.approx((7.5, R))
    assert len(approach) == 1
    assert first[0][1] == R


@pytest.mark.spec("isg.trc.on-path-g236")
def test_on_path_at_an_obtuse_inside_corner_ends_with_an_arc() -> None:
    arc = enter("G236", "X-20 Y20")[0]
    assert arc[0] == pytest.approx((-R * ROOT, R * ROOT), abs=1e-6)
    assert arc[1] == (0.0, R, 0.0, 0.0, R, -45.0)


@pytest.mark.spec("isg.trc.opt-g236-lin")
def test_g236_lin_inserts_a_line() -> None:
    path = tool_path("G00 X-20 Y20\n#TRC [G236_LIN=1]\nG236 G41 G01 X0 Y0\nX40\nG40 X60 Y60\nM30")
    assert path.of(3) == [(-R, R), (0.0, R)]


@pytest.mark.spec("isg.trc.on-path-g236")
@pytest.mark.parametrize(("start", "angle"), [("X-20 Y-20", -135.0), ("X0 Y-20", -180.0), ("X20 Y-20", -225.0)])
def test_on_path_at_an_outside_corner_goes_around_it(start: str, angle: float) -> None:
    approach, _ = enter("G236 G25", start)
    assert math.hypot(*approach[0]) == pytest.approx(R, abs=1e-6)
    assert approach[1] == (0.0, R, 0.0, 0.0, R, angle)


@pytest.mark.spec("isg.trc.on-path-g236")
def test_on_path_needs_an_approach_of_one_radius() -> None:
    path = tool_path("G00 X-4 Y0\nG236 G41 G01 X0 Y0\nX40\nG40 X60\nM30")
    assert path.error is not None
    assert path.error.problem.entry is catalogue.APPROACH_SHORT
    assert path.error.problem.place.line == 2


@pytest.mark.spec("isg.trc.direct-g138", "isg.trc.indirect-g139", "isg.trc.on-path-g236")
@pytest.mark.parametrize("mode", ["G138", "G139 G25", "G139 G26", "G236"])
@pytest.mark.parametrize("approach", ["G01 X0 Y0", "G03 X0 Y0 I20", "G02 X0 Y0 J-20"])
@pytest.mark.parametrize("first", ["G01 X40", "G02 X30 Y-30 J-30", "G03 X40 Y40 J40"])
def test_every_pair_of_line_and_arc_can_be_entered(mode: str, approach: str, first: str) -> None:
    start = {"G01": "X-20 Y0", "G03": "X-20 Y20", "G02": "X20 Y20"}[approach[:3]]
    path = tool_path(f"G00 {start} G162\n{mode} G41 {approach}\n{first}\nG01 G91 X50 Y0\nG90 G138 G40 X150 Y150\nM30")
    if path.error is not None:
        assert path.error.problem.entry in (catalogue.CONTOUR_DAMAGED, catalogue.OFFSETS_APART)
        return
    first_motion = next(motion for motion in path.motions if motion.source.line == 3)
    assert first_motion.start[1] == pytest.approx(R, abs=6.0)


@pytest.mark.spec("isg.trc.g40-g41-g42")
def test_without_a_contour_the_programmed_path_is_driven() -> None:
    assert tool_path("G00 X0 Y0\nG41 G01 X10 Y10\nG40 X20\nM30").shape == [(1, 0, 0), (2, 10, 10), (3, 20, 10)]
    assert tool_path("G00 X0 Y0\nG41\nG40\nG01 X20\nM30").shape == [(1, 0, 0), (4, 20, 0)]
