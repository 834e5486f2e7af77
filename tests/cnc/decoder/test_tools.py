"""Tools in programs: D and T, length and axis offsets and when the axes take them up, the data of the tools as variables."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.blocks import BlockEnd, Line, TechnologyFunction, ToolRadius
from runtime.cnc.decoder import ChannelMemory, DecoderSetup
from runtime.cnc.tools.setup import ToolSetup
from runtime.cnc.tools.table import MemoryTools, SqliteTools
from runtime.cnc.tools.tool import Tool
from runtime.diagnostics.catalogue import language as C  # noqa: N812 - a table of constants
from runtime.diagnostics.catalogue import tools as T  # noqa: N812
from tests.cnc.decoder.programs import SETUP, Run, decode

TOOLS = (
    Tool(1, "mill", radius=5.0, length=50.0),
    Tool(2, radius=3.0, length=80.0, offsets=(10.0, 20.0, 1.0)),
    Tool(3, radius=2.0, length=10.0, valid=False),
    Tool(4, type=1, cutter_position=3, parameters=(0.0, 1.5), kin_parameters=(1e6,), spindle=6, max_speed=8000.0),
    Tool(17, basic=7, sister_valid=True, sister=2, variant_valid=True, variant=4, radius=1.0, length=7.0),
)


def run(text: str, tools: tuple[Tool, ...] = TOOLS, files: dict[str, str] | None = None, **setup: object) -> Run:
    """A program on a channel with tools; `setup` are fields of ToolSetup."""
    channel: DecoderSetup = replace(SETUP, tools=ToolSetup(**setup))  # type: ignore[arg-type]
    return decode(text, channel, files, memory=ChannelMemory(channel, MemoryTools(tools)))


def good(text: str, **setup: object) -> Run:
    made = run(text, **setup)  # type: ignore[arg-type]
    assert made.problem is None, made.problem
    return made


def radii(made: Run) -> list[float]:
    return [block.radius for block in made.blocks if isinstance(block, ToolRadius)]


# -- D, length, offsets --------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.tool.d-select", "isg.tool.length-comp")
def test_length_is_added_in_z_and_taken_out_by_d0() -> None:
    made = good("G00 X0 Y0 Z0\nD1 X10 Z5\nD0 Z5\nD00\nD[1+1] Z5")
    assert made.ends == [[0, 0, 0], [10, 0, 55], [10, 0, 5], [10, 0, 85 + 1]]
    assert [row["to_pcs"]["Z"] for row in made.rows if row["type"] == "line"][-1] == 5  # type: ignore[index]


@pytest.mark.spec("isg.tool.offset-timing", "chan.tool.offset-time")
def test_each_axis_takes_its_offset_up_with_its_own_next_absolute_word() -> None:
    made = good("G00 X1 Y2 Z3\nD2\nY2\nX1\nZ3\nD1\nD0\nX1")
    assert made.ends == [[1, 2, 3], [1, 22, 3], [11, 22, 3], [11, 22, 84], [1, 22, 84]]


@pytest.mark.spec("isg.tool.offset-timing", "chan.tool.offset-time")
def test_an_incremental_word_adds_its_way_only_and_the_offset_waits() -> None:
    made = good("G00 X1 Y2 Z3\nD2\nG91 X0\nZ5\nD1 Z1\nG90 X1\nZ0")
    assert made.ends == [[1, 2, 3], [1, 2, 3], [1, 2, 8], [1, 2, 9], [1, 2, 9], [1, 2, 50]]


@pytest.mark.spec("isg.tool.offset-timing")
@given(
    st.lists(
        st.tuples(st.sampled_from("XYZ"), st.booleans(), st.integers(-50, 50), st.sampled_from((0, 1, 2))), max_size=12
    )
)
def test_an_axis_stands_at_its_words_and_the_offset_of_its_last_absolute_one(
    blocks: list[tuple[str, bool, int, int]],
) -> None:
    """Law of the pending offsets, held against a bookkeeping per axis."""
    offsets = {0: (0, 0, 0), 1: (0, 0, 50), 2: (10, 20, 81)}
    place = [0.0, 0.0, 0.0]
    expected = []
    lines = ["G00"]
    for name, incremental, value, data in blocks:
        axis = "XYZ".index(name)
        place[axis] = place[axis] + value if incremental else value + offsets[data][axis]
        expected.append(place.copy())
        lines.append(f"D{data} {'G91' if incremental else 'G90'} {name}{value}")
    assert good("\n".join(lines)).ends == expected


@pytest.mark.spec("isg.tool.length-comp", "chan.tool.length-axis")
def test_the_length_changes_over_with_the_plane() -> None:
    made = good("G00 X0 Y0 Z0\nD1 X0 Y0 Z0\nG18\nX0\nY0\nZ0\nG19\nX0 Y0")
    assert made.ends == [[0, 0, 0], [0, 0, 50], [0, 0, 50], [0, 50, 50], [0, 50, 0], [50, 0, 0]]


@pytest.mark.spec("chan.tool.length-axis")
def test_the_length_stays_in_z_if_the_channel_wants_it() -> None:
    made = good("D1 G00\nG18 X0 Y0 Z0\nG19 X0 Y0 Z0\n#TLAX DEFAULT\nX0 Y0 Z0", length_stays=True)
    assert made.ends == [[0, 0, 50], [0, 0, 50], [50, 0, 0]]


@pytest.mark.spec("isg.tool.tlax")
def test_the_length_can_be_given_to_an_axis_and_back_to_the_plane() -> None:
    made = good(
        "G00 X0 Y0 Z0\nV.G.WZL=33\n#TLAX [Z+]\nG18\nX0 Y0 Z0\nG19 X0 Y0 Z0\n#TLAX [ X - ]\nX0 Y0 Z0\nG18 #TLAX\n".replace(
            "\nG18 #TLAX", "\nG18\n#TLAX DEFAULT\nX0 Y0 Z0\nG17 X0 Y0 Z0"
        )
    )
    assert made.ends == [[0, 0, 0], [0, 0, 33], [0, 0, 33], [-33, 0, 0], [0, 33, 0], [0, 0, 33]]


@pytest.mark.spec("isg.tool.tlax")
def test_what_tlax_does_not_take() -> None:
    for text in ("#TLAX [Z]", "#TLAX [+]", "#TLAX", "#TLAX [Z*]"):
        assert decode_error(text) in (C.STATEMENT_ARGUMENTS, C.KEY_MISSING), text
    assert decode_error("#TLAX [Q+]") is C.AXIS_UNKNOWN


def decode_error(text: str) -> object:
    from tests.cnc.decoder.programs import problems

    return problems(text)[0].entry


@pytest.mark.spec("isg.tool.offset-timing", "chan.tool.offset-time")
def test_with_direct_offsets_the_d_word_moves() -> None:
    made = good("G00 X1 Y2 Z3\nD2\nG91 X1\nD1 X1\nD0", direct_offsets=True)
    assert made.ends == [[1, 2, 3], [11, 22, 84], [12, 22, 84], [2, 2, 53], [3, 2, 53], [3, 2, 3]]
    made = good("G01 F100 D2\nD0 G90 X0", direct_offsets=True)
    assert made.ends == [[10, 20, 81], [0, 0, 0], [0, 0, 0]]
    assert [block.feed for block in made.blocks if isinstance(block, Line)] == [100, 100, 100]


def test_a_block_that_moves_by_its_tool_only_is_a_step_of_single_block() -> None:
    made = good("G00 X1 T1\nD1\nV.G.WZ_AKT.L = 60 T2\nT3", direct_offsets=True)
    assert [block.source.line for block in made.blocks if isinstance(block, BlockEnd)] == [1, 2, 3]


def test_a_direct_offset_needs_a_feed_as_any_motion() -> None:
    made = run("G01 D1", direct_offsets=True)
    assert made.problem is not None
    assert made.problem.entry is C.FEED_MISSING
    assert made.ends == []


def test_behind_a_change_of_plane_direct_offsets_wait_in_the_axes_of_the_length() -> None:
    """Whether the axes have taken the length over is not known: D must not move them the wrong way."""
    made = good("G00 D1\nG18\nD2\nX0 Y0 Z0", direct_offsets=True)
    assert made.ends == [[0, 0, 50], [10, 0, 50], [10, 100, 1]]


# -- selection and its checks --------------------------------------------------------------------------------------


@pytest.mark.spec("isg.tool.d-select")
def test_a_tool_that_is_not_there_or_not_valid_is_refused_before_anything_moves() -> None:
    for text, entry in (("D99 X5", T.TOOL_MISSING), ("D3 X5", T.TOOL_INVALID), ("D[-1] X5", T.NUMBER_INVALID)):
        made = run("G00 " + text)
        assert made.problem is not None
        assert made.problem.entry is entry
        assert made.problem.place.column == 5
        assert made.ends == []


@pytest.mark.spec("chan.tool.min-dimensions")
def test_a_tool_must_not_be_smaller_than_the_channel_allows() -> None:
    limits = {"minimum_length": 50.0, "minimum_radius": 3.0}
    assert good("D1\nD2\nD0", **limits).problem is None
    assert run("D4", minimum_length=0.1).problem.entry is T.LENGTH_MINIMUM  # type: ignore[union-attr]
    assert run("D1", minimum_length=50.1).problem.entry is T.LENGTH_MINIMUM  # type: ignore[union-attr]
    assert run("D2", minimum_radius=3.1).problem.entry is T.RADIUS_MINIMUM  # type: ignore[union-attr]
    assert (T.LENGTH_MINIMUM.id, T.RADIUS_MINIMUM.id) == (21426, 21427)


@pytest.mark.spec("chan.tool.implicit-d")
def test_t_executes_d_where_the_channel_is_configured_so() -> None:
    program = "T1\nP1=V.G.D_AKT P2=V.G.T_AKT\nT2 D1\nP3=V.G.D_AKT P4=V.G.T_AKT\nT0\nP5=V.G.D_AKT"
    assert good(program).parameters == {1: 0, 2: 1, 3: 1, 4: 2, 5: 1}
    assert good(program, implicit_d=True).parameters == {1: 1, 2: 1, 3: 1, 4: 2, 5: 0}
    made = good("#TOOL PREP [2]\nP1=V.G.D_AKT", implicit_d=True)
    assert made.parameters == {1: 0}
    assert run("T99", implicit_d=True).problem.place.column == 1  # type: ignore[union-attr]


@pytest.mark.spec("isg.add.file-name", "chan.sub.d")
def test_a_d_word_calls_its_program_behind_everything_else() -> None:
    files = {"d.nc": "P1 = V.G.D_AKT\nX[V.G.WZ_AKT.R]\nM17\n"}
    made = run('#FILE NAME [D="d.nc"]\nG00 D1 X10\nD0\nT2\nP2 = 1', files=files)
    assert made.problem is None
    assert [end[0] for end in made.ends] == [10, 5, 0]
    assert made.parameters == {1: 0, 2: 1}
    made = run('#FILE NAME [D="d.nc"]\nG00 T2 X20', files=files, implicit_d=True)
    assert [end[0] for end in made.ends] == [20 + 10, 3 + 10]
    assert run("D3", files=files).problem.entry is T.TOOL_INVALID  # type: ignore[union-attr]


# -- the radius in the stream --------------------------------------------------------------------------------------


@pytest.mark.spec("isg.tool.d-select")
def test_the_radius_stands_in_the_stream_in_front_of_the_block_that_it_holds_for() -> None:
    made = good("G00 X1\nD1 X2\nX3\nV.G.WZ_AKT.R = V.G.WZ_AKT.R - 0.5 X4\nD2\nD2\nD0")
    assert radii(made) == [5, 4.5, 3, 0]
    kinds = [type(block).__name__ for block in made.blocks]
    assert [kind for kind in kinds if kind != "BlockEnd"][:6] == [
        "Polyline", "ToolRadius", "Line", "Polyline", "ToolRadius", "Polyline"
    ]  # fmt: skip
    lines = [block.source.line for block in made.blocks if isinstance(block, ToolRadius)]
    assert lines == [2, 4, 5, 7]
    assert made.decoder.execution.tools.radius == 0


# -- variables -----------------------------------------------------------------------------------------------------


def test_the_table_is_read_and_written_with_all_its_data() -> None:
    program = """
