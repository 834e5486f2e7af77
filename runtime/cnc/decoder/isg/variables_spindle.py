"""V.SPDL, V.SPDL_PROG: configuration of the spindles and what was programmed (programming manual 21767–21802)."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable
from runtime.cnc.decoder.isg.variables_flags import require_absent
from runtime.cnc.language.errors import CalculationError
from runtime.diagnostics.catalogue import language as catalogue

_SPEC = "isg.var.spindle-data"


def _require_main(spindle: int, name: str) -> None:
    """Only the main spindle can be programmed by now."""
    if spindle:
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, name, purpose="spindles beside the main spindle")


@variable("V.SPDL.LOG_AX_NR.<spindle>", _SPEC, "logical axis number of a spindle")
def logical_number(x: Execution, spindle: int) -> float:
    if spindle >= len(x.setup.log_spindles):
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, "V.SPDL.LOG_AX_NR", purpose="no machine description")
    return float(x.setup.log_spindles[spindle])


@variable("V.SPDL.PLC_CONTROL.<spindle>", _SPEC, "0: the control moves the spindle itself")
def moved_by_plc(x: Execution, spindle: int) -> float:
    return 0.0


@variable("V.SPDL.NBR_IN_CHANNEL", _SPEC, "spindles of the channel")
def count(x: Execution) -> float:
    return float(len(x.setup.spindles))


@variable("V.SPDL.M_FCT_FREE", _SPEC, "0: M3, M4, M5, M19 belong to the spindle")
def free_functions(x: Execution) -> float:
    return 0.0


@variable("V.SPDL_PROG.SPEED.<spindle>", _SPEC, "last S word", unit="rev/min")
def speed(x: Execution, spindle: int) -> float:
    _require_main(spindle, "V.SPDL_PROG.SPEED")
    return x.modal.speed


@variable("V.SPDL_PROG.MOVE_CMD.<spindle>", _SPEC, "3, 4 or 5: last of M3, M4, M5 in this program, 5 before")
def command(x: Execution, spindle: int) -> float:
    _require_main(spindle, "V.SPDL_PROG.MOVE_CMD")
    return float(x.spindle_command)


@variable("V.SPDL_PROG.DWELL_ROT_COUNT.<spindle>", _SPEC, "revolutions of the last G04 S", unit="rev")
def dwell_revolutions(x: Execution, spindle: int) -> float:
    _require_main(spindle, "V.SPDL_PROG.DWELL_ROT_COUNT")
    return x.dwell_revolutions


@variable("V.SPDL_PROG.GEAR_LINK_ACTIVE.<spindle>", _SPEC, "0: this control does not have the function", flush=True)
def gear_link(x: Execution, spindle: int) -> float:
    require_absent("V.SPDL_PROG.GEAR_LINK_ACTIVE", ("GEAR LINK",), ())
    return 0.0
