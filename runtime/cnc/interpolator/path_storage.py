"""The way that lies behind: records that the path has passed, kept so that it can be driven backward. Kernels.

    kept          FIRST … NEXT-1: numbers of records, slot = number % capacity       │ the record in work: number NEXT
                  ══╪═══╪══M00══╪═════╪══[ON ── OFF]══╪════▶                         │
    replay queue  filled from the place where the path turns, backward ◀── or forward ──▶, some records ahead of the path

A record driven backward begins where it ended. The corner between two elements keeps its speed, and an arc its centre; a
polynomial becomes q(1 - u), and its parameter 1 - u(1 - σ). So the same planner drives it, with the same limits.

What is not contiguous with what is kept (the path was taken over somewhere else, a block was cut off) clears what is kept
before it.
"""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.polynomial_table import MAP, ROWS, WIDTH
from runtime.cnc.geometry.polynomials import part_of
from runtime.cnc.motion_queue import RECORD, ActionKind, Counters, GateReason, MotionQueue, RecordKind, Records
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

REPLAY = 512  # records of the replay queue
AHEAD = 64  # records that are filled in one cycle at most
_GAP = 1e-6  # mm

_ARC, _POLYNOMIAL, _BLOCK_END = int(RecordKind.ARC), int(RecordKind.POLYNOMIAL), int(RecordKind.BLOCK_END)
_FUNCTION, _GATE, _ACTION = int(RecordKind.FUNCTION), int(RecordKind.GATE), int(RecordKind.ACTION)
_AHEAD = int(RecordKind.FUNCTION_AHEAD)
_WAIT, _M00, _M01 = int(GateReason.WAIT), int(GateReason.PROGRAMMED_STOP), int(GateReason.OPTIONAL_STOP)
_STOP_MARK = int(GateReason.STOP_MARK)
_FIRST_FOREIGN = int(GateReason.MANUAL)  # from here on somebody else moves the axes, or the path begins anew
_OPTIONAL_ON, _OPTIONAL_OFF = int(ActionKind.OPTIONAL_ON), int(ActionKind.OPTIONAL_OFF)
_CLEAR = int(ActionKind.CLEAR_STORAGE)
_HAND = int(ActionKind.MANUAL_ON)
_MVS_SVS, _BWD_SYNCH = 0x2, 0x400000

# what is kept
FIRST, NEXT, STORED, OPEN = 0, 1, 2, 3  # OPEN: the section that has begun and not yet ended, -1 none
STATE = 4
# where the filling is
# number to be filled next; 1 forward, -1 backward; 1: nothing more lies before it; 1: the path turns inside of the first one
AT, DIRECTION, ENDED, INSIDE = 0, 1, 2, 3
FILL = 4


@kernel
def keep(records: Records, tables: Floats, end: int, n: int, kept: Records, kept_tables: Floats, state: Ints) -> None:
    """Keep the records STORED to before `end` of the queue; the oldest give way."""
    size, room = records.shape[0], kept.shape[0]
    while state[STORED] < end:
        r = records[state[STORED] % size]
        number = state[NEXT]
        slot = number % room
        kind = r["kind"]
        foreign = kind == _GATE and r["reason"] >= _FIRST_FOREIGN
        foreign = foreign or (kind == _ACTION and (r["action"] == _CLEAR or r["action"] == _HAND))
        kept[slot] = r
        if kind == _POLYNOMIAL:
            kept_tables[slot, :, :] = tables[state[STORED] % size, :, :]
        if kind <= _POLYNOMIAL and number > state[FIRST]:
            before = number - 1
            while before >= state[FIRST] and kept[before % room]["kind"] > _POLYNOMIAL:
                before -= 1
            if before >= state[FIRST]:
                for k in range(n):
                    if abs(kept[before % room]["end"][k] - r["start"][k]) > _GAP:
                        state[FIRST] = number
        if kind == _ACTION and r["action"] == _OPTIONAL_ON:
            state[OPEN] = number
            kept[slot]["size"] = -1
        elif kind == _ACTION and r["action"] == _OPTIONAL_OFF:
            kept[slot]["offset"] = state[OPEN]
            if state[OPEN] > number - room and state[OPEN] >= 0:
                kept[state[OPEN] % room]["size"] = number
                kept[slot]["number"] = kept[state[OPEN] % room]["number"]
                kept[slot]["spindle"] = kept[state[OPEN] % room]["spindle"]
            state[OPEN] = -1
        state[NEXT] = number + 1
        state[STORED] += 1
        if foreign:
            state[FIRST] = number + 1
        state[FIRST] = max(state[FIRST], number + 1 - room)


