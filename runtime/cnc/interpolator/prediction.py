"""When the path comes to a place ahead, or when it was at one behind: for functions that are put out at a time. Kernels.

Nothing here moves anything. Two sources, the first that holds:

- the plan that is driven, where it is sure to be driven to its end: behind the present place, and while the path brakes for
  the stop at its end;
- the records: from the present speed at once to the greatest one and back with the limits of each stretch, without
  acceleration at the borders of stretches. Elements that are driven alike, one after the other, are one stretch.

           cap ┌───────────┐                  vb: from behind, what can still be braked
     ┌─────────┤           ├────┐ stop        vf: from here, what can be reached
     ▼ here    ▲ entry     ▲    ▼             time = Σ of up, along, down
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.lookahead import BLOCK_END, GATE, ORDERS, entry_speed, wanted_speed
from runtime.cnc.interpolator.plan import ACCELERATION_AT, COLUMNS, JERK_AT, SPEED_AT, TIME, WAY, crossing, state_at
from runtime.cnc.motion_queue import RECORD, Records
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]

STRETCHES = 64
ELEMENTS = 4096  # looked at for one prediction
AT_END = 1e-6  # mm: a plan that ends so near to a stop ends at it
LENGTH, CAP, A_MOST, J_MOST, ENTRY, BACK, FORTH = 0, 1, 2, 3, 4, 5, 6  # rows of the scratch
ROWS = 7


@kernel
def ramp_time(change: float, A: float, J: float) -> float:
    """Seconds for a change of speed that begins and ends without acceleration."""
    change = abs(change)
    return change / A + A / J if change > A * A / J else 2.0 * math.sqrt(change / J)


@kernel
def stretch_time(length: float, v0: float, v1: float, cap: float, A: float, J: float) -> float:
    """Seconds for a way from v0 to v1, as fast as `cap` where there is room for it."""
    low, high = max(v0, v1), max(cap, max(v0, v1))
    up, down = ramp_time(high - v0, A, J), ramp_time(high - v1, A, J)
    way = (v0 + high) / 2.0 * up + (high + v1) / 2.0 * down
    if way <= length:
        return up + down + (length - way) / high if high > 0.0 else np.inf
    if length <= 0.0:
        return 0.0
    for _ in range(50):
        top = (low + high) / 2.0
        up, down = ramp_time(top - v0, A, J), ramp_time(top - v1, A, J)
        if (v0 + top) / 2.0 * up + (top + v1) / 2.0 * down > length:
            high = top
        else:
            low = top
    up, down = ramp_time(low - v0, A, J), ramp_time(low - v1, A, J)
    rest = length - (v0 + low) / 2.0 * up - (low + v1) / 2.0 * down
    if rest < -1e-9:  # no room even for v0 → v1: it is braking already
        return 2.0 * length / (v0 + v1) if v0 + v1 > 0.0 else np.inf
    return up + down + (rest / low if low > 0.0 else 0.0)


@kernel
def time_on_plan(plan: Floats, rows: int, now: float, way: float) -> float:
    """Seconds from `now`, a time of the plan, to where it is `way` further (or, below 0, nearer)."""
    s, _, _ = state_at(plan, rows, now)
    s = max(s + way, 0.0)
    for row in range(rows - 1):
        if plan[row + 1, WAY] >= s:
            most = plan[row + 1, TIME] - plan[row, TIME]
            t = crossing(s - plan[row, WAY], plan[row, SPEED_AT], plan[row, ACCELERATION_AT], plan[row, JERK_AT], most)
            return float(plan[row, TIME] + t - now)
    return float(plan[rows - 1, TIME] - now)


@kernel
def time_until(
    records: Records,
    written: int,
    cur: int,
    s_in: float,
    v: float,
    way: float,
    before: int,
    at_most: float,
    orders: Floats,
    opened: int,
    single_block: bool,
    released: int,
    plan: Floats,
    rows: int,
    now: float,
    rest: float,
    z: Floats,
) -> float:
    """Seconds until the path has gone `way` mm, from `s_in` in record `cur`; infinite if that cannot be foreseen, or is more
    than `at_most`.

    A closed gate in front of record `before` makes it unforeseeable. `rest`: way to the end of the plan; `z`: scratch.
    """
    size = records.shape[0]
    count, at = 0, -1  # stretches, and how many of them end before the place
    seen = -s_in
    fastest = v
    optimistic = 0.0
    stop = np.inf
    need = np.inf
    z[LENGTH, 0] = z[CAP, 0] = 0.0
    e = cur
    last = min(written, cur + ELEMENTS)
    while e < last:
        r = records[e % size]
        closed = r["kind"] == GATE and e > opened
        if r["length"] > 0.0:
            length = r["length"] - s_in if e == cur else r["length"]
            cap = wanted_speed(r["rapid"], r["feed"], r["external"], r["spindle"], r["v_limit"], orders)
            if cap <= 0.0:
                return np.inf
            new = count == 0 or (at == count) or abs(cap - z[CAP, count - 1]) > 1e-9 * cap or r["v_entry"] < cap
            if new and count < STRETCHES:
                z[LENGTH, count], z[CAP, count] = length, cap
                z[A_MOST, count], z[J_MOST, count] = r["a_limit"], r["j_limit"]
                z[ENTRY, count] = r["v_entry"] if count > 0 else np.inf
                count += 1
            else:
                k = count - 1  # too many: as one stretch that takes as long
                z[CAP, k] = (z[LENGTH, k] + length) / (z[LENGTH, k] / z[CAP, k] + length / cap)
                z[LENGTH, k] += length
                z[A_MOST, k] = min(z[A_MOST, k], r["a_limit"])
                z[J_MOST, k] = min(z[J_MOST, k], r["j_limit"])
            fastest = max(fastest, cap)
            seen += r["length"]
            if at < 0:
                optimistic += length / cap
                if optimistic > at_most:
                    return np.inf
                if seen >= way - AT_END:
                    at = count
                    A, J = z[A_MOST, count - 1], z[J_MOST, count - 1]
                    need = seen + fastest * ramp_time(fastest, A, J)
        if single_block and e > released and (r["kind"] == BLOCK_END or r["block_end"] == 1):
            closed = True
        if closed:
            if e < before or seen < way - AT_END:
                return np.inf
            stop = seen
            break
        if seen > need:
            break
        e += 1
    if at < 0 or count == 0:
        return 0.0 if way <= AT_END else np.inf
    if abs(rest - stop) <= AT_END and way <= rest + AT_END:
        return time_on_plan(plan, rows, now, min(way, rest))
    z[BACK, count] = 0.0
    for k in range(count - 1, -1, -1):
        most = min(z[CAP, k], z[ENTRY, k])
        if k > 0:
            most = min(most, z[CAP, k - 1])
        z[BACK, k] = min(most, entry_speed(z[LENGTH, k], z[BACK, k + 1], z[A_MOST, k], z[J_MOST, k]))
    time = 0.0
    z[FORTH, 0] = v
    for k in range(at):
        then = min(z[BACK, k + 1], entry_speed(z[LENGTH, k], z[FORTH, k], z[A_MOST, k], z[J_MOST, k]))
        time += stretch_time(z[LENGTH, k], z[FORTH, k], then, z[CAP, k], z[A_MOST, k], z[J_MOST, k])
        z[FORTH, k + 1] = then
    return time


def scratch() -> Floats:
    """Memory for a prediction."""
    return np.zeros((ROWS, STRETCHES + 1))


@warms("prediction")
def _warm_up() -> None:
    time_until(
        np.zeros(1, dtype=RECORD), 0, 0, 0.0, 0.0, 1.0, -1, np.inf, np.ones(ORDERS), -1, False, -1,
        np.zeros((2, COLUMNS)), 1, 0.0, 0.0, scratch(),
    )  # fmt: skip
    time_on_plan(np.zeros((2, COLUMNS)), 1, 0.0, -1.0)
    ramp_time(1.0, 1.0, 1.0)  # threads ask for it by itself
