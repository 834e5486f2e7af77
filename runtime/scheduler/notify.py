"""Telling systemd how the service is: sd_notify(3), written out because it is one datagram.

Without $NOTIFY_SOCKET nothing is told and nothing fails. Sending never blocks: the cycle feeds the watchdog.
"""

from __future__ import annotations

import os
import socket
from collections.abc import Mapping


class Notifier:
    """The socket of the service manager, or none."""

    def __init__(self, address: str | None = None, *, watchdog: float | None = None) -> None:
        """`address`: path of the socket, "@name" for an abstract one, None: none. `watchdog`: its time limit in s."""
        self.watchdog_limit = watchdog
        self._socket: socket.socket | None = None
        self._address = ""
        if address:
            self._address = "\0" + address[1:] if address.startswith("@") else address
            self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC | socket.SOCK_NONBLOCK)

    @classmethod
    def from_environment(cls, environment: Mapping[str, str], pid: int | None = None) -> Notifier:
        """What systemd tells the service; `pid` is that of this process (os.getpid()).

        $WATCHDOG_PID names the main process; with NotifyAccess=all any process of the service may feed, so a process
        that feeds for it takes the limit from the main process' notifier.
        """
        watchdog = None
        limit, owner = environment.get("WATCHDOG_USEC", ""), environment.get("WATCHDOG_PID", "")
        if limit.isdigit() and int(limit) > 0 and (not owner or owner == str(os.getpid() if pid is None else pid)):
            watchdog = int(limit) / 1e6
        return cls(environment.get("NOTIFY_SOCKET"), watchdog=watchdog)

    def ready(self, status: str = "") -> bool:
        """Start-up is finished; whether it was told."""
        return self._send("READY=1", f"STATUS={_line(status)}" if status else "")

    def status(self, text: str) -> bool:
        """One line for `systemctl status`."""
        return self._send(f"STATUS={_line(text)}")

    def starting(self, text: str, seconds: float) -> bool:
        """The start goes on: one line about it, and it may take so many seconds more from now, whatever the unit allows."""
        return self._send(f"STATUS={_line(text)}", f"EXTEND_TIMEOUT_USEC={round(seconds * 1e6)}")

    def feed_watchdog(self) -> bool:
        """Sign of life; due at least twice within `watchdog_limit`."""
        return self._send("WATCHDOG=1")

    def stopping(self, status: str = "") -> bool:
        """The service ends in order."""
        return self._send("STOPPING=1", f"STATUS={_line(status)}" if status else "")

    def close(self) -> None:
        """Let go of the socket; afterwards nothing is told."""
        if self._socket is not None:
            self._socket.close()
            self._socket = None

    def _send(self, *assignments: str) -> bool:
        if self._socket is None:
            return False
        try:
            self._socket.sendto("\n".join(filter(None, assignments)).encode(), self._address)
        except OSError:  # the manager is gone or its queue is full: no reason to stop a machine
            return False
        return True


def _line(text: str) -> str:
    return " ".join(text.split())
