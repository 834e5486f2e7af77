"""How far the decoder may be ahead of the interpolator (P-CHAN-00216, 00246, 00269, 00270; channel parameters 6930–7005).

The blocks ahead are counted in the queue: those of which something is still to be passed. In protected mode the limit does not
hold while the path would suffer: the queue has to know more way than braking from the present speed needs, and PROTECTED_TIME.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from runtime.cnc.motion_queue import MotionQueue, RecordKind
from runtime.config.channel.parameters import ChannelParameters

Ints = npt.NDArray[np.int64]

PROTECTED_TIME = 0.5  # s of motion that have to be known before a limit holds in protected mode
_MOTION = (RecordKind.LINE, RecordKind.ARC, RecordKind.POLYNOMIAL)
_UNLIMITED = 1e9


@dataclass(frozen=True, slots=True)
class RunAhead:
    """0 is no limit. `blocks`: NC blocks, `motions`: those with motion, `seconds` of motion at the speed that is asked for."""

    blocks: int = 0
    motions: int = 0
    seconds: float = 0.0
    protected: bool = False

    @classmethod
    def of(cls, parameters: ChannelParameters) -> RunAhead:
        """By time it is always protected (line 6975)."""
        seconds = parameters.max_time_ahead * 1e-6
        protected = parameters.dec_max_ahead_protected == "ACTIVE" or seconds > 0.0
        return cls(parameters.max_nc_blocks_ahead, parameters.max_motion_blocks_ahead, seconds, protected)

    @property
    def unlimited(self) -> bool:
        return not (self.blocks or self.motions or self.seconds)

    def reached(self, queue: MotionQueue) -> bool:
        """Whether the decoder has to wait."""
        if self.unlimited or queue.written == queue.read:
            return False
        here = np.arange(queue.read, queue.written) % queue.capacity
        moving = here[np.isin(queue.records["kind"][here], _MOTION)]
        if self.protected and seconds_of(queue, moving) < PROTECTED_TIME:
            return False
        return (
            (self.blocks > 0 and _blocks(queue, here) >= self.blocks)
            or (self.motions > 0 and _blocks(queue, moving) >= self.motions)
            or (self.seconds > 0.0 and seconds_of(queue, moving) >= self.seconds)
        )


def _blocks(queue: MotionQueue, slots: Ints) -> int:
    """NC blocks among the records of successive slots: those with another line or number than the one before."""
    line, n = queue.records["line"][slots], queue.records["n"][slots]
    return len(slots) and 1 + int(np.count_nonzero((np.diff(line) != 0) | (np.diff(n) != 0)))


def seconds_of(queue: MotionQueue, slots: Ints) -> float:
    """The time that the elements of slots take at the feed that they ask for, s."""
    records = queue.records
    speed = np.minimum(records["feed"][slots], np.minimum(records["v_limit"][slots], _UNLIMITED))
    return float((records["length"][slots] / np.maximum(speed, 1e-9)).sum())
