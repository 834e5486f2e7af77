"""Memories that the cycle shares with other processes, word by word: who wrote what since one has looked last.

An area has three copies of the same words (8 bytes each):

    shared    what everybody sees and writes
    own       what the cycle reads and writes
    agreed    what both were when they were compared last

`take_in` brings what differs between shared and agreed into the cycle; `give_out` brings what differs between own and agreed to
the others. So the cycle sees the outside change at two moments of a cycle only, and both moments can be recorded. Where both
sides have written the same element the cycle's value stays, as with any memory that two write to.

A flag that guards data is its writer's last store. So flags come in first (what they guard is there by then) and go out last. A
word is read by one load. It is written element by element, with one store of the element's own size, and only those elements
that have changed: what others have written beside them in the same word stays.

    words of changes    | first word << 32 | how many | value | value | … | first word << 32 | how many | …
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from runtime.kernels import kernel, warms
from runtime.recorder.elements import Element

Words = npt.NDArray[np.int64]
Spans = npt.NDArray[np.int64]
_WORD = 8


def words_of(buffer: Any) -> Words:
    """The words of a structure or buffer, without the rest that is no whole word."""
    data = np.frombuffer(buffer, dtype=np.uint8)
    return data[: len(data) // _WORD * _WORD].view(np.int64)


WHOLE_WORDS: tuple[Element, ...] = (Element("", 0, _WORD, 1 << 40, False),)  # of memories that only one process writes


class Area:
    """The three copies of a memory, and how they are compared. Sizes are whole words.

    `ranges`: bytes (begin, end) that are looked at in every cycle; the rest is settled by `settle` only.
    """

    def __init__(
        self,
        shared: Words,
        own: Words,
        elements: Iterable[Element],
        ranges: Iterable[tuple[int, int]] | None = None,
    ) -> None:
        if len(shared) != len(own):
            raise ValueError(f"an area has the same words on both sides, not {len(shared)} and {len(own)}")
        size = own.nbytes
        self.shared, self.own = shared, own
        self.agreed: Words = self.own.copy()
        self.sizes = np.zeros(size, dtype=np.uint8)  # of the element that begins at a byte, 0: none does
        flags: set[int] = set()
        for element in elements:
            begin, end = element.offset, element.offset + element.size * element.count
            self.sizes[begin : end : element.size] = element.size
            if element.flag:
                flags.add(begin // _WORD)
        looked_at = sorted(ranges) if ranges is not None else [(0, size)]
        within = [word for begin, end in looked_at for word in range(begin // _WORD, -(-end // _WORD))]
        flagged = sorted(flags.intersection(within))
        guarded = [word for word in within if word not in flags]
        self.flags: Words = np.array(flagged, dtype=np.int64)
        self.guarded = _spans(guarded)

    def take_in(self, kind: int, out: Words, at: int) -> int:
        """What others have written, as a section of a record; the place behind it."""
        return self._exchange(kind, True, self.guarded, self.flags, out, at)

    def give_out(self, kind: int, out: Words, at: int) -> int:
        """What the cycle has written, as a section of a record; the place behind it."""
        return self._exchange(kind, False, self.guarded, self.flags, out, at)

    def settle(self) -> None:
        """Bring everything that the cycle has written so far to the others; before anybody else writes."""
        everything = np.array([[0, len(self.own)]], dtype=np.int64)
        self._exchange(0, False, everything, self.flags[:0], np.zeros(0, np.int64), 0)

    def _exchange(self, kind: int, inward: bool, guarded: Spans, flags: Words, out: Words, at: int) -> int:
        # a plain number: to tell the type of an enum takes Numba half a millisecond
        return exchange(int(kind), inward, self.shared, self.own, self.agreed, flags, guarded, self.sizes, out, at)


def _spans(words: list[int]) -> Spans:
    """Runs of words as (begin, end), (k, 2)."""
    spans: list[list[int]] = []
    for word in words:
        if spans and spans[-1][1] == word:
            spans[-1][1] = word + 1
        else:
            spans.append([word, word + 1])
    return np.array(spans, dtype=np.int64).reshape(-1, 2)


@kernel
def _store(shared: Words, value: int, old: int, i: int, sizes: npt.NDArray[np.uint8]) -> None:
    """One word, element by element, each by one store; those that have not changed are left alone."""
    if sizes[8 * i] == 8:
        shared[i] = value
        return
    bytes_of, halves, words = shared.view(np.uint8), shared.view(np.uint16), shared.view(np.uint32)
    for b in range(8):
        size = sizes[8 * i + b]
        new, was = (value >> (8 * b)), (old >> (8 * b))
        if size == 1 and (new ^ was) & 0xFF:
            bytes_of[8 * i + b] = new & 0xFF
        elif size == 2 and (new ^ was) & 0xFFFF:
            halves[4 * i + b // 2] = new & 0xFFFF
        elif size == 4 and (new ^ was) & 0xFFFFFFFF:
            words[2 * i + b // 4] = new & 0xFFFFFFFF


@kernel
def _scan(
    source: Words,
    target: Words,
    agreed: Words,
    spans: Spans,
    sizes: npt.NDArray[np.uint8],
    whole: bool,
    out: Words,
    at: int,
) -> int:
    """Bring what differs between source and agreed to the target, and write it down in `out`; the place behind it.

    `whole`: nobody else writes into the target, so whole words are stored, not elements of `sizes`.
    """
    room = out.shape[0]
    for k in range(spans.shape[0]):
        i, end = spans[k, 0], spans[k, 1]
        before, head = -2, 0
        while i < end:
            if i + 8 <= end:
                differs = 0
                for j in range(i, i + 8):
                    differs |= source[j] ^ agreed[j]
                if differs == 0:
                    i += 8
                    continue
            stop = min(i + 8, end)
            while i < stop:
                value = source[i]
                if value != agreed[i]:
                    if whole:
                        target[i] = value
                    else:
                        _store(target, value, agreed[i], i, sizes)
                    agreed[i] = value
                    if before != i - 1:
                        head = at
                        if at < room:
                            out[at] = i << 32
                        at += 1
                    if at < room:
                        out[at] = value
                        out[head] += 1
                    at += 1
                    before = i
                i += 1
    return at


@kernel
def _write_one(word: int, value: int, out: Words, at: int) -> int:
    if at + 2 <= out.shape[0]:
        out[at] = word << 32 | 1
        out[at + 1] = value
    return at + 2


@kernel
def exchange(
    kind: int,
    inward: bool,
    shared: Words,
    own: Words,
    agreed: Words,
    flags: Words,
    guarded: Spans,
    sizes: npt.NDArray[np.uint8],
    out: Words,
    at: int,
) -> int:
    """Take over what others have written (`inward`), or hand over what the cycle has; the place behind it in `out`.

    It is written down as a section of a record, which begins at `at`; if nothing has changed there is none. A place beyond
    the end of `out` tells that it had no room for everything; what is exchanged is whole all the same.
    """
    begin = at
    at += 1
    if inward:
        for k in range(flags.shape[0]):
            i = flags[k]
            value = shared[i]
            if value != agreed[i]:
                agreed[i] = value
                own[i] = value
                at = _write_one(i, value, out, at)
        at = _scan(shared, own, agreed, guarded, sizes, True, out, at)
    else:
        at = _scan(own, shared, agreed, guarded, sizes, False, out, at)
        for k in range(flags.shape[0] - 1, -1, -1):  # what stands first in an area guards the most
            i = flags[k]
            value = own[i]
            if value != agreed[i]:
                _store(shared, value, agreed[i], i, sizes)
                agreed[i] = value
                at = _write_one(i, value, out, at)
    if at == begin + 1:
        return begin
    if begin < out.shape[0]:
        out[begin] = kind << 32 | (at - begin - 1)
    return at


@kernel
def apply_changes(changes: Words, own: Words, agreed: Words) -> None:
    """Write words of changes into the cycle's copy, as `take_in` did when they were recorded."""
    at = 0
    while at < changes.shape[0]:
        word, count = changes[at] >> 32, changes[at] & 0xFFFFFFFF
        at += 1
        for k in range(count):
            own[word + k] = changes[at + k]
            agreed[word + k] = changes[at + k]
        at += count


@warms("areas of the recorder")
def _warm() -> None:
    shared, own, agreed = (np.zeros(2, dtype=np.int64) for _ in range(3))
    spans, out, sizes = np.array([[0, 1]]), np.zeros(8, dtype=np.int64), np.full(16, 4, dtype=np.uint8)
    shared[0] = 1
    flags = np.array([1])
    used = exchange(1, True, shared, own, agreed, flags, spans, sizes, out, 0)
    own[0] = 2
    exchange(1, False, shared, own, agreed, flags, spans, sizes, out, 0)
    apply_changes(out[1:used], own, agreed)
