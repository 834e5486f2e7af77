"""V.A.: data of the axes (programming manual 21624–21733). Axes by name or by index: V.A.ABS.X, V.A.ABS[0]."""

from __future__ import annotations

import math

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import Reader, variable
from runtime.cnc.decoder.isg.variables_flags import require_absent
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

_COORDINATES = "isg.var.a-coordinates"
_LIMITS = "isg.var.a-limits-offsets"
_STATUS = "isg.var.a-axis-status"
_MODULO_VARIABLES = "isg.modulo.variables"
_COMPENSATIONS = "isg.var.a-compensations"
_LENGTH = "mm, inch, deg"
_LINEAR, _MODULO, _FACING, _LONGITUDINAL = 0x1, 0x4, 0x40, 0x80  # axis modes (P-AXIS-00015)


# ---------------------------------------------------------------------------------------------------- coordinates


@variable(
    "V.A.ABS.<axis>",
    _COORDINATES,
    "coordinate of the block before with all offsets, in the active system",
    unit=_LENGTH,
)
def absolute(x: Execution, axis: int) -> float:
    return x.shown(axis, x.place_in_system(axis))


@variable("V.A.ACS.ABS.<axis>", _COORDINATES, "the same, mapped onto the machine axis", unit=_LENGTH)
def absolute_of_axis(x: Execution, axis: int) -> float:
    return x.shown(axis, x.place_of(axis))


@variable("V.A.PROG.<axis>", _COORDINATES, "programmed coordinate of the block before", unit=_LENGTH)
def programmed(x: Execution, axis: int) -> float:
    return x.shown(axis, x.modulo.shown(axis, x.coordinates.programmed()[axis]))


@variable("V.A.MENT.<axis>", _COORDINATES, "coordinate of the block before as if nothing were mirrored", unit=_LENGTH)
def virtual(x: Execution, axis: int) -> float:
    return x.shown(axis, x.modulo.shown(axis, x.coordinates.programmed()[axis]))


# ---------------------------------------------------------------------------------------------------- limits and offsets


def _limit(name: str, side: int, configured: bool, meaning: str) -> Reader:
    @variable(f"V.A.{name}.<axis>", _LIMITS, meaning, unit=_LENGTH)
    def limit(x: Execution, axis: int) -> float:
        value = (x.configured_limits if configured else x.soft_limits)[axis][side]
        if not math.isfinite(value):
            raise CalculationError(catalogue.LIMIT_MISSING, f"V.A.{name}", axis=x.setup.axes[axis])
        return x.shown(axis, value)

    return limit


_limit("-SWE", 0, False, "software limit in the negative direction, as G98 has set it")
_limit("+SWE", 1, False, "software limit in the positive direction, as G99 has set it")
_limit("-SWE_MDS", 0, True, "configured software limit in the negative direction")
_limit("+SWE_MDS", 1, True, "configured software limit in the positive direction")


@variable("V.A.REF.<axis>", _LIMITS, "machine reference point, where homing finds it", unit=_LENGTH)
def reference_point(x: Execution, axis: int) -> float:
    places = x.setup.reference_points
    return x.shown(axis, places[axis]) if places else 0.0


@variable("V.A.BZP.<axis>", _LIMITS, "reference point offset (G92)", unit=_LENGTH)
def reference_offset(x: Execution, axis: int) -> float:
    return x.shown(axis, x.coordinates.offsets.reference[axis])


@variable("V.A.PZV.<axis>", _LIMITS, "clamp position offset", unit=_LENGTH)
def clamp_offset(x: Execution, axis: int) -> float:
    return x.shown(axis, x.coordinates.offsets.clamp[axis])


# ---------------------------------------------------------------------------------------------------- status


@variable("V.A.LOG_AX_NR.<axis>", _STATUS, "logical axis number")
def logical_number(x: Execution, axis: int) -> float:
    if axis >= len(x.setup.log_axes):
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, "V.A.LOG_AX_NR", purpose="no machine description")
    return float(x.setup.log_axes[axis])


@variable("V.A.AX_LIST_NAME.<axis>", _STATUS, "configured name", kind=ValueKind.STRING)
def list_name(x: Execution, axis: int) -> str:
    return x.setup.axes[axis]


@variable("V.A.MIRROR.<axis>", _STATUS, "-1 while the axis is mirrored, else 1")
def mirror(x: Execution, axis: int) -> float:
    return x.coordinates.mirror_plane[axis] * x.coordinates.mirror_axis[axis]


@variable("V.A.RERF.<axis>", _STATUS, "1: the axis has its reference", flush=True)
def referenced(x: Execution, axis: int) -> float:
    return float(x.outside.referenced(axis))


@variable(
    "V.A.MODE.<axis>", _MODULO_VARIABLES, "axis mode: 1 linear (+64 facing, +128 longitudinal), 4 turns without end"
)
def mode(x: Execution, axis: int) -> float:
    if x.setup.linear[axis]:
        described = x.setup.turning[axis] if x.setup.turning else None
        kind = 0 if described is None else _FACING if described.facing else _LONGITUDINAL
        return float(_LINEAR | kind)
    if axis not in x.modulo.configured:
        purpose = "the mode of a rotary axis with limits"
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, "V.A.MODE", purpose=purpose)
    return float(_MODULO)


@variable("V.A.MODULO_VALUE.<axis>", _MODULO_VARIABLES, "modulo range, 0 for an axis that has none", unit="deg")
def modulo_range(x: Execution, axis: int) -> float:
    return x.modulo.size(axis)


@variable("V.A.AXIS_DEACTIVATED.<axis>", _STATUS, "1: the axis is parked", flush=True)
def parked(x: Execution, axis: int) -> float:
    return float(x.outside.parked(axis))


@variable("V.A.DIAMETER_PROG.ABS.<axis>", _STATUS, "1: with G51 and G90 values of the axis are diameters now")
def diameter_absolute(x: Execution, axis: int) -> float:
    described = x.setup.turning[axis] if x.modal.diameter and x.setup.turning else None
    return float(described is not None and described.facing and described.diameter_absolute)


@variable("V.A.DIAMETER_PROG.REL.<axis>", _STATUS, "1: with G51 and G91 values of the axis are diameters now")
def diameter_incremental(x: Execution, axis: int) -> float:
    described = x.setup.turning[axis] if x.modal.diameter and x.setup.turning else None
    return float(described is not None and described.facing and described.diameter_incremental)


@variable("V.A.GEAR_LINK_ACTIVE.<axis>", _STATUS, "0: this control does not have the function", flush=True)
def gear_link(x: Execution, axis: int) -> float:
    require_absent("V.A.GEAR_LINK_ACTIVE", ("GEAR LINK",), ())
    return 0.0


# ---------------------------------------------------------------------------------------------------- compensations


def _compensation(name: str) -> None:
    """Axes have no compensations here: none is set up or active, and the values are 0."""

    @variable(f"V.A.{name}.<axis>", _COMPENSATIONS, "0: axes have no compensations", flush=True)
    def read(x: Execution, axis: int) -> float:
        return 0.0


for _kind in ("CROSS", "PLANE", "LEAD", "TEMP", "FRICT", "CROSSTALK"):
    for _item in ("INIT", "ACTIVE", "CURR"):
        _compensation(f"{_kind}_COMP_{_item}")
_compensation("BACKLASH_COMP_ACTIVE")
_compensation("BACKLASH_COMP_CURR")
