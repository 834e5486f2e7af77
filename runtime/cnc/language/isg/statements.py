"""# statements: their arguments are read as their registration says.

#NAME WORDS [KEY = value, KEY value]      keys may be glued to their values, commas and equals signs left out
#NAME X1 Y2                               axis words
#NAME expression                          one value
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import TYPE_CHECKING, NamedTuple

from runtime.cnc.language.isg import expressions
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind, StatementSyntax, Vocabulary
from runtime.cnc.language.isg.words import ADDITIONS, Argument, ParsedStatement
from runtime.diagnostics.catalogue import language as catalogue

if TYPE_CHECKING:
    from runtime.cnc.language.isg.parser import BlockParser

_WORD = re.compile(r"[A-Za-z_]+[A-Za-z0-9_.]*")
_START = re.compile(
    r"\"(?:\\.|[^\"\\])*\"|'[^']*'|(#)|((?<![A-Za-z0-9_.])LL?[ \t]+(?:CYCLE|SEQUENCE)(?=[ \t]*\[))"
    r"|((?<![\w.@#$])[A-CQU-Z]\w*[ \t]*\[[ \t]*OVERRIDE[ \t]+(?=FEED_FACT|RAPID_FACT))",
    re.IGNORECASE,
)
_ADDED = r"ADD|SUPPRESS[ \t]+OFFSETS"  # the statements that may stand beside other words
_INLINE = re.compile(rf"#(?:{'|'.join(ADDITIONS)}|{_ADDED})(?![A-Za-z0-9_])", re.IGNORECASE)
_BESIDE = re.compile(r"\"(?:\\.|[^\"\\])*\"|(#(?:" + _ADDED + r")(?![A-Za-z0-9_]))", re.IGNORECASE)
_BARE_NAME = re.compile(r"(?!V\.)[^ \t,\"]+", re.IGNORECASE)  # of a file or program, without quotes
_DIRECTION = re.compile(r"([A-Z][A-Za-z0-9_]*?)[ \t]*([+-])[ \t]*\Z")
_SPINDLE_NAME = re.compile(r"[Ss]\w*")
_SYSTEM_NAME = re.compile(r"(?!P\d+\Z)[A-Z_][A-Z0-9_]*", re.IGNORECASE)  # P1 is a parameter
_AXIS_NAME = re.compile(r"[ABCQUVWXYZ][A-Za-z0-9_]*")


class StatementStart(NamedTuple):
    """Where a statement begins in the text of its block (from 0), and whether it is one with #; behind the name of an axis,
    where its keys begin."""

    start: int
    hash: bool
    keys: int = 0


class Beside(NamedTuple):
    """A statement beside words: the block text with everything else blanked, and where it begins."""

    text: str
    at: StatementStart
    adds: bool  # #ADD


def statement_at(text: str) -> StatementStart | None:
    """The statement of a block that is nothing but a statement; None if the block has words."""
    for match in _START.finditer(text):
        if match.group(2):
            return StatementStart(match.start(), False)
        if match.group(3):
            return StatementStart(match.start(), False, match.end())
        if not match.group(1):
            continue  # a quoted text
        inline = _INLINE.match(text, match.start())
        if inline is None:
            return StatementStart(match.start(), True)
        return None
    return None


def beside_words(text: str) -> tuple[str, Beside | None]:
    """Block text without #ADD or #SUPPRESS OFFSETS, and that statement if there is one."""
    match = next((found for found in _BESIDE.finditer(text) if found.group(1)), None)
    if match is None:
        return text, None
    end = len(text)
    adds = "ADD" in match.group().upper()
    if not adds:  # the axis words behind it belong to the block
        bracket = re.compile(r"[ \t]*\[[^\]]*\]").match(text, match.end())
        end = bracket.end() if bracket else match.end()
    blank = " " * (end - match.start())
    alone = " " * match.start() + text[match.start() : end]
    return text[: match.start()] + blank + text[end:], Beside(alone, StatementStart(match.start(), True), adds)


