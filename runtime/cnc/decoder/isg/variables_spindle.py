"""V.SPDL, V.SPDL_PROG: configuration of the spindles and what was programmed (programming manual 21767–21802)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.isg.variables_flags import require_absent
from runtime.cnc.language.errors import CalculationError
from runtime.diagnostics.catalogue import language as catalogue

_SPEC = "isg.var.spindle-data"


def _index(x: Execution, spindle: int) -> int:
    """The number of a spindle; one behind the last stands for the name of the main spindle, whichever that is."""
    return x.spindles.main if spindle >= len(x.setup.spindles) or _named_main(x, spindle) else spindle


def _named_main(x: Execution, spindle: int) -> bool:
    return x.setup.spindles[spindle].name.upper() == x.setup.main_name.upper()


def _require_main(x: Execution, spindle: int, name: str) -> None:
    """Turning functions belong to the main spindle."""
    if _index(x, spindle) != x.spindles.main:
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, name, purpose="spindles beside the main spindle")


@variable("V.SPDL.LOG_AX_NR.<spindle>", _SPEC, "logical axis number of a spindle")
def logical_number(x: Execution, spindle: int) -> float:
    if not x.setup.log_spindles:
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, "V.SPDL.LOG_AX_NR", purpose="no machine description")
    return float(x.setup.log_spindles[_index(x, spindle)])


@variable("V.SPDL.PLC_CONTROL.<spindle>", _SPEC, "1: the PLC moves the spindle, 0: the control does")
def moved_by_plc(x: Execution, spindle: int) -> float:
    return float(x.setup.spindles[_index(x, spindle)].plc)


@variable("V.SPDL.NBR_IN_CHANNEL", _SPEC, "spindles of the channel")
def count(x: Execution) -> float:
    return float(len(x.setup.spindles))


@variable("V.SPDL.M_FCT_FREE", _SPEC, "0: M3, M4, M5, M19 belong to the spindle, 1: they are as in m_synch")
def free_functions(x: Execution) -> float:
    return float(x.memory.spindle_m_free)


@writes("V.SPDL.M_FCT_FREE")
def free_the_functions(x: Execution, value: float) -> None:
    """Holds for the programs that follow, too."""
    if value not in (0.0, 1.0):
        raise CalculationError(catalogue.ARRAY_INDEX, "V.SPDL.M_FCT_FREE", value=value, last=1)
    x.memory.spindle_m_free = value == 1.0


@variable("V.SPDL_PROG.SPEED.<spindle>", _SPEC, "last S word", unit="rev/min")
def speed(x: Execution, spindle: int) -> float:
    return x.spindles.programmed[_index(x, spindle)].speed


@variable("V.SPDL_PROG.POSITION.<spindle>", _SPEC, "last POS", unit="°")
def position(x: Execution, spindle: int) -> float:
    return x.spindles.programmed[_index(x, spindle)].angle


@variable("V.SPDL_PROG.MOVE_CMD.<spindle>", _SPEC, "3, 4 or 5: last of M3, M4, M5 in this program, 5 before")
def command(x: Execution, spindle: int) -> float:
    return float(x.spindles.programmed[_index(x, spindle)].command)


@variable("V.SPDL_PROG.GEAR_DATA_STEP.<spindle>", _SPEC, "gear stage of G112 or M40 to M45, from 1; 0 before the first")
def gear(x: Execution, spindle: int) -> float:
    return float(x.memory.gear_data.get(_index(x, spindle), -1) + 1)


@variable("V.SPDL_PROG.DWELL_ROT_COUNT.<spindle>", _SPEC, "revolutions of the last G04 S", unit="rev")
def dwell_revolutions(x: Execution, spindle: int) -> float:
    _require_main(x, spindle, "V.SPDL_PROG.DWELL_ROT_COUNT")
    return x.dwell_revolutions


@variable("V.SPDL_PROG.MAX_SPEED.<spindle>", _SPEC, "G196: greatest speed while G96 holds, 0: none", unit="rev/min")
def greatest_speed(x: Execution, spindle: int) -> float:
    _require_main(x, spindle, "V.SPDL_PROG.MAX_SPEED")
    return x.turning.limit


@variable("V.SPDL_PROG.CONST_CUT_SPEED.<spindle>", _SPEC, "cutting speed of G96, 0: none", unit="m/min or ft/min")
def cutting_speed(x: Execution, spindle: int) -> float:
    _require_main(x, spindle, "V.SPDL_PROG.CONST_CUT_SPEED")
    return x.turning.velocity / x.turning.unit(x)


@variable("V.SPDL_PROG.GEAR_LINK_ACTIVE.<spindle>", _SPEC, "0: this control does not have the function", flush=True)
def gear_link(x: Execution, spindle: int) -> float:
    require_absent("V.SPDL_PROG.GEAR_LINK_ACTIVE", ("GEAR LINK",), ())
    return 0.0
