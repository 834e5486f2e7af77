"""From the constraints of a cycle to a plan: this cycle as fast as possible, and then the way to standstill. Kernels.

     v ▲  this cycle ┆ standstill in zone 0:  the same constraints, NOW 0, braking with the least of what is crossed
       │        ╭────┆──╮
       │    ────╯    ┆   ╲                      or, where zone 0 is too short for that: to the speed v(1) at which its
       │             ┆    ╲___v(1)              border may be crossed, and on with the limits of zone 1:
       │             ┆        ┊╲__v(2)          to 0 in it if it is long enough, else to v(2), ...
       └─────────────┆────────┊───┊───────▶ s

The plan is only a proposal: whether it keeps all limits is proven by `plan.keeps_limits`.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.plan import ACCELERATION_AT, SPEED_AT, TIME, WAY, begin, go
from runtime.cnc.interpolator.profile import (
    BORDER,
    FEED,
    NEVER,
    NOW,
    REDUCE,
    SLOWER,
    SPEED,
    STOP,
    TOLERANCE,
    brake_distance,
    drive,
    watch_cycle,
)
from runtime.kernels import kernel

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]


@kernel
def brake(plan: Floats, rows: int, target: float, A: float, J: float) -> int:
    """Add the braking with A and J from the end of the plan, a ≤ 0, to `target` without acceleration."""
    v, a = plan[rows - 1, SPEED_AT], plan[rows - 1, ACCELERATION_AT]
    drop = v + a * a / (2.0 * J) - target
    if drop > a * a / J:  # more than taking back what there is
        peak = min(A, math.sqrt(drop * J))
        if peak + a > 0.0:
            rows = go(plan, rows, (peak + a) / J, -J)
        if drop > A * A / J:
            rows = go(plan, rows, drop / A - A / J, 0.0)
    a = plan[rows - 1, ACCELERATION_AT]
    if a < 0.0:
        rows = go(plan, rows, -a / J, J)
    v = plan[rows - 1, SPEED_AT]
    plan[rows - 1, ACCELERATION_AT] = 0.0
    if abs(v - target) < 1e-6:
        plan[rows - 1, SPEED_AT] = target
    return rows


@kernel
def stop_in_zones(plan: Floats, rows: int, zones: int, borders: Floats) -> int:
    """Add the braking to standstill behind the border of zone 1, with the limits of each zone."""
    for z in range(1, zones + 1):
        s, v, a = plan[rows - 1, WAY], plan[rows - 1, SPEED_AT], plan[rows - 1, ACCELERATION_AT]
        A, J = borders[z + 1, 1], borders[z + 1, 2]
        if z == zones or brake_distance(v, a, 0.0, A, J) <= borders[z + 1, 0] - s:
            return brake(plan, rows, 0.0, A, J)
        rows = brake(plan, rows, min(borders[z + 1, 3], v), A, J)
        way, v = borders[z + 1, 0] - plan[rows - 1, WAY], plan[rows - 1, SPEED_AT]
        if way > 0.0 and v > 0.0:
            rows = go(plan, rows, way / v, 0.0)
    return rows


@kernel
def propose(
    T: float, v: float, a: float, count: int, kind: Ints, d: Floats, x: Floats, A: Floats, J: Floats, B: Floats,
    state: Ints, up: Floats, zones: int, borders: Floats, plan: Floats,
) -> tuple[int, int, bool]:  # fmt: skip
    """Fill `plan` from (0, v, a): one cycle of T seconds, then to standstill.

    Returns the number of rows, the constraint that braked in the cycle (-1: none), and whether a cycle needed more
    pieces than there are. The constraints are used up. `zones`: how many lie behind the first (0: not looked at so).
    """
    rows = begin(plan, v, a)
    watch_cycle(T, v, a, up[0], up[1], count, kind, d, x, A, J, B, state)
    rows, braked, left = drive(T, count, kind, d, x, A, J, B, state, up, T, NEVER, plan, rows)
    last = rows - 1
    s, v, a = plan[last, WAY], plan[last, SPEED_AT], plan[last, ACCELERATION_AT]
    border = NEVER
    for i in range(count):
        if kind[i] == BORDER:
            border = d[i]
    if left > 1e-9 and s < border - TOLERANCE:
        return rows, braked, True
    if left <= 1e-9:
        plan[last, TIME] = T
    if v == 0.0 and a == 0.0 and left <= 1e-9:
        return rows, braked, False
    if s < border - TOLERANCE:
        # Standstill before the border, with the least of what is crossed?
        A[0], J[0] = up[0], up[1]
        way = brake_distance(v, a, 0.0, A[0], J[0])
        for i in range(1, count):
            if kind[i] == REDUCE and d[i] > s + TOLERANCE:
                if d[i] - s > way:
                    break
                A[0], J[0] = min(A[0], x[i]), min(J[0], A[i])
                if d[i] < border:
                    way = brake_distance(v, a, 0.0, A[0], J[0])
        x[0] = 0.0
        if a < 0.0 and 2.0 * v * J[0] < a * a:  # only in a corner where the acceleration may jump can it be taken back
            for i in range(1, count):
                if kind[i] == SPEED and B[i] > 0.0 and d[i] > s - 1e-6:
                    way = max(way, d[i] - s + v * math.sqrt(2.0 * v / J[0]))
                    break
        if s + way > border:
            A[0], J[0] = borders[1, 1], borders[1, 2]
            change = a * a / (2.0 * J[0])
            x[0] = max(min(borders[1, 3], v + change if a > 0.0 else v - change), 0.0)
            way = NEVER
        B[0] = up[1]
        for i in range(count):
            peak = v + a * a / (2.0 * J[i]) if a > 0.0 and kind[i] != NOW else v
            slow = (kind[i] == SPEED or kind[i] == SLOWER) and (x[i] < peak or a > 0.0)
            slow = slow or (kind[i] == SPEED and B[i] > 0.0)
            less = kind[i] == REDUCE and a > x[i]
            watched = less or kind[i] == STOP or kind[i] == BORDER or slow
            state[i] = 1 if watched and kind[i] != FEED and s - 1e-6 < d[i] <= s + way + 1e-6 else 0
        state[0] = 1
        while count > 1 and d[count - 1] > s + way + 1e-6:
            count -= 1
        rows, _, _ = drive(NEVER, count, kind, d, x, A, J, B, state, up, T, border, plan, rows)
    if border < NEVER and plan[rows - 1, SPEED_AT] > 0.0:
        rows = stop_in_zones(plan, rows, zones, borders)
    return rows, braked, False
