"""A CANopen node without threads: SDO server and NMT slave of `canopen`, PDOs and heartbeats as the dictionary says.

Profiles (drive, I/O) derive from it: they own the live objects (`values`) and are told of SYNC, of new set-points, of
lost heartbeats.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Final

import canopen
from canopen.objectdictionary import ODVariable
from canopen.objectdictionary.datatypes import DATA_TYPES, FLOAT_TYPES
from canopen.sdo.exceptions import SdoAbortedError

from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.lss import UNCONFIGURED, Identity
from runtime.fieldbus.network import PolledNetwork
from runtime.fieldbus.pdo import (
    EVENT,
    INVALID,
    LAST_PDO,
    LAST_SYNCHRONOUS,
    Direction,
    ObjectKey,
    PdoLayout,
    PdoPlan,
    lay_out,
)
from runtime.fieldbus.simulator.lss import LssSlave

ERROR_REGISTER: Final = 0x1001
ERROR_HISTORY: Final = 0x1003
GUARD_TIME: Final = 0x100C  # ms
LIFE_TIME_FACTOR: Final = 0x100D
CONSUMER_HEARTBEAT: Final = 0x1016
MASTER_GUARDS: Final = -1  # instead of a node id: whoever asks
OPERATIONAL: Final = 5
ERROR_BEHAVIOUR: Final = 0x1029
HEARTBEAT_ERROR: Final = 0x8130
HISTORY_LENGTH: Final = 8

# NMT
START, STOP, PRE_OPERATIONAL, RESET_NODE, RESET_COMMUNICATION = 1, 2, 128, 129, 130

# abort codes of CiA 301
CANNOT_MAP: Final = 0x06040041
PDO_TOO_LONG: Final = 0x06040042
DEVICE_STATE: Final = 0x08000022

# bits of the error register, by the first digit of the error code
ERROR_BITS: Final = {0x2: 0x02, 0x3: 0x04, 0x4: 0x08, 0x8: 0x10}


@dataclass(slots=True)
class Pdo:
    """One PDO that is switched on."""

    cob_id: int
    layout: PdoLayout
    transmission: int
    event_timer: float = 0.0  # s, 0: none
    syncs: int = 0  # since the last transmission
    due: float = 0.0
    inhibit: float = 0.0  # s between two of them
    sent_at: float = -math.inf
    received: tuple[int, ...] | None = None  # waits for the SYNC
    sent: bytes = b""


class SimulatedNode:
    """One node on the network. `values`: the live objects that can be mapped, by index and sub-index."""

    def __init__(self, node: int, eds: str, network: PolledNetwork) -> None:
        self.id = node
        self.network = network
        self._eds = eds
        self.local = canopen.LocalNode(node, read_dictionary(eds, node))
        self._renamed = False  # takes the node id that LSS gave it
        self.values: dict[ObjectKey, int] = {}
        self.silent = False
        self.vendor_id: int | None = None  # another than that of the EDS
        self.operational = False
        self._errors: list[int] = []
        self._toggle = 0
        self._master_heard: float | None = None
        self._master_lost = False
        self._watched: tuple[int, float] = (0, 0.0)  # node id, time-out in s
        self._transmit: list[Pdo] = []
        self._receive: list[Pdo] = []
        self.now = 0.0
        identity = Identity(*(self._number(0x1018, sub) for sub in range(1, 5)))
        self.lss = LssSlave(identity, node, network.send_message)
        self._attach()
        network.subscribe(0, self._on_nmt)

    def _attach(self) -> None:
        """Be on the network under the present node id."""
        self.local.add_read_callback(self._on_read)
        self.local.add_write_callback(self._on_write)
        self.local.associate_network(self.network)

    # -- for profiles ------------------------------------------------------------------------------------------------

    def reset_application(self) -> None:
        """Power-on values of the profile's objects."""

    def before_sync(self) -> None:
        """A SYNC has come: bring the live values up to date."""

    def set_points_taken(self) -> None:
        """An RPDO has been taken over into `values`."""

    def written(self, index: int, subindex: int, value: int) -> None:
        """A number was written by SDO."""

    def changed(self, pdo: Pdo) -> bool:
        """Whether a PDO that is sent when something changes has to be sent."""
        return self._pack(pdo) != pdo.sent

    def connection_lost(self) -> None:
        """The master's heartbeat is lost, or NMT took the node out of operation."""

    # -- life --------------------------------------------------------------------------------------------------------

    def power_on(self, now: float) -> None:
        """Boot: defaults, boot-up message, pre-operational."""
        self.now = now
        self.lss.configuring, self.lss.node_id = False, self.lss.stored
        self._rename()
        self.local.data_store.clear()
        self.reset_application()
        self._boot()

    def _rename(self) -> None:
        """Take the node id that LSS has set."""
        self._renamed = False
        if self.lss.node_id == self.id:
            return
        if self.id != UNCONFIGURED:
            self.local.remove_network()
        self.id = self.lss.node_id
        if self.id != UNCONFIGURED:
            store = self.local.data_store
            self.local = canopen.LocalNode(self.id, read_dictionary(self._eds, self.id))
            self.local.data_store = store
            self._attach()

    def on_lss(self, data: bytearray) -> None:
        """A frame of the LSS master."""
        if not self.silent and self.lss.on_frame(data) and self.id == UNCONFIGURED:
            self._renamed = self.lss.node_id != UNCONFIGURED

    def _boot(self) -> None:
        self.operational = False
        self._toggle = 0
        self._master_heard, self._master_lost, self._watched = None, False, (0, 0.0)
        self._transmit, self._receive = [], []
        self.local.nmt.stop_heartbeat()
        if not self.silent and self.id != UNCONFIGURED:
            self.local.nmt.state = "INITIALISING"  # sends the boot-up message
            self.local.nmt.state = "PRE-OPERATIONAL"

    def _on_nmt(self, can_id: int, data: bytearray, timestamp: float) -> None:
        if len(data) < 2 or data[1] not in (0, self.id) or self.silent:
            return
        command = data[0]
        was_operational, self.operational = self.operational, False
        if command in (RESET_NODE, RESET_COMMUNICATION):
            store = self.local.data_store
            for index in [i for i in store if command == RESET_NODE or i < 0x2000]:
                del store[index]
            if was_operational:
                self.connection_lost()
            if command == RESET_NODE:
                self.reset_application()
            self._renamed = self.lss.node_id != self.id  # in `step`: the network is handing this frame out
            if not self._renamed:
                self._boot()
        elif command == START:
            self.operational = True
            if not was_operational:
                self._switch_on_pdos()
        elif command in (STOP, PRE_OPERATIONAL):
            if was_operational:
                self.connection_lost()
        else:
            self.operational = was_operational

    def step(self, now: float) -> None:
        """Let the time be `now` (s)."""
        self.now = now
        if self._renamed:
            self._rename()
            self._boot()
        node, timeout = self._watched
        if node and self._master_heard is not None and not self._master_lost and now - self._master_heard > timeout:
            self._master_lost = True
            was_operational = self.operational
            self.emergency(HEARTBEAT_ERROR)
            if was_operational:
                self.connection_lost()
                if self._number(ERROR_BEHAVIOUR, 1) == 0:  # CiA 301: leave operation
                    self.operational = False
                    self.local.nmt.state = "PRE-OPERATIONAL"
        if self.operational and not self.silent:
            self._send_events()

    def on_heartbeat(self, node: int, now: float) -> None:
        """Some node's heartbeat; watching begins with the first one."""
        if node == self._watched[0]:
            self._master_heard = now
            self._master_lost = False

    def on_guard(self, now: float) -> None:
        """The master asks for the state (node guarding): the answer toggles, and the question is a sign of its life."""
        if self.silent:
            return
        guard_time, factor = self._number(GUARD_TIME), self._number(LIFE_TIME_FACTOR)
        if guard_time and factor:
            self._watched = MASTER_GUARDS, guard_time * factor / 1000.0
            self.on_heartbeat(MASTER_GUARDS, now)
        state = OPERATIONAL if self.operational else PRE_OPERATIONAL - 1
        self.network.send_message(0x700 + self.id, bytes((state | self._toggle,)))
        self._toggle ^= 0x80

    def emergency(self, code: int) -> None:
        """Send an EMCY and keep it in the error history."""
        self._errors = [code, *self._errors][:HISTORY_LENGTH]
        self.values[ERROR_REGISTER, 0] = 0x01 | ERROR_BITS.get(code >> 12, 0)
        if not self.silent:
            self.local.emcy.send(code, self.values[ERROR_REGISTER, 0])

    def clear_emergency(self) -> None:
        self.values[ERROR_REGISTER, 0] = 0
        if not self.silent:
            self.local.emcy.reset()

    # -- objects -----------------------------------------------------------------------------------------------------

    def _number(self, index: int, subindex: int = 0) -> int:
        variable = self.local.object_dictionary.get_variable(index, subindex)
        if variable is None:
            return 0
        return int(variable.decode_raw(self.local.get_data(index, subindex)))

    def _on_read(self, index: int, subindex: int, od: ODVariable) -> int | None:
        if index == 0x1018 and subindex == 1:
            return self.vendor_id
        if index == 0x1018 and subindex == 4:
            return self.lss.identity.serial  # that of the EDS goes with the node id
        if index == ERROR_HISTORY:
            return len(self._errors) if subindex == 0 else (self._errors[subindex - 1 : subindex] or [0])[0]
        return self.values.get((index, subindex))

    def _on_write(self, index: int, subindex: int, od: ODVariable, data: bytes) -> None:
        """Called before the value is stored; raises SdoAbortedError to refuse it."""
        if od.data_type in DATA_TYPES or od.data_type in FLOAT_TYPES:
            return
        value = int(od.decode_raw(data))
        if od.min is not None and value < od.min:
            raise SdoAbortedError(0x06090032)
        if od.max is not None and value > od.max:
            raise SdoAbortedError(0x06090031)
        if 0x1400 <= index < 0x1C00:
            self._check_pdo_write(index, subindex, value)
        elif index == CONSUMER_HEARTBEAT and subindex == 1:
            self._watched = value >> 16 & 0x7F, (value & 0xFFFF) / 1000.0
            self._master_heard, self._master_lost = None, False
        elif index == ERROR_HISTORY and subindex == 0:
            if value:
                raise SdoAbortedError(0x06090030)
            self._errors.clear()
        if (index, subindex) in self.values:
            self.values[index, subindex] = value
        self.written(index, subindex, value)

    def _check_pdo_write(self, index: int, subindex: int, value: int) -> None:
        """A PDO may be changed only while it is switched off, and its mapping only while it is empty."""
        direction = Direction.RECEIVE if index < 0x1800 else Direction.TRANSMIT
        communication, mapping, _ = direction.value
        number = index & 0xFF
        switched_on = not self._number(communication + number, 1) & INVALID
        if switched_on and (index >= mapping or subindex == 2):
            raise SdoAbortedError(DEVICE_STATE)
        if index >= mapping and subindex and self._number(mapping + number, 0):
            raise SdoAbortedError(DEVICE_STATE)
        if index >= mapping and not subindex and value:
            self._layout(mapping + number, value)

    def _layout(self, mapping: int, count: int) -> PdoLayout:
        od = self.local.object_dictionary
        entries = [self._number(mapping, sub) for sub in range(1, count + 1)]
        if sum(entry & 0xFF for entry in entries) > 64:
            raise SdoAbortedError(PDO_TOO_LONG)
        try:
            layout = lay_out(od, tuple((entry >> 16, entry >> 8 & 0xFF) for entry in entries))
        except (KeyError, ValueError):
            raise SdoAbortedError(CANNOT_MAP) from None
        if layout.mapping_entries(od) != entries or any(key not in self.values for key in layout.objects):
            raise SdoAbortedError(CANNOT_MAP)
        return layout

    # -- process data ------------------------------------------------------------------------------------------------

    def _switch_on_pdos(self) -> None:
        for pdo in self._receive:
            self.network.unsubscribe(pdo.cob_id, self._on_rpdo)
        self._transmit, self._receive = [], []
        od = self.local.object_dictionary
        for direction, pdos in ((Direction.RECEIVE, self._receive), (Direction.TRANSMIT, self._transmit)):
            for number in range(1, LAST_PDO + 1):
                plan = PdoPlan(direction, number, ())
                if plan.communication_index not in od:
                    continue
                cob_id = self._number(plan.communication_index, 1)
                count = self._number(plan.mapping_index, 0)
                if cob_id & INVALID or not count:
                    continue
                transmits = direction is Direction.TRANSMIT
                timer = self._number(plan.communication_index, 5) / 1000.0 if transmits else 0.0
                inhibit = self._number(plan.communication_index, 3) / 1e4 if transmits else 0.0
                transmission = self._number(plan.communication_index, 2)
                layout = self._layout(plan.mapping_index, count)
                pdos.append(Pdo(cob_id & 0x7FF, layout, transmission, timer, due=self.now + timer, inhibit=inhibit))
        for pdo in self._receive:
            self.network.subscribe(pdo.cob_id, self._on_rpdo)

    def _on_rpdo(self, can_id: int, data: bytearray, timestamp: float) -> None:
        if not self.operational or self.silent:
            return
        for pdo in self._receive:
            if pdo.cob_id == can_id and len(data) >= pdo.layout.codec.size:
                pdo.received = pdo.layout.codec.unpack_from(data)
                if pdo.transmission > LAST_SYNCHRONOUS:
                    self._take(pdo)

    def _take(self, pdo: Pdo) -> None:
        if pdo.received is not None:
            self.values.update(zip(pdo.layout.objects, pdo.received, strict=True))
            pdo.received = None
            self.set_points_taken()

    def on_sync(self) -> None:
        """SYNC: feedback of this moment goes out, set-points that came before it are taken over."""
        if not self.operational or self.silent:
            return
        self.before_sync()
        for pdo in self._transmit:
            if pdo.transmission <= LAST_SYNCHRONOUS:
                pdo.syncs += 1
                if pdo.syncs >= pdo.transmission:
                    pdo.syncs = 0
                    self._send(pdo)
        for pdo in self._receive:
            self._take(pdo)

    def _send_events(self) -> None:
        for pdo in self._transmit:
            if pdo.transmission >= EVENT - 1:
                if self.now - pdo.sent_at < pdo.inhibit - 1e-9:
                    continue
                timed_out = pdo.event_timer and self.now >= pdo.due
                if timed_out or self.changed(pdo):
                    pdo.due = self.now + pdo.event_timer
                    self._send(pdo)

    def _pack(self, pdo: Pdo) -> bytes:
        values = self.values
        return pdo.layout.codec.pack(*[values[key] for key in pdo.layout.objects])

    def _send(self, pdo: Pdo) -> None:
        if self.silent:
            return
        pdo.sent, pdo.sent_at = self._pack(pdo), self.now
        self.network.send_message(pdo.cob_id, pdo.sent)
