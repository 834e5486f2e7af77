"""Log entries: fields in the journal's own protocol, readable lines elsewhere."""

from __future__ import annotations

import array
import io
import os
import socket
import struct
from collections.abc import Iterator
from pathlib import Path

import pytest

from runtime.diagnostics.catalogue import machine
from runtime.diagnostics.errors import ErrorEntry, Place, Problem, Reaction, Severity
from runtime.diagnostics.events import Event, EventKind
from runtime.scheduler import journal as journal_module
from runtime.scheduler.journal import LineJournal, NativeJournal, open_journal, write_event, write_problem

ENTRY = ErrorEntry(303_999, "Drive of axis {axis}: fault", Severity.FATAL, Reaction.QUICK_STOP, "Look at axis {axis}.")
PROBLEM = Problem(ENTRY, {"axis": "X"}, Place("plate.nc", 12, 5))
ERROR_EVENT = Event(1.5, 1500, EventKind.ERROR, line=12, n=30, number=303_999, axis=1, text="Drive of axis Y: fault")


@pytest.fixture
def listener(tmp_path: Path) -> Iterator[socket.socket]:
    with socket.socket(socket.AF_UNIX, socket.SOCK_DGRAM) as server:
        server.bind(str(tmp_path / "socket"))
        server.settimeout(5)
        yield server


def parse(data: bytes) -> dict[str, str]:
    """An entry as journald reads it."""
    fields, rest = {}, data
    while rest:
        line, _, rest = rest.partition(b"\n")
        name, separator, value = line.partition(b"=")
        if not separator:
            (length,) = struct.unpack("<Q", rest[:8])
            value, rest = rest[8 : 8 + length], rest[8 + length + 1 :]
        fields[name.decode()] = value.decode()
    return fields


def test_a_problem_has_its_fields(listener: socket.socket, tmp_path: Path) -> None:
    write_problem(NativeJournal(tmp_path / "socket"), PROBLEM, TANDEM_AXIS="X")
    assert parse(listener.recv(65536)) == {
        "MESSAGE": "Drive of axis X: fault",
        "PRIORITY": "2",
        "SYSLOG_IDENTIFIER": "tandem",
        "TANDEM_ERROR_ID": "303999",
        "TANDEM_SEVERITY": "fatal",
        "TANDEM_FILE": "plate.nc",
        "TANDEM_LINE": "12",
        "TANDEM_COLUMN": "5",
        "TANDEM_REMEDY": "Look at axis X.",
        "TANDEM_AXIS": "X",
    }


def test_an_error_event_has_its_fields(listener: socket.socket, tmp_path: Path) -> None:
    write_event(NativeJournal(tmp_path / "socket"), ERROR_EVENT, axes=("X", "Y"))
    assert parse(listener.recv(65536)) == {
        "MESSAGE": "Drive of axis Y: fault",
        "PRIORITY": "3",
        "SYSLOG_IDENTIFIER": "tandem",
        "TANDEM_EVENT": "error",
        "TANDEM_ERROR_ID": "303999",
        "TANDEM_SEVERITY": "error",
        "TANDEM_CYCLE": "1500",
        "TANDEM_TIME": "1.500000",
        "TANDEM_LINE": "12",
        "TANDEM_BLOCK_NUMBER": "30",
        "TANDEM_AXIS": "Y",
    }


def test_an_event_without_text_is_told_by_its_name(listener: socket.socket, tmp_path: Path) -> None:
    write_event(NativeJournal(tmp_path / "socket"), Event(2.0, 2000, EventKind.M_OUT, number=8, value=2.5))
    fields = parse(listener.recv(65536))
    assert (fields["MESSAGE"], fields["PRIORITY"]) == ("m_out", "6")
    assert (fields["TANDEM_NUMBER"], fields["TANDEM_VALUE"]) == ("8", "2.5")
    assert "TANDEM_AXIS" not in fields


