"""The exceptions of the language and the decoder."""

from __future__ import annotations

from collections.abc import Sequence

from runtime.diagnostics.errors import ErrorEntry, Place, Problem, TandemError


class ProgramError(TandemError):
    """Something is wrong in an NC program; `problems` holds everything that was found, at least one."""

    problems: tuple[Problem, ...]

    def __init__(self, entry: ErrorEntry, place: Place = Place(), **values: object) -> None:  # noqa: B008 - frozen
        super().__init__(entry, place, **values)
        self.problems = (self.problem,)


class ProgramErrors(ProgramError):  # noqa: N818 - it is many
    """Several errors of one program, in the order of its lines; `problem` is the first of them."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        first = problems[0]
        super().__init__(first.entry, first.place, **first.values)
        self.problems = tuple(problems)


class LineError(Exception):
    """Something is wrong in a line; `column` counts from 1. The reader of the file adds name and line."""

    def __init__(self, entry: ErrorEntry, column: int, **values: object) -> None:
        super().__init__(entry.id, column)
        self.entry = entry
        self.column = column
        self.values = values


class CalculationError(Exception):
    """An expression has no value. Whoever executes the block adds the place; `name` is what to look for in its text."""

    def __init__(self, entry: ErrorEntry, name: str, /, **values: object) -> None:
        super().__init__(entry.id, name)
        self.entry = entry
        self.name = name
        self.values = {"name": name, **values}
