"""The index of a program file, made while the program is executed: never further ahead than somebody has to see.

    entry   what it is                                      held for it
    -----   ---------------------------------------------   ---------------------------------
    plain   a run of plain blocks, at most RUN lines        offset, first line, line count
    block   one block for the full parser, with all lines   offset, line, 0
            that a backslash ties to it

Entries are numbered from 0 in the order of the file. What control statements need (which $ENDIF belongs to which $IF, in which
structure a label lies) is noted while the index grows; a search forward makes it grow. In branches that are passed over only
block numbers and control statements are looked at, as the manual has it (programming manual lines 8241–8326).

What lies behind an execution that cannot come back to it may be forgotten, so that a program of any length takes the same
small memory.
"""

from __future__ import annotations

import re
from array import array
from collections.abc import Callable, Iterator
from dataclasses import dataclass, field

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg.comments import LineError, blank_comments
from runtime.cnc.language.isg.scan import PlainRows, PlainScanner
from runtime.cnc.language.isg.words import Control
from runtime.cnc.language.text import MAX_BLOCK, WINDOW, Bytes, ProgramText
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place

RUN = 4096  # lines of a plain entry
MAX_CONTROL_DEPTH = 100
CORNER_WITHIN = 8  # entries between a motion and the G301 or G302 that belongs to it, and lines of a run among them
MAX_CONTINUED = 200  # lines of one block
FORGET_FROM = 16_384  # entries behind the execution before some are forgotten

_HEADER = re.compile(r"\s*%(?P<local>L(?=\s))?\s*(?P<name>[^\s(;\"\],#$]*)\s*(?P<rest>.*)$", re.DOTALL)
_CONTROL = re.compile(r"\$([A-Za-z]+)")
_LABEL_NUMBER = re.compile(r"[\s/]*\d*\s*[Nn]\s*(\d+)\s*:")
_LABEL_NAME = re.compile(
    r"(?:/\s*\d*\s*)?(?:[Nn]\s*(?:\d+|\[[^\]]*\]|[Pp]\d+)\s*:?\s*)?\[\s*([A-Za-z_]\w*)\s*\](?!\s*[-+*/])"
)
_CORNER = re.compile(r"[Gg]\s*0*30[12](?!\d)")
_HEAD = re.compile(r"[\s/]*\d*\s*(?:[Nn][^$]*)?(?:\[\s*\w+\s*\]\s*)?")
_BLOCK_NUMBER = re.compile(r"[\s/]*\d*\s*[Nn]\s*(\d+)")
_COMMENT_BLOCK = re.compile(r"\s*(?:[Nn]\s*\d+\s*)?#COMMENT[ \t]+(BEGIN|END)(?![A-Za-z0-9_])", re.IGNORECASE)
_COMMENT_BESIDE = re.compile(r"#COMMENT[ \t]+(BEGIN|END)(?![A-Za-z0-9_])", re.IGNORECASE)
_CONTROLS = {control.value[1:]: control for control in Control}
_OPENING = {
    Control.ELSEIF: Control.IF,
    Control.ELSE: Control.IF,
    Control.ENDIF: Control.IF,
    Control.CASE: Control.SWITCH,
    Control.DEFAULT: Control.SWITCH,
    Control.ENDSWITCH: Control.SWITCH,
    Control.ENDFOR: Control.FOR,
    Control.ENDWHILE: Control.WHILE,
    Control.ENDDO: Control.DO,
    Control.UNTIL: Control.REPEAT,
}
_CLOSING = {
    Control.IF: Control.ENDIF,
    Control.SWITCH: Control.ENDSWITCH,
    Control.FOR: Control.ENDFOR,
    Control.WHILE: Control.ENDWHILE,
    Control.DO: Control.ENDDO,
    Control.REPEAT: Control.UNTIL,
}
LOOPS = frozenset((Control.FOR, Control.WHILE, Control.DO, Control.REPEAT))
MIDDLE = frozenset((Control.ELSEIF, Control.ELSE, Control.CASE, Control.DEFAULT))


