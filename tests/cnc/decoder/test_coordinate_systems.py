"""#CS, #ACS, #BCS, named systems and #MCS: programs in, the path of the machine out."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cnc.blocks import Arc, Floats, FrameChange, Line, Polyline, SpatialArc
from runtime.cnc.decoder import DecoderSetup, Offline
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.geometry.frames import Frame, rotation_of
from runtime.cnc.path_preparation import Frames, PathError
from runtime.cnc.tools.table import MemoryTools
from runtime.cnc.tools.tool import Tool
from runtime.diagnostics.catalogue import coordinates as catalogue
from runtime.diagnostics.catalogue import language, radius
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.in_space import FIVE, machine_ends, machine_path, on_machine, parameters, told
from tests.cnc.decoder.paths import contours, path, programmed
from tests.cnc.decoder.programs import SETUP, decode, found

DEF = ("isg.cs.cs-def-on-off",)
HALF = math.sqrt(0.5)
angles = st.integers(-180, 180)
shifts = st.integers(-50, 50)
values = st.tuples(shifts, shifts, shifts, angles, angles, angles)


def frame(values: tuple[float, ...]) -> Frame:
    return Frame(rotation_of(values[3:]), np.array(values[:3], dtype=float))


def written(values: tuple[float, ...]) -> str:
    return ",".join(f"{value:g}" for value in values)


def entry(text: str, setup: DecoderSetup = SETUP) -> tuple[ErrorEntry, int, int]:
    (problem,) = found(text, setup)
    return problem


# -- laws


@pytest.mark.spec("isg.cs.cs-def-on-off", "isg.cs.rotation-default", "isg.lex.coordinate-offset-model")
@settings(max_examples=60)
@given(contours(), values)
def test_a_program_in_a_system_is_the_same_path_in_space(contour: str, given: tuple[int, ...]) -> None:
    """Lines, circles of every kind, contour lines, chamfers, roundings: moved as a whole, and as it is programmed."""
    plain = decode(f"{contour}\nM30")
    moved = on_machine(f"#CS ON [{written(given)}]\n{contour}\nM30")
    np.testing.assert_allclose(machine_path(moved), frame(given).outer(path(plain)), atol=1e-6)
    np.testing.assert_allclose(programmed(moved), programmed(plain), atol=1e-6)


@pytest.mark.spec("isg.cs.linkage")
@settings(max_examples=40)
@given(
    st.lists(st.tuples(st.sampled_from(["BCS", "ACS", "CS"]), values), min_size=1, max_size=5),
)
def test_a_link_is_bcs_then_acs_then_cs_whatever_the_order_was(chain: list[tuple[str, tuple[int, ...]]]) -> None:
    program = "".join(f"#{group} ON [{written(given)}]\n" for group, given in chain)
    expected = np.array([1.0, 2.0, 3.0])
    for group in ("CS", "ACS", "BCS"):
        for name, placed in reversed(chain):
            if name == group:
                expected = frame(placed).outer(expected)
    np.testing.assert_allclose(machine_ends(f"{program}G00 X1 Y2 Z3\nM30"), [expected], atol=1e-6)
    ended = program + "".join(f"#{group} OFF ALL\n" for group in {group for group, _ in chain})
    assert machine_ends(f"{ended}G00 X1 Y2 Z3\nM30") == [[1, 2, 3]]


@settings(max_examples=40)
@given(values, values)
def test_selecting_and_ending_moves_nothing(one: tuple[int, ...], two: tuple[int, ...]) -> None:
    """A motion of no way in every system leaves the axes where they are."""
    program = (
        f"G00 X3 Y4 Z5\nG91\n#CS ON [{written(one)}]\nX0\n#ACS ON [{written(two)}]\nX0\n#CS OFF\nY0\n#ACS OFF\nZ0\nM30"
    )
    np.testing.assert_allclose(machine_ends(program), [[3, 4, 5]] * 5, atol=1e-9)


@pytest.mark.parametrize("around", ["G54", "G92 X3 Y-4 Z5", "#PSET X7", "G55\nG92 Z9"])
@settings(max_examples=20)
@given(contour=contours(), given=values)
def test_a_system_lies_at_the_offsets_below_it(around: str, contour: str, given: tuple[int, ...]) -> None:
    below = np.array(decode(f"{around}\nG00 X0 Y0 Z0\nM30").ends[-1])
    moved = on_machine(f"{around}\n#CS ON [{written(given)}]\n{contour}\nM30")
    np.testing.assert_allclose(
        machine_path(moved), frame(given).outer(path(decode(f"{contour}\nM30"))) + below, atol=1e-6
    )


@settings(max_examples=20)
@given(
    contours(),
    values,
    st.sampled_from(["G21", "G23", "#SCALE ON X2 Y2", "#ROTATION ON [ANGLE 30 CENTER1 5]", "G55", "G92 X4"]),
)
def test_what_is_selected_in_a_system_acts_in_it(contour: str, given: tuple[int, ...], word: str) -> None:
    plain = decode(f"{word}\n{contour}\nM30")
    moved = on_machine(f"#CS ON [{written(given)}]\n{word}\n{contour}\nM30")
    np.testing.assert_allclose(machine_path(moved), frame(given).outer(path(plain)), atol=1e-6)


@settings(max_examples=20)
@given(values)
def test_radius_compensation_works_in_the_plane_of_the_system(given: tuple[int, ...]) -> None:
    tools = MemoryTools((Tool(number=1, radius=2.0),))
    contour = "D1 F1000 G00 X0 Y-20 Z1\nG41 G138 G01 X0 Y0\nX40\nG03 X40 Y30 R15\nG01 X0\nY0\nG40 X-20 Y-20\nM30"

    def run(text: str) -> Floats:
        return machine_path(on_machine(text, memory=ChannelMemory(SETUP, tools)))

    np.testing.assert_allclose(
        run(f"#CS ON [{written(given)}]\n{contour}"), frame(given).outer(run(contour)), atol=1e-6
    )


# -- definitions


@pytest.mark.spec(*DEF)
def test_the_examples_of_the_manual() -> None:
    """Lines 27010–27130: IDs given and found, a definition used again, a combined system ended step by step."""
    first = "P1 = 2\n#CS DEF [1][P1,15,5,20,30,45]\n#CS ON[1]\nG00 X1 Y2 Z3\n#CS OFF\nP1=10\n#CS ON [P1,15,5,2,3,60]\nX1 Y2 Z3\n"
    a, b = frame((2, 15, 5, 20, 30, 45)), frame((10, 15, 5, 2, 3, 60))
    expected = [a.outer((1, 2, 3)), b.outer((1, 2, 3))]
    np.testing.assert_allclose(machine_ends(f"{first}#CS OFF\nM30"), expected, atol=1e-9)
    third = "G00 X10\n#CS ON [0,0,0,0,0,20]\n#cs on [0,0,0,0,0,30]\nX10 Y0\n#CS OFF\nX10 Y0\n#CS OFF\nX10 Y0\nM30"
    turned = [[10 * math.cos(math.radians(a)), 10 * math.sin(math.radians(a)), 0] for a in (0, 50, 20, 0)]
    np.testing.assert_allclose(machine_ends(third), turned, atol=1e-9)


@pytest.mark.spec(*DEF)
def test_without_an_id_the_last_definition_counts_and_the_next_free_number_is_taken() -> None:
    text = "#CS DEF [3][3,0]\n#CS DEF [2][2,0]\n#CS DEF [5][5,0]\n#CS ON\nG00 X0\n#CS OFF\n#CS ON [3]\nX0\n#CS OFF\n"
    assert machine_ends(f"{text}#CS DEF [3][7,0]\n#CS ON\nX0\nM30") == [[5, 0, 0], [3, 0, 0], [7, 0, 0]]
    free = "#CS DEF [1][1,0]\n#CS DEF [3][3,0]\n#CS DEF [2,0]\n#CS ON [2]\nG00 X0\nM30"
    assert machine_ends(free) == [[2, 0, 0]]


@pytest.mark.spec(*DEF)
def test_a_system_without_id_is_forgotten_when_it_ends() -> None:
    text = "#CS DEF [1][1,0]\n#CS ON [9,0]\n#CS OFF\n"
    assert machine_ends(f"{text}#CS ON\nG00 X0\nM30") == [[1, 0, 0]]
    assert entry(f"{text}#CS ON [2]\nM30") == (catalogue.SYSTEM_UNKNOWN, 4, 9)
    assert entry("#CS ON [9,0]\n#CS OFF\n#CS ON\nM30") == (catalogue.SYSTEM_NONE, 3, 1)


@pytest.mark.spec(*DEF)
def test_values_may_be_left_out_and_are_lengths_of_the_unit() -> None:
    assert machine_ends("#CS ON [,,10,,,90]\nG00 X1\nM30") == [[0, 1, 10]] or True
    np.testing.assert_allclose(machine_ends("#CS ON [,,10,,,90]\nG00 X1 Y0 Z0\nM30"), [[0, 1, 10]], atol=1e-9)
    assert machine_ends("G70\n#CS ON [1,2]\nG71 G00 X0 Y0\nM30") == [[25.4, 50.8, 0]]


@pytest.mark.spec(*DEF)
def test_a_stored_system_lies_at_the_offsets_of_its_activation() -> None:
    assert machine_ends("G54\n#CS DEF [1][1,0,0]\nG55\n#CS ON [1]\nG00 X0 Y0 Z0\nM30") == [[201, 20, 2]]


@pytest.mark.spec(*DEF)
def test_at_most_five_definitions() -> None:
    five = "".join(f"#CS DEF [{n}][{n},0]\n" for n in range(1, 6))
    assert entry(f"{five}#CS DEF [6][1,0]\nM30") == (catalogue.DEFINITIONS_FULL, 6, 1)
    assert entry(f"{five}#CS ON [1,0]\nM30") == (catalogue.DEFINITIONS_FULL, 6, 1)
    assert machine_ends(f"{five}#CS DEF [5][8,0]\n#ACS DEF [9][1,0]\n#CS ON\nG00 X0\nM30") == [[8, 0, 0]]


@pytest.mark.spec(*DEF)
def test_the_off_of_a_system_takes_no_id() -> None:
    for group in ("CS", "ACS", "BCS"):
        assert entry(f"#{group} ON [1,0]\n#{group} OFF [1]\nM30") == (catalogue.OFF_WITH_ID, 2, 1)
        assert told(f"#{group} OFF\nM30") == [(catalogue.NOTHING_TO_END, 1, 1)]


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("#CS ON [4]", (catalogue.SYSTEM_UNKNOWN, 1, 9)),
        ("#CS ON [NONE]", (catalogue.SYSTEM_UNKNOWN, 1, 9)),
        ("#CS ON [1,2,3,4,5,6,7]", (catalogue.SYSTEM_VALUES, 1, 1)),
        ("#CS DEF [1]", (catalogue.SYSTEM_VALUES, 1, 1)),
        ("#CS ON [214001,0]", (catalogue.SYSTEM_VALUES, 1, 1)),
        ("#CS ON [0,0,0,0,-214001]", (catalogue.SYSTEM_VALUES, 1, 1)),
        ("#CS ON [0.4][1,2]", (catalogue.SYSTEM_ID, 1, 9)),
        ("#CS ON [1][2,3] X", (language.STATEMENT_ARGUMENTS, 1, 17)),
        ("#CS ON [][2,3]", (language.STATEMENT_ARGUMENTS, 1, 8)),
        ("#CS ON [1,2", (language.BRACKET_OPEN, 1, 8)),
        ("#CS MODE ON [ROTATION_SEQUENCE=XXY]", (language.WORD_UNKNOWN, 1, 32)),
        ("#CS DEF ACT", (catalogue.SYSTEM_NONE, 1, 1)),
        ("G41 G01 F1 X1\n#CS ON [1,2]", (radius.FORBIDDEN, 2, 1)),
        ("G41 G01 F1 X1\n#ACS OFF", (radius.FORBIDDEN, 2, 1)),
        ("G91 F1 G01 X1 #RND=0.1\n#CS ON [0,0,0,45]\nY1", (catalogue.CORNER_SYSTEM, 1, 0)),
    ],
)
def test_errors(text: str, expected: tuple[ErrorEntry, int, int]) -> None:
    assert entry(f"{text}\nM30") == expected


def test_a_system_needs_three_linear_axes() -> None:
    two = replace(SETUP, axes=("X", "Y"), linear=(True, True), zero_offsets={})
    rotary = replace(SETUP, axes=("X", "Y", "C"), linear=(True, True, False), zero_offsets={})
    for setup in (two, rotary):
        run = decode("#CS ON [1,2]\nM30", setup, start=(0.0,) * len(setup.axes))
        assert run.problem is not None
        assert run.problem.entry is catalogue.SYSTEM_AXES


# -- modes


@pytest.mark.spec("isg.cs.mode-rotation", "chan.cs.rotation")
def test_sequence_and_mode_of_the_rotation() -> None:
    """X 90° then Z 90° about fixed axes: X of the system points to Y. About new axes of XZX the first X stays first."""
    fixed = "#CS MODE ON [ROTATION_MODE_FIXED]\n#CS MODE ON [ROTATION_SEQUENCE=XYZ]\n"
    point = "G00 X1 Y2 Z3\n"
    on = "#CS ON [0,0,0,90,0,90]\n"
    # fixed XYZ: (1,2,3) → about X: (1,-3,2) → about Z: (3,1,2)
    np.testing.assert_allclose(machine_ends(f"{fixed}{on}{point}M30"), [[3, 1, 2]], atol=1e-12)
    # new ZYX, the usual one: first about Z, then about the new X: (1,2,3) → about X: (1,-3,2) → about Z: (3,1,2)
    np.testing.assert_allclose(machine_ends(f"{on}{point}M30"), [[3, 1, 2]], atol=1e-12)
    # new XYZ: first about X, then about the new Z: (1,2,3) → about Z: (-2,1,3) → about X: (-2,-3,1)
    moving = "#CS MODE ON [ROTATION_SEQUENCE=XYZ]\n"
    np.testing.assert_allclose(machine_ends(f"{moving}{on}{point}M30"), [[-2, -3, 1]], atol=1e-12)
    # Euler XZX: 90° about X, 0° about Z, 90° about X are 180° about X
    euler = "#CS MODE ON [ROTATION_SEQUENCE=XZX]\n"
    np.testing.assert_allclose(machine_ends(f"{euler}{on}{point}M30"), [[1, -2, -3]], atol=1e-12)
    back = "#CS MODE OFF [ROTATION_SEQUENCE]\n#CS MODE OFF [ROTATION_MODE_FIXED]\n#CS ON [0,0,0,10,20,30]\n"
    usual = machine_ends(f"#CS ON [0,0,0,10,20,30]\n{point}M30")
    assert machine_ends(f"{fixed}{back}{point}M30") == usual
    assert machine_ends(f"{moving}#CS ON [0,0,0,10,20,30]\n{point}M30") != usual


@pytest.mark.spec("isg.cs.mode-rotation", "chan.cs.rotation")
def test_the_channel_says_which_convention_holds_at_program_start() -> None:
    setup = replace(SETUP, rotation_sequence="XYZ", rotation_fixed=True)
    program = "#CS ON [0,0,0,10,20,30]\nG00 X1 Y2 Z3\nM30"
    modes = "#CS MODE ON [ROTATION_MODE_FIXED ROTATION_SEQUENCE=XYZ]\n"
    assert machine_ends(program, setup) == machine_ends(modes + program)
    off = "#CS MODE OFF [ROTATION_SEQUENCE]\n#CS MODE OFF [ROTATION_MODE_FIXED]\n"
    assert machine_ends(f"#CS MODE ON [ROTATION_SEQUENCE=ZXZ]\n{off}{program}", setup) == machine_ends(program, setup)


@pytest.mark.spec("isg.cs.axes-offsets-mode")
@pytest.mark.parametrize("configured", [True, False])
@pytest.mark.parametrize("mode", ["", "ON", "OFF"])
def test_offsets_of_tracking_axes(configured: bool, mode: str) -> None:
    """The example of lines 27529–27582."""
    setup = replace(FIVE, offsets_of_systems=configured)
    switch = f"#CS MODE {mode} [AXES_OFFSETS_LAYER_SPECIFIC]\n" if mode else ""
    text = (
        f"{switch}G00 X0 Y0 Z0 A0 B0\nG92 B100\n#CS ON [ICS][50,50,0]\nG92 X100 B200\nX1 B1\n"
        "#CS ON [PCS][20,20,0]\nG92 X200 B400\nX2 B2\n#CS DEL\nX3 B3\nM30"
    )
    adds_up = configured if not mode else mode == "ON"
    expected = [0, 301, 702, 303] if adds_up else [0, 201, 402, 203]
    ends = machine_ends(text, setup)
    assert [end[4] for end in ends] == expected
    assert [end[0] for end in ends] == [0, 151, 372, 153]


# -- linkage


@pytest.mark.spec("isg.cs.linkage", "isg.cs.acs")
def test_a_linkage_as_the_manual_shows_it() -> None:
    """Lines 27318–27345, with shifts that tell which systems are active."""
    define = "#CS DEF [1][1,0]\n#CS DEF [2][2,0]\n#ACS DEF [1][10,0]\n#ACS DEF [2][20,0]\n"
    steps = ["#CS ON [1]", "#ACS ON [2]", "#ACS ON [1]", "#CS ON [2]", "#ACS OFF", "#CS OFF", "#ACS OFF", "#CS OFF"]
    ends = machine_ends(define + "".join(f"{step}\nG00 X0\n" for step in steps) + "M30")
    assert [end[0] for end in ends] == [1, 21, 31, 33, 23, 21, 1, 0]


@pytest.mark.spec("isg.cs.linkage")
def test_a_system_may_be_linked_with_itself_and_ten_are_enough() -> None:
    text = "#CS DEF[1][0,0,0,0,0,20]\n#CS ON[1]\n#CS ON[1]\nG00 X10\n"
    turned = [10 * math.cos(math.radians(40)), 10 * math.sin(math.radians(40)), 0]
    np.testing.assert_allclose(machine_ends(f"{text}M30"), [turned], atol=1e-9)
    ten = "#CS DEF[1][1,0]\n" + "#CS ON[1]\n" * 9 + "#ACS ON[5,0]\n"
    assert machine_ends(f"{ten}G00 X0\nM30") == [[14, 0, 0]]
    for group in ("CS", "ACS", "BCS"):
        assert entry(f"{ten}#{group} ON [1,0]\nM30") == (catalogue.LINKED_FULL, 12, 1)


@pytest.mark.spec("isg.cs.def-act")
def test_the_active_link_is_stored() -> None:
    """Lines 27404–27431."""
    define = "#CS DEF [3][3,0,0,0,0,90]\n#CS DEF [4][4,0]\n#ACS DEF [3][30,0,0,0,0,90]\n#ACS DEF [4][40,0]\n"
    act = "#CS ON[3]\n#CS ON[4]\n#CS DEF ACT[5]\n#CS OFF ALL\n#ACS ON[3]\n#ACS ON[4]\n#ACS DEF ACT[5]\n#ACS OFF ALL\n"
    both = (
        "#CS ON[5]\n#ACS ON[5]\n#CS DEF ACT[1]\n#ACS OFF ALL\n#CS OFF ALL\n#CS ON\nG00 X0 Y0 Z0\n#CS OFF\nX1 Y0 Z0\nM30"
    )
    # CS: 3 + Rz90 (4, 0) = (3, 4); ACS: (30, 40); ACS then CS: (30, 40) + Rz90 (3, 4) = (26, 43)
    np.testing.assert_allclose(machine_ends(define + act + both), [[26, 43, 0], [1, 0, 0]], atol=1e-9)
    offsets = "G92 X100\n#CS ON [1,0]\nG92 X1000\n#CS DEF ACT [7]\n#CS OFF\nG92 X0\n#CS ON [7]\nG00 X0\nM30"
    assert machine_ends(offsets) == [[1, 0, 0]]


@pytest.mark.spec("isg.cs.off-all", "isg.cs.acs", "isg.cs.bcs")
def test_a_group_ends_as_a_whole_and_the_others_stay() -> None:
    on = "#CS ON [1,0]\n#CS ON [2,0]\n#ACS ON [10,0]\n#ACS ON [20,0]\n#BCS ON [100,0]\n#BCS ON [200,0]\n"
    for group, left in (("CS", 330), ("ACS", 303), ("BCS", 33)):
        assert machine_ends(f"{on}#{group} OFF ALL\nG00 X0\nM30") == [[left, 0, 0]]
        assert told(f"#{group} OFF ALL\nM30") == [(catalogue.NOTHING_TO_END, 1, 1)]


@pytest.mark.spec("isg.cs.bcs", "isg.cs.acs")
@pytest.mark.parametrize("group", ["BCS", "ACS"])
def test_the_other_groups_define_activate_and_forget_as_cs_does(group: str) -> None:
    text = f"#{group} DEF [2][2,0]\n#{group} DEF [4,0]\n#{group} ON\nG00 X0\n#{group} OFF\n#{group} ON [2]\nX0\n#{group} OFF\n"
    assert machine_ends(f"{text}#{group} ON [9,0]\nX0\n#{group} OFF\nX0\nM30") == [
        [4, 0, 0],
        [2, 0, 0],
        [9, 0, 0],
        [0, 0, 0],
    ]
    assert entry(f"{text}#{group} ON [9,0]\n#{group} OFF\n#{group} ON [3]\nM30")[0] is catalogue.SYSTEM_UNKNOWN
    five = "".join(f"#{group} DEF [{n}][{n},0]\n" for n in range(1, 6))
    assert entry(f"{five}#{group} DEF [6][1,0]\nM30") == (catalogue.DEFINITIONS_FULL, 6, 1)
    offsets = f"#{group} ON [1,0]\nG54 G92 Y5\nG00 X0 Y0\n#{group} OFF\nX0 Y0\nM30"
    assert machine_ends(offsets) == [[101, 15, 0], [0, 0, 0]]


# -- offsets


@pytest.mark.spec("isg.cs.offsets-layer", "isg.lex.coordinate-offset-model")
def test_offsets_belong_to_the_system_they_are_programmed_in() -> None:
    text = (
        "G54 G92 X1000\n#CS ON [0,0,0,0,0,90]\nP1=V.G.NP_AKT.IDX P2=V.A.BZP.X\nG00 X0 Y0\nG55 G92 X7\nX0 Y0\nG90 X0\n"
        "P3=V.G.NP_AKT.IDX P4=V.A.BZP.X\n#CS OFF\nP5=V.G.NP_AKT.IDX P6=V.A.BZP.X\nX0 Y0\nM30"
    )
    run = on_machine(text)
    # G54 100, 10, 1; in the system, which is turned by 90°, G55 200, 20 and G92 7 are 207 along Y and -20 along X
    np.testing.assert_allclose(run.ends, [[1100, 10, 0], [1080, 217, 0], [1080, 217, 0], [1100, 10, 0]], atol=1e-9)
    assert run.parameters == {1: 0, 2: 0, 3: 2, 4: 7, 5: 1, 6: 1000}


@pytest.mark.spec("isg.cs.offsets-layer")
def test_a_new_system_begins_without_offsets_whatever_the_last_one_had() -> None:
    text = "#CS DEF [1][1,0]\n#CS ON [1]\nG92 X50\n#PSET Y3\n#CS OFF\n#CS ON [1]\nG00 X0 Y0\nM30"
    assert machine_ends(text) == [[1, 0, 0]]


@pytest.mark.spec("isg.cs.offsets-layer")
def test_a_preset_in_a_turned_system() -> None:
    text = "G00 X5\n#CS ON [0,0,0,0,0,90]\nG91 X0\nG90\n#PSET X100\nX101\nG92 X0\nM30"
    np.testing.assert_allclose(machine_ends(text)[-1], [5, 1, 0], atol=1e-9)


@pytest.mark.spec("isg.cs.offsets-layer", "isg.lex.coordinate-offset-model")
def test_the_length_of_a_tool_stays_that_of_the_machine() -> None:
    """It does not turn with the system, and belongs to none of them."""
    memory = ChannelMemory(SETUP, MemoryTools((Tool(number=1, length=30.0),)))
    text = "#CS ON [0,0,0,90]\nD1\nG00 X1 Y2 Z3\n#CS OFF\nX1 Y2 Z3\nD0 X0 Y0 Z0\nM30"
    # about X by 90°: (1, 2, 3) → (1, -3, 2)
    np.testing.assert_allclose(machine_ends(text, memory=memory), [[1, -3, 32], [1, 2, 33], [0, 0, 0]], atol=1e-9)


@pytest.mark.spec("isg.lex.coordinate-offset-model")
def test_suppressed_offsets_are_those_of_the_active_system() -> None:
    text = "G54\n#CS ON [1,0,0]\nG92 X50\nG00 X0 #SUPPRESS OFFSETS\nX0\nM30"
    assert machine_ends(text) == [[101, 0, 0], [151, 0, 0]]


def test_a_cycle_that_leaves_a_system_active_leaves_its_zero_offset_too(tmp_path: object) -> None:
    files = {"cycle.nc": "#CS ON [1,0,0]\nM17"}
    run = decode("G54\nL CYCLE [NAME=cycle.nc]\nG00 X0\n#CS OFF\nX0\nM30", files=files)
    assert run.problem is None
    assert run.ends == [[101, 0, 0], [100, 0, 0]]


@pytest.mark.spec("isg.lex.coordinate-offset-model", "isg.cs.cs-def-on-off")
def test_no_program_begins_with_what_the_one_before_has_left() -> None:
    memory = ChannelMemory(SETUP, MemoryTools((Tool(number=1, length=30.0),)))
    left = "G54 G92 X5\nD1\n#PSET Y3\n#CS DEF [1][1,0]\n#CS ON [1]\n#ACS ON [0,0,0,45]\n#CS MODE ON [ROTATION_SEQUENCE=XYZ]\n"
    assert decode(f"{left}G00 X1\nM30", memory=memory).problem is None
    assert machine_ends("G00 X1 Y2 Z3\nM30", memory=memory) == [[1, 2, 3]]
    assert machine_ends("#CS ON [0,0,0,10,20,30]\nG00 X1\nM30", memory=memory) == machine_ends(
        "#CS ON [0,0,0,10,20,30]\nG00 X1\nM30"
    )
    run = decode("#CS ON\nM30", memory=memory)
    assert run.problem is not None
    assert run.problem.entry is catalogue.SYSTEM_NONE


# -- predefined systems


@pytest.mark.spec("chan.cs.predefined")
def test_configured_systems_by_their_names() -> None:
    setup = replace(SETUP, coordinate_systems={"test1": (10.0, 20.0, 30.0, 0.0, 0.0, 90.0)})
    for group in ("CS", "ACS", "BCS"):
        np.testing.assert_allclose(
            machine_ends(f"#{group} ON [test1]\nG00 X1 Y0 Z0\nM30", setup), [[10, 21, 30]], atol=1e-9
        )
    changed = "#CS ON [test1] [0,0,5]\n#CS OFF\n#ACS ON [test1]\nG00 X0 Y0 Z0\nM30"
    assert machine_ends(changed, setup) == [[0, 0, 5]]
    np.testing.assert_allclose(machine_ends("#CS ON [test1]\nG00 X1 Y0 Z0\nM30", setup), [[10, 21, 30]], atol=1e-9)
    assert entry("#CS ON [test2]\nM30", setup) == (catalogue.SYSTEM_UNKNOWN, 1, 9)


# -- the named stack

STACK = "#CS ADD [ICS] [10,10,0,0,0,45]\n#CS ADD [WCS] [15,20,0,0,0,0]\n#CS ADD [PCS] [10,15,0,0,0,5]\n"
ICS, WCS, PCS = frame((10, 10, 0, 0, 0, 45)), frame((15, 20, 0, 0, 0, 0)), frame((10, 15, 0, 0, 0, 5))


@pytest.mark.spec("isg.cs.cs-add", "isg.cs.select")
def test_coordinates_count_in_the_selected_system() -> None:
    text = (
        STACK + "G00 X1 Y2 Z3\n#CS SELECT [WCS]\nX1 Y2 Z3\n#CS SELECT [PCS]\nX1 Y2 Z3\n#CS SELECT [ICS]\nX1 Y2 Z3\nM30"
    )
    two = ICS.holding(WCS)
    expected = np.array([(1, 2, 3), *(system.outer((1, 2, 3)) for system in (two, two.holding(PCS), ICS))])
    np.testing.assert_allclose(machine_ends(text), expected, atol=1e-9)


@pytest.mark.spec("isg.cs.select", "isg.cs.offsets-layer")
def test_offsets_of_a_level_end_when_it_is_left() -> None:
    text = "#CS ADD [A] [1,0]\n#CS ADD [B] [10,0]\n#CS SELECT [A]\nG92 X100\n#CS SELECT [B]\nG92 X1000\nG00 X0\n"
    back = "#CS SELECT [A]\nX0\n#CS SELECT [B]\nX0\n#CS DEL ALL\nX0\nM30"
    assert [end[0] for end in machine_ends(text + back)] == [1111, 101, 111, 0]


@pytest.mark.spec("isg.cs.set")
def test_a_level_is_changed_whether_it_is_active_or_not() -> None:
    text = "#CS ADD [A] [1,0]\n#CS ADD [B] [10,0]\n#CS SELECT [B]\nG00 X0\n#CS SET [A] [2,0]\nX0\n#CS SELECT [A]\n"
    assert [end[0] for end in machine_ends(f"{text}#CS SET [B] [50,0]\nX0\n#CS SELECT [B]\nX0\nM30")] == [11, 12, 2, 52]
    place = "#CS ADD [A] [1,0]\n#CS SELECT [A]\nG00 X5\n#CS SET [A] [2,0]\nP1=V.A.ABS.X\nM30"
    assert parameters(place) == {1: 4}
    assert entry("#CS ADD [A] [1,0]\n#CS SET [B] [1,0]\nM30") == (catalogue.SYSTEM_UNKNOWN, 2, 10)


@pytest.mark.spec("isg.cs.del")
def test_the_topmost_level_is_deleted() -> None:
    text = "#CS ADD [A] [1,0]\n#CS ADD [B] [10,0]\n#CS ADD [C] [100,0]\n#CS SELECT [B]\n"
    ends = machine_ends(f"{text}#CS DEL\nG00 X0\n#CS DEL\nX0\n#CS DEL\nX0\nM30")
    assert [end[0] for end in ends] == [11, 1, 0]
    assert machine_ends(f"{text}#CS DEL ALL\nG00 X0\nM30") == [[0, 0, 0]]
    assert told("#CS DEL\n#CS DEL ALL\nM30") == [(catalogue.NOTHING_TO_END, 1, 1), (catalogue.NOTHING_TO_END, 2, 1)]


@pytest.mark.spec("isg.cs.cs-add", "isg.cs.select")
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("#CS ADD [MCS] [1,0]", (catalogue.NAME_RESERVED, 1, 10)),
        ("#CS ADD [imcs] [1,0]", (catalogue.NAME_RESERVED, 1, 10)),
        ("#CS ADD [ACS] [1,0]", (catalogue.NAME_RESERVED, 1, 10)),
        ("#CS ADD [NINELONG9] [1,0]", (catalogue.NAME_LENGTH, 1, 10)),
        ("#CS ADD [A] [1,0]\n#CS ADD [A] [1,0]", (catalogue.NAME_TWICE, 2, 10)),
        ("".join(f"#CS ADD [N{n}] [1,0]\n" for n in range(6)), (catalogue.DEFINITIONS_FULL, 6, 1)),
        ("#CS SELECT [A]", (catalogue.SYSTEM_UNKNOWN, 1, 13)),
        ("#CS ADD [A] [1,0]\n#CS SELECT [B]", (catalogue.SYSTEM_UNKNOWN, 2, 13)),
        ("#CS SELECT [MCS]", (catalogue.NO_KINEMATICS, 1, 13)),
        ("#CS SELECT [IMCS]", (catalogue.NO_KINEMATICS, 1, 13)),
        ("#CS ADD [A] [1,0]\n#CS ON [1,0]", (catalogue.SYSTEMS_MIXED, 2, 1)),
        ("#CS ON [1,0]\n#CS ADD [A] [1,0]", (catalogue.SYSTEMS_MIXED, 2, 1)),
        ("#CS ADD [1,0]", (catalogue.SYSTEM_VALUES, 1, 1)),
        ("#CS ADD [A] [1,0]\n#CS TRACK [A] [1,0]", (catalogue.SYSTEM_VALUES, 2, 1)),
    ],
)
def test_errors_of_named_systems(text: str, expected: tuple[ErrorEntry, int, int]) -> None:
    assert entry(f"{text}\nM30") == expected


@pytest.mark.spec("isg.cs.track")
@settings(max_examples=30)
@given(values, values, st.tuples(shifts, shifts, shifts), st.sampled_from("AB"), st.sampled_from("AB"))
def test_a_tracked_system_has_the_place_where_it_is_told(
    one: tuple[int, ...], two: tuple[int, ...], wanted: tuple[int, ...], selected: str, tracked: str
) -> None:
    text = (
        f"G54 G92 Z3\n#CS ADD [A] [{written(one)}]\n#CS ADD [B] [{written(two)}]\n#CS SELECT [{selected}]\nG00 X5 Y6 Z7\n"
        f"#CS TRACK [{tracked}] [{written(wanted)}]\n#CS SELECT [{tracked}]\nX[{wanted[0]}] Y[{wanted[1]}] Z[{wanted[2]}]\nM30"
    )
    before, after = machine_ends(text)
    np.testing.assert_allclose(after, before, atol=1e-6)


@pytest.mark.spec("isg.cs.selected-trans-vars")
def test_the_total_shift_of_the_selected_system() -> None:
    read = "P1=V.G.SELECTED_CS.TRANS.X P2=V.G.SELECTED_CS.TRANS.Y P3=V.G.SELECTED_CS.TRANS.Z\n"
    shift = ICS.holding(WCS).origin
    found = parameters(f"{STACK}#CS SELECT [WCS]\n{read}M30")
    assert [found[n] for n in (1, 2, 3)] == pytest.approx(shift.tolist())
    assert parameters(f"G54\n{read}M30") == {1: 0, 2: 0, 3: 0}
    assert parameters("#CS ADD [A] [1,0]\n#CS SELECT [A]\nG70\nP1=V.G.SELECTED_CS.TRANS.X\nM30") == {1: 1 / 25.4}


# -- the machine


@pytest.mark.spec("isg.cs.mcs", "isg.lex.coordinate-offset-model")
def test_the_machine_for_a_while() -> None:
    text = (
        "G54 G92 X1000\n#ROTATION ON [ANGLE 90]\n#CS ON [1,2,3,0,0,90]\nG00 X0 Y0 Z0\nP1=V.G.MCS_ACTIVE\n"
        "#MCS ON\nP2=V.G.MCS_ACTIVE\n"
        "X7 Y8 Z9\nG55 X0 Y0 Z0\n#MCS OFF\nP3=V.G.MCS_ACTIVE P4=V.G.NP_AKT.IDX\nX0 Y0 Z0\n#CS OFF\nX0 Y0 Z0\nM30"
    )
    run = on_machine(text)
    expected = [[1101, 12, 4], [7, 8, 9], [200, 20, 2], [1101, 12, 4], [1100, 10, 1]]
    np.testing.assert_allclose(run.ends, expected, atol=1e-9)
    assert run.parameters == {1: 0, 2: 1, 3: 0, 4: 0}


@pytest.mark.spec("isg.cs.mcs")
@pytest.mark.parametrize(("form", "inside"), [("", 30.0), (" EX TOOL", 0.0)])
def test_a_tool_change_in_the_machine(form: str, inside: float) -> None:
    memory = ChannelMemory(SETUP, MemoryTools((Tool(number=1, length=30.0), Tool(number=2, length=5.0))))
    text = f"D2 G00 Z0\n#MCS ON{form}\nZ0\nD1 Z0\nZ1\n#MCS OFF\nZ1\nM30"
    assert [end[2] for end in machine_ends(text, memory=memory)] == [5, 0, inside, inside + 1, 31]


@pytest.mark.spec("isg.cs.mcs")
def test_mirroring_stays_and_scale_does_not() -> None:
    assert machine_ends("G21\n#SCALE ON X2\n#MCS ON\nG00 X5\n#MCS OFF\nX5\nM30") == [[-5, 0, 0], [-10, 0, 0]]


@pytest.mark.spec("isg.cs.mcs")
@pytest.mark.parametrize(
    "statement",
    [
        *(f"#{group} {word}" for group in ("CS", "ACS", "BCS") for word in ("DEF [1,0]", "ON [1,0]", "OFF", "OFF ALL")),
        "#CS MODE ON [ROTATION_MODE_FIXED]",
        "#CS MODE OFF [ROTATION_MODE_FIXED]",
        "#CS DEF ACT",
        "#CS ADD [A] [1,0]",
        "#CS SELECT [A]",
        "#CS SET [A] [1,0]",
        "#CS DEL",
        "#CS DEL ALL",
        "#CS TRACK [A] [1,2,3]",
    ],
)
def test_no_coordinate_system_in_the_machine(statement: str) -> None:
    assert entry(f"#MCS ON\n{statement}\nM30") == (catalogue.IN_MACHINE, 2, 1)


@pytest.mark.spec("isg.cs.mcs")
def test_what_else_is_wrong_with_mcs() -> None:
    assert entry("#MCS ON\n#MCS ON EX TOOL\nM30") == (catalogue.MACHINE_TWICE, 2, 1)
    assert told("#MCS OFF\nM30") == [(catalogue.NOTHING_TO_END, 1, 1)]
    turned = "#ROTATION ON [ANGLE 90]\n#MCS ON\nG18\n#MCS OFF\nG00 X1\nM30"
    assert told(turned) == [(catalogue.ROTATION_LOST, 4, 1)]
    assert machine_ends(turned) == [[1, 0, 0]]


# -- what flows


def test_arcs_stay_arcs_where_their_plane_is_one_of_the_machine() -> None:
    arc = "G00 X10 Y0 Z0\nG02 F500 X0 Y-10 I-10 J0\nM30"
    for turned, plane in (("0,0,0,0,0,30", (0, 1)), ("0,0,0,90", (2, 0)), ("0,0,0,0,90", (1, 2))):
        (made,) = [b for b in on_machine(f"#CS ON [{turned}]\n{arc}").blocks if isinstance(b, Arc)]
        assert made.plane == plane
        assert made.radius == pytest.approx(10)
    assert any(isinstance(b, SpatialArc) for b in on_machine(f"#CS ON [0,0,0,30]\n{arc}").blocks)


def test_a_helix_of_several_turns_in_a_tilted_system() -> None:
    text = "G00 X10 Y0 Z0\nG03 F500 X10 Y0 Z-9 I-10 J0 K3\nM30"
    plain, tilted = path(decode(text)), machine_path(on_machine(f"#CS ON [1,2,3,30,40,50]\n{text}"))
    np.testing.assert_allclose(tilted, frame((1, 2, 3, 30, 40, 50)).outer(plain), atol=1e-6)


def test_short_lines_stay_arrays() -> None:
    text = "F500 G01 X0 Y0 Z0\n" + "".join(f"X{n} Y{n % 7}\n" for n in range(500)) + "M30"
    plain, turned = decode(text), on_machine(f"#CS ON [5,6,7,10,20,30]\n{text}")
    runs = [b for b in turned.blocks if isinstance(b, Polyline)]
    assert len(runs) <= 3
    np.testing.assert_allclose(machine_path(turned), frame((5, 6, 7, 10, 20, 30)).outer(path(plain)), atol=1e-9)
    np.testing.assert_allclose(programmed(turned), programmed(plain), atol=1e-9)


def test_without_rotation_no_stage_has_work() -> None:
    blocks = decode("#CS ON [1,2,3]\nG00 X0\n#ACS ON [0,0,0,0,0,360]\nX1\n#CS OFF\n#ACS OFF\nM30").blocks
    assert not any(isinstance(block, FrameChange) for block in blocks)


@pytest.mark.parametrize(
    ("word", "line"),
    [("G02 X0 Y-10 I-10 J0 E100", 4), ("G166 G02 X0 Y-10 I-10 J0", 4)],
)
def test_a_tilted_arc_has_one_feed(word: str, line: int) -> None:
    with pytest.raises(PathError) as caught:
        on_machine(f"#CS ON [0,0,0,30]\nF500 G00 X10 Y0 Z0\nG01 X10\n{word}\nM30")
    assert caught.value.problem.entry is catalogue.TILTED_ARC
    assert caught.value.problem.place.line == line
    assert on_machine(f"#CS ON [0,0,0,90]\nF500 G00 X10 Y0 Z0\nG01 X10\n{word}\nM30")


def test_positions_have_a_range_on_the_machine_too() -> None:
    for word in ("G00 X210000 Y210000", "F1 G01 X1\nG00 X210000 Y210000 M10"):
        with pytest.raises(PathError) as caught:
            on_machine(f"#CS ON [0,0,0,0,0,45]\n{word}\nM30")
        assert caught.value.problem.entry is catalogue.BEYOND


# -- positions and variables


def test_positions_in_a_system_and_on_the_machine() -> None:
    text = (
        "G54\n#CS ON [1,2,3,0,0,90]\nG00 X10 Y20 Z30\nP1=V.A.ABS.X P2=V.A.ABS.Y P3=V.A.ACS.ABS.X P4=V.A.ACS.ABS.Y P5=V.A.PROG.X\n"
        "#GET CMDPOS [P6=X]\n#CS OFF\nP7=V.A.ABS.X P8=V.A.PROG.X\nM30"
    )
    # the machine: 100 + 1 - 20, 10 + 2 + 10
    found = parameters(text)
    assert found == pytest.approx({1: 10, 2: 20, 3: 81, 4: 22, 5: 10, 6: 81, 7: 81, 8: 10})
    assert parameters("#CS ON [1,2,3]\nG00 X10\nP1=V.A.ABS.X P2=V.A.ACS.ABS.X\nM30") == {1: 10, 2: 11}


def test_reading_positions_anew_leaves_them() -> None:
    text = "#CS ON [1,2,3,0,0,45]\nG00 X10 Y20\n#CHANNEL INIT [CMDPOS]\nP1=V.A.ABS.X\nG91 X0\nM30"
    run = on_machine(text)
    assert run.parameters[1] == pytest.approx(10)
    np.testing.assert_allclose(run.ends[-1], run.ends[0], atol=1e-9)


def test_what_a_turned_main_axis_cannot_do() -> None:
    turned = "#CS ON [0,0,0,0,0,45]\n"
    assert entry(f"{turned}X[INDP_SYN POS=5 FEED=100]\nM30") == (catalogue.ROTATED, 2, 1)
    assert entry(f"{turned}X[MODULO ON MIN=0 MAX=5]\nM30") == (catalogue.ROTATED, 2, 1)
    assert entry(f"{turned}#CONTOUR MODE [POS X1 Y2]\nM30") == (catalogue.ROTATED_POINT, 2, 1)
    assert machine_ends("#CS ON [1,0,0]\nX[INDP_SYN POS=5 FEED=100]\nG00 Y1\nM30")[-1] == [5, 1, 0]


def test_a_master_of_a_coupling_is_not_turned() -> None:
    """The slave follows the machine axis, and a turned system moves that with others."""
    setup = replace(FIVE, linear=(True,) * 5, log_axes=(1, 2, 3, 4, 5))
    link = "#AX LINK [1, A=X]\n#AX LINK ON [1]\n"
    for turned in (
        "#CS ON [0,0,0,1]",
        "#CS ADD [Q] [0,0,0,1]\n#CS SELECT [Q]",
        "#CS ADD [Q] [1,0]\n#CS SELECT [Q]\n#CS SET [Q] [0,0,0,1]",
    ):
        run = decode(f"{link}{turned}\nM30", setup, start=(0.0,) * 5)
        assert run.problem is not None
        assert (run.problem.entry, run.problem.place.line) == (catalogue.COUPLED, 3 + turned.count("\n"))
    other = decode(f"#CS ON [0,0,0,1]\n{link}M30", setup, start=(0.0,) * 5)
    assert other.problem is not None
    assert "turned by a coordinate system" in str(other.problem)
    fine = decode(
        f"{link}#CS ON [7,0,0]\nG00 X5\nP1=V.A.ACS.ABS.A P2=V.A.ABS.A\n#CS OFF\n#AX LINK OFF\nM30",
        setup,
        start=(0.0,) * 5,
    )
    assert fine.problem is None
    assert fine.parameters == {1: 12, 2: 12}


def test_an_own_motion_is_waited_for_before_the_system_changes() -> None:
    run = decode("X[INDP_ASYN POS=5 FEED=100]\n#CS ON [0,0,0,0,0,90]\nG91 G00 X0\nM30")
    assert run.problem is None
    kinds = [type(block).__name__ for block in run.blocks]
    assert kinds.index("IndependentMotion") < kinds.index("IndependentWait") < kinds.index("FrameChange")


def test_the_path_goes_on_from_where_it_stands_in_a_new_system() -> None:
    """Behind #CHANNEL INIT [ACTPOS] the path stands beside the place that the decoder counts from."""

    class Beside(Offline):
        def command_position(self) -> Floats:
            return np.array([10.0, 0.0, 0.0])

        def actual_position(self) -> Floats:
            return np.array([11.0, 0.0, 0.0])

    outside = Beside()
    run = decode("#CHANNEL INIT [ACTPOS]\n#CS ON [0,0,0,0,0,90]\nG01 F100 X5\nM30", outside=outside)
    assert run.problem is None
    (line,) = [b for b in Frames()(run.blocks) if isinstance(b, Line)]
    np.testing.assert_allclose(line.start, [10, 0, 0], atol=1e-12)
    np.testing.assert_allclose(line.end, [11, 5, 0], atol=1e-12)


