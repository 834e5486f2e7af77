"""V.G.: names and levels of programs, cycles, time stamps, program versions (programming manual 21316–21358, 21546–21624)."""

from __future__ import annotations

import re
from datetime import datetime

from runtime.cnc.decoder.execution import Execution
from runtime.cnc.decoder.frames import Frame, Level
from runtime.cnc.decoder.isg.registry import variable, writes
from runtime.cnc.decoder.isg.variables_channel import index_between
from runtime.cnc.language.errors import CalculationError
from runtime.cnc.language.isg.functions import as_number, as_string
from runtime.cnc.language.isg.words import ValueKind
from runtime.diagnostics.catalogue import language as catalogue

_INFO = "isg.var.g-program-info"
_VERSION = "isg.var.g-program-version"
_TRANSFERS = 200
_PART = 255  # greatest part of a version, UNS08


# ---------------------------------------------------------------------------------------------------- names and levels


def _main(x: Execution) -> Frame:
    """The level of the main program; the configured final program has none below it."""
    return next((frame for frame in x.frames if frame.level is Level.MAIN), x.frames[0])


def _name(frame: Frame) -> str:
    """Name behind %, that of the file where a program has none."""
    return frame.section.name or frame.unit.name


def _number(name: str, variable_name: str) -> float:
    if not re.fullmatch(r"\d{1,9}", name):
        raise CalculationError(catalogue.PROGRAM_NAME_NO_NUMBER, variable_name)
    return float(name)


@variable("V.G.MAIN_FILE_NAME", _INFO, "file of the main program", kind=ValueKind.STRING)
def main_file(x: Execution) -> str:
    return _main(x).unit.text.path.name


@variable("V.G.MAIN_PROG_NAME", _INFO, "name (%) of the main program", kind=ValueKind.STRING)
def main_program(x: Execution) -> str:
    return _name(_main(x))


@variable("V.G.MAIN_PROG_NR", _INFO, "name of the main program as a number")
def main_number(x: Execution) -> float:
    return _number(_name(_main(x)), "V.G.MAIN_PROG_NR")


@variable("V.G.FILE_NAME", _INFO, "file of the program in work", kind=ValueKind.STRING)
def file(x: Execution) -> str:
    return x.unit.text.path.name


@variable("V.G.PROG_NAME", _INFO, "name (%) of the program in work", kind=ValueKind.STRING)
def program(x: Execution) -> str:
    return _name(x.frame)


@variable("V.G.PROG_NR", _INFO, "name of the program in work as a number")
def number(x: Execution) -> float:
    return _number(_name(x.frame), "V.G.PROG_NR")


@variable("V.G.PROG_LEVEL", _INFO, "1 in the main program, 2 and more in subprograms")
def level(x: Execution) -> float:
    return float(len(x.frames))


@variable("V.G.FILE_OFFSET", _INFO, "place in its file of the block that asks", unit="bytes")
def file_offset(x: Execution) -> float:
    """Of the start of the line. Where the block belongs to a run of plain blocks nothing can ask."""
    return float(x.unit.offset(x.frame.index - 1))


@variable("V.G.CYCLE_ACTIVE", "isg.var.g-cycle-parameters", "1 in a program that was called as a cycle")
def in_cycle(x: Execution) -> float:
    return float(x.frame.transfer is not None)


@variable("V.G.@P[].VALID", "isg.var.g-cycle-parameters", "1 if the call of the cycle gave this @P (1…200)")
def transfer_given(x: Execution, place: float) -> float:
    frame = next((frame for frame in reversed(x.frames) if frame.transfer is not None), None)
    if frame is None:
        raise CalculationError(catalogue.TRANSFER_OUTSIDE, "V.G.@P")
    return float(index_between(place, 1, _TRANSFERS, "V.G.@P") in frame.given)


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
    """The version of the level in work: its own one, else that of its caller. Levels are known by their frames."""
    own: dict[int, tuple[Frame, list[int]]] = x.state.setdefault("program versions", {})
    for frame in reversed(x.frames):
        known = own.get(id(frame))
        if known is not None and known[0] is frame:
            return known[1]
    return [0, 0, 0, 0]


def _set_version(x: Execution, parts: list[int]) -> None:
    own: dict[int, tuple[Frame, list[int]]] = x.state.setdefault("program versions", {})
    alive = {id(frame) for frame in x.frames}
    for key in [key for key in own if key not in alive]:
        del own[key]
    own[id(x.frame)] = (x.frame, parts)


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
    _set_version(x, parts)


def _version_part(name: str, place: int) -> None:
    path = f"V.G.PROG_VERSION.{name}"

    @variable(path, _VERSION, "part of the version of the program, 0…255")
    def read(x: Execution) -> float:
        return float(_version(x)[place])

    @writes(path)
    def write(x: Execution, value: float) -> None:
        parts = list(_version(x))
        parts[place] = index_between(as_number(value, path), 0, _PART, path)
        _set_version(x, parts)


for _place, _part in enumerate(("MAJOR", "MINOR", "BUILD", "PATCH")):
    _version_part(_part, _place)
