"""How much of a catalogue of the manuals has passing tests.

    python -m tests.coverage_spec FOLDER [--results FILE] [--core 1,2] [--groups]

`FOLDER` holds the catalogue, YAML files with lists of entries that have an `id`, a `title` or `name`, mostly a `group`
and a `core` level (1 every machine, 2 common, 3 special). The results come from `pytest --spec-results FILE`. An entry
counts as covered if at least one test names it and every test that names it passed.

The exit code is 0 whatever is covered, 1 if tests or sources name entries that the catalogue does not have, 2 if
catalogue or results cannot be read.
"""

from __future__ import annotations

import argparse
import ast
import json
import re
import sys
from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from pathlib import Path

import yaml
from rich.console import Console
from rich.table import Table

RESULTS = Path("out/spec-results.json")
SOURCES = Path("runtime")
WIDTH = 130  # characters of the report where there is no terminal
_ID = re.compile(r"[a-z]+(\.[a-z0-9]+(-[a-z0-9]+)*){2,}")


class CoverageError(Exception):
    """The catalogue or the results cannot be read."""


@dataclass(frozen=True, slots=True)
class Entry:
    """One entry of the catalogue; `core` is None where the catalogue gives none."""

    id: str
    title: str
    file: str
    group: str
    core: int | None


@dataclass(frozen=True, slots=True)
class Results:
    """The tests that name an entry, by its id: `passed` all of them, `failed` those that failed or were skipped."""

    passed: Mapping[str, Sequence[str]]
    failed: Mapping[str, Sequence[str]]

    def covers(self, entry: Entry) -> bool:
        """Whether the entry counts as covered."""
        return entry.id in self.passed and entry.id not in self.failed

    @property
    def ids(self) -> set[str]:
        """Every id that a test names."""
        return {*self.passed, *self.failed}


@dataclass(slots=True)
class Count:
    """Covered and all entries, in total and by core level."""

    covered: int = 0
    entries: int = 0
    by_core: dict[int | None, tuple[int, int]] = field(default_factory=dict)

    def add(self, core: int | None, covered: bool) -> None:
        """Count one entry."""
        self.covered += covered
        self.entries += 1
        done, of = self.by_core.get(core, (0, 0))
        self.by_core[core] = done + covered, of + 1

    def level(self, core: int | None) -> str:
        """Covered and all entries of one core level, empty if there are none."""
        done, of = self.by_core.get(core, (0, 0))
        return f"{done}/{of}" if of else ""

    @property
    def share(self) -> str:
        """Covered entries in per cent."""
        return f"{100.0 * self.covered / self.entries:.1f} %" if self.entries else ""


def read_catalogue(folder: Path) -> list[Entry]:
    """The entries of all YAML files in `folder`, in the order of files and lines. Lists without ids are left out.

    Raises CoverageError for a folder without entries, a file that is no YAML, and an id that is there twice.
    """
    entries: dict[str, Entry] = {}
    for file in sorted(folder.glob("*.yaml")):
        try:
            content = yaml.load(file.read_text(encoding="utf-8"), Loader=_LOADER)
        except yaml.YAMLError as error:
            raise CoverageError(f"{file}: {error}") from None
        lists = content.values() if isinstance(content, dict) else [content]
        for row in (row for rows in lists if isinstance(rows, list) for row in rows):
            if not isinstance(row, dict) or "id" not in row:
                continue
            entry = _entry(row, file.name)
            if entry.id in entries:
                raise CoverageError(f"{file}: {entry.id} is there twice, first in {entries[entry.id].file}")
            entries[entry.id] = entry
    if not entries:
        raise CoverageError(f"{folder}: no catalogue entries there")
    return list(entries.values())


_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)  # the one in C reads a big catalogue in a second, not in ten


def _entry(row: Mapping[str, object], file: str) -> Entry:
    id_ = str(row["id"])
    core = row.get("core")
    group = row.get("group") or (id_.split(".")[1] if "." in id_ else "")
    title = row.get("title") or row.get("name") or ""
    return Entry(id_, str(title), file, str(group), core if isinstance(core, int) else None)


def read_results(file: Path) -> Results:
    """What `pytest --spec-results` wrote. Raises CoverageError."""
    passed: dict[str, list[str]] = {}
    failed: dict[str, list[str]] = {}
    try:
        for test, result in json.loads(file.read_text(encoding="utf-8"))["tests"].items():
            for id_ in result["ids"]:
                (passed if result["outcome"] == "passed" else failed).setdefault(id_, []).append(test)
    except OSError as error:
        raise CoverageError(f"{file}: {error.strerror}; `pytest --spec-results {file}` writes it") from None
    except (ValueError, KeyError, TypeError, AttributeError):
        raise CoverageError(f"{file}: not written by `pytest --spec-results`") from None
    return Results(passed, failed)


