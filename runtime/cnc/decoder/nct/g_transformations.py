"""Rotation G68, G69, scaling G51, G50, programmable mirror image G51.1, G50.1 (manual lines 4306–4503).

Switching on moves nothing and leaves the numbers of the last point as they are; switching off counts the position anew.
"""

from __future__ import annotations

from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.decoder.nct.execution import NctExecution
from runtime.cnc.decoder.nct.registry import GCall, Group, Stage, g_code
from runtime.cnc.decoder.nct.transformations import Scaled, Turned
from runtime.cnc.language.errors import LineError
from runtime.diagnostics.catalogue import nct
from runtime.diagnostics.catalogue import nct_offsets as catalogue


def _switched(x: NctExecution, *, on: bool) -> None:
    x.coordinates.update()
    if on:
        x.coordinates.keep_numbers()
    else:
        x.coordinates.recount()
    x.modal_changed()


def _expect_nested(x: NctExecution, call: GCall, kind: type[Turned | Scaled]) -> None:
    if not x.coordinates.transformations.is_last(kind):
        other = "G50" if kind is Turned else "G69"
        raise LineError(catalogue.NOT_NESTED, call.column, name=call.name, other=other)


@g_code(
    "68", Group.ROTATION, "nct.trafo.rotation-g68-g69", "nct.trafo.nesting", meaning="rotation about a point of the plane by R",
    stage=Stage.SET, takes="R", axes=True,
)  # fmt: skip
def turn(x: NctExecution, call: GCall) -> None:
    """A coordinate of the centre that is not given is that of the position; an incremental angle is added to the last one."""
    c, plane = x.coordinates, PLANE_AXES[x.modal.plane]
    if max(plane) >= len(x.setup.axes):
        raise LineError(nct.AXIS_MISSING, call.column, address="XYZ"[max(plane)], axes=", ".join(x.setup.axes))
    angle = x.words.needed("R", catalogue.VALUE_MISSING, call.column, word="R", what="G68")
    words = c.absolute(x.axes(), x.incremental_words)
    for axis in words:
        if axis not in plane:
            name = x.setup.axes[axis]
            raise LineError(nct.WORD_WITHOUT_MEANING, x.words.place(name), address=name)
    before = c.transformations.turned
    if before is not None and (x.modal.incremental or x.words.incremental("R")):
        angle += before.angle
    first, second = (words.get(axis, c.numbers[axis]) for axis in plane)
    decimals = 5 if x.setup.nct.ang_accu else 3
    c.transformations.switch_on(Turned(plane, round(angle, decimals), (first, second)))
    _switched(x, on=True)


@g_code("69", Group.ROTATION, "nct.trafo.rotation-g68-g69", "nct.trafo.nesting", meaning="no rotation", stage=Stage.SET)
def turn_no_more(x: NctExecution, call: GCall) -> None:
    if x.coordinates.transformations.turned is None:
        return
    _expect_nested(x, call, Turned)
    x.coordinates.transformations.switch_off(Turned)
    _switched(x, on=False)


@g_code(
    "51", Group.SCALING, "nct.trafo.scaling-g50-g51", "nct.trafo.nesting", meaning="scaling about a point by the factor P",
    stage=Stage.SET, takes="P", axes=True,
)  # fmt: skip
def scale(x: NctExecution, call: GCall) -> None:
    """One factor for all linear axes; a coordinate of the centre that is not given is that of the position."""
    c = x.coordinates
    factor = x.words.needed("P", nct.FAULTY_P, call.column)
    if not factor > 0.0:
        raise LineError(nct.FAULTY_P, x.words.place("P"))
    words = c.absolute(x.axes(), x.incremental_words)
    for axis in words:
        if not x.setup.linear[axis]:
            name = x.setup.axes[axis]
            raise LineError(nct.WORD_WITHOUT_MEANING, x.words.place(name), address=name)
    centre = tuple(words.get(axis, number) for axis, number in enumerate(c.numbers))
    axes = tuple(axis for axis, linear in enumerate(x.setup.linear) if linear)
    c.transformations.switch_on(Scaled(factor, centre, axes))
    _switched(x, on=True)


@g_code("50", Group.SCALING, "nct.trafo.scaling-g50-g51", "nct.trafo.nesting", meaning="no scaling", stage=Stage.SET)
def scale_no_more(x: NctExecution, call: GCall) -> None:
    if x.coordinates.transformations.scaled is None:
        return
    _expect_nested(x, call, Scaled)
    x.coordinates.transformations.switch_off(Scaled)
    _switched(x, on=False)


def _expect_outside(x: NctExecution, call: GCall) -> None:
    if x.coordinates.transformations.nested:
        raise LineError(catalogue.MIRROR_INSIDE, call.column)
    if not x.axis_words:
        raise LineError(catalogue.AXIS_WANTED, call.column, what=call.name)


@g_code(
    "51.1", Group.MIRROR, "nct.trafo.mirror-g50-1-g51-1", "nct.trafo.nesting", meaning="axes are mirrored at their values",
    stage=Stage.SET, axes=True,
)  # fmt: skip
def mirror(x: NctExecution, call: GCall) -> None:
    """Axes that are not named stay as they are."""
    _expect_outside(x, call)
    c = x.coordinates
    c.transformations.mirrors |= c.absolute(x.axes(), x.incremental_words)
    _switched(x, on=True)


@g_code(
    "50.1", Group.MIRROR, "nct.trafo.mirror-g50-1-g51-1", "nct.trafo.nesting", meaning="the named axes are mirrored no more",
    stage=Stage.SET, axes=True,
)  # fmt: skip
def mirror_no_more(x: NctExecution, call: GCall) -> None:
    """The values of the words have no meaning."""
    if call.modal:
        return
    _expect_outside(x, call)
    named = x.axes()
    x.coordinates.transformations.mirrors = {
        axis: value for axis, value in x.coordinates.transformations.mirrors.items() if axis not in named
    }
    _switched(x, on=False)
