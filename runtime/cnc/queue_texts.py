"""Texts of the records in the motion queue: a small ring of slots beside it, since few records have one.

The producer puts the text in, and its index into the record; the consumer takes it out when the record is passed, in the same
order. When all slots are in use the producer waits, as with a full queue.
"""

from __future__ import annotations

import mmap

import numpy as np

TEXTS = 64
TEXT_BYTES = 256
_HEAD = 64  # bytes: put, taken
TEXTS_BYTES = _HEAD + TEXTS * TEXT_BYTES


class QueueTexts:
    """The ring in `buffer` from byte `offset` on; TEXTS_BYTES bytes, zero at first."""

    def __init__(self, buffer: mmap.mmap | bytearray, offset: int) -> None:
        self.counters = np.frombuffer(buffer, dtype=np.int64, count=2, offset=offset)
        self.slots = np.frombuffer(buffer, dtype=f"S{TEXT_BYTES}", count=TEXTS, offset=offset + _HEAD)

    @property
    def free(self) -> int:
        """Texts that `put` will take now."""
        return TEXTS - int(self.counters[0] - self.counters[1])

    def put(self, text: str) -> int:
        """Keep a text, cut to TEXT_BYTES bytes; its index. Producer only, and only while `free`."""
        index = int(self.counters[0])
        self.slots[index % TEXTS] = text.encode("utf-8", "replace")[:TEXT_BYTES].decode("utf-8", "ignore").encode()
        self.counters[0] = index + 1
        return index

    def take(self, index: int) -> str:
        """The text of an index, -1 for none; frees its slot and those before it. Consumer only."""
        if index < 0:
            return ""
        text = bytes(self.slots[index % TEXTS]).decode("utf-8", "replace")
        self.counters[1] = max(int(self.counters[1]), index + 1)
        return text

    def discard_all(self) -> None:
        """Free every slot. Consumer only, while the producer does not write."""
        self.counters[1] = self.counters[0]
