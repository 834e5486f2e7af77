"""G functions of the programming system: plane, unit, dimension."""

from __future__ import annotations

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, GHandler, g_function
from runtime.cnc.decoder.modal import Plane
from runtime.cnc.language.isg.syntax import Group


def _plane(number: int, plane: Plane) -> GHandler:
    @g_function(number, Group.PLANE, "isg.g.plane-g17-g18-g19")
    def select(x: Execution, call: GCall) -> None:
        x.modal.plane = plane

    return select


plane_xy, plane_zx, plane_yz = _plane(17, Plane.XY), _plane(18, Plane.ZX), _plane(19, Plane.YZ)


@g_function(70, Group.UNIT, "isg.g.units-g70-g71")
def inch(x: Execution, call: GCall) -> None:
    x.modal.inch = True


@g_function(71, Group.UNIT, "isg.g.units-g70-g71")
def metric(x: Execution, call: GCall) -> None:
    x.modal.inch = False


@g_function(90, Group.DIMENSION, "isg.g.dimension-g90-g91")
def absolute(x: Execution, call: GCall) -> None:
    x.modal.incremental = False


@g_function(91, Group.DIMENSION, "isg.g.dimension-g90-g91")
def incremental(x: Execution, call: GCall) -> None:
    x.modal.incremental = True
