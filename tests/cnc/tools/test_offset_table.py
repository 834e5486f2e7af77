"""The offset table: what was set is there again, and what is damaged is told."""

from __future__ import annotations

import sqlite3
from pathlib import Path

import pytest

from runtime.cnc.tools.offset_table import (
    COMMON,
    MemoryOffsets,
    OffsetTable,
    OffsetTableError,
    Register,
    SqliteOffsets,
    WorkOffset,
)
from runtime.diagnostics.catalogue import offsets as catalogue


@pytest.fixture(params=["memory", "file"])
def table(request: pytest.FixtureRequest, tmp_path: Path) -> OffsetTable:
    return MemoryOffsets() if request.param == "memory" else SqliteOffsets(tmp_path / "folder" / "offsets.db")


def test_what_was_set_is_there(table: OffsetTable) -> None:
    assert table.register("H", 7) == (0.0, 0.0)
    table.set_register("H", 7, Register(100.0, -0.1))
    table.set_register("D", 7, Register(5.0))
    table.set_register("H", 7, Register(101.0, -0.1))
    assert table.register("H", 7).value == pytest.approx(100.9)
    assert dict(table.registers()) == {("D", 7): (5.0, 0.0), ("H", 7): (101.0, -0.1)}
    table.set_work_offset(1, COMMON, "X", WorkOffset(3.0, 0.0))
    table.set_work_offset(1, 2, "X", WorkOffset(4.0, 300.0))
    table.set_work_offset(2, 2, "X", WorkOffset(9.0, 300.0))
    assert table.work_offsets(1) == {(COMMON, "X"): (3.0, 0.0), (2, "X"): (4.0, 300.0)}
    assert table.work_offsets(3) == {}


def test_two_processes_see_the_same(tmp_path: Path) -> None:
    one, other = SqliteOffsets(tmp_path / "offsets.db"), SqliteOffsets(tmp_path / "offsets.db")
    one.set_register("D", 3, Register(4.0))
    assert other.register("D", 3) == (4.0, 0.0)
    one.set_work_offset(2, 1, "Y", WorkOffset(1.0, 0.0))
    assert other.channels() == [2]
    one.close()
    other.close()


def test_damage_is_told(tmp_path: Path) -> None:
    file = tmp_path / "offsets.db"
    table = SqliteOffsets(file)
    connection = sqlite3.connect(file)
    connection.execute("INSERT INTO registers VALUES ('H', 1, 100000.0, 0.0)")
    connection.commit()
    with pytest.raises(OffsetTableError) as told:
        table.register("H", 1)
    assert told.value.problem.entry is catalogue.TABLE_FAILED
    connection.execute("PRAGMA user_version = 9")
    connection.commit()
    with pytest.raises(OffsetTableError) as told:
        SqliteOffsets(file)
    assert told.value.problem.entry is catalogue.TABLE_VERSION
    file.write_text("no database " * 100)
    with pytest.raises(OffsetTableError) as told:
        SqliteOffsets(file)
    assert told.value.problem.entry is catalogue.TABLE_FAILED
