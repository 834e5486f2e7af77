"""What the decoder knows of cutter compensation: codes and D set the state, `follow` tells the stage behind it what has changed.

It takes the place of the other dialect's `Compensation`, whose strategies of approach and exit this one does not have.
"""

from __future__ import annotations

from typing import TYPE_CHECKING

from runtime.cnc.blocks import Block, VectorCompensation, VectorOrder, VectorSettings
from runtime.cnc.decoder.modal import PLANE_AXES
from runtime.cnc.decoder.radius_compensation import Compensation
from runtime.config.nct import NctParameters

if TYPE_CHECKING:
    from runtime.cnc.decoder.execution import Execution

Told = tuple[bool, float]  # active, offset


class VectorSelection(Compensation):
    """The compensation of one program run. `radius` is that of the last D word, mm."""

    def __init__(self, parameters: NctParameters) -> None:
        super().__init__()
        self.settings = VectorSettings(
            parameters.deltv, parameters.interfer, not parameters.anglal, parameters.circover / 100.0
        )
        self.radius = 0.0
        self.direction: tuple[float, float] | None = None  # of the auxiliary line in the block in work, on the machine
        self._now: Told = (False, 0.0)
        self._orders: list[tuple[VectorOrder, tuple[float, float] | None]] = []  # of the block in work

    @property
    def active(self) -> bool:
        """The stage compensates, or is about to."""
        return self._now[0]

    @property
    def watches(self) -> bool:
        """Nothing has to see every motion."""
        return False

    def order(self, *orders: VectorOrder, direction: tuple[float, float] | None = None) -> None:
        """Something that happens at the place of the block in work."""
        self._orders += [(order, direction) for order in orders]

    def follow(self, x: Execution) -> None:
        """Tell the stage if another compensation holds now, and what happens here."""
        side = x.modal.compensation_side
        plane = PLANE_AXES[x.modal.plane]
        if (
            side
            and max(plane) < len(x.coordinates.gain)
            and x.coordinates.gain[plane[0]] * x.coordinates.gain[plane[1]] < 0
        ):
            side = -side
        told: Told = (side != 0, side * self.radius)
        if told != self._now:
            self._now = told
            x.emit(
                VectorCompensation(x.source, VectorOrder.SELECT, plane, told[0], told[1], self.direction, self.settings)
            )
        orders, self._orders = self._orders, []
        for order, direction in orders:
            self.tell(x, order, direction)
        self.direction = None

    def tell(self, x: Execution, order: VectorOrder, direction: tuple[float, float] | None = None) -> None:
        """Hand over an order at once."""
        if self.active:
            x.emit(VectorCompensation(x.source, order, PLANE_AXES[x.modal.plane], direction=direction))

    def note(self, x: Execution, block: Block) -> None:
        """Nothing of the motions is needed."""
