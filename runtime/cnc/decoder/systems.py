"""The chain of coordinate systems changes: offsets change hands, the place stays, the stage of rotated frames is told."""

from __future__ import annotations

from typing import TYPE_CHECKING

from runtime.cnc.blocks import FrameChange
from runtime.cnc.decoder import additions
from runtime.cnc.decoder.coordinates import MAIN
from runtime.cnc.decoder.independent import wait_for
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.decoder.system_state import LINKED, MachineMode, System
from runtime.cnc.geometry.frames import Frame
from runtime.cnc.language.isg.comments import LineError
from runtime.diagnostics.catalogue import coordinates as errors

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

# ---------------------------------------------------------------------------------------------------- offsets change hands


def _keep(x: Execution) -> None:
    """The layer whose offsets are programmed gets them back."""
    top, offsets = x.systems.top, x.coordinates.offsets
    top.zero, top.reference, top.preset = list(offsets.zero), list(offsets.reference), list(offsets.preset)
    top.index = x.modal.zero_offset


def _bring(x: Execution) -> None:
    """The chain, or a layer, is another one: its last system gives its offsets, and the position is told anew."""
    top, c = x.systems.top, x.coordinates
    c.offsets.zero, c.offsets.reference, c.offsets.preset = list(top.zero), list(top.reference), list(top.preset)
    x.modal.zero_offset, x.modal.layer = top.index, top.number
    before, path = c.frame, None if x.path_start is None else c.machine(x.path_start)
    c.enter(*x.systems.placement(c.mirror_axis))
    if path is not None:
        x.path_start = c.of_machine(path)
    if c.frame is not None or before is not None:
        x.emit(FrameChange(x.source, c.frame))


class Changing:
    """`with Changing(x, ...)`: the chain changes in it. Raises LineError where it must not.

    A contour line that waits would get its target in another system; own motions of main axes are waited for, because the
    position counts them at their targets.
    """

    def __init__(self, x: Execution) -> None:
        self._x = x

    def __enter__(self) -> None:
        additions.expect_no_line(self._x)
        wait_for(self._x, range(min(MAIN, len(self._x.setup.axes))))
        _keep(self._x)

    def __exit__(self, kind: object, error: object, trace: object) -> None:
        _bring(self._x)


# ---------------------------------------------------------------------------------------------------- what is asked for


def expect_main_axes(x: Execution, statement: str, column: int) -> None:
    """LineError for a channel without three linear main axes."""
    if len(x.setup.axes) < MAIN or not all(x.setup.linear[:MAIN]):
        raise LineError(errors.SYSTEM_AXES, column, statement=statement, axes=", ".join(x.setup.axes))


def expect_no_machine_mode(x: Execution, statement: str, column: int) -> None:
    """LineError between #MCS ON and #MCS OFF."""
    if x.systems.mcs is not None:
        raise LineError(errors.IN_MACHINE, column, statement=statement)


def expect_unrotated(x: Execution, axis: int, what: str, column: int) -> None:
    """LineError for a main axis while a rotated system is active."""
    if x.coordinates.frame is not None and axis < MAIN:
        raise LineError(errors.ROTATED, column, what=what, axis=x.setup.axes[axis])


def new_system(x: Execution, name: str, placement: Frame, *, passing: bool = False) -> System:
    """A system that is about to join the chain; its offsets are zero, those of axes that do not add up are those below."""
    specific = x.systems.specific
    layer = x.systems.new_layer(len(x.setup.axes))
    if not specific:
        offsets = x.coordinates.offsets
        for values, below in (
            (layer.zero, offsets.zero),
            (layer.reference, offsets.reference),
            (layer.preset, offsets.preset),
        ):
            values[MAIN:] = below[MAIN:]
    return System(name, placement, layer, passing, specific)


def check_link(x: Execution, placement: Frame, statement: str, column: int) -> None:
    """LineError if one more system cannot join the chain."""
    if len(x.systems.chain) >= LINKED:
        raise LineError(errors.LINKED_FULL, column, statement=statement, limit=LINKED)
    if placement.only_shifted:
        return
    for coupled in x.coupling.slaves.values():
        if coupled.master < MAIN:
            raise LineError(errors.COUPLED, column, statement=statement, axis=x.setup.axes[coupled.master])


# ---------------------------------------------------------------------------------------------------- the machine itself


def leave_systems(x: Execution, *, without_tool: bool) -> None:
    """#MCS ON: no system, no offset, no contour rotation and no scale; a tool counts again from the next D word on, or
    (`without_tool`) not before #MCS OFF."""
    c, systems = x.coordinates, x.systems
    with Changing(x):
        systems.mcs = MachineMode(
            systems.new_layer(len(x.setup.axes)),
            list(c.offsets.clamp),
            list(c.offsets.measuring),
            c.rotation,
            c.scale_active,
        )
        c.offsets.clamp, c.offsets.measuring = [0.0] * len(c.position), [0.0] * len(c.position)
        c.rotation, c.scale_active = None, False
        x.tools.leave_out(until_next=not without_tool)
    x.modal_changed()


def return_to_systems(x: Execution) -> bool:
    """#MCS OFF: everything as it was before; whether the contour rotation could be restored."""
    c, systems = x.coordinates, x.systems
    mode = systems.mcs
    assert mode is not None
    with Changing(x):
        systems.mcs = None
        c.offsets.clamp, c.offsets.measuring = mode.clamp, mode.measuring
        restored = mode.rotation is None or mode.rotation.plane == PLANE_AXES[x.modal.plane]
        c.rotation, c.scale_active = mode.rotation if restored else None, mode.scaled
        x.tools.take_in()
    x.modal_changed()
    return restored
