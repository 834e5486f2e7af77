"""A Debian system with the package in /opt/tandem, as a disk: what the full form boots. Made once per state of the sources.

    debootstrap ─▶ bookworm/          the distribution, made once
                      │ copy, /opt/tandem with the wheel and what it depends on, the kernels compiled, the unit of the test
                      ▼
                   system-FINGERPRINT.ext4

Making it needs the rights to make devices and to change the root (root in a container has them), but no mount and no network
beyond the package archive.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Iterator
from importlib import metadata
from pathlib import Path
from typing import Final

from packaging.requirements import Requirement

from tests.vm.parts import UnavailableError, cache_folder, run

PROJECT: Final = Path(__file__).parents[2]
SUITE: Final = "bookworm"
PYTHON: Final = (3, 11)  # of this suite
PACKAGES: Final = "systemd,systemd-sysv,udev,dbus,iproute2,python3,kmod,e2fsprogs"
TOOLS: Final = (("debootstrap", "debootstrap"), ("mkfs.ext4", "e2fsprogs"), ("chroot", "coreutils"))
SIZE: Final = "2500M"  # sparse
KERNELS: Final = "/var/cache/tandem/numba"  # as the unit says
COMPILE_LIMIT: Final = 900.0  # s
PACKAGE: Final = ("pyproject.toml", "README.md", "LICENSE", "runtime")  # what the wheel is built from
DEPENDENCIES_OF: Final = "tandem-cnc"

_UNIT: Final = """[Unit]
Description=What the test does in this machine
# beside the service, which waits at boot for the drives that the test brings
Requires=dbus.socket
After=basic.target dbus.socket
SuccessAction=poweroff
FailureAction=poweroff-force

[Service]
Type=oneshot
WorkingDirectory=/run/tests
EnvironmentFile=/run/out/environment
ExecStart=/opt/tandem/bin/python -u -m tests.vm.guest.full /run/out
StandardOutput=append:/run/out/console.txt
StandardError=inherit
TimeoutStartSec=infinity