@dataclass(slots=True)
class Link:
    """A control statement: `first` begins its structure, `following` is the next statement of the same structure, `last`
    ends it; -1 as long as the index has not come so far. `outer` are the structures around it, the innermost last."""

    control: Control
    first: int
    outer: tuple[int, ...]
    following: int = -1
    last: int = -1


@dataclass(slots=True)
class Section:
    """The main program or a local subprogram: entries `begin` to before `end`, -1 as long as that is not known."""

    name: str
    begin: int
    line: int
    local: bool
    end: int = -1
    numbers: dict[int, int] = field(default_factory=dict)  # expression labels N10: → entry
    names: dict[str, int] = field(default_factory=dict)  # string labels, upper case → entry


@dataclass(frozen=True, slots=True)
class Rules:
    """What a channel may choose: whether #COMMENT blocks nest (programming manual line 12395), how many expression and string
    labels of a file are stored and how long a name may be (lines 8571–8576), how many local subprograms a file may define."""

    nested_comments: bool = True
    labels: int = 20_000
    names: int = 20_000
    local_programs: int = 20_000
    label_length: int = 83


@dataclass(frozen=True, slots=True)
class Fault:
    """Something is wrong with the structure at an entry: told when the entry is reached or passed over."""

    entry: ErrorEntry
    line: int
    column: int
    text: str
    values: dict[str, object]


@dataclass(frozen=True, slots=True)
class BlockText:
    """The text of a block; continued lines are joined with one blank. `pieces`: where each line begins in it."""

    text: str
    line: int
    pieces: tuple[int, ...] = (0,)
    lines: tuple[str, ...] = ()

    def place(self, column: int) -> tuple[int, int, str]:
        """Line, column and text of that line for a column of the block."""
        index = max(i for i, start in enumerate(self.pieces) if start < max(column, 1))
        text = self.lines[index] if self.lines else self.text
        return self.line + index, column - self.pieces[index], text


