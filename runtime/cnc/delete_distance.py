"""Delete distance to go: the rest of the motion block is dropped, and the path goes straight to the target of the next one.

    ─────●· · · · ·●            the path brakes, stands at ●, and what is left of the block becomes nothing
          ╲        │            the next element, whenever it is known, becomes a straight line from where the path stands
           ╲_______▼            to its target; the corner behind it is a stop, as nobody has planned it

The records of the queue are changed in place while the path stands; then it begins anew with them.
"""

from __future__ import annotations

import numpy as np

from runtime.cnc.geometry.axis_limits import AxisLimits
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import ActionKind, RecordKind
from runtime.cnc.path_preparation.dynamics import line_dynamics
from runtime.cnc.path_preparation.queue_writer import NO_LENGTH, path_length
from runtime.cnc.queue_limits import (
    ACCELERATION,
    BRAKING_JERK,
    DECELERATION,
    JERK,
    SETS,
    VELOCITY,
    VELOCITY_STEP,
)

_MOTION = int(RecordKind.POLYNOMIAL)


class DeleteDistance:
    """Of one channel. `order`, then `step` in every cycle; while `holds` the path has to brake."""

    def __init__(self, path: Interpolator) -> None:
        self._path = path
        self.holds = False
        self._displaced = False  # the path stands beside where the next element begins
        self._cuts = False  # nothing leads on to the next element: whoever follows begins where the path stands

    def begin(self) -> None:
        """A program starts."""
        self.holds = self._displaced = self._cuts = False

    def order(self) -> None:
        """Drop the rest of the block in work; without effect where the path is in none."""
        path = self._path
        inside = path.queue.written > path.next_index and path.queue.kind(path.next_index) <= _MOTION
        self.holds = inside and (path.path_velocity > 0.0 or 0.0 < path.covered < 1.0)

    def cut(self) -> None:
        """A measuring run has what it wants: everything up to its end is dropped, even what is not yet in the queue."""
        self.holds = self._cuts = True

    def cut_is_over(self) -> None:
        """The path has come to the end of the run."""
        if self._cuts:
            self.holds = self._cuts = False

    def _cut_off(self) -> None:
        path = self._path
        queue, index = path.queue, path.next_index
        if not path.standstill or queue.read != index or index >= queue.written:
            return
        if queue.kind(index) <= _MOTION:
            self._drop_block()
            self._displaced = False

    def step(self) -> None:
        """After the interpolator's step: act when the path stands."""
        path = self._path
        if self._cuts:
            self._cut_off()
        elif self.holds and path.standstill and path.queue.read == path.next_index:
            self.holds = False
            self._drop_block()
        elif self._displaced and path.apart and path.queue.read == path.next_index:
            self._displaced = False
            self._lead_to_next()

    @property
    def explains_gap(self) -> bool:
        """The next element does not begin where the path stands, and this is why."""
        return self._displaced

    def _drop_block(self) -> None:
        """What is left of the block becomes records without effect; the last of them keeps its end."""
        queue, begin = self._path.queue, self._path.next_index
        first = queue.record(begin)
        block = (int(first["line"]), int(first["n"]), int(first["program"]))
        for i in range(begin, queue.written):
            record = queue.record(i)
            if (
                int(record["kind"]) > _MOTION
                or (int(record["line"]), int(record["n"]), int(record["program"])) != block
            ):
                break
            ends = bool(record["block_end"])
            record["kind"] = RecordKind.BLOCK_END if ends else RecordKind.ACTION
            record["action"], record["number"] = ActionKind.MANUAL_ON, 0  # of no axis
        self._displaced = True
        self._again()

    def _lead_to_next(self) -> None:
        queue, path = self._path.queue, self._path
        n, begin = queue.n_axes, path.next_index
        record = queue.record(begin)
        way = record["end"][:n] - path.position
        (length,), (main,) = path_length(way[None, :])
        if length <= NO_LENGTH:
            record["kind"], record["action"], record["number"] = RecordKind.ACTION, ActionKind.MANUAL_ON, 0
            self._displaced = True  # the place is the same, but for rounding
        else:
            sets = queue.limits.sets[int(record["limits"]) % SETS, :, :n]
            rows = (VELOCITY, ACCELERATION, JERK, VELOCITY_STEP, DECELERATION, BRAKING_JERK)
            limits = AxisLimits(*(sets[row].copy() for row in rows))
            feed = np.array([float(record["feed"])])
            dynamics, _ = line_dynamics(
                limits, path.period, way[None, :] / length, np.array([length]), np.array([main]), feed, None
            )
            record["kind"], record["start"][:n], record["length"] = RecordKind.LINE, path.position, length
            record["v_limit"], record["a_limit"] = dynamics.v_limit[0], dynamics.a_limit[0]
            record["j_limit"] = dynamics.j_limit[0]
            record["a_hold"] = record["j_hold"] = 0.0
            record["v_entry"] = record["v_corner"] = 0.0
            for i in range(begin + 1, queue.written):
                following = queue.record(i)
                if int(following["kind"]) <= _MOTION:
                    following["v_entry"] = following["v_corner"] = 0.0
                    break
        self._again()

    def _again(self) -> None:
        """The interpolator knows nothing of the records as they were."""
        path = self._path
        path.restart(path.position.copy(), path.path_position)