class StatementParser:
    """Reads # statements and cycle calls; raises LineError."""

    def __init__(self, blocks: BlockParser, vocabulary: Vocabulary) -> None:
        self._blocks = blocks
        self._statements = {name.upper(): statement for name, statement in vocabulary.statements.items()}
        self._most_words = max((len(name.split()) for name in self._statements), default=1)

    def parse(self, text: str, at: StatementStart) -> ParsedStatement:
        """The statement that begins at `at`; `text` ends with the block."""
        if at.keys:
            return self._of_axis(text, at)
        syntax, end = self._named(text, at)
        arguments: tuple[Argument, ...] = ()
        rest = text[end:].strip()
        if rest or not syntax.optional:
            arguments = tuple(self._arguments(syntax, text, end))
        self._check(syntax, arguments, at.start + 1)
        return ParsedStatement(syntax, at.start + 1, arguments)

    def _of_axis(self, text: str, at: StatementStart) -> ParsedStatement:
        """<axis>[OVERRIDE ...] (programming manual 30364)."""
        syntax = self._statements["AXIS OVERRIDE"]
        opening = text.index("[", at.start)
        name = text[at.start : opening].strip()
        axis = self._blocks.addresses.axis(name)
        if axis < 0:
            axes = ", ".join(self._blocks.addresses.axes)
            raise LineError(catalogue.AXIS_UNKNOWN, at.start + 1, axis=name, axes=axes)
        end = _closing(text, opening)
        if end < 0:
            raise LineError(catalogue.BRACKET_OPEN, opening + 1)
        if text[end + 1 :].strip():
            raise self._not_understood(syntax, text, end + 1)
        keys = tuple(self._keys(syntax, text, at.keys, end))
        arguments = (Argument("AX", at.start + 1, text=name, index=axis), *keys)
        self._check(syntax, arguments, at.start + 1)
        return ParsedStatement(syntax, at.start + 1, arguments)

    def job(self, text: str, name: str, index: int, start: int, begin: int, end: int) -> ParsedStatement | None:
        """<axis>[MC_... keys]: what is registered as `name`, None if nothing is; its keys stand between `begin` and `end`."""
        syntax = self._statements.get(name.upper())
        if syntax is None:
            return None
        arguments = (Argument("AX", start + 1, index=index), *self._keys(syntax, text, begin, end))
        self._check(syntax, arguments, start + 1)
        return ParsedStatement(syntax, start + 1, arguments)

    def known(self, beginning: str) -> list[str]:
        """Names of registered statements that begin so."""
        return [syntax.name for syntax in self._statements.values() if syntax.name.startswith(beginning)]

    def _named(self, text: str, at: StatementStart) -> tuple[StatementSyntax, int]:
        """The statement with the longest name that fits, and where its arguments begin."""
        begin = position = at.start + (1 if at.hash else 0)
        if at.hash and text[position : position + 1].isspace():
            raise LineError(catalogue.STATEMENT_BLANK, at.start + 1)
        words: list[str] = []
        ends: list[int] = []
        while len(words) < self._most_words:
            match = _WORD.match(text, position)
            if match is None:
                break
            words.append(match.group().upper())
            ends.append(match.end())
            position = match.end()
            while text[position : position + 1] in (" ", "\t"):
                position += 1
        prefix = "" if at.hash else "CALL "
        for count in range(len(words), 0, -1):
            syntax = self._statements.get(prefix + " ".join(words[:count]))
            if syntax is not None:
                return syntax, ends[count - 1]
        for name, syntax in self._statements.items():  # a value glued to the name: #TIME2
            glued = (
                syntax.form is Form.VALUE and words and words[0].startswith(name) and words[0][len(name) :].isdigit()
            )
            if glued and not prefix:
                return syntax, at.start + 1 + len(name)
        name = " ".join(words) or text[begin : begin + 10].strip()
        entry = catalogue.STATEMENT_UNSUPPORTED if _is_known(words) else catalogue.STATEMENT_UNKNOWN
        raise LineError(entry, at.start + 1, name=name)

    # ------------------------------------------------------------------ arguments

    def _arguments(self, syntax: StatementSyntax, text: str, begin: int) -> Iterator[Argument]:
        form = syntax.form
        if form is Form.ALONE:
            if text[begin:].strip():
                raise self._not_understood(syntax, text, begin)
        elif form is Form.VALUE:
            position = _skip(text, begin, " \t=")
            value = self._blocks.expression(text[position:], position + 1)
            yield Argument("", position + 1, value)
        elif form in (Form.AXES, Form.AXIS_LIST):
            yield from self._axes(syntax, text, begin)
        elif form is Form.AXIS_BRACKET:
            yield from self._axis_bracket(syntax, text, begin)
        elif form is Form.VARIABLES:
            yield from self._variables(text, begin)
        elif form is Form.SYSTEM:
            yield from self._system(syntax, text, begin)
        else:
            yield from self._words(syntax, text, begin)

    def _axis_bracket(self, syntax: StatementSyntax, text: str, begin: int) -> Iterator[Argument]:
        """[X, Y=2] and nothing behind it."""
        opening = _skip(text, begin)
        if text[opening : opening + 1] != "[":
            raise self._not_understood(syntax, text, opening)
        end = _closing(text, opening)
        if end < 0:
            raise LineError(catalogue.BRACKET_OPEN, opening + 1)
        if text[end + 1 :].strip() or not text[opening + 1 : end].strip():
            raise self._not_understood(syntax, text, end + 1 if text[end + 1 :].strip() else opening)
        yield from self._axes(syntax, text[:end], opening + 1)

    def _system(self, syntax: StatementSyntax, text: str, begin: int) -> Iterator[Argument]:
        """[ID] [values]: a single bracket with one value is the ID. It is ID, with the name as `text`; of the values the place
        of each, from 0, is its `index`."""
        brackets: list[tuple[int, int]] = []
        position = _skip(text, begin)
        while text[position : position + 1] == "[" and len(brackets) < 2:
            end = _closing(text, position)
            if end < 0:
                raise LineError(catalogue.BRACKET_OPEN, position + 1)
            brackets.append((position + 1, end))
            position = _skip(text, end + 1)
        if text[position:].strip() or not brackets:
            raise self._not_understood(syntax, text, position)
        if len(brackets) == 2 or len(list(_parts(text, *brackets[0]))) == 1:
            start, stop = brackets.pop(0)
            name, column = text[start:stop].strip(), _skip(text, start) + 1
            if not name:
                raise self._not_understood(syntax, text, start - 1)
            if _SYSTEM_NAME.fullmatch(name):
                yield Argument("ID", column, text=name.upper())
            else:
                value = expressions.number(self._blocks.expression(text[column - 1 : stop], column), "ID", column)
                yield Argument("ID", column, value)
        for start, stop in brackets:
            yield from self._places(syntax, text, start, stop)

    def _words(self, syntax: StatementSyntax, text: str, begin: int) -> Iterator[Argument]:
        """Words, then a bracket with keys, a message or assignments."""
        position = _skip(text, begin)
        while (match := _WORD.match(text, position)) and syntax.words:
            word = match.group().upper()
            if word not in syntax.words:
                raise LineError(
                    catalogue.WORD_UNKNOWN, position + 1, word=word, key=_title(syntax), known=", ".join(syntax.words)
                )
            yield Argument("", position + 1, text=word)
            position = _skip(text, match.end())
        if text[position : position + 1] != "[":
            if text[position:].strip() or not syntax.optional:
                raise self._not_understood(syntax, text, position)
            return
        end = _closing(text, position)
        if end < 0:
            raise LineError(catalogue.BRACKET_OPEN, position + 1)
        after = _skip(text, end + 1)
        if syntax.form is Form.MESSAGE:
            yield from self._message(syntax, text, position + 1, end)
        elif syntax.form is Form.ASSIGNMENTS:
            yield from self._assignments(syntax, text, position + 1, end)
        elif syntax.form is Form.PLACES:
            yield from self._places(syntax, text, position + 1, end)
        elif syntax.form is Form.PAIRS:
            yield from self._pairs(syntax, text, position + 1, end)
        elif syntax.form is Form.SPINDLE:
            yield self._spindle(text, position + 1, end)
        elif syntax.form is Form.DIRECTION:
            yield self._direction(syntax, text, position + 1, end)
        else:
            yield from self._keys(syntax, text, position + 1, end)
        if text[after:].strip():
            if syntax.name.startswith("SUPPRESS OFFSETS"):
                yield from self._axes(syntax, text, after)
            else:
                raise self._not_understood(syntax, text, after)

    def _keys(self, syntax: StatementSyntax, text: str, begin: int, end: int) -> Iterator[Argument]:
        pattern = _key_pattern(syntax.keys)
        position = _skip(text, begin, " \t,")
        while position < end:
            match = pattern.match(text, position, end)
            if match is None:
                known = ", ".join(key.name for key in syntax.keys)
                found = text[position:end].split()[0].split("=")[0].split(",")[0]
                raise LineError(catalogue.KEY_UNKNOWN, position + 1, key=found, statement=_title(syntax), known=known)
            key, index = _matched(syntax.keys, match)
            column, position = position + 1, _skip(text, match.end())
            if key.kind is KeyKind.TARGET:
                stop = _value_end(text, position, end, pattern)
                path = text[match.start() : match.end()]
                value = self._blocks.expression(
                    text[_skip(text, position, " \t=") : stop], _skip(text, position, " \t=") + 1
                )
                yield Argument(key.name, column, value, path, index)
                position = _skip(text, stop, " \t,")
                continue
            if key.kind is KeyKind.LABEL:
                yield Argument(key.name, column, text=match.group()[1:-1].strip().upper())
                position = _skip(text, position, " \t,")
                continue
            if key.kind is KeyKind.FLAG:
                yield Argument(key.name, column, index=index)
                position = _skip(text, position, " \t,")
                continue
            if key.kind is KeyKind.SWITCH and _bare(text, position, end, pattern):
                yield Argument(key.name, column, index=index)
                position = _skip(text, position, " \t,")
                continue
            position = _skip(text, position, " \t=")
            stop = _value_end(text, position, end, pattern)
            if key.kind is KeyKind.NAME and (bare := _BARE_NAME.match(text, position, stop)):
                stop = bare.end()
            value_text = text[position:stop].strip(" \t,")
            if not value_text:
                raise LineError(catalogue.VALUE_MISSING, column, address=key.name)
            yield self._value(syntax, key, index, value_text, position + 1)
            position = _skip(text, stop, " \t,")

    def _value(self, syntax: StatementSyntax, key: Key, index: int, text: str, column: int) -> Argument:
        if key.kind is KeyKind.AXIS:
            axis = self._blocks.addresses.axis(text)
            if axis < 0:
                axes = ", ".join(self._blocks.addresses.axes)
                raise LineError(catalogue.AXIS_UNKNOWN, column, axis=text, axes=axes)
            return Argument(key.name, column, text=text, index=axis)
        if key.kind is KeyKind.WORD:
            if text.upper() not in key.words:
                raise LineError(catalogue.WORD_UNKNOWN, column, word=text, key=key.name, known=", ".join(key.words))
            return Argument(key.name, column, text=text.upper(), index=index)
        if key.kind is KeyKind.NAME and text[0] != '"' and not text.upper().startswith("V."):
            return Argument(key.name, column, expressions.text(text), text, index)
        if key.kind is KeyKind.MACHINE_AXIS:
            addresses = self._blocks.addresses
            if text in (*addresses.axes, *addresses.other_axes):
                return Argument(key.name, column, text=text)
        value = self._blocks.expression(text, column)
        if key.kind in (KeyKind.NUMBER, KeyKind.SWITCH, KeyKind.MACHINE_AXIS):
            value = expressions.number(value, key.name, column)
        elif key.kind in (KeyKind.STRING, KeyKind.NAME):
            value = expressions.string(value, key.name, column)
        return Argument(key.name, column, value, index=index)

    def _message(self, syntax: StatementSyntax, text: str, begin: int, end: int) -> Iterator[Argument]:
        for number, (start, stop) in enumerate(_parts(text, begin, end)):
            value = self._blocks.expression(text[start:stop], start + 1)
            if number == 0:
                value = expressions.string(value, _title(syntax), start + 1)
            yield Argument("TEXT" if number == 0 else "VALUE", start + 1, value)

    def _assignments(self, syntax: StatementSyntax, text: str, begin: int, end: int) -> Iterator[Argument]:
        """P1=X, V.P.POS=Y: what is assigned to, and an axis."""
        for start, stop in _parts(text, begin, end):
            left, equals, right = text[start:stop].partition("=")
            if not equals:
                raise self._not_understood(syntax, text, start)
            name = right.strip()
            axis = self._blocks.addresses.axis(name)
            if axis < 0:
                column = start + len(left) + 2
                axes = ", ".join(self._blocks.addresses.axes)
                raise LineError(catalogue.AXIS_UNKNOWN, column, axis=name, axes=axes)
            yield Argument(left.strip(), start + 1, index=axis, target=self._blocks.written(left, start + 1))

    def _places(self, syntax: StatementSyntax, text: str, begin: int, end: int) -> Iterator[Argument]:
        """1,,P3: the place of each value, from 0, is its `index`."""
        for place, (start, stop) in enumerate(_parts(text, begin, end)):
            if text[start:stop].strip():
                value = expressions.number(
                    self._blocks.expression(text[start:stop], start + 1), _title(syntax), start + 1
                )
                yield Argument("", start + 1, value, index=place)

    def _pairs(self, syntax: StatementSyntax, text: str, begin: int, end: int) -> Iterator[Argument]:
        """1, Z=Y: GROUP, then SLAVE and MASTER of each pair, names as `text`, everything else as numbers."""
        for number, (start, stop) in enumerate(_parts(text, begin, end)):
            if number == 0:
                value = self._blocks.expression(text[start:stop], start + 1)
                yield Argument("GROUP", start + 1, expressions.number(value, _title(syntax), start + 1))
                continue
            left, equals, right = text[start:stop].partition("=")
            if not equals or left.lstrip().startswith("["):
                raise self._not_understood(syntax, text, start)
            for key, part, at in (("SLAVE", left, start), ("MASTER", right, start + len(left) + 1)):
                yield self._axis_or_number(syntax, key, part.strip(), _skip(text, at) + 1)
        if number == 0:
            raise self._not_understood(syntax, text, end)

    def _axis_or_number(self, syntax: StatementSyntax, key: str, text: str, column: int) -> Argument:
        if _AXIS_NAME.fullmatch(text) and not text.startswith("V."):
            return Argument(key, column, text=text)
        value = expressions.number(self._blocks.expression(text, column), _title(syntax), column)
        return Argument(key, column, value)

    def _spindle(self, text: str, begin: int, end: int) -> Argument:
        """S2, or an expression for the logical axis number."""
        start = _skip(text, begin)
        name = text[start:end].strip()
        if self._blocks.addresses.has_spindle(name):
            return Argument("", start + 1, text=name)
        if _SPINDLE_NAME.fullmatch(name):
            spindles = ", ".join(self._blocks.addresses.spindles)
            raise LineError(catalogue.SPINDLE_UNKNOWN, start + 1, spindle=name, spindles=spindles)
        value = expressions.number(self._blocks.expression(text[start:end], start + 1), "#MAIN SPINDLE", start + 1)
        return Argument("", start + 1, value)

    def _direction(self, syntax: StatementSyntax, text: str, begin: int, end: int) -> Argument:
        """Z+: the sign is the `text`, the axis the `index`."""
        start = _skip(text, begin)
        match = _DIRECTION.match(text, start, end)
        if match is None:
            raise self._not_understood(syntax, text, start)
        axis = self._blocks.addresses.axis(match[1])
        if axis < 0:
            axes = ", ".join(self._blocks.addresses.axes)
            raise LineError(catalogue.AXIS_UNKNOWN, start + 1, axis=match[1], axes=axes)
        return Argument("", start + 1, text=match[2], index=axis)

    def _axes(self, syntax: StatementSyntax, text: str, begin: int) -> Iterator[Argument]:
        position = _skip(text, begin)
        while position < len(text.rstrip()):
            name = self._axis_name(text, position)
            if name is None:
                raise self._not_understood(syntax, text, position)
            axis = self._blocks.addresses.axis(name)
            if axis < 0:
                axes = ", ".join(self._blocks.addresses.axes)
                raise LineError(catalogue.AXIS_UNKNOWN, position + 1, axis=name, axes=axes)
            column = position + 1
            position = _skip(text, position + len(name), " \t=")
            stop = position if text[position : position + 1] == "," else self._axis_value_end(text, position)
            given = text[position:stop].strip()
            value = self._blocks.expression(given, position + 1) if given else None
            if value is None and syntax.form is Form.AXES:
                raise LineError(catalogue.VALUE_MISSING, column, address=name)
            if value is not None:
                value = expressions.number(value, name, column)
            yield Argument(name, column, value, index=axis)
            position = _skip(text, stop, " \t,")

    def _axis_name(self, text: str, position: int) -> str | None:
        """X of X1, X1 of X1=5, and the longest axis name of the channel where no value follows."""
        match = _AXIS_NAME.match(text, position)
        if match is None:
            return None
        name = match.group()
        if (
            text[_skip(text, match.end()) : _skip(text, match.end()) + 1] == "="
            or self._blocks.addresses.axis(name) >= 0
        ):
            return name
        return name[0]

    def _axis_value_end(self, text: str, position: int) -> int:
        """Where the value of an axis word ends: in front of the next axis name that does not belong to it."""
        depth, i = 0, position
        while i < len(text):
            c = text[i]
            if c in "[":
                depth += 1
            elif c == "]":
                depth -= 1
            elif depth == 0 and i > position and c == ",":
                return i
            elif depth == 0 and (i == position or not (text[i - 1].isalpha() or text[i - 1] in "_.")):
                name = self._axis_name(text, i)
                if name is not None and self._blocks.addresses.axis(name) >= 0 and text[i : i + 2].upper() != "V.":
                    return i
            i += 1
        return len(text)

    def _variables(self, text: str, begin: int) -> Iterator[Argument]:
        for start, stop in _parts(text, begin, len(text)):
            path = text[start:stop].strip()
            place = self._blocks.place(path, start + 1)
            indices = (place.number,) if place.number is not None else place.indices
            yield Argument(path, start + 1, text=place.path, indices=indices)

    # ------------------------------------------------------------------ rules

    def _check(self, syntax: StatementSyntax, arguments: tuple[Argument, ...], column: int) -> None:
        seen: set[tuple[str, int]] = set()
        for argument in arguments:
            if syntax.form is Form.KEYS and argument.name:
                many = argument.name in ("AX", "AXNR", "P", "N", "LABEL") or syntax.name.startswith("#")
                many |= any(key.many for key in syntax.keys if key.name == argument.name)
                if (argument.name, argument.index) in seen and not many:
                    raise LineError(catalogue.KEY_TWICE, argument.column, key=argument.name, statement=_title(syntax))
                seen.add((argument.name, argument.index))
        given = {argument.name for argument in arguments}
        for key in syntax.keys:
            if key.needed and key.name not in given and (arguments or not syntax.optional):
                raise LineError(
                    catalogue.KEY_MISSING, column, key=key.name, statement=_title(syntax), syntax=syntax.syntax[0]
                )

    def _not_understood(self, syntax: StatementSyntax, text: str, position: int) -> LineError:
        found = text[position:].strip()
        if not found:
            return LineError(
                catalogue.KEY_MISSING, position + 1, key="arguments", statement=_title(syntax), syntax=syntax.syntax[0]
            )
        return LineError(
            catalogue.STATEMENT_ARGUMENTS,
            _skip(text, position) + 1,
            found=found[:20],
            statement=_title(syntax),
            syntax=syntax.syntax[0],
        )


