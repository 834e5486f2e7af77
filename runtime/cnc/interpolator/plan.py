"""A plan: what is driven from now to standstill, piece by piece, and the proof that it keeps every limit. Kernels.

    row      0        1     2          3      …   last          each row: where a piece of constant jerk begins
    ─────────●────────●─────●──────────●──────────●             t (s from the plan's begin), s (mm), v, a, jerk
             │  this cycle  │  braking to standstill            last row: v = 0, a = 0

In every cycle the profile proposes what it wants to drive, followed by a braking to standstill. `keeps_limits` holds
that against the records themselves, not against what the look-ahead made of them. Only a proven plan is driven; it is
kept, and when a later proposal can't be proven, the machine goes on along the kept one, so that whatever is ordered
(feed hold taken back, override raised, gates opened while braking) takes effect in the first cycle in which it is safe.
Nothing that is ordered later can break a proven plan: it ends before the first closed gate and before the end of what
is known, and single block closes no gate in front of its end.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.motion_queue import Records
from runtime.kernels import kernel

Floats = npt.NDArray[np.float64]

TIME, WAY, SPEED_AT, ACCELERATION_AT, JERK_AT = 0, 1, 2, 3, 4
COLUMNS = 5
ROWS = 256  # a cycle has some pieces, a braking at most four per zone

LINE, ARC, POLYNOMIAL, FUNCTION, GATE, BLOCK_END = 0, 1, 2, 3, 4, 5  # motion up to POLYNOMIAL

AT_BORDER = 1e-9  # mm: a piece that begins so near to a border begins at it
NEAR = 1e-7  # mm: standing so near to a gate is standing at it
LEAP_AT = 2e-7  # mm: so near to a corner the acceleration may jump in it
ROUNDING_V, ROUNDING_A = 1e-6, 1e-5  # shares of the limits
ROUNDING_J = 0.002  # of the change of acceleration that the jerk allows in one cycle


@kernel
def begin(plan: Floats, v: float, a: float) -> int:
    """A plan of one row; returns the number of rows."""
    plan[0, TIME], plan[0, WAY], plan[0, SPEED_AT], plan[0, ACCELERATION_AT], plan[0, JERK_AT] = 0.0, 0.0, v, a, 0.0
    return 1


@kernel
def add(plan: Floats, rows: int, t: float, jerk: float, s: float, v: float, a: float) -> int:
    """Add a piece of `t` seconds that ends in (s, v, a); returns the number of rows (a full plan stays as it is)."""
    if rows >= plan.shape[0] or t <= 0.0:
        if rows < plan.shape[0]:  # no time has passed: put right what was rounded
            plan[rows - 1, WAY], plan[rows - 1, SPEED_AT], plan[rows - 1, ACCELERATION_AT] = s, v, a
        return rows
    plan[rows - 1, JERK_AT] = jerk
    plan[rows, TIME] = plan[rows - 1, TIME] + t
    plan[rows, WAY], plan[rows, SPEED_AT], plan[rows, ACCELERATION_AT], plan[rows, JERK_AT] = s, v, a, 0.0
    return rows + 1


@kernel
def leap(plan: Floats, rows: int, s: float, v: float, a: float) -> int:
    """Let the acceleration jump to `a`: a piece without time; returns the number of rows."""
    if rows >= plan.shape[0]:
        return rows
    plan[rows - 1, JERK_AT] = 0.0
    plan[rows, TIME] = plan[rows - 1, TIME]
    plan[rows, WAY], plan[rows, SPEED_AT], plan[rows, ACCELERATION_AT], plan[rows, JERK_AT] = s, v, a, 0.0
    return rows + 1


@kernel
def go(plan: Floats, rows: int, t: float, jerk: float) -> int:
    """Add a piece of `t` seconds with constant jerk; returns the number of rows."""
    s, v, a = plan[rows - 1, WAY], plan[rows - 1, SPEED_AT], plan[rows - 1, ACCELERATION_AT]
    s += v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
    return add(plan, rows, t, jerk, s, max(v + a * t + jerk * t * t / 2.0, 0.0), a + jerk * t)


@kernel
def state_at(plan: Floats, rows: int, time: float) -> tuple[float, float, float]:
    """(s, v, a) at `time`; behind the end what the end is."""
    row = 0
    while row + 1 < rows and plan[row + 1, TIME] <= time + 1e-12:
        row += 1
    s, v, a = plan[row, WAY], plan[row, SPEED_AT], plan[row, ACCELERATION_AT]
    t = time - plan[row, TIME]
    if t <= 1e-12 or row + 1 >= rows:
        return s, v, a
    jerk = plan[row, JERK_AT]
    s += v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
    return s, max(v + a * t + jerk * t * t / 2.0, 0.0), a + jerk * t


@kernel
def crossing(way: float, v: float, a: float, jerk: float, most: float) -> float:
    """Time at which `way` is covered, at most `most`; Newton, kept between bounds, as the way only grows."""
    low, high = 0.0, most
    t = most if v <= 0.0 else min(way / v, most)
    for _ in range(60):
        off = v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0 - way
        if off < 0.0:
            low = t
        else:
            high = t
        if abs(off) < 1e-13 or high - low < 1e-15:
            break
        speed = v + a * t + jerk * t * t / 2.0
        t = t - off / speed if speed > 0.0 else -1.0
        if not low < t < high:
            t = (low + high) / 2.0
    return t


@kernel
def most_acceleration(limit: float, in_hold: float, hold: bool) -> float:
    """The acceleration, or the jerk, that an element allows: in feed hold also that of its own ramp, if it is the harder one."""
    return max(limit, in_hold) if hold else limit


@kernel
def part_keeps(
    r: Records, jerk: float, t: float, v0: float, a0: float, v1: float, a1: float, period: float, hold: bool
) -> bool:
    """Whether a piece, or the part of one that lies on the element `r`, keeps its limits."""
    A = most_acceleration(float(r["a_limit"]), float(r["a_hold"]), hold)
    J = most_acceleration(float(r["j_limit"]), float(r["j_hold"]), hold)
    if max(abs(a0), abs(a1)) > A * (1.0 + ROUNDING_A) + 1e-4:
        return False
    if (abs(jerk) - J) * t > ROUNDING_J * J * period:
        return False
    top = max(v0, v1)
    if a0 > 0.0 > a1:
        top = v0 - a0 * a0 / (2.0 * jerk)
    return bool(top <= r["v_limit"] * (1.0 + ROUNDING_V) + ROUNDING_V)


@kernel
def is_motion(s: float, v: float, a: float, jerk: float, t: float, s1: float, v1: float, a1: float) -> bool:
    """Whether constant jerk leads from one row to the next, but for rounding, and never backwards."""
    if abs(a + jerk * t - a1) > 1e-3 or abs(v + a * t + jerk * t * t / 2.0 - v1) > 1e-5 or s1 < s or v1 < 0.0:
        return False
    if abs(s + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0 - s1) > 1e-6:
        return False
    # a least velocity within the piece
    return not (a < 0.0 < a1 and v - a * a / (2.0 * jerk) < -1e-5)


@kernel
def keeps_limits(
    records: Records,
    written: int,
    cur: int,
    s_in: float,
    opened: int,
    single: int,
    plan: Floats,
    rows: int,
    period: float,
    hold: bool,
) -> bool:
    """Whether a plan from `s_in` in record `cur` ends standing, before the first closed gate, `single` (the end of a
    block, -1: none) and the end of what is known, and keeps v, a, j of every element and the speed of every corner.

    `hold`: it brakes for feed hold, which may have limits of its own."""
    size = records.shape[0]
    last = rows - 1
    if plan[last, SPEED_AT] != 0.0 or plan[last, ACCELERATION_AT] != 0.0:
        return False
    end = plan[last, WAY]
    e = cur
    r = records[e % size]
    if r["kind"] > POLYNOMIAL:
        return bool(end <= 0.0)
    border = r["length"] - s_in
    leapt = 0.0  # greatest acceleration of a jump in the corner that comes
    for row in range(last):
        s, v, a, jerk = plan[row, WAY], plan[row, SPEED_AT], plan[row, ACCELERATION_AT], plan[row, JERK_AT]
        time = plan[row + 1, TIME] - plan[row, TIME]
        s1, v1, a1 = plan[row + 1, WAY], plan[row + 1, SPEED_AT], plan[row + 1, ACCELERATION_AT]
        if time == 0.0:
            if abs(s - border) > LEAP_AT or abs(s1 - s) > LEAP_AT or v1 != v or a > 0.0:
                return False
            leapt = max(leapt, max(abs(a), abs(a1)))
            continue
        if not is_motion(s, v, a, jerk, time, s1, v1, a1):
            return False
        t0, v0, a0 = 0.0, v, a
        while s1 > border + AT_BORDER and end > border + NEAR:
            if s < border - AT_BORDER:
                t = crossing(border - s, v, a, jerk, time)
                v_t, a_t = v + a * t + jerk * t * t / 2.0, a + jerk * t
                if not part_keeps(r, jerk, t - t0, v0, a0, v_t, a_t, period, hold):
                    return False
                t0, v0, a0 = t, v_t, a_t
            if e == single:
                return False
            e += 1
            while e < written and records[e % size]["kind"] > POLYNOMIAL:
                if e == single or (records[e % size]["kind"] == GATE and e > opened):
                    return False
                e += 1
            if e >= written:
                return False
            r = records[e % size]
            # at a corner with standstill 1e-9 mm are already some 1e-4 mm/s: v = ∛J (6 s)^⅔ / 2
            if (
                v0 > r["v_entry"] + ROUNDING_V
                and v0 > 0.5 * most_acceleration(r["j_limit"], r["j_hold"], hold) ** (1.0 / 3.0) * 3e-4
            ):
                return False
            if leapt > r["a_entry"] * (1.0 + ROUNDING_A):
                return False
            leapt = 0.0
            border += r["length"]
        if not part_keeps(r, jerk, time - t0, v0, a0, v1, a1, period, hold):
            return False
    return True
