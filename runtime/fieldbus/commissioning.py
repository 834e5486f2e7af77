"""A bus without a machine: who is there, are they what their EDS files say, and which node ids do they have.

It needs the bus for itself: a running master has SDO conversations of its own, and two clients of one server talk past each
other. A master that is heard is a refusal.
"""

from __future__ import annotations

import contextlib
from collections.abc import Callable, Iterable, Iterator
from dataclasses import dataclass
from typing import Final

import can
import canopen
from canopen.objectdictionary import ODVariable
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from runtime.diagnostics.catalogue import commissioning as errors
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus.dialogue import SYNC
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.lss import Identity, LssMaster
from runtime.fieldbus.network import PolledNetwork, PumpedSdoClient
from runtime.fieldbus.objects import variables
from runtime.fieldbus.pdo import STRUCT_CODES, object_name

LISTEN: Final = 0.5  # s for a master to be heard
KNOCK: Final = 0.3  # s for the answers of all nodes
ANSWER: Final = 0.3  # s for one answer
BOOT: Final = 5.0  # s until the boot-up message
RESET_COMMUNICATION: Final = 130
PROFILES: Final = {401: "I/O (CiA 401)", 402: "drive (CiA 402)", 406: "encoder (CiA 406)", 0: "no profile"}


@dataclass(frozen=True, slots=True)
class FoundNode:
    """What a node tells of itself; None or empty what it does not."""

    node: int
    device_type: int
    vendor: int | None
    product: int | None
    revision: int | None
    serial: int | None
    name: str
    hardware: str
    firmware: str

    @property
    def profile(self) -> str:
        number = self.device_type & 0xFFFF
        return PROFILES.get(number, f"CiA {number}")


@dataclass(frozen=True, slots=True)
class Difference:
    """A place where node and EDS file do not agree."""

    object: str
    name: str
    expected: str
    found: str


