"""The bits of the I/O nodes of one bus, from and to the image that all buses share."""

from __future__ import annotations

from collections.abc import Callable

import can
import numpy as np

from runtime.drives import DIGITAL_BYTES, DriveImage
from runtime.fieldbus.exchange import IO_REFRESH
from runtime.fieldbus.links import IoLink, Links


class IoExchange:
    """`send` puts a frame on the bus; what it raises comes through. Drives have inputs too (object 0x60FD)."""

    def __init__(self, image: DriveImage, links: Links, send: Callable[[can.Message], None]) -> None:
        self._image = image
        self._links = [link for link in links if isinstance(link, IoLink)]
        self._inputs_of = [link for link in links if isinstance(link, IoLink) or link.has_inputs]
        self._send = send
        self._inputs = 0  # as published, at their place among all bits
        self._last_outputs = b""
        self._next_outputs = 0.0  # s

    def publish(self) -> None:
        """The inputs of these nodes into the image; those of other buses stay."""
        bits = 0
        for link in self._inputs_of:
            bits |= link.input_bits()
        if bits == self._inputs:
            return
        image = self._image
        inputs = int.from_bytes(image.digital_in.tobytes(), "little") ^ self._inputs ^ bits
        self._inputs = bits
        image.digital_in[:] = np.frombuffer(inputs.to_bytes(DIGITAL_BYTES, "little"), dtype=np.uint8)

    def send_outputs(self, now: float) -> None:
        """Outputs go out when they change, and now and then for nodes that missed it."""
        if not self._links:
            return
        outputs = self._image.digital_out.tobytes()
        due = now >= self._next_outputs
        if outputs == self._last_outputs and not due:
            return
        if due:
            self._next_outputs = now + IO_REFRESH
        self._last_outputs = outputs
        bits = int.from_bytes(outputs, "little")
        for link in self._links:
            if (link.command(bits) or due) and link.message is not None:
                self._send(link.message)

    def refresh(self) -> None:
        """The next outputs go out whether they changed or not."""
        self._next_outputs = 0.0
