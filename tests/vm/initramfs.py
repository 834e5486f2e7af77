"""The first file system of the virtual machine: busybox, the modules, one script. Written without root and without cpio."""

from __future__ import annotations

import stat
from collections.abc import Sequence
from pathlib import Path
from typing import Final

from tests.vm.parts import Kernel

MODULES: Final = (
    # in the order in which they need each other
    "drivers/virtio/virtio_ring",
    "drivers/virtio/virtio",
    "drivers/virtio/virtio_pci_legacy_dev",
    "drivers/virtio/virtio_pci_modern_dev",
    "drivers/virtio/virtio_pci",
    "net/can/can",
    "net/can/can-raw",
    "drivers/net/can/dev/can-dev",
    "drivers/net/can/vcan",
    "drivers/net/can/sja1000/sja1000",
    "drivers/net/can/sja1000/kvaser_pci",
    "fs/netfs/netfs",
    "fs/fscache/fscache",
    "net/9p/9pnet",
    "net/9p/9pnet_virtio",
    "fs/9p/9p",
)
DISK_MODULES: Final = (
    # behind the others: a disk with a file system
    "drivers/block/virtio_blk",
    "crypto/crc32c_generic",
    "lib/libcrc32c",
    "lib/crc16",
    "fs/mbcache",
    "fs/jbd2/jbd2",
    "fs/ext4/ext4",
)
APPLETS: Final = (
    "sh",
    "mount",
    "umount",
    "mkdir",
    "insmod",
    "chroot",
    "poweroff",
    "cat",
    "echo",
    "ip",
    "switch_root",
    "sync",
)


def write(archive: Path, kernel: Kernel, busybox: Path, script: str, more: Sequence[str] = ()) -> None:
    """An initramfs whose init is `script`; `more`: modules beside those that every machine needs."""
    entries: list[tuple[str, int, bytes]] = [(name, stat.S_IFDIR | 0o755, b"") for name in ("bin", "modules", "proc")]
    entries += [(name, stat.S_IFDIR | 0o755, b"") for name in ("sys", "dev", "root")]
    entries.append(("bin/busybox", stat.S_IFREG | 0o755, busybox.read_bytes()))
    entries += [(f"bin/{applet}", stat.S_IFLNK | 0o777, b"busybox") for applet in APPLETS]
    entries.append(("init", stat.S_IFREG | 0o755, script.encode()))
    for module in (*MODULES, *more):
        name = module.rpartition("/")[2]
        entries.append((f"modules/{name}.ko", stat.S_IFREG | 0o644, (kernel.modules / f"{module}.ko").read_bytes()))
    with archive.open("wb") as file:
        for number, (name, mode, data) in enumerate(entries, 1):
            file.write(_entry(number, name, mode, data))
        file.write(_entry(0, "TRAILER!!!", 0, b""))


def load_modules(more: Sequence[str] = ()) -> str:
    """The line of the script that loads everything."""
    names = " ".join(module.rpartition("/")[2] for module in (*MODULES, *more))
    return f"for m in {names}; do insmod /modules/$m.ko || echo no module $m; done"


def _entry(number: int, name: str, mode: int, data: bytes) -> bytes:
    """One entry in the "newc" format: a header of hexadecimal numbers, name and data filled up to multiples of four."""
    fields = (number, mode, 0, 0, 1, 0, len(data), 0, 0, 0, 0, len(name) + 1, 0)
    head = b"070701" + b"".join(b"%08X" % field for field in fields) + name.encode() + b"\0"
    return head + bytes(-len(head) % 4) + data + bytes(-len(data) % 4)
