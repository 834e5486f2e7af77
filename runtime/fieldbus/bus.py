"""Opening the CAN bus that the machine description names; what can go wrong is told in the user's terms."""

from __future__ import annotations

import errno
import fcntl
import ipaddress
import socket
import struct
from typing import Any, Final

import can

from runtime.config.machine import Bus
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
SIOCGIFFLAGS: Final = 0x8913
INTERFACE_UP: Final = 0x1
_MULTICAST_ONLY = (catalogue.BUS_NO_MULTICAST,)


def open_bus(config: Bus) -> can.BusABC:
    """An open bus. The caller shuts it down. Raises FieldbusError (303001 to 303007)."""
    try:
        if config.interface == "udp_multicast":
            return _open_multicast(config)
        if config.interface == "socketcan":
            _check_up(config)
        arguments: dict[str, Any] = dict(config.options)
        return can.Bus(interface=config.interface, channel=config.channel, **arguments)
    except TypeError as error:
        options = ", ".join(config.options) or "none"
        raise _problem(catalogue.BUS_BAD_OPTION, config, str(error), options=options) from error
    except (can.CanError, OSError) as error:
        raise _translate(config, error) from error


def _open_multicast(config: Bus) -> can.BusABC:
    try:
        if not ipaddress.ip_address(config.channel).is_multicast:
            raise _problem(catalogue.BUS_NO_MULTICAST, config, "this is no multicast address")
    except ValueError:
        raise _problem(catalogue.BUS_NO_MULTICAST, config, "this is no IP address") from None
    bus = MulticastBus(config.channel, **config.options)
    try:
        # A group can be joined on an interface that has no route to it: only sending tells. An empty frame of an
        # identifier that nobody uses harms nobody.
        bus.send(can.Message(arbitration_id=0x7FF, is_extended_id=False))
    except can.CanError:
        bus.shutdown()
        raise
    return bus


def _check_up(config: Bus) -> None:
    """Binding to an interface that is down succeeds; its flags tell. Raises OSError."""
    with socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW) as probe:
        request = struct.pack("16sh14x", config.channel.encode()[:15], 0)
        flags = struct.unpack("16sh14x", fcntl.ioctl(probe, SIOCGIFFLAGS, request))[1]
    if not flags & INTERFACE_UP:
        raise OSError(errno.ENETDOWN, "the interface is down")


def _translate(config: Bus, error: Exception) -> FieldbusError:
    """The catalogue entry for what the operating system or python-can said."""
    cause: BaseException | None = error
    while cause is not None:
        code = getattr(cause, "errno", None) or getattr(cause, "error_code", None)
        entry = _BY_ERRNO.get(code or 0)
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
