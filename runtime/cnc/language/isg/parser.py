"""One block of text → `ParsedBlock`, with everything checked that can be checked without executing it."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import cache
from importlib import resources

from lark import Lark, Token, Transformer, UnexpectedInput, v_args

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg import expressions
from runtime.cnc.language.isg.brackets import take_brackets
from runtime.cnc.language.isg.comments import LineError, blank_comments
from runtime.cnc.language.isg.environment import Access, Environment
from runtime.cnc.language.isg.job_brackets import take_jobs
from runtime.cnc.language.isg.macros import define_and_replace, g_expressions
from runtime.cnc.language.isg.numeric_blocks import numeric_block
from runtime.cnc.language.isg.returning import parse_return
from runtime.cnc.language.isg.statements import StatementParser, beside_words, statement_at
from runtime.cnc.language.isg.syntax import Group, GSyntax, Values, Vocabulary
from runtime.cnc.language.isg.syntax_errors import explain
from runtime.cnc.language.isg.words import (
    Control,
    ControlStatement,
    Expression,
    ParsedBlock,
    ParsedStatement,
    ValueKind,
    Word,
    WordKind,
)
from runtime.cnc.language.text import MAX_BLOCK
from runtime.diagnostics.catalogue import language as catalogue
from runtime.kernel_cache import CACHE

GRAMMAR_TABLES = "block.lark.tables"  # Lark sees by itself whether they are those of the grammar and of its own version
MAX_PARAMETER = 2**31 - 1
SKIP_LEVELS = 10
SPINDLE_M = (3, 4, 5)
POSITIONING_M = 19
GEAR_M = range(40, 46)
INTERNAL_M = (0, 1, 2, 17, 29, 30)  # reserved numbers that work without a configuration (line 6606)
TOOL_CHANGE_M = 6

# Numbers that the dialect knows, as ranges from–to; those not registered are refused as "not supported yet"
# instead of "unknown".
# fmt: off
_KNOWN_RANGES = (
    (0, 5), (8, 13), (17, 23), (25, 26), (33, 33), (40, 42), (51, 61), (63, 63), (66, 66), (68, 71), (74, 74),
    (80, 102), (106, 108), (112, 112), (115, 117), (127, 141), (150, 151), (159, 167), (193, 194), (196, 196),
    (200, 202), (230, 231), (233, 233), (236, 239), (260, 261), (293, 293), (301, 303), (310, 310), (331, 334),
    (338, 339), (351, 351), (359, 360), (800, 839), (900, 901),
)
# fmt: on
G_NUMBERS = frozenset(number for first, last in _KNOWN_RANGES for number in range(first, last + 1))

_SIGNS = re.compile(r"(?:@[A-Za-z]|[A-Z](?:[A-Za-z0-9_]*(?=[ \t]*=))?)[ \t]*=?[ \t]*([+-](?:[ \t]*[+-])?)")
_CONSTANTS = {"TRUE": 1.0, "FALSE": 0.0, "PI": 3.141592653589793}
_CONTROLS = {control.value: control for control in Control}
_ONCE = {
    WordKind.RADIUS: "R",
    WordKind.FEED: "F",
    WordKind.END_FEED: "E",
    WordKind.SPEED: "S",
    WordKind.TOOL: "T",
    WordKind.TOOL_DATA: "D",
    WordKind.DWELL: "G04",
    WordKind.RETURN: "M17",
    WordKind.SPINDLE_POSITION: "S.POS",
    WordKind.SPINDLE_OFFSET: "S.OFFSET",
}
_ADDRESSES = {
    "FEED": WordKind.FEED,
    "END_FEED": WordKind.END_FEED,
    "TOOL": WordKind.TOOL,
    "TOOL_DATA": WordKind.TOOL_DATA,
}
_NEUTRAL_AXES = "XYZ"
_NEUTRAL_LETTERS = "IJK"


def _column(token: Token) -> int:
    return token.column or 0


class _Path:
    """A variable or parameter of the text: its path with [] for indices, the indices, and where it stands."""

    __slots__ = ("column", "indices", "number", "path")

    def __init__(
        self, path: str, indices: tuple[Expression, ...], column: int, number: Expression | None = None
    ) -> None:
        self.path = path
        self.indices = indices
        self.column = column
        self.number = number  # of a P parameter without indices, as source


@v_args(inline=True)
class _Builder(Transformer[Token, ParsedBlock]):
    """Called by the parser bottom-up while it reduces; nothing is kept between blocks.

    `addresses` and `environment`, set before each block, resolve names.
    """

    environment: Environment

    def __init__(self, addresses: Addresses) -> None:
        super().__init__()
        self._addresses = addresses

    # -- expressions

    def literal(self, token: Token) -> Expression:
        return expressions.literal(token, _column(token))

    def based_literal(self, token: Token) -> Expression:
        return expressions.based_literal(token, _column(token))

    def text(self, token: Token) -> Expression:
        return expressions.text(unquoted(token))

    def constant(self, token: Token) -> Expression:
        value = _CONSTANTS[token.upper()]
        return Expression(repr(value), constant=value)

    def binary(self, left: Expression, operator: Token, right: Expression) -> Expression:
        return expressions.binary(left, operator, right, _column(operator))

    def sign(self, operator: Token, operand: Expression) -> Expression:
        return expressions.signed(operator, operand, _column(operator))

    def call(self, name: Token, *arguments: Expression) -> Expression:
        if name.upper() in ("MACRO_LENGTH", "MACRO_CONTENT"):
            kind = ValueKind.NUMBER if name.upper() == "MACRO_LENGTH" else ValueKind.STRING
            if len(arguments) != 1:
                raise LineError(
                    catalogue.FUNCTION_ARGUMENTS, _column(name), function=name.upper(), expected=1, given=len(arguments)
                )
            return expressions.named_call(name.lower(), arguments, _column(name), kind)
        return expressions.call(name, arguments, _column(name))

    def index(self, value: Expression) -> Expression:
        return value

    def parameter(self, token: Token, *indices: Expression) -> _Path:
        """P12 → "12"; PP12 → the number that stands in P12."""
        levels = len(token) - len(token.lstrip("Pp"))
        number = int(token[levels:])
        if not 1 <= number <= MAX_PARAMETER:
            raise LineError(catalogue.PARAMETER_INDEX, _column(token), value=float(number))
        source = Expression(str(number), constant=float(number))
        return self._parameter(source, levels, indices, _column(token))

    def parameter_computed(self, opening: Token, number: Expression, *indices: Expression) -> _Path:
        source = expressions.parameter(expressions.number(number, "P[", _column(opening)), _column(opening))
        return self._parameter(source, len(opening) - 1, indices, _column(opening))

    def _parameter(self, source: Expression, levels: int, indices: tuple[Expression, ...], column: int) -> _Path:
        for _ in range(levels - 1):
            source = expressions.parameter(expressions.read(source.source, source.depth, source.flush), column)
        if indices:
            return _Path("P[]" + "[]" * len(indices), (source, *indices), column)
        return _Path("P", (), column, source)

    def transfer(self, token: Token) -> _Path:
        number = Expression(token[2:], constant=float(token[2:]))
        return _Path("@P[]", (number,), _column(token))

    def transfer_computed(self, opening: Token, number: Expression) -> _Path:
        return _Path("@P[]", (number,), _column(opening))

    def variable(self, name: Token, *rest: Expression | Token) -> _Path:
        path, indices = str(name), []
        for part in rest:
            if isinstance(part, Expression):
                path += "[]"
                indices.append(part)
            else:
                path += str(part)
        return _Path(path, tuple(indices), _column(name))

    def read(self, place: _Path) -> Expression:
        if place.number is not None:
            return expressions.read(place.number.source, place.number.depth, place.number.flush)
        access = self.environment.read(place.path, place.column)
        return expressions.access(access.name, place.indices, place.column, access.kind, access.flush)

    def exists(self, name: Token, place: _Path) -> Expression:
        if place.number is not None:
            return expressions.exists(place.number, "p", _column(name))
        return expressions.access(self.environment.exists(place.path), place.indices, _column(name))

    def exists_function(self, name: Token, letter: Token, number: Expression) -> Expression:
        rounded = Expression(f"round_half_up({number.source})", depth=number.depth + 1)
        return expressions.exists(rounded, "known_m" if letter.upper() == "M" else "known_h", _column(name))

    def exists_macro(self, name: Token, macro: Token) -> Expression:
        return Expression(f"(1.0 if macro({unquoted(macro)!r}) is not None else 0.0)")

    def size(self, name: Token, place: _Path, dimension: Expression | None) -> Expression:
        path = place.path
        given: tuple[Expression, ...] = ()
        if place.number is not None:
            path, given = "P[]", (place.number,)
        elif path.startswith("P[]"):
            given = place.indices[:1]
        wanted = dimension or Expression("1.0", constant=1.0)
        return expressions.access(self.environment.size(path), (wanted, *given), _column(name))

    def only(self, value: Expression) -> Expression:
        return value

    def target(self, place: _Path) -> _Path:
        return place

    # -- words

    def axis(self, name: Token, value: Expression) -> Word:
        return Word(WordKind.AXIS, _column(name), self._value(value, name), self._axis(name), name=str(name))

    def _axis(self, name: Token) -> int:
        index = self._addresses.axis(name)
        if index < 0:
            axes = ", ".join(self._addresses.axes)
            raise LineError(catalogue.AXIS_UNKNOWN, _column(name), axis=str(name), axes=axes)
        return index

    def _value(self, value: Expression, name: Token | str) -> Expression:
        return expressions.number(value, str(name), _column(name) if isinstance(name, Token) else 0)

    def neutral(self, name: Token, value: Expression) -> Word:
        """@X … @K: the main axes and their circle centres, whatever their names (lines 7536–7562)."""
        letter, value = name[1:].upper(), self._value(value, name)
        if letter in _NEUTRAL_AXES:
            index = _NEUTRAL_AXES.index(letter)
            if index >= len(self._addresses.axes):
                raise LineError(
                    catalogue.AXIS_UNKNOWN, _column(name), axis=str(name), axes=", ".join(self._addresses.axes)
                )
            return Word(WordKind.AXIS, _column(name), value, index, name=self._addresses.axes[index])
        if letter in _NEUTRAL_LETTERS:
            return Word(WordKind.INTERPOLATION, _column(name), value, _NEUTRAL_LETTERS.index(letter), name=letter)
        self._check_spindle(name)
        return Word(WordKind.SPEED, _column(name), value)

    def interpolation(self, letter: Token, value: Expression) -> Word:
        index = "IJK".index(letter.upper())
        return Word(WordKind.INTERPOLATION, _column(letter), self._value(value, letter), index, name=letter.upper())

    def radius(self, letter: Token, value: Expression) -> Word:
        return Word(WordKind.RADIUS, _column(letter), self._value(value, letter))

    def _plain(self, letter: Token, value: Expression) -> Word:
        return Word(_ADDRESSES[letter.type], _column(letter), self._value(value, letter))

    feed = end_feed = tool = tool_data = _plain

    def speed(self, name: Token, value: Expression) -> Word:
        self._check_spindle(name)
        return Word(WordKind.SPEED, _column(name), self._value(value, name), name=str(name))

    def spindle_position(self, name: Token, value: Expression) -> Word:
        spindle = str(name).rpartition(".")[0]
        self._check_spindle(name, spindle)
        return Word(WordKind.SPINDLE_POSITION, _column(name), self._value(value, name), name=spindle)

    def spindle_offset(self, name: Token, value: Expression) -> Word:
        spindle = str(name).rpartition(".")[0]
        self._check_spindle(name, spindle)
        return Word(WordKind.SPINDLE_OFFSET, _column(name), self._value(value, name), name=spindle)

    def function_word(self, letter: Token, number: Expression, extra: Expression | None) -> Word:
        kind = WordKind.M if letter.upper() == "M" else WordKind.H
        extra = extra and self._value(extra, letter)
        return Word(kind, _column(letter), self._value(number, letter), extra=extra)

    def returning(self, token: Token) -> Word:
        return Word(WordKind.RETURN, _column(token), index=int(token[1 : token.index("[")]), name=str(token))

    def g(self, token: Token, value: Expression | None = None) -> Word:
        return Word(WordKind.G, _column(token), value and self._value(value, token), int(token[1:]))

    def g_values(self, token: Token, *values: Expression | None) -> Word:
        return Word(WordKind.G, _column(token), index=int(token[1:]), values=values, name="[")

    def dwell(self, token: Token, value: Expression) -> Word:
        return Word(WordKind.DWELL, _column(token), self._value(value, token))

    def dwell_address(self, token: Token, name: Token, value: Expression) -> Word:
        if name.type in ("SPEED", "SPINDLE_NAME"):
            self._check_spindle(name)
            return Word(WordKind.DWELL, _column(token), self._value(value, token), 1)
        if name != self._addresses.axes[0]:
            first = self._addresses.axes[0]
            raise LineError(catalogue.DWELL_AXIS, _column(name), axis=first, address=str(name))
        return Word(WordKind.DWELL, _column(token), self._value(value, token))

    def addition(self, name: Token, value: Expression) -> Word:
        return Word(WordKind.ADDITION, _column(name), self._value(value, name), name=name[1:].upper())

    def assignment(self, place: _Path, value: Expression) -> Word:
        return Word(WordKind.ASSIGNMENT, place.column, value, target=self._written(place), name=place.path)

    def assignment_changed(self, place: _Path, operator: Token, value: Expression) -> Word:
        """V.G.NP[1].ALL += …"""
        return self.assignment(place, expressions.binary(self.read(place), operator[0], value, _column(operator)))

    def _written(self, place: _Path) -> str:
        """The source of a write access, `{}` where the value stands."""
        if place.number is not None:
            return place.number.source
        access: Access = self.environment.write(place.path, place.column)
        indices = "".join(f", {expressions.number(index, 'index', place.column).source}" for index in place.indices)
        return f"{access.name}({{}}{indices})"

    def list(self, *values: Expression) -> tuple[Expression, ...]:
        return tuple(value for value in values if isinstance(value, Expression))

    def type(self, name: Token, size: Token | None = None) -> str:
        return name.upper() if size is None else f"{name.upper()}[{int(float(size))}]"

    def declaration(self, place: _Path, values: tuple[Expression, ...] = ()) -> Word:
        return self._declared(place, "", values)

    def typed(self, place: _Path, name: str, values: tuple[Expression, ...] | Expression = ()) -> Word:
        return self._declared(place, name, (values,) if isinstance(values, Expression) else values)

    def _declared(self, place: _Path, name: str, values: tuple[Expression, ...]) -> Word:
        indices = (place.number,) if place.number is not None else place.indices
        return Word(WordKind.DECLARATION, place.column, target=name, name=place.path, values=values, indices=indices)

    def call_local(self, token: Token) -> Word:
        return Word(WordKind.CALL_LOCAL, _column(token), name=token[2:].strip())

    def call_global(self, token: Token) -> Word:
        return Word(WordKind.CALL_GLOBAL, _column(token), name=token[1:].strip())

    def _check_spindle(self, token: Token, name: str = "") -> None:
        """The channel has this spindle; whether it is the main spindle is seen when the block is executed."""
        spindles, name = self._addresses.spindles, name or str(token)
        if not spindles:
            raise LineError(catalogue.SPINDLE_MISSING, _column(token), word=name)
        if len(name) > 1 and name[0] != "@" and not self._addresses.has_spindle(name):
            raise LineError(catalogue.SPINDLE_UNKNOWN, _column(token), spindle=name, spindles=", ".join(spindles))

    # -- jumps, control statements, blocks

    def goto_number(self, token: Token, _: Token, number: Expression, __: Token | None) -> Word:
        return Word(WordKind.GOTO, _column(token), self._value(number, "N"))

    def goto_label(self, token: Token, label: Token) -> Word:
        return Word(WordKind.GOTO, _column(token), name=label[1:-1].strip().upper())

    def goto_variable(self, token: Token, place: _Path) -> Word:
        return Word(WordKind.GOTO, _column(token), expressions.string(self.read(place), "$GOTO", _column(token)))

    def condition(self, token: Token, value: Expression, goto: Word | None = None) -> ControlStatement:
        return ControlStatement(_CONTROLS[token.upper()], _column(token), (self._value(value, token),), goto=goto)

    def assigned_switch(self, token: Token, place: _Path, value: Expression) -> ControlStatement:
        """$SWITCH P1=…: assigns and branches by what was assigned."""
        return ControlStatement(
            Control.SWITCH, _column(token), (self._value(value, token),), target=self._written(place)
        )

    def counting(
        self, token: Token, place: _Path, start: Expression, end: Expression, step: Expression
    ) -> ControlStatement:
        parts = tuple(self._value(part, token) for part in (start, end, step))
        written = self._written(place)
        counter = self._value(self.read(place), token)
        return ControlStatement(Control.FOR, _column(token), parts, written, counter)

    def plain_control(self, token: Token) -> ControlStatement:
        return ControlStatement(_CONTROLS[token.upper()], _column(token))

    def number(self, letter: Token, value: Expression, _: Token | None) -> Expression:
        return self._value(value, letter)

    def head(self, skip: Token | None, number: Expression | None, label: Token | None) -> ParsedBlock:
        level = 0
        if skip is not None:
            level = int(skip[1:].strip() or 1)
            if not 1 <= level <= SKIP_LEVELS:
                raise LineError(catalogue.SKIP_LEVEL, _column(skip), level=level)
        return ParsedBlock(number=number, skip_level=level, label=label[1:-1].strip().upper() if label else "")

    def block(
        self, skip: Token | None, number: Expression | None, label: Token | None, *rest: Word | ControlStatement | None
    ) -> ParsedBlock:
        head = self.head(skip, number, label)
        control = next((part for part in rest if isinstance(part, ControlStatement)), None)
        words = tuple(word for word in rest if isinstance(word, Word))
        return ParsedBlock(words, control, None, head.number, head.skip_level, head.label)


def unquoted(token: str) -> str:
    """The text between quotes, with \\" and \\\\ as the characters they stand for."""
    return re.sub(r"\\(.)", r"\1", token[1:-1])


