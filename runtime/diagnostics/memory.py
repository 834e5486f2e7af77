"""Named shared memory that outlives a crash of its user: the owner removes it, nobody else.

Python's own class starts a further process beside each that opens such a memory (its resource tracker), which would also remove
the memory when any of them ends. Here it is what it is on Linux: a file in /dev/shm, mapped.
"""

from __future__ import annotations

import contextlib
import errno
import mmap
import os
from pathlib import Path
from typing import Final

SHARED_MEMORY: Final = Path("/dev/shm")  # shm_overview(7)


class SharedMemory:
    """Shared memory that is open in this process. `buf`: its bytes, `size` of them; views of them stay readable after `close`."""

    def __init__(self, path: Path, descriptor: int) -> None:
        """Raises ValueError if the memory has no size yet."""
        self._path = path
        self.descriptor = descriptor
        self.size = os.fstat(descriptor).st_size
        self.buf = mmap.mmap(descriptor, self.size)

    def close(self) -> None:
        """Let go of the memory; where views of it are still in use, the mapping goes when the last of them does."""
        with contextlib.suppress(BufferError):
            self.buf.close()
        if self.descriptor >= 0:
            os.close(self.descriptor)
            self.descriptor = -1

    def remove(self) -> None:
        """Let go of the memory and take its name away."""
        self.close()
        self._path.unlink(missing_ok=True)


def open_shared(name: str, size: int | None) -> SharedMemory:
    """Open the shared memory `name`; with a `size` in bytes make it anew, zeroed, removing a left-over of the same name.

    All of it is there from the beginning: a page that is missing later would end the process that touches it. Raises
    FileNotFoundError if there is nothing to attach to, OSError if there is no room for it, ValueError if it has no size yet.
    """
    path = SHARED_MEMORY / name
    flags = os.O_RDWR | os.O_NOFOLLOW | os.O_CLOEXEC
    if size is not None:
        path.unlink(missing_ok=True)
        flags |= os.O_CREAT | os.O_EXCL
    descriptor = os.open(path, flags, 0o600)
    try:
        if size is not None:
            _take(descriptor, size, path)
        return SharedMemory(path, descriptor)
    except BaseException:
        os.close(descriptor)
        raise


def _take(descriptor: int, size: int, path: Path) -> None:
    try:
        os.posix_fallocate(descriptor, 0, size)
    except OSError as error:
        path.unlink(missing_ok=True)
        raise OSError(error.errno or errno.ENOSPC, os.strerror(error.errno or errno.ENOSPC), str(path)) from None
