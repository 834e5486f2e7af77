"""How one cycle is driven: as fast as every constraint ahead allows, with bounded jerk. Kernels.

State on the path: s (mm from where the cycle began), v, a. Ahead lie constraints, each a place d and what must hold
there:

      v ▲            NOW: the speed wanted at this moment (feed × override, 0 in feed hold); d = 0
        │ ─────╮
        │       ╲    SPEED: at d the path velocity must not exceed x (corner); SLOWER: from d on; FEED: it should not
        │        ╲___o          in a corner the acceleration may jump up to B: braking there ends with B, not with 0
        │             ╲   STOP: at d the path stands (closed gate, end of what is known)
        └──────────────●──▶ s          REDUCE: at d the acceleration must not exceed x (an element with less of it)

The braking to a constraint is the third-order one: jerk -J down to -A, hold, jerk +J so that v = x and a = 0 are
reached together. Its length has a closed form, so nothing needs a grid: `slack` = d - braking distance, and a state
is safe when no slack is negative. For limits that don't grow towards the far constraints (the look-ahead sees to
that) this is sufficient for all of them together: braking for the slowest one stays below the braking curves of all
others.

A cycle is cut where the jerk changes:  accelerate with +J until some slack is 0 (found by bisection: slack falls
steadily while accelerating), from there follow that constraint's braking through its exact switching times, until it is
fulfilled, and so on. Braking curves are thus followed without chatter, and a stop lands on its place.

Constraints that can't be met (override just lowered, feed hold) only have the effect that the hardest permitted
braking is chosen.

This holds while a braking is carried through. One that is taken back in its middle just before an element with far
less acceleration or jerk may leave too little way to take it back: what is driven is therefore proven first (`plan`).

Units: mm, s (degrees where only rotary axes move).
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.plan import ACCELERATION_AT, SPEED_AT, WAY, add, leap
from runtime.kernels import kernel

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

# kinds of constraints
NOW, SPEED, STOP, REDUCE, SLOWER, FEED, BORDER, PLACE = 0, 1, 2, 3, 4, 5, 6, 7

TOLERANCE = 1e-11  # mm of slack taken as zero
STEPS = 32  # pieces of one cycle; a few are used
ARRIVED = 1e-7  # mm: standing so near to a stop is standing on it
AT_CORNER = 1e-7  # mm: so near to a corner the path is in it
NEVER = 1e30


@kernel
def reduce_distance(v: float, a: float, x: float, J: float) -> float:
    """Way while the acceleration falls from `a` to `x` ≤ a with jerk -J."""
    t = (a - x) / J
    return v * t + a * t * t / 2.0 - J * t * t * t / 6.0


@kernel
def brake_distance(v: float, a: float, target: float, A: float, J: float) -> float:
    """Way until velocity `target` is reached with zero acceleration, braking with at most A and J.

    A positive `a` is taken back first. A negative one is understood as the middle of a braking that began at v +
    a²/2J with zero acceleration: the length of the whole, less the part that lies behind. If the velocity is already
    below what the taking back of `a` needs, the distance is that of taking it back.
    """
    way = 0.0
    if a > 0.0:
        way = reduce_distance(v, a, 0.0, J)
        v += a * a / (2.0 * J)
        a = 0.0
    if a < 0.0 and target < v <= target + a * a / (2.0 * J):  # nothing but taking back is left
        t = -a / J
        return max(way + v * t - J * t * t * t / 3.0, 0.0)
    if -a > A:  # more than is allowed up to there: back to A first
        t = (-a - A) / J
        way += v * t + a * t * t / 2.0 + J * t * t * t / 6.0
        v += a * t + J * t * t / 2.0
        a = -A
    t_a = -a / J
    top = v + a * a / (2.0 * J)
    drop = top - target
    if drop <= 0.0:
        return way
    if drop <= A * A / J:
        t = 2.0 * math.sqrt(drop / J)
    else:
        t = drop / A + A / J
    return way + (top + target) / 2.0 * t - (top * t_a - J * t_a * t_a * t_a / 6.0)


@kernel
def corner_distance(v: float, a: float, x: float, most: float, A: float, J: float) -> float:
    """Way until velocity `x` < v is reached, braking with at most A and J and at the end with at most `most` ≤ A."""
    way = 0.0
    if a > 0.0:
        way = reduce_distance(v, a, 0.0, J)
        v += a * a / (2.0 * J)
        a = 0.0
    if -a > A:
        t = (-a - A) / J
        way += v * t + a * t * t / 2.0 + J * t * t * t / 6.0
        v += a * t + J * t * t / 2.0
        a = -A
    if v <= x + max(a * a - most * most, 0.0) / (2.0 * J):  # nothing but taking back is left
        t = max(-a - most, 0.0) / J
        return way + v * t + a * t * t / 2.0 + J * t * t * t / 6.0
    drop = v + a * a / (2.0 * J) - x
    peak = math.sqrt(2.0 * drop * J)
    back, hold = 0.0, 0.0
    if peak > most:
        peak = math.sqrt(drop * J + most * most / 2.0)
        if peak > A:
            hold = (drop + most * most / (2.0 * J)) / A - A / J
            peak = A
        back = (peak - most) / J
    t = (peak + a) / J
    way += v * t + a * t * t / 2.0 - J * t * t * t / 6.0
    v += a * t - J * t * t / 2.0
    way += v * hold - peak * hold * hold / 2.0
    v -= peak * hold
    return way + v * back - peak * back * back / 2.0 + J * back * back * back / 6.0


@kernel
def time_to(way: float, v: float, a: float, jerk: float, most: float) -> float:
    """Time at which `way` has just been covered; at `most` it has."""
    low, high = 0.0, most
    for _ in range(60):
        t = (low + high) / 2.0
        if v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0 < way:
            low = t
        else:
            high = t
        if high - low < 1e-14:
            break
    return high


@kernel
def can_release(d: float, A: float, J: float, J_before: float, v: float, a: float) -> bool:
    """Whether a braking (a < 0) can be taken back over a border at d: at most A is left there, J ends it at v ≥ 0."""
    t = -a / J_before
    if v * t - J_before * t * t * t / 3.0 <= d:
        return True
    t = time_to(d, v, a, J_before, t)
    v += a * t + J_before * t * t / 2.0
    a += J_before * t
    return -a <= A and a * a <= 2.0 * J * v


@kernel
def slack(kind: int, d: float, x: float, A: float, J: float, B: float, v: float, a: float, period: float) -> float:
    """How far the state is from having to react to a constraint, mm; negative: it can't be met any more.

    Where the velocity stays below x anyway, or the acceleration below x, the slack is made of what is missing to x
    (times the period), so that it reaches zero together with it. `B` is the jerk behind d (SLOWER) or at present (NOW), or
    the acceleration that may jump at d (SPEED).
    """
    if kind == REDUCE:
        if a <= x:
            return max(d, 0.0) + (x - a) * period * period
        return d - reduce_distance(v, a, x, J)
    if kind == PLACE:
        return d
    if kind == NOW:
        top = v + a * a / (2.0 * B) if a > 0.0 else v
        return (x - top) * period if top <= x else -brake_distance(v, a, x, A, J)
    top = v + a * a / (2.0 * J) if a > 0.0 else v
    if top <= x:
        if a > 0.0:
            left = d - reduce_distance(v, a, 0.0, J)
            if left < 0.0 and kind >= SLOWER and B < J:  # still accelerating behind d, where the jerk is less
                t = time_to(max(d, 0.0), v, a, -J, a / J)
                top = v + a * t - J * t * t / 2.0 + (a - J * t) * (a - J * t) / (2.0 * B)
            d = left
        if kind == BORDER and a > 0.0:
            return d  # over it without acceleration
        return max(d, 0.0) + (x - top) * period
    if kind == SPEED and B > 0.0:
        return d - corner_distance(v, a, x, B, A, J)
    return d - brake_distance(v, a, x, A, J)


@kernel
def reaction(kind: int, d: float, x: float, A: float, J: float, B: float, v: float, a: float) -> tuple[float, float]:
    """Jerk that a constraint without slack asks for, and for how long (s) before it asks for something else."""
    if kind == PLACE:
        return NEVER, NEVER
    if kind == REDUCE:
        if a - x > 1e-9 * x:
            return -J, (a - x) / J
        return 0.0, (max(d, 0.0) + TOLERANCE) / v if v > 1e-9 and kind != NOW else NEVER
    if a > 0.0:
        return (-B, a / B) if kind == NOW else (-J, a / J)
    if -a > A * 1.000001:
        return J, (-a - A) / J
    drop = v - x
    release = a * a / (2.0 * J)
    most = B if kind == SPEED else 0.0
    if most > 0.0:
        if drop > 1e-9 and drop + release <= most * most / (2.0 * J):
            return -J, (math.sqrt(a * a + 2.0 * J * drop) + a) / J
        drop += most * most / (2.0 * J)
    if drop > release + 1e-9:
        A = max(A, -a)  # rounding
        whole = drop + release
        if whole <= A * A / J:
            t = (math.sqrt(whole * J) + a) / J
            if t > 1e-10:
                return -J, t
        elif A + a > 1e-6:
            return -J, (A + a) / J
        else:
            t = (drop - release) / A
            if t > 1e-10:
                return 0.0, t
    if a < -most:
        return J, (-a - most) / J
    if a < 0.0 and d <= 0.0:
        return J, -a / J
    if (kind == SPEED or kind >= SLOWER) and v > 1e-9:
        return 0.0, (max(d, 0.0) + TOLERANCE) / v  # over the place, then it is behind
    return 0.0, NEVER


@kernel
def is_safe(
    count: int,
    kind: Ints,
    d: Floats,
    x: Floats,
    A: Floats,
    J: Floats,
    B: Floats,
    state: Ints,
    s: float,
    v: float,
    a: float,
    T: float,
) -> bool:
    """Whether no constraint with state 3 is violated at (s, v, a)."""
    for i in range(count):
        if state[i] == 3 and slack(kind[i], d[i] - s, x[i], A[i], J[i], B[i], v, a, T) < -TOLERANCE:
            return False
    return True


@kernel
def leap_to(
    at: int, count: int, kind: Ints, d: Floats, x: Floats, A: Floats, J: Floats, B: Floats, state: Ints,
    v: float, a: float, up: float, period: float,
) -> float:  # fmt: skip
    """To what the acceleration jumps in the corner of constraint `at`: as high as everything ahead allows, `a` at least."""
    if v > x[0]:  # braking for its own sake goes on, as far as it can still be taken back
        jerk = J[0]
        for i in range(1, count):
            if kind[i] == REDUCE and d[i] <= d[at] + AT_CORNER:
                jerk = min(jerk, A[i])
        return max(a, -math.sqrt(2.0 * jerk * v) * (1.0 - 1e-9))
    low, high = a, min(B[at], up)
    if high <= low:
        return a
    for step in range(40):
        middle = high if step == 0 else (low + high) / 2.0
        safe = True
        for i in range(count):
            if i == at or state[i] == 0:
                continue
            if slack(kind[i], d[i] - d[at], x[i], A[i], J[i], B[i], v, middle, period) < 0.0:
                safe = False
                break
        if safe:
            low = middle
            if step == 0:
                break
        else:
            high = middle
    return low


@kernel
def leap_ahead(
    count: int, kind: Ints, d: Floats, B: Floats, state: Ints, s: float, v: float, a: float, jerk: float
) -> int:
    """The watched corner in which the acceleration may jump and that is reached before `jerk` leads to standstill, 0: none."""
    t = (-a - math.sqrt(a * a - 2.0 * v * jerk)) / jerk
    reach = s + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
    for i in range(1, count):
        if kind[i] == SPEED and B[i] > 0.0 and state[i] != 0 and s < d[i] < reach:
            return i
    return 0


@kernel
def watch_cycle(
    T: float, v: float, a: float, A_up: float, J_up: float,
    count: int, kind: Ints, d: Floats, x: Floats, A: Floats, J: Floats, B: Floats, state: Ints,
) -> None:  # fmt: skip
    """Set `state` to 1 for what can come into effect in a cycle of T seconds from (0, v, a), else 0."""
    # Whatever happens in this cycle lies below accelerating with +J all the time: what is safe there needs no watching.
    # (Close to standstill a braking may have to be taken back with more jerk than J_up, see below.)
    a_top = a + J_up * T
    if a < 0.0 and 2.0 * v * J_up < 4.0 * a * a:
        a_top = J_up * T
    v_top = v + max(a_top, 0.0) * T
    s_top = v_top * T
    leap = 0.0
    for i in range(1, count):
        if kind[i] == SPEED and d[i] <= s_top + 1e-6:
            leap = max(leap, B[i])
    if leap > a_top:
        a_top = leap + J_up * T
        v_top = v + a_top * T
        s_top = v_top * T
    for i in range(count):
        near = i == 0 or slack(kind[i], d[i] - s_top, x[i], A[i], J[i], B[i], v_top, a_top, T) <= TOLERANCE
        near = near or (kind[i] == SPEED and B[i] > 0.0 and d[i] <= s_top + 1e-6)
        state[i] = 1 if near else 0


@kernel
def drive(
    T: float,
    count: int,
    kind: Ints,
    d: Floats,
    x: Floats,
    A: Floats,
    J: Floats,
    B: Floats,
    state: Ints,
    up: Floats,
    period: float,
    until: float,
    plan: Floats,
    rows: int,
) -> tuple[int, int, float]:
    """Drive T seconds from the end of `plan`, or until the path stands (T = NEVER), or to a BORDER; add it to `plan`.

    Returns the number of rows of the plan, the constraint that braked (-1: none), and the time that is left.

    Constraints in the order of d, the first is NOW. `state` says what is watched: 0 out of reach or behind,
    1 watched; 2 binding and 3 violated at the end of a piece are for use in here. `up`: (A, J) of the element here for
    accelerating; it is brought up to date at borders. `until`: a place where a piece has to end.
    More time is left than was asked for if the motion needs more than `STEPS` pieces (none is known).
    """
    s, v, a = plan[rows - 1, WAY], plan[rows - 1, SPEED_AT], plan[rows - 1, ACCELERATION_AT]
    A_up, J_up = up[0], up[1]
    left = T
    braked = -1
    border = 1  # the next REDUCE
    for _ in range(STEPS if T < NEVER else 3 * STEPS):
        while border < count and (kind[border] != REDUCE or d[border] - s <= TOLERANCE):
            if kind[border] == REDUCE:
                A_up, J_up = min(A_up, x[border]), min(J_up, A[border])
                B[0] = min(B[0], J_up)
            border += 1
        if T >= NEVER and v == 0.0 and a == 0.0:
            break
        for i in range(1, count):
            there = kind[i] == SPEED and state[i] != 0 and B[i] > 0.0 and -5e-10 < d[i] - s <= AT_CORNER
            if there and v <= x[i] + 5e-7 and a <= 0.0 and -a <= B[i] * (1.0 + 1e-9):
                state[i] = 0
                a_then = leap_to(i, count, kind, d, x, A, J, B, state, v, a, A_up, period)
                if a_then > a:
                    s, a = d[i], a_then
                    rows = leap(plan, rows, s, v, a)
        jerk, t = NEVER, NEVER
        crossed, braked_by_wish = False, False
        for i in range(count):
            if state[i] == 0:
                continue
            way = d[i] - s
            if v == 0.0 and a == 0.0 and kind[i] != NOW and kind[i] != REDUCE and 0.0 < way < ARRIVED:
                s = d[i]  # standing before a full stop by a rounding error
                way = 0.0
            # Behind; a full stop in a corner only once the path has stood, whatever 1e-9 mm say.
            done = v <= x[i] + 1e-6 * min(x[i], 1.0) or way < -1e-6 or kind[i] == REDUCE or kind[i] == PLACE
            if (way <= TOLERANCE and kind[i] == PLACE) or (way <= 0.0 and kind[i] != NOW and kind[i] != STOP and done):
                state[i] = 0  # behind
                if kind[i] == BORDER:
                    crossed = True
                elif kind[i] >= SLOWER:
                    x[0] = min(x[0], x[i])
                continue
            if slack(kind[i], way, x[i], A[i], J[i], B[i], v, a, period) > TOLERANCE:
                state[i] = 1
                continue
            state[i] = 2
            jerk_i, t_i = reaction(kind[i], way, x[i], A[i], J[i], B[i], v, a)
            if braked_by_wish and jerk_i < NEVER and kind[i] != REDUCE:
                jerk, t, braked, braked_by_wish = jerk_i, t_i, i, False
            elif jerk_i < jerk or (jerk_i == jerk and t_i < t):
                jerk, t, braked = jerk_i, t_i, i
                # NOW takes a braking back with the least jerk of what it crosses; who has to, knows better when.
                braked_by_wish = i == 0 and a < 0.0 and jerk > 0.0
        if crossed:
            break
        if jerk >= NEVER:  # nothing binds: faster
            braked = -1
            if a < A_up:
                jerk, t = J_up, (A_up - a) / J_up
            elif a > A_up * 1.000001:
                jerk, t = -J_up, (a - A_up) / J_up
            else:
                jerk, t = 0.0, NEVER
        elif jerk >= 0.0 and a > A_up * 1.000001:
            jerk, t = -J_up, (a - A_up) / J_up
        if a < 0.0 and jerk > 0.0 and v > 0.0 and 2.0 * v * jerk < a * a:
            corner = leap_ahead(count, kind, d, B, state, s, v, a, jerk)
            if corner > 0:  # there the braking is taken back at once
                t = min(t, time_to(d[corner] - s, v, a, jerk, -a / jerk))
            else:
                # Braked with more jerk than is left here to take the braking back: a border came between. Not backwards.
                jerk = a * a / (2.0 * v)
                t = -a / jerk
        t = min(t, left)
        if border < count:  # no further than to where less jerk is allowed
            reach = s + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
            for i in range(border, count):
                if d[i] >= reach:
                    break
                if kind[i] == REDUCE and A[i] < abs(jerk):
                    t = time_to(d[i] - s, v, a, jerk, t)
                    break
        if a < 0.0:  # no further than to where the acceleration may jump
            reach = s + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
            for i in range(1, count):
                if kind[i] == SPEED and B[i] > 0.0 and state[i] != 0 and s + AT_CORNER < d[i] < reach:
                    t = time_to(d[i] - s, v, a, jerk, t)
                    break
        if s < until - TOLERANCE and s + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0 > until:
            t = time_to(until - s, v, a, jerk, t)
        v_t = v + a * t + jerk * t * t / 2.0
        s_t = s + v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
        # Slack changes in one direction within a piece: only what is violated at its end can be violated in it.
        violated = 0
        for i in range(count):
            if (
                state[i] == 1
                and slack(kind[i], d[i] - s_t, x[i], A[i], J[i], B[i], v_t, a + jerk * t, period) < -TOLERANCE
            ):
                state[i] = 3
                violated += 1
        if violated > 0:
            low, high = 0.0, t
            while high - low > 1e-16:
                middle = (low + high) / 2.0
                if middle <= low or middle >= high:
                    break
                v_t = v + a * middle + jerk * middle * middle / 2.0
                s_t = s + v * middle + a * middle * middle / 2.0 + jerk * middle * middle * middle / 6.0
                if is_safe(count, kind, d, x, A, J, B, state, s_t, v_t, a + jerk * middle, period):
                    low = middle
                else:
                    high = middle
            t = low
        s += v * t + a * t * t / 2.0 + jerk * t * t * t / 6.0
        v += a * t + jerk * t * t / 2.0
        a += jerk * t
        if abs(a) < 1e-6:
            a = 0.0
            if braked >= 0 and kind[braked] != REDUCE and abs(v - x[braked]) < 1e-6:
                v = x[braked]
        if v < 0.0 or (v < 1e-9 and a <= 0.0):
            v, a = 0.0, 0.0
        rows = add(plan, rows, t, jerk, s, v, a)
        left -= t
        if left <= 1e-12:
            break
    up[0], up[1] = A_up, J_up
    return rows, braked, left
