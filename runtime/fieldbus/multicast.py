"""python-can's CAN over UDP multicast, for several processes on one computer, without the echo.

A multicast socket hears what it sends itself, and python-can cannot tell: half of all frames received would be our
own. Frames carry a mark of their sender in the message's channel, which the protocol has room for; other python-can
users are understood, and understand.
"""

from __future__ import annotations

import uuid

import can
from can.interfaces.udp_multicast import UdpMulticastBus
from can.interfaces.udp_multicast.utils import pack_message, unpack_message


class MulticastBus(UdpMulticastBus):
    """A CAN bus on the multicast group `channel`; with `hop_limit` 0 frames never leave this computer."""

    def __init__(self, channel: str, port: int = 43113, hop_limit: int = 0) -> None:
        self._mark = uuid.uuid4().hex
        self._mark_bytes = self._mark.encode()
        super().__init__(channel, port, hop_limit)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Raises can.CanOperationError."""
        msg.channel = self._mark
        self._multicast.send(pack_message(msg), timeout)

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        while True:
            received = self._multicast.recv(timeout)
            if received is None:
                return None, False
            data, _, timestamp = received
            if self._mark_bytes in data:
                continue
            try:
                return unpack_message(data, replace={"timestamp": timestamp}, check=True), False
            except Exception:  # anybody may send anything to the group; msgpack and Message raise of many kinds
                continue
