"""Tool lists: ASCII files with a line `wz[<number>].<datum> <value>` per datum, as ISG controls load them at their start.

Lengths in them are whole numbers of 0.1 µm, or of 0.0001 inch where the tool says `mass_einheit 1`; offsets of rotary
axes 0.0001°.
"""

from __future__ import annotations

import re
from collections.abc import Iterable
from dataclasses import dataclass
from pathlib import Path

from runtime.cnc.tools.table import ToolTableError
from runtime.cnc.tools.tool import FIELDS, GREATEST_NUMBER, Field, FieldError, Kind, Tool
from runtime.cnc.tools.written import INCH, expect_radius
from runtime.diagnostics.catalogue import tools as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place, Problem

LARGEST_LIST = 10_000_000  # bytes
_LINE = re.compile(r"\s*(?P<key>[^\s#;]+)(?:\s+(?P<value>[^\s#;]+))?")
_KEY = re.compile(r"wz\[(\d+)\]\.([a-z_.]+)(?:\[(\d+)\])?(\.[a-z_.\[\]0-9]+)?\Z")
_UNIT = "mass_einheit"

_BY_LIST = {field.listed: field for field in FIELDS.values() if field.listed}
_REFUSED = {  # what other controls do with a tool, and a tool without them would be another tool
    "gear_ratio_num": ("gear ratios of tools", (0.0, 1.0)),
    "gear_ratio_denom": ("gear ratios of tools", (0.0, 1.0)),
    "gear_inv_direction": ("gears of tools", (0.0,)),
    "gear_inv_direction_no_stopm": ("gears of tools", (0.0,)),
    "path": ("radii of several paths", (0.0,)),
}
_IGNORED = {
    "grinding_max_infeed": "there is no online tool compensation",
    "grinding_angle": "there is no online tool compensation",
    "linkpoint_data": "there is no collision model",
    "gobject": "there is no collision model",
}


@dataclass(frozen=True, slots=True)
class ReadTools:
    """What a file has given: tools in the order of their numbers, and what is wrong in it or has no effect."""

    tools: tuple[Tool, ...]
    problems: tuple[Problem, ...] = ()
    warnings: tuple[Problem, ...] = ()


def read_tool_list(path: Path, rotary: frozenset[int] = frozenset()) -> ReadTools:
    """The tools of a list file; `rotary`: channel indices of axes whose offsets are angles. Raises ToolTableError."""
    return parse_tool_list(read_text(path), str(path), rotary)


def read_text(path: Path) -> str:
    """The text of a file. A text that is no UTF-8 is taken as Latin-1, as older lists are. Raises ToolTableError."""
    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_LIST + 1)
    except OSError as error:
        reason = error.strerror or str(error)
        raise ToolTableError(catalogue.LIST_UNREADABLE, Place(file=str(path)), reason=reason) from None
    if len(data) > LARGEST_LIST or b"\0" in data:
        reason = "it is no text" if b"\0" in data else f"it is larger than {LARGEST_LIST} bytes"
        raise ToolTableError(catalogue.LIST_UNREADABLE, Place(file=str(path)), reason=reason)
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("latin-1")


def parse_tool_list(text: str, file: str = "-", rotary: frozenset[int] = frozenset()) -> ReadTools:
    """The tools of a list; every mistake in it is told, with its line."""
    reading = _Reading(file, rotary)
    for number, line in enumerate(text.splitlines(), start=1):
        reading.line(number, line)
    return reading.result()


