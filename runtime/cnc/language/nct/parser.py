"""The text of one block → `ParsedBlock`.

A block of letters and plain numbers is read by one regular expression; the grammar takes whatever else there is (variables,
formulas, control statements). Both give the same for the same text.
"""

from __future__ import annotations

import re
from functools import cache
from importlib import resources

from lark import Lark, Token, Transformer, UnexpectedCharacters, UnexpectedInput, UnexpectedToken, v_args

from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct import expressions
from runtime.cnc.language.nct.addresses import ADDRESSES
from runtime.cnc.language.nct.comments import without_comments
from runtime.cnc.language.nct.words import Assignment, Control, ControlStatement, Expression, ParsedBlock, Word
from runtime.cnc.language.text import MAX_BLOCK
from runtime.diagnostics.catalogue import language as files
from runtime.diagnostics.catalogue import nct as catalogue
from runtime.diagnostics.catalogue import nct_macros as macros
from runtime.kernel_cache import CACHE

GRAMMAR_TABLES = "nct-block.lark.tables"
MOST_BLOCK_NUMBER = 99_999
MOST_DIGITS = 30  # of a number, its decimal point included; the control has eight
_HEAD = re.compile(r"[ \t]*(?:(?P<skip>/)[ \t]*(?P<switch>\d?)[ \t]*)?(?:N[ \t]*(?P<number>\d+)(?![\d.]))?")
_WORD = r"(,[ \t]*[CRA]|[A-Z])[ \t]*(I[ \t]*)?([+-]?(?:\d+(?:\.\d*)?|\.\d+))[ \t]*"
_WORDS = re.compile(_WORD)
_NUMERIC = re.compile(rf"[ \t]*(?:{_WORD})*")
_MESSAGE = re.compile(r"#[ \t]*300[06][ \t]*=[ \t]*$")  # a text without a number: it is 0 (lines 6938, 7016)
_OUTPUT = re.compile(r"POPEN|PCLOS|BPRNT|DPRNT")


def _column(token: Token) -> int:
    return token.column or 0


def _word(name: str, column: int, value: Expression, incremental: bool, signed: bool, decimal: bool) -> Word:
    """A word that the dialect knows. LineError for an address without such a right, or without a meaning."""
    name = name.replace(" ", "").replace("\t", "")
    address = ADDRESSES.get(name)
    if address is None:
        raise LineError(catalogue.ADDRESS_UNKNOWN, column, address=name)
    for given, right, what in (
        (incremental, address.operator, "the operator I"),
        (signed, address.sign, "a sign"),
        (decimal, address.decimals > 0, "a decimal point"),
    ):
        if given and not right:
            raise LineError(catalogue.ADDRESS_RIGHT, column, address=name, what=what)
    return Word(name, column, value, incremental, signed, decimal)


@v_args(inline=True)
class _Builder(Transformer[Token, object]):
    """Called by the parser bottom-up while it reduces; nothing is kept between blocks."""

    def literal(self, token: Token) -> Expression:
        if len(token) > MOST_DIGITS:
            raise LineError(macros.NUMBER_LONG, _column(token), limit=MOST_DIGITS)
        return expressions.literal(token)

    def bracketed(self, inner: Expression) -> Expression:
        return expressions.bracketed(inner, 1)

    def read(self, number: Expression) -> Expression:
        return expressions.read(number)

    def numbered(self, token: Token) -> Expression:
        return expressions.numbered(token, _column(token))

    def computed(self, inner: Expression) -> Expression:
        return expressions.call("number_of", expressions.bracketed(inner, 1))

    def binary(self, left: Expression, operator: Token, right: Expression) -> Expression:
        return expressions.call(expressions.OPERATORS[operator], left, right)

    def sign(self, operator: Token, operand: Expression) -> Expression:
        return expressions.signed(operator, operand)

    def call(self, name: Token, operand: Expression) -> Expression:
        return expressions.call(str(name), operand)

    def condition(self, left: Expression, comparison: Token, right: Expression) -> Expression:
        return expressions.call(str(comparison), left, right)

    # -- words

    def value(self, operand: Expression) -> tuple[Expression, bool, bool]:
        return operand, False, operand.constant is not None and "." in operand.source.removesuffix(".0")

    def signed_value(self, sign: Token, operand: Expression) -> tuple[Expression, bool, bool]:
        _, _, decimal = self.value(operand)
        return expressions.signed(sign, operand), sign == "-", decimal

    def word(self, name: Token, value: tuple[Expression, bool, bool]) -> Word:
        expression, signed, decimal = value
        return _word(name, _column(name), expression, False, signed, decimal)

    def incremental_word(self, name: Token, _operator: Token, value: tuple[Expression, bool, bool]) -> Word:
        expression, signed, decimal = value
        return _word(name, _column(name), expression, True, signed, decimal)

    def assignment(self, number: Expression, value: Expression) -> Assignment:
        return Assignment(number, value, 1)

    # -- control statements

    def goto(self, keyword: Token, target: Expression) -> ControlStatement:
        return ControlStatement(Control.GOTO, _column(keyword), None, target)

    def if_goto(self, keyword: Token, condition: Expression, *rest: Token | Expression) -> ControlStatement:
        target = rest[-1]
        assert isinstance(target, Expression)
        return ControlStatement(Control.IF, _column(keyword), condition, target)

    def if_then(self, keyword: Token, condition: Expression, *rest: Token | Word | Assignment) -> ParsedBlock:
        words = tuple(part for part in rest if isinstance(part, Word))
        assignments = tuple(part for part in rest if isinstance(part, Assignment))
        return ParsedBlock(words, assignments, ControlStatement(Control.IF, _column(keyword), condition))

    def while_do(self, keyword: Token, condition: Expression, _do: Token, target: Expression) -> ControlStatement:
        return ControlStatement(Control.WHILE, _column(keyword), condition, target)

    def do(self, keyword: Token, target: Expression) -> ControlStatement:
        return ControlStatement(Control.DO, _column(keyword), None, target)

    def end(self, keyword: Token, target: Expression) -> ControlStatement:
        return ControlStatement(Control.END, _column(keyword), None, target)

    def block(self, *parts: Word | Assignment | ControlStatement | ParsedBlock) -> ParsedBlock:
        if parts and isinstance(parts[0], ParsedBlock):
            return parts[0]
        words = tuple(part for part in parts if isinstance(part, Word))
        assignments = tuple(part for part in parts if isinstance(part, Assignment))
        control = next((part for part in parts if isinstance(part, ControlStatement)), None)
        return ParsedBlock(words, assignments, control)


