"""One block of text → `ParsedBlock`, with everything checked that can be checked without executing it."""

from __future__ import annotations

from functools import cache
from importlib import resources

from lark import Lark, Token, Transformer, UnexpectedInput, v_args

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.isg import expressions
from runtime.cnc.language.isg.comments import LineError, blank_comments
from runtime.cnc.language.isg.numeric_blocks import numeric_block
from runtime.cnc.language.isg.registry import G_FUNCTIONS, G_NUMBERS, GFunction
from runtime.cnc.language.isg.syntax_errors import explain
from runtime.cnc.language.isg.words import Control, ControlStatement, Expression, ParsedBlock, Word, WordKind
from runtime.cnc.language.text import MAX_BLOCK
from runtime.diagnostics.catalogue import language as catalogue
from runtime.kernels import CACHE

GRAMMAR_TABLES = "block.lark.tables"  # Lark sees by itself whether they are those of the grammar and of its own version
MAX_PARAMETER = 2**31 - 1
SKIP_LEVELS = 10
SPINDLE_M = (3, 4, 5)
POSITIONING_M = 19
GEAR_M = range(40, 46)
INTERNAL_M = (0, 1, 2, 17, 29, 30)  # reserved numbers that work without a configuration (line 6606)

_CONSTANTS = {"TRUE": 1.0, "FALSE": 0.0, "PI": 3.141592653589793}
_CONTROLS = {control.value: control for control in Control}
_ONCE = {
    WordKind.RADIUS: "R",
    WordKind.FEED: "F",
    WordKind.SPEED: "S",
    WordKind.TOOL: "T",
    WordKind.DWELL: "G04",
}


def _column(token: Token) -> int:
    return token.column or 0


