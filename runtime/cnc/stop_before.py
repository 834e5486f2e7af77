"""Stops of the path before an element that must not begin: axis feed hold, directional hold, read disable, dynamic limits.

    ── element that may go on ──┃ block end: a gate while something is to be stopped before ┃── element that must not begin ──
                                 opened at once if what follows may go on; else the path stops here, functions are put out,
                                 and it is held before the element begins

What is asked of is always the element in work and the next one; nothing is known of how the interpolator plans.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

import numpy as np
import numpy.typing as npt

from runtime.cnc.beside_path import stopping_way
from runtime.cnc.interpolator import Interpolator
from runtime.cnc.motion_queue import RecordKind
from runtime.config.machine import Axis
from runtime.hli.layout import Blocked, StopCondition

Floats = npt.NDArray[np.float64]

SEARCHED = 64  # records behind a block end among which the next element is looked for
_MOTION = int(RecordKind.POLYNOMIAL)
_ARC, _POLYNOMIAL = int(RecordKind.ARC), int(RecordKind.POLYNOMIAL)
_NONE = int(StopCondition.NONE)
_AXIS_FEED_HOLD = int(StopCondition.AXIS_FEED_HOLD)
_READ_DISABLE = int(StopCondition.READ_DISABLE)
_AXIS_LIMIT = int(StopCondition.AXIS_LIMIT)
_PLUS, _MINUS = int(Blocked.PLUS), int(Blocked.MINUS)


class Restrictions(Protocol):
    """What is commanded to the path in this cycle."""

    read_disable: bool
    axis_feed_hold: bool
    restricted: bool  # a direction is blocked, or an axis has dynamic limits
    axis_holds: list[bool]
    blocked: list[int]
    limits: list[tuple[float, float] | None]


class StopBefore:
    """Of one channel. `step` once per cycle before the interpolator; then `hold` and `stop_at_block_ends` hold."""

    def __init__(self, path: Interpolator, axes: Sequence[Axis], condition: str) -> None:
        """`condition` is P-CHAN-00267: DEFAULT, NEXT_NON_RAPID_BLOCK or NEXT_RAPID_BLOCK."""
        self._path = path
        self._axes = list(axes)
        self._condition = condition
        self._at_limit = [0] * len(self._axes)  # direction in which an axis is held at its dynamic limit
        self._limits_before: list[tuple[float, float] | None] = [None] * len(self._axes)
        self.hold = _NONE  # StopCondition bits
        self.stop_at_block_ends = False

    def step(self, inputs: Restrictions) -> None:
        """Decide for this cycle."""
        self.hold, self.stop_at_block_ends = _NONE, False
        if not (inputs.axis_feed_hold or inputs.read_disable or inputs.restricted):
            return
        record = self._element()
        if inputs.axis_feed_hold:
            held = [k for k, wanted in enumerate(inputs.axis_holds) if wanted]
            if record is None or any(moves(record, k) for k in held):
                self.hold |= _AXIS_FEED_HOLD
            else:
                self.stop_at_block_ends = True
        if inputs.read_disable:
            if self._condition == "DEFAULT" or (record is not None and not self._begun and self._read_disabled(record)):
                self.hold |= _READ_DISABLE
            else:
                self.stop_at_block_ends = True
        if inputs.restricted and record is not None:
            if self._restricted(inputs, record):
                self.hold |= _AXIS_LIMIT
            else:
                self.stop_at_block_ends |= any(inputs.blocked)

    def may_follow(self, inputs: Restrictions, gate: int) -> bool:
        """Whether what comes behind the block end `gate` may begin; TRUE also where nothing is known of it."""
        record = self._next(gate + 1)
        if record is None:
            return True
        if inputs.axis_feed_hold and any(moves(record, k) for k, held in enumerate(inputs.axis_holds) if held):
            return False
        if any(
            inputs.blocked[k] & _direction(float(record["end"][k] - record["start"][k])) for k in range(len(self._axes))
        ):
            return False
        return not (inputs.read_disable and self._read_disabled(record))

    def limit_state(self, k: int, limits: tuple[float, float], position: float) -> int:
        """Of the dynamic limits: 1 inside, 2 held at one, -1 beyond."""
        if not limits[0] - 1e-6 <= position <= limits[1] + 1e-6:
            return -1
        return 2 if self._at_limit[k] or position in limits else 1

    # ------------------------------------------------------------------ elements

    def _element(self) -> Any:
        """The element in work, or the next one where the path stands between two; None if none is known."""
        path = self._path
        at_its_end = path.index == path.next_index and path.path_velocity == 0.0 and path.covered >= 1.0
        return self._next(path.next_index + at_its_end)

    def _next(self, index: int) -> Any:
        queue = self._path.queue
        for i in range(index, min(index + SEARCHED, queue.written)):
            if queue.kind(i) <= _MOTION:
                return queue.record(i)
        return None

    @property
    def _begun(self) -> bool:
        """The path is inside an element, or on its way into one."""
        path = self._path
        return path.path_velocity > 0.0 or (path.index == path.next_index and 0.0 < path.covered < 1.0)

    def _read_disabled(self, record: Any) -> bool:
        return bool(record["rapid"]) == (self._condition == "NEXT_RAPID_BLOCK")

    # ------------------------------------------------------------------ directions and limits

    def _restricted(self, inputs: Restrictions, record: Any) -> bool:
        path, found = self._path, False
        for k, axis in enumerate(self._axes):
            limits = inputs.limits[k]
            if limits != self._limits_before[k]:
                self._limits_before[k], self._at_limit[k] = limits, 0
            v = float(path.velocity[k])
            way = v if v != 0.0 else float(record["end"][k] - record["start"][k])
            if way == 0.0:
                continue
            if inputs.blocked[k] & _direction(way):
                found = True
            if limits is not None:
                found |= self._reaches_limit(k, axis, limits, math.copysign(1.0, way), v)
        return found

    def _reaches_limit(
        self, k: int, axis: Axis, limits: tuple[float, float], direction: float, velocity: float
    ) -> bool:
        """Held from where the axis just comes to rest before its limit, until the limit changes or the way leads back."""
        if self._at_limit[k] == direction:
            return True
        self._at_limit[k] = 0
        ahead = float(self._path.position[k]) + direction * stopping_way(axis, abs(velocity))
        # two cycles: the hold acts in the next one, and the path may still speed up in this one
        ahead += direction * 2.0 * self._path.period * (abs(velocity) + axis.acceleration * self._path.period)
        if (ahead >= limits[1]) if direction > 0.0 else (ahead <= limits[0]):
            self._at_limit[k] = int(direction)
            return True
        return False


def _direction(way: float) -> int:
    """The bit of `Blocked` that forbids it."""
    return _PLUS if way > 0.0 else _MINUS if way < 0.0 else 0


def moves(record: Any, axis: int) -> bool:
    """Whether the element moves the axis; a polynomial counts as moving all of them."""
    kind = int(record["kind"])
    if kind == _POLYNOMIAL or (kind == _ARC and axis in (int(record["axis0"]), int(record["axis1"]))):
        return True
    return bool(record["start"][axis] != record["end"][axis])
