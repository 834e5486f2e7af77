"""Addresses A, B, C that are no axes: their value goes to the PLC as an H function (manual lines 2879–2886)."""

from __future__ import annotations

from runtime.cnc.blocks import Technology
from runtime.cnc.decoder.block_functions import Functions, put_out
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import language
from runtime.diagnostics.catalogue import nct as catalogue

MOST = 999  # three digits


def put_out_auxiliary(x: NctExecution, functions: Functions) -> None:
    """The auxiliary functions of the block in work, A before B before C. Raises LineError."""
    for address in sorted(x.nct.miscel):
        value = x.words.number(address)
        if value is None:
            continue
        column, number = x.words.place(address), x.nct.miscel[address]
        if not 0 <= value <= MOST:
            raise LineError(catalogue.VALUE_EXCESS, column, address=address, value=value, least=0, most=MOST)
        if x.words.incremental(address):
            raise LineError(catalogue.ADDRESS_RIGHT, column, address=address, what="the operator I")
        if number not in x.memory.h_synch:
            raise LineError(language.H_UNDEFINED, column, number=number)
        put_out(x, functions, Technology.H, number, float(round(value)), column)
