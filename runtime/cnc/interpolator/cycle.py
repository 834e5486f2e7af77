"""One cycle of the interpolator in one kernel call: walk, look ahead, drive, walk, evaluate, report.

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
from runtime.cnc.interpolator.lookahead import (
    ARC,
    CONSTRAINTS,
    FUNCTION,
    GATE,
    HORIZON,
    KNOWN_END,
    LINE,
    SHARPLY,
    SINGLE_GATE,
    VALID,
    WHOLE,
    look_ahead,
)
from runtime.cnc.interpolator.profile import ARRIVED, drive
from runtime.cnc.motion_queue import MAX_AXES, RECORD, Counters, GateReason, Records
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

PASSED = 256  # records told in one cycle
SEARCH = 1024  # records searched for gates and functions in one cycle
JOIN = 1e-6  # mm: the first element must start where the axes stand
PROGRAM_END = int(GateReason.PROGRAM_END)

# state, float
S_IN, V, A, PATH, LENGTH, OVERFLOWS = 0, 1, 2, 3, 4, 5
FLOAT_STATE = 8
# state, integer
CUR, REPORTED, OPENED, HORIZON_ALL, SINGLE_GATE_AT, SCANNED, NEXT_GATE, NEXT_FUNCTION = 0, 1, 2, 3, 4, 5, 6, 7
GATE_INDEX, AT_GATE, FUNCTIONS, PASSED_COUNT, STANDSTILL, STARVED, STARTED, ENDED = 8, 9, 10, 11, 12, 13, 14, 15
ABORTING, APART, SHOWN, BRAKED, HORIZON_ZONES = 16, 17, 18, 19, 20
INT_STATE = 24


@kernel
def walk(records: Records, written: int, n: int, single_block: bool, f: Floats, i: Ints, q: Floats) -> None:
    """Pass every record whose end has been reached; `q` becomes the exact end of each element that is passed."""
    size = records.shape[0]
    while i[CUR] < written:
        r = records[i[CUR] % size]
        held = single_block and i[CUR] == i[SINGLE_GATE_AT] and i[CUR] > i[OPENED]
        if r["kind"] <= ARC:
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
            if held or (r["kind"] == GATE and i[CUR] > i[OPENED]):
                i[SHOWN] = i[CUR]
                f[S_IN] = 0.0
                return
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
    while i[REPORTED] < i[CUR] and count < passed.shape[0]:
        if records[i[REPORTED] % size]["kind"] != GATE:
            passed[count] = i[REPORTED]
            count += 1
        i[REPORTED] += 1
    i[PASSED_COUNT] = count


@kernel
def search(records: Records, written: int, single_block: bool, i: Ints) -> None:
    """Find the next closed gate and the next function, `SEARCH` records per cycle."""
    size = records.shape[0]
    if i[NEXT_GATE] >= 0 and i[NEXT_GATE] <= i[OPENED]:
        i[NEXT_GATE] = -1
    i[SCANNED] = max(i[SCANNED], i[CUR])
    end = min(written, i[SCANNED] + SEARCH)
    while i[NEXT_GATE] < 0 and i[SCANNED] < end:
        if records[i[SCANNED] % size]["kind"] == GATE and i[SCANNED] > i[OPENED]:
            i[NEXT_GATE] = i[SCANNED]
        i[SCANNED] += 1
    i[NEXT_FUNCTION] = max(i[NEXT_FUNCTION], i[REPORTED])
    end = min(written, i[NEXT_FUNCTION] + SEARCH)
    while i[NEXT_FUNCTION] < end and records[i[NEXT_FUNCTION] % size]["kind"] != FUNCTION:
        i[NEXT_FUNCTION] += 1
    gate = i[NEXT_GATE]
    if single_block and i[SINGLE_GATE_AT] > i[OPENED] and (gate < 0 or i[SINGLE_GATE_AT] < gate):
        gate = i[SINGLE_GATE_AT]
    i[GATE_INDEX] = gate
    found = i[NEXT_FUNCTION] < written and records[i[NEXT_FUNCTION] % size]["kind"] == FUNCTION
    i[FUNCTIONS] = 1 if gate >= 0 and found and i[NEXT_FUNCTION] < gate else 0


@kernel
def cycle(
    records: Records,
    counters: Counters,
    n: int,
    period: float,
    override: float,
    hold: bool,
    single_block: bool,
    f: Floats,
    i: Ints,
    q: Floats,
    dq: Floats,
    passed: Ints,
    real: Floats,
    whole: Ints,
) -> None:
    """Advance by one period. `q`, `dq` (n,): commanded position and velocity; `real`, `whole`: scratch."""
    size = records.shape[0]
    counters[1] = max(counters[1], min(i[REPORTED], i[CUR]))  # free what was told in the cycle before
    written = counters[0]
    if not single_block or i[SINGLE_GATE_AT] <= i[OPENED]:
        i[SINGLE_GATE_AT] = -1
    walk(records, written, n, single_block, f, i, q)
    for k in range(n):
        dq[k] = 0.0
    v_before = f[V]
    braked_by_end = False
    count = 0
    s_best, v_best, a_best, pieces_best = 0.0, 0.0, 0.0, 0.0
    stop_A, stop_J = np.inf, np.inf
    up, result, borders = real[0, 6], real[0, 7], real[1, 8 : 8 + 6].T
    if i[APART] == 0:
        for mode in range(2):
            whole[mode, 3, HORIZON] = i[HORIZON_ALL] if mode == 0 else i[HORIZON_ZONES]
            whole[mode, 3, SINGLE_GATE] = i[SINGLE_GATE_AT]
        count = look_ahead(
            records, written, i[CUR], f[S_IN], f[V], f[A], period, override, hold or i[ABORTING] == 1, i[OPENED],
            single_block, False, whole[0, 3], whole[0, 0], real[0, 0], real[0, 1], real[0, 2], real[0, 3], real[0, 4],
            whole[0, 1], up, borders,
        )  # fmt: skip
    if count > 0:
        i[SINGLE_GATE_AT] = whole[0, 3, SINGLE_GATE]
        best = -1
        for mode in range(2):
            number = count
            places = whole[mode, 3]
            if mode == 1:
                if whole[0, 3, SHARPLY] == 0:
                    i[HORIZON_ZONES] = i[HORIZON_ALL]
                    break
                places[SINGLE_GATE] = i[SINGLE_GATE_AT]
                number = look_ahead(
                    records, written, i[CUR], f[S_IN], f[V], f[A], period, override, hold or i[ABORTING] == 1,

                    i[OPENED], single_block, True, places, whole[1, 0], real[1, 0], real[1, 1], real[1, 2], real[1, 3],
                    real[1, 4], whole[1, 1], up, borders,
                )  # fmt: skip
                i[SINGLE_GATE_AT] = places[SINGLE_GATE]
                real[1, 2, 0], real[1, 3, 0] = min(real[1, 2, 0], stop_A), min(real[1, 3, 0], stop_J)
                if places[VALID] == 0 and best >= 0:
                    break
            else:
                stop_A, stop_J = real[0, 2, 0], real[0, 3, 0]
                if places[VALID] == 0 and places[SHARPLY] == 1:
                    continue
            i[HORIZON_ALL if mode == 0 else HORIZON_ZONES] = places[HORIZON]
            result[3] = 0.0
            braked = drive(
                period, f[V], f[A], up[0], up[1], number, whole[mode, 0], real[mode, 0], real[mode, 1], real[mode, 2],
                real[mode, 3], real[mode, 4], whole[mode, 2], result,
            )  # fmt: skip
            # the one that knows more; of equals the faster
            if (
                best < 0
                or places[WHOLE] > whole[0, 3, WHOLE]
                or (places[WHOLE] == whole[0, 3, WHOLE] and (result[1], result[0]) > (v_best, s_best))
            ):
                best = mode
                s_best, v_best, a_best, pieces_best = result[0], result[1], result[2], result[3]
                i[BRAKED] = braked
                braked_by_end = braked >= 0 and braked == places[KNOWN_END]
        f[OVERFLOWS] += pieces_best
        f[S_IN] += s_best
        f[PATH] += s_best
        f[V], f[A] = v_best, a_best
        walk(records, written, n, single_block, f, i, q)
    else:
        f[V], f[A] = 0.0, 0.0
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
    for k in range(n):
        dq[k] *= f[V]
    report(records, i, passed)
    search(records, written, single_block, i)
    i[AT_GATE] = 0
    here = records[i[CUR] % size]
    at_end = here["kind"] > ARC or f[S_IN] >= here["length"]
    if f[V] == 0.0 and i[GATE_INDEX] >= 0 and i[CUR] == i[GATE_INDEX] and at_end:
        i[AT_GATE] = 1
    i[STANDSTILL] = 1 if f[V] == 0.0 and v_before == 0.0 else 0
    dry = i[STARTED] == 1 and i[ENDED] == 0 and i[AT_GATE] == 0
    i[STARVED] = 1 if dry and (i[CUR] >= written or (braked_by_end and f[V] > 0.0)) else 0


def scratch() -> tuple[Floats, Ints]:
    """Memory for the constraints of a cycle."""
    return np.zeros((2, 14, CONSTRAINTS)), np.zeros((2, 4, CONSTRAINTS), dtype=np.int64)


@warms("interpolator")
def _warm_up() -> None:
    real, whole = scratch()
    buffer = bytearray(RECORD.itemsize)
    cycle(
        np.frombuffer(buffer, dtype=RECORD), np.zeros(8, dtype=np.int64), 1, 0.001, 1.0, False, False,
        np.zeros(FLOAT_STATE), np.zeros(INT_STATE, dtype=np.int64), np.zeros(MAX_AXES), np.zeros(MAX_AXES),
        np.zeros(PASSED, dtype=np.int64), real, whole,
    )  # fmt: skip
