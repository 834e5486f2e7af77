"""What programs and operators have set, and what survives a restart: compensation registers, work offsets, common variables.

    register      H (length) or D (radius), number 1 … 999: geometry and wear, whose sum is used
    variable      channel, number: #500 to #599 of the NCT dialect
    work offset   channel, data set of the zero offsets (0: G53, 1: G54 …; COMMON is added to all of them), axis

The machine description gives the work offsets that a new machine begins with. One that was set holds from then on, until it is
set again or the description gives another value than it gave then: somebody has changed it on purpose. Lengths in mm, angles in
degrees. The file is read at every access to a register, so that what an operator has entered holds with the next H or D.
"""

from __future__ import annotations

import math
import sqlite3
from collections.abc import Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import NamedTuple, Protocol

from runtime.diagnostics.catalogue import offsets as catalogue
from runtime.diagnostics.errors import Place, TandemError

SCHEMA = 1
GREATEST_REGISTER = 999
GREATEST_GEOMETRY = 9999.999  # mm
GREATEST_WEAR = 16.380  # mm
COMMON = -1  # the data set whose offsets are added to those of all others
_PATIENCE = 2.0  # s that a writer waits for another one


class OffsetTableError(TandemError):
    """The table cannot be read or written."""


class Register(NamedTuple):
    """What a compensation register holds, mm."""

    geometry: float = 0.0
    wear: float = 0.0

    @property
    def value(self) -> float:
        """What is used."""
        return self.geometry + self.wear

    @property
    def within_limits(self) -> bool:
        """Whether both are numbers that a register can hold."""
        sizes = ((self.geometry, GREATEST_GEOMETRY), (self.wear, GREATEST_WEAR))
        return all(math.isfinite(value) and abs(value) <= limit + 1e-9 for value, limit in sizes)


class WorkOffset(NamedTuple):
    """A work offset that was set, and what the machine description gave at that time."""

    value: float
    described: float


class StrokeBox(NamedTuple):
    """The box of G22 in machine coordinates of the first three axes, mm; `outside`: that is forbidden, else the inside."""

    active: bool
    outside: bool
    low: tuple[float, ...]
    high: tuple[float, ...]


Registers = Mapping[tuple[str, int], Register]  # by "H" or "D" and number
WorkOffsets = Mapping[tuple[int, str], WorkOffset]  # by data set and name of the axis


class OffsetTable(Protocol):
    """Every call may raise OffsetTableError."""

    def register(self, kind: str, number: int) -> Register:
        """What register `number` of "H" or "D" holds; number 0, and what was never set, is zero."""

    def set_register(self, kind: str, number: int, register: Register) -> None:
        """Enter both values of a register, 1 … GREATEST_REGISTER."""

    def registers(self) -> Registers:
        """All that were set."""

    def work_offsets(self, channel: int) -> WorkOffsets:
        """All that were set in a channel (1, 2 …)."""

    def set_work_offset(self, channel: int, data_set: int, axis: str, offset: WorkOffset) -> None:
        """Enter the offset of an axis in a data set."""

    def stroke_box(self, channel: int) -> StrokeBox | None:
        """The box of the last G22, None as long as there was none."""

    def set_stroke_box(self, channel: int, box: StrokeBox) -> None:
        """Keep a box."""

    def variables(self, channel: int) -> Mapping[int, float]:
        """The common variables of programs that are kept, by number; vacant ones are not there."""

    def set_variables(self, channel: int, values: Mapping[int, float | None]) -> None:
        """Enter some of them together, None: vacant."""


