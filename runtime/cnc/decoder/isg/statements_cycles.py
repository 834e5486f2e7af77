"""Cycle calls, block sequences, and what belongs to them (programming manual lines 7300–8053)."""

from __future__ import annotations

from runtime.cnc.decoder import sequences
from runtime.cnc.decoder.cycles import call_cycle
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Level
from runtime.cnc.decoder.isg.registry import StatementCall, statement
from runtime.cnc.language.isg.syntax import Form, Key, KeyKind
from runtime.diagnostics.catalogue import language as catalogue

TRANSFERS = 200
_CYCLE_KEYS = (
    Key("NAME", KeyKind.NAME, needed=True),
    Key("MODAL_MOVE", KeyKind.FLAG),
    Key("MODAL_BLOCK", KeyKind.FLAG),
    Key("MODAL", KeyKind.FLAG),
    Key("@P", KeyKind.VALUE, indexed=(1, TRANSFERS)),
)


def _cycle(name: str, local: bool) -> None:
    @statement(
        f"CALL {name} CYCLE",
        "isg.sub.cycle-call",
        "isg.sub.cycle-modal",
        syntax=(f"{name} CYCLE [NAME=<name> {{MODAL_MOVE | MODAL_BLOCK}} {{@P<n>=..}}]",),
        form=Form.KEYS,
        keys=_CYCLE_KEYS,
        prefix="",
    )
    def call(x: Execution, call: StatementCall) -> None:
        transfer = {argument.index: value for argument, value in call if argument.name == "@P"}
        move, block = call.given("MODAL_MOVE") or call.given("MODAL"), call.given("MODAL_BLOCK")
        if move and block:
            raise call.error(catalogue.CYCLE_MODAL, "MODAL_BLOCK")
        called = call.text("NAME") or ""
        call_cycle(x, local, called, call.columns("NAME"), transfer, move if move or block else None)


_cycle("L", local=False)
_cycle("LL", local=True)


@statement("DISABLE MODAL CYCLE", "isg.sub.cycle-modal")
def disable_modal_cycle(x: Execution, call: StatementCall) -> None:
    x.frame.modal = None


@statement("RETAIN CYCLE CHANGES", "isg.sub.cycle-modal-state")
def retain_cycle_changes(x: Execution, call: StatementCall) -> None:
    """The modal changes of this cycle stay for the level that has called it."""
    if x.frame.level is not Level.CYCLE:
        x.warn(catalogue.RETAIN_OUTSIDE, call.column)
    x.frame.retain = True


@statement(
    "CALL L SEQUENCE",
    "isg.sub.sequence-numbers",
    "isg.sub.sequence-labels",
    "isg.sub.sequence-endtag",
    syntax=(
        "L SEQUENCE [{NAME=<file>} N<first> {N<last>} {BEGIN} {REPEAT=..} {ENDTAG}]",
        "L SEQUENCE [{NAME=<file>} [<FIRST>] {[<LAST>]} {BEGIN} {REPEAT=..} {ENDTAG}]",
    ),
    form=Form.KEYS,
    keys=(
        Key("NAME", KeyKind.NAME),
        Key("N"),
        Key("LABEL", KeyKind.LABEL),
        Key("REPEAT"),
        Key("ENDTAG", KeyKind.FLAG),
        Key("BEGIN", KeyKind.FLAG),
    ),
    prefix="",
)
def call_sequence(x: Execution, call: StatementCall) -> None:
    sequences.call_sequence(x, call)
    x.levels.entered = True  # also where the same call is passed over


@statement("SEQUENCE END", "isg.sub.sequence-end-command")
def sequence_end(x: Execution, call: StatementCall) -> None:
    sequences.end_mark(x)
