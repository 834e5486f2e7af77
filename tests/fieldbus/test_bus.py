"""Opening a bus by configuration only, and what is told when it cannot be."""

from __future__ import annotations

import errno
import os
import socket
from typing import Any

import can
import pytest
from can.interfaces.udp_multicast.utils import pack_message

from runtime.config.machine import Bus
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.fieldbus import bus as module
from runtime.fieldbus.bus import open_bus
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.multicast import MulticastBus


def port() -> int:
    """A UDP port that this test has for itself."""
    return 20_000 + os.getpid() % 20_000


@pytest.fixture
def multicast() -> dict[str, Any]:
    config = {"interface": "udp_multicast", "channel": "239.74.163.2", "options": {"hop_limit": 0, "port": port()}}
    try:
        open_bus(Bus(**config)).shutdown()  # type: ignore[arg-type]
    except FieldbusError as error:
        pytest.skip(f"no multicast here: {error}")
    return config


def refused(config: Bus, entry: ErrorEntry) -> str:
    with pytest.raises(FieldbusError) as error:
        open_bus(config)
    assert error.value.problem.entry is entry
    assert error.value.problem.explained()
    return error.value.problem.text


def test_virtual() -> None:
    with open_bus(Bus(interface="virtual", channel="test-open")) as bus:
        assert isinstance(bus, can.BusABC)


def test_multicast_carries_frames_between_two_and_has_no_echo(multicast: dict[str, Any]) -> None:
    with open_bus(Bus(**multicast)) as one, open_bus(Bus(**multicast)) as two:
        while one.recv(0.05) or two.recv(0.05):
            pass
        one.send(can.Message(arbitration_id=0x181, data=b"\x01\x02", is_extended_id=False))
        message = two.recv(1.0)
        assert message is not None
        assert (message.arbitration_id, bytes(message.data)) == (0x181, b"\x01\x02")
        assert one.recv(0.05) is None


def test_nobody_reaches_the_group_by_an_address_of_this_computer(multicast: dict[str, Any]) -> None:
    """What the network could send: a datagram to the computer itself, on the port of the bus."""
    stop = pack_message(can.Message(arbitration_id=0x000, data=b"\x02\x00", is_extended_id=False))
    with open_bus(Bus(**multicast)) as bus, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        while bus.recv(0.05):
            pass
        stranger.setsockopt(socket.IPPROTO_IP, socket.IP_MULTICAST_IF, socket.inet_aton("127.0.0.1"))
        for address in {"127.0.0.1", "127.0.0.2", socket.gethostbyname(socket.gethostname())}:
            stranger.sendto(stop, (address, port()))
        assert bus.recv(0.1) is None
        stranger.sendto(stop, (multicast["channel"], port()))  # by the group it is heard
        heard = bus.recv(1.0)
        assert heard is not None
        assert heard.arbitration_id == 0x000


@pytest.mark.parametrize(("code", "hop_limit"), [(errno.ENODEV, 0), (errno.ENETDOWN, 1), (errno.ENETUNREACH, 1)])
def test_a_group_that_cannot_be_joined(monkeypatch: pytest.MonkeyPatch, code: int, hop_limit: int) -> None:
    def join(self: object, *_: object) -> None:
        raise OSError(code, os.strerror(code))

    monkeypatch.setattr(MulticastBus, "_join", join)
    config = Bus(interface="udp_multicast", channel="239.1.2.3", options={"hop_limit": hop_limit})
    assert os.strerror(code) in refused(config, catalogue.BUS_NO_MULTICAST)


def test_a_group_of_this_computer_needs_no_network_card(multicast: dict[str, Any]) -> None:
    """Somebody who joined it on the loopback interface only hears it."""
    loopback = socket.inet_aton("127.0.0.1")
    with open_bus(Bus(**multicast)) as bus, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as listener:
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEPORT, 1)
        listener.setsockopt(socket.IPPROTO_IP, 49, 0)  # IP_MULTICAST_ALL, ip(7): only what was joined here
        listener.bind(("", port()))
        group = socket.inet_aton(multicast["channel"])
        listener.setsockopt(socket.IPPROTO_IP, socket.IP_ADD_MEMBERSHIP, group + loopback)
        listener.settimeout(5.0)
        bus.send(can.Message(arbitration_id=0x182, data=b"\x03", is_extended_id=False))
        assert b"arbitration_id" in listener.recv(4096)


def test_multicast_ignores_what_is_no_frame(multicast: dict[str, Any]) -> None:
    with open_bus(Bus(**multicast)) as bus, socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as stranger:
        while bus.recv(0.05):
            pass
        for rubbish in (b"", b"hello", b"\x81\xa1a\x01", bytes(300)):
            stranger.sendto(rubbish, ("239.74.163.2", port()))
        assert bus.recv(0.1) is None


