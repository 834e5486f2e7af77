"""One SDO access at a time while the cycle runs: asked in one cycle, answered in a later one, nobody waits.

What has up to 4 bytes goes in one frame (expedited), more of a write in segments of 7 bytes, one per answer. A segment that is
not answered begins the whole transfer anew: the node may have taken it, and would refuse it a second time.
"""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Final

from runtime.fieldbus.dialogue import Access, aborted, decoded, encoded, silent
from runtime.fieldbus.links import DriveLink, IoLink

ANSWER_LIMIT: Final = 0.5  # s for an answer
QUESTIONS: Final = 3  # times that the same is asked

UPLOAD: Final = 0x40  # command specifiers of an expedited SDO transfer (CiA 301)
UPLOADED: Final = 0x43
DOWNLOAD: Final = 0x23
DOWNLOADED: Final = 0x60
SEGMENTED: Final = 0x21  # a download of so many bytes follows
SEGMENT_TAKEN: Final = 0x20
TOGGLE: Final = 0x10
SEGMENT: Final = 7  # bytes
EXPEDITED: Final = 4
ABORT: Final = 0x80
_SPECIFIER: Final = 0xE3  # without the bits that tell the number of unused bytes


class Questions:
    """To one node. `send(cob_id, data)` puts a frame on the bus; what it raises comes through."""

    def __init__(self, link: DriveLink | IoLink, send: Callable[[int, bytes], None]) -> None:
        self._link = link
        self._send = send
        self.open: Access | None = None  # the one that waits for its answer
        self._answer: bytes | None = None
        self._frame = b""
        self._begin = b""  # the frame with which a segmented transfer begins
        self._rest = b""  # what is still to be sent of it
        self._data = b""
        self._toggle = 0
        self._asked = 0  # times
        self._limit = 0.0  # s, end of the patience

    def ask(self, access: Access, now: float) -> None:
        """Begin an access. Raises FieldbusError for an object that the EDS does not have."""
        head = struct.pack("<HB", access.index, access.subindex)
        self._data = self._begin = b""
        if access.reads:
            frame = bytes((UPLOAD,)) + head + bytes(4)
        elif len(data := encoded(self._link, access)) <= EXPEDITED:
            frame = bytes((DOWNLOAD | 4 - len(data) << 2,)) + head + data.ljust(4, b"\0")
        else:
            frame = self._begin = bytes((SEGMENTED,)) + head + len(data).to_bytes(4, "little")
            self._data = data
        self.open, self._frame, self._answer, self._asked = access, frame, None, 0
        self._put(now)

    def forget(self) -> None:
        """An answer is waited for no more."""
        self.open = self._answer = None

    def on_answer(self, data: bytes | bytearray) -> None:
        """A frame of the node's SDO server."""
        if len(data) == 8 and self.open is not None:
            if self._frame is not self._begin and self._data and data[0] == SEGMENT_TAKEN | self._toggle:
                self._answer = bytes(data)
                return
            index, subindex = struct.unpack_from("<HB", data, 1)
            if (index, subindex) == (self.open.index, self.open.subindex):  # else it answers what was asked before
                self._answer = bytes(data)

    def poll(self, now: float) -> int | None:
        """The number that was read, 0 after a write; None as long as there is no answer.

        Raises FieldbusError for a refusal, and after the last question without an answer.
        """
        access, answer = self.open, self._answer
        if access is None:
            return None
        if answer is not None:
            if self._data and answer[0] in (DOWNLOADED, SEGMENT_TAKEN | self._toggle) and self._next_segment(answer):
                self._answer = None
                self._send_frame(now)
                return None
            self.forget()
            return self._understood(access, answer)
        if now > self._limit:
            if self._data:
                self._frame = self._begin
            if self._asked >= QUESTIONS:
                self.forget()
                raise silent(self._link, access, "no answer")
            self._put(now)
        return None

    def _put(self, now: float) -> None:
        """Ask, or ask again: question or answer may have been lost, and all of them may be carried out twice."""
        self._asked += 1
        self._send_frame(now)

    def _send_frame(self, now: float) -> None:
        self._limit = now + ANSWER_LIMIT
        self._send(0x600 + self._link.node, self._frame)

    def _next_segment(self, answer: bytes) -> bool:
        """Whether another segment has to be sent; the last one is answered like a write in one frame."""
        if answer[0] == DOWNLOADED:
            self._rest, self._toggle = self._data, 0
        elif not self._rest:
            return False
        else:
            self._toggle ^= TOGGLE
        segment, self._rest = self._rest[:SEGMENT], self._rest[SEGMENT:]
        head = self._toggle | SEGMENT - len(segment) << 1 | (not self._rest)
        self._frame = bytes((head,)) + segment.ljust(SEGMENT, b"\0")
        return True

    def _understood(self, access: Access, answer: bytes) -> int:
        if answer[0] == ABORT:
            raise aborted(self._link, access, int.from_bytes(answer[4:], "little"))
        if not access.reads:
            if answer[0] != (SEGMENT_TAKEN | self._toggle if self._data else DOWNLOADED):
                raise silent(self._link, access, f"an answer that is none (0x{answer[0]:02X})")
            return 0
        if answer[0] & _SPECIFIER != UPLOADED & _SPECIFIER:
            raise silent(self._link, access, f"an answer that is no number (0x{answer[0]:02X})")
        unused = answer[0] >> 2 & 3 if answer[0] & 1 else 0
        return decoded(self._link, access, answer[4 : 8 - unused])
