"""Channel parameters from the YAML tree and from a list file: keys looked up, values checked, mistakes at their place.

    YAML tree ─ entries ─┐
                         ├─▶ look-up in the register ─▶ value ─▶ in use? ─▶ ChannelParameters ─▶ checks
    list file ─ entries ─┘

A parameter may stand in one of the two only, and once.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

from runtime.config.channel.checks import check
from runtime.config.channel.key import Key, key_text, parse_key, pattern_of
from runtime.config.channel.list_file import ListLine, parse_list, read_list, value_text
from runtime.config.channel.parameter import ChannelParameter, Use, Value
from runtime.config.channel.parameters import ChannelParameters
from runtime.config.channel.register import (
    GROUPS,
    SPELLINGS,
    BadIndex,
    Found,
    group_suggestion,
    look_up,
    suggestion,
)
from runtime.config.channel.values import ValueMistakeError, value_of, value_of_text
from runtime.config.contradictions import Contradiction, ContradictionError, Location
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.errors import ErrorEntry, Place, Problem

_INDEX = re.compile(r"[0-9]{1,9}\Z")


@dataclass(frozen=True, slots=True)
class _Entry:
    """A key with what was given for it, in YAML (`location`) or in a list (`line`)."""

    key: Key
    given: object
    location: Location = ()
    line: ListLine | None = None

    def mistake(self, entry: ErrorEntry, values: Mapping[str, object], *, at_key: bool = False) -> Contradiction:
        if self.line is None:
            return Contradiction(entry, self.location, values, at_key)
        return Contradiction(entry, (), values, at_key, self.line.key_place if at_key else self.line.place)

    @property
    def origin(self) -> tuple[Location, Place | None]:
        return (self.location, None) if self.line is None else ((), self.line.place)


def read_parameters(tree: Mapping[object, object], list_path: Path | None, folder: Path | None) -> ChannelParameters:
    """The parameters of a channel; relative folders count from `folder`, or from where the list file stands.

    Raises ContradictionError with every mistake; locations count from the tree.
    """
    mistakes: list[Contradiction] = []
    entries = list(_tree_entries(tree, (), (), mistakes))
    if list_path is not None:
        try:
            text = read_list(list_path)
        except OSError as error:
            reason = error.strerror or str(error)
            raise ContradictionError(
                [Contradiction(errors.LIST_NOT_READABLE, (), {"reason": reason}, place=Place(str(list_path)))]
            ) from None
        mistakes += (_of_problem(problem) for problem in text.problems)
        entries += (_Entry(line.key, None, (), line) for line in text.lines)
    folders = {True: folder, False: None if list_path is None else list_path.parent}
    return _parameters(entries, mistakes, folders)


def parse_parameters(text: str, file: str = "-") -> ChannelParameters:
    """The parameters of a list text alone; raises ContradictionError."""
    parsed = parse_list(text, file)
    entries = [_Entry(line.key, None, (), line) for line in parsed.lines]
    return _parameters(entries, [_of_problem(problem) for problem in parsed.problems], {})


def _of_problem(problem: Problem) -> Contradiction:
    return Contradiction(problem.entry, (), problem.values, place=problem.place)


def _tree_entries(node: object, key: Key, location: Location, mistakes: list[Contradiction]) -> Iterator[_Entry]:
    """Every value of the tree; what is no parameter is a mistake at the first key that leads nowhere."""
    pairs: Iterable[tuple[object, object]]
    if isinstance(node, Mapping):
        pairs = node.items()
    elif isinstance(node, (list, tuple)):
        pairs = enumerate(node)
    else:
        yield _Entry(key, node, location)
        return
    if key and pattern_of(key) not in GROUPS:  # a single value is needed here
        yield _Entry(key, node, location)
        return
    for name, value in pairs:
        step: Location = (*location, name if isinstance(name, (int, str)) else str(name))
        below = _steps(name)
        inner = (*key, *below) if below is not None else None
        if inner is None or not (pattern_of(inner) in GROUPS or pattern_of(inner) in SPELLINGS):
            values = {
                "key": str(name),
                "owner": key_text(key) or "the channel parameters",
                "suggestion": group_suggestion(key, str(name)),
            }
            mistakes.append(Contradiction(errors.PARAMETER_UNKNOWN, step, values, at_key=not isinstance(node, list)))
            continue
        yield from _tree_entries(value, inner, step, mistakes)


def _steps(name: object) -> Key | None:
    """A key of the tree: an index, a name, or a written key with dots and brackets."""
    if isinstance(name, bool):
        return None
    if isinstance(name, int):
        return (name,)
    if isinstance(name, str):
        return (int(name),) if _INDEX.match(name) else parse_key(name)
    return None


def _parameters(
    entries: Iterable[_Entry], mistakes: list[Contradiction], folders: Mapping[bool, Path | None]
) -> ChannelParameters:
    values: dict[Key, Value] = {}
    given: dict[Key, _Entry] = {}
    warnings: list[Contradiction] = []
    for entry in entries:
        found = look_up(entry.key)
        if isinstance(found, Found):
            if found.key in given:
                mistakes.append(_twice(entry, given[found.key]))
                continue
            given[found.key] = entry
            value = _value(found.parameter, entry)
            if isinstance(value, Contradiction):
                mistakes.append(value)
            elif found.parameter.use is Use.USED:
                values[found.key] = value
            elif (told := _unused(found.parameter, entry, value)) is not None:
                (warnings if found.parameter.use is Use.HARMLESS else mistakes).append(told)
        else:
            mistakes.append(_no_parameter(entry, found))
    for key in [key for key in values if key[0] == "path" and key[-1] == "dir"]:
        folder = folders.get(given[key].line is None)
        if folder is not None:
            values[key] = str((folder / str(values[key])).absolute())
    origins = {key: entry.origin for key, entry in given.items()}
    contradictions, remarks = check(values)
    for finding in (*contradictions, *remarks):
        location, place = next(
            (origin for key, origin in origins.items() if key[: len(finding.location)] == finding.location), ((), None)
        )
        placed = Contradiction(finding.entry, location, finding.values, finding.at_key, place)
        (mistakes if finding in contradictions else warnings).append(placed)
    if mistakes:
        raise ContradictionError(mistakes)
    return ChannelParameters.of(_nested(values), origins, tuple(warnings))


def _no_parameter(entry: _Entry, found: BadIndex | None) -> Contradiction:
    name = key_text(entry.key)
    if found is not None:
        within = f"{found.first} to {found.last}" if found.first != found.last else f"{found.first}"
        values = {"key": name, "given": entry.key[found.position], "bound": f"it must be {within}"}
        return entry.mistake(errors.OUT_OF_RANGE, values, at_key=True)
    if pattern_of(entry.key) in GROUPS:
        return entry.mistake(errors.PARAMETER_GROUP, {"key": name}, at_key=True)
    values = {"key": name, "owner": "the channel parameters", "suggestion": suggestion(entry.key)}
    return entry.mistake(errors.PARAMETER_UNKNOWN, values, at_key=True)


def _value(parameter: ChannelParameter, entry: _Entry) -> Value | Contradiction:
    try:
        if parameter.kind == "UNDEFINED":
            return _unsupported(parameter, entry, "take it out")
        if entry.line is None:
            return value_of(parameter, entry.given)
        text = value_text(parameter, entry.line)
        if isinstance(text, Problem):
            return _of_problem(text)
        if text == "" and '"' not in entry.line.rest and parameter.kind != "FLAGS":
            return entry.mistake(errors.LIST_VALUE_MISSING, {"key": key_text(entry.key)}, at_key=True)
        return value_of_text(parameter, text)
    except ValueMistakeError as error:
        return entry.mistake(error.entry, {"key": key_text(entry.key), **error.values})


def _unused(parameter: ChannelParameter, entry: _Entry, value: Value) -> Contradiction | None:
    """What is told of a known parameter that is not in use; None if it has its default."""
    if value == parameter.default:
        return None
    default = parameter.default
    if isinstance(default, bool):
        default = int(default)
    elif isinstance(default, float):
        default = f"{default:g}"
    return _unsupported(parameter, entry, f"only {default} is possible" if default != "" else "it has to be empty")


def _unsupported(parameter: ChannelParameter, entry: _Entry, possible: str) -> Contradiction:
    told = errors.PARAMETER_WITHOUT_EFFECT if parameter.use is Use.HARMLESS else errors.PARAMETER_UNSUPPORTED
    meaning = parameter.meaning
    if meaning[1:2].islower():  # a sentence, no name in capitals
        meaning = meaning[0].lower() + meaning[1:]
    values = {"key": key_text(entry.key), "id": parameter.id, "meaning": meaning, "possible": possible}
    return entry.mistake(told, values, at_key=parameter.kind == "UNDEFINED")


def _twice(entry: _Entry, first: _Entry) -> Contradiction:
    place = f"line {first.line.key_place.line} of the list" if first.line is not None else "the machine description"
    return entry.mistake(errors.PARAMETER_TWICE, {"key": key_text(entry.key), "first": place}, at_key=True)


def _nested(values: Mapping[Key, Value]) -> dict[str | int, object]:
    tree: dict[str | int, object] = {}
    for key, value in values.items():
        node = tree
        for step in key[:-1]:
            below = node.setdefault(step, {})
            assert isinstance(below, dict)  # a key is never the beginning of another one
            node = below
        node[key[-1]] = value
    spindles = tree.get("spindel")
    if isinstance(spindles, dict):  # the checks have found no gap
        tree["spindel"] = tuple(spindles[index] for index in sorted(spindles))
    return tree
