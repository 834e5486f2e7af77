"""V.G.…_ACTIVE: which functions are active (programming manual 21325–21447).

A function that this control does not have cannot be active: its flag is 0. As soon as a statement or G function that switches it
on is registered, the flag is refused instead, until it is made to tell the truth.
"""

from __future__ import annotations

from runtime.cnc.decoder.couplings import GROUPS
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, variable
from runtime.cnc.decoder.isg.variables_channel import index_between
from runtime.cnc.language.errors import CalculationError
from runtime.diagnostics.catalogue import language as catalogue

_SPEC = "isg.var.g-active-flags"


@variable("V.G.MIRROR_ACTIVE", _SPEC, "1 while an axis is mirrored (G21…G23, G351)")
def mirrored(x: Execution) -> float:
    c = x.coordinates
    return float(any(sign < 0 for sign in (*c.mirror_plane, *c.mirror_axis)))


@variable("V.G.CIRCLE_CP_ABS", _SPEC, "1 with G161, 0 with G162")
def centre_absolute(x: Execution) -> float:
    return float(x.modal.centre_absolute)


@variable("V.G.CIRCLE_CPC_ACTIVE", _SPEC, "1 with G165, 0 with G164")
def centre_corrected(x: Execution) -> float:
    return float(x.modal.centre_correction)


@variable("V.G.TRC_ACTIVE", _SPEC, "1 between G41 or G42 and G40")
def radius_compensated(x: Execution) -> float:
    return float(x.modal.compensation_side != 0)


@variable("V.G.MCS_ACTIVE", _SPEC, "1 between #MCS ON and #MCS OFF")
def machine_coordinates(x: Execution) -> float:
    return float(x.systems.mcs is not None)


@variable("V.G.DIAMETER_PROG_ACTIVE", _SPEC, "1 between G51 and G52")
def diameters(x: Execution) -> float:
    return float(x.modal.diameter)


@variable(
    "V.G.DIAMETER_PROG.ZERO_OFFSET", _SPEC, "1 with G51 where offsets of the facing axis are diameters (P-CHAN-00091)"
)
def diameter_offsets(x: Execution) -> float:
    facing = any(described is not None and described.facing for described in x.setup.turning)
    return float(x.modal.diameter and facing and x.setup.offset_diameters)


# Flag → what would switch the function on: beginnings of statements, G numbers.
ABSENT: dict[str, tuple[tuple[str, ...], tuple[int, ...]]] = {
    "TRAFO_ACTIVE": (("TRAFO",), ()),
    "OTC_ACTIVE": (("OTC",), ()),
    "CAXTRACK_ACTIVE": (("CAXTRACK",), ()),
    "STROKE_DEF_ACTIVE": (("STROKE DEF",), ()),
    "PUNCH_ACTIVE": (("PUNCH",), ()),
    "NIBBLE_ACTIVE": (("NIBBLE",), ()),
    "EDM_ACTIVE": (("EDM",), ()),
    "FRICTION_ACTIVE": (("FRICTION",), ()),
    "VECTOR_OFFSET_ACTIVE": (("VECTOR OFFSET",), ()),
    "GEAR_LINK_ACTIVE": (("GEAR LINK",), ()),
    "SINGUL_AVOID_ACTIVE": (("SINGULARITY",), ()),
}
_COUPLING_SPEC = "isg.var.g-link-rotation"


def require_absent(name: str, statements: tuple[str, ...], g: tuple[int, ...]) -> None:
    """CalculationError if the dialect has what switches a function on."""
    if any(number in G_FUNCTIONS for number in g) or any(
        f"{key} ".startswith(f"{beginning} ") for beginning in statements for key in STATEMENTS
    ):
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, name, purpose="state of a function")


def _absent(name: str, statements: tuple[str, ...], g: tuple[int, ...]) -> None:
    @variable(f"V.G.{name}", _SPEC, "0: this control does not have the function")
    def read(x: Execution) -> float:
        require_absent(f"V.G.{name}", statements, g)
        return 0.0


for _name, (_statements, _g) in ABSENT.items():
    _absent(_name, _statements, _g)


@variable("V.G.LIFT_ACTIVE", _SPEC, "0: no word lifts or lowers an axis")
def lifting(x: Execution) -> float:
    """X[LIFT ..] belongs to the axis word; the parser refuses it."""
    return 0.0


@variable("V.G.BLOCK_SEARCH_ACTIVE", _SPEC, "1 while a block search leaves out what comes before its place")
def searching(x: Execution) -> float:
    return float(x.outside.searching())


@variable("V.G.TOOL_COMP", "isg.var.g-channel-state", "type of the active tool compensation: 0 none, 3 in the plane")
def tool_compensation(x: Execution) -> float:
    require_absent("V.G.TOOL_COMP", ("RTCP", "TLC", "TRAFO"), ())
    return 3.0 if x.modal.compensation_side else 0.0


# ---------------------------------------------------------------------------------------------------- axis couplings


@variable("V.G.AX_LINK_GROUP[].ACTIVE", _COUPLING_SPEC, "1 while this group (0…4) of axis couplings is active")
def group_coupled(x: Execution, group: float) -> float:
    return float(index_between(group, 0, GROUPS - 1, "V.G.AX_LINK_GROUP") in x.coupling.active)