@pytest.mark.parametrize("channel", ["192.168.1.1", "can0", ""])
def test_a_channel_that_is_no_multicast_address(channel: str) -> None:
    config = Bus(interface="udp_multicast", channel=channel)
    assert "address" in refused(config, catalogue.BUS_NO_MULTICAST)


@pytest.mark.parametrize("interface", ["udp_multicast", "socketcan", "virtual"])
def test_options_that_the_interface_does_not_know(interface: str) -> None:
    config = Bus.model_validate({"interface": interface, "channel": "239.1.2.3", "options": {"hops": 1}})
    assert "hops" in refused(config, catalogue.BUS_BAD_OPTION)


def test_options_of_the_wrong_type() -> None:
    config = Bus.model_validate({"interface": "udp_multicast", "channel": "239.1.2.3", "options": {"port": "many"}})
    refused(config, catalogue.BUS_BAD_OPTION)


class Answers:
    """Stands for the kernel: what happens when the socket is opened."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.opened: dict[str, Any] = {}
        self.error: Exception | None = None
        self.flags = 0x1
        monkeypatch.setitem(module.INTERFACES, "socketcan", self.open)
        monkeypatch.setattr(module, "_interface_flags", lambda channel: self.flags)

    def open(self, channel: str, local_loopback: bool = True, fd: bool = False) -> Any:
        self.opened = {"channel": channel, "local_loopback": local_loopback, "fd": fd}
        if self.error:
            raise self.error
        return "the bus"


@pytest.fixture
def kernel(monkeypatch: pytest.MonkeyPatch) -> Answers:
    return Answers(monkeypatch)


def test_socketcan_by_configuration_only(kernel: Answers) -> None:
    config = Bus(interface="socketcan", channel="can7", options={"local_loopback": False})
    assert str(open_bus(config)) == "the bus"
    assert kernel.opened == {"channel": "can7", "local_loopback": False, "fd": False}


@pytest.mark.parametrize(
    ("error", "entry"),
    [
        (OSError(errno.ENODEV, "No such device"), catalogue.BUS_MISSING),
        (OSError(errno.ENETDOWN, "Network is down"), catalogue.BUS_DOWN),
        (PermissionError(errno.EPERM, "Operation not permitted"), catalogue.BUS_PERMISSION),
        (OSError(errno.EAFNOSUPPORT, "Address family not supported by protocol"), catalogue.BUS_UNSUPPORTED),
        (can.CanInitializationError("something", errno.ENODEV), catalogue.BUS_MISSING),
        (can.CanInterfaceNotImplementedError("no such interface"), catalogue.BUS_UNSUPPORTED),
        (can.CanInitializationError("something else"), catalogue.BUS_OPEN_FAILED),
        (OSError(errno.ENETUNREACH, "Network is unreachable"), catalogue.BUS_OPEN_FAILED),
        (TypeError("unexpected keyword argument"), catalogue.BUS_BAD_OPTION),
    ],
)
def test_what_the_kernel_says_is_told_in_the_users_terms(kernel: Answers, error: Exception, entry: ErrorEntry) -> None:
    kernel.error = error
    refused(Bus(interface="socketcan", channel="can0"), entry)


def test_an_interface_that_is_down(kernel: Answers) -> None:
    kernel.flags = 0
    text = refused(Bus(interface="socketcan", channel="can0"), catalogue.BUS_DOWN)
    assert "can0" in text


def test_socketcan_here_gives_a_bus_or_a_clear_error() -> None:
    """On this very host: an interface of this name does not exist, or there is no CAN in the kernel at all."""
    with pytest.raises(FieldbusError) as error:
        open_bus(Bus(interface="socketcan", channel="tandemtest0"))
    assert error.value.problem.entry in (catalogue.BUS_MISSING, catalogue.BUS_UNSUPPORTED, catalogue.BUS_PERMISSION)


def test_a_route_that_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    def unreachable(self: object, *_: object) -> None:
        raise can.CanOperationError("failed to send via socket") from OSError(errno.ENETUNREACH, "unreachable")

    monkeypatch.setattr(MulticastBus, "__init__", lambda self, channel: None)
    monkeypatch.setattr(MulticastBus, "shutdown", lambda self: None)
    monkeypatch.setattr(MulticastBus, "send", unreachable)
    monkeypatch.setattr(MulticastBus, "__del__", lambda self: None)
    config = Bus(interface="udp_multicast", channel="239.1.2.3")
    assert "239.1.2.3" in refused(config, catalogue.BUS_NO_MULTICAST)
