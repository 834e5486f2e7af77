"""What modal functions select in the coordinates: zero offset, mirroring, rotation; and all of it again at the end of a cycle."""

from __future__ import annotations

from runtime.cnc.decoder.coordinates import Rotation
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.modal import ModalState
from runtime.cnc.decoder.smoothing import select_contouring
from runtime.cnc.decoder.turning import offset_of
from runtime.diagnostics.catalogue import language as catalogue

# Signs of the first two main axes by G number; values of the third are never mirrored, in no plane (line 4139).
MIRRORS = {20: (1.0, 1.0), 21: (-1.0, 1.0), 22: (1.0, -1.0), 23: (-1.0, -1.0)}


def select_zero_offset(x: Execution, index: int) -> None:
    """Make a stored data set the active one; it acts with the next absolute word of each axis."""
    x.modal.zero_offset = index
    stored, enabled = x.memory.zero_offsets[index], x.memory.zero_enabled[index]
    x.coordinates.offsets.zero = [offset_of(x, k, float(v)) for k, v in enumerate(stored * enabled)]
    x.coordinates.update()


def select_mirror(x: Execution, number: int) -> None:
    """Mirroring in the plane by G20…G23; it acts with the next word of each axis."""
    x.modal.mirror = number
    signs = x.coordinates.mirror_plane
    signs[:2] = MIRRORS[number][: len(signs)]
    x.coordinates.update()


def switch_rotation(x: Execution, rotation: Rotation | None) -> None:
    """Rotation of the contour on or off; it moves nothing."""
    x.coordinates.rotation = rotation
    x.modal_changed()


def plane_changed(x: Execution, column: int) -> None:
    """A rotation does not outlive its plane; the tool length goes over to the third axis of the new one."""
    x.tools.assigned()
    if x.coordinates.rotation is not None:
        x.warn(catalogue.ROTATION_ENDED, column, number=int(x.modal.plane))
        switch_rotation(x, None)


def restore_modal(x: Execution, saved: ModalState) -> None:
    """The modal state as it was before a cycle (lines 7389–7392), with what it selects.

    What was programmed with axis names (G92, G98, G99, G351, G68) or as a statement stays as the cycle has left it.
    """
    left, x.modal = x.modal, saved
    if left.layer != saved.layer:  # the cycle has left another coordinate system active, which has its own zero offset
        saved.layer, saved.zero_offset = left.layer, left.zero_offset
    if left.zero_offset != saved.zero_offset:
        select_zero_offset(x, saved.zero_offset)
    if left.mirror != saved.mirror:
        select_mirror(x, saved.mirror)
    if left.contouring != saved.contouring:
        select_contouring(x, saved.contouring)
    if left.plane is not saved.plane:
        plane_changed(x, 1)
    x.compensation.follow(x)
    x.modal_changed()
