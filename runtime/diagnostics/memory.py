"""Named shared memory that outlives a crash of its user and belongs to nobody's resource tracker."""

from __future__ import annotations

import contextlib
import os
from multiprocessing import resource_tracker, shared_memory


def open_shared(name: str, size: int | None) -> shared_memory.SharedMemory:
    """Open the shared memory `name`; with a `size` make it anew, zeroed, removing a left-over of the same name.

    Python's resource tracker would remove the memory when any process that attached to it ends (until 3.13), so it is told to
    forget it: the owner removes it. Raises FileNotFoundError if there is nothing to attach to.
    """
    if size is None:
        memory = shared_memory.SharedMemory(name)
    else:
        with contextlib.suppress(FileNotFoundError):
            old = shared_memory.SharedMemory(name)
            old.close()
            old.unlink()
        memory = shared_memory.SharedMemory(name, create=True, size=size)
    with contextlib.suppress(Exception):
        resource_tracker.unregister(memory._name, "shared_memory")  # type: ignore[attr-defined]
    return memory


def release_shared(memory: shared_memory.SharedMemory) -> None:
    """Close shared memory; where views of it are still in use, the mapping goes when the last of them does.

    `close()` alone refuses then, and complains again when the object is deleted.
    """
    try:
        memory.close()
    except BufferError:
        os.close(memory._fd)  # type: ignore[attr-defined]
        memory._fd = -1  # type: ignore[attr-defined]
        memory._buf = None  # type: ignore[attr-defined]
        memory._mmap = None  # type: ignore[attr-defined]


def remove_shared(memory: shared_memory.SharedMemory) -> None:
    """Close and remove shared memory that `open_shared` made."""
    release_shared(memory)
    name = memory._name  # type: ignore[attr-defined]
    resource_tracker.register(name, "shared_memory")  # unlink forgets it again
    try:
        memory.unlink()
    except FileNotFoundError:
        resource_tracker.unregister(name, "shared_memory")
