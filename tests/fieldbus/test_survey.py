"""A machine description from a scan: units and mapping as the nodes tell them, and the way to a machine that runs."""

from __future__ import annotations

from pathlib import Path

import can
import pytest
import yaml
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.cli import bus as command
from runtime.cli.main import main
from runtime.config.loader import ConfigurationError, load_machine, parse_machine
from runtime.config.machine import Bus
from runtime.diagnostics.catalogue import configuration
from runtime.fieldbus.commissioning import Commissioning, FoundNode
from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.survey import Factors, Survey, describe, eds_files, survey
from tests.fieldbus.rig import Rig
from tests.fieldbus.test_commissioning import look

FILLED = {
    "<name of the machine>": "found",
    "<m/min>": "24 m/min",
    "<m/s^2>": "4 m/s^2",
    "<m/s^3>": "60 m/s^3",
    "<increments per mm or degree>": "10000",
    "[<64 names at most>]": "[one, two]",
}


def fill_in(text: str) -> str:
    for what, value in FILLED.items():
        text = text.replace(what, value)
    return text


def test_a_scan_becomes_a_machine_that_runs() -> None:
    with Rig() as rig:
        bus = rig.machine.fieldbus.bus
        looking = look(rig)
        text = describe(survey(looking, looking.scan()), bus, {}, Path())
    machine = parse_machine(fill_in(text))
    assert [(axis.name, axis.drive and axis.drive.node) for axis in machine.axes] == [
        ("X", 1), ("Y", 2), ("Z", 3), ("A", 6),
    ]  # fmt: skip
    assert [io.node for io in machine.fieldbus.io] == [10]
    with Rig(machine.model_dump(mode="json", exclude_defaults=True)) as rig:
        rig.enabled()
        assert rig.event_ids() == []


def test_what_is_to_be_filled_in_is_named_where_it_stands() -> None:
    with Rig() as rig:
        looking = look(rig)
        text = describe(survey(looking, looking.scan()), rig.machine.fieldbus.bus, {}, Path())
    with pytest.raises(ConfigurationError) as refusal:
        parse_machine(text, file="found.yaml")
    problems = refusal.value.problems
    assert {problem.entry for problem in problems} == {configuration.TO_FILL_IN}
    told = [problem.values["what"] for problem in problems]
    assert told[:3] == ["name of the machine", "m/min", "m/s^2"]
    assert told[-2:] == ["64 names at most"] * 2
    lines = text.splitlines()
    for problem in problems:
        assert lines[problem.place.line - 1][problem.place.column - 1] == "<"


def drive(**told: object) -> Survey:
    node = FoundNode(5, 0x20192, 0x1AB, 0x77, 0x10002, 9, "servo", "", "2.1")
    return Survey(node=node, **told)  # type: ignore[arg-type]


def written(found: Survey, pitches: dict[int, float] | None = None) -> str:
    text = describe([found], Bus(), pitches or {}, Path())
    (line,) = [line for line in text.splitlines() if "increments_per_unit:" in line]
    return line.partition(":")[2].strip()


def test_units_of_the_factor_group() -> None:
    group = Factors(encoder=(131072, 1), gear=(5, 2), feed=(10000, 1))
    assert written(drive(factors=group)).startswith("<10000 divided by")
    assert written(drive(factors=group), {5: 5.0}).startswith("2000 #")
    assert written(drive(factors=Factors(encoder=(131072, 1), gear=(5, 2))), {5: 10.0}).startswith("32768 #")
    assert written(drive(factors=Factors(unit=0xFA01_0000))).startswith("1000 # per mm")  # µm
    assert written(drive(factors=Factors(unit=0xFD41_0000))).startswith("1000 # per degree")
    assert written(drive()) == "<increments per mm or degree>"
    text = describe([drive(factors=group, max_velocity=400_000, modes=0x180)], Bus(), {5: 5.0}, Path())
    assert "# the drive allows 200 mm/s or degrees/s (0x607F)" in text
    assert "# it has cyclic position, cyclic velocity" in text
    assert "# gear: 5 turns of the motor for 2 of the shaft (0x6091)" in text
    assert "NO CYCLIC MODE" in describe([drive(modes=0x01)], Bus(), {}, Path())


