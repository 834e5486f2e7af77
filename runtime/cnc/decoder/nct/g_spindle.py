"""Codes of the spindle: constant surface speed (manual lines 2542–2624)."""

from __future__ import annotations

from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import GCall, Group, g_code
from runtime.cnc.decoder.nct.surface_speed import AXES
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue


@g_code(
    "96", Group.SURFACE_SPEED, "nct.spindle.css-g96-g97", "nct.spindle.css-clamp-axis",
    meaning="constant surface speed: S in m/min or ft/min, P the axis (1 X … 9 C)", takes="P",
)  # fmt: skip
def surface_speed(x: NctExecution, call: GCall) -> None:
    number = x.words.number("P")
    if number is not None:
        if number not in range(1, len(AXES) + 1):
            raise LineError(catalogue.FAULTY_P, x.words.place("P"))
        x.surface.settings.axis = AXES[int(number) - 1]
    x.surface.begin(x, call.column)
    x.modal_changed()


@g_code("97", Group.SURFACE_SPEED, "nct.spindle.css-g96-g97", meaning="constant surface speed off: S in rev/min")
def speed(x: NctExecution, call: GCall) -> None:
    if not call.modal:
        x.surface.end(x)
    x.modal_changed()
