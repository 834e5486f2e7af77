"""Where single block stops: behind which blocks the stream gets an end mark."""

from __future__ import annotations

import math
from collections.abc import Iterator
from dataclasses import dataclass

from runtime.cnc.blocks import (
    AxisJob,
    AxisJobWait,
    Block,
    BlockEnd,
    Dwell,
    ExternalWrite,
    Line,
    Message,
    Polyline,
    Source,
    SpindleSetting,
    StepEnd,
    Stop,
    StopMark,
    TechnologyFunction,
    TimerAction,
    ToolLifeAction,
)

# Of a block without motion: what makes it a relevant control block of P-CHAN-00015, and what stops the path anyway
CONTROLS = (
    TechnologyFunction, Dwell, Message, TimerAction, SpindleSetting, AxisJob, AxisJobWait, ExternalWrite, ToolLifeAction
)  # fmt: skip
ENDS_STEP = (BlockEnd, StepEnd, Stop, StopMark)


@dataclass(slots=True)
class Steps:
    """`locked`: nowhere, until it is unlocked. `resolution`: only where the block number reaches its next multiple, 1 for
    every block; `reached` is the multiple of the last stop."""

    locked: bool = False
    resolution: int = 1
    reached: int | None = None

    @property
    def everywhere(self) -> bool:
        """Every block is a step."""
        return not self.locked and self.resolution == 1

    def ends(self, number: int | None) -> bool:
        """Whether a step ends behind the block with this number."""
        if self.locked or self.everywhere:
            return not self.locked
        if number is None:
            return False
        multiple = number // self.resolution
        if multiple == self.reached:
            return False
        self.reached = multiple
        return True

    def apart(self, run: Polyline, shown: Source | None) -> Iterator[Block]:
        """The moves of a run one by one, with end marks where a step ends; `shown` is the source that stands for all of them."""
        gain = 1.0 if run.pcs_gain is None else run.pcs_gain
        for i, feed in enumerate(run.feeds):
            number = int(run.numbers[i])
            source = shown or Source(run.program, int(run.lines[i]), None if number < 0 else number)
            end = run.points[i + 1]
            rapid = math.isinf(feed)
            yield Line(source, run.points[i], end, float(feed), rapid, (end - run.pcs_shift) / gain)
            if shown is None and self.ends(source.n):
                yield BlockEnd(source)
