"""What master and node say to each other by SDO before the node may run: who are you, be configured so, where are you.

A dialogue is a generator of `Access`: it yields what is to be read or written and is sent the number that was read. Who
carries the accesses out decides whether it waits for the answers (the boot, runtime.fieldbus.boot) or lets cycles pass
meanwhile (a node that comes back, runtime.fieldbus.rejoin). Refusals are raised where they are found, as FieldbusError.
"""

from __future__ import annotations

import struct
from collections.abc import Generator, Iterator, Mapping
from dataclasses import dataclass
from typing import Final

from canopen.objectdictionary import ObjectDictionaryError

from runtime.config.machine import Bus, Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry, Place
from runtime.drives import DriveImage
from runtime.fieldbus import cia402, exchange
from runtime.fieldbus.dcf import Configuration, Entry, read_configuration
from runtime.fieldbus.drive_setup import drive_writes, needed_writes, parts
from runtime.fieldbus.error_codes import abort_text
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.links import DriveLink, IoLink
from runtime.fieldbus.pdo import (
    INVALID,
    LAST_PDO,
    NO_RTR,
    PREDEFINED,
    STRUCT_CODES,
    Direction,
    PdoPlan,
    find_variable,
    object_name,
)

DEVICE_TYPE: Final = 0x1000
SYNC_COB_ID: Final = 0x1005
SYNC_PERIOD: Final = 0x1006  # µs
SYNC_COUNTER: Final = 0x1019
TIME_COB_ID: Final = 0x1012
GUARD_TIME: Final = 0x100C  # ms
LIFE_TIME_FACTOR: Final = 0x100D
CONSUMER_HEARTBEAT: Final = 0x1016
PRODUCER_HEARTBEAT: Final = 0x1017
IDENTITY: Final = 0x1018
VERIFY_CONFIGURATION: Final = 0x1020  # days since 1984, ms since midnight
STORE_PARAMETERS: Final = 0x1010
SAVE: Final = 0x65766173  # "save"

SYNC: Final = 0x80
TIME: Final = 0x100
TIME_CONSUMER: Final = 0x8000_0000


@dataclass(frozen=True, slots=True)
class Access:
    """One SDO access: a write of the number `value`, or of `data` as they are; a read if there is neither."""

    index: int
    subindex: int = 0
    value: int | None = None
    data: bytes | None = None

    @property
    def name(self) -> str:
        return object_name(self.index, self.subindex)

    @property
    def verb(self) -> str:
        return "read" if self.reads else "write"

    @property
    def reads(self) -> bool:
        return self.value is None and self.data is None


Dialogue = Generator[Access, int, None]


def interpolation_time(period: float) -> tuple[int, int]:
    """Mantissa (1...255) and decimal exponent of object 0x60C2 for a period in seconds.

    Raises FieldbusError for a period that the object cannot tell.
    """
    for exponent in (-3, -2, -4, -5, -6):
        mantissa = period / 10.0**exponent
        if abs(mantissa - round(mantissa)) < 1e-6 and 1 <= round(mantissa) <= 255:
            return round(mantissa), exponent
    raise FieldbusError(catalogue.CYCLE_NOT_REPRESENTABLE, period_us=f"{period * 1e6:g}")


@dataclass(frozen=True, slots=True)
class Download:
    """A configuration, and whether the node shall keep it without supply."""

    configuration: Configuration
    store: bool = False


def downloads(machine: Machine, bus: str) -> dict[int, Download]:
    """The configuration files of the nodes of a bus, by node id. Raises FieldbusError for one that cannot be used."""
    drives = [axis.drive for axis in machine.axes if axis.drive is not None]
    devices = [(drive.node, drive) for drive in drives]
    devices += [(drive.gantry.node, drive) for drive in drives if drive.gantry is not None]
    files = [(node, drive.dcf, drive.dcf_store) for node, drive in devices if (drive.bus or "") == bus]
    files += [(io.node, io.dcf, io.dcf_store) for io in machine.fieldbus.io if (io.bus or "") == bus]
    return {node: Download(read_configuration(dcf, node), store) for node, dcf, store in files if dcf is not None}


