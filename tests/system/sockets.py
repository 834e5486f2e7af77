"""Which sockets of a process the network could reach, as the kernel tells it."""

from __future__ import annotations

import os
import re
from collections.abc import Iterable
from dataclasses import dataclass
from ipaddress import ip_address
from pathlib import Path
from typing import Final

FAMILIES: Final = ("tcp", "tcp6", "udp", "udp6", "udplite", "udplite6", "raw", "raw6", "packet")
LISTENING: Final = "0A"  # state of a TCP socket


@dataclass(frozen=True, slots=True)
class Socket:
    """A socket of the internet families."""

    family: str
    address: str
    port: int
    listening: bool  # takes connections, or datagrams of anybody


def network_sockets(pids: Iterable[int]) -> list[Socket]:
    """Those of these processes that listen, or are not connected."""
    inodes = {inode for pid in pids for inode in _inodes(pid)}
    found = []
    for family in FAMILIES:
        file = Path("/proc/net") / family
        for line in file.read_text().splitlines()[1:] if file.exists() else []:
            columns = line.split()
            if columns[8 if family == "packet" else 9] not in inodes:
                continue
            address, _, port = columns[1].partition(":")
            listening = columns[3] == LISTENING or not family.startswith("tcp")
            found.append(Socket(family, _readable(address) if port else "", int(port or "0", 16), listening))
    return found


def _inodes(pid: int) -> Iterable[str]:
    for descriptor in Path(f"/proc/{pid}/fd").iterdir():
        try:
            link = os.readlink(descriptor)
        except OSError:  # closed meanwhile
            continue
        if match := re.fullmatch(r"socket:\[(\d+)\]", link):
            yield match[1]


def _readable(address: str) -> str:
    """The kernel writes addresses as words in the byte order of the host."""
    words = [bytes.fromhex(address[i : i + 8])[::-1] for i in range(0, len(address), 8)]
    return str(ip_address(b"".join(words)))