@v_args(inline=True)
class _Builder(Transformer[Token, ParsedBlock]):
    """Called by the parser bottom-up while it reduces; nothing is kept between blocks. `addresses` resolves names."""

    def __init__(self, addresses: Addresses) -> None:
        super().__init__()
        self._addresses = addresses

    # -- expressions

    def literal(self, token: Token) -> Expression:
        return expressions.literal(token, _column(token))

    def based_literal(self, token: Token) -> Expression:
        return expressions.based_literal(token, _column(token))

    def constant(self, token: Token) -> Expression:
        value = _CONSTANTS[token.upper()]
        return Expression(repr(value), constant=value)

    def binary(self, left: Expression, operator: Token, right: Expression) -> Expression:
        return expressions.binary(left, operator, right, _column(operator))

    def sign(self, operator: Token, operand: Expression) -> Expression:
        return expressions.signed(operator, operand, _column(operator))

    def call(self, name: Token, *arguments: Expression) -> Expression:
        return expressions.call(name, arguments, _column(name))

    def parameter(self, token: Token) -> Expression:
        """P12 → "12"; PP12 → the number that stands in P12."""
        levels = len(token) - len(token.lstrip("Pp"))
        number = int(token[levels:])
        if not 1 <= number <= MAX_PARAMETER:
            raise LineError(catalogue.PARAMETER_INDEX, _column(token), value=float(number))
        source = Expression(str(number))
        for _ in range(levels - 1):
            source = expressions.parameter(expressions.read(source.source, source.depth), _column(token))
        return source

    def parameter_computed(self, opening: Token, number: Expression) -> Expression:
        source = expressions.parameter(number, _column(opening))
        for _ in range(len(opening) - 2):
            source = expressions.parameter(expressions.read(source.source, source.depth), _column(opening))
        return source

    def read(self, number: Expression) -> Expression:
        return expressions.read(number.source, number.depth)

    def exists(self, name: Token, number: Expression) -> Expression:
        return expressions.exists(number, "p", _column(name))

    def exists_function(self, name: Token, letter: Token, number: Expression) -> Expression:
        rounded = Expression(f"round_half_up({number.source})", depth=number.depth + 1)
        return expressions.exists(rounded, "known_m" if letter.upper() == "M" else "known_h", _column(name))

    # -- words

    def axis(self, name: Token, value: Expression) -> Word:
        index = self._addresses.axis(name)
        if index < 0:
            axes = ", ".join(self._addresses.axes)
            raise LineError(catalogue.AXIS_UNKNOWN, _column(name), axis=str(name), axes=axes)
        return Word(WordKind.AXIS, _column(name), value, index, name=str(name))

    def interpolation(self, letter: Token, value: Expression) -> Word:
        return Word(WordKind.INTERPOLATION, _column(letter), value, "IJK".index(letter.upper()), name=letter.upper())

    def radius(self, letter: Token, value: Expression) -> Word:
        return Word(WordKind.RADIUS, _column(letter), value)

    def feed(self, letter: Token, value: Expression) -> Word:
        return Word(WordKind.FEED, _column(letter), value)

    def speed(self, name: Token, value: Expression) -> Word:
        self._check_spindle(name)
        return Word(WordKind.SPEED, _column(name), value)

    def tool(self, letter: Token, value: Expression) -> Word:
        return Word(WordKind.TOOL, _column(letter), value)

    def function_word(self, letter: Token, number: Expression, extra: Expression | None) -> Word:
        kind = WordKind.M if letter.upper() == "M" else WordKind.H
        return Word(kind, _column(letter), number, extra=extra)

    def g(self, token: Token, value: Expression | None = None) -> Word:
        number = int(token[1:])
        return Word(WordKind.G, _column(token), value, number)

    def dwell(self, token: Token, value: Expression) -> Word:
        return Word(WordKind.DWELL, _column(token), value)

    def dwell_address(self, token: Token, name: Token, value: Expression) -> Word:
        if name.type in ("SPEED", "SPINDLE_NAME"):
            self._check_spindle(name)
            return Word(WordKind.DWELL, _column(token), value, 1)
        if name != self._addresses.axes[0]:
            first = self._addresses.axes[0]
            raise LineError(catalogue.DWELL_AXIS, _column(name), axis=first, address=str(name))
        return Word(WordKind.DWELL, _column(token), value)

    def assignment(self, number: Expression, value: Expression) -> Word:
        return Word(WordKind.ASSIGNMENT, 0, value, target=number.source)

    def call_local(self, token: Token) -> Word:
        return self._call(WordKind.CALL_LOCAL, token, token[2:].strip())

    def call_global(self, token: Token) -> Word:
        return self._call(WordKind.CALL_GLOBAL, token, token[1:].strip())

    def _call(self, kind: WordKind, token: Token, name: str) -> Word:
        if name.upper() in ("CYCLE", "SEQUENCE"):
            what = f"{token[:2].strip()} {name.upper()}"
            raise LineError(catalogue.NOT_SUPPORTED, _column(token), what=what)
        if name.upper().startswith("V."):
            raise LineError(catalogue.NOT_SUPPORTED, _column(token), what=f"call by variable {name}")
        return Word(kind, _column(token), name=name)

    def _check_spindle(self, name: Token) -> None:
        spindles = self._addresses.spindles
        if not spindles:
            raise LineError(catalogue.SPINDLE_MISSING, _column(name), word=str(name))
        if len(name) > 1 and name != spindles[0]:
            raise LineError(catalogue.SPINDLE_UNKNOWN, _column(name), spindle=str(name), spindles=", ".join(spindles))

    # -- control statements and blocks

    def condition(self, token: Token, value: Expression) -> ControlStatement:
        return ControlStatement(_CONTROLS[token.upper()], _column(token), (value,))

    def counting(
        self, token: Token, counter: Expression, start: Expression, end: Expression, step: Expression
    ) -> ControlStatement:
        return ControlStatement(Control.FOR, _column(token), (start, end, step), counter.source)

    def plain_control(self, token: Token) -> ControlStatement:
        return ControlStatement(_CONTROLS[token.upper()], _column(token))

    def number(self, _: Token, value: Expression) -> Expression:
        return value

    def block(self, skip: Token | None, number: Expression | None, *rest: Word | ControlStatement) -> ParsedBlock:
        level = 0
        if skip is not None:
            level = int(skip[1:].strip() or 1)
            if not 1 <= level <= SKIP_LEVELS:
                raise LineError(catalogue.SKIP_LEVEL, _column(skip), level=level)
        if rest and isinstance(rest[0], ControlStatement):
            return ParsedBlock((), rest[0], number, level)
        words = tuple(word for word in rest if isinstance(word, Word))
        return ParsedBlock(words, None, number, level)


