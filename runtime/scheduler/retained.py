"""What survives a restart: axis positions, zero offsets, where a program was interrupted, the alarm history.

A file is replaced, never changed: the new text goes into a file of its own, which is brought to the disk and then takes
the name of the old one in one step. The old one is kept under a second name. Whatever moment the power goes, one of the
two is whole; a checksum tells a whole one from a damaged one.

    retained.json.new ──fsync──▶ rename ▶ retained.json ◀── read first
                                             │ hard link, made before the rename
                                             ▼
                                  retained.json.previous ◀── read if the first one is damaged
"""

from __future__ import annotations

import errno
import hashlib
import json
import os
from collections.abc import Mapping
from contextlib import suppress
from dataclasses import asdict, dataclass, field
from pathlib import Path
from typing import Any

from runtime.diagnostics.catalogue import system
from runtime.diagnostics.errors import Place, Problem, TandemError

SCHEMA = 1
FILE = "retained.json"
GREATEST_HISTORY = 1000  # alarms


class RetainedError(TandemError):
    """Retained data cannot be written."""


@dataclass(frozen=True, slots=True)
class RetainedAlarm:
    """A line of the alarm history; `time_ns` since 1970, `line` of the program or 0, `axis` its name or ""."""

    time_ns: int
    id: int
    severity: int
    text: str
    axis: str = ""
    line: int = 0


@dataclass(frozen=True, slots=True)
class Retained:
    """Everything that is retained; lengths in mm, angles in degrees."""

    positions: Mapping[str, float] = field(default_factory=dict)  # axis name -> position
    zero_offsets: Mapping[str, Mapping[str, Mapping[str, float]]] = field(default_factory=dict)  # channel, G5x, axis
    alarms: tuple[RetainedAlarm, ...] = ()  # oldest first, GREATEST_HISTORY at most are kept
    references: Mapping[str, Mapping[str, Any]] = field(
        default_factory=dict
    )  # axis with an absolute encoder, see `keeping`
    interruption: Mapping[str, Any] = field(default_factory=dict)  # see `keeping`; empty: no program was interrupted


class _DamagedError(Exception):
    """The text is the reason."""


def state_directory(configured: Path | None, environment: Mapping[str, str]) -> Path:
    """Where retained data lives: the machine description, else $STATE_DIRECTORY of systemd, else the user's folder."""
    if configured is not None:
        return configured
    if given := environment.get("STATE_DIRECTORY", "").split(":")[0]:
        return Path(given)
    home = Path(environment.get("HOME") or "~").expanduser()
    return Path(environment.get("XDG_STATE_HOME") or home / ".local/state") / "tandem"


class RetainedStore:
    """The files in one directory. One process writes; it may be killed at any moment."""

    def __init__(self, directory: Path) -> None:
        self.directory = directory
        self.file = directory / FILE
        self.previous = directory / f"{FILE}.previous"
        self._new = directory / f"{FILE}.new"
        self._broken = directory / f"{FILE}.broken"

    def load(self) -> tuple[Retained, list[Problem]]:
        """What was saved last, and warnings; nothing saved yet is no warning. Never raises for a damaged file."""
        try:
            return _read(self.file), []
        except FileNotFoundError:
            if not self.previous.exists():
                return Retained(), []
            reason = "it is missing"
        except (_DamagedError, OSError) as error:
            reason = str(error)
        values = {"file": self.file, "reason": reason, "kept": self._broken}
        try:
            return _read(self.previous), [Problem(system.RETAINED_BROKEN, values, Place(str(self.file)))]
        except (_DamagedError, OSError):
            return Retained(), [Problem(system.RETAINED_LOST, values, Place(str(self.file)))]

    def save(self, data: Retained) -> None:
        """Replace what is saved; on return it is on the disk. Raises RetainedError, and the old data is still whole."""
        body = asdict(data) | {"alarms": [asdict(alarm) for alarm in data.alarms[-GREATEST_HISTORY:]]}
        text = json.dumps({"schema": SCHEMA, "checksum": _checksum(body), "data": body}, indent=1)
        try:
            self.directory.mkdir(parents=True, exist_ok=True)
            descriptor = os.open(self._new, os.O_WRONLY | os.O_CREAT | os.O_TRUNC | os.O_CLOEXEC, 0o640)
            with os.fdopen(descriptor, "w", encoding="utf-8") as file:
                file.write(text)
                file.flush()
                os.fsync(descriptor)
            self._keep_previous()
            os.replace(self._new, self.file)
            _sync_directory(self.directory)
        except OSError as error:
            values = {
                "file": self.file,
                "reason": error.strerror or str(error),
                "advice": _advice(error, self.directory),
            }
            raise RetainedError(system.RETAINED_NOT_WRITTEN, Place(str(self.file)), **values) from error

    def _keep_previous(self) -> None:
        """Give the present file its second name; a damaged one is put aside and pushes out no whole one."""
        try:
            _read(self.file)
        except FileNotFoundError:
            return
        except _DamagedError:
            os.replace(self.file, self._broken)
            return
        link = self.directory / f"{FILE}.link"
        with suppress(FileNotFoundError):
            link.unlink()  # left over from a kill
        os.link(self.file, link)
        os.replace(link, self.previous)


def _advice(error: OSError, directory: Path) -> str:
    """What to do about a disk that refuses."""
    if error.errno in (errno.ENOSPC, errno.EDQUOT, errno.EFBIG):
        return "make room on this disk"
    if error.errno == errno.EROFS:
        return "mount this disk so that it can be written"
    if error.errno in (errno.EACCES, errno.EPERM):
        return f"give {directory} to the user of the runtime, with the right to write"
    return "look after the disk"


def _read(file: Path) -> Retained:
    """Raises FileNotFoundError, another OSError, or _DamagedError."""
    raw = file.read_bytes()
    try:
        content: dict[str, Any] = json.loads(raw)
        schema, checksum, body = content["schema"], content["checksum"], content["data"]
    except (ValueError, TypeError, KeyError):
        raise _DamagedError("it is incomplete") from None
    if schema != SCHEMA:
        raise _DamagedError(f"its version is {schema}, this runtime knows {SCHEMA}")
    if checksum != _checksum(body):
        raise _DamagedError("its checksum is wrong")
    alarms = tuple(RetainedAlarm(**alarm) for alarm in body.pop("alarms"))
    return Retained(**body, alarms=alarms)


def _checksum(body: object) -> str:
    return hashlib.sha256(json.dumps(body, sort_keys=True).encode()).hexdigest()


def _sync_directory(directory: Path) -> None:
    """Bring the names to the disk as well."""
    descriptor = os.open(directory, os.O_RDONLY | os.O_DIRECTORY)
    try:
        os.fsync(descriptor)
    finally:
        os.close(descriptor)
