"""Records of what axes do beside the path: moved by hand, homed, and the limits that are left to the path meanwhile."""

from __future__ import annotations

from dataclasses import fields

import numpy as np

from runtime.cnc.blocks import (
    MANUAL_SHARE,
    Block,
    CoupledAxis,
    CouplingChange,
    Homing,
    IndependentMotion,
    IndependentWait,
    ManualKind,
    ManualMotion,
    ManualParameter,
    ManualValue,
    PositionSetting,
    TakeOver,
)
from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.motion_queue import ActionKind, GateReason, RecordKind, Records

RANK_BITS = 4  # of an axis in the record of G74
_VALUES = tuple(ManualValue)


def independent(record: Records, block: IndependentMotion | IndependentWait) -> None:
    """Fill the record of the gate."""
    record["kind"] = RecordKind.GATE
    if isinstance(block, IndependentWait):
        record["reason"], record["offset"] = GateReason.INDEPENDENT_WAIT, block.exact
        record["number"] = sum(1 << axis for axis in block.axes)
        return
    record["reason"], record["number"], record["value"] = GateReason.INDEPENDENT, block.axis, block.target
    record["feed"], record["lead"], record["seconds"] = block.velocity, block.acceleration, block.jerk


def beside_path(record: Records, block: ManualMotion | ManualParameter | Homing | TakeOver | PositionSetting) -> bool:
    """Fill the record of the block; whether the decoder waits until the path has come there and everything is done."""
    record["kind"] = RecordKind.GATE
    match block:
        case ManualMotion(kind=ManualKind.PARALLEL):
            record["kind"], record["action"] = RecordKind.ACTION, ActionKind.MANUAL_ON
            record["number"] = sum(1 << axis for axis in block.axes)
        case ManualMotion():
            exclusive = block.kind is ManualKind.EXCLUSIVE
            record["reason"] = GateReason.MANUAL if exclusive else GateReason.MANUAL_END
            record["number"] = sum(1 << axis for axis in block.axes)
            return exclusive
        case ManualParameter():
            record["kind"], record["action"] = RecordKind.ACTION, ActionKind.MANUAL_PARAMETER
            record["number"], record["offset"], record["size"] = block.axis, _VALUES.index(block.what), block.stage
            record["value"], record["seconds"] = block.first, block.second
        case Homing():
            record["reason"] = GateReason.HOMING
            record["number"] = sum(rank << RANK_BITS * axis for axis, rank in enumerate(block.ranks))
            return True
        case PositionSetting():
            record["reason"] = GateReason.SET_POSITION
            record["number"], record["value"], record["offset"] = block.axis, block.value, block.relative
            return True
        case TakeOver():
            record["reason"] = GateReason.TAKE_OVER
            return True
    return False


def coupling(record: Records, block: CouplingChange) -> None:
    """Fill the record of the gate: `start` of a slave its master + 1, `end` how far it is ahead."""
    record["kind"], record["reason"] = RecordKind.GATE, GateReason.COUPLING
    for one in block.coupled:
        record["start"][0, one.slave], record["end"][0, one.slave] = one.master + 1, one.offset


class PathShare:
    """What is left to the path: an axis that the hand may move too keeps its share free for it, one that others follow does no
    more than these can."""

    def __init__(self, limits: AxisLimits) -> None:
        self._whole = limits
        self._share = np.ones(limits.n)
        self._coupled: tuple[CoupledAxis, ...] = ()

    def of(self, limits: AxisLimits) -> AxisLimits:
        """The limits of the axes are others now; those of the path."""
        self._whole = limits
        return self.now

    def changed_by(self, block: Block) -> bool:
        """Whether another share is left from this block on."""
        if not isinstance(block, ManualMotion) or block.kind is ManualKind.EXCLUSIVE:
            return False
        self._share[list(block.axes)] = 1.0 - MANUAL_SHARE if block.kind is ManualKind.PARALLEL else 1.0
        return True

    def couple(self, coupled: tuple[CoupledAxis, ...]) -> AxisLimits:
        """Other axes follow others from here on; the limits of the path."""
        self._coupled = coupled
        return self.now

    def _followed(self) -> AxisLimits:
        """The limits where a master does no more than its slaves can."""
        if not self._coupled:
            return self._whole
        values = {f.name: getattr(self._whole, f.name).copy() for f in fields(AxisLimits)}
        for one in self._coupled:
            for value in values.values():
                value[one.master] = min(value[one.master], value[one.slave])
        return AxisLimits(**values)

    @property
    def now(self) -> AxisLimits:
        """The limits of the path."""
        whole, share = self._followed(), self._share
        if np.all(share == 1.0):
            return whole
        return AxisLimits(
            whole.velocity * share,
            whole.acceleration * share,
            whole.jerk * share,
            whole.velocity_step * share,
            whole.deceleration * share,
            whole.braking_jerk * share,
        )
