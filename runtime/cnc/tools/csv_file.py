"""Tools in CSV files, for spreadsheets: a row per tool, a column per datum (`number`, `radius`, `offset.X`, `parameters[3]` …).

`unit` of a row is mm or inch, mm without one. Cells may carry units of their own ("5 mm"); an empty one leaves its datum alone.
"""

from __future__ import annotations

import csv
import io
from collections.abc import Callable, Iterable
from pathlib import Path

from runtime.cnc.tools.list_file import ReadTools, read_text
from runtime.cnc.tools.tool import FIELDS, GREATEST_NUMBER, FieldError, Kind, Tool
from runtime.cnc.tools.written import Datum, ToolAxes, datum_of, name_of, with_written
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place, Problem

_NUMBER, _UNIT = "number", "unit"
_UNITS = {"": False, "mm": False, "inch": True}


def read_csv(path: Path, axes: ToolAxes) -> ReadTools:
    """The tools of a CSV file. Raises ToolTableError if it cannot be read at all."""
    return parse_csv(read_text(path), axes, str(path))


def parse_csv(text: str, axes: ToolAxes, file: str = "-") -> ReadTools:
    """The tools of a CSV text; every mistake in it is told, with line and column (counted in cells)."""
    problems: list[Problem] = []
    tools: dict[int, Tool] = {}

    def refuse(line: int, cell: int, entry: ErrorEntry, **values: object) -> None:
        problems.append(Problem(entry, values, Place(file, line, cell)))

    rows = csv.reader(io.StringIO(text), delimiter=_delimiter(text))
    head = [name.strip() for name in next(rows, [])]
    columns = _columns(head, axes, refuse)
    if problems:
        return ReadTools((), tuple(problems))
    for row in rows:
        if not any(cell.strip() for cell in row):
            continue
        if len(row) != len(head):
            refuse(rows.line_num, 0, catalogue.CSV_CELLS, count=len(row), expected=len(head))
            continue
        tool = _tool(row, head, columns, axes, lambda *told, **values: refuse(rows.line_num, *told, **values))
        if tool is None:
            continue
        if tool.number in tools:
            refuse(rows.line_num, head.index(_NUMBER) + 1, catalogue.TOOL_TWICE, number=tool.number)
        tools[tool.number] = tool
    return ReadTools(tuple(tools[number] for number in sorted(tools)), tuple(problems))


def _delimiter(text: str) -> str:
    """A comma, or the semicolon that spreadsheets write where the comma is the decimal point."""
    head = text.partition("\n")[0]
    return ";" if head.count(";") > head.count(",") else ","


def _columns(head: list[str], axes: ToolAxes, refuse: Callable[..., None]) -> dict[int, Datum]:
    """The datum of each column but `number` and `unit`."""
    columns: dict[int, Datum] = {}
    if _NUMBER not in head:
        refuse(1, 1, catalogue.CSV_NUMBER)
    for place, name in enumerate(head):
        if name in head[:place]:
            refuse(1, place + 1, catalogue.COLUMN_TWICE, name=name)
        if name in (_NUMBER, _UNIT):
            continue
        try:
            columns[place] = datum_of(name, axes)
        except FieldError as error:
            refuse(1, place + 1, error.entry, **error.values)
    return columns


def _tool(
    row: list[str], head: list[str], columns: dict[int, Datum], axes: ToolAxes, refuse: Callable[..., None]
) -> Tool | None:
    number = row[head.index(_NUMBER)].strip()
    if not number.isdecimal() or not 1 <= int(number) <= GREATEST_NUMBER:
        refuse(head.index(_NUMBER) + 1, catalogue.TOOL_NUMBER, value=number, limit=GREATEST_NUMBER)
        return None
    unit = row[head.index(_UNIT)].strip() if _UNIT in head else ""
    if unit not in _UNITS:
        refuse(head.index(_UNIT) + 1, catalogue.UNIT_WRONG, field=_UNIT, value=unit, units="mm, inch")
        return None
    tool = Tool(int(number))
    for place, datum in columns.items():
        if not row[place].strip():
            continue
        try:
            tool = with_written(tool, datum, row[place], axes, inch=_UNITS[unit])
        except FieldError as error:
            refuse(place + 1, error.entry, **error.values)
    return tool


def format_csv(tools: Iterable[Tool], axes: ToolAxes) -> str:
    """The tools as CSV, in mm; columns of elements as far as some tool has one."""
    tools = list(tools)
    columns: list[Datum] = []
    for name, field in FIELDS.items():
        if not field.count:
            columns.append(Datum(field))
        else:
            used = {i for tool in tools for i, element in enumerate(getattr(tool, name)) if element != 0.0}
            columns += [Datum(field, i) for i in sorted(used)]
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow([_NUMBER, _UNIT, *(name_of(datum, axes) for datum in columns)])
    for tool in tools:
        writer.writerow([tool.number, "mm", *(_cell(tool, datum) for datum in columns)])
    return out.getvalue()


def _cell(tool: Tool, datum: Datum) -> str:
    value = tool.value(datum.field.name, datum.index)
    return str(int(value)) if datum.field.kind is Kind.FLAG else str(value)
