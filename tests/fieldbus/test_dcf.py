"""Configuration files of devices: DCF and concise DCF, downloaded at boot and to nodes that come back, and when not."""

from __future__ import annotations

import struct
from pathlib import Path
from typing import Any

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import commissioning as errors
from runtime.fieldbus.dcf import Entry, concise, parse_concise, read_configuration
from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.dialogue import Access
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig, demo_description
from tests.fieldbus.test_rejoin import back

STAMP = (15_000, 3_600_000)


def dcf(**values: str) -> str:
    """The drive's EDS as a DCF: `_6085="1234"` sets an object, `_1020sub1` a sub-object."""
    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    for section, value in values.items():
        head = f"[{section[1:]}]\n"
        assert head in text
        text = text.replace(head, f"{head}ParameterValue={value}\n")
    return text


def described(file: Path, **more: Any) -> dict[str, Any]:
    description = demo_description()
    description["axes"][0]["drive"] |= {"dcf": str(file), **more}
    return description


def refused(file: Path, reason: str) -> None:
    with pytest.raises(FieldbusError, match=reason) as refusal:
        read_configuration(str(file), 1)
    assert refusal.value.problem.entry in (errors.DCF_UNREADABLE, errors.DCF_VALUE)
    assert refusal.value.problem.explained()


@pytest.fixture
def file(tmp_path: Path) -> Path:
    file = tmp_path / "x.dcf"
    file.write_text(
        dcf(
            _6066="77",
            _605E="$NODEID+1",
            _607A="5000",
            _6040="15",
            _1017="9999",
            _1020sub1="15000",
            _1020sub2="3600000",
        )
    )
    return file


def test_what_is_downloaded(file: Path) -> None:
    """Orders, set-points and what the master itself sets are left out."""
    configuration = read_configuration(str(file), 1)
    assert configuration.stamp == STAMP
    assert configuration.entries == (Entry(0x605E, 0, b"\2\0"), Entry(0x6066, 0, b"\x4d\0"))


def test_a_drive_is_configured_at_boot_and_when_it_comes_back(file: Path) -> None:
    with Rig(described(file, dcf_store=False)) as rig:
        rig.enabled()
        drive = rig.simulated.drives[1]
        assert drive._number(0x6066) == 77
        assert (drive._number(0x1020, 1), drive._number(0x1020, 2)) == STAMP
        assert rig.simulated.drives[2]._number(0x6066) != 77
        rig.simulated.inject(1, Fault.REBOOT)
        assert rig.run_until(lambda: back(rig, 1), 5.0)
        assert drive._number(0x6066) == 77


def written(rig: Rig, node: int = 1) -> list[int]:
    """The indices that are written to a node from now on."""
    indices: list[int] = []
    rig.simulated.nodes[node].local.add_write_callback(lambda index, **_: indices.append(index))
    return indices


def test_a_device_that_is_configured_so_already_is_left_alone(file: Path) -> None:
    with Rig(described(file)) as rig:
        drive = rig.simulated.drives[1]
        rig.idle()
        read = drive._on_read
        stamp = list(STAMP)
        drive.local._read_callbacks[:] = [
            lambda index, subindex, od: stamp[subindex - 1] if index == 0x1020 else read(index, subindex, od)
        ]
        indices = written(rig)
        rig.master.start()
        assert 0x6085 in indices  # the master's own
        assert not {0x6066, 0x1020} & set(indices)
        rig.master.stop()
        stamp[1] += 1
        rig.master.start()
        assert {0x6066, 0x1020} <= set(indices)


def test_concise_files_do_the_same(file: Path, tmp_path: Path) -> None:
    configuration = read_configuration(str(file), 1)
    stamps = [Entry(0x1020, 1 + k, struct.pack("<I", number)) for k, number in enumerate(STAMP)]
    other = tmp_path / "x.cdcf"
    other.write_bytes(concise([*configuration.entries, *stamps]))
    assert read_configuration(str(other), 1) == configuration
    with Rig(described(other)) as rig:
        rig.master.start()
        assert rig.simulated.drives[1]._number(0x6066) == 77


entries = st.lists(st.builds(Entry, st.integers(0, 0xFFFF), st.integers(0, 0xFF), st.binary(max_size=12)), max_size=8)


@settings(deadline=None)
@given(entries)
def test_law_of_concise_files(wanted: list[Entry]) -> None:
    """Law: what was written is read; every file that is cut off anywhere, or too long, is refused."""
    data = concise(wanted)
    assert parse_concise(data) == wanted
    for cut in range(len(data)):
        with pytest.raises(FieldbusError):
            parse_concise(data[:cut])
    with pytest.raises(FieldbusError, match="follow its last entry"):
        parse_concise(data + b"\0")


