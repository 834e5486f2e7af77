"""Declarations in #VAR … #ENDVAR (programming manual 8108–8146, 21827–21914)."""

from __future__ import annotations

import re

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.compiler import DeclarationSlots, Values
from runtime.cnc.language.isg.functions import as_number, round_half_up
from runtime.diagnostics.catalogue import language as catalogue

_USER = re.compile(r"V\.(P|S|L|CYC)\.([^\[\]]+)(?:\[\])*$")


def declare(x: Execution, slots: DeclarationSlots, values: Values) -> None:
    """A declaration of the block. LineError outside #VAR, CalculationError for sizes and values that don't fit."""
    word = slots.word
    if not x.declaring:
        raise LineError(catalogue.DECLARATION_PLACE, word.column, name=word.name.replace("[]", "[..]"))
    given = [values[slot] for slot in slots.values]
    indices = tuple(values[slot] for slot in slots.indices)
    if word.name == "P":
        if word.target not in ("", "REAL64"):
            raise LineError(catalogue.TYPE_INVALID, word.column, type=word.target)
        if len(given) > 1:
            raise LineError(catalogue.ARRAY_NEEDED, word.column, name="P", given=0)
        number = round_half_up(indices[0])
        x.parameter_arrays.delete(str(number))  # declaring makes anew
        if number not in x.parameters:
            x.environment.new_parameter(number)
        x.parameters[number] = as_number(given[0], f"P{number}") if given else 0.0
        return
    if word.name.startswith("P[]"):
        number, *sizes = indices
        name = str(round_half_up(number))
        x.parameters.pop(int(name), None)
        if name not in x.parameter_arrays:
            x.environment.new_parameter(int(name))
        x.parameter_arrays.declare(name, word.target, tuple(sizes), given)
        return
    match = _USER.match(word.name)
    if match is None:
        hint = "V.P, V.S, V.L, V.CYC and P parameters can be declared"
        raise LineError(catalogue.VARIABLE_UNKNOWN, word.column, name=word.name, hint=hint)
    scope, name = x.own_scope(match.group(1)), match.group(2)
    scope.declare(name, word.target, indices, given)
    if match.group(1) == "CYC":
        x.check_cycle_memory(scope, name)
