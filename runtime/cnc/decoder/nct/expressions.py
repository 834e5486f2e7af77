"""What the names in expressions mean: arithmetic, comparisons, variables (programmer's manual lines 6567–6720, 7260–7434)."""

from __future__ import annotations

from typing import Any

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.names import names
from runtime.cnc.language.nct import functions

OPERATORS = (
    functions.negate,
    functions.add,
    functions.subtract,
    functions.multiply,
    functions.divide,
    functions.modulo,
    functions.bit_and,
    functions.bit_or,
    functions.bit_xor,
)


@names
def arithmetic(x: NctExecution) -> dict[str, Any]:
    called = {name: function.call for name, function in functions.FUNCTIONS.items()}
    return {call.__name__: call for call in OPERATORS} | functions.COMPARISONS | called


@names
def variables(x: NctExecution) -> dict[str, Any]:
    return {"read": x.variables.read, "write": x.variables.write, "number_of": x.variables.number_of}
