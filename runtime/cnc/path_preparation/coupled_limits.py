"""Software limits of axes that follow others: what holds for a slave holds for its master, as far as it is ahead."""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

from runtime.cnc.blocks import Block, CoupledAxis, CouplingChange, SoftwareLimitChange, Source

Limits = tuple[tuple[float, float], ...]


def narrowed(limits: Limits, coupled: Iterable[CoupledAxis]) -> Limits:
    """The limits within which every master has to stay, so that its slaves stay within theirs; all of them (n_axes,)."""
    kept = list(limits)
    for one in coupled:
        low, high = kept[one.master]
        least, greatest = limits[one.slave]
        kept[one.master] = (max(low, least - one.offset), min(high, greatest - one.offset))
    return tuple(kept)


def coupled_limits(blocks: Iterable[Block], configured: Limits) -> Iterator[Block]:
    """The stage in front of the software limits: it hands on the limits that hold while axes are coupled."""
    programmed = SoftwareLimitChange(Source("", 0), configured)
    coupled: tuple[CoupledAxis, ...] = ()
    for block in blocks:
        if isinstance(block, SoftwareLimitChange):
            programmed = block
            yield replace(block, limits=narrowed(block.limits, coupled)) if coupled else block
            continue
        if isinstance(block, CouplingChange):
            coupled = block.coupled
            yield replace(programmed, source=block.source, limits=narrowed(programmed.limits, coupled))
        yield block
