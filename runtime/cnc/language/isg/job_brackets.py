"""Commands of single axes: jobs of those outside of the channel, B[MC_MoveAbsolute Position=.. Velocity=.. Direction=..]
(programming manual, line 25538), and what axes of the channel do by themselves, A[MODULO ON MIN=0 MAX=360] (line 30039).

Several of them may stand in a block, beside everything else. They are taken out of its text before its grammar sees it; what is
in the bracket is read as the registration of the job says.
"""

from __future__ import annotations

import re

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.statements import StatementParser
from runtime.cnc.language.isg.words import Word, WordKind
from runtime.diagnostics.catalogue import axis_jobs, language, technology

PREFIX = "<axis>["
OF_PATH_AXES = ("MODULO", "POS_LIMIT", "SET_POSITION", "INDP_SYN", "INDP_ASYN")
_OPENING = re.compile(
    rf"\"(?:\\.|[^\"\\])*\"|'[^']*'|(?<![\w.@#$])([A-Z]\w*)[ \t]*\[[ \t]*(MC_\w*|(?:{'|'.join(OF_PATH_AXES)})(?![A-Za-z0-9_]))",
    re.IGNORECASE,
)


def job_name(function: str) -> str:
    """The name under which a job is registered. No # statement can be written like that."""
    return f"{PREFIX}{function}]"


def take_jobs(text: str, addresses: Addresses, statements: StatementParser) -> tuple[str, tuple[Word, ...]]:
    """Block text with the jobs blanked, and a word for each of them; raises LineError."""
    words: list[Word] = []
    at = 0
    while (match := _OPENING.search(text, at)) is not None:
        at = match.end()
        if match.group(1) is None:  # a quoted text
            continue
        start, name, function = match.start(), match.group(1), match.group(2)
        end = _closing(text, text.index("[", start))
        of_path = function.upper() in OF_PATH_AXES
        index = _path_axis(addresses, name, start + 1) if of_path else _axis(addresses, name, function, start + 1)
        job = statements.job(text, job_name(function), index, start, at, end)
        if job is None:
            known = ", ".join(known.removeprefix(PREFIX).rstrip("]") for known in statements.known(PREFIX + "MC_"))
            raise LineError(axis_jobs.JOB_FUNCTION, match.start(2) + 1, function=function, known=known)
        words.append(Word(WordKind.BRACKET, start + 1, index=index, name=name, job=job))
        at = end + 1
        text = text[:start] + " " * (at - start) + text[at:]
    return text, tuple(words)


def _closing(text: str, opening: int) -> int:
    depth = 0
    for place in range(opening, len(text)):
        depth += (text[place] == "[") - (text[place] == "]")
        if depth == 0:
            return place
    raise LineError(technology.BRACKET_OPEN, opening + 1)


def _path_axis(addresses: Addresses, name: str, column: int) -> int:
    """Channel index of an axis, whose name may be written small here; LineError for one that the channel does not have."""
    index = max(addresses.axis(name), addresses.axis(name.upper()))
    if index < 0:
        raise LineError(language.AXIS_UNKNOWN, column, axis=name, axes=", ".join(addresses.axes))
    return index


def _axis(addresses: Addresses, name: str, function: str, column: int) -> int:
    """Index among the axes outside of the channel; LineError for one that takes no job of the program."""
    for known in (name, name.upper()):
        if known in addresses.other_axes:
            return addresses.other_axes.index(known)
    if addresses.axis(name) >= 0:
        raise LineError(axis_jobs.JOB_PATH_AXIS, column, axis=name, function=function)
    if addresses.has_spindle(name):
        raise LineError(axis_jobs.JOB_OF_SPINDLE, column, axis=name, function=function)
    known = ", ".join(addresses.other_axes) or "none"
    raise LineError(axis_jobs.JOB_NO_AXIS, column, axis=name, function=function, known=known)