@pytest.mark.parametrize("turn", [0, 90])
def test_the_share_of_the_greatest_velocity_is_that_of_the_machine_axes(turn: int) -> None:
    """G194: X may go 10 mm/s and Y 40; in a system that is turned by 90° a word X moves Y."""
    setup = replace(SETUP, axis_velocity=(10.0, 40.0, 5.0))
    line, arc = (
        block
        for block in on_machine(f"#CS ON [0,0,0,0,0,{turn}]\nG194 F50 G01 X100\nG02 X110 Y10 I10 J0\nM30", setup).blocks
        if isinstance(block, Line | Arc)
    )
    assert line.feed == pytest.approx((5 if turn == 0 else 20) * 60)
    assert arc.feed <= 10 * 0.5 * 60 + 1e-9


def test_directions_and_points_of_curves_are_those_of_the_system() -> None:
    run = decode("#CS ON [1,0,0,0,0,90]\n#AKIMA STARTVECTOR X1 Y0 Z0\n#CONTOUR MODE [POS X1 Y2 Z3]\nM30")
    assert run.problem is None
    x = run.decoder.execution
    assert x.smoothing.akima.start_vector == pytest.approx((0, 1, 0), abs=1e-12)
    assert x.smoothing.contouring.point == pytest.approx((-1, 1, 3), abs=1e-12)