def _title(syntax: StatementSyntax) -> str:
    return syntax.prefix + syntax.name.removeprefix("CALL ")


def _skip(text: str, position: int, what: str = " \t") -> int:
    while position < len(text) and text[position] in what:
        position += 1
    return position


def _closing(text: str, opening: int) -> int:
    """Index of the bracket that closes the one at `opening`, -1 if there is none."""
    depth, quoted, i = 0, False, opening
    while i < len(text):
        c = text[i]
        if quoted:
            if c == "\\":
                i += 1
            quoted = c != '"'
        elif c == '"':
            quoted = True
        elif c == "[":
            depth += 1
        elif c == "]":
            depth -= 1
            if depth == 0:
                return i
        i += 1
    return -1


def _parts(text: str, begin: int, end: int) -> Iterator[tuple[int, int]]:
    """The parts between commas outside brackets and quotes, without surrounding blanks."""
    depth, quoted, start, i = 0, False, begin, begin
    while i <= end:
        c = text[i] if i < end else ","
        if quoted:
            if c == "\\":
                i += 1
            elif c == '"':
                quoted = False
            if i >= end:
                yield _skip(text, start), end
        elif c == '"':
            quoted = True
        elif c == "[":
            depth += 1
        elif c == "]":
            depth -= 1
        elif c == "," and (depth <= 0 or i == end):
            yield _skip(text, start), i
            start = i + 1
        i += 1


