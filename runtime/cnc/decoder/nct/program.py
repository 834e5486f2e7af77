"""An NCT program, opened: what the decoder executes, and what can be said of its text without executing it."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

from runtime.cnc.decoder.nct import codes  # noqa: F401 - registers the dialect
from runtime.cnc.decoder.nct.block import g_calls
from runtime.cnc.decoder.nct.functions import m_numbers
from runtime.cnc.decoder.nct.library import Library
from runtime.cnc.decoder.nct.registry import G_CODES, tenths_of
from runtime.cnc.decoder.nct.words import BlockWords
from runtime.cnc.decoder.program import CHECKED_BEFORE_START, MAX_PROBLEMS, Progress, as_warning
from runtime.cnc.decoder.setup import DecoderSetup
from runtime.cnc.language.errors import LineError, ProgramErrors
from runtime.cnc.language.nct.addresses import checked
from runtime.cnc.language.nct.parser import block_parser
from runtime.cnc.language.nct.program_file import BlockText, Unit
from runtime.cnc.language.nct.words import Control, ParsedBlock, Word
from runtime.diagnostics.errors import Problem, Severity

BLOCKS_AS_ARGUMENTS = 661  # G66.1


@dataclass(frozen=True, slots=True)
class NctProgram:
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


def open_program(path: Path, setup: DecoderSetup) -> NctProgram:
    """Open a program. A short one is looked through before it starts, so that what is wrong in it is told before anything moves.

    Raises ProgramError for a file, ProgramErrors for what is wrong in its blocks.
    """
    library = Library([path.parent, *(path.parent / folder for folder in setup.program_paths)])
    try:
        unit = library.open(path, path.name)
        _ = unit.main
        if unit.text.size <= CHECKED_BEFORE_START:
            found = _look(unit, setup, None)
            problems = [problem for problem in found if problem.entry.severity >= Severity.ERROR]
            if problems:
                raise ProgramErrors(problems[:MAX_PROBLEMS])
    except BaseException:
        library.close()
        raise
    return NctProgram(unit, library)


def look_through(path: Path, setup: DecoderSetup, progress: Progress | None = None) -> Iterator[Problem]:
    """What is wrong with the blocks of the main program of a file, in the order of its lines, without executing any.

    What may be passed over (skipped blocks, and all behind a jump) is told as a warning: the control does not look at it as long
    as it does not come there.
    """
    library = Library([path.parent])
    try:
        yield from _look(library.open(path, path.name), setup, progress)
    finally:
        library.close()


def _look(unit: Unit, setup: DecoderSetup, progress: Progress | None) -> Iterator[Problem]:
    parser = block_parser()
    own = {tenths_of(abs(code)) for code in setup.nct.g.values()}  # codes that call programs
    arguments = False  # behind G66.1 the words of a block may be arguments
    passed = False  # a jump, or a block that may be skipped, stands before
    section = unit.main
    for count, text in enumerate(unit.blocks(section.begin, section.line), 1):
        try:
            parsed = parser.parse(text.text)
            known = [(word, word.value.constant) for word in parsed.words if word.value.constant is not None]
            for word, value in known:
                checked(word.address, value, word.column)
            arguments = arguments or _starts_arguments(known)
            if not arguments:
                _look_at_codes(known, own)
        except LineError as error:
            problem = _problem(unit, text, error)
            yield as_warning(problem) if passed or text.text.lstrip().startswith("/") else problem
            continue
        passed = passed or _jumps(parsed)
        if progress and count % 256 == 0:
            progress(text.following, unit.text.size)
    if progress:
        progress(unit.text.size, unit.text.size)


def _starts_arguments(known: list[tuple[Word, float]]) -> bool:
    return any(word.address == "G" and tenths_of(value) == BLOCKS_AS_ARGUMENTS for word, value in known)


def _look_at_codes(known: list[tuple[Word, float]], own: set[int]) -> None:
    """LineError for codes that there are not, or that exclude each other; a block that calls a program has arguments instead."""
    numbers = [tenths_of(value) for word, value in known if word.address == "G"]
    if any(number in own or (number in G_CODES and G_CODES[number].all_words) for number in numbers):
        return
    words = BlockWords(known, {})
    m_numbers(words)
    g_calls(words)


def _jumps(parsed: ParsedBlock) -> bool:
    """Whether the block may lead to somewhere else than the next one, or end the program."""
    if parsed.control is not None:
        return parsed.control.control in (Control.GOTO, Control.IF, Control.WHILE)
    return any(word.address == "M" and word.value.constant in (2.0, 30.0, 99.0, None) for word in parsed.words)


def _problem(unit: Unit, text: BlockText, error: LineError) -> Problem:
    line, column, shown = text.place(error.column)
    return Problem(error.entry, error.values, unit.place(line, column, shown))