def test_several_lines_stay_one_entry(listener: socket.socket, tmp_path: Path) -> None:
    NativeJournal(tmp_path / "socket").write("Traceback\n  line 3\nMESSAGE=forged", TANDEM_EVENT="plc")
    fields = parse(listener.recv(65536))
    assert fields["MESSAGE"] == "Traceback\n  line 3\nMESSAGE=forged"
    assert fields["TANDEM_EVENT"] == "plc"


def test_a_long_entry_goes_as_a_sealed_file(listener: socket.socket, tmp_path: Path) -> None:
    text = "x" * 2_000_000
    NativeJournal(tmp_path / "socket").write(text)
    descriptors = array.array("i", [0])
    data, ancillary, _, _ = listener.recvmsg(10, socket.CMSG_SPACE(descriptors.itemsize))
    assert data == b""
    descriptors.frombytes(ancillary[0][2])
    with os.fdopen(descriptors[1], "rb") as file:
        file.seek(0)
        assert parse(file.read())["MESSAGE"] == text


def test_a_journal_that_is_gone_is_no_error(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    NativeJournal(tmp_path / "gone").write("Emergency stop")
    assert capsys.readouterr().err == "Emergency stop\n"


def test_lines_for_a_terminal() -> None:
    stream = io.StringIO()
    journal = LineJournal(stream)
    write_problem(journal, Problem(ErrorEntry(1, "Text", Severity.WARNING, remedy="Do this.")))
    write_problem(journal, PROBLEM)
    write_event(journal, ERROR_EVENT, axes=("X", "Y"))
    write_event(journal, Event(2.0, 2000, EventKind.M_OUT, number=8))
    lost = Event(2.0, 2000, EventKind.ERROR, number=machine.DRIVE_OFFLINE.id, text="drive of axis X does not answer")
    write_event(journal, lost)
    assert stream.getvalue().splitlines() == [
        "warning 1: Text. Do this.",
        "fatal 303999: Drive of axis X: fault",
        "    hint: Look at axis X.",
        "error 303999: Drive of axis Y: fault",
        "error 306002: drive of axis X does not answer",
        f"    hint: {machine.DRIVE_OFFLINE.remedy}",
    ]


def test_verbose_lines_for_a_terminal() -> None:
    stream = io.StringIO()
    journal = LineJournal(stream, verbose=True)
    write_event(journal, ERROR_EVENT, axes=("X", "Y"))
    write_event(journal, Event(2.0, 2000, EventKind.M_OUT, number=8))
    assert stream.getvalue().splitlines() == [
        "error 303999: Drive of axis Y: fault (event=error cycle=1500 time=1.500000 line=12 block_number=30 axis=Y)",
        "info: m_out (event=m_out cycle=2000 time=2.000000 number=8)",
    ]


def test_the_journal_is_used_only_if_stderr_leads_there(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    (tmp_path / "socket").touch()
    monkeypatch.setattr(journal_module, "SOCKET", tmp_path / "socket")
    with (tmp_path / "stderr").open("w") as stream:
        status = os.fstat(stream.fileno())
        mine = f"{status.st_dev}:{status.st_ino}"
        assert isinstance(open_journal({"JOURNAL_STREAM": mine}, stream), NativeJournal)
        assert isinstance(open_journal({"JOURNAL_STREAM": f"{status.st_dev}:1"}, stream), LineJournal)
        assert isinstance(open_journal({}, stream), LineJournal)
    assert isinstance(open_journal({"JOURNAL_STREAM": mine}, io.StringIO()), LineJournal)


def test_messages_of_the_program_are_for_the_operator() -> None:
    stream = io.StringIO()
    event = Event(1.5, 1500, EventKind.MESSAGE, line=12, number=1, text="turn the part")
    write_event(LineJournal(stream), event)
    assert stream.getvalue() == "notice: turn the part\n"
    stream = io.StringIO()
    write_event(LineJournal(stream, verbose=True), event)
    assert "receiver=HMI" in stream.getvalue()
