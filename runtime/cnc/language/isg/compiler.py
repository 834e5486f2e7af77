"""`ParsedBlock` → `CompiledBlock`: one Python function that computes all values of the block, and where each value
belongs.

A block is compiled when it is executed for the first time. Executing it again is one call; blocks of plain numbers
need none. The function's globals are the namespace of the decoder that executes it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg import functions
from runtime.cnc.language.isg.expressions import NUMBER_LIMIT, number
from runtime.cnc.language.isg.index import BlockText
from runtime.cnc.language.isg.parser import MAX_PARAMETER
from runtime.cnc.language.isg.syntax import Group, Vocabulary
from runtime.cnc.language.isg.words import (
    ControlStatement,
    Expression,
    ParsedBlock,
    ParsedStatement,
    Word,
    WordKind,
)
from runtime.diagnostics.catalogue import language as catalogue

Value = float | str
Values = tuple[Any, ...]  # numbers where the grammar asks for numbers
Evaluate = Callable[[], Values]


class Parameters(dict[int, float]):
    """The P parameters by number; reading one that has no value raises CalculationError."""

    def __missing__(self, number: int) -> float:
        raise CalculationError(catalogue.PARAMETER_UNSET, f"P{number}")


def parameter_number(value: float) -> int:
    """The number of a parameter from a computed value."""
    if not 0.5 <= value <= MAX_PARAMETER:
        raise CalculationError(catalogue.PARAMETER_INDEX, "P[", value=value)
    return functions.round_half_up(value)


def _new_parameter(number: int) -> None:
    """Told before a parameter comes into being; a channel replaces it by its own limit."""


def _check_assigned(value: float, number: int) -> None:
    if not abs(value) <= NUMBER_LIMIT:
        raise CalculationError(catalogue.RESULT_RANGE, f"P{number}", value=value)


NAMES: Mapping[str, object] = {
    **{function.call.__name__: function.call for function in functions.FUNCTIONS.values()},
    **{
        call.__name__: call
        for call in (
            functions.divide,
            functions.modulo,
            functions.power,
            functions.bit_and,
            functions.bit_or,
            functions.bit_xor,
            functions.logic_and,
            functions.logic_or,
            functions.logic_xor,
            functions.round_half_up,
            functions.as_number,
            functions.as_string,
            functions.add,
            functions.subtract,
            functions.compare,
            parameter_number,
        )
    },
    "check_assigned": _check_assigned,
    "new_parameter": _new_parameter,
}


@dataclass(frozen=True, slots=True)
class FunctionSlots:
    """An M or H function: slots of its number and of its additional value (-1 without)."""

    word: Word
    number: int
    extra: int


@dataclass(frozen=True, slots=True)
class GSlots:
    """A G function of a block: its word, the slot of its value (-1 without), those of bracketed values."""

    word: Word
    value: int
    values: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class BracketSlots:
    """Commands in brackets: the word, and of each command in it its word, the slot of its value and of an additional one."""

    word: Word
    commands: tuple[FunctionSlots, ...]


@dataclass(frozen=True, slots=True)
class DeclarationSlots:
    """A declaration: its word, slots of the initial values and of the sizes or indices."""

    word: Word
    values: tuple[int, ...]
    indices: tuple[int, ...]


@dataclass(frozen=True, slots=True)
class StatementSlots:
    """A # statement with the slots of its arguments, -1 where an argument has no expression; and those of indices.

    The value of an argument with a target is the function that writes to it.
    """

    statement: ParsedStatement
    slots: tuple[int, ...]
    indices: tuple[tuple[int, ...], ...]


@dataclass(frozen=True, slots=True)
class Counter:
    """The counter of a `$FOR`, which may be any variable that can be written."""

    write: Callable[[float], object]
    read: Callable[[], float]


@dataclass(frozen=True, slots=True)
class CompiledBlock:
    """A block ready to be executed.

    `values()` gives the values; the other fields are slots in them, -1 where the word is not programmed. `axes` and
    `interpolation` are pairs (index, slot). For a control statement the slots 0, 1, 2 are its expressions. `simple` tells that
    there is nothing but N, G00/G01, axis words and F: `motion` is 0 or 1, -1 without G.
    """

    source: BlockText
    skip_level: int = 0
    constants: Values = ()
    evaluate: Evaluate | None = None
    number: int = -1
    g: tuple[GSlots, ...] = ()
    axes: tuple[tuple[int, int], ...] = ()
    interpolation: tuple[tuple[int, int], ...] = ()
    radius: int = -1
    feed: int = -1
    end_feed: int = -1
    speed: int = -1
    tool: int = -1
    tool_data: int = -1
    m: tuple[FunctionSlots, ...] = ()
    h: tuple[FunctionSlots, ...] = ()
    brackets: tuple[BracketSlots, ...] = ()
    spindle_position: int = -1
    dwell: int = -1
    dwell_revolutions: bool = False
    call: Word | None = None
    call_slot: int = -1  # of its name, where a variable gives it
    return_slots: tuple[int, int] = (-1, -1)  # levels and block number of `returning`
    returning: Word | None = None
    goto: Word | None = None
    goto_slot: int = -1
    control: ControlStatement | None = None
    declarations: tuple[DeclarationSlots, ...] = ()
    additions: tuple[tuple[str, int], ...] = ()
    statement: StatementSlots | None = None
    beside: StatementSlots | None = None
    macros: tuple[tuple[str, str], ...] = ()
    words: tuple[Word, ...] = ()
    flush: bool = False
    simple: bool = False
    motion: int = -1
    assigned: bool = False  # nothing but assignments
    counter: Counter | None = None  # of $FOR
    jobs: tuple[StatementSlots, ...] = ()
    signs: tuple[tuple[int, str], ...] = ()  # channel axis index, and the signs directly behind its name
    spindle_offset: int = -1
    macro_version: int = -1  # of the macros that its text was read with, -1 if it has no quoted text

    @property
    def text(self) -> str:
        return self.source.text

    def values(self) -> Values:
        """All values of the block, assignments done; raises CalculationError."""
        return self.constants if self.evaluate is None else self.evaluate()

    def column(self, kind: WordKind, index: int | None = None) -> int:
        """Column of the first word of this kind, 1 if there is none."""
        return next((w.column for w in self.words if w.kind is kind and index in (None, w.index)), 1)


class _Emitter:
    """Collects the statements of a block's function and the slots of its values."""

    def __init__(self) -> None:
        self.lines: list[str] = []
        self.slots: list[str] = []
        self.constants: list[float] = []
        self.constant = True
        self.flush = False

    def slot(self, expression: Expression | None) -> int:
        if expression is None:
            return -1
        index = len(self.slots)
        self.flush |= expression.flush
        if expression.constant is None:
            self.constant = False
            self.lines.append(f"v{index} = {expression.source}")
            self.slots.append(f"v{index}")
        else:
            self.slots.append(repr(expression.constant))
            self.constants.append(expression.constant)
        return index

    def writer(self, target: str) -> int:
        """The slot of a function that writes its argument to a target of a # statement."""
        return self.slot(Expression(f"lambda value: {target.replace('{}', 'value', 1)}"))

    def given(self, values: tuple[Expression | None, ...]) -> tuple[int, ...]:
        """Values of a call that become transfer parameters one after the other: a later one may name an earlier one
        (G803[5,@P1], line 4316)."""
        if not any(value is not None and "(" in value.source for value in values):
            return tuple(self.slot(value) for value in values)
        self.constant = False
        self.lines.append("begin_transfer()")
        slots = []
        for place, value in enumerate(values, 1):
            slots.append(self.slot(value))
            if value is not None:
                self.lines.append(f"give_transfer({place}, {self.slots[-1]})")
        return tuple(slots)

    def assign(self, target: str, expression: Expression) -> None:
        self.constant = False
        self.flush |= expression.flush
        if "{}" in target:
            self.lines.append(target.replace("{}", expression.source, 1))
            return
        source = number(expression, "P", 1).source
        self.lines += [
            f"n, v = {target}, {source}",
            f"if not -{NUMBER_LIMIT!r} <= v <= {NUMBER_LIMIT!r}: check_assigned(v, n)",
            "if n not in p: new_parameter(n)",
            "p[n] = v",
        ]

    def function(self, namespace: dict[str, Any]) -> Evaluate:
        body = "\n".join(f"    {line}" for line in self.lines)
        source = f"def block():\n{body}\n    return ({', '.join(self.slots)}{',' if self.slots else ''})\n"
        return _made(source, namespace)


