"""EDS and DCF files as vendors write them, brought into the form of CiA 306 that the parser expects.

Seen in the field, and mended here without a word because only one meaning is possible: text in Windows' code page or UTF-16, byte
order marks, `[1a00SUB1]` or `[ 1A00sub1 ]`, sub-objects in front of their object, keys in any case (`datatype`), `TRUE` for 1,
spaces around `=`, a section or key that stands twice (the first one counts, as in the vendors' own tools), `$NODEID` alone or in
any sum, `10h`, octal numbers, names of types (`UNSIGNED16`), objects without a name, comments that are fewer than counted, lines
that are neither section nor key. What has no meaning at all (no data type, a formula that is none) is refused with its object.
"""

from __future__ import annotations

import re
from typing import Final

from canopen.objectdictionary import datatypes

_SECTION: Final = re.compile(r"\s*\[\s*([^\]]*?)\s*\]")
_OBJECT: Final = re.compile(r"(?:0x)?([0-9a-f]{4})(?:sub(?:0x)?([0-9a-f]{1,2}))?(name|value)?\Z", re.IGNORECASE)
_TRUTH: Final = {"true": "1", "yes": "1", "false": "0", "no": "0"}
_KEYS: Final = {
    key.lower(): key
    for key in [
        "ParameterName",
        "ObjectType",
        "DataType",
        "AccessType",
        "PDOMapping",
        "DefaultValue",
        "ParameterValue",
        "LowLimit",
        "HighLimit",
        "SubNumber",
        "CompactSubObj",
        "SupportedObjects",
        "Lines",
        "NodeID",
        "Baudrate",
        "NrOfEntries",
        "ObjFlags",
        "Denotation",
        "ParameterRefd",
    ]
}
_HEXADECIMAL: Final = re.compile(r"([0-9][0-9A-Fa-f]*)[hH]")
_OCTAL: Final = re.compile(r"0[0-7]+")
_TERM: Final = re.compile(r"([+-]?)(\$NODEID|0X[0-9A-F]+|[0-9][0-9A-F]*H|[0-9]+)")
_SUM: Final = re.compile(rf"{_TERM.pattern}(?:{_TERM.pattern.replace('?', '', 1)})*")
_OBJECT_TYPES: Final = {"DOMAIN": "0x2", "VAR": "0x7", "ARRAY": "0x8", "RECORD": "0x9"}
_TYPES: Final = {
    name: hex(getattr(datatypes, name))
    for name in (
        "BOOLEAN", "INTEGER8", "INTEGER16", "INTEGER32", "INTEGER64", "UNSIGNED8", "UNSIGNED16", "UNSIGNED32", "UNSIGNED64",
        "REAL32", "REAL64", "VISIBLE_STRING", "OCTET_STRING", "DOMAIN",
    )
}  # fmt: skip
_OF_NO_USE: Final = (
    "Comments",
    "DeviceComissioning",
    "DeviceCommissioning",
)  # the node id is that of the machine description
_NUMBERS_OF_DEVICE: Final = ("VendorNumber", "ProductNumber", "RevisionNumber", "NrOfRXPDO", "NrOfTXPDO", "Granularity")
_NAMES: Final = {
    name.lower(): name
    for name in [
        "FileInfo",
        "DeviceInfo",
        "DummyUsage",
        "Comments",
        "MandatoryObjects",
        "OptionalObjects",
        "ManufacturerObjects",
        "DeviceComissioning",
    ]
}


def decode(data: bytes) -> str:
    """The text of a file: UTF-16 if it says so, UTF-8 if it can be, else the code page that Windows tools write."""
    if data.startswith((b"\xff\xfe", b"\xfe\xff")):
        return data.decode("utf-16", errors="replace")
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def normalise(text: str) -> str:
    """The same content in the one form that every parser reads. Raises ValueError, which names the object."""
    sections: dict[str, dict[str, str]] = {}
    current: dict[str, str] | None = None
    for line in text.splitlines():
        if match := _SECTION.match(line):
            name = _section_name(match.group(1))
            current = sections.setdefault(name, {})
            continue
        key, equals, value = line.partition("=")
        key, value = key.strip(), value.strip()
        if current is None or not equals or not key or key.startswith((";", "#")):
            continue
        key = _KEYS.get(key.lower(), key)
        try:
            current.setdefault(key, _value(key, value))
        except ValueError as error:
            raise ValueError(f"[{list(sections)[-1]}] {key}: {error}") from None
    lines: list[str] = []
    for name, entries in sorted(sections.items(), key=_rank):
        if name in _OF_NO_USE:
            continue
        _complete(name, entries)
        lines += [f"[{name}]", *(f"{key}={value}" for key, value in entries.items()), ""]
    return "\n".join(lines)


