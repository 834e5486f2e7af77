"""canopen's network without threads: whoever owns it feeds frames in and lets time pass.

`canopen.Network` receives in a notifier thread and sends periodic frames from another one. Both are replaced by
calls, so that the same objects (SDO server and client, NMT, EMCY) run in a cycle and under a virtual clock.
"""

from __future__ import annotations

import logging
import struct
from collections.abc import Callable

import can
import canopen
from canopen.sdo.client import SdoClient
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

# What it has to say comes as an exception too, and is told in words of our own; without a handler it would stand between them.
logging.getLogger("canopen").setLevel(logging.CRITICAL)

Wait = Callable[[Callable[[], bool], float], bool]
"""`wait(condition, seconds)`: let bus and time run until the condition holds; False if the time went by."""


def fill(message: can.Message, data: bytes) -> None:
    """New data, of the message's length, for a message that may be sent again and again.

    As bytes: python-can's virtual bus copies every frame deeply, and a bytearray is ten times as slow to copy.
    """
    message.data = data  # type: ignore[assignment]


def as_fd(message: can.Message) -> None:
    """Make it a frame of CAN FD with the bit rate switch; a remote frame, which CAN FD has not, stays what it is."""
    message.is_fd = message.bitrate_switch = not message.is_remote_frame


class PeriodicFrame:
    """A frame sent every `period` seconds of the network's time; what canopen uses for heartbeats."""

    def __init__(self, network: PolledNetwork, can_id: int, data: bytes, period: float, due: float) -> None:
        self._network = network
        self.can_id = can_id
        self.data = bytes(data)
        self.period = period
        self.due = due

    def update(self, data: bytes) -> None:
        self.data = bytes(data)

    def stop(self) -> None:
        self._network.forget(self)


class PolledNetwork(canopen.Network):
    """A canopen network on an open bus; nothing happens but in calls."""

    def __init__(self, bus: can.BusABC, *, fd: bool = False) -> None:
        super().__init__(bus)
        self._open_bus = bus
        self._fd = fd
        self._periodic: list[PeriodicFrame] = []
        self._time = 0.0

    def send_message(self, can_id: int, data: bytes, remote: bool = False) -> None:
        """Send at once. Raises can.CanError."""
        message = can.Message(arbitration_id=can_id, is_extended_id=False, is_remote_frame=remote, dlc=len(data))
        fill(message, bytes(data))
        if self._fd:
            as_fd(message)
        self._open_bus.send(message)

    def send_periodic(self, can_id: int, data: bytes, period: float, remote: bool = False) -> PeriodicFrame:  # type: ignore[override]
        """Send in `step`, first after one period."""
        frame = PeriodicFrame(self, can_id, data, period, self._time + period)
        self._periodic.append(frame)
        return frame

    def forget(self, frame: PeriodicFrame) -> None:
        """Send this periodic frame no more."""
        if frame in self._periodic:
            self._periodic.remove(frame)

    def step(self, now: float) -> None:
        """Let the time be `now` (s): send the periodic frames that are due."""
        self._time = now
        for frame in self._periodic:
            if now >= frame.due:
                # keep the raster, but don't catch up on what a late call missed
                frame.due = max(frame.due + frame.period, now)
                self.send_message(frame.can_id, frame.data)

    def receive(self, message: can.Message) -> None:
        """Hand a received frame to its subscribers. Frames that canopen cannot read are dropped."""
        if message.is_error_frame or message.is_remote_frame or message.is_extended_id:
            return
        try:
            self.notify(message.arbitration_id, message.data, message.timestamp)
        except (struct.error, IndexError, KeyError, TypeError):
            return  # too short, or out of turn


class PumpedSdoClient(SdoClient):
    """An SDO client that, while it waits for an answer, lets the bus run by `wait`."""

    MAX_RETRIES = 3
    RETRY_DELAY = 0.0  # no sleeping on a clock that is not ours

    def __init__(self, node: int, od: canopen.ObjectDictionary, wait: Wait) -> None:
        super().__init__(0x600 + node, 0x580 + node, od)  # type: ignore[no-untyped-call]
        self._wait = wait

    def take(self, data: bytearray) -> None:
        """A frame of the server."""
        self.on_response(self.tx_cobid, data, 0.0)  # type: ignore[no-untyped-call]

    def read_response(self) -> bytes:
        """The answer; raises SdoAbortedError or, after the time-out, SdoCommunicationError."""
        if not self._wait(lambda: not self.responses.empty(), self.RESPONSE_TIMEOUT):
            raise SdoCommunicationError("no answer")
        response: bytes = self.responses.get_nowait()
        if len(response) < 8:
            raise SdoCommunicationError(f"an answer of {len(response)} bytes")
        if response[0] == 0x80:
            raise SdoAbortedError(int.from_bytes(response[4:8], "little"))
        return response
