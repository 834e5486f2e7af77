"""`ParsedBlock` → `CompiledBlock`: one Python function that computes all values of the block.

A block is compiled when it is executed for the first time; blocks of plain numbers need no function. The globals of the function
are the namespace of the decoder that executes it.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct.addresses import COORDINATES, checked
from runtime.cnc.language.nct.program_file import BlockText
from runtime.cnc.language.nct.words import ControlStatement, Expression, ParsedBlock, Word
from runtime.diagnostics.catalogue import nct as catalogue

Value = float | None  # None: vacant
Values = tuple[Value, ...]


@dataclass(frozen=True, slots=True)
class CompiledBlock:
    """A block ready to be executed: `values()` computes, in the order of the text, the values of `words`.

    `condition` and `target` do the same for a control statement, `assigns` execute the assignments one by one. Each raises
    CalculationError.
    `constant`: the words have plain numbers, so `values()` is the same each time. `comment`: text of the first comment.
    """

    source: BlockText
    words: tuple[Word, ...] = ()
    number: int = -1
    skip: int = 0
    comment: str = ""
    control: ControlStatement | None = None
    constants: Values | None = None
    evaluate: Callable[[], Values] | None = None
    condition: Callable[[], bool] | None = None
    target: Callable[[], Value] | None = None
    assigns: tuple[Callable[[], None], ...] = ()
    simple: bool = (
        False  # nothing but G00 or G01, absolute or incremental axis words and F, as plain numbers, none twice
    )

    @property
    def constant(self) -> bool:
        return self.constants is not None

    @property
    def empty(self) -> bool:
        """The block says nothing: a comment, or a number alone."""
        return not self.words and self.control is None and not self.assigns

    def values(self) -> Values:
        """The values of the words, vacant ones None; those of the text are checked and rounded."""
        if self.constants is not None:
            return self.constants
        assert self.evaluate is not None
        return self.evaluate()


def compile_block(block: ParsedBlock, source: BlockText, namespace: dict[str, Any]) -> CompiledBlock:
    """Compile a block. LineError for a value out of the range of its address, and for a name that is not there."""
    constants: Values | None = None
    evaluate = None
    if all(word.value.constant is not None for word in block.words):
        constants = tuple(checked(w.address, w.value.constant or 0.0, w.column) for w in block.words)
    else:
        for word in block.words:
            _expect_names(word.value, namespace, word.column)
        inner = ", ".join(word.value.source for word in block.words)
        evaluate = _made(f"lambda: ({inner},)", namespace)
    condition = target = None
    assigns: list[Callable[[], None]] = []
    control = block.control
    if control is not None:
        if control.condition is not None:
            _expect_names(control.condition, namespace, control.column)
            condition = _made(f"lambda: {control.condition.source}", namespace)
        if control.target is not None:
            _expect_names(control.target, namespace, control.column)
            target = _made(f"lambda: {control.target.source}", namespace)
    for assignment in block.assignments:
        _expect_names(assignment.value, namespace, assignment.column, "write")
        _expect_names(assignment.number, namespace, assignment.column)
        assigns.append(_made(f"lambda: write({assignment.number.source}, {assignment.value.source})", namespace))
    return CompiledBlock(
        source,
        block.words,
        block.number,
        block.skip,
        block.comment,
        control,
        constants,
        evaluate,
        condition,
        target,
        tuple(assigns),
        constants is not None and control is None and _simple(block.words),
    )


def _simple(words: tuple[Word, ...]) -> bool:
    names = [word.address for word in words]
    return (
        len(set(names)) == len(names)
        and any(name in COORDINATES for name in names)
        and all(
            (word.address in COORDINATES and not word.incremental)
            or word.address == "F"
            or (word.address == "G" and word.value.constant in (0.0, 1.0))
            for word in words
        )
    )


def _made(source: str, namespace: dict[str, Any]) -> Callable[[], Any]:
    made: Callable[[], Any] = eval(compile(source, "<NC block>", "eval"), namespace)
    return made


def _expect_names(expression: Expression, namespace: Mapping[str, Any], column: int, *more: str) -> None:
    for name in sorted(expression.names.union(more)):
        if name not in namespace:
            what = {"read": "reading a variable", "write": "writing a variable"}.get(name, name)
            raise LineError(catalogue.NOT_SUPPORTED, column, what=what)
