"""Reading a machine description: YAML text → `Machine`, and every mistake in it at its line and column.

    text ── compose ──▶ node tree (marks) ── construct ──▶ plain values ── pydantic ──▶ Machine
                            ▲                                                │ locations of mistakes
                            └────────────── line and column ◀────────────────┘

pydantic knows where a mistake is as a path of keys ("axes", 0, "velocity"); the YAML node tree knows the line and
column of each key and value. Nothing but plain values is built from the file: tags of Python objects are refused.
"""

from __future__ import annotations

import re
from collections.abc import Iterator, Sequence
from pathlib import Path

import yaml
from pydantic import ValidationError

from runtime.config.contradictions import Contradiction, Location
from runtime.config.explanations import Explanation, explain
from runtime.config.machine import Machine
from runtime.config.yaml_core import CoreLoader, plain_tag
from runtime.diagnostics.catalogue import configuration as errors
from runtime.diagnostics.errors import ErrorEntry, Place, Problem, TandemError

DEMO_MACHINE = Path(__file__).parents[1] / "demo" / "machine.yaml"
LARGEST_FILE = 1_000_000  # bytes; a description has some thousands, /dev/zero has no end

_TO_FILL_IN = re.compile(r"<.+>")
_PLAINER = {  # what PyYAML says -> what we say
    "found character '\\t' that cannot start any token": "a tab stands where only spaces are allowed",
    "mapping values are not allowed here": "a second colon in the line, or the line is indented too far",
    "could not find expected ':'": "the colon behind the key is missing",
    "expected a single document in the stream": "a second document (---) begins here; there may be one only",
}


class ConfigurationError(TandemError):
    """The description is not taken; `problems` holds every mistake that was found, in the order of the file."""

    def __init__(self, problems: Sequence[Problem]) -> None:
        first = problems[0]
        super().__init__(first.entry, first.place, **first.values)
        self.problems = tuple(problems)


def load_machine(path: Path | None = None) -> Machine:
    """The machine that the YAML file `path` describes; None is the built-in demo machine.

    Relative paths in the file count from its folder. What is no mistake but worth knowing stands in
    `Machine.warnings`. Raises ConfigurationError.
    """
    path = DEMO_MACHINE if path is None else path
    return parse_machine(_read(path), file=str(path), folder=path.parent)


def parse_machine(text: str, *, file: str = "-", folder: Path | None = None) -> Machine:
    """The machine that a YAML text describes; `file` is the name for messages. Raises ConfigurationError."""
    lines = text.splitlines()

    def place(mark: yaml.Mark | None) -> Place:
        if mark is None:
            return Place(file)
        line = lines[mark.line] if mark.line < len(lines) else ""
        return Place(file, mark.line + 1, mark.column + 1, line)

    def refuse(entry: ErrorEntry, mark: yaml.Mark | None = None, **values: object) -> ConfigurationError:
        return ConfigurationError([Problem(entry, values, place(mark))])

    try:
        loader = CoreLoader(text)
        root = loader.get_single_node()
        if root is None:
            raise refuse(errors.EMPTY)
        mistakes = list(_yaml_mistakes(root, loader))
        if mistakes:
            raise ConfigurationError(
                [Problem(entry, values, place(node.start_mark)) for entry, node, values in mistakes]
            )
        values = loader.construct_document(root)
    except yaml.reader.ReaderError as error:
        raise refuse(errors.NOT_TEXT, reason=f"character {error.character!r} at position {error.position}") from None
    except yaml.MarkedYAMLError as error:
        reason = _PLAINER.get(error.problem or "", error.problem or "unknown")
        raise refuse(errors.YAML_SYNTAX, error.problem_mark or error.context_mark, reason=reason) from None
    except RecursionError:
        raise refuse(errors.YAML_SYNTAX, reason="it is nested too deeply") from None

    def problem(found: Explanation | Contradiction, *above: str | int) -> Problem:
        node = _node(root, (*above, *found.location), key=found.at_key)
        return Problem(found.entry, found.values, found.place or place(node.start_mark))

    def in_order(problem: Problem) -> tuple[bool, str, int, int]:
        where = problem.place
        return where.file != file, where.file, where.line, where.column

    try:
        machine = Machine.model_validate(values, context={"folder": folder})
    except ValidationError as error:
        problems = [problem(found) for found in explain(error.errors(), lambda location: _raw(root, location))]
        raise ConfigurationError(sorted(problems, key=in_order)) from None
    warnings = [
        problem(found, "channels", index, "parameters")
        for index, channel in enumerate(machine.channels)
        for found in channel.parameters.warnings
    ]
    machine._warnings = tuple(sorted(warnings, key=in_order))
    return machine