class NodeDialogues:
    """The dialogues of the nodes of one bus of a machine. `downloads`: node id → its configuration file."""

    def __init__(
        self, machine: Machine, bus: Bus, image: DriveImage, downloads: Mapping[int, Download] | None = None
    ) -> None:
        self._downloads = downloads or {}
        self._machine = machine
        self._bus = bus
        self._image = image
        self._interpolation = interpolation_time(machine.cycle.period)

    def identify(self, link: DriveLink | IoLink) -> Dialogue:
        """Is it the device that the machine description means? Raises FieldbusError if not."""
        profile = (yield Access(DEVICE_TYPE)) & 0xFFFF
        if profile != link.profile:
            raise refused(catalogue.WRONG_DEVICE_TYPE, link, actual=profile, expected=link.profile)
        if link.vendor_id is not None and (vendor := (yield Access(IDENTITY, 1))) != link.vendor_id:
            raise refused(catalogue.WRONG_VENDOR, link, actual=vendor, expected=link.vendor_id)
        if link.product_code is not None and (product := (yield Access(IDENTITY, 2))) != link.product_code:
            raise refused(catalogue.WRONG_PRODUCT, link, actual=product, expected=link.product_code)
        if link.configuration is not None:
            found = ((yield Access(VERIFY_CONFIGURATION, 1)), (yield Access(VERIFY_CONFIGURATION, 2)))
            if found != link.configuration:
                raise refused(catalogue.WRONG_CONFIGURATION, link, actual=found, expected=link.configuration)
        if isinstance(link, DriveLink) and self._is_kept(link):
            for k, sub in enumerate((1, 2, 4)):
                self._image.identity[link.axis, k] = (yield Access(IDENTITY, sub)) if has(link, IDENTITY, sub) else 0
        if isinstance(link, DriveLink) and has(link, cia402.SUPPORTED_MODES):
            modes = yield Access(cia402.SUPPORTED_MODES)
            for mode in (link.mode, *sorted(link.modes)):
                if not modes >> (mode - 1) & 1:
                    name = mode.name.lower().replace("_", " ")
                    raise refused(catalogue.MODE_UNSUPPORTED, link, mode=name, supported=modes)

    def _is_kept(self, link: DriveLink) -> bool:
        """The reference of the axis is that of this very drive."""
        homing = self._machine.axes[link.axis].homing
        return homing is not None and homing.absolute is not None

    def configure(self, link: DriveLink | IoLink) -> Dialogue:
        """Watching, profile, start-up list, process data: in this order."""
        heartbeat_ms, timeout_ms = round(self._bus.heartbeat * 1000), round(self._bus.heartbeat_timeout * 1000)
        if link.guarded:
            link.toggle = -1
            yield Access(GUARD_TIME, 0, heartbeat_ms)
            yield Access(LIFE_TIME_FACTOR, 0, min(-(-timeout_ms // heartbeat_ms), 255))
        else:
            yield Access(PRODUCER_HEARTBEAT, 0, heartbeat_ms)
            yield Access(CONSUMER_HEARTBEAT, 1, self._bus.master_node << 16 | timeout_ms)
        if download := self._downloads.get(link.node):
            yield from _download(link, download)
        for index, value in self._clock_objects():
            if has(link, index):
                yield Access(index, 0, value)
        if isinstance(link, DriveLink):
            yield from self._configure_drive(link)
        else:
            for index, subindex, value in link.analogue.set_up():
                yield Access(index, subindex, value)
            for index, subindex, value in link.analogue.set_up_if_there():
                if has(link, index, subindex):
                    yield Access(index, subindex, value)
        for index, subindex, value in link.startup:
            yield Access(index, subindex, value)
        yield from _pdo_writes(link)

    def _clock_objects(self) -> Iterator[tuple[int, int]]:
        """The counter may be changed only while there is no period (CiA 301, object 0x1019)."""
        yield SYNC_COB_ID, SYNC
        if self._bus.sync_counter:
            yield SYNC_PERIOD, 0
            yield SYNC_COUNTER, self._bus.sync_counter
        yield SYNC_PERIOD, round(self._machine.cycle.period * 1e6)
        if self._bus.time_stamp:
            yield TIME_COB_ID, TIME_CONSUMER | TIME

    def _configure_drive(self, link: DriveLink) -> Dialogue:
        axis = self._machine.axes[link.axis]
        for index, subindex, value in drive_writes(axis, link, self._interpolation):
            if has(link, index, subindex):
                yield Access(index, subindex, value)
        for index, subindex, value in needed_writes(axis, link):
            yield Access(index, subindex, value)
        if axis.drive is not None and (transmission := axis.drive.transmission) is not None:
            for part in parts(transmission, link):
                if transmission.objects == "write":
                    yield Access(part.object, 1, part.first)
                    yield Access(part.object, 2, part.second)
                    continue
                found = (yield Access(part.object, 1)), (yield Access(part.object, 2))
                if not part.agrees(*found):
                    raise refused(
                        catalogue.UNITS_DIFFER,
                        link,
                        object=object_name(part.object),
                        actual=f"{found[0]}:{found[1]}",
                        expected=f"{part.first}:{part.second}",
                    )

    def first_values(self, link: DriveLink | IoLink) -> Dialogue:
        """Positions, states and inputs are known before the first cycle with the node."""
        if isinstance(link, DriveLink):
            if has(link, cia402.ERROR_CODE):
                self._image.fault_code[link.axis] = yield Access(cia402.ERROR_CODE)
            position = yield Access(cia402.POSITION_ACTUAL)
            statusword = yield Access(cia402.STATUSWORD)
            link.begin(statusword, position, self._image)
            return
        for one in link.analogue.inputs:
            one.counts = yield Access(*one.key)
            link.analogue.changed = True
        if link.inputs:
            data = bytearray()
            for group in range((link.inputs + 7) // 8):
                data.append((yield Access(exchange.READ_INPUTS, group + 1)))
            link.receive_inputs(data)


def _download(link: DriveLink | IoLink, download: Download) -> Dialogue:
    """The configuration file, unless the node says by date and time that it is configured so (CiA 302-3)."""
    stamp = download.configuration.stamp
    if stamp is not None:
        found = ((yield Access(VERIFY_CONFIGURATION, 1)), (yield Access(VERIFY_CONFIGURATION, 2)))
        if found == stamp:
            return
    for entry in download.configuration.entries:
        yield Access(entry.index, entry.subindex, data=_checked(link, entry))
    if stamp is not None:
        yield Access(VERIFY_CONFIGURATION, 1, stamp[0])
        yield Access(VERIFY_CONFIGURATION, 2, stamp[1])
    if download.store:
        yield Access(STORE_PARAMETERS, 1, SAVE)


def _checked(link: DriveLink | IoLink, entry: Entry) -> bytes:
    """The value of an entry, which fits its type in the EDS of the node. Raises FieldbusError."""
    access = Access(entry.index, entry.subindex)
    try:
        whole_number = find_variable(link.od, entry.index, entry.subindex).data_type in STRUCT_CODES
    except KeyError:
        raise refused(
            catalogue.EDS_OBJECT_MISSING, link, object=access.name, purpose="its configuration file"
        ) from None
    if whole_number:
        decoded(link, access, entry.data)
    return entry.data


def _pdo_writes(link: DriveLink | IoLink) -> Dialogue:
    """The order is that of CiA 301: switch off, empty, map, switch on; PDOs that nobody uses stay off."""
    used = {plan.communication_index: plan for plan in link.layouts}
    for direction in Direction:
        for number in range(1, LAST_PDO + 1):
            plan = PdoPlan(direction, number, ())
            index = plan.communication_index
            if index not in link.od:
                continue
            plan = used.get(index, plan)
            if number > PREDEFINED and index not in used:  # what it has for a COB-ID is the device's own
                found = yield Access(index, 1)
                if not found & INVALID:
                    yield Access(index, 1, found | INVALID)
                continue
            cob_id = plan.cob_id(link.node) | (NO_RTR if direction is Direction.TRANSMIT else 0)
            yield Access(index, 1, cob_id | INVALID)
            if index not in used:
                continue
            yield Access(plan.mapping_index, 0, 0)
            entries = link.layouts[plan].mapping_entries(link.od)
            for sub, entry in enumerate(entries, 1):
                yield Access(plan.mapping_index, sub, entry)
            yield Access(plan.mapping_index, 0, len(entries))
            yield Access(index, 2, plan.transmission)
            if plan.event_timer_ms and has(link, index, 5):
                yield Access(index, 5, plan.event_timer_ms)
            if plan.inhibit_time and has(link, index, 3):
                yield Access(index, 3, plan.inhibit_time)
            yield Access(index, 1, cob_id)


# -- from numbers to bytes, and what can go wrong --------------------------------------------------------------------


def has(link: DriveLink | IoLink, index: int, subindex: int = 0) -> bool:
    """Whether the EDS of the node has the object."""
    try:
        find_variable(link.od, index, subindex)
    except KeyError:
        return False
    return True


def encoded(link: DriveLink | IoLink, access: Access) -> bytes:
    """The data of a write. Raises FieldbusError for an object that the EDS does not have, or a value it cannot take."""
    if access.data is not None:
        return access.data
    assert access.value is not None
    try:
        data: bytes = find_variable(link.od, access.index, access.subindex).encode_raw(access.value)
    except KeyError:
        raise refused(catalogue.EDS_OBJECT_MISSING, link, object=access.name, purpose="the configuration") from None
    except (struct.error, ValueError, OverflowError, ObjectDictionaryError) as error:
        raise refused(
            catalogue.STARTUP_OBJECT, link, object=access.name, value=access.value, reason=str(error)
        ) from error
    return data


def decoded(link: DriveLink | IoLink, access: Access, data: bytes) -> int:
    """The number that was read. Raises FieldbusError, also for an answer of another length than the EDS says."""
    try:
        return int(find_variable(link.od, access.index, access.subindex).decode_raw(data))
    except KeyError:
        purpose = "the check of the device"
        raise refused(catalogue.EDS_OBJECT_MISSING, link, object=access.name, purpose=purpose) from None
    except (struct.error, ValueError, ObjectDictionaryError) as error:
        raise silent(link, access, f"its {len(data)} bytes are no value of the type in the EDS") from error


def refused(entry: ErrorEntry, link: DriveLink | IoLink, **values: object) -> FieldbusError:
    return FieldbusError(entry, Place(), node=link.node, owner=link.owner, **values)


def aborted(link: DriveLink | IoLink, access: Access, code: int) -> FieldbusError:
    """The node refuses an access, with an abort code of CiA 301."""
    meaning = abort_text(code)
    return refused(catalogue.SDO_ABORTED, link, access=access.verb, object=access.name, meaning=meaning, code=code)


def silent(link: DriveLink | IoLink, access: Access, reason: str) -> FieldbusError:
    """The node does not answer, or answers what is no answer."""
    return refused(catalogue.SDO_NO_ANSWER, link, access=access.verb, object=access.name, reason=reason)
