"""A program file → `Program`: the whole file is checked, streaming, before any of it is executed.

Plain blocks go through the scan kernel, everything else through the full parser. Files that are called with L are
found and checked the same way, each once.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Mapping, Sequence
from contextlib import suppress
from pathlib import Path

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import ProgramError, ProgramErrors
from runtime.cnc.language.isg.comments import LineError, blank_comments
from runtime.cnc.language.isg.parser import block_parser
from runtime.cnc.language.isg.program import Link, Program, Section, Unit
from runtime.cnc.language.isg.scan import PlainScanner
from runtime.cnc.language.isg.words import Control, ControlStatement, Word, WordKind
from runtime.cnc.language.text import MAX_BLOCK, WINDOW, ProgramText
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Problem

MAX_PROBLEMS = 20  # told per program
MAX_CONTROL_DEPTH = 100
_SCAN_ROWS = 16384

Progress = Callable[[int, int], None]  # bytes done, bytes in all

_HEADER = re.compile(r"\s*%(?P<local>L(?=\s))?\s*(?P<name>[^\s(;\"\],#$]*)\s*(?P<rest>.*)$", re.DOTALL)
_CONTROL = re.compile(r"[\s/]*\d*\s*(?:N[^$]*)?(\$[A-Z]+)", re.IGNORECASE)
_CONTROLS = {control.value: control for control in Control}
_OPENING = {
    Control.ELSEIF: Control.IF,
    Control.ELSE: Control.IF,
    Control.ENDIF: Control.IF,
    Control.ENDFOR: Control.FOR,
    Control.ENDWHILE: Control.WHILE,
}
_CLOSING = {Control.IF: Control.ENDIF, Control.FOR: Control.ENDFOR, Control.WHILE: Control.ENDWHILE}


def load(
    path: Path, addresses: Addresses, program_paths: Sequence[Path] = (), progress: Progress | None = None
) -> Program:
    """Read and check a program and all that it calls.

    Global subprograms are looked for beside the main program and then in `program_paths`; relative ones count from
    the folder of the main program. Raises ProgramError for a file, ProgramErrors for what is wrong in its blocks.
    """
    folders = [path.parent, *(path.parent / folder for folder in program_paths)]
    units: dict[Path, Unit] = {}
    problems: list[Problem] = []
    try:
        unit = _load_unit(path, path.name, addresses, folders, units, problems, progress)
    except BaseException:
        _close(units)
        raise
    if problems:
        _close(units)
        raise ProgramErrors(problems[:MAX_PROBLEMS])
    assert unit.main is not None
    return Program(unit, unit.main)


def _close(units: dict[Path, Unit]) -> None:
    for unit in units.values():
        unit.text.close()


def _load_unit(
    path: Path,
    name: str,
    addresses: Addresses,
    folders: Sequence[Path],
    units: dict[Path, Unit],
    problems: list[Problem],
    progress: Progress | None = None,
) -> Unit:
    text = ProgramText(path)
    unit = units[path.resolve()] = Unit(name, text, addresses)
    reader = _Reader(unit, problems, progress)
    reader.read()
    for word, line, source in reader.calls:
        if word.kind is WordKind.CALL_LOCAL:
            if word.name not in unit.local_programs:
                reader.problem(catalogue.LOCAL_MISSING, line, word.column, source, {"name": word.name})
            continue
        found = next((f for f in (folder / word.name for folder in folders) if f.is_file()), None)
        if found is None:
            paths = ", ".join(dict.fromkeys(str(folder) for folder in folders))
            values = {"name": word.name, "paths": paths}
            reader.problem(catalogue.GLOBAL_MISSING, line, word.column, source, values)
        elif found.resolve() in units:
            unit.global_programs[word.name] = units[found.resolve()]
        else:
            unit.global_programs[word.name] = _load_unit(found, word.name, addresses, folders, units, problems)
    return unit


class _Reader:
    """Reads one file into its unit. Problems are collected, reading goes on with the next line."""

    def __init__(self, unit: Unit, problems: list[Problem], progress: Progress | None) -> None:
        self.calls: list[tuple[Word, int, str]] = []
        self._unit = unit
        self._problems = problems
        self._progress = progress
        self._parser = block_parser(unit.addresses)
        self._open: list[tuple[int, int, str]] = []  # entry, line, text of the open control statements
        self._sections: list[tuple[str, bool, int, int]] = []  # name, local, first entry, line
        self._calls_seen: set[tuple[WordKind, str]] = set()
        self._unit_problems = 0

    def problem(self, entry: ErrorEntry, line: int, column: int, text: str, values: Mapping[str, object]) -> None:
        """Note a problem; after many of them only count."""
        self._unit_problems += 1
        if len(self._problems) < MAX_PROBLEMS:
            self._problems.append(Problem(entry, values, self._unit.place(line, column, text)))

    def read(self) -> None:
        """The whole file."""
        unit, text = self._unit, self._unit.text
        scanner = PlainScanner(unit.addresses, _SCAN_ROWS)
        offset, line = text.start, 1
        run = -1  # entry of the plain run that goes on
        window, base = text.window(offset), offset
        while offset < text.size and len(self._problems) < MAX_PROBLEMS:
            final = base + window.size >= text.size
            if not final and offset - base > window.size - 2 * MAX_BLOCK:
                window, base = text.window(offset, WINDOW), offset
                if self._progress:
                    self._progress(offset, text.size)
                continue
            if self._sections:
                count, end, stopped = scanner.scan(window, offset - base, final)
                if count:
                    if run < 0:
                        run = unit.append(offset, line, 0)
                    unit.counts[run] += count
                    offset, line = base + end, line + count
                if not stopped:
                    if not count and not final:
                        window, base = text.window(offset, WINDOW), offset
                    continue
            run = -1
            offset = self._line(offset, line)
            line += 1
        unit.line_count = line - 1
        self._end_section(line)
        if not any(not local for _, local, _, _ in self._sections) and not self._unit_problems:
            raise ProgramError(catalogue.MAIN_MISSING, unit.place(0), file=unit.text.name)
        if self._progress:
            self._progress(text.size, text.size)

    def _line(self, offset: int, line: int) -> int:
        """One line by the full parser; returns the offset of the next."""
        text, following = self._unit.text.line(offset)
        try:
            if text.lstrip().startswith("%"):
                self._header(text, line)
            elif self._sections or blank_comments(text).strip():
                self._block(text, offset, line)
        except LineError as error:
            self.problem(error.entry, line, error.column, text, error.values)
            self._link_faulty(text, offset, line)
        return following

    def _link_faulty(self, text: str, offset: int, line: int) -> None:
        """A faulty control statement still opens or closes its structure, so that the others are not told as faulty."""
        match = _CONTROL.match(text)
        control = _CONTROLS.get(match.group(1).upper()) if match else None
        if match and control and self._sections:
            entry = self._unit.append(offset, line, 0)
            with suppress(LineError):  # one message per line
                self._control(ControlStatement(control, match.start(1) + 1), entry, line, text)

    def _header(self, text: str, line: int) -> None:
        """% NAME or %L NAME."""
        blanked = blank_comments(text)
        column = blanked.index("%") + 1
        match = _HEADER.match(blanked)
        assert match is not None
        name, local = match["name"], match["local"] is not None
        if match["rest"].strip():
            raise LineError(catalogue.HEADER_INVALID, match.start("rest") + 1, text=match["rest"].strip())
        if local and not name:
            raise LineError(catalogue.HEADER_NAME, column)
        if self._sections and not self._sections[-1][1]:
            raise LineError(catalogue.HEADER_LATE, column, name=name)
        for other, was_local, _, first in self._sections:
            if local and was_local and other == name:
                raise LineError(catalogue.LOCAL_TWICE, column, name=name, first=first)
        self._end_section(line)
        self._sections.append((name, local, len(self._unit.counts), line))

    def _block(self, text: str, offset: int, line: int) -> None:
        if not self._sections:
            self._sections.append(("", False, 0, line))  # the unnamed main program (line 1104)
        parsed = self._parser.parse(text)
        entry = self._unit.append(offset, line, 0)
        if parsed.control is not None:
            self._control(parsed.control, entry, line, text)
        for word in parsed.words:
            called = word.kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL)
            if called and (word.kind, word.name) not in self._calls_seen:
                self._calls_seen.add((word.kind, word.name))
                self.calls.append((word, line, text))

    def _control(self, statement: ControlStatement, entry: int, line: int, text: str) -> None:
        """Link a control statement with those of its structure."""
        control, links = statement.control, self._unit.links
        opening = _OPENING.get(control)
        if opening is None:
            if len(self._open) >= MAX_CONTROL_DEPTH:
                raise LineError(catalogue.CONTROL_DEPTH, statement.column, limit=MAX_CONTROL_DEPTH)
            links[entry] = Link(control, entry)
            self._open.append((entry, line, text))
            return
        previous = links[self._open[-1][0]] if self._open else None
        first = links[previous.first].control if previous else None
        if (
            previous is None
            or first is not opening
            or (previous.control is Control.ELSE and control is not Control.ENDIF)
        ):
            start = "$IF" if control is Control.ENDIF else opening.value
            raise LineError(catalogue.CONTROL_WITHOUT_START, statement.column, statement=control.value, start=start)
        previous.following = entry
        links[entry] = Link(control, previous.first)
        if control not in (Control.ELSEIF, Control.ELSE):
            self._close_structure(previous.first, entry)
            self._open.pop()
        else:
            self._open[-1] = (entry, line, text)

    def _close_structure(self, first: int, last: int) -> None:
        link: Link | None = self._unit.links[first]
        while link is not None:
            link.last = last
            link = self._unit.links[link.following] if link.following >= 0 else None

    def _end_section(self, line: int) -> None:
        """The section that is open ends in front of `line`."""
        for entry, opened, text in self._open:
            first = self._unit.links[self._unit.links[entry].first].control
            statement = self._unit.links[entry].control.value
            values = {"statement": statement, "end": _CLOSING[first].value}
            self.problem(catalogue.CONTROL_OPEN, opened, text.find("$") + 1, text, values)
        self._open.clear()
        if self._sections:
            name, local, begin, first_line = self._sections[-1]
            section = Section(name, begin, len(self._unit.counts), first_line)
            if local:
                self._unit.local_programs[name] = section
            else:
                self._unit.main = section
