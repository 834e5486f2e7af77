"""The look-ahead: from the records in the queue to the constraints that the velocity profile has to keep. Kernels.

    cur                                        horizon                    written
     ▼                                            ▼                          ▼
     ══════╪═══╪════════╪══════════╪══════╪═══════╪═══════╪═══════╪══════════╪
       s   corner    slower     gate                                  end of what is known: v = 0
     ├── as far as a braking from here can reach, and some cycles more ──┤

In every cycle the elements ahead are walked once, as far as braking can reach from the fastest state of this cycle (a
few hundred at most, one comparison each). Only what is slower than everything before it becomes a constraint; the
limits (A, J) of a constraint are the smallest of all elements up to it, so that a braking may run across any borders.

New elements are taken into the plan only if the present state is safe with them; until then the plan ends, with v =
0, where it ended before. So a plan that was safe stays safe whatever the preparation appends.

Where the limits fall sharply (a line runs into a small arc) the smallest of all elements would be a bad judge of the
braking before: the path is then also looked at in zones. Each zone counts with its own limits, and what lies in it
and behind becomes one number, the speed at which its border may be crossed with zero acceleration:

     ── zone 0: A 4000 ───▌─ zone 1: A 400 ─▌── zone 2 ──       v(1) = least over k in zone 1 of the speed from which
                          v(1)              v(2)                     x_k is reached within d_k - d(1), and so for v(2)

A cycle takes the faster of both views. Whether what comes of it keeps all limits is not left to them: see `plan`.
"""

from __future__ import annotations

import math

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.plan import most_acceleration
from runtime.cnc.interpolator.profile import (
    BORDER,
    FEED,
    NOW,
    PLACE,
    REDUCE,
    SLOWER,
    SPEED,
    STOP,
    brake_distance,
    can_release,
    slack,
)
from runtime.cnc.motion_queue import Records
from runtime.kernels import kernel

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ELEMENTS = 2048  # records walked in a cycle at most
CONSTRAINTS = 4 * ELEMENTS + 16
ZONES = 32  # borders seen in a cycle at most
SHARP = 0.8  # limits that fall below this share of those before begin a zone
MARGIN = 16.0  # cycles of travel that the look-ahead sees beyond the braking distance

# orders of operator and PLC: shares, and mm/s of an external feed, negative: none; and what the spindles turn with, rev/min
OVERRIDE, RAPID_OVERRIDE, EXTERNAL_FEED, TURNING = 0, 1, 2, 3
SPINDLES = 6  # of a channel, at most
ORDERS = TURNING + SPINDLES

LINE, ARC, POLYNOMIAL, FUNCTION, GATE, BLOCK_END = 0, 1, 2, 3, 4, 5  # motion up to POLYNOMIAL


@kernel
def wanted_speed(rapid: int, feed: float, external: float, spindle: int, v_limit: float, orders: Floats) -> float:
    """Path velocity wanted on an element: the override scales feed within the limits, and rapid up to 100 %.

    `orders` (ORDERS,) are those of the operator; a feed of the PLC takes the place of the programmed one, `external` of it.
    Below 0 `external` is the speed of `spindle`, rev/min, that a feed per revolution was made with.
    """
    share: float = orders[OVERRIDE]
    if orders[EXTERNAL_FEED] >= 0.0 and external != 0.0:
        feed = orders[EXTERNAL_FEED] * (external if external > 0.0 else 1.0)
    elif external < 0.0:
        feed *= orders[TURNING + spindle] / -external
    elif rapid == 1:
        share = orders[RAPID_OVERRIDE]
        return v_limit * min(share, 1.0)
    return min(feed * share, v_limit)


# places
HORIZON, SINGLE_GATE, KNOWN_END, SEEN = 0, 1, 2, 3
SHARPLY, VALID, WHOLE, BEHIND, RELEASED = 4, 5, 6, 7, 8


