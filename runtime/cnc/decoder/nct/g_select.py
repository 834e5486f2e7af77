"""What other words mean: plane, unit, absolute or incremental, feed (manual lines 1520–1631, 1858–1982, 2479–2526)."""

from __future__ import annotations

from runtime.cnc.decoder.modal import FeedMode, Plane
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import GCall, Group, g_code
from runtime.cnc.decoder.selection import plane_changed
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct as catalogue
from runtime.diagnostics.catalogue.nct_offsets import PLANE_TURNED


def _plane(x: NctExecution, call: GCall, plane: Plane) -> None:
    if x.modal.plane is plane:
        return
    if x.modal.compensation_side:
        raise LineError(catalogue.PLANE_COMPENSATED, call.column)
    if x.coordinates.rotation is not None:
        raise LineError(PLANE_TURNED, call.column)
    x.modal.plane = plane
    x.polar_angle = None
    plane_changed(x, call.column)


@g_code("17", Group.PLANE, "nct.coord.plane-g17-g18-g19", meaning="plane X Y")
def plane_xy(x: NctExecution, call: GCall) -> None:
    _plane(x, call, Plane.XY)


@g_code("18", Group.PLANE, "nct.coord.plane-g17-g18-g19", meaning="plane Z X")
def plane_zx(x: NctExecution, call: GCall) -> None:
    _plane(x, call, Plane.ZX)


@g_code("19", Group.PLANE, "nct.coord.plane-g17-g18-g19", meaning="plane Y Z")
def plane_yz(x: NctExecution, call: GCall) -> None:
    _plane(x, call, Plane.YZ)


@g_code("15", Group.POLAR, "nct.coord.polar-data-g15-g16", meaning="Cartesian coordinates")
def cartesian(x: NctExecution, call: GCall) -> None:
    x.polar_angle = None


@g_code(
    "16",
    Group.POLAR,
    "nct.coord.polar-data-g15-g16",
    meaning="polar coordinates: radius and angle at the axes of the plane",
)
def polar(x: NctExecution, call: GCall) -> None:
    x.polar_angle = None


@g_code("20", Group.UNIT, "nct.config.inch-metric-g20-g21", meaning="inch")
def inch(x: NctExecution, call: GCall) -> None:
    _unit(x, call, True)


@g_code("21", Group.UNIT, "nct.config.inch-metric-g20-g21", meaning="millimetres")
def metric(x: NctExecution, call: GCall) -> None:
    _unit(x, call, False)


@g_code("90", Group.DIMENSION, "nct.coord.absolute-incremental-g90-g91", meaning="absolute coordinates")
def absolute(x: NctExecution, call: GCall) -> None:
    x.modal.incremental = False


@g_code("91", Group.DIMENSION, "nct.coord.absolute-incremental-g90-g91", meaning="incremental coordinates")
def incremental(x: NctExecution, call: GCall) -> None:
    x.modal.incremental = True


@g_code("94", Group.FEED_MODE, "nct.feed.cutting-g94-g95", meaning="feed per minute")
def per_minute(x: NctExecution, call: GCall) -> None:
    _feed_mode(x, FeedMode.PER_MINUTE)


@g_code("95", Group.FEED_MODE, "nct.feed.cutting-g94-g95", meaning="feed per revolution of the spindle")
def per_revolution(x: NctExecution, call: GCall) -> None:
    _feed_mode(x, FeedMode.PER_REVOLUTION)


def _unit(x: NctExecution, call: GCall, inch: bool) -> None:
    """A programmed unit holds for the programs behind too (line 1624)."""
    x.modal.inch = inch
    if not call.modal:
        x.memory.select_input(inch)


def _feed_mode(x: NctExecution, mode: FeedMode) -> None:
    x.modal.feed_mode = mode
    x.modal_changed()
