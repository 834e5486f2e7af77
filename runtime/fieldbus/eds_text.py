"""EDS and DCF files as vendors write them, brought into the form of CiA 306 that the parser expects.

Seen in the field, and mended here without a word because only one meaning is possible: text in Windows' code page, byte order
marks, `[1a00SUB1]` or `[ 1A00sub1 ]`, keys in any case (`datatype`), `TRUE` for 1, spaces around `=`, a section or key that
stands twice (the first one counts, as in the vendors' own tools), `$NODEID` alone, lines that are neither section nor key.
"""

from __future__ import annotations

import re
from typing import Final

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
    """The text of a file: UTF-8 if it can be, else the code page that Windows tools write."""
    try:
        return data.decode("utf-8-sig")
    except UnicodeDecodeError:
        return data.decode("cp1252", errors="replace")


def normalise(text: str) -> str:
    """The same content in the one form that every parser reads."""
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
        current.setdefault(_KEYS.get(key.lower(), key), _value(key, value))
    lines: list[str] = []
    for name, entries in sections.items():
        lines += [f"[{name}]", *(f"{key}={value}" for key, value in entries.items()), ""]
    return "\n".join(lines)


def _section_name(name: str) -> str:
    if match := _OBJECT.match(name):
        index, subindex, kind = match.groups()
        return index.upper() + (f"sub{int(subindex, 16):X}" if subindex else "") + (kind or "").capitalize()
    return _NAMES.get(name.lower(), name)


def _value(key: str, value: str) -> str:
    value = value.partition(";")[0].strip() if key.lower() != "parametername" else value
    if key.lower() == "pdomapping":
        return _TRUTH.get(value.lower(), value or "0")
    return f"{value}+0" if value.upper() == "$NODEID" else value
