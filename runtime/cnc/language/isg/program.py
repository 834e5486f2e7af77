"""The parsed program: an index into its text, and never the text as objects.

    entry   what it is                                   held for it
    -----   ------------------------------------------   ------------------------------
    plain   a run of plain blocks, any number of lines   offset, first line, line count
    block   one block for the full parser                offset, line, 0

Entries are executed by index. A block is parsed again and compiled when it is executed for the first time, and kept
while it is in use: a program of a million lines that all need the full parser takes 24 bytes per line, and one of
plain blocks nothing.
"""

from __future__ import annotations

from array import array
from collections.abc import Iterator
from dataclasses import dataclass, field

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock, compile_block
from runtime.cnc.language.isg.parser import block_parser
from runtime.cnc.language.isg.words import Control
from runtime.cnc.language.text import ProgramText
from runtime.diagnostics.errors import Place

COMPILED_BLOCKS = 20_000  # kept at once, some 3 kB each


@dataclass(frozen=True, slots=True)
class Section:
    """The main program or a local subprogram: entries `begin` to before `end`."""

    name: str
    begin: int
    end: int
    line: int


@dataclass(slots=True)
class Link:
    """Where control goes from a control statement.

    `following` is the next statement of the same structure (`$ELSEIF`, `$ELSE` or `$ENDIF` of an `$IF`, the end of a
    loop); `last` its end statement; `first` its first one.
    """

    control: Control
    first: int
    following: int = -1
    last: int = -1


@dataclass(slots=True)
class Unit:
    """One program file: its entries, control links, local subprograms and the global ones it calls.

    `name` is what blocks call it; errors name the file with its path (`text.name`).
    """

    name: str
    text: ProgramText
    addresses: Addresses
    offsets: array[int] = field(default_factory=lambda: array("q"))
    lines: array[int] = field(default_factory=lambda: array("q"))
    counts: array[int] = field(default_factory=lambda: array("q"))
    links: dict[int, Link] = field(default_factory=dict)
    local_programs: dict[str, Section] = field(default_factory=dict)
    main: Section | None = None
    global_programs: dict[str, Unit] = field(default_factory=dict)
    line_count: int = 0
    _compiled: dict[int, CompiledBlock] = field(default_factory=dict)

    def place(self, line: int, column: int = 0, text: str = "") -> Place:
        """A place in this file."""
        return Place(self.text.name, line, column, text)

    def append(self, offset: int, line: int, count: int) -> int:
        """Add an entry and give its index; `count` 0 for a block of the full parser."""
        self.offsets.append(offset)
        self.lines.append(line)
        self.counts.append(count)
        return len(self.counts) - 1

    def block(self, offset: int, line: int) -> CompiledBlock:
        """The block at an offset, compiled; ProgramError if the line is faulty (plain lines are only looked at
        here)."""
        compiled = self._compiled.get(offset)
        if compiled is None:
            text, _ = self.text.line(offset)
            try:
                compiled = compile_block(block_parser(self.addresses).parse(text), text, self.addresses)
            except LineError as error:
                raise ProgramError(error.entry, self.place(line, error.column, text), **error.values) from None
            if len(self._compiled) >= COMPILED_BLOCKS:
                self._compiled.clear()
            self._compiled[offset] = compiled
        return compiled


@dataclass(frozen=True, slots=True)
class Program:
    """A checked program with everything that it calls."""

    unit: Unit
    main: Section

    @property
    def name(self) -> str:
        """Name of the program file, as blocks and errors show it."""
        return self.unit.name

    def units(self) -> Iterator[Unit]:
        """The files of the program, each once."""
        seen: dict[int, Unit] = {}
        pending = [self.unit]
        while pending:
            unit = pending.pop()
            if id(unit) not in seen:
                seen[id(unit)] = unit
                pending += unit.global_programs.values()
        yield from seen.values()

    def close(self) -> None:
        """Give the files back."""
        for unit in self.units():
            unit.text.close()
