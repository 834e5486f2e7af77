"""EDS files as they are met in the field: what has one meaning only is read, what has none is refused with its object."""

from __future__ import annotations

import contextlib
import re
from collections.abc import Callable
from pathlib import Path

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus import eds_text
from runtime.fieldbus.described import DRIVE_EDS, eds_path, make_links
from runtime.fieldbus.dictionaries import read_dictionary
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.pdo import find_variable
from tests.fieldbus.rig import Rig, demo_description
from tests.fieldbus.test_object_dictionaries import described

TEXT = Path(eds_path(None, DRIVE_EDS)).read_text(encoding="utf-8")
GOOD = described(read_dictionary(eds_path(None, DRIVE_EDS), 5))


def _in(section: str, key: str, value: str | None) -> Callable[[str], str]:
    """Change a key of a section, or take it out."""
    line = "" if value is None else f"{key}={value}\n"
    return lambda text: re.sub(rf"(\[{section}\][^[]*?){key}=.*\n", rf"\g<1>{line}", text)


def _subs_first(text: str) -> str:
    found = re.search(r"\[1018\]\n.*?\n\n", text, re.DOTALL)
    assert found is not None
    return text.replace(found[0], "") + "\n" + found[0]


HARMLESS: dict[str, Callable[[str], str]] = {
    "sub-objects in front of their object": _subs_first,
    "comments without a number": lambda text: text.replace("Lines=2", ""),
    "fewer comments than counted": lambda text: text.replace("Lines=2", "Lines=9"),
    "a dummy left out": lambda text: text.replace("Dummy0003=0\n", ""),
    "numbers of the device left empty": lambda text: text.replace("VendorNumber=0x7A4D", "VendorNumber="),
    "yes for a bit rate": lambda text: text.replace("BaudRate_1000=1", "BaudRate_1000=yes"),
    "limits left empty": lambda text: text.replace("[6040]\n", "[6040]\nLowLimit=\nHighLimit=\n"),
    "names of types": _in("6040", "DataType", "unsigned16"),
    "names of kinds": lambda t: t.replace("ObjectType=0x7", "ObjectType=VAR").replace("ObjectType=0x9", "ObjectType=record"),
    "h for hexadecimal": _in("6085", "DefaultValue", "989680h"),
    "octal": _in("6085", "DefaultValue", "046113200"),
    "the formula in brackets": lambda text: text.replace("$NODEID+0x200", "( 0x200 + $NODEID )"),
    "the formula in three parts": lambda text: text.replace("$NODEID+0x200", "0x100+$NODEID+256"),
    "commissioning in words": lambda text: text + "\n[DeviceComissioning]\nNodeID=none\nBaudrate=1000 kbit/s\n",
    "strange ends of lines": lambda text: text.replace("\n", "\r\r\n"),
    "form feeds and tabs": lambda text: text.replace("=", "\t=\t").replace("\n\n", "\n\f\n"),
}  # fmt: skip


@pytest.mark.parametrize("spoil", HARMLESS.values(), ids=HARMLESS.keys())
def test_only_one_meaning_is_possible(spoil: Callable[[str], str], tmp_path: Path) -> None:
    file = tmp_path / "nasty.eds"
    spoilt = spoil(TEXT)
    assert spoilt != TEXT
    file.write_text(spoilt, newline="")
    assert described(read_dictionary(str(file), 5)) == GOOD


@pytest.mark.parametrize("encoding", ["utf-16", "utf-8-sig", "cp1252"])
def test_encodings(encoding: str, tmp_path: Path) -> None:
    file = tmp_path / "nasty.eds"
    file.write_bytes(TEXT.replace("Vendor-ID", "Größe").encode(encoding))
    od = read_dictionary(str(file), 5)
    assert described(od) == GOOD
    assert find_variable(od, 0x1018, 1).name == "Größe"


HOPELESS: dict[str, tuple[Callable[[str], str], str]] = {
    "no data type": (_in("6040", "DataType", None), "object 0x6040 has no DataType"),
    "no access": (_in("1018sub1", "AccessType", None), "object 0x1018:1 has no AccessType"),
    "another formula": (lambda text: text.replace("$NODEID+0x200", "2*$NODEID"), "formula '2\\*\\$NODEID' is no sum"),
    "the id taken away": (lambda text: text.replace("$NODEID+0x200", "0x200-$NODEID"), "is no sum"),
    "no process data": (lambda text: re.sub(r"\[1[46]00(sub\d)?\][^[]*", "", text), "no object 0x1400:1.*process data"),
    "half of the mapping": (lambda text: re.sub(r"\[1600sub0\][^[]*", "", text), "no object 0x1600.*process data"),
    "nothing": (lambda text: "", "no object"),
}


@pytest.mark.parametrize(("spoil", "told"), HOPELESS.values(), ids=HOPELESS.keys())
def test_what_has_no_meaning_is_refused_with_its_object(spoil: Callable[[str], str], told: str, tmp_path: Path) -> None:
    file = tmp_path / "nasty.eds"
    file.write_text(spoil(TEXT))
    description = demo_description()
    description["axes"][0]["drive"]["eds"] = str(file)
    with Rig(description, nodes=False) as rig, pytest.raises(FieldbusError, match=told) as refusal:
        make_links(rig.machine)
    assert refusal.value.problem.entry in (catalogue.EDS_UNREADABLE, catalogue.EDS_OBJECT_MISSING)
    assert "axis X" in refusal.value.problem.text


@settings(deadline=None)
@given(
    st.lists(st.tuples(st.sampled_from("+-"), st.integers(0, 0x4000_0000), st.booleans()), max_size=4),
    st.integers(0, 4),
)
def test_law_of_formulas(terms: list[tuple[str, int, bool]], place: int) -> None:
    """Law: a sum means the same however it is written."""
    written = [f"{sign} {hex(number) if hexadecimal else number}" for sign, number, hexadecimal in terms]
    written.insert(min(place, len(written)), "+ $NODEID")
    text = " ".join(written).removeprefix("+ ")
    total = sum(-number if sign == "-" else number for sign, number, _ in terms)
    (line,) = [
        line
        for line in eds_text.normalise(f"[2000]\nDataType=7\nAccessType=rw\nDefaultValue={text}\n").splitlines()
        if line.startswith("DefaultValue")
    ]
    assert line == f"DefaultValue=$NODEID+{total}"


@settings(deadline=None)
@given(st.binary(max_size=400))
def test_rubbish_is_read_or_refused(data: bytes) -> None:
    """Nothing but ValueError comes out of any bytes."""
    with contextlib.suppress(ValueError):
        eds_text.normalise(eds_text.decode(data))