def test_files_that_cannot_be_used(tmp_path: Path) -> None:
    file = tmp_path / "x.dcf"
    refused(file, "No such file")
    file.write_text(dcf(_6066="many"))
    refused(file, "object 0x6066: 'many' is no value")
    file.write_text(dcf(_6066="70000"))
    refused(file, "object 0x6066: 70000 does not fit")
    file.write_text("[1000")
    refused(file.with_suffix(".cdcf"), "No such file")
    long = tmp_path / "x.cdcf"
    long.write_bytes(b"\1\0")
    refused(long, "ends after 0")


def test_a_bad_file_stops_the_start_before_a_node_is_told_anything(tmp_path: Path) -> None:
    file = tmp_path / "x.dcf"
    file.write_text(dcf(_6066="many"))
    with Rig(described(file)) as rig, pytest.raises(FieldbusError, match="0x6066"):
        rig.master.start()


def test_an_object_that_the_device_refuses_is_named(tmp_path: Path) -> None:
    file = tmp_path / "x.cdcf"
    file.write_bytes(concise([Entry(0x6999, 0, b"\1")]))
    with Rig(described(file)) as rig, pytest.raises(FieldbusError, match="no object 0x6999"):
        rig.master.start()


def test_a_device_is_asked_to_keep_it(file: Path, tmp_path: Path) -> None:
    """A drive whose EDS has object 0x1010 gets "save" when it was configured."""
    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    store = "[1010]\nParameterName=Store parameters\nObjectType=0x8\nSubNumber=2\n"
    sub = "[1010sub{}]\nParameterName=Store\nObjectType=0x7\nDataType=0x0007\nAccessType=rw\nDefaultValue=1\nPDOMapping=0\n"
    eds = tmp_path / "keeps.eds"
    eds.write_text(text + store + sub.format(0) + sub.format(1))
    with (
        Rig(described(file, dcf_store=True, eds=str(eds))) as rig,
        pytest.raises(FieldbusError, match="write object 0x1010:1"),
    ):
        rig.master.start()  # the simulated drive has none: it was asked for it


NAMES = [bytes(65 + k % 26 for k in range(length)) for length in (1, 4, 5, 7, 8, 14, 15, 70)]


@pytest.mark.parametrize("name", NAMES, ids=[str(len(name)) for name in NAMES])
def test_values_of_any_length_at_the_boot_and_when_a_node_comes_back(tmp_path: Path, name: bytes) -> None:
    """Up to 4 bytes go in one frame, more in segments."""
    file = tmp_path / "x.cdcf"
    file.write_bytes(concise([Entry(0x2000, 0, name), Entry(0x6066, 0, b"\x4d\0")]))
    with Rig(described(file)) as rig:
        rig.enabled()
        drive = rig.simulated.drives[1]
        assert drive.local.get_data(0x2000, 0) == name
        rig.simulated.inject(1, Fault.REBOOT)
        assert drive.local.get_data(0x2000, 0) != name
        assert rig.run_until(lambda: back(rig, 1), 5.0)
        assert drive.local.get_data(0x2000, 0) == name
        assert drive._number(0x6066) == 77


def test_texts_and_real_numbers_of_a_dcf(tmp_path: Path) -> None:
    file = tmp_path / "x.dcf"
    file.write_text(dcf(_2000="spindle of the second carriage", _2001="2.5"))
    assert read_configuration(str(file), 1).entries == (
        Entry(0x2000, 0, b"spindle of the second carriage"),
        Entry(0x2001, 0, struct.pack("<d", 2.5)),
    )


def test_a_number_of_another_length_than_its_type_is_refused(tmp_path: Path) -> None:
    file = tmp_path / "x.cdcf"
    file.write_bytes(concise([Entry(0x6066, 0, bytes(8))]))
    with Rig(described(file)) as rig, pytest.raises(FieldbusError, match="8 bytes are no value of the type"):
        rig.master.start()


@settings(deadline=None, max_examples=30)
@given(name=st.binary(min_size=5, max_size=40), lost=st.sets(st.integers(0, 12), max_size=3), of_node=st.booleans())
def test_law_of_a_download_with_frames_lost(name: bytes, lost: set[int], of_node: bool) -> None:
    """Law: the node has the whole value or the transfer is refused, whichever frames of it were lost."""
    with Rig() as rig:
        rig.started()
        drive = rig.simulated.drives[1]
        questions = rig.master.questions(rig.master.drive(0))
        count = 0

        def passes() -> bool:
            nonlocal count
            count += 1
            return count - 1 not in lost

        if of_node:
            take = questions.on_answer
            questions.on_answer = lambda data: take(data) if passes() else None  # type: ignore[method-assign]
        else:
            send = questions._send
            questions._send = lambda cob_id, data: send(cob_id, data) if passes() else None
        questions.ask(Access(0x2000, data=name), rig.time)
        try:
            while questions.open is not None:
                rig.cycle()
                questions.poll(rig.time)
        except FieldbusError:
            assert len(lost) == 3
        else:
            assert drive.local.get_data(0x2000, 0) == name
