"""The objects of a node as a person writes them: by name or index, in the types of its EDS."""

from __future__ import annotations

import struct
from collections.abc import Iterator

import canopen
from canopen.objectdictionary import ObjectDictionaryError, ODVariable, datatypes
from canopen.sdo.exceptions import SdoAbortedError, SdoCommunicationError

from runtime.diagnostics.catalogue import commissioning as errors
from runtime.diagnostics.catalogue import fieldbus as catalogue
from runtime.fieldbus.error_codes import abort_text
from runtime.fieldbus.errors import FieldbusError
from runtime.fieldbus.network import PumpedSdoClient
from runtime.fieldbus.pdo import VALUE_RANGES, find_variable, object_name

Value = int | float | str | bytes
_NAMED_MAX = 8  # names that a refusal lists


def variables(od: canopen.ObjectDictionary) -> Iterator[ODVariable]:
    """Every object and sub-object that has a value, in the order of the file."""
    for entry in od.values():
        if isinstance(entry, ODVariable):
            yield entry
        else:
            for subindex in entry:
                yield entry[subindex]


def title(variable: ODVariable) -> str:
    """Name of an object, with that of its record in front."""
    parent = variable.parent
    if isinstance(parent, canopen.ObjectDictionary) or parent is None:
        return str(variable.name)
    return f"{parent.name}.{variable.name}"


def find_object(od: canopen.ObjectDictionary, text: str) -> ODVariable:
    """The object `0x6064`, `0x60C2:1`, or one whose name is, or alone begins with, this text in any case.

    Raises FieldbusError (303110) that tells what it could mean.
    """
    index_text, _, subindex_text = text.partition(":")
    try:
        index, subindex = int(index_text, 0), int(subindex_text or "0", 0)
    except ValueError:
        return _by_name(od, text)
    try:
        return find_variable(od, index, subindex)
    except KeyError:
        raise FieldbusError(errors.OBJECT_UNKNOWN, object=text, reason="its EDS has no such object") from None


def _by_name(od: canopen.ObjectDictionary, text: str) -> ODVariable:
    wanted = " ".join(text.lower().replace("_", " ").split())
    begins, contains = [], []
    for variable in variables(od):
        name = title(variable).lower()
        if name == wanted:
            return variable
        if name.startswith(wanted):
            begins.append(variable)
        elif wanted in name:
            contains.append(variable)
    found = begins or contains
    if len(found) == 1:
        return found[0]
    reason = "its EDS has no object of this name"
    if found:
        named = [f"{object_name(v.index, v.subindex)} {title(v)}" for v in found[:_NAMED_MAX]]
        reason = f"this could be {', '.join(named)}" + (" and others" if len(found) > _NAMED_MAX else "")
    raise FieldbusError(errors.OBJECT_UNKNOWN, object=text, reason=reason)


def read_object(client: PumpedSdoClient, node: int, variable: ODVariable) -> Value:
    """The value of an object, in its type; bytes if the EDS does not tell one. Raises FieldbusError."""
    try:
        data: bytes = client.upload(variable.index, variable.subindex)
    except SdoAbortedError as error:
        raise _refused(node, variable, "read", error) from error
    except SdoCommunicationError as error:
        raise _silent(node, variable, "read", error) from error
    return value_of(variable, data)


def value_of(variable: ODVariable, data: bytes) -> Value:
    """What the bytes of an object mean; the bytes themselves if they do not fit its type."""
    if variable.data_type == datatypes.VISIBLE_STRING:
        return data.decode("latin-1").rstrip("\0 ")
    try:
        value = variable.decode_raw(data)
    except (struct.error, ValueError, ObjectDictionaryError):
        return data
    if isinstance(value, bytearray):
        return bytes(value)
    return int(value) if isinstance(value, bool) else value


def parse(variable: ODVariable, text: str) -> bytes:
    """The bytes of an object from what a person wrote. Raises FieldbusError for a value that it cannot take."""
    kind = variable.data_type or 0

    def refuse(reason: str) -> FieldbusError:
        return FieldbusError(
            errors.OBJECT_VALUE, object=object_name(variable.index, variable.subindex), value=text, reason=reason
        )

    if not variable.writable:
        raise refuse("it can only be read")
    if kind in datatypes.FLOAT_TYPES:
        try:
            return bytes(variable.encode_raw(float(text)))
        except (ValueError, OverflowError, struct.error, ObjectDictionaryError):
            raise refuse("this is no number of its type") from None
    if kind == datatypes.VISIBLE_STRING:
        if not text.isascii():
            raise refuse("only ASCII characters can be written")
        return text.encode("ascii")
    if kind in (datatypes.OCTET_STRING, datatypes.DOMAIN):
        try:
            return bytes.fromhex(text)
        except ValueError:
            raise refuse("hexadecimal bytes are expected") from None
    low, high = (0, 1) if kind == datatypes.BOOLEAN else VALUE_RANGES.get(kind, (0, -1))
    if low > high:
        raise refuse(f"values of data type 0x{kind:04X} cannot be written")
    low = max(low, low if variable.min is None else int(variable.min))
    high = min(high, high if variable.max is None else int(variable.max))
    try:
        number = int(text, 0)
    except ValueError:
        raise refuse("a whole number is expected") from None
    if not low <= number <= high:
        raise refuse(f"its values go from {low} to {high}")
    return bytes(variable.encode_raw(bool(number) if kind == datatypes.BOOLEAN else number))


def write_object(client: PumpedSdoClient, node: int, variable: ODVariable, text: str) -> None:
    """Write what a person wrote. Raises FieldbusError."""
    data = parse(variable, text)
    try:
        client.download(variable.index, variable.subindex, data)
    except SdoAbortedError as error:
        raise _refused(node, variable, "write", error) from error
    except SdoCommunicationError as error:
        raise _silent(node, variable, "write", error) from error


def _refused(node: int, variable: ODVariable, verb: str, error: SdoAbortedError) -> FieldbusError:
    name, owner = object_name(variable.index, variable.subindex), variable.name
    meaning = abort_text(error.code)
    return FieldbusError(
        catalogue.SDO_ABORTED, node=node, owner=owner, access=verb, object=name, meaning=meaning, code=error.code
    )


def _silent(node: int, variable: ODVariable, verb: str, error: SdoCommunicationError) -> FieldbusError:
    name, owner = object_name(variable.index, variable.subindex), variable.name
    return FieldbusError(catalogue.SDO_NO_ANSWER, node=node, owner=owner, access=verb, object=name, reason=str(error))
