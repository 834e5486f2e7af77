"""The filter of the set-points behind the interpolator (#FILTER): one FIR filter per axis, all with the same delay.

    age in cycles   0 ─────────── middle ─────────── window
                    path          where the axes are: what has been passed there is told,
                                  and what is ahead is counted from there

An axis with a shorter filter, or with none, waits for the others in the middle, so the axes stay together. While the path
stands the filter runs empty; only then is it changed, so it never jumps, and the axes come to the exact place.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from runtime.cnc.geometry.fir_filter import NONE, TAPS, fill_weights, filter_half
from runtime.config.fir_filter import FirFilter
from runtime.kernels import kernel, warms

Floats = npt.NDArray[np.float64]
Ints = npt.NDArray[np.int64]

_AT, _QUIET, _MIDDLE, _WINDOW, _TOLD = 0, 1, 2, 3, 4


@kernel
def push(
    places: Floats,
    ways: Floats,
    records: Ints,
    state: Ints,
    weights: Floats,
    q: Floats,
    way: float,
    record: int,
    out: Floats,
) -> None:
    """Take the newest place of the path `q` (≥ n,), `way` along it, the record where it is; `out` (n,): where the axes are."""
    size, n = places.shape
    before = state[_AT]
    at = (before + 1) % size
    still = True
    for k in range(n):
        still = still and q[k] == places[before, k]
        places[at, k] = q[k]
    ways[at], records[at] = way, record
    state[_AT] = at
    state[_QUIET] = state[_QUIET] + 1 if still else 0
    middle, window = state[_MIDDLE], state[_WINDOW]
    for k in range(n):
        here = places[(at - middle) % size, k]
        off = 0.0  # differences: exact while everything is the same
        for age in range(window + 1):
            off += weights[age, k] * (places[(at - age) % size, k] - here)
        out[k] = here + off


@kernel
def age_of(ways: Floats, at: int, most: int, way: float) -> float:
    """How many cycles ago the path came to `way`, `most` at most, between cycles by interpolation."""
    size = ways.shape[0]
    older = ways[(at - most) % size]
    if older >= way:
        return float(most)
    for age in range(most - 1, -1, -1):
        newer = ways[(at - age) % size]
        if newer >= way:
            share: float = (newer - way) / (newer - older)
            return age + share
        older = newer
    return 0.0


@warms("set-point filter")
def _warm_up() -> None:
    state, ints, floats = np.zeros(5, dtype=np.int64), np.zeros(TAPS, dtype=np.int64), np.zeros(1)
    push(np.zeros((TAPS, 1)), np.zeros(TAPS), ints, state, np.zeros((TAPS, 1)), floats, 0.0, 0, floats)
    age_of(np.zeros(TAPS), 0, 0, 0.0)


class SetPointFilter:
    """Of the path axes of a channel; `filters` describe them, None for an axis without one. `period` in s."""

    def __init__(self, filters: Sequence[FirFilter | None], period: float) -> None:
        n = len(filters)
        self._filters = tuple(filters)
        self._period = period
        self._weights: Floats = np.zeros((TAPS, n))
        self._places: Floats = np.zeros((TAPS, n))
        self._ways: Floats = np.zeros(TAPS)
        self._records: Ints = np.zeros(TAPS, dtype=np.int64)
        self._state: Ints = np.zeros(5, dtype=np.int64)
        self.position: Floats = np.zeros(n)  # where the axes are sent to, (n,)
        self.on = False

    # ------------------------------------------------------------------ what it does

    def begin(self) -> None:
        """A program begins: what the machine description says (P-AXIS-00573). Only while the path stands."""
        given = [f if f is not None and f.enable else None for f in self._filters]
        self._choose([0 if f is None else _half(f, self._period) for f in given])

    def set(self, halves: Sequence[int], share: float, cut_off: float, quality: float) -> None:
        """Filters of these halves, cycles, from here on, 0: none; NaN: what the machine description says. Only while the
        path stands and the filter is empty."""
        self._choose(halves, share, cut_off, quality)

    def _choose(
        self, halves: Sequence[int], share: float = np.nan, cut_off: float = np.nan, quality: float = np.nan
    ) -> None:
        self.on = any(half > 0 for half in halves)
        if not self.on:
            return
        middle = max(halves)
        window = 0
        for k, (given, half) in enumerate(zip(self._filters, halves, strict=True)):
            kind = NONE if given is None or half <= 0 else int(given.type.number)
            fill_weights(
                kind, half, _or(share, 1.0 if given is None else given.share / 100.0),
                _or(cut_off, 30.0 if given is None else given.cut_off),
                _or(quality, 1.0 if given is None else given.quality), self._period, middle, k, self._weights,
            )  # fmt: skip
            window = max(window, middle + half)
        self._state[_MIDDLE], self._state[_WINDOW] = middle, window

    def settle(self, position: Floats, way: float, record: int) -> None:
        """The path stands at `position` (n,), `way` along it, at this record, and so do the axes."""
        self._places[:] = position
        self._ways[:] = way
        self._records[:] = record
        self._state[_QUIET] = TAPS
        self.position[:] = position

    def step(self, q: Floats, way: float, record: int) -> None:
        """One cycle: where the path is now."""
        push(self._places, self._ways, self._records, self._state, self._weights, q, way, record, self.position)

    # ------------------------------------------------------------------ where the axes are

    @property
    def empty(self) -> bool:
        """The axes have come to where the path stands."""
        return not self.on or bool(self._state[_QUIET] >= self._state[_WINDOW])

    @property
    def delay(self) -> int:
        """How many cycles the axes are behind the path."""
        return int(self._state[_MIDDLE]) if self.on else 0

    @property
    def record(self) -> int:
        """The record up to which the axes have come in the step that comes.

        Where the path stands they come to its place last of all: what it has passed there waits until the filter is empty.
        """
        state = self._state
        there = (state[_AT] - state[_MIDDLE] + 1) % TAPS
        if self.empty or self._ways[there] < self._ways[state[_AT]]:
            state[_TOLD] = self._records[there]
        return int(state[_TOLD])

    @property
    def trail(self) -> float:
        """How far behind the path the axes are, mm."""
        if not self.on:
            return 0.0
        state = self._state
        return float(self._ways[state[_AT]] - self._ways[(state[_AT] - state[_MIDDLE]) % TAPS])

    def seconds_to(self, way: float) -> float:
        """Time until the axes are where the path was `way` mm (≤ 0) before now, s; below 0: they were there already."""
        state = self._state
        at, middle = int(state[_AT]), int(state[_MIDDLE])
        return (middle - float(age_of(self._ways, at, middle + 1, self._ways[at] + way))) * self._period


def _or(value: float, described: float) -> float:
    return described if np.isnan(value) else value


def _half(given: FirFilter, period: float) -> int:
    """The half of a filter as it is described, cycles."""
    return filter_half(int(given.type.number), given.cycles(period), given.cut_off, period)
