"""Starting the virtual machine and waiting for its end.

Quick form: the host's root is the guest's, read-only, so the guest has the same Python environment as the tests.

    /            the host's root, read-only (9p)           /run, /dev/shm   memory of the guest
    /run/out     folder of this run, writable (9p)         /run/kernels     compiled kernels, writable (9p)

Full form: a disk with a Debian system of its own, systemd as init (tests.vm.system_image).

    /            /dev/vda, writable, kept from boot to boot         /run, /dev/shm   memory of the guest
    /run/out     folder of this run, writable (9p)         /run/tests, /run/sources   what plays, README and units (9p)

Software emulation on purpose: it needs no privilege and works inside other virtual machines. A busy host falsifies the first
measurement of the processor's clock, so the kernel may measure it again, and takes the timer without asking.
"""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Final

from tests.vm import initramfs, parts, system_image

PROJECT: Final = Path(__file__).parents[2]
MEMORY_MB: Final = 2048
PROCESSORS: Final = 3  # cycle and drives may take one each, in real-time priority, where the host is busy
GENERIC: Final = {"NUMBA_CPU_NAME": "x86-64-v2", "NUMBA_CPU_FEATURES": ""}  # machine code that host and guest both run
_IMPORTED: Final = (  # what the processes in the guest import
    "runtime.cli.run",
    "runtime.scheduler.session",
    "runtime.scheduler.cycle_process",
    "runtime.scheduler.preparation_process",
    "runtime.scheduler.plc_process",
    "runtime.demo.plc",
    "runtime.fieldbus.simulator.__main__",
    "tests.vm.guest.quick",
    "tests.vm.guest.wire_log",
)

_QUICK_INIT: Final = """#!/bin/sh
export PATH=/bin
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev
{modules}
P=trans=virtio,version=9p2000.L,msize=512000
mount -t 9p -o $P,ro,cache=loose hostroot /root || poweroff -f
mount -t tmpfs -o mode=755 run /root/run
mkdir /root/run/out /root/run/kernels /root/run/tmp /root/run/home
mount -t 9p -o $P out /root/run/out
mount -t 9p -o $P kernels /root/run/kernels
mount --bind /proc /root/proc; mount --bind /sys /root/sys; mount --bind /dev /root/dev
mkdir -p /dev/shm; mount -t tmpfs shm /dev/shm
ip link set lo up
echo 1 > /proc/sys/kernel/printk
cat > /root/run/job <<'JOB'
{job}
JOB
chroot /root /bin/sh /run/job > /root/run/out/console.txt 2>&1
echo $? > /root/run/out/code
sync
poweroff -f
"""

_FULL_INIT: Final = """#!/bin/sh
export PATH=/bin
mount -t proc proc /proc; mount -t sysfs sys /sys; mount -t devtmpfs dev /dev
{modules}
P=trans=virtio,version=9p2000.L,msize=512000
mount -t ext4 /dev/vda /root || poweroff -f
mount -t tmpfs -o mode=755 run /root/run
mkdir -p /root/run/out /root/run/tests/tests /root/run/sources
mount -t 9p -o $P out /root/run/out
mount -t 9p -o $P,ro,cache=loose tests /root/run/tests/tests
mount -t 9p -o $P,ro,cache=loose sources /root/run/sources
umount /dev; umount /sys; umount /proc
exec switch_root /root /lib/systemd/systemd
"""


@dataclass(frozen=True, slots=True)
class GuestRun:
    """How a run ended: exit code of the job inside, -1 if it did not get so far; everything that was printed."""

    code: int
    console: str
    folder: Path


def run_quick(module: str, arguments: Sequence[str], folder: Path, limit: float) -> GuestRun:
    """Run `python -m module arguments` inside a machine with two CAN cards on one wire; at most `limit` s.

    Raises parts.UnavailableError.
    """
    parts.require_tools()
    kernel = parts.kernel()
    kernels = kernel_cache()
    environment = {
        "HOME": "/run/home",
        "TMPDIR": "/run/tmp",
        "NUMBA_CACHE_DIR": "/run/kernels",
        "MPLCONFIGDIR": "/run/home",
        "PYTHONPATH": str(PROJECT),
        "PYTHONPYCACHEPREFIX": "/run/kernels/bytecode",
        "PATH": "/usr/sbin:/usr/bin:/sbin:/bin",
        **GENERIC,
    }
    job = "\n".join(f"export {key}='{value}'" for key, value in environment.items())
    job += f"\ncd {PROJECT}\nexec {sys.executable} -m {module} {' '.join(arguments)}"
    script = _QUICK_INIT.format(modules=initramfs.load_modules(), job=job)
    initramfs.write(folder / "initramfs", kernel, parts.busybox(), script)
    shares = [share("hostroot", Path("/"), readonly=True), share("out", folder), share("kernels", kernels)]
    command = [*base_command(kernel, folder), *(word for words in shares for word in words)]
    start_and_wait(command, limit)
    return result_of(folder)


