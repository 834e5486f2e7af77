"""One record: what a cycle took in and gave out, as words of 8 bytes.

    | words in all | number of the cycle | time (float) | wall clock, ns | marks |  section  section  …
    section:  | kind << 32 | words | …

The sections stand in the order in which things happened. A cycle in which nothing of a kind has changed has no section of it.
"""

from __future__ import annotations

import json
from collections.abc import Iterator
from dataclasses import dataclass
from enum import IntEnum
from typing import Any

import numpy as np
import numpy.typing as npt

Words = npt.NDArray[np.int64]

HEAD = 5
GAP = 1  # mark: records before this one were dropped
KEYFRAME = 2  # mark: the state in front of this cycle stands in the records from this one on


class Section(IntEnum):
    """What stands in a section. Up to AFTER_PLC: taken in; from BEFORE_PLC on: given out."""

    CALLS = 1  # what the process did with the controller before the cycle, JSON
    KEYFRAME_QUEUE = 2  # counters of the consumer
    KEYFRAME_AREA = 3  # area | first word | words
    KEYFRAME_RING = 4  # ring of the way that is kept | first | records, as those of the queue
    KEYFRAME_STATE = 5  # a piece of the state of the objects, JSON
    KEYFRAME_END = 6  # 1: everything was told, 0: it was given up
    FIGURES = 10  # of the drive image: bus load, EMCY, frames
    BUSES = 11  # load and state of each bus, JSON
    DRIVE_EVENTS = 12  # JSON
    IMAGE = 13  # changes of the drive image
    HLI = 14
    LINK = 15
    QUEUE = 16  # records written, program names, texts, sets of limits ever put, functions ahead
    QUEUE_NAMES = 17  # first | names
    QUEUE_TEXTS = 18  # first | texts
    QUEUE_LIMITS = 19  # first | sets
    QUEUE_RECORDS = 20  # first | records, each with its coefficients if it is a polynomial
    AFTER_PLC = 25  # changes of the HLI by a PLC in the same process
    BEFORE_PLC = 30  # changes of the HLI
    HLI_OUT = 31
    LINK_OUT = 32
    IMAGE_OUT = 33
    QUEUE_READ = 34


@dataclass(frozen=True, slots=True)
class CycleRecord:
    """A record, taken apart: `time` s since the start of the runtime, `wall_ns` since 1970."""

    cycle: int
    time: float
    wall_ns: int
    marks: int
    sections: tuple[tuple[int, Words], ...]
    words: int

    def section(self, kind: Section) -> Words | None:
        """The first section of a kind."""
        number = int(kind)  # an enum is slow to compare
        for found, words in self.sections:
            if found == number:
                return words
        return None


def records_of(words: Words) -> Iterator[CycleRecord]:
    """The records in whole ones; ValueError if they are none."""
    at = 0
    while at < len(words):
        count = int(words[at])
        if count < HEAD or at + count > len(words):
            raise ValueError(f"a record of {count} words in {len(words) - at}")
        yield parse(words[at : at + count])
        at += count


def parse(record: Words) -> CycleRecord:
    """Take one apart. Raises ValueError if it is damaged."""
    sections = []
    at, end = HEAD, int(record[0])
    while at < end:
        kind, count = int(record[at]) >> 32, int(record[at]) & 0xFFFFFFFF
        at += 1
        if at + count > end:
            raise ValueError(f"section {kind} of {count} words in {end - at}")
        sections.append((kind, record[at : at + count]))
        at += count
    time = float(record[2:3].view(np.float64)[0])
    return CycleRecord(int(record[1]), time, int(record[3]), int(record[4]), tuple(sections), end)


def text_words(value: Any) -> Words:
    """JSON as words, filled up with spaces."""
    data = json.dumps(value, separators=(",", ":")).encode()
    return np.frombuffer(data.ljust(-(-len(data) // 8) * 8, b" "), dtype=np.int64)


def value_of(words: Words) -> Any:
    """The other way round."""
    return json.loads(words.tobytes())