class BlockParser:
    """Parses blocks for one channel. `parse` raises LineError."""

    def __init__(self, addresses: Addresses, vocabulary: Vocabulary) -> None:
        self.addresses = addresses
        self.vocabulary = vocabulary
        self._builder = _Builder(addresses)
        grammar = resources.files("runtime.cnc.language.isg").joinpath("block.lark").read_text(encoding="utf-8")
        self._lark = Lark(
            grammar,
            parser="lalr",
            lexer="contextual",
            start=["block", "head", "only", "target"],
            maybe_placeholders=True,
            transformer=self._builder,
            cache=str(CACHE.folder / GRAMMAR_TABLES),
        )
        self._statements = StatementParser(self, vocabulary)

    @property
    def environment(self) -> Environment:
        return self._builder.environment

    def parse(self, text: str, environment: Environment) -> ParsedBlock:
        """A line of the file (without its end) as a block; comments may stand in it."""
        if len(text) > MAX_BLOCK:
            raise LineError(catalogue.BLOCK_TOO_LONG, MAX_BLOCK + 1, limit=MAX_BLOCK)
        self._builder.environment = environment
        blanked = blank_comments(text)
        parsed = numeric_block(blanked, self.addresses) or self.by_grammar(blanked)
        if parsed.words:
            check_words(parsed.words, self.addresses, self.vocabulary)
        return parsed

    def by_grammar(self, blanked: str) -> ParsedBlock:
        """The block by the grammars alone, without the rules between its words."""
        macros: tuple[tuple[str, str], ...] = ()
        if '"' in blanked:
            macros, replaced = define_and_replace(blanked, self.environment)
            blanked = self._g_numbers(replaced) if replaced != blanked else blanked
        at = statement_at(blanked)
        if at is not None:
            alone, beside = beside_words(blanked)
            if beside is not None and not beside.adds:
                alone, beside = blanked, None
            statement = self._statements.parse(alone, at)
            head = self._head(blanked[: at.start], statement)
            added = self._statements.parse(beside.text, beside.at) if beside is not None else None
            return ParsedBlock((), None, statement, head.number, head.skip_level, head.label, macros, added)
        blanked, jobs = take_jobs(blanked, self.addresses, self._statements)
        blanked, brackets = take_brackets(blanked, self)
        blanked, beside = beside_words(blanked)
        addition: ParsedStatement | None = None
        if beside is not None:
            addition = self._statements.parse(beside.text, beside.at)
        parsed = self._by_lark(blanked, "block")
        assert isinstance(parsed, ParsedBlock)
        words = (*(self._completed(word, blanked) for word in parsed.words), *brackets, *jobs)
        return ParsedBlock(
            words, parsed.control, None, parsed.number, parsed.skip_level, parsed.label, macros, addition
        )

    def _head(self, text: str, statement: ParsedStatement) -> ParsedBlock:
        """What stands in front of a statement: skip level, block number, label, and nothing else."""
        try:
            head = self._by_lark(text, "head")
        except LineError:
            self._by_lark(text, "block")  # tells what is wrong with the words themselves
            syntax = statement.syntax
            word = syntax.prefix + syntax.name.removeprefix("CALL ")
            raise LineError(catalogue.NOT_ALONE, statement.column, word=word) from None
        assert isinstance(head, ParsedBlock)
        return head

    def _completed(self, word: Word, text: str) -> Word:
        """What the grammar leaves open: calls by a variable, returns to a chosen place, signs behind the name of an axis."""
        if word.kind is WordKind.AXIS:
            match = _SIGNS.match(text, word.column - 1)
            return replace(word, signs=re.sub(r"[ \t]", "", match.group(1))) if match is not None else word
        if word.kind is WordKind.RETURN:
            return parse_return(word, self)
        if word.kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL) and word.name.upper().startswith("V."):
            at = word.column + (2 if word.kind is WordKind.CALL_LOCAL else 1)
            name = expressions.string(self.expression(word.name, at), word.name, word.column)
            return replace(word, value=name)
        return word

    def _g_numbers(self, text: str) -> str:
        """A block with macros in it, expressions of plain numbers behind G computed (line 26085)."""
        for match in reversed(list(g_expressions(text))):
            try:
                number = expressions.computed(self.expression(match.group(1), match.start(1) + 1))
            except CalculationError as error:
                raise LineError(error.entry, match.start() + 1, **error.values) from None
            if not number.is_integer() or number < 0:
                raise LineError(catalogue.G_NUMBER, match.start() + 1, text=match.group(1))
            text = f"{text[: match.start(1)]}{int(number)}{text[match.end(1) :]}"
        return text

    def expression(self, text: str, column: int) -> Expression:
        """An expression alone; `column` is the place of its first character in the block."""
        parsed = self._by_lark(" " * (column - 1) + text, "only")
        assert isinstance(parsed, Expression)
        return parsed

    def place(self, text: str, column: int) -> _Path:
        """A parameter or variable alone."""
        parsed = self._by_lark(" " * (column - 1) + text, "target")
        assert isinstance(parsed, _Path)
        return parsed

    def written(self, text: str, column: int) -> str:
        """The source of a write access to a parameter or variable, `{}` where the value stands."""
        place = self.place(text, column)
        source = self._builder._written(place)
        return f"set_parameter({source}, {{}})" if place.number is not None else source

    def _by_lark(self, blanked: str, start: str) -> object:
        try:
            return self._lark.parse(blanked, start=start)
        except UnexpectedInput as error:
            raise explain(blanked, error, self.addresses) from None


