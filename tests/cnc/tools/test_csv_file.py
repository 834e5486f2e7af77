"""Tools in CSV files, and data as people write them."""

from __future__ import annotations

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.tools.csv_file import format_csv, parse_csv
from runtime.cnc.tools.tool import FieldError, Tool
from runtime.cnc.tools.written import ToolAxes, datum_of, with_written
from runtime.diagnostics.catalogue import tools as T  # noqa: N812 - a table of constants
from tests.cnc.tools.test_table import tools

AXES = ToolAxes(("X", "Y", "C"), frozenset({2}))


def written(text: str) -> Tool:
    name, _, value = text.partition("=")
    return with_written(Tool(1), datum_of(name, AXES), value, AXES)


@pytest.mark.parametrize(
    ("text", "expected"),
    [
        ("radius=5", Tool(1, radius=5)),
        ("radius = 5 mm", Tool(1, radius=5)),
        ("length=2inch", Tool(1, length=50.8)),
        ("length=1500 um", Tool(1, length=1.5)),
        ("length=-3", Tool(1, length=-3)),
        ("offset.Y=1 inch", Tool(1, offsets=(0.0, 25.4))),
        ("offset.C=90 deg", Tool(1, offsets=(0.0, 0.0, 90.0))),
        ("offsets[0]=3", Tool(1, offsets=(3.0,))),
        ("type=turning", Tool(1, type=1)),
        ("type=2", Tool(1, type=2)),
        ("valid=no", Tool(1, valid=False)),
        ("max_speed=8000", Tool(1, max_speed=8000)),
        ("max_speed=8000 rev/min", Tool(1, max_speed=8000)),
        ("max_speed=600 deg/s", Tool(1, max_speed=100)),
        ("max_acceleration=100 rev/min/s", Tool(1, max_acceleration=600)),
        ("parameters[1]=1.5", Tool(1, parameters=(0.0, 1.5))),
        ("name=end mill", Tool(1, name="end mill")),
    ],
)
def test_data_are_written_with_or_without_units(text: str, expected: Tool) -> None:
    assert written(text) == expected


@pytest.mark.parametrize(
    ("text", "entry"),
    [
        ("radius=-1", T.NEGATIVE_RADIUS),
        ("radius=5 deg", T.UNIT_WRONG),
        ("offset.C=5 mm", T.UNIT_WRONG),
        ("offset.X=5 deg", T.UNIT_WRONG),
        ("max_speed=5 m/min", T.UNIT_WRONG),
        ("radius=wide", T.VALUE_INVALID),
        ("radius=", T.VALUE_INVALID),
        ("radius=nan", T.VALUE_INVALID),
        ("kin_id=1.5", T.VALUE_INVALID),
        ("type=laser", T.VALUE_INVALID),
        ("valid=maybe", T.VALUE_INVALID),
        ("radius=300 m", T.VALUE_RANGE),
        ("depth=1", T.FIELD_UNKNOWN),
        ("offset.Z=1", T.FIELD_UNKNOWN),
        ("radius.X=1", T.FIELD_UNKNOWN),
        ("radius[0]=1", T.FIELD_UNKNOWN),
        ("parameters=1", T.FIELD_UNKNOWN),
        ("r!=1", T.FIELD_UNKNOWN),
        ("parameters[60]=1", T.ELEMENT_RANGE),
    ],
)
def test_what_is_written_wrong_is_told(text: str, entry: object) -> None:
    with pytest.raises(FieldError) as told:
        written(text)
    assert told.value.entry is entry


def test_a_table_is_read_with_the_unit_of_each_row() -> None:
    read = parse_csv("number,unit,radius,offset.C,name\n5,inch,1,90,\n\n2,,1 inch,,a b\n9,mm,3,,\n", AXES)
    assert read.problems == ()
    assert read.tools == (
        Tool(2, radius=25.4, name="a b"),
        Tool(5, radius=25.4, offsets=(0.0, 0.0, 90.0)),
        Tool(9, radius=3),
    )
    assert parse_csv("number;radius\n1;5\n", AXES).tools == (Tool(1, radius=5),)


@pytest.mark.parametrize(
    ("text", "entry", "line", "cell"),
    [
        ("", T.CSV_NUMBER, 1, 1),
        ("radius\n5\n", T.CSV_NUMBER, 1, 1),
        ("number,depth\n1,5\n", T.FIELD_UNKNOWN, 1, 2),
        ("number,radius,radius\n1,5,5\n", T.COLUMN_TWICE, 1, 3),
        ("number,radius\n1\n", T.CSV_CELLS, 2, 0),
        ("number,radius\n1,5\n0,5\n", T.TOOL_NUMBER, 3, 1),
        ("number,radius\nx,5\n", T.TOOL_NUMBER, 2, 1),
        ("number,radius\n1,5\n1,6\n", T.TOOL_TWICE, 3, 1),
        ("number,unit\n1,cm\n", T.UNIT_WRONG, 2, 2),
        ("number,unit,radius\n1,mm,-5\n", T.NEGATIVE_RADIUS, 2, 3),
        ("number,radius\n1,5 deg\n", T.UNIT_WRONG, 2, 2),
    ],
)
def test_mistakes_are_told_at_their_line_and_cell(text: str, entry: object, line: int, cell: int) -> None:
    (problem,) = parse_csv(text, AXES).problems
    assert (problem.entry, problem.place.line, problem.place.column) == (entry, line, cell)
    assert problem.text


@given(st.lists(tools(), max_size=4, unique_by=lambda tool: tool.number))
def test_a_table_that_is_written_is_read_again(written_tools: list[Tool]) -> None:
    positive = [tool.with_value("radius", abs(tool.radius)) for tool in written_tools]
    named = [tool.with_value("name", tool.name.strip()) for tool in positive]
    read = parse_csv(format_csv(named, AXES), AXES)
    assert read.problems == ()
    assert list(read.tools) == sorted(named, key=lambda tool: tool.number)
