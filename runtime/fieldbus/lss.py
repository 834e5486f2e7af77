"""Layer setting services (CiA 305): node id and bit rate of nodes that have no switches for them.

A node is known by its identity (object 0x1018: vendor, product, revision, serial number). The master puts one node, or the only
one on the bus, into the configuration state, sets it, lets it store what was set, and puts all back into the waiting state.

    waiting ── switch by identity, switch globally, fast scan ──▶ configuration ── switch globally ──▶ waiting

canopen has a master of its own; it sleeps on the wall clock, and does not tell what a node answers.
"""

from __future__ import annotations

import struct
from collections.abc import Iterator
from typing import Final, NamedTuple

from canopen import lss as wire

from runtime.diagnostics.catalogue import commissioning as errors
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.network import PolledNetwork, Wait

TO_SLAVES: Final = 0x7E5
FROM_SLAVES: Final = 0x7E4
WAITING: Final = 0
CONFIGURATION: Final = 1
UNCONFIGURED: Final = 0xFF  # node id of a node that has none yet
SCAN_START: Final = 0x80  # "bit checked" of the first question of a fast scan

# Table of bit rates in bit/s, CiA 305 (5 is reserved, 9 is automatic).
BITRATES: Final = {1_000_000: 0, 800_000: 1, 500_000: 2, 250_000: 3, 125_000: 4, 50_000: 6, 20_000: 7, 10_000: 8}

ANSWER: Final = 0.1  # s for an answer
STORE_ANSWER: Final = 2.0  # s: memory that is erased and written takes its time
SEVERAL: Final = 0.05  # s in which a second node would answer too
FAST_SCAN_ANSWER: Final = 0.02  # s; a fast scan asks 132 times, and half of the questions have no answer

_REFUSALS: Final = {
    (wire.CS_CONFIGURE_NODE_ID, 1): "the node id is outside of 1 to 127",
    (wire.CS_CONFIGURE_BIT_TIMING, 1): "it does not know this bit rate",
    (wire.CS_STORE_CONFIGURATION, 1): "it cannot store its settings",
    (wire.CS_STORE_CONFIGURATION, 2): "its memory cannot be written",
}


class Identity(NamedTuple):
    """Object 0x1018 of a node, which no other node has."""

    vendor: int
    product: int
    revision: int
    serial: int

    def __str__(self) -> str:
        return "vendor 0x{:X}, product 0x{:X}, revision 0x{:X}, serial 0x{:X}".format(*self)