[Install]
WantedBy=multi-user.target
"""


def system_image(environment: dict[str, str]) -> Path:
    """The disk; `environment`: what kernels are compiled with. Raises UnavailableError."""
    if sys.version_info[:2] != PYTHON:
        here, there = (".".join(map(str, version)) for version in (sys.version_info[:2], PYTHON))
        raise UnavailableError(f"this environment has Python {here}, the guest's Debian {there}")
    disk = cache_folder() / f"system-{_fingerprint(environment)}.ext4"
    if disk.exists():
        return disk
    distribution = _distribution()
    for old in cache_folder().glob("system-*"):  # a disk takes a gigabyte
        shutil.rmtree(old) if old.is_dir() else old.unlink()
    folder = disk.with_suffix(".tmp")
    run(["cp", "-a", str(distribution), str(folder)], cache_folder(), "the system cannot be copied")
    _install(folder)
    _compile(folder, environment)
    _settle(folder)
    made = disk.with_suffix(".new")
    command = ["mkfs.ext4", "-q", "-F", "-L", "root", "-d", str(folder), str(made), SIZE]
    run(command, cache_folder(), "the disk cannot be made")
    shutil.rmtree(folder)
    return made.rename(disk)


def _fingerprint(environment: dict[str, str]) -> str:
    digest = hashlib.sha256(repr((sorted(environment.items()), sys.version_info)).encode())
    named = [PROJECT / name for name in (*PACKAGE, "requirements.lock")]
    files = [Path(__file__), *(path for path in named if path.is_file())]
    files += [path for path in (PROJECT / "runtime").rglob("*") if path.is_file() and "__pycache__" not in path.parts]
    for path in sorted(files):
        digest.update(str(path.relative_to(PROJECT)).encode() + b"\0" + path.read_bytes())
    return digest.hexdigest()[:16]


def _distribution() -> Path:
    """The unpacked distribution."""
    folder = cache_folder() / SUITE
    if (folder / "complete").exists():
        return folder
    if os.geteuid() != 0:
        raise UnavailableError("debootstrap needs root (in a container without privileges is enough)")
    shutil.rmtree(folder, ignore_errors=True)
    command = ["debootstrap", "--variant=minbase", f"--include={PACKAGES}", SUITE, str(folder)]
    run(command, cache_folder(), "debootstrap cannot make a Debian system", limit=900.0)
    shutil.rmtree(folder / "var/cache/apt/archives", ignore_errors=True)
    (folder / "complete").touch()
    return folder


def _install(root: Path) -> None:
    """/opt/tandem as `python3 -m venv` and `pip install` leave it, with what is installed here: no network in the guest."""
    library = root / "opt/tandem/lib" / f"python{PYTHON[0]}.{PYTHON[1]}" / "site-packages"
    commands = root / "opt/tandem/bin"
    library.mkdir(parents=True)
    commands.mkdir()
    (commands / "python").symlink_to("/usr/bin/python3")
    (root / "opt/tandem/pyvenv.cfg").write_text("home = /usr/bin\ninclude-system-site-packages = false\n")
    for distribution in _dependencies(DEPENDENCIES_OF):
        for file in distribution.files or ():
            source = Path(str(distribution.locate_file(file)))
            if ".." in file.parts or "__pycache__" in file.parts or not source.is_file():
                continue
            target = library / file
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copyfile(source, target)
    with tempfile.TemporaryDirectory(prefix="tandem-wheel-") as name:
        sources = Path(name) / "sources"
        sources.mkdir()
        for part in PACKAGE:
            copy = shutil.copytree if (PROJECT / part).is_dir() else shutil.copyfile
            copy(PROJECT / part, sources / part)
        pip = [sys.executable, "-m", "pip", "--disable-pip-version-check", "install", "--no-deps", "--no-compile"]
        run([*pip, "--target", str(library), str(sources)], sources, "the package cannot be built", limit=600.0)
    script = (library / "bin/tandem").read_text().splitlines(keepends=True)
    (commands / "tandem").write_text("#!/opt/tandem/bin/python\n" + "".join(script[1:]))
    (commands / "tandem").chmod(0o755)
    shutil.rmtree(library / "bin")


def _dependencies(name: str) -> Iterator[metadata.Distribution]:
    """Everything that the package needs to run, without what its tests need."""
    seen: set[tuple[str, str]] = set()
    todo = [Requirement(text) for text in metadata.requires(name) or []]
    told: set[str] = set()
    todo = [requirement for requirement in todo if _holds(requirement, "")]
    while todo:
        requirement = todo.pop()
        distribution = metadata.distribution(requirement.name)
        if requirement.name not in told:
            told.add(requirement.name)
            yield distribution
        for extra in ("", *requirement.extras):
            if (requirement.name, extra) not in seen:
                seen.add((requirement.name, extra))
                further = map(Requirement, distribution.requires or [])
                todo += [needed for needed in further if _holds(needed, extra)]


def _holds(requirement: Requirement, extra: str) -> bool:
    return requirement.marker is None or requirement.marker.evaluate({"extra": extra})


def _compile(root: Path, environment: dict[str, str]) -> None:
    """Modules, as pip compiles them, and kernels, where the unit has them: an emulator would need a quarter of an hour."""
    for path in (root / "opt/tandem").rglob("*"):  # a disk made by mkfs keeps whole seconds, the cache compares
        os.utime(path, (1_700_000_000, 1_700_000_000), follow_symlinks=False)
    compile_all = [
        "chroot",
        str(root),
        "/opt/tandem/bin/python",
        "-m",
        "compileall",
        "-q",
        "-j",
        "2",
        "/opt/tandem/lib",
    ]
    # some packages carry files of other versions of Python
    subprocess.run(compile_all, check=False, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
    variables = [f"{key}={value}" for key, value in environment.items()]
    code = "from runtime.cli.preparing import prepare_kernels; prepare_kernels()"
    command = ["chroot", str(root), "/usr/bin/env", f"NUMBA_CACHE_DIR={KERNELS}", "HOME=/tmp", *variables]
    command += ["PYTHONDONTWRITEBYTECODE=1", "/opt/tandem/bin/python", "-c", code]
    run(command, root, "the kernels cannot be compiled", limit=COMPILE_LIMIT)


def _settle(root: Path) -> None:
    """What else a machine has."""
    (root / "etc/hostname").write_text("mill\n")
    (root / "etc/machine-id").write_text("0123456789abcdef0123456789abcdef\n")  # no first boot
    (root / "etc/fstab").write_text("/dev/vda / ext4 defaults 0 1\n")
    (root / "var/log/journal").mkdir(exist_ok=True)  # a journal that outlives the machine
    units = root / "etc/systemd/system"
    (units / "tandem-test.service").write_text(_UNIT)
    wanted = units / "multi-user.target.wants"
    wanted.mkdir(exist_ok=True)
    (wanted / "tandem-test.service").symlink_to("../tandem-test.service")
    for unit in ("getty.target", "systemd-resolved.service", "systemd-timesyncd.service", "apt-daily.timer"):
        (units / unit).symlink_to("/dev/null")


def copy_of(disk: Path, target: Path) -> Path:
    """A copy for one run, its holes kept."""
    subprocess.run(["cp", "--sparse=always", "--reflink=auto", str(disk), str(target)], check=True)
    return target
