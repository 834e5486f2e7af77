"""V.G.: time stamps and versions of programs (programming manual 21351–21358, 21546–21624)."""

from __future__ import annotations

import re
from datetime import datetime

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.isg.variables_channel import index_between
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import as_number, as_string
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

_VERSION = "isg.var.g-program-version"
_PART = 255  # greatest part of a version, UNS08


# ---------------------------------------------------------------------------------------------------- time stamps


@variable("V.G.TIME_STAMP", "isg.var.g-timestamp", "DD.MM.YYYY hh:mm:ss:ttt", kind=ValueKind.STRING)
def time_stamp(x: Execution) -> str:
    return stamp(x.outside.now())


def stamp(now: datetime) -> str:
    """DD.MM.YYYY hh:mm:ss:ttt"""
    return f"{now:%d.%m.%Y %H:%M:%S}:{now.microsecond // 1000:03d}"


@variable("V.G.TIME_STAMP_FILE_NAME", "isg.var.g-timestamp", "YYYYMMDDThhmmssttt", kind=ValueKind.STRING)
def file_stamp(x: Execution) -> str:
    now = x.outside.now()
    return f"{now:%Y%m%dT%H%M%S}{now.microsecond // 1000:03d}"


# ---------------------------------------------------------------------------------------------------- program version


def _version(x: Execution) -> list[int]:
    """The version of the level in work: its own one, else that of its caller."""
    return next((frame.version for frame in reversed(x.frames) if frame.version is not None), [0, 0, 0, 0])


@variable(
    "V.G.PROG_VERSION.COMPLETE", _VERSION, "version of the program: major.minor.build.patch", kind=ValueKind.STRING
)
def complete_version(x: Execution) -> str:
    return ".".join(str(part) for part in _version(x))


@writes("V.G.PROG_VERSION.COMPLETE")
def set_complete_version(x: Execution, value: object) -> None:
    text = as_string(value, "V.G.PROG_VERSION.COMPLETE")
    match = re.fullmatch(r"(\d{1,3})\.(\d{1,3})\.(\d{1,3})\.(\d{1,3})", text)
    parts = [int(part) for part in match.groups()] if match else []
    if not parts or max(parts) > _PART:
        raise CalculationError(catalogue.VERSION_FORM, "V.G.PROG_VERSION", text=text)
    x.frame.version = parts


def _version_part(name: str, place: int) -> None:
    path = f"V.G.PROG_VERSION.{name}"

    @variable(path, _VERSION, "part of the version of the program, 0…255")
    def read(x: Execution) -> float:
        return float(_version(x)[place])

    @writes(path)
    def write(x: Execution, value: float) -> None:
        parts = list(_version(x))
        parts[place] = index_between(as_number(value, path), 0, _PART, path)
        x.frame.version = parts


for _place, _part in enumerate(("MAJOR", "MINOR", "BUILD", "PATCH")):
    _version_part(_part, _place)