@kernel
def entry_speed(d: float, x: float, A: float, J: float) -> float:
    """Greatest velocity, with zero acceleration, from which `x` can be reached within `d`.

    The inverse of `brake_distance` at a = 0. With u² the drop of velocity: (2x + u²) u = d √J while A is not reached
    (Newton from above converges steadily, the left side is convex), else (2x + u²) (u²/A + A/J) = 2d.
    """
    root = d * math.sqrt(J)
    u = math.pow(root, 1.0 / 3.0)
    for _ in range(30):
        step = (u * u * u + 2.0 * x * u - root) / (3.0 * u * u + 2.0 * x + 1e-300)
        u -= step
        if step < 1e-12 * u:
            break
    if u * u <= A * A / J:
        return x + max(u * u * (1.0 - 1e-9) - 1e-12, 0.0)
    b = 2.0 * x + A * A / J
    c = 2.0 * d * A - 2.0 * x * A * A / J
    return x + max(((math.sqrt(b * b + 4.0 * c) - b) / 2.0) * (1.0 - 1e-9), 0.0)


@kernel
def collect(
    records: Records,
    written: int,
    last: int,
    cur: int,
    s_in: float,
    v: float,
    a: float,
    period: float,
    orders: Floats,
    hold: bool,
    opened: int,
    single_block: bool,
    planned: float,
    zones: bool,
    places: Ints,
    kind: Ints,
    d: Floats,
    x: Floats,
    A: Floats,
    J: Floats,
    B: Floats,
    zone: Ints,
    up: Floats,
    borders: Floats,
) -> int:
    """Walk the records from `cur` to before `last`; fill the constraints and return their number, 0 without motion."""
    size = records.shape[0]
    count = 0
    here = 0  # zone
    way = 0.0
    A_least, J_least = np.inf, np.inf
    fastest, least_wanted, slowest_corner = np.inf, np.inf, np.inf  # what constraints so far allow
    need = 0.0
    top, v_top, v_most, a_top = 0.0, 0.0, 0.0, 0.0
    places[KNOWN_END], places[SHARPLY] = -1, 0
    fall, A_to, J_to = np.inf, np.inf, np.inf  # where the limits fall sharply for the first time, and those up to there
    stopped = False
    moving = False
    e = cur
    while e < last:
        r = records[e % size]
        what = r["kind"]
        if what <= POLYNOMIAL:
            wanted = 0.0 if hold else wanted_speed(
                r["rapid"], r["feed"], r["external"], r["spindle"], r["v_limit"], orders
            )  # fmt: skip
            a_most = most_acceleration(r["a_limit"], r["a_hold"], hold)
            j_most = most_acceleration(r["j_limit"], r["j_hold"], hold)
            if not moving:
                moving = True
                kind[0], d[0], x[0], zone[0] = NOW, 0.0, wanted, 0
                A[0], J[0] = a_most, j_most
                count = 1
                fastest, least_wanted = r["v_limit"], wanted
                B[0] = j_most
                if hold and r["a_hold"] > 0.0:  # which may be the gentler one, too
                    A[0], J[0], B[0] = r["a_hold"], r["j_hold"], r["j_hold"]
                up[0], up[1] = a_most, j_most
                A_least, J_least = a_most, j_most
                a_top = max(a, 0.0) + J_least * period
                v_top = v_most = v + a_top * period
                top = v_top + a_top * a_top / (2.0 * J_least)
                need = brake_distance(v_top, a_top, 0.0, A_least, J_least) + v_top * period * MARGIN
                way = r["length"] - s_in
            else:
                J_then = min(J_least, j_most)
                less = J_then < J_least
                peak = v_top + a_top * a_top / (2.0 * J_then)
                if r["v_limit"] < fastest or less:
                    fastest = min(fastest, r["v_limit"])
                    if fastest < peak:
                        kind[count], d[count], x[count], zone[count] = SLOWER, way, fastest, here
                        A[count], J[count], B[count] = A_least, J_least, J_then
                        count += 1
                if r["brake_late"] == 1:  # its feed is reached behind the border: it counts once the path is on it
                    wanted = max(wanted, least_wanted)
                if not hold and (wanted < least_wanted or less):
                    least_wanted = min(least_wanted, wanted)
                    if least_wanted < peak and least_wanted < fastest:
                        kind[count], d[count], x[count], zone[count] = FEED, way, least_wanted, here
                        A[count], J[count], B[count] = A_least, J_least, J_then
                        count += 1
                if r["v_entry"] < slowest_corner:
                    slowest_corner = r["v_entry"]
                    if slowest_corner < top and slowest_corner < fastest:
                        kind[count], d[count], x[count], zone[count] = SPEED, way, slowest_corner, here
                        A[count], J[count] = A_least, J_least
                        B[count] = min(r["a_entry"], min(A_least, a_most)) if slowest_corner > 0.0 else 0.0
                        if B[count] > 0.0:  # behind it the path may be faster at once
                            slowest_corner = np.inf
                            if here == 0 and B[count] > a_top and way <= 2.0 * v_top * period:
                                a_top = B[count] + J_least * period
                                v_top = v_most = v_most + a_top * period
                                top = v_top + a_top * a_top / (2.0 * J_least)
                                need = brake_distance(v_top, a_top, 0.0, A_least, J_least) + v_top * period * MARGIN
                        count += 1
                sharp = a_most < SHARP * A_least or j_most < SHARP * J_least
                if a_most < A_least or j_most < J_least:
                    J_before, A_before = J_least, A_least
                    A_least, J_least = min(A_least, a_most), min(J_least, j_most)
                    kind[count], d[count], x[count], zone[count] = REDUCE, way, A_least, here
                    A[count], J[count] = J_least, J_before
                    count += 1
                    top = v_top + a_top * a_top / (2.0 * J_least)
                    need = brake_distance(v_most, a_top, 0.0, A_least, J_least) + v_most * period * MARGIN
                    if sharp:
                        places[SHARPLY] = 1
                        if way < fall:
                            fall, A_to, J_to = way, A_before, J_before
                    if sharp and zones:
                        if here + 1 >= ZONES:
                            break
                        here += 1
                        # d, A and J of the zone before, its own speed (hard, wanted), number of its first constraint
                        borders[here, 0], borders[here, 1], borders[here, 2] = way, A_before, J_before
                        borders[here, 3] = min(r["v_limit"], r["v_entry"])
                        borders[here, 4] = min(wanted, borders[here, 3])
                        borders[here, 5] = count
                        A_least, J_least = a_most, j_most
                        fastest, least_wanted, slowest_corner = r["v_limit"], wanted, np.inf
                        top = np.inf  # whatever comes counts for the speed at the border
                        v_top = np.inf
                way += r["length"]
        gate = what == GATE and e > opened
        if single_block and e > places[RELEASED] and (what == BLOCK_END or r["block_end"] == 1):
            possible = moving and (way <= 0.0 or brake_distance(v, a, 0.0, A_least, J_least) <= way)
            if moving and not possible and fall < way:
                over = min(entry_speed(way - fall, 0.0, A_least, J_least), min(fastest, slowest_corner))
                possible = brake_distance(v, a, min(over, v), A_to, J_to) <= fall
            if places[SINGLE_GATE] < 0 and possible and way >= planned - 1e-7:
                places[SINGLE_GATE] = e  # the first block end where stopping is possible
            gate = gate or e == places[SINGLE_GATE]
        if gate:
            stopped = True
            e += 1
            break
        e += 1
        if moving and way > need:
            break
    if not moving:
        return 0
    places[SEEN] = e
    if stopped or e >= last or way <= need:
        kind[count], d[count], x[count], zone[count] = STOP, way, 0.0, here
        A[count], J[count] = A_least, J_least
        if not stopped and e >= written and here == 0:
            places[KNOWN_END] = count
        count += 1
    places[BEHIND] = here
    if here > 0:
        borders[here + 1, 0], borders[here + 1, 1], borders[here + 1, 2] = np.inf, A_least, J_least
        count = fold_zones(here, count, hold, kind, d, x, A, J, B, zone, borders)
    return count


