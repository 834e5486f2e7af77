"""System variables of the PLC interface: 16 inputs and 16 outputs, bit by bit or as a number (manual lines 6721–6823).

    #1000 … #1015   inputs, #1032 all of them      word `i_line`, an external variable of type UNS16 that the PLC writes
    #1100 … #1115   outputs, #1132 all of them     word `o_line`, one that the PLC reads

Bit n has the weight 2 to the n. An input is read when the path has come to the block, an output is put out there.
"""

from __future__ import annotations

from runtime.cnc.blocks import ExternalWrite
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import system_variable, writes
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.nct.functions import Value, number
from runtime.diagnostics.catalogue import nct_macros as catalogue
from runtime.hli.external import ExternalEntry, read_external

BITS = 16
KIND, SIZE = "UNS16", 2
INPUTS, ALL_INPUTS = 1000, 1032
OUTPUTS, ALL_OUTPUTS = 1100, 1132
_SPEC = "nct.sysvar.interface-io"


def _word(x: NctExecution, name: str, key: str, variable: int) -> ExternalEntry:
    """The external variable of a word. CalculationError if the machine has none."""
    if not name:
        reason = f"the description of the channel has no {key}"
        raise CalculationError(catalogue.VARIABLE_REFUSED, f"#{variable}", number=variable, reason=reason)
    for entry in x.setup.external:
        if entry.path.removeprefix("V.E.") == name and entry.kind == KIND and not entry.dims:
            return entry
    reason = f"{key} names {name}, which is no external variable of type {KIND}"
    raise CalculationError(catalogue.VARIABLE_REFUSED, f"#{variable}", number=variable, reason=reason)


def _stored(x: NctExecution, entry: ExternalEntry) -> int:
    value = read_external(x.outside.external, entry.offset, KIND, SIZE)
    assert not isinstance(value, str)
    return int(value)


def _inputs(x: NctExecution, variable: int) -> int:
    return _stored(x, _word(x, x.setup.nct.i_line, "i_line", variable))


def _outputs(x: NctExecution, variable: int) -> int:
    """What was put out last, by this program or before it."""
    entry = _word(x, x.setup.nct.o_line, "o_line", variable)
    return _stored(x, entry) if x.outputs is None else x.outputs


def _put_out(x: NctExecution, variable: int, word: int) -> None:
    entry = _word(x, x.setup.nct.o_line, "o_line", variable)
    x.outputs = word
    x.emit(ExternalWrite(x.source, entry.offset, KIND, SIZE, float(word)))


def _whole(variable: int, value: Value, most: int) -> int:
    given = number(value)
    if given not in range(most + 1):
        values = {"value": f"{given:g}", "allowed": f"whole numbers from 0 to {most}"}
        raise CalculationError(catalogue.VALUE_REFUSED, f"#{variable}", number=variable, **values)
    return round(given)


@system_variable(INPUTS, INPUTS + BITS - 1, _SPEC, meaning="inputs 0 to 15 of the interface, 0 or 1", in_step=True)
def one_input(x: NctExecution, variable: int) -> Value:
    return float(_inputs(x, variable) >> (variable - INPUTS) & 1)


@system_variable(ALL_INPUTS, None, _SPEC, meaning="all 16 inputs as a number", in_step=True)
def all_inputs(x: NctExecution, variable: int) -> Value:
    return float(_inputs(x, variable))


@system_variable(OUTPUTS, OUTPUTS + BITS - 1, _SPEC, meaning="outputs 0 to 15 of the interface, 0 or 1")
def one_output(x: NctExecution, variable: int) -> Value:
    return float(_outputs(x, variable) >> (variable - OUTPUTS) & 1)


@writes(OUTPUTS)
def put_out_one(x: NctExecution, variable: int, value: Value) -> None:
    bit = 1 << (variable - OUTPUTS)
    word = _outputs(x, variable)
    _put_out(x, variable, word | bit if _whole(variable, value, 1) else word & ~bit)


@system_variable(ALL_OUTPUTS, None, _SPEC, meaning="all 16 outputs as a number")
def all_outputs(x: NctExecution, variable: int) -> Value:
    return float(_outputs(x, variable))


@writes(ALL_OUTPUTS)
def put_out_all(x: NctExecution, variable: int, value: Value) -> None:
    _put_out(x, variable, _whole(variable, value, 2**BITS - 1))