@settings(deadline=None)
@given(
    st.integers(1, 1 << 24), st.integers(1, 1000), st.integers(1, 1000), st.integers(1, 1000), st.floats(0.01, 360.0)
)
def test_a_turn_of_the_shaft_is_what_it_moves(
    increments: int, turns: int, motor: int, shaft: int, pitch: float
) -> None:
    """Law: `pitch` units are one turn of the shaft, whatever encoder and gear are."""
    factors = Factors(encoder=(increments, turns), gear=(motor, shaft))
    per_unit = float(written(drive(factors=factors), {5: pitch}).partition("#")[0])
    assert per_unit * pitch == pytest.approx(increments / turns * motor / shaft)


def test_mapping_as_found_stands_in_the_remarks() -> None:
    with Rig() as rig:
        rig.started()
        rig.master.stop()
        looking = look(rig)
        (found,) = [s for s in survey(looking, looking.scan()) if s.node.node == 1]
        assert found.mapping["RPDO 1"] == ("0x6040", "0x607A")
        assert found.modes is not None
        assert found.modes & 0x80


def test_the_eds_that_fits_is_named(tmp_path: Path) -> None:
    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    (tmp_path / "b_exact.eds").write_text(text)
    (tmp_path / "a_older.EDS").write_text(text.replace("RevisionNumber=0x00010000", "revisionnumber = 0x00000001"))
    (tmp_path / "c_other.eds").write_text(text.replace("ProductNumber=0x402", "ProductNumber=0x403"))
    (tmp_path / "d_broken.eds").write_bytes(b"\xff\xfe\0[")
    (tmp_path / "e_nothing.dcf").write_text("[DeviceInfo]\nVendorNumber=none\n")
    (tmp_path / "readme.txt").write_text("no EDS")
    files = eds_files(tmp_path)
    node = FoundNode(5, 0x20192, 0x7A4D, 0x402, 0x10000, 9, "", "", "")
    assert sorted(Path(file.path).name for file in files if file.fits(node)) == ["a_older.EDS", "b_exact.eds"]
    with Rig() as rig:
        looking = look(rig)
        text = describe(survey(looking, looking.scan([1]), files), rig.machine.fieldbus.bus, {}, tmp_path)
    assert 'eds: "b_exact.eds"' in text


def test_from_the_command_line(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    with Rig() as rig:

        class Looking(Commissioning):
            def __init__(self, bus: can.BusABC, *_: object) -> None:
                super().__init__(bus, lambda: rig.time, rig.idle)

        rig.idle()
        monkeypatch.setattr(command, "Commissioning", Looking)
        channel = rig.machine.fieldbus.bus.channel
        monkeypatch.setattr(command, "open_bus", lambda bus: can.Bus(interface="virtual", channel=channel))
        out = tmp_path / "out.yaml"
        assert main(["bus", "scan", "--machine", str(out)]) == 0
        assert "drive (CiA 402)" in capsys.readouterr().out
        with pytest.raises(ConfigurationError):
            load_machine(out)
        out.write_text(fill_in(out.read_text()))
        assert len(load_machine(out).axes) == 4
        assert main(["bus", "scan", "--machine", str(out)]) == 2  # nothing is written over
        assert main(["bus", "scan", "--pitch", "1=wide"]) == 2
        capsys.readouterr()
        eds = eds_path(None, DRIVE_EDS)
        assert main(["bus", "eds", eds, "1"]) == 0
        assert capsys.readouterr().out == "node 1 is what tandem_cia402.eds describes\n"
        assert main(["bus", "eds", eds, "10"]) == 1
        assert capsys.readouterr().out.endswith("differences\ntandem_cia402.eds is the file of another device\n")


@pytest.mark.parametrize("content", [b"no EDS at all", b"[DeviceInfo]\nVendorNumber=1\n", b"\xff\x00binary", b""])
def test_a_file_that_describes_nothing_describes_no_node(
    capsys: pytest.CaptureFixture[str], tmp_path: Path, content: bytes
) -> None:
    """It has nothing in which a node could differ."""
    file = tmp_path / "some.eds"
    file.write_bytes(content)
    assert main(["bus", "eds", str(file), "1"]) == 1
    said = capsys.readouterr()
    assert said.out == ""
    assert said.err.startswith(f"303010: EDS file {file} of node 1 (on the bus) cannot be read")


def test_the_bus_of_the_description_is_that_of_the_scan() -> None:
    """With its options: nodes that answered there are found there again."""
    bus = Bus(
        interface="udp_multicast", channel="239.1.2.3", options={"port": 51000, "hop_limit": 0}, fd=True, heartbeat=0.05
    )
    described = yaml.safe_load(describe([], bus, {}, Path()))
    assert Bus.model_validate(described["fieldbus"]["bus"]) == bus
