"""Late functions of type MVS_SLM: the path waits for them where it goes over to machining (channel parameters, line 1941).

    M24 ─ G00 ─ G00 ─▌─ G01 ─ G01        ▌ a place to wait, only in front of the first feed motion after the function

Rapid moves go on without waiting. What a program leaves open is asked for by the first feed motion of the next one
(P-CHAN-00033), so the object lives as long as the channel. Functions of type MVS_SLP are waited for by #EXPL SYN.
"""

from __future__ import annotations

from collections.abc import Iterable, Iterator
from dataclasses import replace

import numpy as np

from runtime.cnc.blocks import Arc, Block, Line, Polyline, Source, SpatialArc, Synch, TechnologyFunction, Wait


class LateSynchronisation:
    """A stage of the preparation."""

    def __init__(self) -> None:
        self._open = False

    def __call__(self, blocks: Iterable[Block]) -> Iterator[Block]:
        for block in blocks:
            if isinstance(block, TechnologyFunction):
                self._open |= bool(block.synch & Synch.MVS_SLM)
            elif self._open and isinstance(block, Polyline):
                yield from self._run(block)
                continue
            elif self._open and (isinstance(block, Arc | SpatialArc) or (isinstance(block, Line) and not block.rapid)):
                yield self._wait(block.source)
            yield block

    def _wait(self, source: Source) -> Wait:
        self._open = False
        return Wait(source, Synch.MVS_SLM)

    def _run(self, run: Polyline) -> Iterator[Block]:
        """Straight moves, the wait in front of the first of them that is no rapid move."""
        machining = np.isfinite(run.feeds)
        if not machining.any():
            yield run
            return
        first = int(np.argmax(machining))
        if first:
            yield replace(
                run,
                points=run.points[: first + 1],
                feeds=run.feeds[:first],
                lines=run.lines[:first],
                numbers=run.numbers[:first],
            )
        n = int(run.numbers[first])
        yield self._wait(Source(run.program, int(run.lines[first]), n if n >= 0 else None))
        yield replace(
            run,
            points=run.points[first:],
            feeds=run.feeds[first:],
            lines=run.lines[first:],
            numbers=run.numbers[first:],
        )
