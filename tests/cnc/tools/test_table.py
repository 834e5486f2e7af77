"""The tool table in its file, and what its fields may hold."""

from __future__ import annotations

import sqlite3
from dataclasses import replace
from pathlib import Path

import pytest
from hypothesis import given
from hypothesis import strategies as st

from runtime.cnc.tools.table import MemoryTools, SqliteTools, ToolTable, ToolTableError
from runtime.cnc.tools.tool import FIELDS, FieldError, Kind, Tool
from runtime.diagnostics.catalogue import tools as T  # noqa: N812 - a table of constants

_VALUES = {
    Kind.TEXT: st.text("abc äß", max_size=20),
    Kind.INTEGER: st.integers(0, 2),
    Kind.FLAG: st.booleans(),
    Kind.LENGTH: st.floats(-1000, 1000),
    Kind.OFFSET: st.floats(-1000, 1000),
    Kind.NUMBER: st.floats(0, 1e9),
    Kind.SPEED: st.floats(0, 1e5),
    Kind.ACCELERATION: st.floats(0, 1e6),
}


@st.composite
def tools(draw: st.DrawFn) -> Tool:
    tool = Tool(draw(st.integers(1, 30)))
    for name, field in FIELDS.items():
        index = draw(st.integers(0, field.count - 1)) if field.count else 0
        tool = tool.with_value(name, draw(_VALUES[field.kind]), index)
    return tool


@given(st.lists(tools(), max_size=6))
def test_what_is_entered_is_read_again(entered: list[Tool]) -> None:
    expected = {tool.number: tool for tool in entered}
    made: list[ToolTable] = [MemoryTools(), SqliteTools(Path(":memory:"))]
    for table in made:
        table.put(*entered)
        assert table.all() == [expected[number] for number in sorted(expected)]
        for number in range(1, 31):
            assert table.get(number) == expected.get(number)
            assert table.remove(number) == (number in expected)
        assert table.all() == []


def test_a_new_file_begins_with_the_initial_tools_and_only_a_new_one(tmp_path: Path) -> None:
    path = tmp_path / "folder" / "tools.db"
    first = SqliteTools(path, lambda: (Tool(1, radius=2.0),))
    first.remove(1)
    assert SqliteTools(path, lambda: (Tool(1),)).all() == []


def test_all_tools_are_entered_or_none(tmp_path: Path) -> None:
    table = SqliteTools(tmp_path / "tools.db")
    with pytest.raises(ToolTableError):
        table.put(Tool(1), replace(Tool(2), radius=object()))  # type: ignore[arg-type]
    assert table.all() == []
    table.put(Tool(3))  # it can go on
    assert table.all() == [Tool(3)]


def test_a_file_that_is_no_table_or_of_another_version_is_told(tmp_path: Path) -> None:
    path = tmp_path / "tools.db"
    path.write_text("this is no database, but a text that is long enough to be taken for one" * 20)
    with pytest.raises(ToolTableError) as told:
        SqliteTools(path)
    assert told.value.problem.entry is T.TABLE_FAILED
    newer = tmp_path / "newer.db"
    SqliteTools(newer).close()
    with sqlite3.connect(newer) as connection:
        connection.execute("PRAGMA user_version = 2")
    with pytest.raises(ToolTableError) as told:
        SqliteTools(newer)
    assert told.value.problem.entry is T.TABLE_VERSION


def test_a_damaged_row_is_told(tmp_path: Path) -> None:
    table = SqliteTools(tmp_path / "tools.db")
    table.put(Tool(1))
    for column, value in (("radius", "wide"), ("offsets", "{"), ("valid", 7)):
        with sqlite3.connect(table.path) as connection:
            connection.execute(f"UPDATE tools SET {column} = ?", (value,))
        with pytest.raises(ToolTableError) as told:
            table.get(1)
        assert told.value.problem.entry is T.TABLE_FAILED
        table.put(Tool(1))


@pytest.mark.parametrize(
    ("name", "value", "entry"),
    [
        ("radius", float("inf"), T.VALUE_INVALID),
        ("radius", "5", T.VALUE_INVALID),
        ("radius", 1e6, T.VALUE_RANGE),
        ("type", 3, T.VALUE_RANGE),
        ("type", 0.5, T.VALUE_INVALID),
        ("valid", 2, T.VALUE_RANGE),
        ("max_speed", -1, T.VALUE_RANGE),
        ("name", "x" * 61, T.NAME_INVALID),
        ("name", "two\nlines", T.NAME_INVALID),
        ("name", 5, T.NAME_INVALID),
    ],
)
def test_fields_refuse_what_they_cannot_hold(name: str, value: object, entry: object) -> None:
    with pytest.raises(FieldError) as told:
        Tool(1).with_value(name, value)
    assert told.value.entry is entry


def test_elements_end_with_the_last_one_that_is_not_0() -> None:
    tool = Tool(1).with_value("parameters", 4, 3)
    assert tool.parameters == (0, 0, 0, 4)
    assert tool.with_value("parameters", 0, 3).parameters == ()
    assert tool.value("parameters", 59) == 0