def _section_name(name: str) -> str:
    if match := _OBJECT.match(name):
        index, subindex, kind = match.groups()
        return index.upper() + (f"sub{int(subindex, 16):X}" if subindex else "") + (kind or "").capitalize()
    return _NAMES.get(name.lower(), name)


def _rank(section: tuple[str, dict[str, str]]) -> tuple[bool, str]:
    """General sections in their order, then the objects, each in front of its sub-objects."""
    name = section[0]
    match = _OBJECT.match(name)
    return (
        (True, name[:4] + (f"{int(match.group(2) or '0', 16) + bool(match.group(2)):03}" if match else ""))
        if match
        else (False, "")
    )


def _complete(name: str, entries: dict[str, str]) -> None:
    """What a section must have. Raises ValueError if it cannot be made up."""
    if name == "DummyUsage":
        for number in range(1, 8):
            entries.setdefault(f"Dummy{number:04}", "0")
    elif name == "DeviceInfo":
        for key in [key for key, value in entries.items() if key in _NUMBERS_OF_DEVICE and not _is_number(value)]:
            del entries[key]
    elif match := _OBJECT.match(name):
        index, subindex, kind = match.groups()
        if kind:
            return
        title = f"0x{index}" + (f":{int(subindex, 16)}" if subindex else "")
        entries.setdefault("ParameterName", f"Object {title}")
        if entries.get("ObjectType", "0x7") in ("0x8", "0x9") and not subindex and "CompactSubObj" not in entries:
            return
        for key in ("DataType", "AccessType"):
            if not entries.get(key):
                raise ValueError(f"object {title} has no {key}")


def _is_number(value: str) -> bool:
    try:
        int(value, 0)
    except ValueError:
        return False
    return True


def _value(key: str, value: str) -> str:
    """Raises ValueError for what can have no meaning."""
    if key == "ParameterName":
        return value
    value = value.partition(";")[0].strip()
    if key == "PDOMapping" or key.startswith("BaudRate_"):
        return _TRUTH.get(value.lower(), value or "0")
    if key == "DataType":
        return _TYPES.get(value.upper(), _number(value))
    if key == "ObjectType":
        value = _OBJECT_TYPES.get(value.upper(), _number(value))
        return hex(int(value, 0)) if _is_number(value) else value
    if "$NODEID" in value.upper():
        return _formula(value)
    return _number(value) if key in ("DefaultValue", "ParameterValue", "LowLimit", "HighLimit") else value


def _number(value: str) -> str:
    """`10h` and octal numbers (CiA 306: a leading 0) as Python writes them."""
    if match := _HEXADECIMAL.fullmatch(value):
        return f"0x{match.group(1)}"
    return f"0o{value.lstrip('0') or '0'}" if _OCTAL.fullmatch(value) else value


def _formula(value: str) -> str:
    """A sum with `$NODEID`, as `$NODEID+number`. Raises ValueError for any other formula."""
    text = value.upper().replace(" ", "").replace("\t", "")
    text = text[1:-1] if text.startswith("(") and text.endswith(")") else text
    if not _SUM.fullmatch(text) or text.count("$NODEID") != 1 or "-$NODEID" in text:
        raise ValueError(f"the formula {value!r} is no sum of $NODEID and numbers")
    total = sum(
        (-1 if sign == "-" else 1) * int(_number(term), 0) for sign, term in _TERM.findall(text) if term != "$NODEID"
    )
    return f"$NODEID+{total}"
