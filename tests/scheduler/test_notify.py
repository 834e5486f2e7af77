"""sd_notify: what arrives at the service manager's socket, and silence without one."""

from __future__ import annotations

import os
import socket
from collections.abc import Iterator
from pathlib import Path

import pytest

from runtime.scheduler.notify import Notifier


@pytest.fixture(params=["path", "abstract"])
def manager(request: pytest.FixtureRequest, tmp_path: Path) -> Iterator[tuple[socket.socket, str]]:
    """A service manager's socket and its address as $NOTIFY_SOCKET gives it."""
    name = str(tmp_path / "notify") if request.param == "path" else f"@tandem-test-{os.getpid()}"
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as listener:
        listener.bind("\0" + name[1:] if name.startswith("@") else name)
        listener.settimeout(5)
        yield listener, name


def test_every_message_arrives(manager: tuple[socket.socket, str]) -> None:
    listener, name = manager
    notifier = Notifier.from_environment({"NOTIFY_SOCKET": name})
    sent = [
        (notifier.ready("drives enabled"), b"READY=1\nSTATUS=drives enabled"),
        (notifier.ready(), b"READY=1"),
        (notifier.status("two\nlines  are one"), b"STATUS=two lines are one"),
        (notifier.starting("kernels", 120.0), b"STATUS=kernels\nEXTEND_TIMEOUT_USEC=120000000"),
        (notifier.feed_watchdog(), b"WATCHDOG=1"),
        (notifier.stopping("asked to"), b"STOPPING=1\nSTATUS=asked to"),
    ]
    for told, message in sent:
        assert told
        assert listener.recv(4096) == message
    notifier.close()
    assert not notifier.feed_watchdog()


def test_without_a_manager_nothing_is_told_and_nothing_fails(tmp_path: Path) -> None:
    silent = Notifier.from_environment({})
    assert not silent.ready()
    assert silent.watchdog_limit is None
    assert not Notifier(str(tmp_path / "gone")).status("x")


def test_a_full_queue_does_not_block(manager: tuple[socket.socket, str]) -> None:
    _, name = manager
    notifier = Notifier(name)
    results = [notifier.feed_watchdog() for _ in range(5000)]
    assert results[0] is True
    assert results[-1] is False


def test_the_watchdog_limit_is_that_of_this_process() -> None:
    environment = {"WATCHDOG_USEC": "2000000", "WATCHDOG_PID": "77"}
    assert Notifier.from_environment(environment, pid=77).watchdog_limit == 2.0
    assert Notifier.from_environment(environment, pid=78).watchdog_limit is None
    assert Notifier.from_environment({"WATCHDOG_USEC": "500000"}).watchdog_limit == 0.5
    assert Notifier.from_environment({"WATCHDOG_USEC": "junk"}).watchdog_limit is None
