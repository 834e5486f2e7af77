"""What a virtual machine is made of: QEMU of the host, Debian's PREEMPT_RT kernel, busybox. Nothing is installed.

Everything fetched is kept in out/vm, or where TANDEM_VM_CACHE says.
"""

from __future__ import annotations

import os
import shutil
import subprocess
from dataclasses import dataclass
from pathlib import Path
from typing import Final

KERNEL_PACKAGE: Final = "linux-image-rt-amd64"
TOOLS: Final = {
    # program: Debian package
    "qemu-system-x86_64": "qemu-system-x86",
    "busybox": "busybox-static",
    "apt-get": "apt",
    "dpkg-deb": "dpkg",
}
FETCH_LIMIT: Final = 300.0  # s


class UnavailableError(Exception):
    """A part cannot be had on this host; the text is the reason."""


@dataclass(frozen=True, slots=True)
class Kernel:
    """An unpacked kernel package."""

    image: Path
    modules: Path  # folder `kernel` below lib/modules/VERSION
    version: str


def cache_folder() -> Path:
    folder = Path(os.environ.get("TANDEM_VM_CACHE") or Path(__file__).parents[2] / "out/vm").absolute()
    folder.mkdir(parents=True, exist_ok=True)
    return folder


def require_tools(*more: tuple[str, str]) -> None:
    """Raises UnavailableError for a program that is not installed; `more`: further (program, package)."""
    missing = [package for program, package in (*TOOLS.items(), *more) if not shutil.which(program, path=search_path())]
    if missing:
        raise UnavailableError(f"not installed: {', '.join(missing)} (apt install {' '.join(missing)})")


def search_path() -> str:
    """PATH of an administrator: debootstrap and others lie in sbin."""
    return os.environ.get("PATH", "/usr/bin:/bin") + ":/usr/sbin:/sbin"


def busybox() -> Path:
    """A busybox that needs no libraries. Raises UnavailableError."""
    found = shutil.which("busybox")
    assert found is not None  # require_tools was asked
    kind = subprocess.run(["ldd", found], capture_output=True, text=True, check=False)
    if kind.returncode == 0 and "=>" in kind.stdout:
        raise UnavailableError("busybox is not static (apt install busybox-static)")
    return Path(found)


def kernel() -> Kernel:
    """Debian's real-time kernel, fetched once. Raises UnavailableError."""
    package = _kernel_package()
    folder = cache_folder() / package
    if not (folder / "complete").exists():
        shutil.rmtree(folder, ignore_errors=True)
        folder.mkdir(parents=True)
        run(["apt-get", "download", "-q", package], folder, f"the kernel package {package} cannot be downloaded")
        (archive,) = folder.glob("*.deb")
        run(["dpkg-deb", "-x", archive.name, "."], folder, f"{archive.name} cannot be unpacked")
        archive.unlink()
        (folder / "complete").touch()
    (image,) = folder.glob("boot/vmlinuz-*")
    version = image.name.removeprefix("vmlinuz-")
    return Kernel(image, folder / "lib/modules" / version / "kernel", version)


def _kernel_package() -> str:
    """The package that the meta-package stands for now; one that was fetched before if apt knows none."""
    answer = subprocess.run(
        ["apt-cache", "depends", KERNEL_PACKAGE], capture_output=True, text=True, check=False, env=_plain_language()
    )
    for line in answer.stdout.splitlines():
        word = line.strip().removeprefix("Depends:").strip()
        if word.startswith("linux-image-") and word != KERNEL_PACKAGE:
            return word
    if fetched := sorted(path.parent.name for path in cache_folder().glob("linux-image-*/complete")):
        return fetched[-1]
    raise UnavailableError(f"apt knows no package {KERNEL_PACKAGE} (apt-get update, Debian 12)")


def _plain_language() -> dict[str, str]:
    return {**os.environ, "LC_ALL": "C", "PATH": search_path()}


def run(command: list[str], folder: Path, failure: str, limit: float = FETCH_LIMIT) -> None:
    """Run a command in a folder for at most `limit` s; UnavailableError with the `failure` and the reason otherwise."""
    try:
        done = subprocess.run(
            command, cwd=folder, capture_output=True, text=True, check=False, timeout=limit, env=_plain_language()
        )
    except (OSError, subprocess.TimeoutExpired) as error:
        raise UnavailableError(f"{failure}: {error}") from error
    if done.returncode:
        raise UnavailableError(f"{failure}: {(done.stderr or done.stdout).strip()[-300:]}")
