"""The programming system: plane, unit, dimension, mirroring, rotation, scale."""

from __future__ import annotations

from runtime.cnc.decoder.coordinates import Rotation
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import GCall, GHandler, StatementCall, g_function, statement
from runtime.cnc.decoder.modal import Plane
from runtime.cnc.decoder.motion import PLANES
from runtime.cnc.decoder.radius_compensation import expect_none
from runtime.cnc.decoder.selection import MIRRORS, plane_changed, select_mirror, switch_rotation
from runtime.cnc.language.isg.comments import LineError
from runtime.cnc.language.isg.syntax import Form, Group, Key
from runtime.cnc.language.isg.words import WordKind
from runtime.diagnostics.catalogue import language as catalogue


def _plane(number: int, plane: Plane) -> GHandler:
    @g_function(number, Group.PLANE, "isg.g.plane-g17-g18-g19")
    def select(x: Execution, call: GCall) -> None:
        if x.modal.plane is not plane:
            expect_none(x, f"G{number}", call.column)
            x.modal.plane = plane
            plane_changed(x, call.column)

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


# ---------------------------------------------------------------------------------------------------- mirroring


def _mirror(number: int) -> None:
    @g_function(number, Group.MIRROR, "isg.g.mirror-plane-g20-g23")
    def select(x: Execution, call: GCall) -> None:
        select_mirror(x, number)


for _number in MIRRORS:
    _mirror(_number)


@g_function(
    351,
    Group.ARGUMENTS,
    "isg.g.mirror-axis-g351",
    modal=False,
    syntax="G351 <axis>-1 {<axis>1}",
    axis_arguments=True,
    alone=True,
)
def mirror_axes(x: Execution, call: GCall) -> None:
    """-1 mirrors an axis, 1 ends it; G92 of a mirrored axis is mirrored too."""
    for axis, value in x.raw_arguments(351, call.column).items():
        if value not in (1.0, -1.0):
            assert x.block is not None
            raise LineError(catalogue.MIRROR_VALUE, x.block.column(WordKind.AXIS, axis), value=value)
        x.coordinates.mirror_axis[axis] = value
    x.coordinates.update()


# ---------------------------------------------------------------------------------------------------- rotation


def _plane_axes(x: Execution, column: int) -> tuple[int, int]:
    plane = PLANES[x.modal.plane][0]
    if max(plane) >= len(x.setup.axes):
        raise LineError(
            catalogue.PLANE_UNAVAILABLE,
            column,
            plane=int(x.modal.plane),
            needed=max(plane) + 1,
            axes=len(x.setup.axes),
        )
    return plane


@g_function(68, Group.ROTATION, "isg.g.rotation-g68-g69", syntax="G68 R.. X.. Y..", axis_arguments=True)
def rotation_on(x: Execution, call: GCall) -> None:
    """The same as #ROTATION: the contour's zero comes to the centre. One that is not given is the present position."""
    assert x.block is not None
    plane = _plane_axes(x, call.column)
    words = {axis: x.axis_value(axis, value) for axis, value in x.axis_words.items()}
    if any(axis not in plane for axis in words):
        raise LineError(catalogue.ROTATION_AXES, x.block.column(WordKind.AXIS), axes=_names(x, plane))
    x.axes_taken = True
    angle = x.values[x.block.radius] if x.block.radius >= 0 else 0.0
    x.radius_taken = True
    first, second = (words[axis] if axis in words else x.coordinates.contour_place(axis) for axis in plane)
    rotation = x.last_rotation = Rotation(plane, angle, (first, second))
    switch_rotation(x, rotation)


@g_function(69, Group.ROTATION, "isg.g.rotation-g68-g69")
def rotation_off(x: Execution, call: GCall) -> None:
    switch_rotation(x, None)


def _names(x: Execution, plane: tuple[int, int]) -> str:
    return " and ".join(x.setup.axes[axis] for axis in plane)


@statement(
    "ROTATION ON",
    "isg.add.rotation",
    "isg.add.rotation-incremental",
    syntax="#ROTATION ON [ANGLE=.. CENTER1=.. CENTER2=..]",
    form=Form.KEYS,
    keys=(Key("ANGLE"), Key("CENTER1"), Key("CENTER2")),
    optional=True,
    modal=True,
)
def rotate(x: Execution, call: StatementCall) -> None:
    """What is not given keeps its last value."""
    last = x.last_rotation
    angle, centre = (last.angle, last.centre) if last else (0.0, (0.0, 0.0))
    plane = _plane_axes(x, call.column)
    angle = call.number("ANGLE", angle) or 0.0
    given = [call.number("CENTER1"), call.number("CENTER2")]
    values = [old if new is None else x.length(new) for old, new in zip(centre, given, strict=True)]
    rotation = x.last_rotation = Rotation(plane, angle, (values[0], values[1]))
    switch_rotation(x, rotation)


@statement("ROTATION OFF", "isg.add.rotation", modal=True)
def rotate_no_more(x: Execution, call: StatementCall) -> None:
    switch_rotation(x, None)


# ---------------------------------------------------------------------------------------------------- scale


def _factors(x: Execution, call: StatementCall) -> None:
    factors = call.axes()
    if factors and x.coordinates.scale_active:
        raise call.error(catalogue.SCALE_ACTIVE)
    for axis, factor in factors.items():
        if factor is None or not factor > 0:
            raise call.error(catalogue.SCALE_FACTOR, x.setup.axes[axis], value=factor or 0.0)
        if not x.setup.linear[axis]:
            raise call.error(catalogue.SCALE_AXIS, x.setup.axes[axis], axis=x.setup.axes[axis])
        x.coordinates.scale[axis] = factor


@statement("SCALE", "isg.add.scale", syntax="#SCALE <axis><factor> {<axis><factor>}", form=Form.AXES, modal=True)
def define_scale(x: Execution, call: StatementCall) -> None:
    _factors(x, call)


@statement(
    "SCALE ON",
    "isg.add.scale",
    "isg.add.scale-circles",
    syntax="#SCALE ON {<axis><factor>}",
    form=Form.AXES,
    optional=True,
    modal=True,
)
def scale(x: Execution, call: StatementCall) -> None:
    _factors(x, call)
    x.coordinates.scale_active = True
    x.coordinates.update()


@statement("SCALE OFF", "isg.add.scale", modal=True)
def scale_no_more(x: Execution, call: StatementCall) -> None:
    x.coordinates.scale_active = False
    x.coordinates.update()
