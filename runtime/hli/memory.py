"""The memory of the HLI: made by the CNC, attached to by everybody else, checked before the first access.

The owner holds a lock on the memory file as long as it lives. Thus a second runtime of the same name is refused, the
left-over of a killed one is taken away, and whoever watches can tell that the runtime died without having written so.
"""

from __future__ import annotations

import ctypes as c
import fcntl
import hashlib
import mmap
import os
import re
from functools import cache
from pathlib import Path
from types import TracebackType
from typing import Any, NoReturn

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import ErrorEntry
from runtime.diagnostics.memory import SHARED_MEMORY, SharedMemory, open_shared
from runtime.hli import layout
from runtime.hli.errors import HliError
from runtime.hli.layout import Channel, Head, Hli, Platform

GROUP_READABLE = 0o640  # the group looks on; only the owner's user commands
_NAME = re.compile(r"[A-Za-z0-9_.-]{1,60}\Z")


def describe_layout(kind: Any) -> str:
    """The structure in words: every element with type, offset and size, down to the elementary types."""
    if issubclass(kind, c.Array):
        return f"{describe_layout(kind._type_)}[{kind._length_}]"
    if issubclass(kind, c.Structure):
        elements = []
        for name, of, *_ in kind._fields_:
            element = getattr(kind, name)
            elements.append(f"{name}@{element.offset}+{element.size}:{describe_layout(of)}")
        return f"{kind.__name__}({';'.join(elements)})={c.sizeof(kind)}"
    return f"{kind.__name__}={c.sizeof(kind)}"


@cache
def layout_hash() -> str:
    """SHA-256 over the description of the whole layout, 64 hexadecimal digits."""
    return hashlib.sha256(describe_layout(Hli).encode()).hexdigest()


_READS = 5  # until a text counts as it is


def put_text(structure: c.Structure, element: str, text: str) -> None:
    """Write text into a fixed-size element as UTF-8, cut at a character's border, always with an end mark."""
    size = getattr(type(structure), element).size
    setattr(structure, element, text.encode("utf-8", "replace")[: size - 1].decode("utf-8", "ignore").encode())


def get_text(structure: c.Structure, element: str) -> str:
    """Read a text element. No flag guards those of the status: one that changes meanwhile is read again."""
    text: bytes = getattr(structure, element)
    for _ in range(_READS):
        again: bytes = getattr(structure, element)
        if again == text:
            break
        text = again
    return text.decode("utf-8", "replace")


class HliMemory:
    """The HLI and the memory it lies in; `hli` is the tree of `runtime.hli.layout`.

    Made by one of `create` (the CNC), `attach` (everybody else) and `private` (simulation and tests: one process only).
    """

    def __init__(
        self,
        hli: Hli,
        name: str | None = None,
        memory: SharedMemory | None = None,
        *,
        owner: bool = False,
    ) -> None:
        self.hli = hli
        self.name = name
        self._memory = memory
        self._owner = owner

    @classmethod
    def private(cls) -> HliMemory:
        """An HLI in this process only."""
        hli = Hli()
        _initialise(hli)
        return cls(hli)

    @classmethod
    def create(cls, name: str, *, permissions: int = GROUP_READABLE) -> HliMemory:
        """Make the shared memory `name`, zeroed but for its head and the operator's defaults.

        Raises HliError if a runtime of this name is alive, or the name or the rights do not allow it.
        """
        _check_name(name)
        refuse_living_owner(name)
        try:
            memory = open_shared(name, c.sizeof(Hli))
        except PermissionError:
            raise HliError(catalogue.HLI_NO_ACCESS, name=name) from None
        os.fchmod(memory.descriptor, permissions)
        fcntl.flock(memory.descriptor, fcntl.LOCK_EX)
        hli = _tree(memory)
        _initialise(hli)
        return cls(hli, name, memory, owner=True)

    @classmethod
    def attach(cls, name: str, *, read_only: bool = False) -> HliMemory:
        """Attach to the HLI `name` of another process after the start-up check (hli.mech.init-check).

        `read_only` needs only the right to read; what is written then stays in this process. Raises HliError, without
        any access beyond the head, if there is no such memory or it was built from another layout.
        """
        _check_name(name)
        memory: SharedMemory | None = None
        try:
            if read_only:
                hli = _view(SHARED_MEMORY / name)
            else:
                memory = open_shared(name, None)
                if memory.size < c.sizeof(Hli):
                    memory.close()
                    _refuse_size(name)
                hli = _tree(memory)
        except FileNotFoundError:
            raise HliError(catalogue.HLI_NOT_RUNNING, name=name) from None
        except PermissionError:
            raise HliError(catalogue.HLI_NO_ACCESS, name=name) from None
        except ValueError:  # it has no size yet
            raise HliError(catalogue.HLI_NO_SHAPE, name=name) from None
        attached = cls(hli, name, memory)
        try:
            _check_head(name, hli.head)
        except HliError:
            del hli
            attached.close()
            raise
        return attached

    @property
    def owner_alive(self) -> bool:
        """Whether the process that made the memory still lives; TRUE for a private one."""
        if self.name is None or self._owner:
            return True
        return _locked(SHARED_MEMORY / self.name)

    def close(self, *, keep: bool = False) -> None:
        """Let go of the memory; its owner also removes it, unless it is to `keep` it for whoever looks for the cause.

        Structures taken from `hli` before stay readable.
        """
        memory, self._memory = self._memory, None
        if self._owner:
            self.hli.head.running_r = False
        self.hli = Hli()  # whoever writes through a closed memory hurts nobody
        if memory is None:
            return
        if self._owner and not keep:
            memory.remove()
        else:
            memory.close()

    def __enter__(self) -> HliMemory:
        return self

    def __exit__(
        self, kind: type[BaseException] | None, error: BaseException | None, trace: TracebackType | None
    ) -> None:
        self.close()