@kernel
def fold_zones(
    zones: int,
    count: int,
    hold: bool,
    kind: Ints,
    d: Floats,
    x: Floats,
    A: Floats,
    J: Floats,
    B: Floats,
    zone: Ints,
    borders: Floats,
) -> int:
    """Put a border with its crossing speed in the place of all constraints behind zone 0; returns the new number."""
    end = count
    for z in range(zones, 0, -1):
        start, begin = borders[z, 0], int(borders[z, 5])
        hard, wanted = borders[z, 3], borders[z, 4]
        for k in range(begin, end):
            if kind[k] == REDUCE:
                continue
            allowed = entry_speed(max(d[k] - start, 0.0), x[k], borders[z + 1, 1], borders[z + 1, 2])
            wanted = min(wanted, allowed)
            if kind[k] != FEED:
                hard = min(hard, allowed)
        if z < zones:
            way = borders[z + 1, 0] - start
            hard = min(hard, entry_speed(way, borders[z + 1, 3], borders[z + 1, 1], borders[z + 1, 2]))
            wanted = min(min(wanted, hard), entry_speed(way, borders[z + 1, 4], borders[z + 1, 1], borders[z + 1, 2]))
        borders[z, 3], borders[z, 4] = hard, min(wanted, hard)
        end = begin
    count = int(borders[1, 5])
    kind[count], d[count], x[count], zone[count] = BORDER, borders[1, 0], borders[1, 3], 0
    A[count], J[count], B[count] = borders[1, 1], borders[1, 2], borders[1, 2]
    count += 1
    if not hold and borders[1, 4] < borders[1, 3]:
        kind[count], d[count], x[count], zone[count] = FEED, borders[1, 0], borders[1, 4], 0
        A[count], J[count], B[count] = borders[1, 1], borders[1, 2], borders[1, 2]
        count += 1
    return count


