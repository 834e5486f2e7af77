"""CAN over UDP multicast, for several processes on one computer: python-can's protocol, without the echo and without
a network.

A multicast socket hears what it sends itself. Frames carry a mark of their sender in the message's channel, which the
protocol has room for; other python-can users are understood, and understand.

An IPv4 group that never leaves this computer (`hop_limit` 0) lives on the loopback interface: it needs neither a network
card nor a route, so that the demo machine runs in a closed container too. (Linux routes no IPv6 multicast there.) Nobody outside
reaches it: the socket takes what is sent to the group, on the interface where it was joined, and nothing that is sent to an
address of this computer.
"""

from __future__ import annotations

import select
import socket
import struct
import uuid

import can
from can.interfaces.udp_multicast.utils import pack_message, unpack_message

_LARGEST = 4096  # bytes of a datagram; a frame has about 200
_IP_MULTICAST_ALL = 49  # ip(7); Python does not name it
_RECEIVE_BUFFER = 4 << 20  # bytes; the kernel gives what it allows


class MulticastBus(can.BusABC):
    """A CAN bus on the multicast group `channel`; with `hop_limit` 0 frames never leave this computer."""

    def __init__(self, channel: str, port: int = 43113, hop_limit: int = 0) -> None:
        """Raises can.CanInitializationError, its cause the OSError."""
        self._mark = uuid.uuid4().hex
        self._mark_bytes = self._mark.encode()
        family, _, _, _, address = socket.getaddrinfo(channel, port, type=socket.SOCK_DGRAM)[0]
        self._address = address
        self._socket = socket.socket(family, socket.SOCK_DGRAM)
        try:
            self._join(family, hop_limit)
        except OSError as error:
            self._socket.close()
            raise can.CanInitializationError(error.strerror or str(error), error.errno) from error
        super().__init__(channel)
        self.channel_info = f"multicast group {channel}, port {port}"

    def _join(self, family: int, hop_limit: int) -> None:
        """Membership, destination and reach of the socket. Raises OSError."""
        options = self._socket.setsockopt
        options(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        options(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        options(socket.SOL_SOCKET, socket.SO_RCVBUF, _RECEIVE_BUFFER)
        group = socket.inet_pton(family, str(self._address[0]))
        self._socket.bind(self._address)
        if family == socket.AF_INET:
            interface = socket.inet_aton("0.0.0.0" if hop_limit else "127.0.0.1")
            options(socket.IPPROTO_IP, _IP_MULTICAST_ALL, 0)
            options(socket.IPPROTO_IP, socket.IP_MULTICAST_TTL, hop_limit)
            options(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group + interface)
            options(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, interface)
        else:
            options(socket.IPPROTO_IPV6, socket.IPV6_MULTICAST_HOPS, hop_limit)
            options(socket.IPPROTO_IPV6, socket.IPV6_JOIN_GROUP, group + struct.pack("@I", 0))
        self._socket.setblocking(False)

    def send(self, msg: can.Message, timeout: float | None = None) -> None:
        """Raises can.CanOperationError."""
        msg.channel = self._mark
        try:
            self._socket.sendto(pack_message(msg), self._address)
        except OSError as error:
            raise can.CanOperationError(error.strerror or str(error), error.errno) from error

    def _recv_internal(self, timeout: float | None) -> tuple[can.Message | None, bool]:
        waited = timeout == 0.0
        while True:
            try:
                data = self._socket.recv(_LARGEST)
            except BlockingIOError:
                if waited or not select.select([self._socket], [], [], timeout)[0]:
                    return None, False
                waited = timeout is not None  # BusABC.recv calls again as long as there is time left
                continue
            except OSError as error:
                raise can.CanOperationError(error.strerror or str(error), error.errno) from error
            if self._mark_bytes in data:
                continue
            try:
                return unpack_message(data, check=True), False
            except Exception:  # anybody may send anything to the group; msgpack and Message raise of many kinds
                continue

    def fileno(self) -> int:
        return self._socket.fileno()

    def shutdown(self) -> None:
        """Close the socket; again and again if one likes."""
        super().shutdown()
        self._socket.close()