class BlockParser:
    """Parses blocks for one channel. `parse` raises LineError."""

    def __init__(self, addresses: Addresses) -> None:
        self._addresses = addresses
        grammar = resources.files("runtime.cnc.language.isg").joinpath("block.lark").read_text(encoding="utf-8")
        self._lark = Lark(
            grammar,
            parser="lalr",
            lexer="contextual",
            start="block",
            maybe_placeholders=True,
            transformer=_Builder(addresses),
            cache=str(CACHE.folder / GRAMMAR_TABLES),
        )

    def parse(self, text: str) -> ParsedBlock:
        """A line of the file (without its end) as a block; comments may stand in it."""
        if len(text) > MAX_BLOCK:
            raise LineError(catalogue.BLOCK_TOO_LONG, MAX_BLOCK + 1, limit=MAX_BLOCK)
        blanked = blank_comments(text)
        parsed = numeric_block(blanked, self._addresses) or self.by_grammar(blanked)
        if parsed.words:
            check_words(parsed.words, self._addresses)
        return parsed

    def by_grammar(self, blanked: str) -> ParsedBlock:
        """The block by the grammar alone, without the rules between its words."""
        try:
            parsed = self._lark.parse(blanked)
        except UnexpectedInput as error:
            raise explain(blanked, error, self._addresses) from None
        assert isinstance(parsed, ParsedBlock)
        return parsed


@cache
def block_parser(addresses: Addresses) -> BlockParser:
    """The parser of a channel; building one costs some time (tables from the disk: 20 ms, new ones: 200 ms), so it is kept."""
    return BlockParser(addresses)


def check_words(words: tuple[Word, ...], addresses: Addresses) -> None:
    """The rules between the words of a block; raises LineError."""
    seen: set[tuple[WordKind, int]] = set()
    groups: dict[object, GFunction] = {}
    spindle_m = -1
    for word in words:
        if word.kind is WordKind.G:
            function = _g_function(word)
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
        elif word.kind in (WordKind.AXIS, WordKind.INTERPOLATION) or word.kind in _ONCE:
            key = (word.kind, 0 if word.kind is WordKind.DWELL else word.index)
            if key in seen:
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
                if word.kind is WordKind.M and number in SPINDLE_M:
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
    if word.extra is not None and (number in SPINDLE_M or number == POSITIONING_M or number in GEAR_M):
        raise LineError(catalogue.VALUE_NOT_ALLOWED, word.column, number=number)
    if number == POSITIONING_M:
        raise LineError(catalogue.NOT_SUPPORTED, word.column, what="spindle positioning M19")
    if number in SPINDLE_M:
        if not addresses.spindles:
            raise LineError(catalogue.SPINDLE_MISSING, word.column, word=f"M{number}")
    elif number not in addresses.m and number not in INTERNAL_M:
        raise LineError(catalogue.M_UNDEFINED, word.column, number=number)
    return number


def _g_function(word: Word) -> GFunction:
    function = G_FUNCTIONS.get(word.index)
    if function is None:
        entry = catalogue.G_UNSUPPORTED if word.index in G_NUMBERS else catalogue.G_UNKNOWN
        raise LineError(entry, word.column, number=word.index)
    if function.value and word.value is None:
        raise LineError(catalogue.G_VALUE_MISSING, word.column, number=word.index)
    if not function.value and word.value is not None:
        raise LineError(catalogue.G_VALUE, word.column, number=word.index)
    return function
