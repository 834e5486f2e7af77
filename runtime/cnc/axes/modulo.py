"""Which turn an absolute motion of a modulo axis leads to: an axis that turns without end stands at 90 degrees in every turn.

Set-points go on from turn to turn; only where a job says an absolute position its turn is chosen.
"""

from __future__ import annotations

import math

from runtime.hli.layout import Direction

TURN = 360.0
_SAME = 1e-9  # turns: what is left of a motion that has arrived


def chosen_turn(position: float, place: float, rest: float, velocity: float, direction: Direction) -> float:
    """Where the motion to `position` ends, degrees. The axis is at `place`, and would come to rest at `rest` if it braked now.

    In a direction the motion ends at the first such place behind `rest`, so that it never turns back; the shortest way is that
    from `place`. The current direction of an axis at rest is the positive one.
    """
    if direction is Direction.SHORTEST:
        return position + TURN * round((place - position) / TURN)
    turns = (rest - position) / TURN
    if direction is Direction.NEGATIVE or (direction is Direction.CURRENT and velocity < 0.0):
        return position + TURN * math.floor(turns + _SAME)
    return position + TURN * math.ceil(turns - _SAME)