class _Reading:
    """A list while it is read: the data of each tool first, because their unit may stand behind them."""

    def __init__(self, file: str, rotary: frozenset[int]) -> None:
        self._file, self._rotary = file, rotary
        self._data: dict[int, dict[tuple[str, int], tuple[float, Place]]] = {}
        self._inch: dict[int, bool] = {}
        self._first: dict[str, int] = {}  # line of a key
        self._problems: list[Problem] = []
        self._warnings: list[Problem] = []

    def line(self, number: int, text: str) -> None:
        match = _LINE.match(text)
        if match is None:
            return
        key = match["key"]
        place = Place(self._file, number, match.start("key") + 1, text)

        def refuse(entry: ErrorEntry, **values: object) -> None:
            self._problems.append(Problem(entry, {"key": key, **values}, place))

        parts = _KEY.match(key.lower())
        name = parts[2] if parts else ""
        if parts is None or not self._known(name, parts[4]):
            refuse(catalogue.LIST_KEY, known=", ".join((*_BY_LIST, _UNIT)))
            return
        if key.lower() in self._first:
            refuse(catalogue.LIST_TWICE, first=self._first[key.lower()])
            return
        self._first[key.lower()] = number
        tool = int(parts[1])
        if not 1 <= tool <= GREATEST_NUMBER:
            refuse(catalogue.TOOL_NUMBER, value=parts[1], limit=GREATEST_NUMBER)
            return
        what = _IGNORED.get(name.split(".")[0])
        if what is not None:
            self._warnings.append(Problem(catalogue.LIST_IGNORED, {"key": key, "what": what}, place))
            return
        value = _number(match["value"] or "")
        if value is None:
            refuse(catalogue.LIST_VALUE, value=match["value"] or "")
            return
        if name in _REFUSED:
            what, allowed = _REFUSED[name]
            if value not in allowed:
                refuse(catalogue.LIST_UNSUPPORTED, what=what)
            return
        data = self._data.setdefault(tool, {})
        if name == _UNIT:
            if value not in (0.0, 1.0):
                refuse(catalogue.VALUE_RANGE, field=_UNIT, value=value, least=0, greatest=1)
            self._inch[tool] = value == 1.0
            return
        field, index = _BY_LIST[name], int(parts[3] or 0)
        if (parts[3] is not None) != bool(field.count) or index >= max(field.count, 1):
            refuse(catalogue.ELEMENT_RANGE, field=name, last=max(field.count - 1, 0))
            return
        data[field.name, index] = (value * field.factor, place)

    def _known(self, name: str, further: str | None) -> bool:
        if name.split(".")[0] in _IGNORED or name in _REFUSED:
            return True
        return further is None and (name in _BY_LIST or name == _UNIT)

    def result(self) -> ReadTools:
        tools = []
        for number in sorted(self._data):
            tool = Tool(number, valid=False)  # as a list of the other control has it: a tool is valid if it says so
            for (name, index), (value, place) in self._data[number].items():
                field = FIELDS[name]
                try:
                    tool = tool.with_value(name, value * self._unit(number, field, index), index)
                    expect_radius(tool, name)
                except FieldError as error:
                    self._problems.append(Problem(error.entry, error.values, place))
            tools.append(tool)
        return ReadTools(tuple(tools), tuple(self._problems), tuple(self._warnings))

    def _unit(self, number: int, field: Field, index: int) -> float:
        angle = field.kind is Kind.OFFSET and index in self._rotary
        length = field.kind in (Kind.LENGTH, Kind.OFFSET) and not angle
        return INCH if length and self._inch.get(number, False) else 1.0


def _number(text: str) -> float | None:
    try:
        return float(int(text, 16)) if text.lower().startswith("0x") else float(text)
    except ValueError:
        return {"true": 1.0, "false": 0.0}.get(text.lower())


def format_tool_list(tools: Iterable[Tool]) -> str:
    """A list of tools, in mm; names, which lists do not have, are remarks."""
    lines = ["# Tool data: lengths in 0.1 µm, angles in 0.0001 degrees, speeds in 0.001 degrees/s"]
    for tool in tools:
        lines += ["#", f"# Tool {tool.number}" + (f": {tool.name}" if tool.name else "")]
        for name, field in FIELDS.items():
            value = getattr(tool, name)
            if not field.listed:
                continue
            if field.count:
                elements = [(f"wz[{tool.number}].{field.listed}[{i}]", v) for i, v in enumerate(value) if v != 0.0]
            else:
                elements = [(f"wz[{tool.number}].{field.listed}", value)]
            lines += [f"{key:<32}{_listed(field, element)}" for key, element in elements]
        lines.append(f"{f'wz[{tool.number}].{_UNIT}':<32}0")
    return "\n".join(lines) + "\n"


def _listed(field: Field, value: float) -> str:
    number = value / field.factor
    whole = field.kind is not Kind.NUMBER
    return str(round(number)) if whole else repr(float(number))
