"""The LSS slave of a simulated node (CiA 305)."""

from __future__ import annotations

import struct
from collections.abc import Callable
from typing import Final

from canopen import lss as wire

from runtime.fieldbus.lss import BITRATES, CONFIGURATION, FROM_SLAVES, SCAN_START, UNCONFIGURED, WAITING, Identity

INADMISSIBLE: Final = 1


class LssSlave:
    """`send(cob_id, data)` puts an answer on the bus. `node_id` is what was set last, in effect or not."""

    def __init__(self, identity: Identity, node_id: int, send: Callable[[int, bytes], None]) -> None:
        self.identity = identity
        self.node_id = node_id
        self.stored = node_id  # what it keeps without supply
        self.bitrate: int | None = None  # as set, bit/s
        self.activated: float | None = None  # s of delay with which the bit rate was changed over
        self.configuring = False
        self._send = send
        self._selected = 0  # parts of the identity that agreed so far
        self._scan_part = 0

    def on_frame(self, data: bytearray) -> bool:
        """A frame of the master; True if the node leaves the configuration state."""
        if len(data) != 8:
            return False
        service = data[0]
        number: int = struct.unpack_from("<I", data, 1)[0]
        offset = service - wire.CS_SWITCH_STATE_SELECTIVE_VENDOR_ID
        if service == wire.CS_SWITCH_STATE_GLOBAL:
            was, self.configuring = self.configuring, data[1] == CONFIGURATION
            return was and data[1] == WAITING
        if 0 <= offset < 4:
            self._select(offset, number)
        elif service == wire.CS_FAST_SCAN:
            self._fast_scan(number, *data[5:8])
        elif self.configuring:
            self._configure(service, data)
        return False

    def _select(self, part: int, number: int) -> None:
        if part == 0:
            self._selected = 0
        self._selected = self._selected + 1 if part == self._selected and number == self.identity[part] else -1
        if self._selected == 4 and not self.configuring:
            self.configuring = True
            self._answer(wire.CS_SWITCH_STATE_SELECTIVE_RESPONSE)

    def _fast_scan(self, number: int, bit: int, part: int, following: int) -> None:
        """Only nodes without a node id that wait take part."""
        if self.node_id != UNCONFIGURED or self.configuring:
            return
        if bit == SCAN_START:
            self._scan_part = 0
            self._answer(wire.CS_IDENTIFY_SLAVE)
        elif part == self._scan_part and bit < 32 and number >> bit == self.identity[part] >> bit:
            if bit == 0 and following != part:
                self._scan_part = following
                self.configuring = following < part
            self._answer(wire.CS_IDENTIFY_SLAVE)

    def _configure(self, service: int, data: bytearray) -> None:
        error = 0
        if service == wire.CS_CONFIGURE_NODE_ID:
            if 1 <= data[1] <= 127 or data[1] == UNCONFIGURED:
                self.node_id = data[1]
            else:
                error = INADMISSIBLE
        elif service == wire.CS_CONFIGURE_BIT_TIMING:
            rates = {selector: rate for rate, selector in BITRATES.items()}
            if data[1] == 0 and data[2] in rates:
                self.bitrate = rates[data[2]]
            else:
                error = INADMISSIBLE
        elif service == wire.CS_ACTIVATE_BIT_TIMING:
            self.activated = struct.unpack_from("<H", data, 1)[0] / 1000.0
            return
        elif service == wire.CS_STORE_CONFIGURATION:
            self.stored = self.node_id
        elif wire.CS_INQUIRE_VENDOR_ID <= service <= wire.CS_INQUIRE_SERIAL_NUMBER:
            self._answer(service, struct.pack("<I", self.identity[service - wire.CS_INQUIRE_VENDOR_ID]))
            return
        elif service == wire.CS_INQUIRE_NODE_ID:
            self._answer(service, bytes((self.node_id,)))
            return
        else:
            return
        self._answer(service, bytes((error,)))

    def _answer(self, service: int, data: bytes = b"") -> None:
        self._send(FROM_SLAVES, bytes((service, *data)).ljust(8, b"\0"))