def _key_pattern(keys: tuple[Key, ...]) -> re.Pattern[str]:
    """One alternative per key, longest first; a name may be glued to what follows unless the key takes nothing."""
    alternatives = []
    for number, key in sorted(enumerate(keys), key=lambda pair: -len(pair[1].name)):
        name = re.escape(key.name)
        if key.kind is KeyKind.TARGET:
            name = key.name
        elif key.indexed:
            name += r"(\d+)"
        elif key.kind is KeyKind.FLAG:
            name += r"(?![A-Za-z0-9_])"
        elif key.kind in (KeyKind.AXIS, KeyKind.WORD, KeyKind.NAME):
            name += r"(?=[ \t=\"])"
        elif key.kind is KeyKind.LABEL:
            name = r"\[[ \t]*[A-Za-z_][A-Za-z0-9_]*[ \t]*\]"
        else:
            name += r"(?![A-OQ-UW-Z_](?![A-Za-z_0-9]*\[))"
        alternatives.append(f"(?P<k{number}>{name})")
    return re.compile("|".join(alternatives) or r"(?!)", re.IGNORECASE)


def _matched(keys: tuple[Key, ...], match: re.Match[str]) -> tuple[Key, int]:
    group = match.lastgroup
    for number, key in enumerate(keys):
        if match.group(f"k{number}") is not None:
            digits = re.search(r"\d+$", match.group(f"k{number}")) if key.indexed else None
            index = int(digits.group()) if digits else -1
            if key.indexed and not key.indexed[0] <= index <= key.indexed[1]:
                raise LineError(
                    catalogue.KEY_UNKNOWN,
                    match.start() + 1,
                    key=match.group(),
                    statement="the statement",
                    known=f"{key.name}{key.indexed[0]} to {key.name}{key.indexed[1]}",
                )
            return key, index
    raise AssertionError(group)


