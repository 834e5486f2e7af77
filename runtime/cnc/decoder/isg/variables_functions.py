"""V.G.M_FCT, V.G.H_FCT: synchronisation of M and H functions at run time (programming manual 21365–21390).

What a program changes holds for the programs that follow, until the next start of the control.
"""

from __future__ import annotations

from runtime.cnc.blocks import BY_PATH, BY_TIME, MICRO_JOINTS, Synch
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.setup import DecoderSetupError, parse_synch
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import as_number, round_half_up
from runtime.config.channel.parameters import INTERNAL
from runtime.diagnostics.catalogue import language as catalogue
from runtime.diagnostics.catalogue import technology
from runtime.hli.units import MICROSECOND

_SPEC = "isg.var.g-mh-functions"
_BITS = 2**32


def _table(x: Execution, letter: str) -> dict[int, Synch]:
    return x.memory.m_synch if letter == "M" else x.memory.h_synch


def _number(x: Execution, letter: str, value: float) -> int:
    """The number of a configured function; CalculationError for another one."""
    number, name = round_half_up(value), f"V.G.{letter}_FCT"
    if number not in _table(x, letter):
        raise CalculationError(catalogue.FUNCTION_NOT_CONFIGURED, name, letter=letter, number=number)
    return number


def _usable(code: str, name: str, index: int) -> Synch:
    """The type of a code or name; CalculationError for one that is unknown or not supported."""
    try:
        return parse_synch(code, f"{name}[{index}].SYNCH")
    except DecoderSetupError as error:
        raise CalculationError(error.problem.entry, name, **error.problem.values) from None


def _functions(letter: str) -> None:
    name = f"V.G.{letter}_FCT"

    @variable(f"{name}[].SYNCH", _SPEC, f"synchronisation type of an {letter} function, as P-CHAN-00041 codes it")
    def synch(x: Execution, number: float) -> float:
        return float(int(_table(x, letter)[_number(x, letter, number)]))

    @writes(f"{name}[].SYNCH")
    def set_synch(x: Execution, value: float, number: float) -> None:
        index = _number(x, letter, number)
        code = round_half_up(as_number(value, name))
        shown = hex(code) if 0 <= code < _BITS else str(code)
        kind = _usable(shown, name, index)
        if kind == Synch.NOT_VALID:
            raise CalculationError(catalogue.SYNCH_VALUE, name, value=shown)
        _table(x, letter)[index] = kind

    _ahead(letter, "PATH", "path in front of the place of output", BY_PATH, Synch.MEP_SVS)
    _ahead(letter, "TIME", "time in front of it", BY_TIME, Synch.MET_SVS)


def _ahead(letter: str, ahead: str, what: str, fitting: Synch, implied: Synch) -> None:
    """`implied` is the type that a function gets by writing the value while its type is not a `fitting` one (line 21370)."""
    name = f"V.G.{letter}_FCT"
    path = f"{name}[].PRE_OUTP_{ahead}"
    way = ahead == "PATH"
    unit = INTERNAL if way else MICROSECOND
    said = "distance" if way else "time"

    def table(x: Execution) -> dict[int, int]:
        return x.memory.m_ahead if letter == "M" else x.memory.h_ahead

    def joint(x: Execution, synch: Synch) -> bool:
        return x.setup.micro_joints and bool(synch & MICRO_JOINTS)

    @variable(path, _SPEC, what, unit="mm, inch" if way else "s")
    def read(x: Execution, number: float) -> float:
        index = _number(x, letter, number)
        synch = _table(x, letter)[index]
        if not synch & fitting and not (way and joint(x, synch)):
            shown = synch.kind.name
            raise CalculationError(technology.PRE_OUTPUT, name, letter=letter, number=index, synch=shown, what=said)
        value = table(x).get(index, 0) * unit
        return x.shown_length(value) if way else value

    @writes(path)
    def write(x: Execution, value: float, number: float) -> None:
        index = _number(x, letter, number)
        given = as_number(value, name)
        units = (x.length(given) if way else given) / unit
        if not 0.0 <= units < _BITS:
            raise CalculationError(technology.PRE_OUTPUT_VALUE, name, value=given, what=said)
        synch = _table(x, letter)[index]
        if not synch & fitting and not (way and joint(x, synch)):
            _table(x, letter)[index] = implied | synch.flags
        table(x)[index] = round_half_up(units)


_functions("M")
_functions("H")
