"""`ParsedBlock` → `CompiledBlock`: one Python function that computes all values of the block, and where each value
belongs.

A block is compiled when it is executed for the first time. Executing it again is one call; blocks of plain numbers
need none.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from runtime.cnc.language.addresses import Addresses
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg import functions
from runtime.cnc.language.isg.expressions import NUMBER_LIMIT
from runtime.cnc.language.isg.parser import MAX_PARAMETER
from runtime.cnc.language.isg.registry import G_FUNCTIONS, GFunction
from runtime.cnc.language.isg.words import ControlStatement, Expression, ParsedBlock, Word, WordKind
from runtime.diagnostics.catalogue import language as catalogue

Values = tuple[float, ...]
Evaluate = Callable[[dict[int, float]], Values]


class Parameters(dict[int, float]):
    """The P parameters by number; reading one that has no value raises CalculationError."""

    def __missing__(self, number: int) -> float:
        raise CalculationError(catalogue.PARAMETER_UNSET, f"P{number}")


def parameter_number(value: float) -> int:
    """The number of a parameter from a computed value."""
    if not 0.5 <= value <= MAX_PARAMETER:
        raise CalculationError(catalogue.PARAMETER_INDEX, "P[", value=value)
    return functions.round_half_up(value)


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
            parameter_number,
        )
    },
    "check_assigned": _check_assigned,
}


@dataclass(frozen=True, slots=True)
class FunctionSlots:
    """An M or H function: slots of its number and of its additional value (-1 without)."""

    word: Word
    number: int
    extra: int


@dataclass(frozen=True, slots=True)
class CompiledBlock:
    """A block ready to be executed.

    `values(parameters)` gives the values; the other fields are slots in them, -1 where the word is not programmed.
    `axes` and `interpolation` are pairs (index, slot). For a control statement the slots 0, 1, 2 are its expressions.
    """

    text: str
    skip_level: int = 0
    constants: Values = ()
    evaluate: Evaluate | None = None
    number: int = -1
    g: tuple[GFunction, ...] = ()
    axes: tuple[tuple[int, int], ...] = ()
    interpolation: tuple[tuple[int, int], ...] = ()
    radius: int = -1
    feed: int = -1
    speed: int = -1
    tool: int = -1
    m: tuple[FunctionSlots, ...] = ()
    h: tuple[FunctionSlots, ...] = ()
    dwell: int = -1
    dwell_revolutions: bool = False
    call: Word | None = None
    control: ControlStatement | None = None
    counter: int = -1  # slot of the number of the counter of $FOR
    words: tuple[Word, ...] = ()

    def values(self, parameters: dict[int, float]) -> Values:
        """All values of the block, assignments done; raises CalculationError."""
        return self.constants if self.evaluate is None else self.evaluate(parameters)

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

    def slot(self, expression: Expression | None) -> int:
        if expression is None:
            return -1
        index = len(self.slots)
        if expression.constant is None:
            self.constant = False
            self.lines.append(f"v{index} = {expression.source}")
            self.slots.append(f"v{index}")
        else:
            self.slots.append(repr(expression.constant))
            self.constants.append(expression.constant)
        return index

    def assign(self, target: str, expression: Expression) -> None:
        self.constant = False
        self.lines += [
            f"n, v = {target}, {expression.source}",
            f"if not -{NUMBER_LIMIT!r} <= v <= {NUMBER_LIMIT!r}: check_assigned(v, n)",
            "p[n] = v",
        ]

    def function(self, addresses: Addresses) -> Evaluate:
        body = "\n".join(f"    {line}" for line in self.lines)
        source = f"def block(p):\n{body}\n    return ({', '.join(self.slots)}{',' if self.slots else ''})\n"
        namespace: dict[str, Any] = {**NAMES, "known_m": addresses.m, "known_h": addresses.h}
        exec(compile(source, "<NC block>", "exec"), namespace)
        function: Evaluate = namespace["block"]
        return function


def compile_block(block: ParsedBlock, text: str, addresses: Addresses) -> CompiledBlock:
    """Compile a block. Assignments and values are computed in the order of the words."""
    emitter = _Emitter()
    if block.control is not None:
        for expression in block.control.expressions:
            emitter.slot(expression)
        target = block.control.target
        counter = emitter.slot(Expression(target)) if target else -1
        number = emitter.slot(block.number)
        constants, evaluate = _result(emitter, addresses)
        return CompiledBlock(
            text, block.skip_level, constants, evaluate, number=number, control=block.control, counter=counter
        )
    slots: dict[WordKind, int] = {}
    axes: list[tuple[int, int]] = []
    interpolation: list[tuple[int, int]] = []
    functions_of: dict[WordKind, list[FunctionSlots]] = {WordKind.M: [], WordKind.H: []}
    g: list[GFunction] = []
    call: Word | None = None
    number = emitter.slot(block.number)
    for word in block.words:
        if word.kind is WordKind.ASSIGNMENT:
            assert word.value is not None
            emitter.assign(word.target, word.value)
        elif word.kind is WordKind.AXIS:
            axes.append((word.index, emitter.slot(word.value)))
        elif word.kind is WordKind.INTERPOLATION:
            interpolation.append((word.index, emitter.slot(word.value)))
        elif word.kind in functions_of:
            functions_of[word.kind].append(FunctionSlots(word, emitter.slot(word.value), emitter.slot(word.extra)))
        elif word.kind is WordKind.G:
            g.append(G_FUNCTIONS[word.index])
            if word.value is not None:
                slots[WordKind.RADIUS] = emitter.slot(word.value)
        elif word.kind in (WordKind.CALL_LOCAL, WordKind.CALL_GLOBAL):
            call = word
        else:
            slots[word.kind] = emitter.slot(word.value)
    constants, evaluate = _result(emitter, addresses)
    dwell = slots.get(WordKind.DWELL, -1)
    return CompiledBlock(
        text,
        block.skip_level,
        constants,
        evaluate,
        number,
        tuple(g),
        tuple(axes),
        tuple(interpolation),
        slots.get(WordKind.RADIUS, -1),
        slots.get(WordKind.FEED, -1),
        slots.get(WordKind.SPEED, -1),
        slots.get(WordKind.TOOL, -1),
        tuple(functions_of[WordKind.M]),
        tuple(functions_of[WordKind.H]),
        dwell,
        dwell >= 0 and block.words[0].index == 1,
        call,
        words=block.words,
    )


def _result(emitter: _Emitter, addresses: Addresses) -> tuple[Values, Evaluate | None]:
    if emitter.constant:
        return tuple(emitter.constants), None
    return (), emitter.function(addresses)