@kernel
def yield_to_lower(
    count: int, kind: Ints, d: Floats, x: Floats, A: Floats, J: Floats, B: Floats, v: float, a: float, period: float
) -> bool:
    """Take constraints out of the way of lower ones; returns whether all were met as they were.

    To be at x with zero acceleration can take more way than to be at less than x: the braking has to be taken back
    earlier. So of several constraints at one place only the lowest counts (the others keep what they mean behind it:
    PLACE). And where x can't be met, but standing still there can, that is done.
    """
    as_they_were = True
    for i in range(1, count):
        if kind[i] == REDUCE or kind[i] == STOP:
            continue
        for k in range(max(i - 4, 1), min(i + 5, count)):
            lower = kind[k] == SPEED or kind[k] == BORDER or kind[k] == STOP or kind[k] == SLOWER
            if kind[i] == FEED and (kind[k] == FEED or not lower):
                continue
            if k != i and lower and d[k] == d[i] and (x[k] < x[i] or (x[k] == x[i] and k > i)):
                kind[i] = PLACE
                break
        if kind[i] == PLACE or kind[i] == FEED or x[i] == 0.0:
            continue
        least = 0.0 if kind[i] == SPEED else B[i]
        if (
            slack(kind[i], d[i], x[i], A[i], J[i], B[i], v, a, period) < -1e-8
            and slack(kind[i], d[i], 0.0, A[i], J[i], least, v, a, period) >= -1e-8
        ):
            x[i], B[i] = 0.0, least
            as_they_were = False
    return as_they_were


