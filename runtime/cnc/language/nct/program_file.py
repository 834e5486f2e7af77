"""A file with programs of the NCT dialect, read line by line while it is executed (programmer's manual lines 299–342).

    %O1234(NAME)      or   %            the frame of a program; neither % is asked for
    N10 G90 ...            O1234 (NAME)
    %                      ...

A block is a line, so a program level stands at an offset of the file and nothing of what it has passed is kept: a program of
any length starts at once and takes the same small memory. A file may hold several programs, the first one without a number.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from dataclasses import dataclass

from runtime.cnc.language.errors import ProgramError
from runtime.cnc.language.text import MAX_BLOCK, ProgramText
from runtime.diagnostics.catalogue import nct as catalogue
from runtime.diagnostics.errors import Place

PART = 1 << 16  # bytes that are read at once
NAME_LENGTH = 16
_HEADER = re.compile(r"[ \t]*%?[ \t]*[Oo](?P<number>[^\s(]*)[ \t]*(?P<rest>.*)$", re.DOTALL)
_NAME = re.compile(r"\((?P<name>[^()]*)\)[ \t]*")
_NUMBER = re.compile(r"[ \t]*(?:/[ \t]*\d?[ \t]*)?[Nn][ \t]*(\d+)(?![\d.])")


@dataclass(frozen=True, slots=True)
class BlockText:
    """The text of a block, a line of the file: `line` counts from 1, `offset` and `following` in bytes."""

    text: str
    line: int
    offset: int
    following: int

    def place(self, column: int) -> tuple[int, int, str]:
        """Line, column and text of that line for a column of the block."""
        return self.line, column, self.text


@dataclass(slots=True)
class Section:
    """A program of a file: `number` from its O word, None without; its blocks begin at `begin` in line `line`.

    Where it ends is known when somebody has read so far.
    """

    number: int | None
    name: str
    begin: int
    line: int


class Unit:
    """One program file. `name` is what blocks call it; errors name it with its path."""

    def __init__(self, name: str, text: ProgramText) -> None:
        self.name = name
        self.text = text
        self._part, self._part_begin = b"", text.start
        self._sections: list[Section] | None = None
        self._main: Section | None = None

    def place(self, line: int, column: int = 0, text: str = "") -> Place:
        """A place in this file."""
        return Place(self.text.name, line, column, text)

    # ------------------------------------------------------------------ lines and blocks

    def _line(self, offset: int) -> tuple[str, int]:
        """The line at an offset, and the offset of the next one; the end of the file gives that of the file."""
        at = offset - self._part_begin
        end = self._part.find(b"\n", at) if 0 <= at < len(self._part) else -1
        if end < 0:
            self._part, self._part_begin = self.text.window(offset, PART).tobytes(), offset
            at, end = 0, self._part.find(b"\n")
            if end < 0 and len(self._part) > MAX_BLOCK:
                return self.text.line(offset)
            if end < 0:
                return self._part.rstrip(b"\r").decode("latin-1"), offset + len(self._part)
        return self._part[at:end].rstrip(b"\r").decode("latin-1"), self._part_begin + end + 1

    def block(self, offset: int, line: int) -> BlockText | None:
        """The block at an offset, None if the program ends there."""
        if offset >= self.text.size:
            return None
        text, following = self._line(offset)
        if _is_frame(text):
            return None
        return BlockText(text, line, offset, following)

    def blocks(self, offset: int, line: int) -> Iterator[BlockText]:
        """The blocks from an offset on to the end of their program."""
        block = self.block(offset, line)
        while block is not None:
            yield block
            block = self.block(block.following, block.line + 1)

    # ------------------------------------------------------------------ programs

    @property
    def main(self) -> Section:
        """The first program of the file. ProgramError if its frame is faulty, or it has no block."""
        if self._main is None:
            self._main = next(self._found(), None)
            if self._main is None:
                raise ProgramError(catalogue.PROGRAM_MISSING, self.place(0), file=self.text.name)
        return self._main

    def program(self, number: int) -> Section | None:
        """The program of a number, None if the file has none. ProgramError for a faulty frame; the file is read once for it."""
        if self._sections is None:
            self._sections = list(self._found())
            seen: dict[int, int] = {}
            for section in self._sections:
                if section.number is not None and section.number in seen:
                    raise ProgramError(
                        catalogue.PROGRAM_TWICE,
                        self.place(section.line - 1),
                        number=section.number,
                        first=seen[section.number],
                    )
                if section.number is not None:
                    seen[section.number] = section.line - 1
        return next((section for section in self._sections if section.number == number), None)

    @property
    def single(self) -> bool:
        """The file is one program without a number."""
        return self.main.number is None

    def _found(self) -> Iterator[Section]:
        """The programs of the file in their order. What stands behind the closing % of a program and in front of the next one is
        no program (the trailer of a transfer)."""
        offset, line = self.text.start, 1
        begun = False
        while offset < self.text.size:
            text, following = self._line(offset)
            if _is_header(text):
                begun = True
                yield self._section(text, following, line)
            elif not begun and text.strip() not in ("", "%"):
                begun = True
                yield Section(None, "", offset, line)
            offset, line = following, line + 1

    def _section(self, text: str, following: int, line: int) -> Section:
        match = _HEADER.match(text)
        assert match is not None
        number, rest = match["number"], match["rest"]
        if not re.fullmatch(r"\d{4}", number) or int(number) == 0:
            raise ProgramError(
                catalogue.PROGRAM_NUMBER, self.place(line, match.start("number"), text), text=f"O{number}"
            )
        name = ""
        if rest.strip():
            named = _NAME.fullmatch(rest)
            if named is None or len(named["name"]) > NAME_LENGTH:
                raise ProgramError(
                    catalogue.PROGRAM_NAME, self.place(line, match.start("rest") + 1, text), text=rest.strip()
                )
            name = named["name"]
        return Section(int(number), name, following, line + 1)


def _is_header(text: str) -> bool:
    stripped = text.lstrip(" \t%")
    return stripped[:1] in ("O", "o")


def _is_frame(text: str) -> bool:
    """Whether the line ends a program: a % or the number of the next one."""
    return text.strip()[:1] == "%" or _is_header(text)


def number_of(text: str) -> int:
    """The number of a block by its text, -1 without."""
    match = _NUMBER.match(text)
    return int(match.group(1)) if match is not None else -1