@cache
def _block_parser(addresses: Addresses, key: int) -> BlockParser:
    return BlockParser(addresses, _vocabularies[key])


_vocabularies: dict[int, Vocabulary] = {}


def block_parser(addresses: Addresses, vocabulary: Vocabulary) -> BlockParser:
    """The parser of a channel; building one costs some time (tables from the disk: 20 ms, new ones: 200 ms), so it is kept."""
    _vocabularies[id(vocabulary)] = vocabulary
    return _block_parser(addresses, id(vocabulary))


def check_words(words: tuple[Word, ...], addresses: Addresses, vocabulary: Vocabulary) -> None:
    """The rules between the words of a block; raises LineError."""
    seen: set[tuple[WordKind, int | str]] = set()
    groups: dict[object, GSyntax] = {}
    spindle_m = -1
    for word in words:
        if word.kind is WordKind.G:
            function = _g_function(word, vocabulary)
            if function.group is Group.NONE or function.group in vocabulary.repeatable:
                continue
            other = groups.setdefault(function.group, function)
            if other is not function or (word.kind, word.index) in seen:
                raise LineError(
                    catalogue.G_GROUP_TWICE,
                    word.column,
                    number=word.index,
                    other=other.number,
                    group=function.group.value,
                )
            seen.add((word.kind, word.index))
        elif word.kind in (WordKind.AXIS, WordKind.INTERPOLATION, WordKind.ADDITION) or word.kind in _ONCE:
            key = (word.kind, word.name if word.kind is WordKind.ADDITION else word.index)
            if word.kind is WordKind.DWELL:
                key = (word.kind, 0)
            if key in seen and not (word.kind is WordKind.AXIS and vocabulary.repeats_axes):
                raise LineError(catalogue.WORD_TWICE, word.column, address=word.name or _ONCE[word.kind])
            seen.add(key)
            if word.kind is WordKind.DWELL and len(words) > 1:
                raise LineError(catalogue.NOT_ALONE, word.column, word="G04")
        elif word.kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL):
            if any(other.kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL) for other in words if other is not word):
                raise LineError(catalogue.WORD_TWICE, word.column, address="a subprogram call")
        elif word.kind in (WordKind.M, WordKind.H):
            assert word.value is not None
            if word.value.constant is not None:
                number = check_function(word, word.value.constant, addresses)
                if word.kind is WordKind.M and number in SPINDLE_M and number not in addresses.m:
                    if spindle_m >= 0:
                        raise LineError(catalogue.SPINDLE_M_TWICE, word.column, number=number, other=spindle_m)
                    spindle_m = number


