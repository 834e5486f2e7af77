"""Objects by name or index, typed by the EDS: what is meant, what can be written, what a node answers."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import canopen
import pytest
from canopen.objectdictionary import ODVariable, datatypes
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.fieldbus.described import DRIVE_EDS, eds_path
from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.network import PumpedSdoClient
from runtime.fieldbus.objects import find_object, parse, read_object, value_of, write_object
from runtime.fieldbus.pdo import VALUE_RANGES
from runtime.fieldbus.simulator import Fault
from tests.fieldbus.rig import Rig
from tests.fieldbus.test_commissioning import look

OD = read_dictionary(eds_path(None, DRIVE_EDS), 1)


@pytest.mark.parametrize(
    ("text", "key"),
    [
        ("0x6064", (0x6064, 0)),
        ("24676", (0x6064, 0)),
        ("0x60C2:1", (0x60C2, 1)),
        ("Position actual value", (0x6064, 0)),
        ("position ACTUAL", (0x6064, 0)),
        ("position_actual_value", (0x6064, 0)),
        ("vendor", (0x1018, 1)),
    ],
)
def test_an_object_by_index_or_name(text: str, key: tuple[int, int]) -> None:
    variable = find_object(OD, text)
    assert (variable.index, variable.subindex) == key


@pytest.mark.parametrize(
    ("text", "told"),
    [
        ("0x6999", "no such object"),
        ("0x60C2:9", "no such object"),
        ("flux capacitor", "no object of this name"),
        ("quick stop", "this could be 0x605A"),
    ],
)
def test_what_is_no_object_is_told(text: str, told: str) -> None:
    with pytest.raises(FieldbusError, match=told):
        find_object(OD, text)


def variable(kind: int, access: str = "rw") -> ODVariable:
    made = ODVariable("something", 0x2000, 0)
    made.data_type, made.access_type = kind, access
    return made


@settings(deadline=None)
@given(st.sampled_from(sorted(VALUE_RANGES)), st.integers(-(1 << 65), 1 << 65))
def test_whole_numbers_are_written_within_their_type(kind: int, number: int) -> None:
    """Law: what fits is read back as written, what does not is refused."""
    low, high = VALUE_RANGES[kind]
    if low <= number <= high:
        assert value_of(variable(kind), parse(variable(kind), str(number))) == number
    else:
        with pytest.raises(FieldbusError, match="its values go from"):
            parse(variable(kind), str(number))


def test_other_types() -> None:
    assert parse(variable(datatypes.REAL32), "1.5") == struct.pack("<f", 1.5)
    assert parse(variable(datatypes.VISIBLE_STRING), "gear") == b"gear"
    assert parse(variable(datatypes.OCTET_STRING), "01 FF") == b"\x01\xff"
    assert parse(variable(datatypes.BOOLEAN), "1") == b"\x01"
    assert value_of(variable(datatypes.REAL32), struct.pack("<f", 1.5)) == 1.5
    assert value_of(variable(datatypes.VISIBLE_STRING), b"gear\0") == "gear"
    assert value_of(variable(datatypes.INTEGER32), b"\x01\x02") == b"\x01\x02"  # of another length than the EDS says
    limited = variable(datatypes.UNSIGNED8)
    limited.min, limited.max = 2, 5
    for text, told in (("6", "from 2 to 5"), ("x", "whole number"), ("1.5", "whole number")):
        with pytest.raises(FieldbusError, match=told):
            parse(limited, text)
    for kind, text in (
        (datatypes.REAL32, "much"),
        (datatypes.OCTET_STRING, "0g"),
        (datatypes.VISIBLE_STRING, "Ü"),
        (0x99, "1"),
    ):
        with pytest.raises(FieldbusError):
            parse(variable(kind), text)
    with pytest.raises(FieldbusError, match="only be read"):
        parse(variable(datatypes.UNSIGNED8, "ro"), "1")


@pytest.fixture
def talking() -> Iterator[tuple[Rig, PumpedSdoClient, canopen.ObjectDictionary]]:
    with Rig() as rig:
        yield rig, look(rig).client(1, OD), OD


def test_a_node_is_read_and_written(talking: tuple[Rig, PumpedSdoClient, canopen.ObjectDictionary]) -> None:
    rig, client, od = talking
    assert read_object(client, 1, find_object(od, "0x1008")) == "Tandem simulated CiA 402 drive"
    write_object(client, 1, find_object(od, "0x6085"), "123456")
    assert read_object(client, 1, find_object(od, "0x6085")) == 123456
    with pytest.raises(FieldbusError, match=r"refuses to write object 0x1400:2: .*\(0x08000022\)"):
        write_object(client, 1, find_object(od, "0x1400:2"), "1")
    rig.simulated.inject(1, Fault.SILENT)
    with pytest.raises(FieldbusError, match="does not answer when asked to read object 0x6085"):
        read_object(client, 1, find_object(od, "0x6085"))