class MemoryOffsets:
    """A table of its own, which ends with the process: for checks and simulations, which change nothing of the machine."""

    def __init__(
        self,
        registers: Registers | None = None,
        work: Mapping[int, WorkOffsets] | None = None,
        variables: Mapping[int, Mapping[int, float]] | None = None,
        boxes: Mapping[int, StrokeBox] | None = None,
    ) -> None:
        self._boxes = dict(boxes or {})
        self._registers = dict(registers or {})
        self._variables = {channel: dict(values) for channel, values in (variables or {}).items()}
        self._work = {channel: dict(offsets) for channel, offsets in (work or {}).items()}

    def copy(self) -> MemoryOffsets:
        """A table of its own that holds the same."""
        return MemoryOffsets(self._registers, self._work, self._variables, self._boxes)

    def stroke_box(self, channel: int) -> StrokeBox | None:
        return self._boxes.get(channel)

    def set_stroke_box(self, channel: int, box: StrokeBox) -> None:
        self._boxes[channel] = box

    def register(self, kind: str, number: int) -> Register:
        return self._registers.get((kind, number), Register())

    def set_register(self, kind: str, number: int, register: Register) -> None:
        self._registers[kind, number] = register

    def registers(self) -> Registers:
        return dict(sorted(self._registers.items()))

    def work_offsets(self, channel: int) -> WorkOffsets:
        return dict(self._work.get(channel, {}))

    def set_work_offset(self, channel: int, data_set: int, axis: str, offset: WorkOffset) -> None:
        self._work.setdefault(channel, {})[data_set, axis] = offset

    def variables(self, channel: int) -> Mapping[int, float]:
        return dict(self._variables.get(channel, {}))

    def set_variables(self, channel: int, values: Mapping[int, float | None]) -> None:
        kept = self._variables.setdefault(channel, {})
        for number, value in values.items():
            if value is None:
                kept.pop(number, None)
            else:
                kept[number] = value


class SqliteOffsets:
    """The table in a file, which is made if it is not there. Several processes may have it open."""

    def __init__(self, path: Path) -> None:
        self.path = path
        with self._told():
            path.parent.mkdir(parents=True, exist_ok=True)
            self._connection = sqlite3.connect(path, timeout=_PATIENCE, isolation_level=None)
            version = self._connection.execute("PRAGMA user_version").fetchone()[0]
            if version not in (0, SCHEMA):
                raise OffsetTableError(catalogue.TABLE_VERSION, Place(file=str(path)), version=version, known=SCHEMA)
            self._connection.execute(_REGISTERS)
            self._connection.execute(_WORK)
            self._connection.execute(_VARIABLES)
            self._connection.execute(_BOXES)
            self._connection.execute(f"PRAGMA user_version = {SCHEMA}")

    def register(self, kind: str, number: int) -> Register:
        with self._told():
            query = "SELECT geometry, wear FROM registers WHERE kind = ? AND number = ?"
            row = self._connection.execute(query, (kind, number)).fetchone()
            return Register() if row is None else _checked(Register(*map(float, row)))

    def set_register(self, kind: str, number: int, register: Register) -> None:
        with self._told():
            self._connection.execute("INSERT OR REPLACE INTO registers VALUES (?, ?, ?, ?)", (kind, number, *register))

    def registers(self) -> Registers:
        with self._told():
            rows = self._connection.execute("SELECT kind, number, geometry, wear FROM registers ORDER BY kind, number")
            return {(row[0], int(row[1])): _checked(Register(float(row[2]), float(row[3]))) for row in rows}

    def work_offsets(self, channel: int) -> WorkOffsets:
        with self._told():
            query = "SELECT data_set, axis, value, described FROM work WHERE channel = ?"
            rows = self._connection.execute(query, (channel,))
            return {(int(row[0]), row[1]): WorkOffset(float(row[2]), float(row[3])) for row in rows}

    def set_work_offset(self, channel: int, data_set: int, axis: str, offset: WorkOffset) -> None:
        with self._told():
            row = (channel, data_set, axis, *offset)
            self._connection.execute("INSERT OR REPLACE INTO work VALUES (?, ?, ?, ?, ?)", row)

    def variables(self, channel: int) -> Mapping[int, float]:
        with self._told():
            rows = self._connection.execute("SELECT number, value FROM variables WHERE channel = ?", (channel,))
            return {int(row[0]): float(row[1]) for row in rows}

    def set_variables(self, channel: int, values: Mapping[int, float | None]) -> None:
        with self._told(), self._connection:
            self._connection.execute("BEGIN IMMEDIATE")
            for number, value in values.items():
                if value is None:
                    self._connection.execute(
                        "DELETE FROM variables WHERE channel = ? AND number = ?", (channel, number)
                    )
                else:
                    row = (channel, number, value)
                    self._connection.execute("INSERT OR REPLACE INTO variables VALUES (?, ?, ?)", row)

    def stroke_box(self, channel: int) -> StrokeBox | None:
        with self._told():
            query = "SELECT active, outside, x0, y0, z0, x1, y1, z1 FROM boxes WHERE channel = ?"
            row = self._connection.execute(query, (channel,)).fetchone()
            if row is None:
                return None
            places = tuple(float(place) for place in row[2:])
            return StrokeBox(bool(row[0]), bool(row[1]), places[:3], places[3:])

    def set_stroke_box(self, channel: int, box: StrokeBox) -> None:
        with self._told():
            row = (channel, int(box.active), int(box.outside), *box.low, *box.high)
            self._connection.execute("INSERT OR REPLACE INTO boxes VALUES (?, ?, ?, ?, ?, ?, ?, ?, ?)", row)

    def channels(self) -> list[int]:
        """The channels of which something is kept."""
        query = "SELECT channel FROM work UNION SELECT channel FROM variables UNION SELECT channel FROM boxes"
        with self._told():
            return [int(row[0]) for row in self._connection.execute(query)]

    def close(self) -> None:
        self._connection.close()

    @contextmanager
    def _told(self) -> Iterator[None]:
        """What SQLite, the file system or a damaged row says becomes an OffsetTableError."""
        try:
            yield
        except (sqlite3.Error, OSError, ValueError, TypeError) as error:
            reason = getattr(error, "strerror", None) or str(error)
            raise OffsetTableError(catalogue.TABLE_FAILED, Place(file=str(self.path)), reason=reason) from None


