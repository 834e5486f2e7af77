"""The couplings that are active in a running program; `cnc/decoder/couplings.py` has their rules."""

from __future__ import annotations

from dataclasses import dataclass, field

from runtime.cnc.blocks import CoupledAxis


@dataclass(slots=True)
class ActiveCouplings:
    """`active`: group -> its pairs, in the order in which they were switched on; `slaves`: channel index -> its pair."""

    active: dict[int, tuple[CoupledAxis, ...]] = field(default_factory=dict)
    slaves: dict[int, CoupledAxis] = field(default_factory=dict)
    last: int = 0  # V.G.AX_LINK.NR

    def place(self, axis: int, position: list[float]) -> float:
        """Where an axis stands where the decoder has `position` (n_axes,): slaves are behind their masters."""
        coupled = self.slaves.get(axis)
        return position[axis] if coupled is None else position[coupled.master] + coupled.offset
