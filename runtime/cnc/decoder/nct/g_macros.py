"""The codes of macro calls: G65, G66, G66.1, G67 (programmer's manual lines 6059–6306)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.arguments import Argument, ArgumentError, assigned
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.macros import ModalCall
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code
from runtime.cnc.decoder.nct.variables import Locals
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue


def _called(x: NctExecution, call: GCall) -> tuple[int, int, Locals, int]:
    """P, L and the arguments of a block with G65, G66 or G66.1, and the column of P."""
    words = x.words
    program = words.needed("P", catalogue.FAULTY_P, call.column)
    if program != int(program) or not 1 <= program <= 9999:
        raise LineError(catalogue.FAULTY_P, words.place("P"))
    passes = words.number("L")
    if passes is not None and not 1 <= passes <= 9999:
        raise LineError(catalogue.FAULTY_L, words.place("L"), value=passes, least=1)
    given: list[Argument] = []
    for word, value in words.all:
        if word.address in ("P", "L"):
            if word.column != words.place(word.address):
                raise LineError(catalogue.WORD_TWICE, word.column, address=word.address)
            continue
        if word.address == "G" and word.column == call.column:
            continue
        given.append(Argument(word.address, value, word.column))
    try:
        arguments = assigned(given)
    except ArgumentError as error:
        raise LineError(error.entry, error.column, **error.values) from None
    return int(program), int(passes or 1), arguments, words.place("P")


@g_code(
    "65", Group.ONE_SHOT, "nct.macro.simple-call-g65", meaning="macro call: G65 P<program> L<passes> <arguments>",
    stage=Stage.LAST, all_words=True,
)  # fmt: skip
def simple_call(x: NctExecution, call: GCall) -> None:
    program, passes, arguments, column = _called(x, call)
    x.macros.call(program, passes, arguments, column)


@g_code(
    "66", Group.MACRO, "nct.macro.modal-call-g66", meaning="macro call behind each motion: G66 P L <arguments>",
    stage=Stage.LAST, all_words=True,
)  # fmt: skip
def modal_call(x: NctExecution, call: GCall) -> None:
    if call.modal:
        return
    program, passes, arguments, column = _called(x, call)
    x.levels.find(program, column)
    x.macros.activate(ModalCall(program, passes, arguments, every_block=False))
    x.active[Group.MACRO] = call.tenths


@g_code(
    "66.1", Group.MACRO, "nct.macro.block-call-g66-1", meaning="macro call in the place of each block: G66.1 P L <arguments>",
    stage=Stage.LAST, all_words=True,
)  # fmt: skip
def block_call(x: NctExecution, call: GCall) -> None:
    """The block of G66.1 calls the macro already."""
    program, passes, arguments, column = _called(x, call)
    modal: list[ModalCall] = x.level.modal_calls
    before = list(modal)
    made = ModalCall(program, passes, arguments, every_block=True)
    x.macros.call(program, passes, arguments, column).modal_calls = before
    modal.append(made)
    x.active[Group.MACRO] = call.tenths


@g_code(
    "67",
    Group.MACRO,
    "nct.macro.modal-call-g66",
    "nct.macro.block-call-g66-1",
    meaning="end of the last modal macro call",
)
def cancel(x: NctExecution, call: GCall) -> None:
    if not call.modal:
        x.macros.cancel()
