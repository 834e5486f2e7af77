"""Tool lists of ISG controls: what they say, in which unit, and every mistake in them at its line."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given

from runtime.cnc.tools.list_file import format_tool_list, parse_tool_list, read_tool_list
from runtime.cnc.tools.table import ToolTableError
from runtime.cnc.tools.tool import FIELDS, Kind, Tool
from runtime.diagnostics.catalogue import tools as T  # noqa: N812 - a table of constants
from tests.cnc.tools.test_table import tools

LIST = """\
# Tool data
wz[5].laenge           6000        # Tool length
wz[5].RADIUS           54000
wz[5].gueltig          1
wz[5].mass_einheit     0
wz[5].ax_versatz[0]    205000      ; offset
wz[5].log_ax_nr_spdl   6
wz[5].vb_min           60000
wz[5].vb_max           3000000
wz[5].a_max            3000
wz[5].param[1]         20.5
wz[5].kinematic.param[0] 1088000
wz[5].linkpoint_data.name tip
wz[8].laenge           10000
wz[8].ax_versatz[0]    10000
wz[8].ax_versatz[1]    900000
wz[8].mass_einheit     1
wz[8].typ              0x2
wz[8].gear_ratio_num   1
wz[8].tool_id.sister   3
"""


def test_a_list_is_read_in_its_units() -> None:
    read = parse_tool_list(LIST, rotary=frozenset({1}))
    assert read.problems == ()
    assert [problem.entry for problem in read.warnings] == [T.LIST_IGNORED]
    five, eight = read.tools
    assert five == Tool(
        5,
        length=0.6,
        radius=5.4,
        offsets=(20.5,),
        spindle=6,
        min_speed=five.min_speed,
        max_speed=five.max_speed,
        max_acceleration=3000,
        parameters=(0.0, 20.5),
        kin_parameters=(1088000.0,),
    )
    assert (five.min_speed, five.max_speed) == pytest.approx((10, 500))
    assert eight == Tool(8, valid=False, length=25.4, offsets=(25.4, 90.0), type=2, sister=3)


@pytest.mark.parametrize(
    ("line", "entry", "column"),
    [
        ("wz[1].laenge", T.LIST_VALUE, 1),
        ("wz[1].laenge long", T.LIST_VALUE, 1),
        ("wz[1].depth 5", T.LIST_KEY, 1),
        ("  tool 5", T.LIST_KEY, 3),
        ("wz[0].laenge 5", T.TOOL_NUMBER, 1),
        ("wz[1].laenge[0] 5", T.ELEMENT_RANGE, 1),
        ("wz[1].param 5", T.ELEMENT_RANGE, 1),
        ("wz[1].param[60] 5", T.ELEMENT_RANGE, 1),
        ("wz[1].radius -5", T.NEGATIVE_RADIUS, 1),
        ("wz[1].typ 7", T.VALUE_RANGE, 1),
        ("wz[1].gueltig 0.5", T.VALUE_INVALID, 1),
        ("wz[1].mass_einheit 2", T.VALUE_RANGE, 1),
        ("wz[1].gear_ratio_num 2", T.LIST_UNSUPPORTED, 1),
        ("wz[1].path[0].radius 5", T.LIST_UNSUPPORTED, 1),
        ("wz[2].laenge 5", T.LIST_TWICE, 1),
    ],
)
def test_mistakes_are_told_at_their_line(line: str, entry: object, column: int) -> None:
    read = parse_tool_list(f"wz[2].laenge 4\n{line}\n", "x.lis")
    (problem,) = read.problems
    assert problem.entry is entry
    assert (problem.place.line, problem.place.column) == (2, column)
    assert problem.text


def test_what_cannot_be_read_is_told(tmp_path: Path) -> None:
    (tmp_path / "b.lis").write_bytes(b"wz[1]\0")
    for name in ("nothing.lis", "b.lis", "."):
        with pytest.raises(ToolTableError) as told:
            read_tool_list(tmp_path / name)
        assert told.value.problem.entry is T.LIST_UNREADABLE
    (tmp_path / "old.lis").write_bytes("# Länge\nwz[1].laenge 5\n".encode("latin-1"))
    assert read_tool_list(tmp_path / "old.lis").tools[0].length == pytest.approx(0.0005)


@given(tools())
def test_a_list_that_is_written_is_read_again(tool: Tool) -> None:
    """To the resolution of a list, and without names, which lists do not have."""
    tool = replace(tool, name="", radius=abs(tool.radius))
    (read,) = parse_tool_list(format_tool_list([tool])).tools
    for name, field in FIELDS.items():
        tolerance = {Kind.LENGTH: 1e-4, Kind.OFFSET: 1e-4, Kind.SPEED: 1e-3, Kind.ACCELERATION: 1.0}.get(
            field.kind, 0.0
        )
        if field.count:
            for i in range(field.count):
                assert read.value(name, i) == pytest.approx(tool.value(name, i), abs=tolerance)
        elif field.kind is not Kind.TEXT:
            assert getattr(read, name) == pytest.approx(getattr(tool, name), abs=tolerance)