def named_in_sources(root: Path, entries: Iterable[Entry]) -> dict[str, str]:
    """Strings of Python files under `root` that look like ids of this catalogue → the place of the first one.

    They look like one if they begin with the same two parts as an entry: "isg.flow.if" and "isg.flow.iff" do.
    """
    families = {tuple(entry.id.split(".")[:2]) for entry in entries}
    found: dict[str, str] = {}
    for file in sorted(root.rglob("*.py")):
        for node in ast.walk(ast.parse(file.read_text(encoding="utf-8"))):
            if not (isinstance(node, ast.Constant) and isinstance(node.value, str)):
                continue
            if _ID.fullmatch(node.value) and tuple(node.value.split(".")[:2]) in families:
                found.setdefault(node.value, f"{file}:{node.lineno}")
    return found


def summary(entries: Iterable[Entry], results: Results, groups: bool) -> Table:
    """Entries, covered ones and their share by file, and by group if asked for."""
    files: dict[str, Count] = {}
    parts: dict[str, dict[str, Count]] = {}
    total = Count()
    for entry in entries:
        covered = results.covers(entry)
        for count in (
            total,
            files.setdefault(entry.file, Count()),
            parts.setdefault(entry.file, {}).setdefault(entry.group, Count()),
        ):
            count.add(entry.core, covered)
    levels = sorted((level for level in total.by_core if level is not None), key=int)
    table = Table()
    table.add_column("catalogue")
    for column in ("entries", "covered", "share", *(f"core {level}" for level in levels)):
        table.add_column(column, justify="right")

    def row(name: str, count: Count, style: str = "") -> None:
        by_core = [count.level(level) for level in levels]
        table.add_row(name, str(count.entries), str(count.covered), count.share, *by_core, style=style)

    for file, count in files.items():
        row(file, count, "bold" if groups else "")
        if groups:
            for group, part in parts[file].items():
                row(f"  {group or '-'}", part)
            table.add_section()
    if not groups:
        table.add_section()
    row("all", total, "bold")
    return table


def report(console: Console, entries: Sequence[Entry], results: Results, groups: bool) -> None:
    """The table, then what is missing and what failed."""
    console.print(summary(entries, results, groups))
    missing = [entry for entry in entries if not results.covers(entry)]
    said = ""
    for entry in missing:
        if entry.file != said:
            said = entry.file
            console.print(f"\nmissing in {said}:", markup=False, highlight=False)
        core = "-" if entry.core is None else entry.core
        reason = "  (its tests did not pass)" if entry.id in results.failed else ""
        console.print(f"  {core} {entry.id}  {entry.title}{reason}", markup=False, highlight=False, soft_wrap=True)


def unknown(console: Console, known: set[str], results: Results, sources: Mapping[str, str]) -> bool:
    """Tell ids that the catalogue does not have; whether there are any."""
    rows = [(id_, test) for id_ in sorted(results.ids - known) for test in _tests(results, id_)]
    rows += [(id_, place) for id_, place in sources.items() if id_ not in known]
    if rows:
        console.print("\nnot in the catalogue:", markup=False)
    for id_, place in rows:
        console.print(f"  {id_}  named by {place}", markup=False, highlight=False, soft_wrap=True)
    return bool(rows)


def _tests(results: Results, id_: str) -> list[str]:
    return sorted({test.partition("[")[0] for test in (*results.passed.get(id_, ()), *results.failed.get(id_, ()))})


def _levels(text: str) -> set[int]:
    return {int(part) for part in text.split(",")}


def main(arguments: Sequence[str], console: Console | None = None) -> int:
    """Print the report; returns the exit code."""
    parser = argparse.ArgumentParser(prog="python -m tests.coverage_spec", description=(__doc__ or "").split("\n")[0])
    parser.add_argument("catalogue", type=Path, metavar="FOLDER", help="folder of the catalogue's YAML files")
    parser.add_argument("--results", type=Path, default=RESULTS, metavar="FILE", help=f"default: {RESULTS}")
    parser.add_argument("--core", type=_levels, metavar="1,2", help="these core levels only")
    parser.add_argument("--groups", action="store_true", help="a row for each group")
    parser.add_argument("--sources", type=Path, default=SOURCES, metavar="FOLDER", help=f"default: {SOURCES}")
    given = parser.parse_args(arguments)
    console = console or Console()
    if not console.is_terminal:
        console.width = WIDTH
    try:
        catalogue, results = read_catalogue(given.catalogue), read_results(given.results)
    except CoverageError as error:
        console.print(str(error), markup=False, highlight=False, soft_wrap=True)
        return 2
    chosen = [entry for entry in catalogue if given.core is None or entry.core in given.core]
    report(console, chosen, results, given.groups)
    known = {entry.id for entry in catalogue}
    return int(unknown(console, known, results, named_in_sources(given.sources, catalogue)))


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
