"""What a user meets when something is wrong: a catalogue entry, the values that fill its text, and the place."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from enum import IntEnum

WINDOW = 120  # characters of a long line that are shown around a place


class Severity(IntEnum):
    """How bad it is; the order is the order of badness."""

    MESSAGE = 0
    WARNING = 1
    ERROR = 2
    FATAL = 3


class Reaction(IntEnum):
    """What the machine does because of the error; the strongest one wins."""

    NONE = 0  # told, nothing else
    REFUSE = 1  # the program, order or configuration is not taken; nothing moves
    STOP_AT_BLOCK_END = 2  # what is known is finished, then standstill
    STOP_ON_PATH = 3  # feed to zero within the axis limits, position kept, program aborted
    QUICK_STOP = 4  # every axis brakes by itself (drive quick stop), then disabled


@dataclass(frozen=True, slots=True)
class ErrorEntry:
    """One row of the catalogue.

    `text` is a `str.format` template over the error's values. `remedy` tells the user what to do. `source` names the manual
    line or standard clause where the id comes from one; our own ids are 300000 and up.
    """

    id: int
    text: str
    severity: Severity = Severity.ERROR
    reaction: Reaction = Reaction.REFUSE
    remedy: str = ""
    source: str = ""


@dataclass(frozen=True, slots=True)
class Place:
    """Where in a program or a configuration file: lines and columns count from 1, 0 is unknown."""

    file: str = ""
    line: int = 0
    column: int = 0
    text: str = ""  # the line itself, for the marker under the place

    def __str__(self) -> str:
        parts = [self.file or "-"]
        if self.line:
            parts.append(str(self.line))
            if self.column:
                parts.append(str(self.column))
        return ":".join(parts)


@dataclass(frozen=True, slots=True)
class Problem:
    """An error that happened: the entry, its values, its place."""

    entry: ErrorEntry
    values: Mapping[str, object] = field(default_factory=dict)
    place: Place = Place()

    @property
    def text(self) -> str:
        """The message, without place and id."""
        return self.entry.text.format(**self.values)

    def __str__(self) -> str:
        """`file:line:column: id: text`, the form of `tandem check`; without a place `id: text`."""
        place = f"{self.place}: " if self.place.file or self.place.line else ""
        return f"{place}{self.entry.id}: {self.text}"

    @property
    def hint(self) -> str:
        """The remedy; none if it names values that stayed behind in the process of the error."""
        try:
            return self.entry.remedy.format(**self.values)
        except KeyError:
            return ""

    def explained(self) -> str:
        """The message, then the program line with a marker under the place, then the remedy; several lines."""
        lines = [str(self)]
        if self.place.text:
            first = max(0, self.place.column - 1 - WINDOW // 2)  # of a long line, the part around the place
            lines.append("    " + self.place.text[first : first + WINDOW])
            if self.place.column:
                before = self.place.text[first : self.place.column - 1]
                lines.append("    " + "".join("\t" if char == "\t" else " " for char in before) + "^")
        if self.hint:
            lines.append(f"    hint: {self.hint}")
        return "\n".join(lines)


class TandemError(Exception):
    """Base of the exceptions that carry a problem; each stage raises its own subclass."""

    def __init__(self, entry: ErrorEntry, place: Place = Place(), **values: object) -> None:
        self.problem = Problem(entry, values, place)
        self.problems: tuple[Problem, ...] = (self.problem,)  # all of them, where a stage reports more than one
        super().__init__(str(self.problem))