class BlockParser:
    """Parses blocks. One is enough for all channels: the names of a block are looked up when it is executed."""

    def __init__(self) -> None:
        grammar = resources.files("runtime.cnc.language.nct").joinpath("block.lark").read_text(encoding="utf-8")
        self._lark = Lark(
            grammar,
            parser="lalr",
            lexer="contextual",
            start="block",
            transformer=_Builder(),
            cache=str(CACHE.folder / GRAMMAR_TABLES),
        )

    def parse(self, text: str) -> ParsedBlock:
        """A line of the file (without its end) as a block; comments may stand in it. LineError."""
        if len(text) > MAX_BLOCK:
            raise LineError(files.BLOCK_TOO_LONG, MAX_BLOCK + 1, limit=MAX_BLOCK)
        blanked, comment = without_comments(text)
        head = _HEAD.match(blanked)
        assert head is not None
        skip = int(head["switch"] or 1) if head["skip"] else 0
        if head["switch"] == "0":
            raise LineError(catalogue.SKIP_NUMBER, head.start("switch") + 1)
        number = int(head["number"]) if head["number"] else -1
        if head["number"] and not 1 <= number <= MOST_BLOCK_NUMBER:
            raise LineError(catalogue.BLOCK_NUMBER, head.start("number") + 1, number=head["number"])
        begin = head.end()
        if _MESSAGE.search(blanked) is not None:
            blanked = blanked.rstrip() + "0"
        parsed = self._numeric(blanked, begin) or self._by_grammar(blanked, begin)
        if number < 0 and parsed.words and parsed.words[0].address == "N":
            raise LineError(macros.NUMBER_FIRST, parsed.words[0].column)
        return ParsedBlock(parsed.words, parsed.assignments, parsed.control, number, skip, comment)

    def _numeric(self, text: str, begin: int) -> ParsedBlock | None:
        """A block of plain numbers, None if it is one for the grammar."""
        if _NUMERIC.fullmatch(text, begin) is None:
            return None
        words = []
        for found in _WORDS.finditer(text, begin):
            name, operator, digits = found.groups()
            value = Expression.number(float(digits))
            words.append(
                _word(name, found.start() + 1, value, operator is not None, digits[0] == "-", _has_decimals(digits))
            )
        return ParsedBlock(tuple(words))

    def _by_grammar(self, text: str, begin: int) -> ParsedBlock:
        blanked = " " * begin + text[begin:]
        try:
            parsed = self._lark.parse(blanked)
        except UnexpectedInput as error:
            raise _explained(blanked, error) from None
        assert isinstance(parsed, ParsedBlock)
        return parsed


def _has_decimals(digits: str) -> bool:
    """Whether there is a decimal point with digits other than 0 behind it: M3. and G0. are whole numbers."""
    return bool(digits.partition(".")[2].strip("0"))


def _explained(text: str, error: UnexpectedInput) -> LineError:
    """What is wrong, in the user's words, at the place where the grammar gives up."""
    if isinstance(error, UnexpectedToken) and error.token.type == "$END":
        position = len(text.rstrip())
    else:
        position = getattr(error, "pos_in_stream", None) or 0
    expected = set()
    if isinstance(error, UnexpectedCharacters):
        expected = set(error.allowed or ())
    elif isinstance(error, UnexpectedToken):
        expected = set(error.accepts or error.expected)
    rest, before = text[position:].strip(), text[:position].strip()
    column = min(position + 1, max(len(text.rstrip()), 1))
    output = _OUTPUT.search(text)
    if output is not None:
        return LineError(catalogue.NOT_SUPPORTED, output.start() + 1, what=output.group())
    if text.count("[") != text.count("]"):
        return LineError(catalogue.MACRO_STATEMENT, column, reason="a bracket is not closed, or not opened")
    if before.endswith(("IF", "WHILE")):
        return LineError(
            catalogue.OPERATION, column, reason=f"{before.split()[-1][-5:].lstrip('0123456789')} needs a condition"
        )
    if any(word in text for word in ("IF", "WHILE", "GOTO", "#", "[")):
        found = f"{rest[:12]!r} is not understood here" if rest else "the statement is not complete"
        return LineError(catalogue.MACRO_STATEMENT, column, reason=found)
    if "NUMBER" in expected and before:
        return LineError(catalogue.VALUE_MISSING, column, address=before[-1])
    return LineError(catalogue.SYNTAX, column, found=rest[:20])


@cache
def block_parser() -> BlockParser:
    """The parser; making one costs some time, so it is kept."""
    return BlockParser()
