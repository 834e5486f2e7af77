"""Where the decoder counts from after axes were moved without it: by hand, by homing.

The block is executed twice: first it hands over what the axes do, then, when the cycle has come there and told where they stand,
it begins anew at that place.
"""

from __future__ import annotations

from runtime.cnc.blocks import Homing, ManualMotion, PathRestart, PositionSetting, TakeOver
from runtime.cnc.decoder.couplings import expect_uncoupled
from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.independent import wait_for


class _AtPlace:
    """What the block keeps that waits for the place."""

    __slots__ = ()


def waits_for_place(x: Execution, block: ManualMotion | Homing | TakeOver | PositionSetting, reason: str) -> bool:
    """Hand over `block` and wait until the cycle has told where the axes are; FALSE when they are known."""
    if isinstance(x.waiting, _AtPlace):
        x.waiting = None
        x.emit(PathRestart(x.source))
        return False
    expect_uncoupled(x, reason, 1)
    wait_for(x, tuple(x.independent.running))
    x.emit(block)
    x.repeat(reason)
    if x.again is None:
        return False
    x.waiting = _AtPlace()
    return True


def begin_where_axes_are(x: Execution, block: ManualMotion | Homing | TakeOver | PositionSetting, reason: str) -> None:
    """The axes are moved by something else; then the program goes on from where they stand."""
    if waits_for_place(x, block, reason):
        return
    position, offsets = x.outside.command_position(), x.outside.manual_offsets()
    if position is not None:
        x.coordinates.moved_to([float(p) for p in position])
    if offsets is not None and isinstance(block, ManualMotion):
        x.manual_offsets = [float(offset) for offset in offsets]
    x.path_start = None
    x.modal_changed()