@kernel
def turned(table: Floats, back: Floats) -> None:
    """The table of a polynomial driven from its end: q(1 - u), with u = 1 - u(1 - σ)."""
    part_of(table[:MAP], 1.0, 0.0, back[:MAP])
    for power in range(WIDTH):
        back[MAP, power] = table[MAP, power]
    for done in range(WIDTH):  # Taylor shift of the map to σ = 1
        for power in range(WIDTH - 2, done - 1, -1):
            back[MAP, power] += back[MAP, power + 1]
    sign = 1.0
    for power in range(WIDTH):
        back[MAP, power] *= -sign
        sign = -sign
    back[MAP, 0] += 1.0


@kernel
def skipped(mode: int, mask: int, backward: bool, simulated: bool, simulated_mask: int) -> bool:
    """Whether a section of #OPTIONAL EXECUTION is left out; `mode` 0 plain, 1 SIMULATE, 2 with a mask."""
    if mode == 0:
        return backward or simulated
    return simulated and (mode == 1 or (mask & simulated_mask) != 0)


@kernel
def put(
    r: Records,
    table: Floats,
    number: int,
    backward: bool,
    n: int,
    after: Floats,
    records: Records,
    tables: Floats,
    numbers: Ints,
    counters: Counters,
    inside: bool,
) -> None:
    """Append a record to the replay queue as it is driven; `after`: v_entry and v_corner of the element behind it. `inside`:
    the path turns in it, so the end of its block is not come to."""
    size = records.shape[0]
    written = counters[0]
    if backward and r["kind"] <= _POLYNOMIAL and r["block_end"] == 1 and not inside:
        out = records[written % size]
        records[written % size] = r
        out["kind"] = _BLOCK_END
        numbers[written % size] = number
        written += 1
    slot = written % size
    records[slot] = r
    numbers[slot] = number
    out = records[slot]
    if out["kind"] == _AHEAD:
        out["kind"] = _FUNCTION
    if r["kind"] <= _POLYNOMIAL:
        out["a_entry"] = 0.0
        if backward:
            for k in range(n):
                out["start"][k], out["end"][k] = r["end"][k], r["start"][k]
            out["v_entry"], out["v_corner"] = after[0], after[1]
            after[0], after[1] = r["v_entry"], r["v_corner"]
            out["block_end"], out["brake_late"] = 0, 0
            if r["kind"] == _ARC:
                out["angle"] = -r["angle"]
            elif r["kind"] == _POLYNOMIAL:
                turned(table, tables[slot])
        elif r["kind"] == _POLYNOMIAL:
            tables[slot, :, :] = table
    elif backward and out["kind"] == _FUNCTION and r["synch"] & _BWD_SYNCH:
        gate = records[(written + 1) % size]
        records[(written + 1) % size] = r
        gate["kind"], gate["reason"], gate["synch"] = _GATE, _WAIT, _MVS_SVS
        numbers[(written + 1) % size] = number
        written += 1
    counters[0] = written + 1


@kernel
def fill(
    kept: Records,
    kept_tables: Floats,
    state: Ints,
    n: int,
    place: Ints,
    after: Floats,
    drops: Ints,
    simulated: bool,
    simulated_mask: int,
    records: Records,
    tables: Floats,
    numbers: Ints,
    counters: Counters,
) -> None:
    """Fill the replay queue from number AT on. `drops`: whether M00 and M01 are left out in this direction."""
    room, size = kept.shape[0], records.shape[0]
    backward = place[DIRECTION] < 0
    for _ in range(AHEAD):
        if counters[0] - counters[1] >= size - 2:
            return
        number = place[AT]
        if (backward and number < state[FIRST]) or (not backward and number >= state[NEXT]):
            place[ENDED] = 1
            return
        r = kept[number % room]
        kind = r["kind"]
        place[AT] = number + place[DIRECTION]
        if kind == _ACTION:
            partner = -1
            if backward and r["action"] == _OPTIONAL_OFF:
                partner = r["offset"]
            elif not backward and r["action"] == _OPTIONAL_ON:
                partner = r["size"]
            else:
                continue
            if partner >= 0 and skipped(r["number"], r["spindle"], backward, simulated, simulated_mask):
                if partner < state[FIRST]:  # the begin of the section is not kept any more: nothing goes on behind it
                    place[AT] = number
                    place[ENDED] = 1
                    return
                place[AT] = partner + place[DIRECTION]
            continue
        if kind == _GATE:
            stops = (r["reason"] == _M00 and drops[0] == 0) or (r["reason"] == _M01 and drops[1] == 0)
            stops = stops or (r["reason"] == _STOP_MARK and (r["offset"] & (4 if backward else 2)) != 0)
            if not stops and (backward or r["reason"] != _WAIT):
                continue
        inside = place[INSIDE] == 1 and kind <= _POLYNOMIAL
        put(r, kept_tables[number % room], number, backward, n, after, records, tables, numbers, counters, inside)
        place[INSIDE] = 0


