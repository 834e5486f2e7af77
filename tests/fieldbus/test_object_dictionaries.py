"""The EDS files: complete, consistent, and what the profiles ask for."""

from __future__ import annotations

import configparser
import os
from pathlib import Path

import canopen
import pytest
from canopen.objectdictionary import ODVariable

from runtime.fieldbus.described import DRIVE_EDS, IO_EDS, eds_path
from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.exchange import DriveNeeds, drive_pdos, io_pdos, plain_mode
from runtime.fieldbus.pdo import STRUCT_CODES, VALUE_RANGES, find_variable, lay_out

FILES = [DRIVE_EDS, IO_EDS]


def sections(file: str) -> configparser.RawConfigParser:
    parser = configparser.RawConfigParser()
    parser.optionxform = str  # type: ignore[assignment,method-assign]
    parser.read_string(Path(eds_path(None, file)).read_text(encoding="utf-8"))
    return parser


@pytest.mark.parametrize("file", FILES)
def test_lists_and_sections_agree(file: str) -> None:
    eds = sections(file)
    listed: list[str] = []
    for name in ("MandatoryObjects", "OptionalObjects", "ManufacturerObjects"):
        count = eds.getint(name, "SupportedObjects")
        numbers = [eds.get(name, str(k + 1)) for k in range(count)]
        assert len(eds.options(name)) == count + 1
        listed += [number[2:] for number in numbers]
    objects = [s for s in eds.sections() if len(s) == 4 and all(c in "0123456789ABCDEF" for c in s)]
    assert sorted(listed) == sorted(objects)
    for index in objects:
        subs = [s for s in eds.sections() if s.startswith(index + "sub")]
        assert len(subs) == eds.getint(index, "SubNumber", fallback=0)
    assert eds.get("FileInfo", "FileName") == file


@pytest.mark.parametrize("file", FILES)
def test_defaults_fit_their_types(file: str) -> None:
    od = canopen.import_od(eds_path(None, file), 5)
    for entry in od.values():
        for variable in [entry] if isinstance(entry, ODVariable) else entry.values():
            assert variable.default is not None, f"{variable.index:04X}:{variable.subindex}"
            if variable.data_type in STRUCT_CODES:
                low, high = VALUE_RANGES[variable.data_type]
                assert low <= variable.default <= high, f"{variable.index:04X}:{variable.subindex}"


@pytest.mark.parametrize("file", FILES)
def test_default_mappings_can_be_laid_out(file: str) -> None:
    od = canopen.import_od(eds_path(None, file), 5)
    for first in (0x1600, 0x1A00):
        for number in range(4):
            if first + number not in od:
                continue
            count = find_variable(od, first + number, 0).default or 0
            entries = [find_variable(od, first + number, k + 1).default or 0 for k in range(count)]
            layout = lay_out(od, tuple((entry >> 16, entry >> 8 & 0xFF) for entry in entries))
            assert layout.mapping_entries(od) == entries


def test_the_dictionaries_have_what_is_exchanged() -> None:
    drive = canopen.import_od(eds_path(None, DRIVE_EDS), 1)
    for plan in (plan for spindle in (False, True) for plan in drive_pdos(DriveNeeds(spindle, plain_mode(spindle)))):
        assert lay_out(drive, plan.objects).codec.size <= 8
    io = canopen.import_od(eds_path(None, IO_EDS), 10)
    for plan in io_pdos(64, 64):
        assert lay_out(io, plan.objects).codec.size == 8


def test_layouts_that_cannot_be() -> None:
    od = canopen.import_od(eds_path(None, DRIVE_EDS), 1)
    with pytest.raises(KeyError):
        lay_out(od, ((0x6999, 0),))
    with pytest.raises(KeyError):
        lay_out(od, ((0x6040, 1),))
    with pytest.raises(ValueError, match="cannot be mapped"):
        lay_out(od, ((0x6085, 0),))
    with pytest.raises(ValueError, match="96 bits"):
        lay_out(od, ((0x607A, 0),) * 3)


def test_dictionaries_are_those_of_the_node_and_of_the_file_as_it_is_now(tmp_path: Path) -> None:
    file = tmp_path / "drive.eds"
    text = Path(eds_path(None, DRIVE_EDS)).read_text()
    file.write_text(text)
    first, second = read_dictionary(str(file), 5), read_dictionary(str(file), 5)
    assert second[0x6040].name == first[0x6040].name == "Controlword"
    assert second[0x6040] is not first[0x6040]  # nobody sees what another one changes
    first_pdos = [read_dictionary(str(file), node).get_variable(0x1400, 1) for node in (5, 6)]
    assert [variable.default for variable in first_pdos if variable] == [0x205, 0x206]
    file.write_text(text.replace("ParameterName=Controlword", "ParameterName=Orders"))
    os.utime(file, ns=(1, 1))
    assert read_dictionary(str(file), 5)[0x6040].name == "Orders"
    file.unlink()
    with pytest.raises(FileNotFoundError):
        read_dictionary(str(file), 5)


def _spoilt(text: str) -> str:
    """The same EDS as a careless vendor writes it."""
    lines = []
    for line in text.splitlines():
        if line.startswith("[") and "sub" in line:
            line = "[ " + line[1:-1].replace("sub", "SUB").lower().replace("sub", "SUB") + " ]"
        line = line.replace("DataType=", "datatype = ").replace("PDOMapping=1", "PDOMapping=TRUE ; can be mapped")
        lines.append(line)
    return "\r\n".join([*lines, "this line is nothing", "[1000]", "ParameterName=Twice", ""])


@pytest.mark.parametrize("file", FILES)
def test_careless_files_give_the_same_dictionary(file: str, tmp_path: Path) -> None:
    good = read_dictionary(eds_path(None, file), 5)
    careless = tmp_path / "careless.eds"
    text = Path(eds_path(None, file)).read_text(encoding="utf-8")
    assert _spoilt(text) != text
    careless.write_bytes(_spoilt(text).replace("Vendor ID", "Größe").encode("cp1252"))
    read = read_dictionary(str(careless), 5)
    assert described(read) == described(good)


def described(od: canopen.ObjectDictionary) -> list[tuple[object, ...]]:
    """All that the runtime reads of a dictionary."""
    variables: list[ODVariable] = []
    for entry in od.values():
        variables += [entry] if isinstance(entry, ODVariable) else [entry[sub] for sub in entry]
    return [(v.index, v.subindex, v.data_type, v.access_type, v.pdo_mappable, v.default) for v in variables]


@pytest.mark.parametrize("formula", ["$NODEID+0x200", "0x200+$NODEID", "$nodeid + 0x200", "0x200 + $NodeID"])
def test_node_id_formulas(formula: str, tmp_path: Path) -> None:
    file = tmp_path / "formula.eds"
    text = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
    (before,) = {line for line in text.splitlines() if line.lower().replace(" ", "") == "defaultvalue=$nodeid+0x200"}
    file.write_text(text.replace(before, f"DefaultValue={formula}"))
    assert find_variable(read_dictionary(str(file), 7), 0x1400, 1).default == 0x207
    file.write_text(text.replace(before, "DefaultValue=$NODEID"))
    assert find_variable(read_dictionary(str(file), 7), 0x1400, 1).default == 7