def _made(source: str, namespace: dict[str, Any]) -> Callable[..., Any]:
    place: dict[str, Any] = {}
    exec(compile(source, "<NC block>", "exec"), namespace, place)
    made: Callable[..., Any] = place["block"]
    return made


def compile_block(
    block: ParsedBlock,
    source: BlockText,
    namespace: dict[str, Any],
    vocabulary: Vocabulary,
    macro_version: int = -1,
) -> CompiledBlock:
    """Compile a block. Assignments and values are computed in the order of the words."""
    emitter = _Emitter()
    if block.control is not None:
        return _compile_control(block, source, namespace, emitter, macro_version)
    slots: dict[WordKind, int] = {}
    axes: list[tuple[int, int]] = []
    interpolation: list[tuple[int, int]] = []
    functions_of: dict[WordKind, list[FunctionSlots]] = {WordKind.M: [], WordKind.H: []}
    g: list[GSlots] = []
    brackets: list[BracketSlots] = []
    jobs: list[StatementSlots] = []
    additions: list[tuple[str, int]] = []
    declarations: list[DeclarationSlots] = []
    special: dict[WordKind, Word] = {}
    return_slots = -1, -1
    number = emitter.slot(block.number)
    for word in block.words:
        kind = word.kind
        if kind is WordKind.ASSIGNMENT:
            assert word.value is not None
            emitter.assign(word.target, word.value)
        elif kind is WordKind.AXIS:
            axes.append((word.index, emitter.slot(word.value)))
        elif kind is WordKind.INTERPOLATION:
            interpolation.append((word.index, emitter.slot(word.value)))
        elif kind in functions_of:
            functions_of[kind].append(FunctionSlots(word, emitter.slot(word.value), emitter.slot(word.extra)))
        elif kind is WordKind.BRACKET and (job := _statement(word.job, emitter)) is not None:
            jobs.append(job)
        elif kind is WordKind.BRACKET:
            commands = tuple(FunctionSlots(w, emitter.slot(w.value), emitter.slot(w.extra)) for w in word.inner)
            brackets.append(BracketSlots(word, commands))
        elif kind is WordKind.G:
            slot = emitter.slot(word.value)
            calls = word.index in vocabulary.g and vocabulary.g[word.index].group is Group.CALL
            given = emitter.given(word.values) if calls else tuple(emitter.slot(value) for value in word.values)
            g.append(GSlots(word, slot, given))
        elif kind is WordKind.ADDITION:
            additions.append((word.name, emitter.slot(word.value)))
        elif kind is WordKind.DECLARATION:
            values = tuple(emitter.slot(value) for value in word.values)
            declarations.append(DeclarationSlots(word, values, tuple(emitter.slot(index) for index in word.indices)))
        elif kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL):
            special[WordKind.CALL_LOCAL] = word
            slots[WordKind.CALL_LOCAL] = emitter.slot(word.value)
        elif kind is WordKind.RETURN:
            special[kind] = word
            jumps, target = word.values
            return_slots = emitter.slot(jumps), emitter.slot(target)
        elif kind is WordKind.GOTO:
            special[kind] = word
            slots[kind] = emitter.slot(word.value)
        else:
            slots[kind] = emitter.slot(word.value)
    statement = _statement(block.statement, emitter)
    beside = _statement(block.addition, emitter)
    constants, evaluate = _result(emitter, namespace)
    dwell = slots.get(WordKind.DWELL, -1)
    kinds = {word.kind for word in block.words}
    plain = statement is None and beside is None and not block.macros
    simple = not any(len(word.signs) > 1 for word in block.words)  # of which one is not to be taken lightly
    simple = (
        simple and plain and bool(axes) and kinds <= {WordKind.AXIS, WordKind.FEED, WordKind.G, WordKind.ASSIGNMENT}
    )
    simple = simple and len({axis for axis, _ in axes}) == len(axes)
    motions = [word.index for word in block.words if word.kind is WordKind.G]
    simple = simple and (not motions or (len(motions) == 1 and motions[0] in (0, 1)))
    return CompiledBlock(
        source,
        block.skip_level,
        constants,
        evaluate,
        number,
        tuple(g),
        tuple(axes),
        tuple(interpolation),
        slots.get(WordKind.RADIUS, -1),
        slots.get(WordKind.FEED, -1),
        slots.get(WordKind.END_FEED, -1),
        slots.get(WordKind.SPEED, -1),
        slots.get(WordKind.TOOL, -1),
        slots.get(WordKind.TOOL_DATA, -1),
        tuple(functions_of[WordKind.M]),
        tuple(functions_of[WordKind.H]),
        tuple(brackets),
        slots.get(WordKind.SPINDLE_POSITION, -1),
        dwell,
        dwell >= 0 and block.words[0].index == 1,
        call=special.get(WordKind.CALL_LOCAL),
        call_slot=slots.get(WordKind.CALL_LOCAL, -1),
        return_slots=return_slots,
        returning=special.get(WordKind.RETURN),
        goto=special.get(WordKind.GOTO),
        goto_slot=slots.get(WordKind.GOTO, -1),
        declarations=tuple(declarations),
        additions=tuple(additions),
        statement=statement,
        beside=beside,
        macros=block.macros,
        words=block.words,
        flush=emitter.flush or (statement is not None and statement.statement.syntax.flush),
        simple=simple,
        motion=motions[0] if simple and motions else -1,
        assigned=plain and bool(kinds) and kinds == {WordKind.ASSIGNMENT},
        jobs=tuple(jobs),
        signs=tuple((w.index, w.signs) for w in block.words if w.kind is WordKind.AXIS and w.signs),
        spindle_offset=slots.get(WordKind.SPINDLE_OFFSET, -1),
        macro_version=macro_version,
    )


