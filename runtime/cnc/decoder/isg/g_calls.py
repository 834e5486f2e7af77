"""G functions that call subprograms: G80–G89, G800–G839 (programming manual lines 4269–4326)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, g_function
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Group, Values
from runtime.diagnostics.catalogue import language as catalogue

CALLS = (*range(80, 90), *range(800, 840))
MOST_VALUES = 50


def _call(number: int) -> None:
    @g_function(
        number,
        Group.CALL,
        "isg.g.implicit-subroutines-g80",
        modal=False,
        syntax=f"G{number} [<value>,<value>,,<value>]",
        values=Values.BRACKETS,
        last=True,
    )
    def call_program(x: Execution, call: GCall) -> None:
        x.pending_transfer = None
        word = f"G{number}"
        name = x.levels.file_of(word)
        if not name:
            raise LineError(catalogue.CALL_FILE, call.column, word=word)
        if not call.bracketed:
            x.levels.call_file(word, call.column)
            return
        if len(call.values) > MOST_VALUES:
            raise LineError(catalogue.VALUES_MANY, call.column, word=word, limit=MOST_VALUES)
        transfer: dict[int, float | str] = {}
        for place, value in enumerate(call.values, 1):
            if isinstance(value, str):
                raise LineError(catalogue.STRING_NOT_ALLOWED, call.column, what=word)
            if value is not None:
                transfer[place] = value
        unit, section = x.levels.program(x.frame, False, name, call.column)
        x.levels.enter_cycle(unit, section, name, call.column, transfer)


for _number in CALLS:
    _call(_number)
