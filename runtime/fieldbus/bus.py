"""Opening the CAN bus that the machine description names; what can go wrong is told in the user's terms."""

from __future__ import annotations

import errno
import fcntl
import inspect
import ipaddress
import socket
import struct
from collections.abc import Callable
from typing import Final

import can
from can.interfaces.socketcan import SocketcanBus
from can.interfaces.virtual import VirtualBus

from runtime.config.machine import Bus, Machine
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.multicast import MulticastBus

_BY_ERRNO: dict[int, ErrorEntry] = {
    errno.ENODEV: catalogue.BUS_MISSING,
    errno.ENXIO: catalogue.BUS_MISSING,
    errno.ENETDOWN: catalogue.BUS_DOWN,
    errno.EPERM: catalogue.BUS_PERMISSION,
    errno.EACCES: catalogue.BUS_PERMISSION,
    errno.EAFNOSUPPORT: catalogue.BUS_UNSUPPORTED,
    errno.EPROTONOSUPPORT: catalogue.BUS_UNSUPPORTED,
    errno.ENETUNREACH: catalogue.BUS_NO_MULTICAST,
    errno.EHOSTUNREACH: catalogue.BUS_NO_MULTICAST,
    errno.EADDRNOTAVAIL: catalogue.BUS_NO_MULTICAST,
}
INTERFACES: Final[dict[str, Callable[..., can.BusABC]]] = {
    "socketcan": SocketcanBus,
    "virtual": VirtualBus,
    "udp_multicast": MulticastBus,
}
SIOCGIFFLAGS: Final = 0x8913
INTERFACE_UP: Final = 0x1
SIOCGIFMTU: Final = 0x8921
CANFD_MTU: Final = 72  # bytes of a struct canfd_frame
_MULTICAST_ONLY = (catalogue.BUS_NO_MULTICAST,)
_NO_GROUP = (errno.ENODEV, errno.ENXIO, errno.ENETDOWN)  # of a group: there is no interface that it could be joined on


def open_bus(config: Bus) -> can.BusABC:
    """An open bus. The caller shuts it down. Raises FieldbusError (303001 to 303007)."""
    # Not can.Bus(): that would let configuration files of the user's home have a say.
    interface = INTERFACES[config.interface]
    known = set(inspect.signature(interface).parameters) - {"self", "channel", "kwargs"}
    if unknown := sorted(set(config.options) - known):
        reason = f"known are {', '.join(sorted(known))}"
        raise _problem(catalogue.BUS_BAD_OPTION, config, reason, options=", ".join(unknown))
    if config.interface == "udp_multicast":
        _check_group(config)
    options: dict[str, object] = dict(config.options)
    try:
        # binding to an interface that is down succeeds; its flags tell
        if config.interface == "socketcan" and not _interface_flags(config.channel) & INTERFACE_UP:
            raise OSError(errno.ENETDOWN, "the interface is down")
        if config.fd:
            options |= _fd_options(config)
        bus = interface(config.channel, **options)
    except (TypeError, ValueError, socket.gaierror) as error:
        raise _problem(catalogue.BUS_BAD_OPTION, config, str(error), options=str(config.options)) from error
    except (can.CanError, OSError) as error:
        raise _translate(config, error) from error
    if config.interface == "udp_multicast":
        _check_route(config, bus)
    return bus


def open_buses(machine: Machine) -> dict[str, can.BusABC]:
    """All buses of a machine, by their names. The caller shuts them down. Raises FieldbusError; then none stays open."""
    opened: dict[str, can.BusABC] = {}
    try:
        for name, config in machine.fieldbus.all_buses().items():
            opened[name] = open_bus(config)
    except FieldbusError:
        for bus in opened.values():
            bus.shutdown()
        raise
    return opened


def _check_group(config: Bus) -> None:
    try:
        multicast = ipaddress.ip_address(config.channel).is_multicast
    except ValueError:
        multicast = False
    if not multicast:
        raise _problem(catalogue.BUS_NO_MULTICAST, config, "this is no multicast address")


def _check_route(config: Bus, bus: can.BusABC) -> None:
    """A group can be joined on an interface that has no route to it: only sending tells."""
    try:
        # an empty frame of an identifier that nobody uses harms nobody
        bus.send(can.Message(arbitration_id=0x7FF, is_extended_id=False))
    except can.CanError as error:
        bus.shutdown()
        raise _translate(config, error) from error


def _interface_flags(channel: str) -> int:
    """Flags of a network interface; raises OSError (ENODEV: none of this name, EAFNOSUPPORT: no CAN in the kernel)."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
        request = struct.pack("16sh14x", channel.encode()[:15], 0)
        flags: int = struct.unpack("16sh14x", fcntl.ioctl(probe, SIOCGIFFLAGS, request))[1]
    return flags


def _fd_options(config: Bus) -> dict[str, object]:
    """What makes the interface take frames of CAN FD. Raises FieldbusError if it cannot."""
    if config.interface == "virtual":
        return {"protocol": can.CanProtocol.CAN_FD}
    if config.interface == "socketcan":
        if _interface_mtu(config.channel) < CANFD_MTU:
            raise _problem(catalogue.BUS_NO_FD, config, "its frames are classic ones")
        return {"fd": True}
    return {}  # CAN over multicast carries frames of any kind


def _interface_mtu(channel: str) -> int:
    """Greatest frame of a network interface, bytes; raises OSError."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
        request = struct.pack("16si12x", channel.encode()[:15], 0)
        mtu: int = struct.unpack("16si12x", fcntl.ioctl(probe, SIOCGIFMTU, request))[1]
    return mtu


def _translate(config: Bus, error: Exception) -> FieldbusError:
    """The catalogue entry for what the operating system or python-can said."""
    cause: BaseException | None = error
    while cause is not None:
        code = getattr(cause, "errno", None) or getattr(cause, "error_code", None)
        entry = _BY_ERRNO.get(code or 0)
        if config.interface == "udp_multicast" and code in _NO_GROUP:
            entry = catalogue.BUS_NO_MULTICAST
        if entry and (config.interface == "udp_multicast" or entry not in _MULTICAST_ONLY):
            return _problem(entry, config, str(cause))
        cause = cause.__cause__
    if isinstance(error, can.CanInterfaceNotImplementedError):
        return _problem(catalogue.BUS_UNSUPPORTED, config, str(error))
    return _problem(catalogue.BUS_OPEN_FAILED, config, str(error))


def _problem(entry: ErrorEntry, config: Bus, reason: str, options: str = "") -> FieldbusError:
    return FieldbusError(
        entry,
        interface=config.interface,
        channel=config.channel,
        bitrate=config.bitrate,
        reason=reason,
        options=options,
    )