def check_function(word: Word, value: float, addresses: Addresses) -> int:
    """The number of an M or H function as an integer, after checking that the channel has it; raises LineError."""
    number = int(value + 0.5) if value >= 0 else -1
    letter = word.kind.name
    if number < 0:
        raise LineError(catalogue.FUNCTION_NEGATIVE, word.column, value=value, address=letter)
    if word.kind is WordKind.H:
        if number not in addresses.h:
            raise LineError(catalogue.H_UNDEFINED, word.column, number=number)
        return number
    of_spindle = number in SPINDLE_M or number == POSITIONING_M
    if word.extra is not None and (of_spindle or number in GEAR_M) and not (of_spindle and number in addresses.m):
        raise LineError(catalogue.VALUE_NOT_ALLOWED, word.column, number=number)
    if of_spindle:
        if not addresses.spindles and number not in addresses.m:
            raise LineError(catalogue.SPINDLE_MISSING, word.column, word=f"M{number}")
    elif number in GEAR_M and addresses.gears:
        return number
    elif number != TOOL_CHANGE_M and number not in addresses.m and number not in INTERNAL_M:
        raise LineError(catalogue.M_UNDEFINED, word.column, number=number)
    return number


def _g_function(word: Word, vocabulary: Vocabulary) -> GSyntax:
    function = vocabulary.g.get(word.index)
    if function is None:
        entry = catalogue.G_UNSUPPORTED if word.index in G_NUMBERS else catalogue.G_UNKNOWN
        raise LineError(entry, word.column, number=word.index)
    if word.name == "[" and function.values is not Values.BRACKETS:
        raise LineError(catalogue.G_VALUE, word.column, number=word.index)
    if function.values is Values.EQUALS and word.value is None:
        raise LineError(catalogue.G_VALUE_MISSING, word.column, number=word.index)
    if function.values not in (Values.EQUALS, Values.OPTIONAL) and word.value is not None:
        raise LineError(catalogue.G_VALUE, word.column, number=word.index)
    return function
