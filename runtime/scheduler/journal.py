"""Structured log entries: to the systemd journal with fields, or as readable lines on stderr.

    journalctl -u tandem TANDEM_ERROR_ID=303010          everything about one error
    journalctl -u tandem -o json --output-fields=MESSAGE,TANDEM_EVENT,TANDEM_AXIS,TANDEM_LINE

The journal's native protocol is one datagram of KEY=value lines; see "Native Journal Protocol" at systemd.io.
"""

from __future__ import annotations

import errno
import os
import socket
import struct
import sys
from collections.abc import Mapping, Sequence
from contextlib import suppress
from fcntl import F_ADD_SEALS, F_SEAL_GROW, F_SEAL_SEAL, F_SEAL_SHRINK, F_SEAL_WRITE, fcntl
from pathlib import Path
from typing import Protocol, TextIO

from runtime.diagnostics.catalogue import CATALOGUE
from runtime.diagnostics.errors import Problem, Severity
from runtime.diagnostics.events import RECEIVERS, Event, EventKind

SOCKET = Path("/run/systemd/journal/socket")

_PRIORITY = {Severity.MESSAGE: 5, Severity.WARNING: 4, Severity.ERROR: 3, Severity.FATAL: 2}  # as in syslog(3)
_NAMES = {3: "error", 2: "fatal", 4: "warning", 5: "notice", 6: "info"}
_WARNING, _NOTICE, _INFO = 4, 5, 6


class Journal(Protocol):
    """Where log entries go."""

    def write(self, message: str, priority: int = _INFO, **fields: object) -> None:
        """One entry: `priority` as in syslog(3), `fields` in capitals (journal.fields(7)). Never raises."""


class NativeJournal:
    """The systemd journal."""

    def __init__(self, address: Path = SOCKET, identifier: str = "tandem") -> None:
        self._address = str(address)
        self._identifier = identifier
        self._socket = socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM | socket.SOCK_CLOEXEC)

    def write(self, message: str, priority: int = _INFO, **fields: object) -> None:
        entry: dict[str, object] = {"MESSAGE": message, "PRIORITY": priority, "SYSLOG_IDENTIFIER": self._identifier}
        data = b"".join(_assignment(name, str(value)) for name, value in (entry | fields).items())
        try:
            self._socket.sendto(data, self._address)
        except OSError as error:
            if error.errno not in (errno.EMSGSIZE, errno.ENOBUFS):
                with suppress(OSError):  # nobody listens any more, or the disk is full
                    print(message, file=sys.stderr)
                return
            self._send_as_file(data)

    def _send_as_file(self, data: bytes) -> None:
        """An entry too long for a datagram goes as a sealed file in memory."""
        descriptor = os.memfd_create("journal-entry", os.MFD_CLOEXEC | os.MFD_ALLOW_SEALING)
        try:
            os.write(descriptor, data)
            fcntl(descriptor, F_ADD_SEALS, F_SEAL_SHRINK | F_SEAL_GROW | F_SEAL_WRITE | F_SEAL_SEAL)
            rights = struct.pack("i", descriptor)
            self._socket.sendmsg([], [(socket.SOL_SOCKET, socket.SCM_RIGHTS, rights)], 0, self._address)
        except OSError:
            with suppress(OSError):
                print(data[:1000], file=sys.stderr)
        finally:
            os.close(descriptor)


class LineJournal:
    """Readable lines for a terminal: what is wrong or worth a notice, and what to do; `verbose`: everything, with fields.

    warning 305010: No real-time priority 80: Operation not permitted. Give the user LimitRTPRIO=99 …
    error 306002: drive of axis X does not answer
        hint: check the drive's supply, its node id and the CAN cable, then reset the channel
    """

    def __init__(self, stream: TextIO, *, verbose: bool = False) -> None:
        self._stream = stream
        self._verbose = verbose

    def write(self, message: str, priority: int = _INFO, **fields: object) -> None:
        if priority >= _INFO and not self._verbose:
            return
        remedy, number = fields.get("TANDEM_REMEDY", ""), fields.get("TANDEM_ERROR_ID")
        line = f"{_NAMES.get(priority, priority)}{f' {number}' if number else ''}: {message}"
        if remedy:
            line += f". {remedy}" if priority >= _WARNING else f"\n    hint: {remedy}"
        if self._verbose:
            hidden = ("TANDEM_REMEDY", "TANDEM_ERROR_ID", "TANDEM_SEVERITY")
            more = [
                f"{key.removeprefix('TANDEM_').lower()}={value}" for key, value in fields.items() if key not in hidden
            ]
            line += f" ({' '.join(more)})" if more else ""
        with suppress(OSError):  # nobody listens any more
            print(line, file=self._stream, flush=True)


