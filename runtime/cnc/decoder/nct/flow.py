"""Control statements: GOTO, IF, WHILE, DO, END (manual lines 7435–7608)."""

from __future__ import annotations

from collections.abc import Callable

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.language.errors import LineError
from runtime.cnc.language.nct.compiler import CompiledBlock
from runtime.cnc.language.nct.words import Control
from runtime.diagnostics.catalogue import nct as catalogue

# What a control statement does: it sets where the level goes on (`x.levels.jump`, `x.level.go_to`) and returns whether the rest
# of the block (the instruction behind IF) is to be executed.
ControlHandler = Callable[[NctExecution, CompiledBlock], bool]

CONTROLS: dict[Control, ControlHandler] = {}


def control(kind: Control) -> Callable[[ControlHandler], ControlHandler]:
    """Register the decorated handler of a control statement."""

    def register(handler: ControlHandler) -> ControlHandler:
        CONTROLS[kind] = handler
        return handler

    return register


def execute_control(x: NctExecution, block: CompiledBlock) -> bool:
    """The control statement of a block; whether the rest is to be executed. LineError if there is no such statement."""
    statement = block.control
    assert statement is not None
    handler = CONTROLS.get(statement.control)
    if handler is None:
        raise LineError(catalogue.NO_CONTROL, statement.column, statement=statement.control.value)
    return handler(x, block)