class Commissioning:
    """Looks at a bus. `now()` in s, `idle()` lets it go forward."""

    def __init__(self, bus: can.BusABC, now: Callable[[], float], idle: Callable[[], None]) -> None:
        self._bus = bus
        self._network = PolledNetwork(bus)
        self._now = now
        self._idle = idle
        self._heard: set[int] = set()

    def wait(self, condition: Callable[[], bool], seconds: float) -> bool:
        end = self._now() + seconds
        while True:
            while (message := self._bus.recv(0)) is not None:
                self._heard.add(message.arbitration_id)
                self._network.receive(message)
            if condition():
                return True
            if self._now() >= end:
                return False
            self._idle()

    def refuse_a_master(self) -> None:
        """Raises FieldbusError if somebody sends SYNC."""
        if self.wait(lambda: SYNC in self._heard, LISTEN):
            raise FieldbusError(catalogue.OTHER_MASTER, channel=self._bus.channel_info)

    def scan(self, nodes: Iterable[int] = range(1, 128)) -> list[FoundNode]:
        """Every node that answers. Raises FieldbusError, can.CanError."""
        self.refuse_a_master()
        wanted = list(nodes)
        self._heard.clear()
        for node in wanted:
            self._network.send_message(0x600 + node, bytes((0x40, 0x00, 0x10, 0, 0, 0, 0, 0)))
            self.wait(lambda: False, 0.0)  # a bus of 10 kbit/s has no room for all questions at once
        self.wait(lambda: all(0x580 + node in self._heard for node in wanted), KNOCK)
        return [self._ask(node) for node in wanted if 0x580 + node in self._heard]

    def client(self, node: int, od: canopen.ObjectDictionary | None = None) -> PumpedSdoClient:
        """To read and write one node."""
        client = PumpedSdoClient(node, od or canopen.ObjectDictionary(), self.wait)
        client.RESPONSE_TIMEOUT = ANSWER
        client.network = self._network
        self._network.subscribe(0x580 + node, client.on_response)
        return client

    @contextlib.contextmanager
    def asking(self, node: int) -> Iterator[PumpedSdoClient]:
        """A client for a while, for objects that need no EDS."""
        client = self.client(node)
        try:
            yield client
        finally:
            self._network.unsubscribe(0x580 + node, client.on_response)

    def _ask(self, node: int) -> FoundNode:
        with self.asking(node) as client:
            return self._found(client, node)

    @staticmethod
    def _found(client: PumpedSdoClient, node: int) -> FoundNode:
        def number(index: int, subindex: int = 0) -> int | None:
            return read_number(client, index, subindex)

        def text(index: int) -> str:
            data = _read(client, index, 0) or b""
            return data.decode("latin-1").rstrip("\0 ")

        return FoundNode(
            node=node,
            device_type=number(0x1000) or 0,
            vendor=number(0x1018, 1),
            product=number(0x1018, 2),
            revision=number(0x1018, 3),
            serial=number(0x1018, 4),
            name=text(0x1008),
            hardware=text(0x1009),
            firmware=text(0x100A),
        )

    def set_node(
        self, identity: Identity | None, node: int | None, bitrate: int | None, *, store: bool
    ) -> tuple[Identity, int | None]:
        """Node id and bit rate (bit/s) of the node with this identity, or of the only one on the bus, by LSS.

        The node boots with its new id, the bit rate holds from its next start on. Identity and id of the node afterwards.
        Raises FieldbusError, also if another node has the id already, or the node does not boot with it.
        """
        self.refuse_a_master()
        lss = LssMaster(self._network, self.wait)
        try:
            if identity is None:
                identity = lss.select_only()
            else:
                lss.select(identity)
            before = lss.node_id()
            if node is not None and node != before and self._answers(node):
                raise FieldbusError(errors.NODE_ID_TAKEN, node=node)
            if bitrate is not None:
                lss.set_bitrate(bitrate)
            if node is not None:
                lss.set_node_id(node)
            if store:
                lss.store()
        finally:
            self._heard.clear()
            lss.deselect()
        if node is None:
            return identity, before
        if before is not None:
            self._network.send_message(0, bytes((RESET_COMMUNICATION, before)))
        if not self.wait(lambda: 0x700 + node in self._heard, BOOT):
            raise FieldbusError(catalogue.NODE_MISSING, nodes=f"node {node}", seconds=BOOT)
        return identity, node

    def unconfigured(self) -> list[Identity]:
        """The nodes that have no node id yet (LSS fast scan). Raises FieldbusError, can.CanError."""
        self.refuse_a_master()
        return list(LssMaster(self._network, self.wait).find_all())

    def _answers(self, node: int) -> bool:
        with self.asking(node) as client:
            client.MAX_RETRIES = 1
            return _read(client, 0x1000, 0) is not None

    def compare(self, node: int, od: canopen.ObjectDictionary) -> Iterator[Difference]:
        """Where the node differs from its EDS: identity, objects that it does not have, constants. Raises FieldbusError."""
        self.refuse_a_master()
        client = self.client(node, od)
        if _read(client, 0x1000, 0) is None:
            raise FieldbusError(
                catalogue.NODE_MISSING, nodes=f"node {node}", seconds=ANSWER * PumpedSdoClient.MAX_RETRIES
            )
        for variable in variables(od):
            if not variable.readable or variable.data_type not in STRUCT_CODES:
                continue
            name = object_name(variable.index, variable.subindex)
            data = _read(client, variable.index, variable.subindex)
            if data is None:
                yield Difference(name, variable.name, "there", "not there")
            elif len(data) * 8 != len(variable):
                yield Difference(name, variable.name, f"{len(variable)} bits", f"{len(data) * 8} bits")
            elif _constant(variable) and (found := int(variable.decode_raw(data))) != variable.default:
                yield Difference(name, variable.name, f"0x{variable.default:X}", f"0x{found:X}")


def _constant(variable: ODVariable) -> bool:
    """Whether the EDS says what stands there: constants, and the identity but for the serial number."""
    if variable.default is None or (variable.index == 0x1018 and variable.subindex == 4):
        return False
    return variable.access_type == "const" or variable.index in (0x1000, 0x1018)


def read_number(client: PumpedSdoClient, index: int, subindex: int = 0) -> int | None:
    """An unsigned number of at most 32 bits; None if the node does not have it, does not tell it, or does not answer."""
    data = _read(client, index, subindex)
    return None if data is None else int.from_bytes(data[:4], "little")


def _read(client: PumpedSdoClient, index: int, subindex: int) -> bytes | None:
    """The data of an object; None if the node does not have it, does not tell it, or does not answer."""
    try:
        data: bytes = client.upload(index, subindex)
    except (SdoAbortedError, SdoCommunicationError):
        return None
    return data
