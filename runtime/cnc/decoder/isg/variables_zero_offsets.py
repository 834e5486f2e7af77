"""V.G.NP, V.G.NP_AKT: stored data sets of the zero offsets and the active one (programming manual 4625–4750, 21179–21186).

Writing NP changes the stored set, for all programs; it acts when the set is selected the next time. Writing NP_AKT changes what
is active now, until a set is selected. Whole sets (.ALL) are arrays of mm and degrees, (n,).
"""

from __future__ import annotations

import numpy as np

from runtime.cnc.blocks import Floats
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.isg.variables_channel import index_between
from runtime.cnc.decoder.memory import ZERO_OFFSET_SETS
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import as_number
from runtime.cnc.language.isg.words import ValueKind
from runtime.cnc.tools.offset_table import OffsetTableError
from runtime.diagnostics.catalogue import language as catalogue

_SPEC = "isg.var.g-zero-offsets"
_COUNTERS = "isg.var.g-invoke-counters"


def _set(value: float) -> int:
    return index_between(value, 0, ZERO_OFFSET_SETS - 1, "V.G.NP")


def _whole(value: object, name: str) -> Floats:
    """A whole set; CalculationError for a single value."""
    if not isinstance(value, np.ndarray):
        raise CalculationError(catalogue.SETS_MIXED, name)
    return value.astype(np.float64)


def _in_range(x: Execution, axis: int, value: float, name: str) -> float:
    """A value in mm or degrees that an offset may have."""
    offset = x.axis_value(axis, as_number(value, name))
    if not np.isfinite(offset):
        raise CalculationError(catalogue.RESULT_RANGE, name, value=value)
    return offset


def _keep(x: Execution, index: int, offsets: dict[int, float]) -> None:
    """Change a stored set. It counts as written once."""
    before = x.memory.zero_writes[index]
    try:
        for axis, offset in offsets.items():
            x.memory.set_work_offset(index, axis, offset)
    except OffsetTableError as error:
        raise CalculationError(error.problem.entry, "V.G.NP", **error.problem.values) from None
    x.memory.zero_writes[index] = before + 1


@variable("V.G.NP[].V.<axis>", _SPEC, "stored zero offset", unit="mm, inch, deg", syntax="V.G.NP[j].V.<axis>")
def stored(x: Execution, number: float, axis: int) -> float:
    return x.shown(axis, float(x.memory.zero_offsets[_set(number)][axis]))


@writes("V.G.NP[].V.<axis>")
def store(x: Execution, value: float, number: float, axis: int) -> None:
    index = _set(number)
    _keep(x, index, {axis: _in_range(x, axis, value, "V.G.NP")})


@variable("V.G.NP[].ALL", _SPEC, "all offsets of a stored set", kind=ValueKind.ANY, syntax="V.G.NP[j].ALL")
def stored_set(x: Execution, number: float) -> Floats:
    return np.array(x.memory.zero_offsets[_set(number)])


@writes("V.G.NP[].ALL")
def store_set(x: Execution, value: object, number: float) -> None:
    index = _set(number)
    _keep(x, index, {axis: float(offset) for axis, offset in enumerate(_whole(value, "V.G.NP"))})


@variable("V.G.NP_AKT.V.<axis>", _SPEC, "active zero offset", unit="mm, inch, deg")
def active(x: Execution, axis: int) -> float:
    return x.shown(axis, x.coordinates.offsets.zero[axis])


@writes("V.G.NP_AKT.V.<axis>")
def change_active(x: Execution, value: float, axis: int) -> None:
    zero = list(x.coordinates.offsets.zero)
    zero[axis] = _in_range(x, axis, value, "V.G.NP_AKT")
    x.coordinates.offsets.zero = zero
    x.coordinates.update()


@variable("V.G.NP_AKT.ALL", _SPEC, "all active zero offsets", kind=ValueKind.ANY)
def active_set(x: Execution) -> Floats:
    return np.array(x.coordinates.offsets.zero)


@writes("V.G.NP_AKT.ALL")
def change_active_set(x: Execution, value: object) -> None:
    x.coordinates.offsets.zero = [float(offset) for offset in _whole(value, "V.G.NP_AKT")]
    x.coordinates.update()


@variable("V.G.NP_AKT.IDX", _SPEC, "number of the active set: 0 with G53, 1 with G54 …")
def active_number(x: Execution) -> float:
    return float(x.modal.zero_offset)


@variable("V.G.NP_DEFAULT", _SPEC, "number of the set that is active when a program starts")
def default_number(x: Execution) -> float:
    return float(x.memory.zero_default)


@writes("V.G.NP_DEFAULT")
def set_default_number(x: Execution, value: float) -> None:
    x.memory.zero_default = _set(value)


@variable("V.G.NP[].INVOKE_COUNT", _COUNTERS, "how often a stored set was written", syntax="V.G.NP[j].INVOKE_COUNT")
def writes_of_set(x: Execution, number: float) -> float:
    return float(x.memory.zero_writes[_set(number)])


@variable("V.G.NP_AKT.INVOKE_COUNT", _COUNTERS, "how often the stored set of the active one was written")
def writes_of_active_set(x: Execution) -> float:
    return float(x.memory.zero_writes[x.modal.zero_offset])