def _read(path: Path) -> str:
    def refuse(entry: ErrorEntry, reason: str) -> ConfigurationError:
        return ConfigurationError([Problem(entry, {"reason": reason}, Place(str(path)))])

    try:
        with path.open("rb") as file:
            data = file.read(LARGEST_FILE + 1)
    except OSError as error:
        raise refuse(errors.FILE_NOT_READABLE, error.strerror or str(error)) from None
    if len(data) > LARGEST_FILE:
        raise refuse(errors.FILE_NOT_READABLE, f"it is larger than {LARGEST_FILE} bytes")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError as error:
        raise refuse(errors.NOT_TEXT, f"byte 0x{data[error.start]:02X} at position {error.start}") from None


_Mistake = tuple[ErrorEntry, yaml.Node, dict[str, object]]


def _yaml_mistakes(root: yaml.Node, loader: CoreLoader) -> Iterator[_Mistake]:
    """What YAML allows and a description doesn't: keys twice, tags, aliases to what they stand in, `<what to fill in>`."""
    finished: set[int] = set()  # nodes met again through an alias are walked once

    def walk(node: yaml.Node, above: tuple[int, ...]) -> Iterator[_Mistake]:
        if id(node) in above:
            yield errors.YAML_RECURSION, node, {}
            return
        if id(node) in finished:
            return
        finished.add(id(node))
        if not plain_tag(loader, node):
            yield errors.YAML_TAG, node, {"tag": node.tag.replace("tag:yaml.org,2002:", "!!")}
            return
        above = (*above, id(node))
        if isinstance(node, yaml.ScalarNode) and not node.style and _TO_FILL_IN.fullmatch(node.value):
            yield errors.TO_FILL_IN, node, {"what": node.value[1:-1]}
        elif isinstance(node, yaml.SequenceNode):
            for item in node.value:
                yield from walk(item, above)
        elif isinstance(node, yaml.MappingNode):
            first_lines: dict[tuple[str, str], int] = {}
            for key, value in node.value:
                yield from walk(key, above)
                if isinstance(key, yaml.ScalarNode) and not key.tag.endswith(":merge"):
                    same = (key.tag, str(loader.construct_object(key)))
                    if same in first_lines:
                        yield errors.KEY_TWICE, key, {"key": key.value, "first_line": first_lines[same]}
                    first_lines.setdefault(same, key.start_mark.line + 1)
                yield from walk(value, above)

    return walk(root, ())


def _node(root: yaml.Node, location: Location, *, key: bool) -> yaml.Node:
    """The node at a path of keys and indices, or the last one on the way that exists; `key`: the key, not its value."""
    node = root
    for depth, step in enumerate(location):
        if isinstance(node, yaml.SequenceNode) and isinstance(step, int) and step < len(node.value):
            node = node.value[step]
        elif isinstance(node, yaml.MappingNode):
            # the last one counts: pairs that came through a merge key stand in front
            found = [pair for pair in node.value if _is_key(pair[0], step)]
            if not found:
                return node
            node = found[-1][0] if key and depth == len(location) - 1 else found[-1][1]
        else:
            return node
    return node


def _is_key(node: yaml.Node, step: str | int) -> bool:
    if not isinstance(node, yaml.ScalarNode):
        return False
    if isinstance(step, int):
        try:
            return int(node.value, 0) == step
        except ValueError:
            return False
    return bool(node.value == step)


def _raw(root: yaml.Node, location: Location) -> str:
    """How the value at `location` stands in the file, for messages."""
    node = _node(root, location, key=False)
    if isinstance(node, yaml.MappingNode):
        return "a mapping" if node.value else "an empty mapping"
    if isinstance(node, yaml.SequenceNode):
        return "a list" if node.value else "an empty list"
    return repr(node.value) if node.value else "nothing"
