"""A program file, opened: what the decoder executes, and what can be said of its text without executing it."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from runtime.cnc.decoder.execution import Execution, check_continued
from runtime.cnc.decoder.library import Library, wrong_name
from runtime.cnc.decoder.memory import ChannelMemory
from runtime.cnc.decoder.outside import Offline
from runtime.cnc.decoder.passed_over import check_passed
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.language.errors import ProgramError, ProgramErrors
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.index import LOOPS, BlockText, Section, Unit
from runtime.cnc.language.isg.words import ParsedBlock, WordKind
from runtime.cnc.language.text import ProgramText
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import Place, Problem, Reaction, Severity

MAX_PROBLEMS = 20  # told per program
CHECKED_BEFORE_START = 1 << 18  # bytes; longer programs start before they are read to their end

Progress = Callable[[int, int], None]  # bytes done, bytes in all


@dataclass(frozen=True, slots=True)
class Program:
    """An open program with everything that it has called so far."""

    unit: Unit
    library: Library

    @property
    def name(self) -> str:
        """Name of the program file, as blocks and errors show it."""
        return self.unit.name

    def units(self) -> Iterator[Unit]:
        """The files of the program that are open, each once."""
        yield from self.library.units()

    def close(self) -> None:
        """Give the files back."""
        self.library.close()


def open_program(path: Path, setup: DecoderSetup) -> Program:
    """Open a program. A short one is looked through before it starts, so that what is wrong in it is told before anything moves.

    Raises ProgramError for a file, ProgramErrors for what is wrong in its blocks.
    """
    wrong = wrong_name(path.name)
    if wrong is not None:
        raise ProgramError(wrong[0], Place(str(path)), **wrong[1])
    library = library_of(path, setup)
    try:
        unit = library.open(path, path.name)
        if unit.text.size <= CHECKED_BEFORE_START:
            problems = [problem for problem in look_through(path, setup) if problem.entry.severity >= Severity.ERROR]
            if problems:
                raise ProgramErrors(problems[:MAX_PROBLEMS])
    except BaseException:
        library.close()
        raise
    return Program(unit, library)


def library_of(path: Path, setup: DecoderSetup) -> Library:
    """The files around a main program: its own folder first, then the search paths in the order of their priority."""
    folders = [path.parent, *(path.parent / folder for folder in setup.program_paths)]
    return Library(setup.addresses, folders, setup.rules, setup.configured_programs)


def look_through(path: Path, setup: DecoderSetup, progress: Progress | None = None) -> Iterator[Problem]:
    """What is wrong with the blocks of a file, in the order of its lines, without executing any.

    Blocks in branches that may be passed over are told as warnings: the control does not look at them as long as it does not
    come there (programming manual lines 8241–8326). The same holds for the whole program once it has a jump.
    """
    unit = Unit(path.name, ProgramText(path), setup.addresses, setup.rules)
    try:
        yield from _Look(unit, setup, path).problems(progress)
    finally:
        unit.text.close()


class _Look:
    def __init__(self, unit: Unit, setup: DecoderSetup, path: Path) -> None:
        self._unit = unit
        self._library = library_of(path, setup)
        start = np.zeros(len(setup.axes))
        self._x = Execution(setup, ChannelMemory(setup), Offline(), self._library, start, lambda: 0)
        self._seen: set[tuple[WordKind, str]] = set()
        self._jumps = False

    def problems(self, progress: Progress | None) -> Iterator[Problem]:
        unit, entry, section = self._unit, 0, None
        while True:
            while entry >= len(unit) and not unit.ended:
                unit.grow()
            if entry >= len(unit):
                break
            section = next((s for s in reversed(list(unit.sections())) if s.begin <= entry), section)
            assert section is not None
            yield from self._entry(entry, section)
            entry += 1
            if entry % 256 == 0:
                unit.forget(entry)
                if progress:
                    progress(unit.offset(entry - 1), unit.text.size)
        for number in sorted(unit.faults):
            if number >= entry:
                yield self._fault(number)
        if progress:
            progress(unit.text.size, unit.text.size)

    def _fault(self, entry: int) -> Problem:
        fault = self._unit.faults[entry]
        return Problem(fault.entry, fault.values, self._unit.place(fault.line, fault.column, fault.text))

    def _entry(self, entry: int, section: Section) -> Iterator[Problem]:
        unit = self._unit
        if entry in unit.links and unit.links[entry].first == entry:
            unit.last(entry)  # so that a structure that is not closed is known
        if unit.count(entry):
            return
        text = unit.block_text(entry)
        if entry in unit.faults and entry not in unit.links:
            yield self._fault(entry)
            return
        try:
            parsed = self._x.parser.parse(text.text, self._x.environment)
            check_continued(parsed, text)
        except LineError as error:
            if self._certain(entry, text.text):
                yield self._problem(error, text)
                return
            told = self._passed(text.text)
            yield as_warning(self._problem(error, text)) if told is None else self._problem(told, text)
            return
        if entry in unit.faults:
            yield self._fault(entry)
            return
        for name, content in parsed.macros:
            self._x.memory.define_macro(name, content)
        yield from self._calls(parsed, entry, text.text, text.line, section)

    def _certain(self, entry: int, text: str) -> bool:
        """Whether the block is executed whenever the program comes to it: in no branch, no jump before it."""
        self._jumps |= "$GOTO" in text.upper()
        unit = self._unit
        around = unit.around(entry)
        return not self._jumps and '"' not in text and all(unit.links[first].control in LOOPS for first in around)

    def _problem(self, error: LineError, text: BlockText) -> Problem:
        line, column, shown = text.place(error.column)
        return Problem(error.entry, error.values, self._unit.place(line, column, shown))

    def _passed(self, text: str) -> LineError | None:
        """What is told of a block even where it is passed over; nothing of one that macros may change."""
        if '"' not in text:
            try:
                check_passed(self._x, text)
            except LineError as error:
                return error
        return None

    def _calls(self, parsed: ParsedBlock, entry: int, text: str, line: int, section: Section) -> Iterator[Problem]:
        self._jumps |= any(word.kind is WordKind.GOTO for word in parsed.words)
        self._jumps |= parsed.control is not None and parsed.control.goto is not None
        for word in parsed.words:
            if word.kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL) and word.value is None:
                yield from self._called(word.kind, word.name, word.column, entry, text, line, section)
        statement = parsed.statement
        if statement is not None and statement.syntax.name in ("CALL L CYCLE", "CALL LL CYCLE"):
            local = statement.syntax.name == "CALL LL CYCLE"
            kind = WordKind.CALL_LOCAL if local else WordKind.CALL_GLOBAL
            for argument in statement.arguments:
                if argument.name == "NAME" and argument.text:
                    yield from self._called(kind, argument.text, argument.column, entry, text, line, section)

    def _called(
        self, kind: WordKind, name: str, column: int, entry: int, text: str, line: int, section: Section
    ) -> Iterator[Problem]:
        """A program that is called but is not there."""
        if (kind, name) in self._seen:
            return
        self._seen.add((kind, name))
        problem = None
        place = self._unit.place(line, column, text)
        if kind is WordKind.CALL_LOCAL:
            if section.local:
                self._unit.open()
            if name not in self._unit.local_programs:
                problem = Problem(catalogue.LOCAL_MISSING, {"name": name}, place)
        else:
            found = self._library.find(name, place)
            problem = found if isinstance(found, Problem) else None
        if problem is not None:
            yield problem if self._certain(entry, text) else as_warning(problem)


def as_warning(problem: Problem) -> Problem:
    """The same, of what may be passed over."""
    entry = replace(problem.entry, severity=Severity.WARNING, reaction=Reaction.NONE)
    return replace(problem, entry=entry)
