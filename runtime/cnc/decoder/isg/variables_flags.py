"""V.G.…_ACTIVE: which functions are active (programming manual 21325–21447).

A function that this version does not have cannot be active: its flag is 0. As soon as a statement or G function that switches it
on is registered, the flag is refused instead, until it is made to tell the truth.
"""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import G_FUNCTIONS, STATEMENTS, variable
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


# Flag → what would switch the function on: first words of statements, G numbers.
ABSENT: dict[str, tuple[tuple[str, ...], tuple[int, ...]]] = {
    "TRAFO_ACTIVE": (("TRAFO", "KIN"), ()),
    "MCS_ACTIVE": (("MCS",), ()),
    "HSC_ACTIVE": (("HSC", "SPLINE", "AKIMA"), (151,)),
    "HSC_SURFACE_ACTIVE": (("HSC",), ()),
    "CONT_MODE_ACTIVE": (("CONTOUR",), (61, 261)),
    "TRC_ACTIVE": ((), (41, 42)),
    "OTC_ACTIVE": (("OTC",), ()),
    "CAXTRACK_ACTIVE": (("CAXTRACK",), ()),
    "LIFT_ACTIVE": (("LIFT",), ()),
    "BLOCK_SEARCH_ACTIVE": (("BLOCK",), ()),
    "SEGMENTATION_ACTIVE": (("SEGMENTATION",), ()),
    "STROKE_DEF_ACTIVE": (("STROKE",), ()),
    "PUNCH_ACTIVE": (("PUNCH",), ()),
    "NIBBLE_ACTIVE": (("NIBBLE",), ()),
    "EDM_ACTIVE": (("EDM",), ()),
    "FRICTION_ACTIVE": (("FRICTION",), ()),
    "VECTOR_OFFSET_ACTIVE": (("VECTOR",), ()),
    "DIAMETER_PROG_ACTIVE": ((), (51,)),
    "GEAR_LINK_ACTIVE": (("GEAR",), ()),
    "SINGUL_AVOID_ACTIVE": (("SINGULARITY",), ()),
    "AX_LINK.ACTIVE": (("AX",), ()),
}


def require_absent(name: str, statements: tuple[str, ...], g: tuple[int, ...]) -> None:
    """CalculationError if the dialect has what switches a function on."""
    if any(number in G_FUNCTIONS for number in g) or any(key.split()[0] in statements for key in STATEMENTS):
        raise CalculationError(catalogue.VARIABLE_UNSUPPORTED, name, purpose="state of a function")


def _absent(name: str, statements: tuple[str, ...], g: tuple[int, ...]) -> None:
    @variable(f"V.G.{name}", _SPEC, "0: this control does not have the function")
    def read(x: Execution) -> float:
        require_absent(f"V.G.{name}", statements, g)
        return 0.0


@variable("V.G.TOOL_COMP", "isg.var.g-channel-state", "type of the active tool compensation: 0, there is none")
def tool_compensation(x: Execution) -> float:
    require_absent("V.G.TOOL_COMP", ("RTCP", "TLC", "TRAFO"), (41, 42))
    return 0.0


for _name, (_statements, _g) in ABSENT.items():
    _absent(_name, _statements, _g)
