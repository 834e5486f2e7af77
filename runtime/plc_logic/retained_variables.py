"""Retained variables: they survive a killed process and a power loss at any instant.

    class Mill(Program):
        parts = retain(0)
        tools = retain({"in_spindle": 0, "magazine": [0] * 8})

What a PLC cycle has changed goes into one record, which is appended to a journal before the outputs of that cycle are
written and its functions are acknowledged. A record has a checksum: it counts as a whole or not at all.

    plc-retain.7   ┌───────────────────┬────────┬────────┬────┐
                   │ all variables     │ change │ change │ ch…  ← torn by the power loss: not counted
                   └───────────────────┴────────┴────────┴────┘
    plc-retain.6   the journal before, kept until the next one is on the disk, and one longer

The kernel has a record when `commit` returns: killing the process loses nothing. It is on the disk after the next flush, which
a thread of its own does all the time; `saved` tells when (a program may wait for it before it acknowledges).
"""

from __future__ import annotations

import json
import os
import re
import threading
import time
import zlib
from collections.abc import Iterator, Mapping
from contextlib import suppress
from copy import deepcopy
from pathlib import Path
from typing import Any, Generic, TypeVar, overload

from runtime.diagnostics.catalogue import plc as catalogue
from runtime.diagnostics.errors import Place, Problem
from runtime.plc_logic.errors import PlcError

T = TypeVar("T")
Values = dict[str, Any]  # name -> what JSON can hold

SCHEMA = 1
PREFIX = "plc-retain."
GREATEST_JOURNAL = 1_000_000  # bytes; then a new one begins
_FLUSH_EVERY = 0.05  # s; disks wear out
_ATTEMPT_EVERY = 250  # commits between two attempts on a disk that takes nothing
_LINE = re.compile(rb"([0-9a-f]{8}) (.*)", re.DOTALL)


class retain(Generic[T]):  # noqa: N801 - reads as a declaration
    """Declares a retained variable of a program: `parts = retain(0)`, then `self.parts += 1`.

    Its value is of the kind of its initial value: BOOL, number, text, or lists and dictionaries of such. PlcError otherwise.
    """

    def __init__(self, initial: T) -> None:
        self.initial = initial
        self.name = ""

    def __set_name__(self, owner: type, name: str) -> None:
        self.name = name

    @overload
    def __get__(self, program: None, owner: type) -> retain[T]: ...

    @overload
    def __get__(self, program: object, owner: type) -> T: ...

    def __get__(self, program: Any, owner: type) -> retain[T] | T:
        if program is None:
            return self
        value: T = program._retained[self.name]
        return value

    def __set__(self, program: Any, value: T) -> None:
        if not self.fits(value):
            raise PlcError(catalogue.PLC_RETAIN_VALUE, name=self.name, value=value, kind=type(self.initial).__name__)
        program._retained[self.name] = value

    def fits(self, value: object) -> bool:
        """Whether a value may stand here: of the same kind as the initial one, and writable."""
        kind = type(self.initial)
        same = isinstance(value, kind) and isinstance(value, bool) is (kind is bool)
        return (same or (kind is float and type(value) is int)) and _writable(value)


def _writable(value: object) -> bool:
    """Whether JSON brings back the same value."""
    if value is None or isinstance(value, bool | int | float | str):
        return True
    if isinstance(value, list):
        return all(map(_writable, value))
    return isinstance(value, dict) and all(isinstance(key, str) and _writable(item) for key, item in value.items())


def declared(program: type) -> dict[str, retain[Any]]:
    """The retained variables of a program class, those of its bases included."""
    return {name: member for base in program.__mro__[::-1] for name, member in vars(base).items() if _is(member)}


def _is(member: object) -> bool:
    return isinstance(member, retain)


def starting_values(program: type, kept: Mapping[str, Any]) -> tuple[Values, list[Problem]]:
    """What the variables of a program begin with: what was kept, else the initial value; warnings for what no longer fits."""
    values: Values = {}
    problems = []
    for name, variable in declared(program).items():
        if name in kept and variable.fits(kept[name]):
            values[name] = deepcopy(kept[name])
            continue
        values[name] = deepcopy(variable.initial)
        if name in kept:
            told = {"name": name, "value": kept[name], "kind": type(variable.initial).__name__}
            problems.append(Problem(catalogue.PLC_RETAIN_KIND, told))
    return values, problems