class Disk:
    """A machine that is booted again and again from one disk of its own."""

    def __init__(self, folder: Path) -> None:
        """Raises parts.UnavailableError."""
        parts.require_tools(*system_image.TOOLS)
        self.folder = folder
        self._kernel = parts.kernel()
        self._disk = system_image.copy_of(system_image.system_image(GENERIC), folder / "disk.ext4")
        script = _FULL_INIT.format(modules=initramfs.load_modules(initramfs.DISK_MODULES))
        initramfs.write(folder / "initramfs", self._kernel, parts.busybox(), script, initramfs.DISK_MODULES)

    def boot(self, part: str, limit: float, cut: float | None = None) -> GuestRun:
        """Play a part of tests.vm.guest.full; with `cut` the power goes so many seconds after the guest has asked for it."""
        variables = {**GENERIC, "PART": part, "PYTHONDONTWRITEBYTECODE": "1"}
        variables |= {name: os.environ[name] for name in ("ONLY",) if name in os.environ}
        (self.folder / "environment").write_text("".join(f"{key}={value}\n" for key, value in variables.items()))
        asked = self.folder / "cut-the-power"
        asked.unlink(missing_ok=True)
        shares = [
            share("out", self.folder),
            share("tests", PROJECT / "tests", readonly=True),
            share("sources", PROJECT, readonly=True),
        ]
        command = base_command(self._kernel, self.folder)
        command += ["-drive", f"file={self._disk},format=raw,if=virtio,cache=writeback"]
        command += [word for words in shares for word in words]
        played = start_and_wait(command, limit, asked, cut)
        if not played and part != "first":  # a crash of the emulator is one more loss of power
            start_and_wait(command, limit, asked, cut)
        return result_of(self.folder)


def kernel_cache() -> Path:
    """A folder in which every kernel is compiled, and every module of the runtime, for any processor."""
    folder = parts.cache_folder() / "kernels"
    folder.mkdir(exist_ok=True)
    environment = {**os.environ, **GENERIC, "NUMBA_CACHE_DIR": str(folder), "PYTHONPATH": str(PROJECT)}
    environment["PYTHONPYCACHEPREFIX"] = str(
        folder / "bytecode"
    )  # of everything that is imported, whoever has installed it
    environment.pop("PYTHONDONTWRITEBYTECODE", None)
    code = f"import {', '.join(_IMPORTED)}; from runtime.cli.preparing import prepare_kernels; prepare_kernels()"
    subprocess.run([sys.executable, "-c", code], cwd=PROJECT, env=environment, check=True, stdin=subprocess.DEVNULL)
    return folder


def base_command(kernel: parts.Kernel, folder: Path) -> list[str]:
    """QEMU with the kernel and two Kvaser cards (SJA1000) on one wire, its serial line into `folder`."""
    return [
        "qemu-system-x86_64", "-accel", "tcg,thread=multi", "-cpu", "max", "-smp", str(PROCESSORS),
        "-m", str(MEMORY_MB), "-display", "none", "-monitor", "none", "-parallel", "none", "-no-reboot", "-nic", "none",
        "-serial", f"file:{folder / 'serial.txt'}",
        "-kernel", str(kernel.image), "-initrd", str(folder / "initramfs"),
        "-append", "console=ttyS0 quiet panic=-1 no_timer_check mitigations=off audit=0",
        "-object", "can-bus,id=wire",
        "-device", "kvaser_pci,canbus=wire", "-device", "kvaser_pci,canbus=wire",
    ]  # fmt: skip


def share(tag: str, path: Path, *, readonly: bool = False) -> list[str]:
    """A folder of the host in the guest."""
    options = f"local,path={path},mount_tag={tag},security_model=none,multidevs=remap"
    return ["-virtfs", options + (",readonly=on" if readonly else "")]


def start_and_wait(command: list[str], limit: float, asked: Path | None = None, cut: float | None = None) -> bool:
    """Until the machine switches itself off, or the limit (s) is over; or until `cut` s after the file `asked` is there.

    FALSE if the emulator has crashed.
    """
    end = time.monotonic() + limit
    with subprocess.Popen(command, stdin=subprocess.DEVNULL) as process:
        while process.poll() is None:
            if cut is not None and asked is not None and asked.exists():
                time.sleep(cut)
                break
            if time.monotonic() > end:
                break
            time.sleep(0.1)
        crashed = process.poll() is not None and process.returncode < 0
        if process.poll() is None:
            process.send_signal(signal.SIGKILL)
    return not crashed


def result_of(folder: Path) -> GuestRun:
    """What a run has left in its folder."""
    texts = [
        path.read_text(errors="replace") for path in (folder / "serial.txt", folder / "console.txt") if path.exists()
    ]
    code = folder / "code"
    return GuestRun(int(code.read_text()) if code.exists() else -1, "\n".join(texts), folder)