def _compile_control(
    block: ParsedBlock, source: BlockText, namespace: dict[str, Any], emitter: _Emitter, macro_version: int
) -> CompiledBlock:
    control = block.control
    assert control is not None
    for expression in control.expressions:
        emitter.slot(expression)
    counter = None
    if control.counter is not None:
        target = control.target if "{}" in control.target else f"set_parameter({control.target}, {{}})"
        write = _made(f"def block(value):\n    {target.replace('{}', 'value', 1)}\n", namespace)
        counter = Counter(write, _made(f"def block():\n    return {control.counter.source}\n", namespace))
    elif control.target:  # $SWITCH P1=…
        emitter.assign(control.target, Expression("v0"))
    goto, slot = control.goto, -1
    if goto is not None and goto.value is not None:
        slot = emitter.slot(goto.value)
    number = emitter.slot(block.number)
    constants, evaluate = _result(emitter, namespace)
    return CompiledBlock(
        source,
        block.skip_level,
        constants,
        evaluate,
        number=number,
        control=control,
        goto=goto,
        goto_slot=slot,
        flush=emitter.flush,
        counter=counter,
        macro_version=macro_version,
    )


def _statement(statement: ParsedStatement | None, emitter: _Emitter) -> StatementSlots | None:
    if statement is None:
        return None
    slots = tuple(
        emitter.writer(argument.target) if argument.target else emitter.slot(argument.value)
        for argument in statement.arguments
    )
    indices = tuple(tuple(emitter.slot(index) for index in argument.indices) for argument in statement.arguments)
    return StatementSlots(statement, slots, indices)


def _result(emitter: _Emitter, namespace: dict[str, Any]) -> tuple[Values, Evaluate | None]:
    if emitter.constant:
        return tuple(emitter.constants), None
    return (), emitter.function(namespace)
