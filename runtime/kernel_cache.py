"""Where the machine code of the kernels is kept between two starts.

Numba looks at the file of a kernel to see whether its machine code is still good, but a kernel also contains the kernels that
it calls, from other files. So the folder carries a fingerprint of all kernels: a change anywhere makes a new folder, and
nothing old is ever run. The folder lies in the first place that can be written:

    $NUMBA_CACHE_DIR ─ beside the program ─ $XDG_CACHE_HOME/tandem or ~/.cache/tandem ─ a temporary one of this run
"""

from __future__ import annotations

import atexit
import contextlib
import fcntl
import hashlib
import os
import re
import shutil
import tempfile
from collections.abc import Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

PACKAGE = Path(__file__).parent
VARIABLE = "NUMBA_CACHE_DIR"
_MARK = b"\n@kernel"
_IMPORT = re.compile(rb"^from (runtime[\w.]*) import (\([^)]*\)|.*)", re.MULTILINE)
_CONSTANT = re.compile(rb"\b[A-Z][A-Z0-9_]+\b")
_KEPT = 4  # folders of earlier versions, for going back and forth between them


@dataclass(frozen=True, slots=True)
class KernelCache:
    """The folder, and the places that refused one before it was made; a temporary one does not outlive this run."""

    folder: Path
    refused: tuple[Path, ...] = ()
    lasting: bool = True

    @property
    def _complete(self) -> Path:
        return self.folder / "complete"

    @property
    def warm(self) -> bool:
        """Every kernel has been compiled into it: a start only loads."""
        return self._complete.exists()

    @contextlib.contextmanager
    def filling(self, *, everything: bool) -> Iterator[None]:
        """Around a warm-up: one process compiles, the others then load. With `everything` the folder is complete behind it."""
        lock = None
        if not self.warm:
            with contextlib.suppress(OSError):  # not writable any more: this process compiles for itself
                lock = (self.folder / "lock").open("w")
                fcntl.flock(lock, fcntl.LOCK_EX)
        try:
            yield
        finally:
            if lock is not None:
                lock.close()
        if lock is not None and everything:
            with contextlib.suppress(OSError):
                self._complete.touch()
            self._forget_old()

    def _forget_old(self) -> None:
        """Remove what versions long gone have left."""
        with contextlib.suppress(OSError):
            others = [path for path in self.folder.parent.glob("kernels-*") if path != self.folder]
            others.sort(key=lambda path: path.stat().st_mtime, reverse=True)
            for path in others[_KEPT:]:
                shutil.rmtree(path, ignore_errors=True)


def places(environment: Mapping[str, str], package: Path = PACKAGE) -> list[Path]:
    """Where the folder may be, best first."""
    given = environment.get(VARIABLE)
    cache = environment.get("XDG_CACHE_HOME") or (environment.get("HOME", "") and environment["HOME"] + "/.cache")
    found = [Path(given)] if given else []
    found.append(package / "__pycache__")
    return [*found, Path(cache) / "tandem"] if cache else found


def find_cache(environment: Mapping[str, str], package: Path = PACKAGE) -> KernelCache:
    """The first place that can be written, else a temporary folder, which processes started by this one share."""
    name = f"kernels-{fingerprint(package)}"
    tried = tuple(places(environment, package))
    for i, place in enumerate(tried):
        try:
            (place / name).mkdir(parents=True, exist_ok=True)
        except OSError:
            continue
        if os.access(place / name, os.W_OK):
            return KernelCache(place / name, tried[:i])
    temporary = Path(tempfile.mkdtemp(prefix="tandem-"))  # readable by this user only: what lies in it is executed
    atexit.register(shutil.rmtree, temporary, ignore_errors=True)
    os.environ[VARIABLE] = str(temporary)
    return KernelCache(temporary / name, tried, lasting=False)


def fingerprint(package: Path = PACKAGE) -> str:
    """Sixteen digits that change with any file that has kernels, or constants that are compiled into them."""
    digest = hashlib.sha256()
    for path, source in sorted(_sources(package).items()):
        digest.update(str(path.relative_to(package)).encode() + b"\0" + source + b"\0")
    return digest.hexdigest()[:16]


def _sources(package: Path) -> dict[Path, bytes]:
    """The files with kernels, and those that they have constants (names in capitals) from."""
    found = {path: source for path in package.rglob("*.py") if _MARK in (source := path.read_bytes())}
    new = list(found.values())
    while new:
        for module, names in _IMPORT.findall(new.pop()):
            stem = package.joinpath(*module.decode().split(".")[1:])
            path = stem / "__init__.py" if stem.is_dir() else stem.with_suffix(".py")
            if path not in found and path.exists() and _CONSTANT.search(names):
                found[path] = path.read_bytes()
                new.append(found[path])
    return found


CACHE = find_cache(os.environ)
