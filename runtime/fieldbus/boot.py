"""Boot of the bus, as CiA 302-2 has it: reset, wait for the boot-up messages, check who is there, configure, start.

Everything here happens before the first cycle. Whoever is missing or wrong stops the start with an error that
names it.
"""

from __future__ import annotations

import struct
from collections.abc import Callable, Iterator
from typing import Final

from canopen.nmt import NmtMaster
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from runtime.config.machine import Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place
from runtime.drives import DriveImage
from runtime.fieldbus import cia402, exchange
from runtime.fieldbus.error_codes import nmt_state_text
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.links import DriveLink, IoLink, Links
from runtime.fieldbus.network import PolledNetwork, PumpedSdoClient, Wait
from runtime.fieldbus.pdo import INVALID, NO_RTR, Direction, PdoPlan, find_variable, object_name

DEVICE_TYPE: Final = 0x1000
SYNC_COB_ID: Final = 0x1005
SYNC_PERIOD: Final = 0x1006  # µs
CONSUMER_HEARTBEAT: Final = 0x1016
PRODUCER_HEARTBEAT: Final = 0x1017
IDENTITY: Final = 0x1018
INTERPOLATION_PERIOD: Final = 0x60C2

SYNC: Final = 0x80
OPERATIONAL: Final = 5

# Reactions of a drive, set where it has the object (CiA 402).
DRIVE_REACTIONS: Final = (
    (0x6007, 1),  # connection aborted: fault
    (0x605A, 2),  # quick stop: brake on the quick stop ramp, then switch on disabled
    (0x605C, 1),  # disable operation: brake on the ramp first
    (0x605E, 2),  # fault: brake on the quick stop ramp
)
QUICK_STOP_DECELERATION: Final = 0x6085
FOLLOWING_ERROR_WINDOW: Final = 0x6065


def interpolation_time(period: float) -> tuple[int, int]:
    """Mantissa (1...255) and decimal exponent of object 0x60C2 for a period in seconds.

    Raises FieldbusError for a period that the object cannot tell.
    """
    for exponent in (-3, -2, -4, -5, -6):
        mantissa = period / 10.0**exponent
        if abs(mantissa - round(mantissa)) < 1e-6 and 1 <= round(mantissa) <= 255:
            return round(mantissa), exponent
    raise FieldbusError(catalogue.CYCLE_NOT_REPRESENTABLE, period_us=f"{period * 1e6:g}")