class OffsetsOutOfReach:
    """A table that could not be opened: every access tells why: nothing moves with wrong offsets."""

    def __init__(self, error: OffsetTableError) -> None:
        self._error = error

    def register(self, kind: str, number: int) -> Register:
        raise self._error

    def set_register(self, kind: str, number: int, register: Register) -> None:
        raise self._error

    def registers(self) -> Registers:
        raise self._error

    def work_offsets(self, channel: int) -> WorkOffsets:
        raise self._error

    def set_work_offset(self, channel: int, data_set: int, axis: str, offset: WorkOffset) -> None:
        raise self._error

    def stroke_box(self, channel: int) -> StrokeBox | None:
        raise self._error

    def set_stroke_box(self, channel: int, box: StrokeBox) -> None:
        raise self._error

    def variables(self, channel: int) -> Mapping[int, float]:
        raise self._error

    def set_variables(self, channel: int, values: Mapping[int, float | None]) -> None:
        raise self._error


def _checked(register: Register) -> Register:
    """ValueError for values that no register can hold: somebody has written into the file."""
    if not register.within_limits:
        raise ValueError(f"a register holds {register.geometry:g} and {register.wear:g} mm")
    return register


_REGISTERS = """CREATE TABLE IF NOT EXISTS registers (
    kind TEXT NOT NULL CHECK (kind IN ('H', 'D')), number INTEGER NOT NULL, geometry REAL NOT NULL, wear REAL NOT NULL,
    PRIMARY KEY (kind, number))"""
_BOXES = """CREATE TABLE IF NOT EXISTS boxes (
    channel INTEGER PRIMARY KEY, active INTEGER NOT NULL, outside INTEGER NOT NULL, x0 REAL NOT NULL, y0 REAL NOT NULL,
    z0 REAL NOT NULL, x1 REAL NOT NULL, y1 REAL NOT NULL, z1 REAL NOT NULL)"""
_WORK = """CREATE TABLE IF NOT EXISTS work (
    channel INTEGER NOT NULL, data_set INTEGER NOT NULL, axis TEXT NOT NULL, value REAL NOT NULL, described REAL NOT NULL,
    PRIMARY KEY (channel, data_set, axis))"""
_VARIABLES = """CREATE TABLE IF NOT EXISTS variables (
    channel INTEGER NOT NULL, number INTEGER NOT NULL, value REAL NOT NULL, PRIMARY KEY (channel, number))"""
