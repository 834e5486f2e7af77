"""The tool table: where the records of the tools live, in memory or in a SQLite file.

The file is read at every access, so that what `tandem tools set` or another program has written holds with the next D word. It
has one row per tool; fields with several elements are JSON lists.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path
from typing import Any, Protocol

from runtime.cnc.tools.tool import FIELDS, Tool
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import Place, Problem, TandemError

SCHEMA = 1
_PATIENCE = 2.0  # s that a writer waits for another one


class ToolTableError(TandemError):
    """The table, or a file with tools, cannot be read or written."""

    @classmethod
    def of(cls, problems: Sequence[Problem]) -> ToolTableError:
        """All that is wrong in a file."""
        error = cls(problems[0].entry, problems[0].place, **problems[0].values)
        error.problems = tuple(problems)
        return error


class ToolTable(Protocol):
    """Tools by their number. Every call may raise ToolTableError."""

    def get(self, number: int) -> Tool | None:
        """The tool of a number, None if there is none."""

    def put(self, *tools: Tool) -> None:
        """Enter tools; each replaces the one with its number. All of them or none."""

    def remove(self, number: int) -> bool:
        """Take a tool out; whether it was there."""

    def all(self) -> list[Tool]:
        """Every tool, in the order of the numbers."""


class MemoryTools:
    """A table of its own, which ends with the process: for checks and simulations, which change nothing of the machine."""

    def __init__(self, tools: Iterable[Tool] = ()) -> None:
        self._tools = {tool.number: tool for tool in tools}

    def get(self, number: int) -> Tool | None:
        return self._tools.get(number)

    def put(self, *tools: Tool) -> None:
        self._tools |= {tool.number: tool for tool in tools}

    def remove(self, number: int) -> bool:
        return self._tools.pop(number, None) is not None

    def all(self) -> list[Tool]:
        return [self._tools[number] for number in sorted(self._tools)]


class SqliteTools:
    """The table in a file, which is made if it is not there, with the tools that `initial` gives. Several processes may have
    it open."""

    def __init__(self, path: Path, initial: Callable[[], Iterable[Tool]] = tuple) -> None:
        self.path = path
        with self._told():
            path.parent.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(path, timeout=_PATIENCE, isolation_level=None)
            version = self._connection.execute("PRAGMA user_version").fetchone()[0]
            if version not in (0, SCHEMA):
                raise ToolTableError(catalogue.TABLE_VERSION, Place(file=str(path)), version=version, known=SCHEMA)
            if version == 0:
                self._make(list(initial()))

    def _make(self, tools: list[Tool]) -> None:
        columns = ", ".join(f"{name} NOT NULL" for name in FIELDS)
        with self._transaction():
            if self._connection.execute("PRAGMA user_version").fetchone()[0] == SCHEMA:
                return  # another process was faster
            self._connection.execute(f"CREATE TABLE tools (number INTEGER PRIMARY KEY, {columns})")
            self._insert(tools)
            self._connection.execute(f"PRAGMA user_version = {SCHEMA}")

    def get(self, number: int) -> Tool | None:
        with self._told():
            row = self._connection.execute(f"{_SELECT} WHERE number = ?", (number,)).fetchone()
            return None if row is None else _tool(row)

    def put(self, *tools: Tool) -> None:
        with self._told(), self._transaction():
            self._insert(tools)

    def replace(self, *tools: Tool) -> None:
        """These tools are all that there are."""
        with self._told(), self._transaction():
            self._connection.execute("DELETE FROM tools")
            self._insert(tools)

    def _insert(self, tools: Iterable[Tool]) -> None:
        marks = ", ".join("?" for _ in range(len(FIELDS) + 1))
        self._connection.executemany(f"INSERT OR REPLACE INTO tools VALUES ({marks})", map(_row, tools))

    def remove(self, number: int) -> bool:
        with self._told():
            return self._connection.execute("DELETE FROM tools WHERE number = ?", (number,)).rowcount > 0

    def all(self) -> list[Tool]:
        with self._told():
            return [_tool(row) for row in self._connection.execute(f"{_SELECT} ORDER BY number")]

    def close(self) -> None:
        self._connection.close()

    @contextmanager
    def _transaction(self) -> Iterator[None]:
        """All or nothing, also if the process is killed."""
        self._connection.execute("BEGIN IMMEDIATE")
        try:
            yield
            self._connection.execute("COMMIT")
        except BaseException:
            if self._connection.in_transaction:  # a full disk has ended it already
                self._connection.execute("ROLLBACK")
            raise

    @contextmanager
    def _told(self) -> Iterator[None]:
        """What SQLite, the file system or a damaged row says becomes a ToolTableError."""
        try:
            yield
        except (sqlite3.Error, OSError, ValueError, TypeError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise ToolTableError(catalogue.TABLE_FAILED, Place(file=str(self.path)), reason=reason) from None


_SELECT = f"SELECT number, {', '.join(FIELDS)} FROM tools"


def _row(tool: Tool) -> tuple[Any, ...]:
    values = (getattr(tool, name) for name in FIELDS)
    return (tool.number, *(json.dumps(value) if isinstance(value, tuple) else value for value in values))


def _tool(row: tuple[Any, ...]) -> Tool:
    """A tool from a row; ValueError for values that its fields cannot have."""
    made: dict[str, Any] = {}
    for (name, field), value in zip(FIELDS.items(), row[1:], strict=True):
        if field.count:
            made[name] = tuple(field.checked(element) for element in json.loads(value))[: field.count]
        else:
            made[name] = field.checked(value)
    return Tool(row[0], **made)
