"""#CONTROL AREA: definitions, and what the stage behind the path lets through."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from runtime.cnc.blocks import Block, ControlAreaChange, Line, Polyline
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.geometry.control_areas import Disc, Polygon
from runtime.cnc.path_preparation import ControlAreas, Frames, PathError, SpatialArcs
from runtime.cnc.tool_radius_comp import ToolRadiusCompensation
from runtime.cnc.tools.table import MemoryTools
from runtime.cnc.tools.tool import Tool
from runtime.diagnostics.catalogue import control_areas as catalogue
from runtime.diagnostics.catalogue import language, radius
from runtime.diagnostics.errors import ErrorEntry
from tests.cnc.decoder.programs import SETUP, decode, found

DEFINE, SELECT, CLEAR = (f"isg.add.control-area-{name}" for name in ("define", "select", "clear"))
FOUR = replace(SETUP, axes=("X", "Y", "Z", "W"), linear=(True,) * 4, zero_offsets={}, log_axes=(1, 2, 3, 8))

# the examples of the manual, lines 16523–16565
T_SHAPE = """#CONTROL AREA BEGIN [ID1 WORK POLY MIN_EXCUR=-50 MAX_EXCUR=50]
G01 F1000 G90 X-150 Y75
X-50 Y150
X50 Y150
X150 Y75
X150 Y0
X50
X50 Y75
X-50 Y75
X-50 Y0
X-150 Y0
X-150 Y75
#CONTROL AREA END
"""
CYLINDER = """#CONTROL AREA BEGIN [ID2 PROT CIRC MIN_EXCUR=-70 MAX_EXCUR=70]
G01 X100 Y0 F10000
G02 G162 I50 J0
#CONTROL AREA END
"""
SQUARE = "#CONTROL AREA BEGIN [ID=1 WORK POLY MIN_EXCUR=-5 MAX_EXCUR=5]\nG00 X-10 Y-10\nX10\nY10\nX-10\nY-10\n#CONTROL AREA END\n"
KEEP_OUT = SQUARE.replace("WORK", "PROT")


def entry(text: str, memory: ChannelMemory | None = None) -> tuple[ErrorEntry, int, int]:
    if memory is None:
        (problem,) = found(f"{text}\nM30")
        return problem
    run = decode(f"{text}\nM30", memory=memory)
    assert run.problem is not None
    return run.problem.entry, run.problem.place.line, run.problem.place.column


def driven(text: str, memory: ChannelMemory | None = None) -> tuple[list[Block], tuple[ErrorEntry, int] | None]:
    """What comes out of the stages, and the error with its line."""
    run = decode(f"{text}\nM30", memory=memory)
    assert run.problem is None, run.problem
    blocks: list[Block] = []
    stages = ControlAreas()(SpatialArcs()(Frames()(ToolRadiusCompensation()(run.blocks))))
    try:
        while (block := next(stages, None)) is not None:
            blocks.append(block)
    except PathError as error:
        return blocks, (error.problem.entry, error.problem.place.line)
    return blocks, None


def error(text: str, memory: ChannelMemory | None = None) -> tuple[ErrorEntry, int] | None:
    return driven(text, memory)[1]


# -- definition


@pytest.mark.spec(DEFINE)
def test_the_examples_of_the_manual() -> None:
    run = decode(f"{T_SHAPE}{CYLINDER}M30", start=(7.0, 8.0, 9.0))
    assert run.problem is None
    assert not any(isinstance(block, Line | Polyline) for block in run.blocks), "a contour moves nothing"
    areas = run.decoder.execution.memory.control_areas
    one, two = areas[1], areas[2]
    assert (one.work, one.axes, one.low, one.high) == (True, (0, 1, 2), -50, 50)
    assert isinstance(one.contour, Polygon)
    assert len(one.contour.corners) == 10
    assert (two.work, two.low, two.high) == (False, -70, 70)
    assert isinstance(two.contour, Disc)
    assert (two.contour.centre.tolist(), two.contour.radius) == ([150, 0], 50)
    assert run.decoder.execution.coordinates.position == [7, 8, 9]


@pytest.mark.spec(DEFINE)
def test_a_contour_counts_in_machine_coordinates_whatever_is_active() -> None:
    around = f"G54 G92 X5\n#CS ON [1,2,3,4,5,6]\n#SCALE ON X2\nG70\n{SQUARE}M30"
    run = decode(around)
    assert run.problem is None
    area = run.decoder.execution.memory.control_areas[1]
    assert isinstance(area.contour, Polygon)
    np.testing.assert_allclose(area.contour.corners, np.array([(-10, -10), (10, -10), (10, 10), (-10, 10)]) * 25.4)
    assert (area.low, area.high) == (-5 * 25.4, 5 * 25.4)


@pytest.mark.spec(DEFINE)
def test_planes_and_other_axes_of_the_excursion() -> None:
    body = "G00 Z0 X0\nZ10\nX10\nZ0 X0\n#CONTROL AREA END\nM30"
    for given, axis in (("", 1), (" EXCUR_AX=W", 3), (" EXCUR_AXNR=8 MONITOR_LVL=MCS", 3)):
        run = decode(
            f"G18\n#CONTROL AREA BEGIN [ID=0 PROT POLY MIN_EXCUR=1 MAX_EXCUR=2{given}]\n{body}", FOUR, start=(0.0,) * 4
        )
        assert run.problem is None
        assert run.decoder.execution.memory.control_areas[0].axes == (2, 0, axis)


@pytest.mark.spec(DEFINE)
def test_definitions_outlive_the_program_and_twenty_are_enough() -> None:
    memory = ChannelMemory(SETUP)
    for number in range(20):
        assert decode(SQUARE.replace("ID=1", f"ID={number}") + "M30", memory=memory).problem is None
    assert entry(SQUARE.replace("ID=1", "ID=20"), memory) == (catalogue.SPACES_FULL, 1, 1)
    assert decode(f"{KEEP_OUT}M30", memory=memory).problem is None, "an inactive one is defined anew"
    assert not memory.control_areas[1].work
    assert decode("G00 X50\nM30", memory=memory).problem is None


@pytest.mark.spec(DEFINE)
@pytest.mark.parametrize(
    ("text", "expected"),
    [
        (SQUARE.replace("\nX-10\nY-10\n#", "\nX-10\n#"), (catalogue.SPACE_OPEN, 6, 1)),
        (SQUARE.replace("\nY10\nX-10\nY-10\n#", "\nX-10\n#"), (catalogue.SPACE_OPEN, 5, 1)),
        (CYLINDER.replace("G02 G162 I50 J0\n", ""), (catalogue.SPACE_OPEN, 3, 1)),
        (SQUARE.replace("#CONTROL AREA END\n", ""), (catalogue.SPACE_BLOCK, 7, 1)),
        (
            SQUARE.replace("G00 X-10", "#CONTROL AREA BEGIN [ID=2 WORK POLY MIN_EXCUR=0 MAX_EXCUR=1]\nG00 X-10"),
            (catalogue.SPACE_TWICE, 2, 1),
        ),
        (SQUARE.replace("\nX10\n", "\n#CONTROL AREA ON ALL\nX10\n"), (catalogue.SPACE_TWICE, 3, 1)),
        ("#CONTROL AREA END", (catalogue.SPACE_NOT_BEGUN, 1, 1)),
        (SQUARE.replace("WORK", "WORK PROT"), (catalogue.SPACE_KEYS, 1, 1)),
        (SQUARE.replace("POLY ", ""), (catalogue.SPACE_KEYS, 1, 1)),
        (SQUARE.replace("MAX_EXCUR=5", "MAX_EXCUR=-5"), (catalogue.SPACE_KEYS, 1, 47)),
        (SQUARE.replace("MAX_EXCUR=5", "MAX_EXCUR=5 MONITOR_LVL=IMCS"), (catalogue.SPACE_KEYS, 1, 74)),
        (SQUARE.replace("MAX_EXCUR=5", "MAX_EXCUR=5 EXCUR_AX=Y"), (catalogue.SPACE_KEYS, 1, 1)),
        (SQUARE.replace("MAX_EXCUR=5", "MAX_EXCUR=5 EXCUR_AX=Y EXCUR_AXNR=2"), (catalogue.SPACE_KEYS, 1, 84)),
        (SQUARE.replace("MAX_EXCUR=5", "MAX_EXCUR=5 EXCUR_AXNR=77"), (language.LOGICAL_AXIS, 1, 73)),
        (SQUARE.replace(" MAX_EXCUR=5", ""), (language.KEY_MISSING, 1, 1)),
        (SQUARE.replace("ID=1", "ID=1.5"), (catalogue.SPACE_ID, 1, 25)),
        (SQUARE.replace("\nX10\n", "\nX10 M10\n"), (catalogue.SPACE_BLOCK, 3, 5)),
        (SQUARE.replace("\nX10\n", "\nX10 Z1\n"), (catalogue.SPACE_BLOCK, 3, 5)),
        (SQUARE.replace("\nX10\n", "\nG91 X10\n"), (catalogue.SPACE_BLOCK, 3, 5)),
        (SQUARE.replace("\nX10\n", "\nG18 X10\n"), (catalogue.SPACE_BLOCK, 3, 1)),
        (SQUARE.replace("G00 X-10 Y-10", "G00 X-10"), (catalogue.SPACE_BLOCK, 2, 5)),
        (SQUARE.replace("\nX10\n", "\nG02 I5 J0\n"), (catalogue.SPACE_BLOCK, 3, 1)),
        (SQUARE.replace("\nX10\n", "\nX10 I5\n"), (catalogue.SPACE_BLOCK, 3, 5)),
        (CYLINDER.replace("G02 G162 I50 J0", "G02 X50 I50 J0"), (catalogue.SPACE_BLOCK, 3, 9)),
        (CYLINDER.replace("G02 G162 I50 J0", "G02 R50"), (catalogue.SPACE_BLOCK, 3, 5)),
        (CYLINDER.replace("G02 G162 I50 J0", "X50"), (catalogue.SPACE_BLOCK, 3, 1)),
        (CYLINDER.replace("G02 G162 I50 J0", "G02 I0 J0"), (catalogue.SPACE_BLOCK, 3, 5)),
        ("G41 G01 F1 X1\n" + SQUARE, (radius.FORBIDDEN, 2, 1)),
    ],
)
def test_wrong_definitions(text: str, expected: tuple[ErrorEntry, int, int]) -> None:
    assert entry(text.rstrip("\n")) == expected


@pytest.mark.spec(DEFINE)
def test_a_program_that_ends_in_a_definition() -> None:
    run = decode(SQUARE.replace("#CONTROL AREA END\n", ""))
    assert run.problem is not None
    assert (run.problem.entry, run.problem.place.line) == (catalogue.SPACE_OPEN, 1)


# -- selection


@pytest.mark.spec(SELECT)
def test_a_work_space_is_not_left() -> None:
    on = f"{SQUARE}#CONTROL AREA ON [ID=1]\nF500 G01 "
    assert error(f"{on}X10 Y10\nX-10 Z5\nY-10 Z-5") is None
    assert error(f"{on}X5\nX11\nX5") == (catalogue.SPACE_LEFT, 10)
    assert error(f"{on}X5\nZ6\nZ0") == (catalogue.SPACE_LEFT, 10)
    blocks, _ = driven(f"{on}X5\nX6\nX11\nX5")
    (run,) = [block for block in blocks if isinstance(block, Polyline)]
    assert run.points[:, 0].tolist() == [0, 5, 6], "what comes before is driven"


@pytest.mark.spec(SELECT)
def test_a_protection_space_is_not_entered() -> None:
    on = f"G00 X20\n{KEEP_OUT}#CONTROL AREA ON [ID=1]\nF500 G01 "
    assert error(f"{on}X10\nY10\nX-10\nZ5\nX5 Y0") is None
    assert error(f"{on}Y-5\nX-20\nY0") == (catalogue.SPACE_ENTERED, 11), "the target is permitted, the way is not"
    assert error(f"{on}Z5\nX0\nZ4") == (catalogue.SPACE_ENTERED, 12)


@pytest.mark.spec(SELECT)
@pytest.mark.parametrize(
    ("word", "good"),
    [
        ("G02 X10 Y0 R5", True),
        ("G03 X8 Y0 I4 J7", True),
        ("G02 X8 Y0 I4 J7", False),  # the long way, up to Y 15
        ("G02 I9 J0", False),
        ("G03 X0 Y0 Z9 I4 J0", False),
        ("G03 X0 Y0 Z4 I4 J0 K2", True),
        ("G18 G02 X8 Z0 I4 K0", True),
        ("G18 G02 X0 Z0 I0 K3", False),
    ],
)
def test_arcs_and_helices(word: str, good: bool) -> None:
    on = f"{SQUARE}#CONTROL AREA ON [ID=1]\nF500 "
    told = error(f"{on}{word}")
    assert told == (None if good else (catalogue.SPACE_LEFT, 9))


@pytest.mark.spec(SELECT)
def test_offsets_systems_and_tools_count() -> None:
    on = f"{SQUARE}#CONTROL AREA ON [ID=1]\nF500 G01 "
    assert error(f"{on}G92 X5\nG01 X6") == (catalogue.SPACE_LEFT, 10)
    assert error(f"{on}X0\n#CS ON [0,0,0,0,0,45]\nX12\nX14.1") is None
    assert error(f"{on}X0\n#CS ON [0,0,0,0,0,45]\nX12\nX14.2") == (catalogue.SPACE_LEFT, 12)
    assert error(f"{on}X0\n#CS ON [0,0,0,0,90]\nG18\nG02 X3 Z0 I1.5 K0\nG01 X5.2") == (catalogue.SPACE_LEFT, 13)
    memory = ChannelMemory(SETUP, MemoryTools((Tool(number=1, length=30.0), Tool(number=2, radius=2.0))))
    assert error(f"{on}D1\nG01 X1 Z5", memory) == (catalogue.SPACE_LEFT, 10), "the axis stands at 0, the tip at -30"
    memory.active_areas.clear()
    free = f"D1 G00 Z0\n{SQUARE}#CONTROL AREA ON [ID=1]\nX1 Z5\nX2 Z-5"
    memory.active_areas.clear()
    assert error(free, memory) is None, "the axis goes from 35 to 25"
    memory.active_areas.clear()
    compensated = f"{on}D2 G41 G138 X2 Y-6\nX8\nY9\nG40 X0"
    assert error(compensated, memory) is None
    memory.active_areas.clear()
    assert error(compensated.replace("Y-6", "Y-9").replace("G41", "G42"), memory) == (catalogue.SPACE_LEFT, 9)


@pytest.mark.spec(SELECT)
def test_several_spaces_are_active_and_the_last_one_ends_first() -> None:
    inner = KEEP_OUT.replace("10", "2").replace("ID=1", "ID=2")
    two = f"G00 X5\n{SQUARE}{inner}#CONTROL AREA ON [ID=1]\n#CONTROL AREA ON [ID=2]\n"
    assert error(f"{two}G00 X0") == (catalogue.SPACE_ENTERED, 18)
    assert error(f"{two}#CONTROL AREA OFF\nG00 X0\nX11") == (catalogue.SPACE_LEFT, 20)
    assert error(f"{two}#CONTROL AREA OFF [ID=1]\nG00 X11\nX0") == (catalogue.SPACE_ENTERED, 20)
    assert error(f"{two}#CONTROL AREA OFF ALL\nG00 X11\nX0") is None
    assert error(f"{two}#CONTROL AREA OFF\n#CONTROL AREA OFF\n#CONTROL AREA OFF\nG00 X11\nX0") is None
    every = f"G00 X5\n{SQUARE}{inner}#CONTROL AREA ON ALL\n"
    assert error(f"{every}G00 X0") == (catalogue.SPACE_ENTERED, 17)
    assert error(f"{every}G00 X11") == (catalogue.SPACE_LEFT, 17)


@pytest.mark.spec(SELECT)
def test_the_tool_is_in_a_permitted_place_when_a_space_is_selected() -> None:
    assert entry(f"G00 X11\n{SQUARE}#CONTROL AREA ON [ID=1]") == (catalogue.SPACE_BEGIN, 9, 1)
    assert entry(f"{KEEP_OUT}#CONTROL AREA ON [ID=1]") == (catalogue.SPACE_BEGIN, 8, 1)
    assert entry(f"{KEEP_OUT}#CONTROL AREA ON ALL") == (catalogue.SPACE_BEGIN, 8, 1)
    memory = ChannelMemory(SETUP, MemoryTools((Tool(number=1, length=30.0),)))
    assert entry(f"D1\n{SQUARE}#CONTROL AREA ON [ID=1]", memory) == (catalogue.SPACE_BEGIN, 9, 1)
    assert memory.active_areas == []


@pytest.mark.spec(SELECT)
def test_spaces_stay_active_from_program_to_program() -> None:
    memory = ChannelMemory(SETUP)
    assert error(f"{SQUARE}#CONTROL AREA ON [ID=1]", memory) is None
    assert error("G00 X5\nX11", memory) == (catalogue.SPACE_LEFT, 2)
    assert error("#CONTROL AREA OFF\nG00 X11", memory) is None
    assert error("G00 X11", memory) is None


@pytest.mark.spec(SELECT, CLEAR)
def test_what_is_not_watched_is_refused_while_a_space_is_active() -> None:
    on = f"{SQUARE}#CONTROL AREA ON [ID=1]\n"
    assert error(f"{on}X[INDP_SYN POS=5 FEED=100]") == (catalogue.SPACE_BESIDE, 9)
    assert error(f"{on}G74 X1") == (catalogue.SPACE_BESIDE, 9)
    assert error(f"{on}G201 X1") == (catalogue.SPACE_BESIDE, 9)
    assert error(f"{on}G202 X1") is None
    for unknown in ("ON [ID=9]", "OFF [ID=9]", "CLEAR [ID=9]"):
        column = f"#CONTROL AREA {unknown}".index("9") + 1
        assert entry(f"#CONTROL AREA {unknown}") == (catalogue.SPACE_UNKNOWN, 1, column)
    assert entry("G41 G01 F1 X1\n#CONTROL AREA ON ALL") == (radius.FORBIDDEN, 2, 1)


@pytest.mark.spec(CLEAR, DEFINE)
def test_definitions_are_deleted_unless_they_are_active() -> None:
    memory = ChannelMemory(SETUP)
    both = SQUARE + SQUARE.replace("ID=1", "ID=2")
    assert error(both, memory) is None
    assert error("#CONTROL AREA CLEAR [ID=1]", memory) is None
    assert list(memory.control_areas) == [2]
    assert error(f"{SQUARE}#CONTROL AREA ON [ID=1]", memory) is None
    assert entry("#CONTROL AREA CLEAR [ID=1]", memory) == (catalogue.SPACE_ACTIVE, 1, 25)
    assert entry("#CONTROL AREA CLEAR ALL", memory) == (catalogue.SPACE_ACTIVE, 1, 1)
    assert entry(SQUARE, memory) == (catalogue.SPACE_ACTIVE, 1, 25)
    assert error("#CONTROL AREA OFF ALL\n#CONTROL AREA CLEAR ALL", memory) is None
    assert memory.control_areas == {}


def test_a_slave_of_a_coupling_is_no_axis_of_a_space() -> None:
    link = "#AX LINK [1, W=X]\n#AX LINK ON [1]\n"
    area = "#CONTROL AREA BEGIN [ID=1 WORK POLY MIN_EXCUR=-5 MAX_EXCUR=5 EXCUR_AX=W]" + SQUARE[SQUARE.index("\nG00") :]
    run = decode(f"{link}{area}#CONTROL AREA ON [ID=1]\nM30", FOUR, start=(0.0,) * 4)
    assert run.problem is not None
    assert run.problem.entry is catalogue.SPACE_BESIDE
    late = decode(f"{area}#CONTROL AREA ON [ID=1]\n{link}M30", FOUR, start=(0.0,) * 4)
    with pytest.raises(PathError) as caught:
        list(ControlAreas()(late.blocks))
    assert caught.value.problem.entry is catalogue.SPACE_BESIDE


def test_without_an_active_space_everything_passes() -> None:
    blocks = decode(f"{SQUARE}G00 X1\nG01 F100 X500\nM30").blocks
    assert not any(isinstance(block, ControlAreaChange) for block in blocks)
    assert list(ControlAreas()(blocks)) == blocks