class Unit:
    """One program file: the index of its entries, its sections, and what was found wrong with its structure.

    `name` is what blocks call it; errors name the file with its path (`text.name`).
    """

    def __init__(self, name: str, text: ProgramText, addresses: Addresses, rules: Rules = Rules()) -> None:
        self.name = name
        self.text = text
        self.addresses = addresses
        self.rules = rules
        self.notes: list[Fault] = []  # warnings that nobody has told yet
        self.local_programs: dict[str, Section] = {}
        self.main: Section | None = None
        self.links: dict[int, Link] = {}
        self.faults: dict[int, Fault] = {}
        self.corner_blocks: set[int] = set()  # blocks with G301 or G302, which belong to the motion before them
        self._sections: list[Section] = []
        self._offsets, self._lines, self._counts = array("q"), array("q"), array("q")
        self._base = 0  # entries before it are forgotten
        self._open: list[int] = []
        self._around: tuple[int, ...] = ()  # the same, as it is kept for entries
        self._outer: list[tuple[int, ...]] = []  # structures around each entry
        self._offset, self._line = text.start, 1
        self._window: Bytes = text.window(text.start, 0)
        self._window_base = text.start
        # Two scanners by turns: the index is mostly one entry ahead of the execution, which still needs the rows before.
        self._scanners = (PlainScanner(addresses, RUN), PlainScanner(addresses, RUN))
        self._scanned = [
            (-1, 0),
            (-1, 0),
        ]  # entry whose rows a scanner holds, and the offset that their starts count from
        self._turn = 0  # the scanner whose rows are older
        self._comment_depth = 0
        self._comment_line = 0
        self.ended = False
        self._noted: set[ErrorEntry] = set()

    # ------------------------------------------------------------------ what others read

    def __len__(self) -> int:
        """Entries so far."""
        return self._base + len(self._counts)

    def offset(self, entry: int) -> int:
        return self._offsets[entry - self._base]

    def line(self, entry: int) -> int:
        return self._lines[entry - self._base]

    def count(self, entry: int) -> int:
        """Lines of a plain entry, 0 for a block."""
        return self._counts[entry - self._base]

    def corner_follows(self, entry: int, section: Section) -> bool:
        """Whether a block with G301 or G302 comes within the next few entries, and no longer run of moves before it."""
        for following in range(entry + 1, entry + 1 + CORNER_WITHIN):
            if not self.has(following, section):
                return False
            if following in self.corner_blocks:
                return True
            if self.count(following) > CORNER_WITHIN:
                return False
        return False

    def around(self, entry: int) -> tuple[int, ...]:
        """First entries of the structures that an entry lies in, the innermost last."""
        return self._outer[entry - self._base]

    def place(self, line: int, column: int = 0, text: str = "") -> Place:
        """A place in this file."""
        return Place(self.text.name, line, column, text)

    def has(self, entry: int, section: Section) -> bool:
        """Whether the section has this entry; the index grows so far."""
        while entry >= len(self) and section.end < 0:
            self.grow()
        return section.end < 0 or entry < section.end

    def open(self) -> Section | None:
        """Read up to the first block of the main program; None if the file has none."""
        while self.main is None and not self.ended:
            self.grow()
        return self.main

    def whole(self, section: Section) -> None:
        """Read to the end of a section."""
        while section.end < 0:
            self.grow()

    def link(self, entry: int) -> Link:
        return self.links[entry]

    def following(self, entry: int) -> int:
        """The next statement of the structure of a control statement, -1 if the structure is not closed."""
        link = self.links[entry]
        while link.following < 0 and not self._section_over(entry):
            self.grow()
        return link.following

    def last(self, entry: int) -> int:
        """The end of the structure of a control statement, -1 if it is not closed."""
        link = self.links[entry]
        while link.last < 0 and not self._section_over(entry):
            self.grow()
        return link.last

    def _section_over(self, entry: int) -> bool:
        section = self._sections[-1]
        return self.ended or section.begin > entry or section.end >= 0

    def find_number(self, section: Section, number: int) -> int:
        """The entry of an expression label, -1 if the section has none."""
        while number not in section.numbers and section.end < 0:
            self.grow()
        if number not in section.numbers and len(section.numbers) >= self.rules.labels:
            return self._searched(section, lambda text: _label_number(text) == number)
        return section.numbers.get(number, -1)

    def find_name(self, section: Section, name: str) -> int:
        """The entry of a string label (upper case), -1 if the section has none."""
        while name not in section.names and section.end < 0:
            self.grow()
        if name not in section.names and len(section.names) >= self.rules.names:
            return self._searched(section, lambda text: _label_name(text) == name)
        return section.names.get(name, -1)

    def _searched(self, section: Section, fits: Callable[[str], bool]) -> int:
        """The first block of a section that fits: for labels that were not stored."""
        for entry in range(max(section.begin, self._base), section.end):
            if not self.count(entry) and fits(without_comments(self.block_text(entry).text)):
                return entry
        return -1

    @property
    def complete(self) -> bool:
        """Nothing of what was read is forgotten."""
        return not self._base

    def anew(self) -> Unit:
        """The same file with an index of its own, from its start on: for somebody who goes back behind what is forgotten."""
        return Unit(self.name, self.text, self.addresses, self.rules)

    def block_text(self, entry: int) -> BlockText:
        """The text of a block entry, with the lines that continue it."""
        return self.text_at(self.offset(entry), self.line(entry))

    def text_at(self, offset: int, line: int) -> BlockText:
        """The block that begins at an offset."""
        text, following = self.text.line(offset)
        if "\\" not in text or not _continued(text):
            return BlockText(text, line)
        joined = ""
        pieces: list[int] = []
        lines: list[str] = []
        while True:
            part = _continued(text)
            lines.append(text)
            if pieces:
                text = _WITHOUT_NUMBER.sub(lambda found: " " * len(found.group()), text)
            pieces.append(len(joined))
            if part is None or following >= self.text.size or len(lines) >= MAX_CONTINUED:
                joined += text
                break
            joined += text[:part] + " "
            text, following = self.text.line(following)
        return BlockText(joined, line, tuple(pieces), tuple(lines))

    def rows(self, entry: int) -> tuple[PlainRows, int]:
        """The scanned rows of a plain entry, valid until the index has grown twice; and the offset their starts count from."""
        for scanner, (held, base) in zip(self._scanners, self._scanned, strict=True):
            if held == entry:
                return scanner.rows, base
        offset, scanner = self.offset(entry), self._scanners[self._turn]
        for windows in (1, 16):  # a run may be longer than a window
            window = self.text.window(offset, WINDOW * windows)
            count, _, _ = scanner.scan(window, 0, offset + window.size >= self.text.size)
            if count >= self.count(entry):
                break
        self._keep(entry, offset)
        return scanner.rows, offset

    def _keep(self, entry: int, base: int) -> None:
        """The rows that the scanner of this turn holds are those of `entry`."""
        self._scanned[self._turn] = (entry, base)
        self._turn = 1 - self._turn

    def forget(self, entry: int) -> None:
        """Entries before `entry` of the main program are not needed any more; label-free programs only let go of them."""
        if entry - self._base < FORGET_FROM or self._open or self.main is None:
            return
        if self.main.numbers or self.main.names or entry < self.main.begin or self.local_programs:
            return
        drop = entry - self._base
        del self._offsets[:drop], self._lines[:drop], self._counts[:drop], self._outer[:drop]
        self._base = entry
        self.links = {key: link for key, link in self.links.items() if key >= entry}

    def numbered(self, first: tuple[int, int], section: Section, number: int) -> tuple[int, int] | None:
        """The first block with this N word from a position (entry, row) on: its position; None without one."""
        entry, begin = first
        while self.has(entry, section):
            if self.count(entry):
                rows, _ = self.rows(entry)
                for row in range(begin, self.count(entry)):
                    if rows.number[row] == number:
                        return entry, row
            else:
                match = _BLOCK_NUMBER.match(self.block_text(entry).text)
                if match and int(match.group(1)) == number:
                    return entry, 0
            entry, begin = entry + 1, 0
        return None

    # ------------------------------------------------------------------ growing

    def grow(self) -> None:
        """One more entry, or the end of a section."""
        if self._offset >= self.text.size:
            self._end_of_file()
            return
        if self._sections and self._sections[-1].end < 0 and not self._comment_depth and self._plain():
            return
        self._one_line()

    def _plain(self) -> bool:
        """A plain run from here, if there is one."""
        begin, size = self._offset - self._window_base, self._window.size
        final = self._window_base + size >= self.text.size
        if not 0 <= begin <= size or (not final and begin > size - 2 * MAX_BLOCK):
            self._window, self._window_base = self.text.window(self._offset, WINDOW), self._offset
            begin, final = 0, self._offset + self._window.size >= self.text.size
        self._scanned[self._turn] = (-1, 0)
        count, end, _ = self._scanners[self._turn].scan(self._window, begin, final)
        if not count:
            return False
        self._keep(self._append(self._offset, self._line, count), self._window_base)
        self._offset, self._line = self._window_base + end, self._line + count
        return True

    def _one_line(self) -> None:
        offset, line = self._offset, self._line
        text, self._offset = self.text.line(offset)
        self._line += 1
        blanked = without_comments(text)
        comment = _COMMENT_BLOCK.match(blanked)
        if comment is None and "#" in blanked and not self._comment_depth:
            beside = _COMMENT_BESIDE.search(blanked)
            if beside and blanked.count('"', 0, beside.start()) % 2 == 0:
                self._outside(offset, line)
                self._fault(catalogue.NOT_ALONE, line, beside.start() + 1, text, word=beside.group())
                return
        if comment:
            self._comment_block(comment, blanked, text, offset, line)
            return
        if self._comment_depth:
            return
        if blanked.lstrip().startswith("%"):
            self._header(blanked, text, offset, line)
            return
        if not blanked.strip():
            return
        while _continued(text) is not None and self._offset < self.text.size and self._line - line < MAX_CONTINUED:
            text, self._offset = self.text.line(self._offset)
            self._line += 1
        if not self._sections:
            self._begin("", False, line)  # the unnamed main program (line 1104)
        elif self._sections[-1].end >= 0:
            return  # behind a header that could not be taken
        entry = self._append(offset, line, 0)
        if self._line - line > 1:
            blanked = without_comments(self.text_at(offset, line).text)
        self._classify(entry, blanked, line)

    def _append(self, offset: int, line: int, count: int) -> int:
        self._offsets.append(offset)
        self._lines.append(line)
        self._counts.append(count)
        self._outer.append(self._around)
        return len(self) - 1

    def _fault(self, entry: ErrorEntry, line: int, column: int, source: str, **values: object) -> None:
        number = len(self) - 1 if self._counts and self._lines[-1] == line else self._append(self._offset, line, 0)
        self.faults.setdefault(number, Fault(entry, line, column, source, values))

    def _classify(self, entry: int, text: str, line: int) -> None:
        """Labels, jumps and control statements of a block."""
        section = self._sections[-1]
        if "30" in text and _CORNER.search(text):
            self.corner_blocks.add(entry)
        if "N" in text or "n" in text:
            number = _label_number(text)
            if number is not None and number not in section.numbers:
                if len(section.numbers) < self.rules.labels:
                    section.numbers[number] = entry
                else:
                    self._note(catalogue.LABELS_FULL, entry, line, text, self.rules.labels)
        if "[" in text:
            name = _label_name(text)
            if name is not None and len(name) > self.rules.label_length:
                self._fault(
                    catalogue.LABEL_LENGTH, line, text.find("[") + 1, text, name=name, limit=self.rules.label_length
                )
            elif name is not None and name not in section.names:
                if len(section.names) < self.rules.names:
                    section.names[name] = entry
                else:
                    self._note(catalogue.NAMES_FULL, entry, line, text, self.rules.names)
        if "$" not in text:
            return
        matches = [m for m in _CONTROL.finditer(text) if text.count('"', 0, m.start()) % 2 == 0]
        words = [match.group(1).upper() for match in matches]
        if "GOTO" in words:
            return
        if not words or words[0] not in _CONTROLS or not _HEAD.fullmatch(text, 0, matches[0].start()):
            return  # told by the parser
        self._control(entry, _CONTROLS[words[0]], line, matches[0].start() + 1, text)

    def _note(self, what: ErrorEntry, entry: int, line: int, text: str, limit: int) -> None:
        """A warning, the same one once per file."""
        if what not in self._noted:
            self._noted.add(what)
            self.notes.append(Fault(what, line, 1, text, {"limit": limit}))

    def _control(self, entry: int, control: Control, line: int, column: int, text: str) -> None:
        """Link a control statement with those of its structure."""
        links = self.links
        if control in (Control.BREAK, Control.CONTINUE):
            links[entry] = Link(control, -1, self._around)
            return
        opening = _OPENING.get(control)
        if opening is None:
            if len(self._open) >= MAX_CONTROL_DEPTH:
                self._fault(catalogue.CONTROL_DEPTH, line, column, text, limit=MAX_CONTROL_DEPTH)
                return
            links[entry] = Link(control, entry, self._around)
            self._open.append(entry)
            self._around = tuple(self._open)
            return
        first = self._open[-1] if self._open else -1
        if first < 0 or links[first].control is not opening:
            start = "$IF" if opening is Control.IF else opening.value
            self._fault(catalogue.CONTROL_WITHOUT_START, line, column, text, statement=control.value, start=start)
            links[entry] = Link(control, -1, self._around)
            return
        previous = first
        while links[previous].following >= 0:
            previous = links[previous].following
        if links[previous].control is Control.ELSE and control is not Control.ENDIF:
            self._fault(catalogue.CONTROL_WITHOUT_START, line, column, text, statement=control.value, start="$IF")
        links[previous].following = entry
        links[entry] = Link(control, first, tuple(self._open[:-1]))
        if control not in MIDDLE:
            self._open.pop()
            self._around = tuple(self._open)
            step = first
            while step >= 0:
                links[step].last = entry
                step = links[step].following

    def _comment_block(self, match: re.Match[str], blanked: str, text: str, offset: int, line: int) -> None:
        begins, column = match.group(1).upper() == "BEGIN", blanked.find("#") + 1
        inside = self._comment_depth > 0
        if begins:
            if not inside:
                self._comment_line = line
            self._comment_depth += 1
            if not self.rules.nested_comments:
                self._comment_depth = 1
        elif inside:
            self._comment_depth -= 1
        else:
            self._outside(offset, line)
            self._fault(catalogue.COMMENT_BLOCK_END, line, column, text)
        if blanked[match.end() :].strip() and not (begins and inside):
            self._outside(offset, line)
            self._fault(catalogue.NOT_ALONE, line, column, text, word=f"#COMMENT {match.group(1).upper()}")

    def _outside(self, offset: int, line: int) -> None:
        """An entry for a faulty line that is no block; a file that has nothing yet begins with it."""
        if not self._sections:
            self._begin("", False, line)
        if not (self._lines and self._lines[-1] == line):
            self._append(offset, line, 0)

    def _header(self, blanked: str, text: str, offset: int, line: int) -> None:
        """% NAME or %L NAME."""
        column = blanked.index("%") + 1
        match = _HEADER.match(blanked)
        assert match is not None
        name, local = match["name"], match["local"] is not None
        problem: tuple[ErrorEntry, int, dict[str, object]] | None = None
        if match["rest"].strip():
            problem = catalogue.HEADER_INVALID, match.start("rest") + 1, {"text": match["rest"].strip()}
        elif local and not name:
            problem = catalogue.HEADER_NAME, column, {}
        elif self._sections and not self._sections[-1].local:
            problem = catalogue.HEADER_LATE, column, {"name": name}
        elif local and name in self.local_programs:
            first = self.local_programs[name].line
            problem = catalogue.LOCAL_TWICE, column, {"name": name, "first": first}
        elif local and len(self.local_programs) >= self.rules.local_programs:
            problem = catalogue.LOCAL_PROGRAMS_MANY, column, {"name": name, "limit": self.rules.local_programs}
        if problem is not None:
            entry, at, values = problem
            if not self._sections:
                self._begin("", False, line)
            if self._sections[-1].end < 0:
                self._append(offset, line, 0)
                self._fault(entry, line, at, text, **values)
                return
        self._end_section()
        self._begin(name, local, line)

    def _begin(self, name: str, local: bool, line: int) -> None:
        section = Section(name, len(self), line, local)
        self._sections.append(section)
        if local:
            self.local_programs[name] = section
        else:
            self.main = section

    def _end_section(self) -> None:
        """The section that is open ends in front of the next entry."""
        if not self._sections or self._sections[-1].end >= 0:
            return
        for entry in self._open:
            control = self.links[entry].control
            text = self.block_text(entry).text
            fault = Fault(
                catalogue.CONTROL_OPEN,
                self.line(entry),
                text.find("$") + 1,
                text,
                {"statement": control.value, "end": _CLOSING[control].value},
            )
            self.faults.setdefault(entry, fault)
        self._open.clear()
        self._around = ()
        self._sections[-1].end = len(self)

    def _end_of_file(self) -> None:
        if self._comment_depth:
            self._comment_depth = 0
            if not self._sections:
                self._begin("", False, self._comment_line)
            self._append(self.text.size, self._comment_line, 0)
            self._fault(catalogue.COMMENT_BLOCK_OPEN, self._comment_line, 1, "")
        self._end_section()
        self.ended = True

    def sections(self) -> Iterator[Section]:
        """All sections that are known."""
        yield from self._sections


def without_comments(text: str) -> str:
    """The text with its comments blanked; as it is if they are faulty, which is told when the block is parsed."""
    try:
        return blank_comments(text)
    except LineError:
        return text


def _label_number(text: str) -> int | None:
    match = _LABEL_NUMBER.match(text)
    return int(match.group(1)) if match else None


def _label_name(text: str) -> str | None:
    match = _LABEL_NAME.match(text.lstrip())
    return match.group(1).upper() if match else None


_WITHOUT_NUMBER = re.compile(r"^\s*[Nn]\s*\d+(?![\w:])")


def _continued(text: str) -> int | None:
    """Where the backslash stands that ties the next line to this one, None without one."""
    if "\\" not in text:
        return None
    try:
        blanked = blank_comments(text).rstrip()
    except LineError:
        return None
    return len(blanked) - 1 if blanked.endswith("\\") and blanked.count('"') % 2 == 0 else None
