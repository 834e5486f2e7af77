"""Planes, units, dimensions, mirroring, rotation, scale: how programmed coordinates become machine coordinates."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Floats, Line, Polyline
from runtime.cnc.decoder import Decoder, load_program
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.decoder.selection import restore_modal
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.paths import contours, ends, motions, path, programmed
from tests.cnc.decoder.programs import SETUP, decode, found

ROTARY = replace(SETUP, axes=("X", "Y", "Z", "C"), linear=(True, True, True, False), zero_offsets={})


def entries(text: str) -> list[tuple[ErrorEntry, int]]:
    return [(entry, line) for entry, line, _ in found(text)]


# -- laws


def transformed(points: Floats, *, scale: float = 1, angle: float = 0, centre: tuple[float, float] = (0, 0)) -> Floats:
    """Points scaled, turned and shifted in the plane X Y."""
    c, s = math.cos(math.radians(angle)), math.sin(math.radians(angle))
    out = points.copy()
    out[:, 0] = scale * (points[:, 0] * c - points[:, 1] * s) + centre[0]
    out[:, 1] = scale * (points[:, 0] * s + points[:, 1] * c) + centre[1]
    return out


@pytest.mark.spec("isg.g.mirror-plane-g20-g23", "isg.g.mirror-axis-g351")
@settings(max_examples=60)
@given(
    contour=contours(),
    mirror=st.sampled_from(
        [("G21", (-1, 1)), ("G22", (1, -1)), ("G23", (-1, -1)), ("G351 X-1", (-1, 1)), ("G21\nG351 X-1 Y-1", (1, -1))]
    ),
)
def test_a_mirrored_program_gives_the_mirrored_path(contour: str, mirror: tuple[str, tuple[int, int]]) -> None:
    word, signs = mirror
    plain, mirrored = decode(f"{contour}\nM30"), decode(f"{word}\n{contour}\nM30")
    np.testing.assert_allclose(path(mirrored), path(plain) * (*signs, 1), atol=1e-6)
    np.testing.assert_allclose(programmed(mirrored), programmed(plain), atol=1e-6)


@pytest.mark.spec("isg.add.rotation", "isg.g.rotation-g68-g69")
@settings(max_examples=60)
@given(contours(), st.integers(-360, 360), st.integers(-50, 50), st.booleans())
def test_a_rotated_program_gives_the_rotated_path(contour: str, angle: int, centre: int, statement: bool) -> None:
    word = f"#ROTATION ON [ANGLE={angle} CENTER1={centre} CENTER2 7]" if statement else f"G68 R{angle} X{centre} Y7"
    plain, rotated = decode(f"{contour}\nM30"), decode(f"{word}\n{contour}\nM30")
    expected = transformed(path(plain), angle=angle, centre=(centre, 7))
    np.testing.assert_allclose(path(rotated), expected, atol=1e-6)


@pytest.mark.spec("isg.add.scale", "isg.add.scale-circles")
@settings(max_examples=60)
@given(contours(), st.sampled_from([0.3, 0.5, 2.0, 7.0]))
def test_a_scaled_program_gives_the_scaled_path(contour: str, factor: float) -> None:
    plain, scaled = decode(f"{contour}\nM30"), decode(f"#SCALE ON X{factor} Y{factor}\n{contour}\nM30")
    np.testing.assert_allclose(path(scaled), path(plain) * (factor, factor, 1), atol=1e-6)
    np.testing.assert_allclose(programmed(scaled), programmed(plain), atol=1e-6)


@settings(max_examples=60)
@given(contours(), st.permutations(["G55", "G92 X3 Y-4", "G351 X-1", "#SCALE ON X2 Y2", "#ROTATION ON [ANGLE 40]"]))
def test_the_order_of_selecting_has_no_influence(contour: str, order: list[str]) -> None:
    """Scale, rotation, mirroring, offsets: in this order, whichever was programmed first."""
    plain = decode(f"{contour}\nM30")
    moved = decode("\n".join(order) + f"\n{contour}\nM30")
    expected = transformed(path(plain), scale=2, angle=40) * (-1, 1, 1) + (200 - 3, 20 - 4, 2)
    np.testing.assert_allclose(path(moved), expected, atol=1e-6)


@pytest.mark.spec("isg.g.units-g70-g71")
@settings(max_examples=40)
@given(contours())
def test_a_program_in_inch_is_25_4_times_as_large(contour: str) -> None:
    metric = decode(f"{contour}\nM30")
    inch = decode(f"G70\n{contour}\nM30")
    np.testing.assert_allclose(path(inch), path(metric) * 25.4, atol=1e-5)


@pytest.mark.spec("isg.g.g-function-system")
def test_every_program_begins_in_the_initial_state(tmp_path: Path) -> None:
    """G01 G17 G20 G53 G69 G71 G90 G94 G162 G165, no offset, no radius, no feed: whatever the program before has left."""
    assert ends("G1 X1 F1\nG01 X2\nG0 X3\nG00 X4\nM30") == [[1, 0, 0], [2, 0, 0], [3, 0, 0], [4, 0, 0]]
    file = tmp_path / "a.nc"
    file.write_text("G02 G18 G22 G55 G70 G91 G95 G161 G164 F3 R5\nG92 X1\nG351 Z-1\n#SCALE ON X2\nG68 R30 Z1\nM30")
    memory = ChannelMemory(SETUP)
    for _ in range(2):
        program = load_program(file, SETUP)
        decoder = Decoder(program, SETUP, start=np.zeros(3), memory=memory)
        coordinates = decoder.execution.coordinates
        assert decoder.modal == ModalState()
        assert (coordinates.gain, coordinates.shift, coordinates.rotation) == ([1, 1, 1], [0, 0, 0], None)
        assert len(list(decoder.blocks())) == 1
        assert coordinates.rotation is not None
        program.close()


# -- planes


@pytest.mark.spec("isg.g.plane-g17-g18-g19")
def test_a_change_of_plane_ends_a_rotation() -> None:
    run = decode("#ROTATION ON [ANGLE=90]\nG00 X1 Y0\nG18\nX1 Y0\nG17\nX1\nM30")
    np.testing.assert_allclose(run.ends, [[0, 1, 0], [1, 0, 0], [1, 0, 0]], atol=1e-12)
    assert [(w.entry, w.place.line) for w in run.decoder.warnings] == [(catalogue.ROTATION_ENDED, 3)]
    again = decode("#ROTATION ON [ANGLE=90]\nG17\nG00 X1 Y0\nM30")
    assert again.decoder.warnings == []
    np.testing.assert_allclose(again.ends, [[0, 1, 0]], atol=1e-12)


# -- dimension


@pytest.mark.spec("isg.g.dimension-g90-g91")
def test_dimension_counts_for_the_arguments_of_its_block() -> None:
    assert ends("G92 X1\nG92 X10 G91\nG90 G00 X0\nG92 X10 G90\nX0\nM30") == [[11, 0, 0], [10, 0, 0]]
    assert entries("G90 X1 G91 Y1\nM30") == [(catalogue.G_GROUP_TWICE, 1)]
    assert entries("G90 X1 G90 Y1\nM30") == [(catalogue.G_GROUP_TWICE, 1)]


@pytest.mark.spec("isg.g.dimension-combined")
def test_both_dimensions_in_one_block() -> None:
    setup = replace(SETUP, mixed_dimension=True)
    text = "G00 X10 Y10 Z10\nG91 X1 G90 Y1 G91 Z1\nX1 G90 Y1\nX2\nX1 G91 Y1 G90\nX3\nM30"
    assert ends(text, setup=setup) == [[10, 10, 10], [11, 1, 11], [12, 1, 11], [2, 1, 11], [1, 2, 11], [3, 2, 11]]


@pytest.mark.spec("isg.g.units-g70-g71")
def test_inch_counts_for_the_arguments_of_its_block() -> None:
    np.testing.assert_allclose(ends("G92 X1 G70\nG71 G00 X0\nM30"), [[25.4, 0, 0]])
    np.testing.assert_allclose(ends("G70\n#ROTATION ON [ANGLE=0 CENTER1=1]\nG71 G00 X0 Y0\nM30"), [[25.4, 0, 0]])
    np.testing.assert_allclose(ends("G70\n#PSET X1\nG71 G00 X0\nM30"), [[-25.4, 0, 0]])
    np.testing.assert_allclose(ends("G70 G00 X1 C10\nM30", (0, 0, 0, 0), ROTARY), [[25.4, 0, 0, 10]])


# -- mirroring


@pytest.mark.spec("isg.g.mirror-plane-g20-g23")
def test_mirroring_in_the_plane() -> None:
    part = "%L PART\nG90 X10 Y20\nG91 X5 Y-5\nX-5 Y-5\nY10\nM17\n%MAIN\nG92 X60 Y40\nG01 F500\n"
    expected = [[70, 60], [75, 55], [70, 50], [70, 60]]
    for word, signs in (("G20", (1, 1)), ("G21", (-1, 1)), ("G22", (1, -1)), ("G23", (-1, -1))):
        mirrored = [[60 + (x - 60) * signs[0], 40 + (y - 40) * signs[1], 0] for x, y in expected]
        assert ends(f"{part}{word}\nLL PART\nM30") == mirrored  # G92 is not mirrored


@pytest.mark.spec("isg.g.mirror-plane-g20-g23")
def test_mirroring_moves_nothing_and_a_full_circle_keeps_its_start() -> None:
    (line, arc) = motions(decode("G00 X10 M14\nG21\nG161 G02 I15 J0 F100\nM30"))
    assert isinstance(arc, Arc)
    assert (line.end[0], arc.start[0], arc.end[0]) == (10, 10, 10)  # type: ignore[union-attr]
    assert (arc.centre.tolist(), arc.radius, arc.angle) == ([-15, 0], 25, 360)


@pytest.mark.spec("isg.g.mirror-plane-g20-g23")
@pytest.mark.parametrize(("circle", "sense"), [("G17 G03 I1 J1", -1), ("G18 G03 K1 I1", -1), ("G19 G03 J1 K1", 1)])
def test_g21_mirrors_x_in_every_plane(circle: str, sense: int) -> None:
    """The third main axis is never mirrored: a circle in Y Z keeps its sense with G21."""
    (arc,) = motions(decode(f"G21 {circle} F100\nM30"))
    assert isinstance(arc, Arc)
    assert arc.angle == sense * 360


@pytest.mark.spec("isg.g.mirror-axis-g351")
def test_mirroring_by_axis() -> None:
    text = "G92 X10 Y10\nG00 X1 Y1\nG351 X-1\nX1 Y1\nG351 Y-1 X+1\nX1 Y1\nG351 Z-1\nZ5\nG91 Z5\nG90 G351 X1"
    assert entries(text + "\nM30") == [(catalogue.NOT_ALONE, 10)]
    text = text.replace("G90 G351 X1", "G90\nG351 X1 Y1 Z1\nX1 Y1 Z1")
    assert ends(text + "\nM30") == [
        [11, 11, 0],
        [-11, 11, 0],  # G92 of a mirrored axis is mirrored
        [11, -11, 0],
        [11, -11, -5],
        [11, -11, -10],
        [11, 11, 1],
    ]
    assert entries("G351\nM30") == [(catalogue.AXIS_ARGUMENT, 1)]
    assert entries("G351 X-1 X1\nM30") == [(catalogue.WORD_TWICE, 1)]
    assert entries("G351 X2\nM30") == [(catalogue.MIRROR_VALUE, 1)]
    assert entries("G351 X-1 F100\nM30") == [(catalogue.NOT_ALONE, 1)]


# -- rotation

# The same stairs, with every mixture of dimensions; both centre values act with the first absolute word of their axis.
_STAIRS = (
    "G91 X20\nY20\nX20\nY20\nX20\nY20",
    "G91 X20\nG90 Y10\nG91 X20\nG90 Y30\nG91 X20\nG90 Y50",
    "G90 X0\nG91 Y20\nG90 X20\nG91 Y20\nG90 X40\nG91 Y20",
    "G90 X0\nY10\nX20\nY30\nX40\nY50",
)


@pytest.mark.spec("isg.add.rotation-incremental")
@pytest.mark.parametrize("stairs", _STAIRS)
def test_a_centre_acts_with_the_first_absolute_word_of_its_axis(stairs: str) -> None:
    text = f"G01 F500\n#ROTATION ON [ANGLE 0 CENTER1 20 CENTER2 10]\n{stairs}\nG90\n#ROTATION OFF\nX0\nY0\nM30"
    assert [end[:2] for end in ends(text)] == [
        [20, 0],
        [20, 20],
        [40, 20],
        [40, 40],
        [60, 40],
        [60, 60],
        [0, 60],
        [0, 0],
    ]


@pytest.mark.spec("isg.add.rotation-incremental")
def test_the_angle_acts_at_once_and_the_centre_with_an_absolute_word() -> None:
    text = (
        "G00 X0 Y0 F200\n#ROTATION ON [ANGLE 30 CENTER1 10 CENTER2 10]\nX0 Y0\nG03 I1 J1\nG01 X10\n"
        "#ROTATION ON [ANGLE 90 CENTER1 -10 CENTER2 0]\nG03 I1 J1\nG01 G91 X10\nY10\nG90 X0 Y0\nM30"
    )
    run = decode(text)
    c, s = math.cos(math.radians(30)), math.sin(math.radians(30))
    here = np.array([10 + 10 * c, 10 + 10 * s])
    up, corner, centre = (here + np.array(way) for way in ((0, 10), (-10, 10), (-1, 1)))
    np.testing.assert_allclose(
        np.array(run.ends)[:, :2],
        np.array([[0, 0], [10, 10], [10, 10], here, here, up, corner, [-10, 0]]),
        atol=1e-9,
    )
    first, second = (block for block in run.blocks if isinstance(block, Arc))
    np.testing.assert_allclose(first.centre, [10 + c - s, 10 + s + c])
    np.testing.assert_allclose(second.centre, centre)


@pytest.mark.spec("isg.add.rotation-incremental")
@pytest.mark.parametrize("rotation", ["", "#ROTATION ON [ANGLE 0 CENTER1 25 CENTER2 -75]", "#ROTATION ON [ANGLE 50]"])
@pytest.mark.parametrize("centre", ["G161 I-75 J0", "G161 I-75", "G162 I0 J-50", "G162 J-50"])
def test_absolute_and_relative_centres_are_turned_alike(rotation: str, centre: str) -> None:
    (arc,) = (
        block
        for block in decode(f"F900\nG54\n{rotation}\nG00 X-75 Y50\nG03 X-75 Y-50 {centre}\nM30").blocks
        if isinstance(block, Arc)
    )
    assert arc.angle == pytest.approx(180)
    angle, origin = (math.radians(50), (0, 0)) if "50]" in rotation else (0.0, (25, -75) if rotation else (0, 0))
    wanted = [-75 * math.cos(angle) + origin[0] + 100, -75 * math.sin(angle) + origin[1] + 10]
    np.testing.assert_allclose(arc.centre, wanted)


@pytest.mark.spec("isg.add.rotation")
def test_rotation_keeps_what_is_not_given_and_moves_nothing() -> None:
    text = (
        "G00 X1 Y0\n#ROTATION ON [ANGLE=90 CENTER1=10]\n#ROTATION OFF\nX2\n#ROTATION ON\nX1 Y0\n"
        "#ROTATION ON [CENTER2=5]\nX1 Y0\n#ROTATION OFF\nX1 Y0\nM30"
    )
    np.testing.assert_allclose(np.array(ends(text))[:, :2], [[1, 0], [2, 0], [10, 1], [10, 6], [1, 0]], atol=1e-12)


@pytest.mark.spec("isg.add.rotation")
def test_offsets_act_along_the_machine_axes_and_mirroring_behind_the_rotation() -> None:
    before = ends("G54\n#ROTATION ON [ANGLE=90]\nG21\nG00 X1 Y0\nM30")
    behind = ends("G21\n#ROTATION ON [ANGLE=90]\nG54 G00 X2 Y1\nM30")
    np.testing.assert_allclose([before[0][:2], behind[0][:2]], [[100, 11], [101, 12]], atol=1e-12)


@pytest.mark.spec("isg.add.rotation", "isg.g.rotation-g68-g69")
def test_rotation_in_other_planes() -> None:
    np.testing.assert_allclose(ends("G18 G68 R90 Z1 X2\nG00 Z10 X0\nM30"), [[12, 0, 1]], atol=1e-12)
    np.testing.assert_allclose(ends("G68 R90 Y1 Z2 G19\nG00 Y10 Z0\nM30"), [[0, 1, 12]], atol=1e-12)
    np.testing.assert_allclose(ends("G18\n#ROTATION ON [ANGLE=90]\nG00 Z10 X0\nM30"), [[10, 0, 0]], atol=1e-12)


@pytest.mark.spec("isg.g.rotation-g68-g69")
def test_g68_without_a_centre_turns_about_where_the_axes_are() -> None:
    text = "G54 G00 X5 Y6\nG55\nG68 R90\nX0 Y0\nX1\nG69\nX0 Y0\nG68\nX1 Y1\nM30"
    np.testing.assert_allclose(
        np.array(ends(text))[:, :2], [[105, 16], [105, 16], [105, 17], [200, 20], [201, 21]], atol=1e-9
    )


@pytest.mark.spec("isg.g.rotation-g68-g69")
def test_wrong_rotations() -> None:
    assert entries("G68 R10 Z1\nM30") == [(catalogue.ROTATION_AXES, 1)]
    assert entries("G68 G69\nM30") == [(catalogue.G_GROUP_TWICE, 1)]
    two = replace(SETUP, axes=("X", "Y"), linear=(True, True), zero_offsets={})
    run = decode("G18 G68 R1\nM30", two, start=(0, 0))
    assert run.problem is not None
    assert run.problem.entry is catalogue.PLANE_UNAVAILABLE


# -- scale


@pytest.mark.spec("isg.add.scale")
def test_scale_acts_on_coordinates_and_not_on_offsets() -> None:
    text = (
        "#SCALE X0.5 Z3\nG54 G00 X10 Y10 Z10\n#SCALE ON\nX10 Y10 Z10\nG55 X10\nG91 X10\nG90\n#SCALE OFF\n#SCALE X4\nX10\n"
        "#SCALE ON\nX10 Z1\nM30"
    )
    assert ends(text) == [
        [110, 20, 11],
        [105, 20, 31],
        [205, 20, 31],
        [210, 20, 31],
        [210, 20, 31],
        [240, 20, 5],
    ]


@pytest.mark.spec("isg.add.scale")
@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("#SCALE X0", catalogue.SCALE_FACTOR),
        ("#SCALE ON X-1", catalogue.SCALE_FACTOR),
        ("#SCALE ON X2\n#SCALE X3", catalogue.SCALE_ACTIVE),
        ("#SCALE ON X2\n#SCALE ON X3", catalogue.SCALE_ACTIVE),
        ("#SCALE ON C2", catalogue.SCALE_AXIS),
    ],
)
def test_wrong_scales(text: str, entry: ErrorEntry) -> None:
    assert [found[0] for found in found_with_c(text + "\nM30")] == [entry]


def found_with_c(text: str) -> list[tuple[ErrorEntry, int, int]]:
    return list(found(text, ROTARY))


@pytest.mark.spec("isg.add.scale-circles")
def test_a_radius_is_scaled_with_the_factor_of_x() -> None:
    (arc,) = motions(decode("#SCALE ON X1.5 Y1.5\nG03 R33 X-66 Y0 F100\nM30"))
    assert isinstance(arc, Arc)
    assert arc.radius == pytest.approx(49.5)
    assert entries("#SCALE ON X0.3 Y0.8\nG02 G91 X80 Y80 I40 J40 F100\nM30") == []  # a centre on the bisector
    assert entries("#SCALE ON X0.3 Y0.8\nG02 G91 X80 Y80 I80 J0 F100\nM30") == [(catalogue.CENTRE_DEVIATION, 2)]


@pytest.mark.spec("isg.add.scale-circles")
def test_the_pitch_of_a_helix_is_scaled_with_its_axis() -> None:
    (arc,) = motions(decode("#SCALE ON X2 Y2 Z3\nG03 I5 Z40 K10 F100\nM30"))
    assert isinstance(arc, Arc)
    assert [arc.angle, arc.end[2]] == pytest.approx([4 * 360, 120])


# -- rotary axes


@pytest.mark.spec("isg.g.rapid-rotary-shortest")
@pytest.mark.parametrize(
    ("start", "text", "end"),
    [
        (0, "G00 C270", -90),
        (0, "G00 C180", 180),
        (0, "G00 C-180", -180),
        (0, "G00 C[270]", -90),
        (0, "G00 C270 M14", -90),
        (350, "G00 C10", 370),
        (3605, "G00 C0", 3600),
        (0, "G00 G91 C270", 270),
        (0, "G91\nG00 C270", 270),
        (0, "G01 C270 F100", -90),
        (0, "G351 C-1\nG00 C270", 90),
    ],
)
def test_a_rotary_axis_takes_the_shorter_way(start: float, text: str, end: float) -> None:
    assert ends(f"{text}\nM30", (0, 0, 0, start), ROTARY) == [[0, 0, 0, end]]


@pytest.mark.spec("isg.g.rapid-rotary-shortest")
def test_a_rotary_axis_with_limits_goes_where_it_is_told() -> None:
    limits = ((None, None), (None, None), (None, None), (-360.0, 360.0))
    assert ends("G00 C270\nM30", (0, 0, 0, 0), replace(ROTARY, position_limits=limits)) == [[0, 0, 0, 270]]


# -- cycles


@pytest.mark.spec("isg.g.mirror-plane-g20-g23", "isg.g.zero-offset-g53-g59")
def test_what_was_selected_before_a_cycle_holds_again_behind_it(tmp_path: Path) -> None:
    """Modal functions that stand alone come back, those with axis names and statements stay (lines 7389–7392)."""
    file = tmp_path / "a.nc"
    file.write_text("G90 G21 G55 G18 G70 G161 G164\nG92 X1\nG351 Y-1\n#ROTATION ON [ANGLE=90]\nM00\nM30")
    program = load_program(file, SETUP)
    decoder = Decoder(program, SETUP, start=np.zeros(3))
    next(iter(decoder.blocks()))
    restore_modal(decoder.execution, ModalState(zero_offset=1))
    program.close()
    coordinates = decoder.execution.coordinates
    assert coordinates.rotation is None
    assert (coordinates.gain, coordinates.shift) == ([1, -1, 1], [125.4, 10, 1])
    assert [warning.entry for warning in decoder.warnings] == [catalogue.ROTATION_ENDED]
    assert decoder.execution.fast


# -- plain runs and full blocks

_SELECTIONS = ["G91", "G70", "G54", "G92 X5 Z-1", "G21", "G22", "G23", "G351 X-1 Y-1", "#SCALE ON X2 Y3", "G95 S100 M14",
               "#ROTATION ON [ANGLE=25]", "G18", "G01 F77", "G00"]  # fmt: skip
_rows = st.lists(
    st.sampled_from(["G01 X1 Y2 F100", "N7 X3", "Z-1.5", "G0 X1.25 Z2", "F300", "X4", "G1 Y5", "X-2 Y7.5 Z3", "G01"]),
    min_size=1,
    max_size=8,
)


@settings(max_examples=80)
@given(st.lists(st.sampled_from(_SELECTIONS), max_size=4), _rows)
def test_plain_runs_decode_like_full_and_like_fast_blocks(selections: list[str], rows: list[str]) -> None:
    """The same words for the kernel, with an expression for the fast road, with a silent function for the long one."""
    before = [*selections, "G01 F50" if "F77" not in "".join(selections) else "G01"]
    texts = (rows, [row.replace("X", "X=0+").replace("Y", "Y=0+") for row in rows], [f"{row} M14" for row in rows])
    runs = [decode("\n".join([*before, "P9 = 0", *text, "M30"]), replace(SETUP, feed_factor=2.0)) for text in texts]
    for other in runs[1:]:
        assert (runs[0].problem is None) == (other.problem is None)
        one, two = ([row for row in run.rows if "to" in row] for run in (runs[0], other))
        assert len(one) == len(two)
        for first, second in zip(one, two, strict=True):
            assert (first["line"], first["n"], first["feed"], first["rapid"]) == (
                second["line"],
                second["n"],
                second["feed"],
                second["rapid"],
            )
            for key in ("from", "to", "to_pcs"):
                np.testing.assert_allclose(list(first[key].values()), list(second[key].values()), atol=1e-9)  # type: ignore[attr-defined]


def test_a_plain_run_of_a_mirrored_scaled_program_is_one_polyline() -> None:
    run = decode("G21\n#SCALE ON X2\nG01 F100\nX1\nX2\nX3\nM30")
    (line,) = (block for block in run.blocks if isinstance(block, Polyline))
    assert line.points[:, 0].tolist() == [0, -2, -4, -6]
    assert not any(isinstance(block, Line) for block in run.blocks)


@pytest.mark.spec("isg.lex.units-ranges")
def test_positions_must_stay_in_their_range_with_everything_added() -> None:
    assert entries("G00 X214000\nM30") == []
    assert entries("G54\nG00 X213950\nM30") == [(catalogue.POSITION_RANGE, 2)]
    assert entries("#SCALE ON X3\nG00 X100000\nM30") == [(catalogue.POSITION_RANGE, 2)]
    assert entries("#ROTATION ON [ANGLE=45]\nG00 X200000 Y200000\nM30") == [(catalogue.POSITION_RANGE, 2)]
    assert entries("G00 X[500000 - 499999]\nM30") == []
    assert entries("G00 X-200000\nG03 I1000000 J0 F100 R=1\nM30") != []
    assert entries("G02 X10 R900000000 F100\nM30") == []
    assert entries("G00 X200000\nG02 I-20000 #CANG=359 F100\nG01 #ANG=0.001 Y10000\nM30") == [
        (catalogue.POSITION_RANGE, 3)
    ]
