"""Devices of CANopen FD (CiA 1301) on a bus with frames of CAN FD: another application layer, which is told by its name.

The nodes of this runtime speak CiA 301, in classic frames or in frames of CAN FD. A device of CANopen FD boots and beats as they
do, but has no SDO: its service is USDO, where the first byte of a frame is the node that is meant, and the identifier names the
one that asks. What gives it away:

- frames of more than 8 bytes, which CiA 301 has not: its emergencies have 20, its PDOs up to 64;
- an answer to a question by USDO.
"""

from __future__ import annotations

from collections import Counter
from dataclasses import dataclass, field
from typing import Final

CLASSIC: Final = 8  # bytes that a frame of CiA 301 has at most
USDO_REQUEST: Final = 0x600  # and the node id of the one that asks
USDO_RESPONSE: Final = 0x580  # and that of the one that answers
UPLOAD: Final = 0x11  # command: read, in one frame
WAIT: Final = 0.1  # s for the answer
_PREDEFINED: Final = range(0x080, 0x780)


@dataclass(slots=True)
class Heard:
    """What was heard on a bus without having asked for it."""

    master: bool = False  # another one: its heartbeat or its SYNC
    boot_ups: Counter[int] = field(default_factory=Counter)  # by node id
    long_frames: set[int] = field(default_factory=set)  # node ids, 0 to 127
    usdo_answers: set[int] = field(default_factory=set)  # the same

    def long_frame(self, cob_id: int, data: bytearray, master: int) -> None:
        """A frame of more than 8 bytes."""
        if cob_id not in _PREDEFINED:
            return
        self.long_frames.add(cob_id & 0x7F)
        if cob_id & 0x780 == USDO_RESPONSE and data[0] == master:
            self.usdo_answers.add(cob_id & 0x7F)


def device_type_question(node: int) -> bytes:
    """The data of a USDO request for the device type: node, command, session, sub-index, index."""
    return bytes((node, UPLOAD, 0, 0, 0x00, 0x10))