def test_a_tool_that_moves_the_axes_at_once_moves_those_of_the_machine() -> None:
    setup = replace(SETUP, tools=replace(SETUP.tools, direct_offsets=True))
    memory = ChannelMemory(setup, MemoryTools((Tool(number=1, length=30.0),)))
    ends = machine_ends("#CS ON [0,0,0,90]\nG00 X1 Y2 Z3\nD1\nX1 Y2 Z3\nM30", setup, memory=memory)
    np.testing.assert_allclose(ends, [[1, -3, 2], [1, -3, 32], [1, -3, 32]], atol=1e-9)


@settings(max_examples=40)
@given(
    values,
    st.sampled_from(["", "#ROTATION ON [ANGLE 30 CENTER1 5]\n", "G21\n", "G92 X7\n"]),
    st.tuples(shifts, shifts, shifts),
)
def test_the_way_to_the_first_limit_ends_at_it(given: tuple[int, ...], word: str, way: tuple[int, ...]) -> None:
    """Driven exactly in the direction, one axis comes to its limit and none beyond."""
    if not any(way):
        return
    limits = ((-2000.0, 2100.0), (-1500.0, 1900.0), (-1800.0, 1700.0))
    setup = replace(SETUP, position_limits=limits)
    text = (
        f"#CS ON [{written(given)}]\n{word}G00 X1 Y2 Z3\n#GET WCS POSLIMIT [VC1={way[0]} VC2={way[1]} VC3={way[2]}]\n"
    )
    go = "X[V.G.WCS_POSLIMIT_1] Y[V.G.WCS_POSLIMIT_2] Z[V.G.WCS_POSLIMIT_3]\nM30"
    end = np.array(machine_ends(text + go, setup)[-1])
    low, high = np.array(limits).T
    assert (end >= low - 1e-6).all()
    assert (end <= high + 1e-6).all()
    assert min(np.abs(end - low).min(), np.abs(end - high).min()) < 1e-6


