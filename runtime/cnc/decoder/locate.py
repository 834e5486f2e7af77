"""From the line of a block back to its text: for errors found behind the decoder, where only file and line are known."""

from __future__ import annotations

import re
from contextlib import suppress
from dataclasses import replace

from runtime.cnc.decoder.dialects import AnyProgram, told
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.text import ProgramText
from runtime.diagnostics.errors import Place, Problem

_COMMENT = re.compile(r"\([^)]*\)?")


def located(program: AnyProgram, problem: Problem) -> Problem:
    """`problem` of a block with path, text and, if its values name an `axis`, the column of that axis' word."""
    problem = told(program, problem)
    place = problem.place
    unit = next((unit for unit in program.units() if unit.name == place.file), None)
    if unit is None or not place.line or place.column:
        return problem
    place = Place(unit.text.name, place.line)
    with suppress(ProgramError):  # the file was changed meanwhile: the line says enough
        text = _line(unit.text, place.line)
        place = Place(unit.text.name, place.line, _column(text, str(problem.values.get("axis", ""))), text)
    return replace(problem, place=place)


def _line(text: ProgramText, number: int) -> str:
    """The line with this number, counted from 1."""
    offset, line = text.start, ""
    for _ in range(number):
        line, offset = text.line(offset)
    return line


def _column(line: str, address: str) -> int:
    """Where the word of an address begins; 1 if it does not stand in the line."""
    without = _COMMENT.sub(lambda found: " " * len(found.group()), line)
    found = re.search(rf"(?<![A-Za-z_]){re.escape(address)}(?=[\s=\[.\d+-])", without) if address else None
    return found.start() + 1 if found else 1
