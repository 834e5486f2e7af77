"""One cycle of the interpolator in one kernel call: walk, look ahead, propose, prove, walk, evaluate, report.

    reported        cur (s_in along it)          gate               written
       ▼             ▼                            ▼                    ▼
    ───●──●──────────┿━━━━━━━━━━┿━━━━┿━━━━━━━━━━━━▌━━━━━━━━━┿━━━━━━━━━━│
       └ passed, to be told      records known, ahead                  end of what is known

`cur` is the record being executed. A record is passed when the path is at its end; records without length are passed
when the path arrives at them, closed gates never. What was passed is told in `passed`, at most its length per cycle;
the rest follows in the next ones and keeps its place in the queue until then.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.elements import arc_at, line_at
from runtime.cnc.geometry.polynomial_table import ROWS as POLYNOMIAL_ROWS
from runtime.cnc.geometry.polynomial_table import WIDTH
from runtime.cnc.geometry.polynomials import polynomial_at
from runtime.cnc.interpolator.lookahead import (
    ARC,
    BEHIND,
    BLOCK_END,
    CONSTRAINTS,
    GATE,
    HORIZON,
    KNOWN_END,
    LINE,
    ORDERS,
    POLYNOMIAL,
    RELEASED,
    SHARPLY,
    SINGLE_GATE,
    VALID,
    WHOLE,
    look_ahead,
)
from runtime.cnc.interpolator.plan import COLUMNS, WAY, keeps_limits, state_at
from runtime.cnc.interpolator.plan import ROWS as PLAN_ROWS
from runtime.cnc.interpolator.profile import ARRIVED
from runtime.cnc.interpolator.stopping import propose
from runtime.cnc.motion_queue import MAX_AXES, RECORD, Counters, GateReason, Records
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

PASSED = 256  # records told in one cycle
SEARCH = 1024  # records searched for gates in one cycle
JOIN = 1e-6  # mm: the first element must start where the axes stand
PROGRAM_END = int(GateReason.PROGRAM_END)
STEP = int(GateReason.STEP)
WAIT = int(GateReason.WAIT)

# state, float
S_IN, V, A, PATH, LENGTH, OVERFLOWS, PLAN_TIME, PLANNED = 0, 1, 2, 3, 4, 5, 6, 7
FLOAT_STATE = 8
# state, integer
CUR, REPORTED, OPENED, HORIZON_ALL, SINGLE_GATE_AT, SCANNED, NEXT_GATE = 0, 1, 2, 3, 4, 5, 6
GATE_INDEX, AT_GATE, PASSED_COUNT, STANDSTILL, STARVED, STARTED, ENDED = 8, 9, 11, 12, 13, 14, 15
# gates up to OPENED are open; block ends of single block up to BLOCKS_RELEASED: a gate far ahead may be open long before
ABORTING, APART, SHOWN, BRAKED, HORIZON_ZONES, BLOCKS_RELEASED = 16, 17, 18, 19, 20, 21
ROWS, BRAKED_IN, ROWS_KEPT, REFUSED = 22, 24, 26, 27  # the first two for both views
TELL = 28  # a filter keeps the axes back: only what lies before this record may be told; below 0 everything
INT_STATE = 29

KEPT = 2  # the plan that is driven, behind the proposals of both views


@kernel
def walk(records: Records, written: int, n: int, single_block: bool, f: Floats, i: Ints, q: Floats) -> None:
    """Pass every record whose end has been reached; `q` becomes the exact end of each element that is passed.

    In single block a path that has stood at a gate until functions were acknowledged stands where their block ends, too: behind
    the gate nothing was looked at, so no end of a block was found there.
    """
    size = records.shape[0]
    waited = False
    while i[CUR] < written:
        r = records[i[CUR] % size]
        held = single_block and i[CUR] == i[SINGLE_GATE_AT] and i[CUR] > i[BLOCKS_RELEASED]
        if r["kind"] <= POLYNOMIAL:
            if f[S_IN] == 0.0 and f[V] == 0.0:
                for k in range(n):
                    if abs(r["start"][k] - q[k]) > JOIN:
                        i[APART] = 1
                        return
            i[SHOWN] = i[CUR]
            if f[V] == 0.0 and r["length"] - f[S_IN] < ARRIVED:
                f[S_IN] = r["length"]
            if f[S_IN] < r["length"]:
                return
            for k in range(n):
                q[k] = r["end"][k]
            if held:
                f[S_IN] = r["length"]
                return
            f[S_IN] = f[S_IN] - r["length"] if f[V] > 0.0 else 0.0
        else:
            if waited and r["kind"] == BLOCK_END and i[CUR] > i[BLOCKS_RELEASED]:
                held = True
                i[SINGLE_GATE_AT] = i[CUR]
            if held or (r["kind"] == GATE and i[CUR] > i[OPENED]):
                i[SHOWN] = i[CUR]
                f[S_IN] = 0.0
                return
            if r["kind"] == GATE:
                waited = single_block and f[V] == 0.0 and r["reason"] == WAIT
            if r["kind"] == GATE and r["reason"] == PROGRAM_END:
                i[ENDED] = 1
        i[CUR] += 1
        i[STARTED] = 1
    f[S_IN] = 0.0


@kernel
def report(records: Records, i: Ints, passed: Ints) -> None:
    """Tell what was passed: functions, ends of elements and blocks; not gates."""
    size = records.shape[0]
    count = 0
    end = i[CUR] if i[TELL] < 0 else min(i[CUR], i[TELL])
    while i[REPORTED] < end and count < passed.shape[0]:
        if records[i[REPORTED] % size]["kind"] != GATE:
            passed[count] = i[REPORTED]
            count += 1
        i[REPORTED] += 1
    i[PASSED_COUNT] = count


@kernel
def search(records: Records, written: int, single_block: bool, i: Ints) -> None:
    """Find the next closed gate, `SEARCH` records per cycle."""
    size = records.shape[0]
    if i[NEXT_GATE] >= 0 and i[NEXT_GATE] <= i[OPENED]:
        i[NEXT_GATE] = -1
    i[SCANNED] = max(i[SCANNED], i[CUR])
    end = min(written, i[SCANNED] + SEARCH)
    while i[NEXT_GATE] < 0 and i[SCANNED] < end:
        if records[i[SCANNED] % size]["kind"] == GATE and i[SCANNED] > i[OPENED]:
            i[NEXT_GATE] = i[SCANNED]
        i[SCANNED] += 1
    gate = i[NEXT_GATE]
    if single_block and i[SINGLE_GATE_AT] > i[BLOCKS_RELEASED] and (gate < 0 or i[SINGLE_GATE_AT] < gate):
        gate = i[SINGLE_GATE_AT]
    i[GATE_INDEX] = gate


@kernel
def last_step(records: Records, written: int, gate: int) -> int:
    """The record up to which all gates from `gate` on are the ends of steps, `SEARCH` records at most."""
    size = records.shape[0]
    end = min(written, gate + SEARCH)
    for e in range(gate, end):
        r = records[e % size]
        if r["kind"] == GATE and r["reason"] != STEP:
            return e - 1
    return end - 1


@kernel
def choose(
    records: Records,
    written: int,
    period: float,
    orders: Floats,
    hold: bool,
    single_block: bool,
    f: Floats,
    i: Ints,
    real: Floats,
    whole: Ints,
    plans: Floats,
) -> tuple[int, bool]:
    """Put the best proven plan from here in the place of the kept one; without any the kept one goes on.

    Returns the view of the look-ahead it is from (-1: the kept one), and whether any motion is known.
    """
    up, borders = real[0, 6], real[1, 8 : 8 + 6].T
    stop_A, stop_J = np.inf, np.inf
    best, other = -1, -1
    overflows = 0.0
    if i[APART] == 1:
        return -1, False
    for mode in range(2):
        places = whole[mode, 3]
        places[HORIZON] = i[HORIZON_ALL] if mode == 0 else i[HORIZON_ZONES]
        places[SINGLE_GATE] = i[SINGLE_GATE_AT]
        places[RELEASED] = i[BLOCKS_RELEASED]
        if mode == 1 and whole[0, 3, SHARPLY] == 0:
            i[HORIZON_ZONES] = i[HORIZON_ALL]
            break
        kind, zone, state = whole[mode, 0], whole[mode, 1], whole[mode, 2]
        d, x, A_to, J_to, B = real[mode, 0], real[mode, 1], real[mode, 2], real[mode, 3], real[mode, 4]
        count = look_ahead(
            records, written, i[CUR], f[S_IN], f[V], f[A], period, orders, hold, i[OPENED], single_block, f[PLANNED],
            mode == 1, places, kind, d, x, A_to, J_to, B, zone, up, borders,
        )  # fmt: skip
        if count == 0:
            return -1, False
        i[SINGLE_GATE_AT] = places[SINGLE_GATE]
        if mode == 0:
            stop_A, stop_J = A_to[0], J_to[0]
            if places[VALID] == 0 and places[SHARPLY] == 1:
                continue
        else:
            A_to[0], J_to[0] = min(A_to[0], stop_A), min(J_to[0], stop_J)
            if places[VALID] == 0 and best >= 0:
                break
        i[HORIZON_ALL if mode == 0 else HORIZON_ZONES] = places[HORIZON]
        i[ROWS + mode], i[BRAKED_IN + mode], overflow = propose(
            period, f[V], f[A], count, kind, d, x, A_to, J_to, B, state, up, places[BEHIND] if mode == 1 else 0,
            borders, plans[mode],
        )  # fmt: skip
        overflows += 1.0 if overflow else 0.0
        if best < 0:
            best = mode
            continue
        # the one that knows more; of equals the faster
        s_first, v_first, _ = state_at(plans[0], i[ROWS], period)
        s_second, v_second, _ = state_at(plans[1], i[ROWS + 1], period)
        more = places[WHOLE] - whole[0, 3, WHOLE]
        if more > 0 or (more == 0 and (v_second, s_second) > (v_first, s_first)):
            best, other = 1, 0
        else:
            other = 1
    single = i[SINGLE_GATE_AT] if single_block and i[SINGLE_GATE_AT] > i[BLOCKS_RELEASED] else -1
    for mode in (best, other):
        if mode < 0:
            continue
        rows = i[ROWS + mode]
        if keeps_limits(records, written, i[CUR], f[S_IN], i[OPENED], single, plans[mode], rows, period, hold):
            plans[KEPT, :rows] = plans[mode, :rows]
            i[ROWS_KEPT], i[BRAKED] = rows, i[BRAKED_IN + mode]
            f[PLAN_TIME] = 0.0
            return mode, True
    i[REFUSED] += 1
    f[OVERFLOWS] += overflows  # a proposal that broke off is never proven: it only counts if there was no other
    return -1, True


@kernel
def cycle(
    records: Records,
    polynomials: Floats,
    counters: Counters,
    n: int,
    period: float,
    orders: Floats,
    hold: bool,
    single_block: bool,
    f: Floats,
    i: Ints,
    q: Floats,
    dq: Floats,
    passed: Ints,
    real: Floats,
    whole: Ints,
    plans: Floats,
) -> None:
    """Advance by one period. `q`, `dq` (n,): commanded position and velocity; `real`, `whole`: scratch; `plans` has
    the plan that is being driven."""
    size = records.shape[0]
    counters[1] = max(counters[1], min(i[REPORTED], i[CUR]))  # free what was told in the cycle before
    written = counters[0]
    if not single_block or i[SINGLE_GATE_AT] <= i[BLOCKS_RELEASED]:
        i[SINGLE_GATE_AT] = -1
    walk(records, written, n, single_block, f, i, q)
    v_before = f[V]
    accepted, known = choose(
        records, written, period, orders, hold or i[ABORTING] == 1, single_block, f, i, real, whole, plans
    )
    if known:
        s, _, _ = state_at(plans[KEPT], i[ROWS_KEPT], f[PLAN_TIME])
        f[PLAN_TIME] += period
        s_then, f[V], f[A] = state_at(plans[KEPT], i[ROWS_KEPT], f[PLAN_TIME])
        way = max(s_then - s, 0.0)
        f[S_IN] += way
        f[PATH] += way
        f[PLANNED] = max(plans[KEPT, i[ROWS_KEPT] - 1, WAY] - s_then, 0.0)
        walk(records, written, n, single_block, f, i, q)
    else:
        f[V], f[A] = 0.0, 0.0
    if accepted >= 0:
        braked_by_end = i[BRAKED] >= 0 and i[BRAKED] == whole[accepted, 3, KNOWN_END]
    else:
        braked_by_end = i[STARVED] == 1  # as when the kept plan was made
    for k in range(n):
        dq[k] = 0.0
    f[LENGTH] = 0.0
    if i[CUR] < written and i[APART] == 0:
        r = records[i[CUR] % size]
        f[LENGTH] = r["length"]
        if r["kind"] == LINE:
            line_at(r["start"], r["end"], f[S_IN] / r["length"], r["length"], n, q, dq)
        elif r["kind"] == ARC:
            arc_at(
                r["start"], r["end"], r["axis0"], r["axis1"], r["centre0"], r["centre1"], r["angle"],
                f[S_IN] / r["length"], r["length"], n, q, dq,
            )  # fmt: skip
        elif r["kind"] == POLYNOMIAL:
            polynomial_at(polynomials[i[CUR] % size], min(f[S_IN] / r["length"], 1.0), r["length"], n, q, dq)
            if f[S_IN] >= r["length"]:
                for k in range(n):
                    q[k] = r["end"][k]
    for k in range(n):
        dq[k] *= f[V]
    report(records, i, passed)
    search(records, written, single_block, i)
    i[AT_GATE] = 0
    here = records[i[CUR] % size]
    at_end = here["kind"] > POLYNOMIAL or f[S_IN] >= here["length"]
    if f[V] == 0.0 and i[GATE_INDEX] >= 0 and i[CUR] == i[GATE_INDEX] and at_end:
        i[AT_GATE] = 1
    i[STANDSTILL] = 1 if f[V] == 0.0 and v_before == 0.0 else 0
    dry = i[STARTED] == 1 and i[ENDED] == 0 and i[AT_GATE] == 0
    i[STARVED] = 1 if dry and (i[CUR] >= written or (braked_by_end and f[V] > 0.0)) else 0


def scratch() -> tuple[Floats, Ints, Floats]:
    """Memory for the constraints of a cycle, and for the plans."""
    return (
        np.zeros((2, 14, CONSTRAINTS)),
        np.zeros((2, 4, CONSTRAINTS), dtype=np.int64),
        np.zeros((3, PLAN_ROWS, COLUMNS)),
    )


@warms("interpolator")
def _warm_up() -> None:
    real, whole, plans = scratch()
    buffer = bytearray(RECORD.itemsize)
    last_step(np.frombuffer(buffer, dtype=RECORD), 0, 0)
    cycle(
        np.frombuffer(buffer, dtype=RECORD), np.zeros((1, POLYNOMIAL_ROWS, WIDTH)),
        np.zeros(8, dtype=np.int64), 1, 0.001, np.ones(ORDERS), False, False,
        np.zeros(FLOAT_STATE), np.zeros(INT_STATE, dtype=np.int64), np.zeros(MAX_AXES), np.zeros(MAX_AXES),
        np.zeros(PASSED, dtype=np.int64), real, whole, plans,
    )  # fmt: skip
