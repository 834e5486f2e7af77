"""The look-ahead: from the records in the queue to the constraints that the velocity profile has to keep. Kernels.

    cur                                        horizon                    written
     ▼                                            ▼                          ▼
     ══════╪═══╪════════╪══════════╪══════╪═══════╪═══════╪═══════╪══════════╪
       s   corner    slower     gate                                  end of what is known: v = 0
     ├── as far as a braking from here can reach, and some cycles more ──┤

In every cycle the elements ahead are walked once, as far as braking can reach from the fastest state of this cycle (a
few hundred at most, one comparison each). Only what is slower than everything before it becomes a constraint; the limits
(A, J) of a constraint are the smallest of all elements up to it, so that a braking may run across any borders.

New elements are taken into the plan only if the present state is safe with them; until then the plan ends, with v = 0, where
it ended before. So a plan that was safe stays safe whatever the preparation appends.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.interpolator.profile import FEED, NOW, REDUCE, SLOWER, SPEED, STOP, brake_distance, can_release, slack
from runtime.cnc.motion_queue import Records
from runtime.kernels import kernel

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

ELEMENTS = 4096  # records walked in a cycle at most
CONSTRAINTS = 2 * ELEMENTS + 8
MARGIN = 16.0  # cycles of travel that the look-ahead sees beyond the braking distance

LINE, ARC, FUNCTION, GATE, BLOCK_END = 0, 1, 2, 3, 4


@kernel
def wanted_speed(rapid: int, feed: float, v_limit: float, override: float) -> float:
    """Path velocity wanted on an element: the override scales feed within the limits, and rapid up to 100 %."""
    if rapid == 1:
        return v_limit * min(override, 1.0)
    return min(feed * override, v_limit)


@kernel
def look_ahead(
    records: Records,
    written: int,
    cur: int,
    s_in: float,
    v: float,
    a: float,
    period: float,
    override: float,
    hold: bool,
    opened: int,
    single_block: bool,
    places: Ints,
    kind: Ints,
    d: Floats,
    x: Floats,
    A: Floats,
    J: Floats,
    B: Floats,
    index: Ints,
    up: Floats,
) -> int:
    """Fill the constraints seen from `s_in` in record `cur`; returns their number, 0 if no motion is known.

    `places` [0] is the accepted horizon (absolute index), [1] the gate of single block (-1: none), [2] becomes the constraint
    that is the end of what is known, -1 if it is out of reach; `up` becomes (A, J) for accelerating in this cycle.
    """
    size = records.shape[0]
    count = 0
    way = 0.0
    A_least, J_least = np.inf, np.inf
    fastest, least_wanted, slowest_corner = np.inf, np.inf, np.inf  # what constraints so far allow
    need = 0.0
    top, v_top, a_top = 0.0, 0.0, 0.0
    old_horizon = places[0]
    at_old = -1
    A_old, J_old, way_old = 0.0, 0.0, 0.0
    places[2] = -1
    stopped = False
    moving = False
    e = cur
    last = min(written, cur + ELEMENTS)
    while e < last:
        if e == old_horizon and moving:
            at_old = count
            A_old, J_old, way_old = A_least, J_least, way
        r = records[e % size]
        what = r["kind"]
        if what <= ARC:
            wanted = 0.0 if hold else wanted_speed(r["rapid"], r["feed"], r["v_limit"], override)
            if not moving:
                moving = True
                kind[0], d[0], x[0], index[0] = NOW, 0.0, wanted, e
                A[0], J[0] = r["a_limit"], r["j_limit"]
                count = 1
                fastest, least_wanted = r["v_limit"], wanted
                B[0] = r["j_limit"]
                up[0], up[1] = r["a_limit"], r["j_limit"]
                A_least, J_least = r["a_limit"], r["j_limit"]
                a_top = max(a, 0.0) + J_least * period
                v_top = v + a_top * period
                top = v_top + a_top * a_top / (2.0 * J_least)
                need = brake_distance(v_top, a_top, 0.0, A_least, J_least) + v_top * period * MARGIN
                way = r["length"] - s_in
            else:
                J_then = min(J_least, r["j_limit"])
                less = J_then < J_least
                peak = v_top + a_top * a_top / (2.0 * J_then)
                if r["v_limit"] < fastest or less:
                    fastest = min(fastest, r["v_limit"])
                    if fastest < peak:
                        kind[count], d[count], x[count], index[count] = SLOWER, way, fastest, e
                        A[count], J[count], B[count] = A_least, J_least, J_then
                        count += 1
                if not hold and (wanted < least_wanted or less):
                    least_wanted = min(least_wanted, wanted)
                    if least_wanted < peak and least_wanted < fastest:
                        kind[count], d[count], x[count], index[count] = FEED, way, least_wanted, e
                        A[count], J[count], B[count] = A_least, J_least, J_then
                        count += 1
                if r["v_entry"] < slowest_corner:
                    slowest_corner = r["v_entry"]
                    if slowest_corner < top and slowest_corner < fastest:
                        kind[count], d[count], x[count], index[count] = SPEED, way, slowest_corner, e
                        A[count], J[count] = A_least, J_least
                        count += 1
                if r["a_limit"] < A_least or r["j_limit"] < J_least:
                    J_before = J_least
                    A_least, J_least = min(A_least, r["a_limit"]), min(J_least, r["j_limit"])
                    kind[count], d[count], x[count], index[count] = REDUCE, way, A_least, e
                    A[count], J[count] = J_least, J_before
                    count += 1
                    top = v_top + a_top * a_top / (2.0 * J_least)
                    need = brake_distance(v_top, a_top, 0.0, A_least, J_least) + v_top * period * MARGIN
                way += r["length"]
        gate = what == GATE and e > opened
        if single_block and e > opened and moving and (what == BLOCK_END or r["block_end"] == 1):
            if places[1] < 0 and (way <= 0.0 or brake_distance(v, a, 0.0, A_least, J_least) <= way):
                places[1] = e  # the first block end where stopping is possible
            gate = gate or e == places[1]
        if gate:
            stopped = True
            e += 1
            break
        e += 1
        if moving and way > need:
            break
    if not moving:
        return 0
    if stopped or e >= last:
        kind[count], d[count], x[count], index[count] = STOP, way, 0.0, e
        A[count], J[count] = A_least, J_least
        if not stopped and e >= written:
            places[2] = count
        count += 1
    if at_old > 0:
        for i in range(at_old, count):
            if kind[i] == FEED:
                continue
            safe = slack(kind[i], d[i], x[i], A[i], J[i], B[i], v, a, period) >= -1e-8
            if kind[i] == REDUCE and a < 0.0:
                safe = safe and can_release(d[i], x[i], A[i], J[i], v, a)
            if not safe:
                count = at_old
                kind[count], d[count], x[count], index[count] = STOP, way_old, 0.0, old_horizon
                A[count], J[count] = A_old, J_old
                count += 1
                places[2] = -1
                e = old_horizon
                break
    places[0] = e
    # A feed that comes too soon (the override has just changed) is braked for at once, as far as nothing else forbids it.
    for i in range(1, count):
        if kind[i] == FEED and slack(FEED, d[i], x[i], A[i], J[i], B[i], v, a, period) < -1e-8:
            x[0] = min(x[0], x[i])
            x[i] = np.inf
    # Braking for its own sake (feed hold, lower override) may cross borders: with the least of what it crosses.
    for i in range(1, count):
        if kind[i] == REDUCE:
            if d[i] > brake_distance(v, a, 0.0, A[0], J[0]):
                break
            A[0], J[0] = min(A[0], x[i]), min(J[0], A[i])
    return count
