"""The register of all channel parameters: reading, errors and documentation take what stands here, and nothing else."""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass
from difflib import get_close_matches

from runtime.config.channel import table_configuration, table_further, table_motion, table_programs
from runtime.config.channel.key import Key, parse_key, pattern_of
from runtime.config.channel.parameter import ChannelParameter

PARAMETERS: tuple[ChannelParameter, ...] = tuple(
    sorted(
        (*table_configuration.ROWS, *table_motion.ROWS, *table_programs.ROWS, *table_further.ROWS),
        key=lambda parameter: parameter.number,
    )
)
_BRACKET = re.compile(r"\[(\w+)\]")


@dataclass(frozen=True, slots=True)
class Spelling:
    """A name under which a parameter can be written; `indices` are letters, or numbers that have to stand there."""

    parameter: ChannelParameter
    name: str

    @property
    def indices(self) -> list[str]:
        return _BRACKET.findall(self.name)


@dataclass(frozen=True, slots=True)
class Found:
    """A key and its parameter: `key` is the key under the parameter's main name."""

    parameter: ChannelParameter
    key: Key


@dataclass(frozen=True, slots=True)
class BadIndex:
    """A key whose index `position` (a step of the key) is not within first…last."""

    parameter: ChannelParameter
    position: int
    first: int
    last: int


def _pattern(name: str) -> str:
    return _BRACKET.sub("[]", name)


def _spellings() -> Iterator[tuple[str, Spelling]]:
    for parameter in PARAMETERS:
        for name in (parameter.name, *parameter.aliases):
            yield _pattern(name), Spelling(parameter, name)


SPELLINGS: dict[str, Spelling] = dict(_spellings())
GROUPS: frozenset[str] = frozenset(  # every beginning of a pattern: `spindel`, `spindel[]`
    pattern[: match.start()] for pattern in SPELLINGS for match in re.finditer(r"\.|\[\]", pattern)
)


def look_up(key: Key) -> Found | BadIndex | None:
    """The parameter of a written key; None if there is none."""
    spelling = SPELLINGS.get(pattern_of(key))
    if spelling is None:
        return None
    parameter = spelling.parameter
    letters = _BRACKET.findall(parameter.name)
    limits = dict(zip(letters, parameter.index, strict=True))
    given: dict[str, int] = {}
    positions = [position for position, step in enumerate(key) if isinstance(step, int)]
    for position, wanted in zip(positions, spelling.indices, strict=True):
        index = int(key[position])
        first, last = (int(wanted), int(wanted)) if wanted.isdigit() else limits.get(wanted, (0, 0))
        if not first <= index <= last:
            return BadIndex(parameter, position, first, last)
        given[wanted] = index
    name = _BRACKET.sub(lambda match: f"[{given.get(match[1], 0)}]", parameter.name)
    return Found(parameter, parse_key(name) or key)


def suggestion(key: Key) -> str:
    """The known name nearest to a wrong key, as an addition to a message; empty if none is near."""
    wrong = pattern_of(key).lower()
    last = wrong.rpartition(".")[2]
    same_last = [pattern for pattern in SPELLINGS if pattern.rpartition(".")[2] == last]  # in another group
    close = get_close_matches(wrong, same_last or SPELLINGS, n=1) or same_last[:1]
    return f"; do you mean {SPELLINGS[close[0]].name!r}?" if close else ""


def group_suggestion(group: Key, wrong: str) -> str:
    """The name nearest to a wrong one within a group of parameters (or on top), as an addition to a message."""
    beginning = pattern_of(group) + "." if group else ""
    known = {
        pattern[len(beginning) :].split(".")[0].split("[")[0] for pattern in SPELLINGS if pattern.startswith(beginning)
    }
    close = get_close_matches(wrong.lower(), sorted(known), n=1)
    return f"; do you mean {close[0]!r}?" if close else ""