class BootSequence:
    """One boot. `heard_master` tells whether another master was heard; `wait` lets bus and time run."""

    def __init__(
        self,
        machine: Machine,
        network: PolledNetwork,
        links: Links,
        image: DriveImage,
        wait: Wait,
        heard_master: Callable[[], bool],
    ) -> None:
        self._machine = machine
        self._bus = machine.fieldbus.bus
        self._network = network
        self._links = links
        self._image = image
        self._wait = wait
        self._heard_master = heard_master
        self._interpolation = interpolation_time(machine.cycle.period)
        self.clients = {link.node: PumpedSdoClient(link.node, link.od, wait) for link in links}
        for client in self.clients.values():
            client.network = network

    def run(self) -> None:
        """Bring every node to OPERATIONAL; raises FieldbusError."""
        self._listen()
        self._reset()
        for link in self._links:
            self._identify(link)
        for link in self._links:
            self._configure(link)
            self._read_first_values(link)
        for link in self._links:
            self._command(link.node, "OPERATIONAL")
        self._wait_operational()

    def _listen(self) -> None:
        """Two masters on one bus would move the axes by turns."""
        if self._wait(self._heard_master, max(1.5 * self._bus.heartbeat, 2 * self._machine.cycle.period)):
            raise FieldbusError(catalogue.OTHER_MASTER, channel=self._bus.channel)

    def _reset(self) -> None:
        for link in self._links:
            link.booted = False
        # Reset of the communication only: a fault of the drive and its cause stay to be seen.
        self._command(0, "RESET COMMUNICATION")
        if not self._wait(lambda: all(link.booted for link in self._links), self._bus.boot_timeout):
            missing = ", ".join(f"node {link.node} ({link.owner})" for link in self._links if not link.booted)
            raise FieldbusError(catalogue.NODE_MISSING, nodes=missing, seconds=self._bus.boot_timeout)

    def _identify(self, link: DriveLink | IoLink) -> None:
        profile = self._read(link, DEVICE_TYPE) & 0xFFFF
        if profile != link.profile:
            raise _refused(catalogue.WRONG_DEVICE_TYPE, link, actual=profile, expected=link.profile)
        if link.vendor_id is not None and (vendor := self._read(link, IDENTITY, 1)) != link.vendor_id:
            raise _refused(catalogue.WRONG_VENDOR, link, actual=vendor, expected=link.vendor_id)
        if link.product_code is not None and (product := self._read(link, IDENTITY, 2)) != link.product_code:
            raise _refused(catalogue.WRONG_PRODUCT, link, actual=product, expected=link.product_code)
        if isinstance(link, DriveLink) and self._has(link, cia402.SUPPORTED_MODES):
            modes = self._read(link, cia402.SUPPORTED_MODES)
            if not modes >> (link.mode - 1) & 1:
                name = link.mode.name.lower().replace("_", " ")
                raise _refused(catalogue.MODE_UNSUPPORTED, link, mode=name, supported=modes)

    def _configure(self, link: DriveLink | IoLink) -> None:
        self._write(link, PRODUCER_HEARTBEAT, 0, round(self._bus.heartbeat * 1000))
        timeout_ms = round(self._bus.heartbeat_timeout * 1000)
        self._write(link, CONSUMER_HEARTBEAT, 1, self._bus.master_node << 16 | timeout_ms)
        for index, value in ((SYNC_COB_ID, SYNC), (SYNC_PERIOD, round(self._machine.cycle.period * 1e6))):
            if self._has(link, index):
                self._write(link, index, 0, value)
        if isinstance(link, DriveLink):
            self._configure_drive(link)
        for index, subindex, value in link.startup:
            self._write(link, index, subindex, value)
        for index, subindex, value in self._pdo_writes(link):
            self._write(link, index, subindex, value)

    def _configure_drive(self, link: DriveLink) -> None:
        axis = self._machine.axes[link.axis]
        writes = [(index, 0, value) for index, value in DRIVE_REACTIONS]
        # What the axis is said to be able to do, it may do when it must stop. The start-up list can say otherwise.
        writes.append((QUICK_STOP_DECELERATION, 0, round(axis.acceleration * link.increments_per_unit)))
        if not link.spindle:
            # The second line of defence, behind the runtime's own watch.
            writes.append((FOLLOWING_ERROR_WINDOW, 0, round(2 * axis.following_error * link.increments_per_unit)))
        writes += [(INTERPOLATION_PERIOD, sub, value) for sub, value in enumerate(self._interpolation, 1)]
        for index, subindex, value in writes:
            if self._has(link, index, subindex):
                self._write(link, index, subindex, min(value, 0xFFFF_FFFF))
        self._write(link, cia402.MODES_OF_OPERATION, 0, link.mode)

    def _pdo_writes(self, link: DriveLink | IoLink) -> Iterator[tuple[int, int, int]]:
        """The order is that of CiA 301: switch off, empty, map, switch on; PDOs that nobody uses stay off."""
        used = {plan.communication_index: plan for plan in link.layouts}
        for direction in Direction:
            for number in range(1, 5):
                plan = PdoPlan(direction, number, ())
                index = plan.communication_index
                if index not in link.od:
                    continue
                cob_id = plan.cob_id(link.node) | (NO_RTR if direction is Direction.TRANSMIT else 0)
                yield index, 1, cob_id | INVALID
                if index not in used:
                    continue
                plan = used[index]
                yield plan.mapping_index, 0, 0
                entries = link.layouts[plan].mapping_entries(link.od)
                for sub, entry in enumerate(entries, 1):
                    yield plan.mapping_index, sub, entry
                yield plan.mapping_index, 0, len(entries)
                yield index, 2, plan.transmission
                if plan.event_timer_ms and self._has(link, index, 5):
                    yield index, 5, plan.event_timer_ms
                yield index, 1, cob_id

    def _read_first_values(self, link: DriveLink | IoLink) -> None:
        """Positions, states and inputs are known before the first cycle."""
        if isinstance(link, DriveLink):
            if self._has(link, cia402.ERROR_CODE):
                self._image.fault_code[link.axis] = self._read(link, cia402.ERROR_CODE)
            position = self._read(link, cia402.POSITION_ACTUAL)
            link.begin(self._read(link, cia402.STATUSWORD), position, self._image)
        elif link.inputs:
            data = bytes(self._read(link, exchange.READ_INPUTS, k + 1) for k in range((link.inputs + 7) // 8))
            link.receive_inputs(data)

    def _wait_operational(self) -> None:
        if not self._bus.heartbeat:
            return
        if not self._wait(lambda: all(link.nmt_state == OPERATIONAL for link in self._links), self._bus.boot_timeout):
            link = next(link for link in self._links if link.nmt_state != OPERATIONAL)
            state = nmt_state_text(link.nmt_state)
            raise _refused(catalogue.NODE_NOT_OPERATIONAL, link, state=state)

    def _command(self, node: int, state: str) -> None:
        nmt = NmtMaster(node)
        nmt.network = self._network
        nmt.state = state

    def _has(self, link: DriveLink | IoLink, index: int, subindex: int = 0) -> bool:
        try:
            find_variable(link.od, index, subindex)
        except KeyError:
            return False
        return True

    def _read(self, link: DriveLink | IoLink, index: int, subindex: int = 0) -> int:
        name = object_name(index, subindex)
        try:
            data = self.clients[link.node].upload(index, subindex)
            return int(find_variable(link.od, index, subindex).decode_raw(data))
        except SdoAbortedError as error:
            raise _aborted(link, "read", name, error) from error
        except (SdoCommunicationError, struct.error, ValueError) as error:
            raise _silent(link, "read", name, error) from error
        except KeyError:
            raise _refused(catalogue.EDS_OBJECT_MISSING, link, object=name, purpose="the check of the device") from None

    def _write(self, link: DriveLink | IoLink, index: int, subindex: int, value: int) -> None:
        name = object_name(index, subindex)
        try:
            data = find_variable(link.od, index, subindex).encode_raw(value)
            self.clients[link.node].download(index, subindex, data)
        except SdoAbortedError as error:
            raise _aborted(link, "write", name, error) from error
        except (SdoCommunicationError, struct.error, ValueError) as error:
            raise _silent(link, "write", name, error) from error
        except KeyError:
            raise _refused(catalogue.EDS_OBJECT_MISSING, link, object=name, purpose="the configuration") from None


def _refused(entry: ErrorEntry, link: DriveLink | IoLink, **values: object) -> FieldbusError:
    return FieldbusError(entry, Place(), node=link.node, owner=link.owner, **values)


def _aborted(link: DriveLink | IoLink, access: str, name: str, error: SdoAbortedError) -> FieldbusError:
    text = SdoAbortedError.CODES.get(error.code, "unknown reason")
    meaning = text[:1].lower() + text[1:]
    return _refused(catalogue.SDO_ABORTED, link, access=access, object=name, meaning=meaning, code=error.code)


def _silent(link: DriveLink | IoLink, access: str, name: str, error: Exception) -> FieldbusError:
    return _refused(catalogue.SDO_NO_ANSWER, link, access=access, object=name, reason=str(error))