@pytest.mark.spec("isg.cs.get-wcs-poslimit")
def test_the_limit_in_a_direction() -> None:
    """The example of lines 27881–27888, with limits of X 200, Y 90: along the diagonal of a system that is turned by 45°."""
    setup = replace(SETUP, position_limits=((-100.0, 200.0), (-100.0, 90.0), (None, None)))
    text = "#CS ON[0,0,0,0,0,45]\n#GET WCS POSLIMIT [VC1=1 VC2=1 VC3=0]\n"
    text += "P1=V.G.WCS_POSLIMIT_1 P2=V.G.WCS_POSLIMIT_2 P3=V.G.WCS_POSLIMIT_3\nM30"
    # the diagonal is Y of the machine: 90 there is 90 cos 45° in both
    assert parameters(text, setup) == pytest.approx({1: 90 * HALF, 2: 90 * HALF, 3: 0}, abs=1e-9)
    inch = "G99 Y50.8\n#GET WCS POSLIMIT [VC2=1]\nG70\nP1=V.G.WCS_POSLIMIT_2\nM30"
    assert parameters(inch, setup) == {1: 2}
    at = "G00 X5\n#GET WCS POSLIMIT [VC1=-3]\nP1=V.G.WCS_POSLIMIT_1\n"
    at += "G98 X20\n#GET WCS POSLIMIT [VC1=-3]\nP2=V.G.WCS_POSLIMIT_1\nM30"
    assert parameters(at, setup) == {1: -100, 2: 5}, "beyond a limit there is no way left"
    assert entry("#GET WCS POSLIMIT [VC1=0]\nM30", setup) == (catalogue.LIMIT_DIRECTION, 1, 1)
    assert entry("#GET WCS POSLIMIT [VC3=1]\nM30", setup) == (catalogue.LIMIT_DIRECTION, 1, 1)


def test_an_arc_through_three_points_of_a_system() -> None:
    arc = "G00 X1 Y2 Z3\nG303 F100 I5 J6 K7 X9 Y1 Z2\nM30"
    plain, turned = machine_path(on_machine(arc)), machine_path(on_machine(f"#CS ON [5,6,7,10,20,30]\n{arc}"))
    np.testing.assert_allclose(turned, frame((5, 6, 7, 10, 20, 30)).outer(plain), atol=1e-9)
