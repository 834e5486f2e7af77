"""A problem as a terminal shows it: with the text of its line, also where it comes from behind the decoder."""

from __future__ import annotations

from contextlib import suppress
from dataclasses import replace
from itertools import islice

from runtime.diagnostics.errors import Problem


def explained(problem: Problem) -> str:
    """`Problem.explained`; a line that the problem does not bring along is read from its file, if that can be found."""
    place = problem.place
    if place.file and place.line and not place.text:
        with suppress(OSError), open(place.file, encoding="utf-8", errors="replace") as file:
            text = next(islice(file, place.line - 1, None), "").rstrip("\r\n")
            problem = replace(problem, place=replace(place, text=text))
    return problem.explained()