class RetainJournal:
    """The journal in one directory. One process writes; it may be killed at any moment."""

    def __init__(self, directory: Path) -> None:
        """Reads what is there and begins a new journal. Raises PlcError if the directory takes nothing."""
        self._directory = directory
        self._descriptor = -1
        self._size = 0
        self._pause = 0  # commits to let pass after a failed one
        self.problems: list[Problem] = []  # to be told, taken by the host
        self._number, self._kept, torn = read_journal(directory)
        if torn:
            self.problems.append(Problem(catalogue.PLC_RETAIN_TORN, {"file": torn}, Place(str(torn))))
        self._committed = self._flushed = 0
        self._wanted = threading.Event()
        self._closing = False
        self._lock = threading.Lock()  # around the exchange of the descriptor only
        try:
            directory.mkdir(parents=True, exist_ok=True)
            self._begin()
            os.fdatasync(self._descriptor)
            _sync_directory(directory)
            self._forget(self._number - 1)
        except OSError as error:
            raise PlcError(catalogue.PLC_RETAIN_NOT_WRITTEN, file=directory, reason=error.strerror) from error
        self._flusher = threading.Thread(target=self._flush, name="retain", daemon=True)
        self._flusher.start()

    @property
    def kept(self) -> Mapping[str, Any]:
        """What stands in the journal."""
        return self._kept

    @property
    def saved(self) -> bool:
        """Everything that was committed is on the disk."""
        return self._flushed >= self._committed

    def commit(self, values: Mapping[str, Any]) -> None:
        """Append what differs from what is kept; one record, or nothing. Never raises: problems are told by the host."""
        kept = self._kept
        changed = {name: value for name, value in values.items() if name not in kept or kept[name] != value}
        if not changed:
            return
        if self._pause:
            self._pause -= 1
            return
        if any(isinstance(value, list | dict) for value in changed.values()):
            changed = deepcopy(changed)
        kept.update(changed)
        try:
            if self._size > GREATEST_JOURNAL or self._descriptor < 0:
                self._begin()
            else:
                self._append({"set": changed})
        except OSError as error:
            for name in changed:
                kept.pop(name)  # differs at the next commit again
            self._pause = _ATTEMPT_EVERY
            self._abandon()
            values_told = {"file": self._directory, "reason": error.strerror or str(error)}
            self.problems.append(Problem(catalogue.PLC_RETAIN_NOT_WRITTEN, values_told))
            return
        self._committed += 1
        self._wanted.set()

    def close(self) -> None:
        """Bring everything to the disk."""
        self._closing = True
        self._wanted.set()
        self._flusher.join(10.0)
        self._abandon()

    # ------------------------------------------------------------------ writing

    def _begin(self) -> None:
        """A new journal whose first record has everything; the one before stays until this one is on the disk."""
        self._number += 1
        file = self._directory / f"{PREFIX}{self._number}"
        descriptor = os.open(file, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_APPEND | os.O_CLOEXEC, 0o640)
        with self._lock:
            before, self._descriptor = self._descriptor, descriptor
            if before >= 0:
                os.close(before)
        self._size = 0
        self._append({"schema": SCHEMA, "all": self._kept})

    def _append(self, record: Mapping[str, Any]) -> None:
        body = json.dumps(record, separators=(",", ":"), ensure_ascii=True).encode()
        line = b"%08x %s\n" % (zlib.crc32(body), body)
        written = os.write(self._descriptor, line)
        if written != len(line):
            raise OSError(28, "the disk is full")
        self._size += written

    def _forget(self, before: int) -> None:
        """Journals that are older than the last two; the newest is on the disk."""
        for number in list(_journals(self._directory)):
            if number < before:
                with suppress(OSError):
                    (self._directory / f"{PREFIX}{number}").unlink()

    def _abandon(self) -> None:
        """A journal that may be torn is not continued: the next commit begins a new one."""
        with self._lock:
            if self._descriptor >= 0:
                os.close(self._descriptor)
            self._descriptor = -1

    # ------------------------------------------------------------------ flushing, in a thread of its own

    def _flush(self) -> None:
        last = False
        while not last:
            self._wanted.wait()
            self._wanted.clear()
            last = self._closing
            committed, number = self._committed, self._number
            with self._lock:
                descriptor = os.dup(self._descriptor) if self._descriptor >= 0 else -1
            if descriptor < 0:
                continue
            try:
                os.fdatasync(descriptor)
                _sync_directory(self._directory)
                self._flushed = committed
                self._forget(number - 1)
            except OSError:
                pass  # the next flush tries again; `saved` stays FALSE
            finally:
                os.close(descriptor)
            time.sleep(0.0 if last else _FLUSH_EVERY)


def read_journal(directory: Path) -> tuple[int, Values, Path | None]:
    """Number of the newest journal (0: none), what it keeps, and the file of whose end something was lost."""
    numbers = sorted(_journals(directory), reverse=True)
    torn: Path | None = None
    for number in numbers:
        file = directory / f"{PREFIX}{number}"
        records = list(_records(file))
        if records and records[0] is not None and records[0].get("schema") == SCHEMA:
            values: Values = dict(records[0]["all"])
            for record in records[1:]:
                if record is None:
                    torn = torn or file
                    break
                values.update(record["set"])
            return numbers[0], values, torn
        torn = torn or file
    return (numbers[0] if numbers else 0), {}, torn


def _records(file: Path) -> Iterator[Values | None]:
    """The whole records from the beginning; None where the first damaged one stands."""
    try:
        lines = file.read_bytes().split(b"\n")
    except OSError:
        return
    for line in lines[:-1]:
        match = _LINE.fullmatch(line)
        if match is None or int(match[1], 16) != zlib.crc32(match[2]):
            yield None
            return
        record: Values = json.loads(match[2])
        yield record
    if lines[-1]:
        yield None


def _journals(directory: Path) -> Iterator[int]:
    with suppress(OSError):
        for entry in os.scandir(directory):
            number = entry.name.removeprefix(PREFIX)
            if entry.name.startswith(PREFIX) and number.isdecimal():
                yield int(number)


def _sync_directory(directory: Path) -> None:
    """Bring the names to the disk as well."""
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