P1=V.G.WZ[2].R P2=V.G.WZ[2].L P3=V.G.WZ[2].V.Y P4=V.G.WZ[2].V[2] P5=V.G.WZ[4].P[1] P6=V.G.WZ[4].KIN_PARAM[0]
P7=V.G.WZ[4].TYPE P8=V.G.WZ[4].SRK_ID P9=V.G.WZ[4].SPDL_AX_NR P10=V.G.WZ[4].S_MAX_SPEED P11=V.G.WZ[3].OK P12=V.G.WZ[99].OK
P13=V.G.WZ[17].SISTER P14=V.G.WZ[17].VARIANT P15=V.G.WZ[17].SISTER_VALID P16=V.G.WZ[1].ME P17=V.G.WZ[17].VARIANT_VALID
G70
P20=V.G.WZ[1].R P21=V.G.WZ[4].KIN_PARAM[0]
V.G.WZ[1].R=1 V.G.WZ[1].V.X=2 V.G.WZ[1].P[59]=7.5 V.G.WZ[1].KIN_ID=9 V.G.WZ[1].OK=1 V.G.WZ[1].TOOL_FIXED=1
V.G.WZ[1].S_MIN_SPEED=100 V.G.WZ[1].S_MAX_ACC=2000 V.G.WZ[1].L=1 V.G.WZ[1].SPDL_AX_NR=6
G71
P22=V.G.WZ[1].R P23=V.G.WZ[1].V.X P24=V.G.WZ[1].P[59] P25=V.G.TOOL_LIST_INVOKE P26=V.G.D_AKT
D1 P27=V.G.WZ_AKT.R P28=V.G.WZ_AKT.KIN_ID P29=V.G.WZ_AKT.TOOL_FIXED
P30=V.G.WZ_AKT.R
"""
    found = good(program).parameters
    expected = [3, 80, 20, 1, 1.5, 1e6, 1, 3, 6, 8000, 0, 0, 2, 4, 1, 0, 1]
    assert [found[n] for n in range(1, 18)] == expected
    assert found[20] == pytest.approx(5 / 25.4)
    assert found[21] == 1e6
    assert [found[n] for n in range(22, 27)] == pytest.approx([25.4, 50.8, 7.5, 10, 0])
    assert found[27] == 0  # values of a block are computed before its D word
    assert found[30] == pytest.approx(25.4)


@pytest.mark.spec("isg.var.g-active-tool")
@pytest.mark.parametrize(
    "name", ["V.G.WZ[1].TYPE", "V.G.WZ[1].SUB_TYPE", "V.G.WZ[1].ME", "V.G.WZ_AKT.TYPE", "V.G.WZ_AKT.ME"]
)
def test_type_and_unit_are_read_only(name: str) -> None:
    assert decode_error(f"{name} = 1") is C.VARIABLE_READ_ONLY


def test_wrong_data_are_refused_with_their_reason() -> None:
    for text, entry in (
        ("P1=V.G.WZ[99].R", T.TOOL_MISSING),
        ("V.G.WZ[99].R=1", T.TOOL_MISSING),
        ("V.G.WZ[1].R=-1", T.NEGATIVE_RADIUS),
        ("V.G.WZ[1].R=1000000", T.VALUE_RANGE),
        ("V.G.WZ[1].OK=2", T.VALUE_RANGE),
        ("V.G.WZ[1].KIN_ID=1.5", T.VALUE_INVALID),
        ("P1=V.G.WZ[1].P[60]", C.SET_INDEX),
        ("P1=V.G.WZ[1].V[3]", C.ARRAY_INDEX),
        ("P1=V.G.WZ[1].GOBJECT[0].LINK", C.VARIABLE_UNSUPPORTED),
        ("P1=V.G.WZ_AKT.LINKPOINT.X", C.VARIABLE_UNSUPPORTED),
    ):
        try:
            problem = run(text).problem
        except Exception as error:  # a mistake that the check finds
            problem = error.problem  # type: ignore[attr-defined]
        assert problem is not None, text
        assert problem.entry is entry, text


@pytest.mark.spec("isg.var.g-active-tool")
def test_writing_the_active_tool_acts_like_a_d_word_and_ends_with_the_next_one() -> None:
    program = (
        "G00 D1\nV.G.WZ_AKT.L = 60 V.G.WZ_AKT.V.X = 1\nX0 Z0\nP1=V.G.WZ[1].L P2=V.G.WZ_AKT.L\nD1 X0 Z0\n"
        "D0\nV.G.WZ_AKT.V[1]=4\nY0\n"
        "V.G.WZ_AKT.P[3] = 8 P3=V.G.WZ_AKT.P[3] P4=V.G.WZ_AKT.OK\nD1\nP5=V.G.WZ_AKT.P[3] P6=V.G.D_AKT P7=V.G.WZR P8=V.G.WZL"
    )
    made = good(program)
    assert made.ends == [[1, 0, 60], [0, 0, 50], [0, 4, 50]]
    assert made.parameters == {1: 50, 2: 60, 3: 8, 4: 1, 5: 0, 6: 1, 7: 5, 8: 50}


@pytest.mark.spec("isg.var.g-active-tool")
def test_a_radius_can_be_given_without_a_tool_and_be_negative() -> None:
    made = good("V.G.WZ_AKT.R = -2\nV.G.WZR = V.G.WZR - 1\nG70\nV.G.WZ_AKT.R = 1\nP1=V.G.WZ_AKT.R P2=V.G.D_AKT\nD0")
    assert radii(made) == [-2, -3, 25.4, 0]
    assert made.parameters == {1: 1, 2: 0}


def test_what_a_program_writes_into_the_table_holds_for_the_next_program() -> None:
    memory = ChannelMemory(SETUP, MemoryTools(TOOLS))
    assert decode("V.G.WZ[1].L = 51", memory=memory).problem is None
    made = decode("G00 D1 Z0\nP1=V.G.T_AKT", memory=memory)
    assert made.ends == [[0, 0, 51]]
    assert made.parameters == {1: 0}
    assert radii(made) == [5]  # a program begins without a tool


def test_wear_of_a_compensation_that_is_not_there_is_0() -> None:
    found = good(
        "P1=V.G.WZ_AKT.WEAR_RADIUS P2=V.G.WZ_AKT.WEAR.X V.G.WZ_AKT.WEAR_CONST=12\nP3=V.G.WZ_AKT.WEAR_CONST"
    ).parameters
    assert found == {1: 0, 2: 0, 3: 12}


# -- #TOOL ---------------------------------------------------------------------------------------------------------


@pytest.mark.spec("isg.toolext.tool-data-prep", "isg.toolext.v-tool-variables")
def test_tools_are_named_by_basic_sister_and_variant_number() -> None:
    program = (
        '"SISTER"="2"\nP10=7\n#TOOL DATA [P10,"SISTER",4]\n'
        "P1=V.G.D_AKT P2=V.TOOL.BASIC P3=V.TOOL.SISTER P4=V.TOOL.VARIANT\nP5=V.G.T_AKT\n"
        "#TOOL PREP [9,,4]\nP6=V.TOOL.BASIC P7=V.TOOL.SISTER P8=V.TOOL.VARIANT P9=V.G.D_AKT\n#TOOL PREP [9,5,]\n"
        "P11=V.TOOL.SISTER P12=V.TOOL.VARIANT\n#TOOL DATA [2]\nP13=V.G.D_AKT\n"
        "T1 P14=V.TOOL.SISTER\nP15=V.TOOL.BASIC P16=V.TOOL.SISTER\n"
        "#TOOL DATA [0]\nP17=V.G.D_AKT"
    )
    made = good(program)
    assert made.parameters == {
        10: 7, 1: 17, 2: 7, 3: 2, 4: 4, 5: 7, 6: 9, 7: 0, 8: 4, 9: 17, 11: 5, 12: 0, 13: 2, 14: 0, 15: 1, 16: 0, 17: 0
    }  # fmt: skip
    functions = [(block.number, block.source.line) for block in made.blocks if isinstance(block, TechnologyFunction)]
    assert functions == [(9, 6), (9, 8), (1, 12)]


@pytest.mark.spec("isg.toolext.tool-data-prep")
def test_what_tool_data_does_not_take() -> None:
    for text, entry in (
        ("#TOOL DATA [,2]", T.ID_PARTS),
        ("#TOOL DATA [1,2,3,4]", T.ID_PARTS),
        ("#TOOL DATA [7,3,4]", T.TOOL_MISSING),
        ("#TOOL DATA [-1]", T.NUMBER_INVALID),
        ("#TOOL DATA [3]", T.TOOL_INVALID),
    ):
        problem = run(text).problem
        assert problem is not None, text
        assert problem.entry is entry, text


@pytest.mark.spec("isg.toolext.v-tool-variables")
def test_the_identification_is_read_only() -> None:
    assert decode_error("V.TOOL.BASIC = 1") is C.VARIABLE_READ_ONLY


@pytest.mark.spec("isg.toolext.tool-refresh")
def test_refresh_keeps_the_data_that_are_in_force() -> None:
    made = good("G00 D1\nV.G.WZ[1].L = 99 V.G.WZ_AKT.L = 60\n#TOOL REFRESH\nZ0\nD1 Z0")
    assert made.ends == [[0, 0, 60], [0, 0, 99]]


# -- the table in a file -------------------------------------------------------------------------------------------


def test_the_file_is_read_with_every_d_word(tmp_path: Path) -> None:
    table = SqliteTools(tmp_path / "tools.db")
    table.put(*TOOLS)
    memory = ChannelMemory(SETUP, table)
    assert decode("G00 D1 Z0", memory=memory).ends == [[0, 0, 50]]
    other = SqliteTools(tmp_path / "tools.db")
    other.put(replace(TOOLS[0], length=55.5))
    assert decode("G00 D1 Z0\nV.G.WZ[1].R=4", memory=memory).ends == [[0, 0, 55.5]]
    found = other.get(1)
    assert found == replace(TOOLS[0], length=55.5, radius=4.0)
    assert np.isclose(found.radius, 4.0)


def test_a_table_that_is_gone_is_an_error_of_the_program(tmp_path: Path) -> None:
    path = tmp_path / "tools.db"
    table = SqliteTools(path)
    table.close()
    for text in ("G00 D1 X5", "G00 X[V.G.WZ[1].R]", "#TOOL DATA [7,2,4]"):
        made = decode(text, memory=ChannelMemory(SETUP, table))
        assert made.problem is not None
        assert made.problem.entry is T.TABLE_FAILED
        assert made.ends == []
