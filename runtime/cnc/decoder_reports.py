"""What the decoder tells at decoding time on its way to the cycle, which alone may write events and the HLI.

A ring of fixed records beside the preparation link. Numbers count from 1 and never begin anew, so that an answer to a message
of an earlier program is never taken for one of a later.
"""

from __future__ import annotations

import mmap
from enum import IntEnum
from typing import NamedTuple

import numpy as np

REPORTS = 16  # beside the ten messages that may wait for the PLC
_TEXT = 256
HEAD = 64  # bytes: put, taken by the cycle, number of the last message that the PLC has taken
RECORD = np.dtype(
    [("kind", "i4"), ("line", "i4"), ("n", "i4"), ("receiver", "i4"), ("information", "i4"), ("program", "S248"),
     ("text", f"S{_TEXT}")],
    align=True,
)  # fmt: skip
REPORTS_BYTES = HEAD + REPORTS * RECORD.itemsize


class ReportKind(IntEnum):
    """What is told."""

    MESSAGE = 0
    WARNING = 1  # #ERROR without consequences
    NOTICED = 2  # a warning of the decoder or of a stage behind it


class Report(NamedTuple):
    """One of them; `receiver` is the position in `blocks.Receiver`, of NOTICED the number of the warning."""

    kind: ReportKind
    text: str
    program: str
    line: int
    n: int | None
    receiver: int = 0
    information: bool = False


class DecoderReports:
    """The ring in `buffer` from byte `offset` (a multiple of 8) on; REPORTS_BYTES bytes, zero at first."""

    def __init__(self, buffer: mmap.mmap | bytearray, offset: int) -> None:
        self._counters = np.frombuffer(buffer, dtype=np.int64, count=3, offset=offset)
        self._records = np.frombuffer(buffer, dtype=RECORD, count=REPORTS, offset=offset + HEAD)

    # ------------------------------------------------------------------ the preparation's side

    @property
    def free(self) -> int:
        """Reports that `put` will take now."""
        return REPORTS - int(self._counters[0] - self._counters[1])

    @property
    def last(self) -> int:
        """Number of the report that was put last, 0 before the first."""
        return int(self._counters[0])

    def put(self, report: Report) -> int:
        """Hand over a report; its number. Only while there is room."""
        index = int(self._counters[0])
        record = self._records[index % REPORTS : index % REPORTS + 1]
        record["kind"], record["line"], record["receiver"] = report.kind, report.line, report.receiver
        record["n"] = -1 if report.n is None else report.n
        record["information"] = report.information
        record["program"] = report.program.encode("utf-8", "replace")[-248:]
        record["text"] = report.text.encode("utf-8", "replace")[:_TEXT].decode("utf-8", "ignore").encode()
        self._counters[0] = index + 1
        return index + 1

    def was_told(self, number: int) -> bool:
        """The cycle has passed it on."""
        return number <= int(self._counters[1])

    def was_taken(self, number: int) -> bool:
        """The PLC has taken the message."""
        return number <= int(self._counters[2])

    # ------------------------------------------------------------------ the cycle's side

    @property
    def waiting(self) -> bool:
        """There is a report that was not taken over."""
        return int(self._counters[0]) > int(self._counters[1])

    def take(self) -> tuple[int, Report]:
        """The oldest report and its number; only while one is `waiting`."""
        index = int(self._counters[1])
        record = self._records[index % REPORTS]
        n = int(record["n"])
        report = Report(
            ReportKind(int(record["kind"])),
            bytes(record["text"]).decode("utf-8", "replace"),
            bytes(record["program"]).decode("utf-8", "replace"),
            int(record["line"]),
            None if n < 0 else n,
            int(record["receiver"]),
            bool(record["information"]),
        )
        self._counters[1] = index + 1
        return index + 1, report

    def confirm(self, number: int) -> None:
        """The PLC has taken the message with this number, and all before it."""
        self._counters[2] = number