class PathStorage:
    """Keeps at most `capacity` records (0: none) of a channel with n axes, and the queue in which they are driven again.

    `kept` and `tables` are the records and their polynomials, `state` tells which of them count.
    """

    def __init__(self, n_axes: int, capacity: int) -> None:
        self._n = n_axes
        self.capacity = capacity
        self.kept = np.zeros(max(capacity, 1), dtype=RECORD)
        self.tables = np.zeros((max(capacity, 1), ROWS, WIDTH))
        self.state = np.zeros(STATE, dtype=np.int64)
        self._place = np.zeros(FILL, dtype=np.int64)
        self._after = np.zeros(2)
        self._drops = np.zeros(2, dtype=np.int64)
        self.queue = MotionQueue(n_axes, capacity=REPLAY if capacity else 1)
        self._numbers = np.zeros(self.queue.capacity, dtype=np.int64)
        self._counters = self.queue.counters  # the queue has no other state

    def begin(self, read: int) -> None:
        """A program starts, its records begin at index `read` of its queue: nothing is kept."""
        self.state[:] = (0, 0, read, -1)
        self.queue.discard_all()

    def follow(self, queue: MotionQueue, passed: int) -> None:
        """Keep what the path has passed: the records of the queue up to before index `passed`."""
        if self.state[STORED] < passed:
            keep(queue.records, queue.polynomials, passed, self._n, self.kept, self.tables, self.state)

    def clear(self) -> None:
        """Forget what lies behind."""
        self.state[FIRST] = self.state[NEXT]

    @property
    def count(self) -> int:
        """Records that are kept."""
        return int(self.state[NEXT] - self.state[FIRST])

    @property
    def next(self) -> int:
        """The number that the record in work will get."""
        return int(self.state[NEXT])

    @property
    def ended(self) -> bool:
        """Everything in this direction is in the replay queue."""
        return bool(self._place[ENDED])

    def number(self, index: int) -> int:
        """The number of a record of the replay queue."""
        return int(self._numbers[index % self.queue.capacity])

    def turn(self, at: int, direction: int, drops: tuple[bool, bool], *, inside: bool) -> None:
        """Fill from number `at` on, 1 forward or -1 backward; `inside` of it. `drops`: M00 and M01 do not stop."""
        self.queue.discard_all()
        self._place[:] = (at, direction, 0, inside)
        self._after[:] = 0.0  # the path stands: no corner is driven over
        self._drops[:] = drops

    def put(self, record: Any, table: Floats, number: int) -> None:
        """The first record of a replay backward: the one in work, which is not yet kept."""
        put(
            record, table, number, True, self._n, self._after, self.queue.records, self.queue.polynomials,
            self._numbers, self.queue.counters, True,
        )  # fmt: skip

    def fill(self, simulated: bool, mask: int) -> None:
        """Once per cycle while the way is driven again."""
        if self._place[ENDED]:
            return
        fill(
            self.kept, self.tables, self.state, self._n, self._place, self._after, self._drops, simulated, mask,
            self.queue.records, self.queue.polynomials, self._numbers, self.queue.counters,
        )  # fmt: skip


@warms("way that is kept")
def _warm_up() -> None:
    storage = PathStorage(1, 4)
    queue = MotionQueue(1, capacity=4)
    queue.append(np.zeros(1, dtype=RECORD))
    storage.begin(0)
    storage.follow(queue, 1)
    storage.turn(0, -1, (False, False), inside=False)
    storage.put(queue.record(0), queue.polynomials[0], 0)
    storage.fill(False, 0)