@kernel
def all_safe(
    count: int, kind: Ints, d: Floats, x: Floats, A: Floats, J: Floats, B: Floats, v: float, a: float, period: float
) -> bool:
    """Whether the state keeps all constraints but wishes (NOW, FEED)."""
    for i in range(1, count):
        if kind[i] == FEED or kind[i] == PLACE:
            continue
        if slack(kind[i], d[i], x[i], A[i], J[i], B[i], v, a, period) < -1e-8:
            return False
        if kind[i] == REDUCE and a < 0.0 and not can_release(d[i], x[i], A[i], J[i], v, a):
            # Taking the braking back now comes too late; but braking on, to a speed in front of it, may end in time: its slack
            # says that it is reached without acceleration.
            ends = False
            for k in range(1, count):
                slows = kind[k] == SPEED or kind[k] == SLOWER or kind[k] == BORDER or kind[k] == STOP
                ends = ends or (slows and d[k] <= d[i] and v > x[k])
            if not ends:
                return False
    return True


@kernel
def look_ahead(
    records: Records,
    written: int,
    cur: int,
    s_in: float,
    v: float,
    a: float,
    period: float,
    orders: Floats,
    hold: bool,
    opened: int,
    single_block: bool,
    planned: float,
    zones: bool,
    places: Ints,
    kind: Ints,
    d: Floats,
    x: Floats,
    A: Floats,
    J: Floats,
    B: Floats,
    zone: Ints,
    up: Floats,
    borders: Floats,
) -> int:
    """Fill the constraints seen from `s_in` in record `cur`; returns their number, 0 if no motion is known.

    `places`: [HORIZON] the accepted horizon (absolute index), [SINGLE_GATE] the gate of single block or -1,
    [RELEASED] the last block end at which the operator said continue,
    [KNOWN_END] becomes the constraint that is the end of what is known or -1, [SHARPLY] whether there are zones,
    [VALID] whether the state is safe, [WHOLE] whether it is with all that was seen, [BEHIND] how many zones lie behind
    the first. `up` becomes (A, J) for accelerating in this cycle. `planned`: way to the end of the plan being driven,
    mm; single block closes no gate in front of it. `borders` becomes the zones: d where it begins, least A and J of the
    zone before, speed at which its border may be crossed, the speed wanted there, its first constraint.
    """
    old = places[HORIZON]
    last = min(written, cur + ELEMENTS)
    count = collect(
        records, written, last, cur, s_in, v, a, period, orders, hold, opened, single_block, planned, zones,
        places, kind, d, x, A, J, B, zone, up, borders,
    )  # fmt: skip
    if count == 0:
        return 0
    whole = yield_to_lower(count, kind, d, x, A, J, B, v, a, period)
    safe = all_safe(count, kind, d, x, A, J, B, v, a, period)
    places[WHOLE] = 1 if whole and safe else 0
    sharply = places[SHARPLY]
    if not safe and cur < old < places[SEEN]:
        again = collect(
            records, written, old, cur, s_in, v, a, period, orders, hold, opened, single_block, planned, zones,
            places, kind, d, x, A, J, B, zone, up, borders,
        )  # fmt: skip
        if again > 0:
            count = again
            places[KNOWN_END] = -1
            yield_to_lower(count, kind, d, x, A, J, B, v, a, period)
            safe = all_safe(count, kind, d, x, A, J, B, v, a, period)
    places[SHARPLY] = sharply
    places[VALID] = 1 if safe else 0
    if safe:
        places[HORIZON] = places[SEEN]
    # A feed that comes too soon (the override has just changed) is braked for at once, as far as nothing forbids it.
    for i in range(1, count):
        if kind[i] == FEED and slack(FEED, d[i], x[i], A[i], J[i], B[i], v, a, period) < -1e-8:
            x[0] = min(x[0], x[i])
            x[i] = np.inf
    # Braking for its own sake (feed hold, lower override) may cross borders: with the least of what it crosses.
    for i in range(1, count):
        if kind[i] == REDUCE:
            way = brake_distance(v, a, 0.0, A[0], J[0])
            if v > x[0]:
                way = max(way, brake_distance(v, a, x[0], A[0], J[0]))
            if d[i] > way - 1e-6:
                break
            A[0], J[0] = min(A[0], x[i]), min(J[0], A[i])
    return count
