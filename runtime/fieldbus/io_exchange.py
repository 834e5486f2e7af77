"""The bits and the analogue values of the I/O nodes of one bus, from and to the image that all buses share."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import can
import numpy as np

from runtime.drives import DIGITAL_BYTES, DriveEvent, DriveImage
from runtime.fieldbus.exchange import IO_REFRESH
from runtime.fieldbus.links import IoLink, Links


class IoExchange:
    """`send` puts a frame on the bus; what it raises comes through.

    Drives have inputs too (object 0x60FD).
    """

    def __init__(self, image: DriveImage, links: Links, send: Callable[[can.Message], None]) -> None:
        self._image = image
        self._links = [link for link in links if isinstance(link, IoLink)]
        self._inputs_of = [link for link in links if isinstance(link, IoLink) or link.has_inputs]
        self._analogue = [link for link in self._links if link.analogue.inputs or link.analogue.outputs]
        self._send = send
        self._inputs = 0  # as published, at their place among all bits
        self._last_outputs = b""
        self._last_values = b""
        self._next_outputs = 0.0  # s

    def publish(self, now: float) -> None:
        """The inputs of these nodes into the image; those of other buses stay. `now`: of this cycle, s."""
        for node in self._analogue:
            if node.analogue.changed or node.lost is not node.analogue.was_lost:
                node.analogue.publish(self._image, lost=node.lost, now=now, event=partial(self._event, node))
        bits = 0
        for link in self._inputs_of:
            bits |= link.input_bits()
        if bits == self._inputs:
            return
        image = self._image
        inputs = int.from_bytes(image.digital_in.tobytes(), "little") ^ self._inputs ^ bits
        self._inputs = bits
        image.digital_in[:] = np.frombuffer(inputs.to_bytes(DIGITAL_BYTES, "little"), dtype=np.uint8)

    def _event(self, node: IoLink, error_id: int, text: str) -> DriveEvent:
        return node.event(error_id, 0, text)

    def send_outputs(self, now: float) -> None:
        """Outputs go out when they change, and now and then for nodes that missed it."""
        if not self._links:
            return
        outputs = self._image.digital_out.tobytes()
        due = now >= self._next_outputs
        if self._analogue:
            values = self._image.analogue_out.tobytes()
            if due or values != self._last_values:
                self._last_values = values
                for node in self._analogue:
                    for message in node.analogue.command(self._image, due=due):
                        self._send(message)
        if outputs == self._last_outputs and not due:
            return
        if due:
            self._next_outputs = now + IO_REFRESH
        self._last_outputs = outputs
        bits = int.from_bytes(outputs, "little")
        for link in self._links:
            if (link.command(bits) or due) and link.message is not None:
                self._send(link.message)

    def switch_off(self) -> None:
        """The analogue outputs at the end; the bits are all FALSE then."""
        for node in self._analogue:
            node.analogue.switch_off(self._image)

    def refresh(self) -> None:
        """The next outputs go out whether they changed or not."""
        self._next_outputs = 0.0