def open_journal(environment: Mapping[str, str], stream: TextIO, *, verbose: bool = False) -> Journal:
    """The journal if `stream` (stderr) leads there: $JOURNAL_STREAM, systemd.exec(5); else lines on `stream`.

    The journal gets every event; lines are for errors, warnings and notices, unless they are to be `verbose`.
    """
    device, _, inode = environment.get("JOURNAL_STREAM", "").partition(":")
    try:
        status = os.fstat(stream.fileno())
    except (OSError, ValueError):
        return LineJournal(stream, verbose=verbose)
    if (device, inode) == (str(status.st_dev), str(status.st_ino)) and SOCKET.exists():
        return NativeJournal()
    return LineJournal(stream, verbose=verbose)


def write_problem(journal: Journal, problem: Problem, **fields: object) -> None:
    """An error or warning, with its id, its place, and what to do."""
    place = problem.place
    known = {"TANDEM_ERROR_ID": problem.entry.id, "TANDEM_SEVERITY": problem.entry.severity.name.lower()}
    if place.file:
        known["TANDEM_FILE"] = place.file
    if place.line:
        known |= {"TANDEM_LINE": place.line, "TANDEM_COLUMN": place.column}
    if problem.entry.remedy:
        known["TANDEM_REMEDY"] = problem.entry.remedy.format(**problem.values)
    journal.write(problem.text, _PRIORITY[problem.entry.severity], **known, **fields)


def write_event(journal: Journal, event: Event, axes: Sequence[str] = (), severity: Severity = Severity.ERROR) -> None:
    """An event of the cycle. `axes`: axis names by index; `severity`: of the error, where the event is one."""
    name = event.kind.name.lower()
    priority = _PRIORITY[severity] if event.kind is EventKind.ERROR else _INFO
    if event.kind is EventKind.MESSAGE:
        priority = _NOTICE  # the program speaks to the operator
    fields: dict[str, object] = {"TANDEM_EVENT": name, "TANDEM_CYCLE": event.cycle, "TANDEM_TIME": f"{event.t:.6f}"}
    if event.kind is EventKind.ERROR:
        fields |= {"TANDEM_ERROR_ID": event.number, "TANDEM_SEVERITY": severity.name.lower()}
        entry = CATALOGUE.get(event.number)
        if entry is not None and entry.remedy and "{" not in entry.remedy:  # the values stayed in the cycle
            fields["TANDEM_REMEDY"] = entry.remedy
    elif event.kind is EventKind.MESSAGE:
        fields["TANDEM_RECEIVER"] = RECEIVERS[event.number]
    elif event.number:
        fields["TANDEM_NUMBER"] = event.number
    if event.value:
        fields["TANDEM_VALUE"] = f"{event.value:g}"
    if event.line:
        fields["TANDEM_LINE"] = event.line
    if event.n is not None:
        fields["TANDEM_BLOCK_NUMBER"] = event.n
    if event.axis >= 0:
        fields["TANDEM_AXIS"] = axes[event.axis] if event.axis < len(axes) else event.axis
    journal.write(event.text or name, priority, **fields)


def _assignment(name: str, value: str) -> bytes:
    """KEY=value, or for text of several lines KEY, its length as 64 bits, and the text."""
    data = value.encode("utf-8", "replace")
    if b"\n" not in data:
        return name.encode() + b"=" + data + b"\n"
    return name.encode() + b"\n" + struct.pack("<Q", len(data)) + data + b"\n"