class LssMaster:
    """The master's side. Every method raises FieldbusError (303100 to 303103) and can.CanError.

    `wait(condition, seconds)` lets bus and time run.
    """

    def __init__(self, network: PolledNetwork, wait: Wait) -> None:
        self._network = network
        self._wait = wait
        self._answers: list[bytes] = []
        network.subscribe(FROM_SLAVES, self._on_answer)

    def _on_answer(self, can_id: int, data: bytearray, timestamp: float) -> None:
        if len(data) == 8:
            self._answers.append(bytes(data))

    # -- who is meant ------------------------------------------------------------------------------------------------

    def deselect(self) -> None:
        """All nodes wait again. A node that got its first node id boots with it."""
        self._send(wire.CS_SWITCH_STATE_GLOBAL, bytes((WAITING,)))

    def select(self, identity: Identity) -> None:
        """Put the node of this identity, and only this one, into the configuration state."""
        self.deselect()
        for offset, number in enumerate(identity):
            self._answers.clear()
            self._send(wire.CS_SWITCH_STATE_SELECTIVE_VENDOR_ID + offset, struct.pack("<I", number))
        if self._answer(wire.CS_SWITCH_STATE_SELECTIVE_RESPONSE, ANSWER) is None:
            raise FieldbusError(errors.LSS_NO_NODE, whom=f"a node of {identity}")

    def select_only(self) -> Identity:
        """Put the only node of the bus into the configuration state; its identity.

        Refused if several answer: what is set would be set in all of them.
        """
        self._answers.clear()
        self._send(wire.CS_SWITCH_STATE_GLOBAL, bytes((CONFIGURATION,)))
        self._send(wire.CS_INQUIRE_SERIAL_NUMBER, b"")
        self._wait(lambda: len(self._answers) > 1, ANSWER + SEVERAL)
        if len(self._answers) != 1:
            count = len(self._answers)
            self.deselect()
            if count:
                raise FieldbusError(errors.LSS_SEVERAL)
            raise FieldbusError(errors.LSS_NO_NODE, whom="any node")
        return self.identity()

    def find(self) -> Identity | None:
        """Fast scan: one node without a node id, which then is in the configuration state; None if there is none.

        128 bits are asked one by one, from the highest: whoever agrees answers, and all that disagree drop out.
        """
        if not self._scan(0, SCAN_START, 0, 0):
            return None
        found = [0, 0, 0, 0]
        for part in range(4):
            for bit in range(31, -1, -1):
                if not self._scan(found[part], bit, part, part):
                    found[part] |= 1 << bit
            if not self._scan(found[part], 0, part, (part + 1) % 4):
                raise FieldbusError(errors.LSS_NO_NODE, whom="the node that answered first")
        return Identity(*found)

    def find_all(self, limit: int = 127) -> Iterator[Identity]:
        """All nodes without a node id; all wait again when the last one was found."""
        self.deselect()
        try:
            for _ in range(limit):
                identity = self.find()  # those already found are in the configuration state and keep silent
                if identity is None:
                    return
                yield identity
        finally:
            self.deselect()

    def _scan(self, number: int, bit: int, part: int, following: int) -> bool:
        self._answers.clear()
        self._send(wire.CS_FAST_SCAN, struct.pack("<IBBB", number, bit, part, following))
        return self._answer(wire.CS_IDENTIFY_SLAVE, FAST_SCAN_ANSWER) is not None

    # -- what the selected node is -----------------------------------------------------------------------------------

    def identity(self) -> Identity:
        """Of the node in the configuration state."""
        return Identity(*(struct.unpack("<I", self._ask(wire.CS_INQUIRE_VENDOR_ID + k)[1:5])[0] for k in range(4)))

    def node_id(self) -> int | None:
        """Of the node in the configuration state; None if it has none yet."""
        number = self._ask(wire.CS_INQUIRE_NODE_ID)[1]
        return None if number == UNCONFIGURED else number

    # -- what it shall be --------------------------------------------------------------------------------------------

    def set_node_id(self, node: int) -> None:
        """In effect after its next reset of communication; at once if it had none. 255 takes its node id from it."""
        self._configure(wire.CS_CONFIGURE_NODE_ID, bytes((node,)))

    def set_bitrate(self, bitrate: int) -> None:
        """Bit/s; in effect after its next start, or by `activate`."""
        if bitrate not in BITRATES:
            known = ", ".join(str(rate) for rate in BITRATES)
            raise FieldbusError(errors.LSS_BITRATE, bitrate=bitrate, known=known)
        self._configure(wire.CS_CONFIGURE_BIT_TIMING, bytes((0, BITRATES[bitrate])))

    def store(self) -> None:
        """Keep node id and bit rate without supply."""
        self._configure(wire.CS_STORE_CONFIGURATION, b"", STORE_ANSWER)

    def activate(self, delay: float) -> None:
        """Change over to the new bit rate: in `delay` s nobody sends, then all change, and again nobody sends for as long."""
        self._send(wire.CS_ACTIVATE_BIT_TIMING, struct.pack("<H", round(delay * 1000)))

    def _configure(self, service: int, data: bytes, seconds: float = ANSWER) -> None:
        answer = self._ask(service, data, seconds)
        if code := answer[1]:
            meaning = _REFUSALS.get((service, code), f"error {code}, {answer[2]} of the device")
            raise FieldbusError(errors.LSS_REFUSED, meaning=meaning)

    def _ask(self, service: int, data: bytes = b"", seconds: float = ANSWER) -> bytes:
        self._answers.clear()
        self._send(service, data)
        answer = self._answer(service, seconds)
        if answer is None:
            raise FieldbusError(errors.LSS_NO_NODE, whom="the node that was selected")
        return answer

    def _answer(self, service: int, seconds: float) -> bytes | None:
        def matching() -> list[bytes]:
            return [answer for answer in self._answers if answer[0] == service]

        self._wait(lambda: bool(matching()), seconds)
        return next(iter(matching()), None)

    def _send(self, service: int, data: bytes) -> None:
        self._network.send_message(TO_SLAVES, bytes((service, *data)).ljust(8, b"\0"))