def _initialise(hli: Hli) -> None:
    """Head and operator's defaults; the magic number last: who sees it, sees the rest."""
    head = hli.head
    head.layout_hash_r = layout_hash().encode()
    head.version_r = layout.VERSION.encode()
    for element, value in _expected_shape().items():
        setattr(head, element, value)
    head.owner_pid_r = os.getpid()
    for operator in hli.operator:
        operator.override_w = 1000
    for channel in hli.channels:
        channel.control.mode_and_state.mode_r = layout.Mode.STANDBY
        channel.control.mode_and_state.state_r = layout.State.SELECTED
    head.magic_r = layout.MAGIC


def _expected_shape() -> dict[str, int]:
    return {
        "channel_capacity_r": layout.MAX_CHANNELS,
        "axis_capacity_r": layout.MAX_AXES,
        "platform_size_r": c.sizeof(Platform),
        "channel_size_r": c.sizeof(Channel),
        "axis_size_r": c.sizeof(layout.Axis),
        "size_r": c.sizeof(Hli),
    }


_SHAPE_ERRORS: dict[str, tuple[ErrorEntry, str]] = {
    "channel_capacity_r": (catalogue.HLI_CAPACITY, "channel"),
    "axis_capacity_r": (catalogue.HLI_CAPACITY, "axis"),
    "platform_size_r": (catalogue.HLI_PLATFORM_SIZE, "platform"),
    "channel_size_r": (catalogue.HLI_CHANNEL_SIZE, "channel"),
    "axis_size_r": (catalogue.HLI_AXIS_SIZE, "axis"),
}


def _check_head(name: str, head: Head) -> None:
    """Compare the shapes of both sides, the coarse differences first: their errors say more than a hash."""
    if head.magic_r != layout.MAGIC:
        raise HliError(catalogue.HLI_NO_SHAPE, name=name)
    version = get_text(head, "version_r")
    if version != layout.VERSION:
        raise HliError(catalogue.HLI_VERSION, name=name, found=version, expected=layout.VERSION)
    expected = _expected_shape()
    for element, (entry, area) in _SHAPE_ERRORS.items():
        found = getattr(head, element)
        if found != expected[element]:
            raise HliError(entry, name=name, found=found, expected=expected[element], area=area)
    found_hash = get_text(head, "layout_hash_r")
    if found_hash != layout_hash():
        raise HliError(catalogue.HLI_LAYOUT, name=name, found=found_hash[:12], expected=layout_hash()[:12])


def _refuse_size(name: str) -> NoReturn:
    """The memory is smaller than the HLI: what its head says, if it has one, tells why."""
    with open(SHARED_MEMORY / name, "rb") as file:
        start = file.read(c.sizeof(Head))
    if len(start) == c.sizeof(Head):
        _check_head(name, Head.from_buffer_copy(start))
    raise HliError(catalogue.HLI_NO_SHAPE, name=name)


def _tree(memory: SharedMemory) -> Hli:
    return Hli.from_buffer(memory.buf)


def _view(path: Path) -> Hli:
    """The HLI mapped copy-on-write: it follows the machine, needs no right to write, and cannot disturb."""
    descriptor = os.open(path, os.O_RDONLY)
    try:
        if os.fstat(descriptor).st_size < c.sizeof(Hli):
            _refuse_size(path.name)
        return Hli.from_buffer(mmap.mmap(descriptor, c.sizeof(Hli), access=mmap.ACCESS_COPY))
    finally:
        os.close(descriptor)


def _check_name(name: str) -> None:
    if not _NAME.match(name):
        raise HliError(catalogue.HLI_NAME, name=name)


def _locked(path: Path) -> bool:
    """Whether somebody holds the owner's lock."""
    try:
        descriptor = os.open(path, os.O_RDONLY)
    except OSError:
        return False
    try:
        fcntl.flock(descriptor, fcntl.LOCK_SH | fcntl.LOCK_NB)
    except BlockingIOError:
        return True
    finally:
        os.close(descriptor)
    return False


def refuse_living_owner(name: str) -> None:
    """Raises HliError if a runtime of this name is alive."""
    path = SHARED_MEMORY / name
    if not _locked(path):
        return
    with open(path, "rb") as file:
        start = file.read(c.sizeof(Head))
    pid = Head.from_buffer_copy(start).owner_pid_r if len(start) == c.sizeof(Head) else "unknown"
    raise HliError(catalogue.HLI_ALREADY_RUNS, name=name, pid=pid)
