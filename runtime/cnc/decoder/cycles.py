"""Cycles with transfer parameters, modal cycles, and returns to a chosen place (programming manual 6646–6721, 7300–7562)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.flow import Flow
from runtime.cnc.decoder.frames import Level, Modal
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import CompiledBlock
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue


def call_modal(x: Execution, flow: Flow, modal: Modal) -> None:
    """Call a modal cycle once more."""
    frame = flow.enter(modal.unit, modal.section, modal.section.name, 1, Level.CYCLE)
    frame.transfer = dict(modal.transfer)
    frame.given = frozenset(modal.transfer)
    frame.saved = x.modal.copy()


def parametrised_return(x: Execution, flow: Flow, block: CompiledBlock) -> None:
    """M17 [..]: leave levels and go on at a label or block number."""
    raise LineError(catalogue.NOT_SUPPORTED, block.column(WordKind.RETURN), what="M17 with brackets")
