"""The frames of one bus: sent, handed to whom they are for by a table of COB-IDs, and counted for the load.

What an interface raises (`BUS_ERRORS`) comes through; whoever calls decides what it means.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Final

import can

from runtime.config.machine import Bus
from runtime.drives import BusFigures, DriveImage
from runtime.fieldbus import wire
from runtime.fieldbus.canopen_fd import CLASSIC, Heard
from runtime.fieldbus.links import Receiver
from runtime.fieldbus.network import as_fd, fill

MAX_FRAMES_PER_READ: Final = 256  # what comes faster than this waits for the next cycle
MAX_STALE_FRAMES: Final = 10_000
LOAD_WINDOW: Final = 100  # cycles over which the bus load is taken
BUS_ERRORS: Final = (can.CanError, OSError, ValueError)  # ValueError: select() on a closed socket


class Frames:
    """`on_error(class)` is told of error frames; `table` and `heard` are filled and read by the master."""

    def __init__(
        self, bus: can.BusABC, config: Bus, period: float, image: DriveImage, on_error: Callable[[int], None]
    ) -> None:
        self.bus = bus
        self.config = config
        self.table: dict[int, Receiver] = {}
        self.figures = BusFigures(config.channel)
        self._period = period
        self._image = image
        self._on_error = on_error
        self._frame_bits = wire.frame_bits(config)
        image.buses.append(self.figures)
        self.forget()

    def forget(self) -> None:
        """The state before the first cycle."""
        self.heard = Heard()
        self.taken = 0  # frames that were received, without error frames
        self.begin_load(gone=False)

    def discard(self) -> None:
        """What was on the bus before is of no interest."""
        for _ in range(MAX_STALE_FRAMES):
            if self.bus.recv(0) is None:
                break

    def send(self, message: can.Message) -> None:
        if self.config.fd:
            as_fd(message)
        self.bus.send(message)
        self._image.frames_sent += 1
        self._bits += self._frame_bits[len(message.data)]

    def send_data(self, cob_id: int, data: bytes) -> None:
        message = can.Message(arbitration_id=cob_id, is_extended_id=False, dlc=len(data))
        fill(message, data)
        self.send(message)

    def receive(self) -> bool:
        """Hand every frame that has come to its receiver; False if more may be waiting."""
        receive, table = self.bus.recv, self.table
        for count in range(MAX_FRAMES_PER_READ):
            message = receive(0)
            if message is None:
                self._image.frames_received += count
                return True
            if message.is_error_frame:
                self._on_error(message.arbitration_id)
                continue
            self.taken += 1
            data = message.data
            if message.is_extended_id or message.is_remote_frame or data is None:
                continue
            if len(data) > CLASSIC:
                self.heard.long_frame(message.arbitration_id, data, self.config.master_node)
                continue
            self._bits += self._frame_bits[len(data)]
            receiver = table.get(message.arbitration_id)
            if receiver is not None:
                receiver(data)
        self._image.frames_received += MAX_FRAMES_PER_READ
        return False

    # -- the load ----------------------------------------------------------------------------------------------------

    def begin_load(self, *, gone: bool) -> None:
        """Nothing is counted yet; `gone`: the bus is."""
        self._cycles, self._bits = 0, 0.0
        self._show(load=0.0, gone=gone)

    def measure(self) -> None:
        """A cycle is over."""
        self._cycles += 1
        if self._cycles == LOAD_WINDOW:
            load = self._bits / (LOAD_WINDOW * self._period * self.config.bitrate)
            self._cycles, self._bits = 0, 0.0
            self._show(load=load, gone=False)

    def _show(self, *, load: float, gone: bool) -> None:
        self.figures.load, self.figures.gone = load, gone
        self._image.bus_load = max(bus.load for bus in self._image.buses)
        self._image.buses_changed = True