def _bare(text: str, position: int, end: int, pattern: re.Pattern[str]) -> bool:
    """Whether a key whose value may be left out has none: a comma, the next key or the end follows."""
    return position >= end or text[position] == "," or pattern.match(text, position, end) is not None


def _value_end(text: str, position: int, end: int, pattern: re.Pattern[str]) -> int:
    """Where a value ends: at a comma or in front of the next key, outside brackets and quotes."""
    depth, quoted, i = 0, False, position
    while i < end:
        c = text[i]
        if quoted:
            if c == "\\":
                i += 1
            elif c == '"':
                quoted = False
        elif c == '"':
            quoted = True
        elif c == "[":
            if depth == 0 and i > position and text[i - 1] in ' \t"]' and pattern.match(text, i, end):
                return i  # a label
            depth += 1
        elif c == "]":
            depth -= 1
        elif (depth == 0 and c == ",") or (
            depth == 0
            and i > position
            and not (text[i - 1].isalpha() or text[i - 1] in "_.@")
            and pattern.match(text, i, end)
        ):
            return i
        i += 1
    return end


def _is_known(words: list[str]) -> bool:
    return bool(words) and words[0] in _KNOWN


# First words of statements that the dialect has and this version has not yet.
_KNOWN_WORDS = """
    ACHSE ACS AKIMA AX BACKWARD BCS BLOCK BLOCKSEARCH CACHE CALL CAX CAXTRACK CHANNEL CLAMP CLEAR COMMAND
    CONTOUR CONTROL CORNER CS CYCL CYL DEL DISABLE DIST DISTANCE DRIVE DYNAMIC ECS EDGE EDM ELECTRODE ENABLE
    EXPL EXPORT EXTCOMP FACE FF FGROUP FILTER FREE FRICTION GANTRY GEAR GET HANDWHEEL HSC IDENT JOG KIN LAH
    LIMIT LOAD LOCK MACHINE MAIN MANUAL MCS MEAS NIBBLE OPTIONAL ORI OTC OVERRIDE PSC PTP PUNCH PUT ROUTE RTCP
    SAVE SCENE SEGMENTATION SET SHIFT SIGNAL SINGLE SINGULARITY SLOPE SPLINE STOP STROKE SYNC SYNCH TANGFEED
    TLC TRACK TRAFO TRANSFORM TRANSVELMIN TRC TURN UNLOCK VECTOR VECTORACC VECTORVEL VIB VOLCOMP WAIT
    WCS
"""
_KNOWN = frozenset(_KNOWN_WORDS.split())
