"""V.G.: names and levels of programs, cycles (programming manual lines 21316–21350, 21510)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.levels import path_number
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import round_half_up
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue
from runtime.hli.layout import Mode

_INFO = "isg.var.g-program-info"
_CYCLE = "isg.var.g-cycle-parameters"
_TRANSFERS = 200


def _number(name: str) -> float:
    return float(name) if name.isdecimal() and name.isascii() else 0.0


@variable("V.G.MAIN_FILE_NAME", _INFO, "file name of the main program", kind=ValueKind.STRING)
def main_file_name(x: Execution) -> str:
    """- in MDI and manual mode, whose blocks are no file."""
    if x.outside.operating_mode() in (Mode.MDI, Mode.MANUAL):
        return "-"
    return x.frames[0].unit.text.path.name


@variable("V.G.MAIN_PROG_NAME", _INFO, "name of the main program", kind=ValueKind.STRING)
def main_program_name(x: Execution) -> str:
    return x.frames[0].section.name


@variable("V.G.MAIN_PROG_NR", _INFO, "name of the main program if it is a number, else 0")
def main_program_number(x: Execution) -> float:
    return _number(x.frames[0].section.name)


@variable("V.G.FILE_NAME", _INFO, "file name of the active program", kind=ValueKind.STRING)
def file_name(x: Execution) -> str:
    return x.unit.text.path.name


@variable("V.G.PROG_NAME", _INFO, "name of the active program", kind=ValueKind.STRING)
def program_name(x: Execution) -> str:
    return x.frame.section.name


@variable("V.G.PROG_NR", _INFO, "name of the active program if it is a number, else 0")
def program_number(x: Execution) -> float:
    return _number(x.frame.section.name)


@variable("V.G.PROG_LEVEL", _INFO, "program level: 1 in the main program")
def program_level(x: Execution) -> float:
    return float(len(x.frames))


@variable("V.G.PATH_NR", _INFO, "number of the search path of the active file, from 1 on; 0 if it lies in none")
def path(x: Execution) -> float:
    return float(path_number(x.library, x.unit))


@variable("V.G.FILE_OFFSET", _INFO, "position in the file where the block begins that reads it", unit="bytes")
def file_offset(x: Execution) -> float:
    return float(x.unit.offset(x.entry))


@variable("V.G.CYCLE_ACTIVE", _CYCLE, "1 if the program level is a cycle")
def cycle_active(x: Execution) -> float:
    return float(x.frame.transfer is not None)


@variable("V.G.@P[].VALID", _CYCLE, "1 if the transfer parameter was given in the call")
def transfer_valid(x: Execution, index: float) -> float:
    frame = next((frame for frame in reversed(x.frames) if frame.transfer is not None), None)
    if frame is None:
        raise CalculationError(catalogue.TRANSFER_OUTSIDE, "V.G.@P")
    if not 0.5 <= index < _TRANSFERS + 0.5:
        raise CalculationError(catalogue.ARRAY_INDEX, "V.G.@P", value=index, last=_TRANSFERS)
    return float(round_half_up(index) in frame.given)


@variable(
    "V.G.CYCLE_CHANGES_MODAL",
    "isg.var.g-cycle-changes-modal",
    "1: modal changes of a cycle stay behind it (P-CHAN-00210)",
)
def cycle_changes_modal(x: Execution) -> float:
    return float(x.keep_cycle_changes)


@writes("V.G.CYCLE_CHANGES_MODAL")
def set_cycle_changes_modal(x: Execution, value: float) -> None:
    x.keep_cycle_changes = value >= 0.5
